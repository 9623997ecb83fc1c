//! The report's part about trucks that make several trips: their years, what the fleet's year adds
//! up to, where the spread is, and the seasons.

use super::svg::{Scale, begin, label as words, levels, rounded_short};
use super::tables::{cells, statistics, table};
use crate::fleet_total::{FleetTotal, fleet_totals};
use crate::label::label;
use crate::number_text::{grouped, rounded};
use ocmc_fleet::statistic::Statistic;
use ocmc_fleet::summary::Summary;
use ocmc_fleet::truck_year::{TruckSummary, TruckTime};
use std::fmt::Write;

/// Most trucks that the picture shows; of more the picture has so many, evenly by rank.
const MOST_SHOWN: usize = 200;

const MONTHS: [&str; 12] =
    ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];

/// Nothing where each trip has a truck of its own.
pub(super) fn trucks(summary: &Summary) -> String {
    let (Some(trucks), Some(own)) = (&summary.trucks, summary.consumption()) else {
        return String::new();
    };
    let (unit, factor) = label(own.column);
    let mut text = format!("<h2>Trucks: {}</h2>\n", grouped(trucks.trucks));
    text.push_str(&year(trucks));
    if let Some(components) = &trucks.components {
        let _ = writeln!(
            text,
            "<p>Trucks are {:.0} % of the variance of trips, and {:.0} % of that of a truck's \
             mean. The standard deviation is {} {unit} between trucks and {} between trips of a \
             truck.</p>",
            100.0 * components.share_of_trips,
            100.0 * components.share_of_means,
            rounded(factor * components.between_sd),
            rounded(factor * components.within_sd),
        );
    }
    text.push_str(&shares(trucks, own));
    text.push_str(&caterpillar(trucks, unit, factor));
    let caption = "Each truck's year, total over total, counted once.";
    text.push_str(&statistics(&trucks.truck_years, caption, trucks.note));
    text.push_str(&seasons(trucks, unit, factor));
    text
}

/// Shares of trucks in the variance of trips, and of truck-months and truck-years of as many trips
/// as they have in the mean.
fn shares(trucks: &TruckSummary, own: &Statistic) -> String {
    let Some(components) = trucks.components else { return String::new() };
    let between = components.between_sd * components.between_sd;
    let trips_and_share = |times: &[Statistic]| {
        let times = times.iter().find(|statistic| statistic.column == own.column)?;
        let trips = own.n as f64 / times.n as f64;
        let share = between / (between + components.within_variance / trips);
        share.is_finite().then_some((trips, share))
    };
    let rows = [
        ("trip", Some((1.0, components.share_of_trips))),
        ("month", trips_and_share(&trucks.truck_months)),
        ("year", trips_and_share(&trucks.truck_years)),
    ];
    let (width, left, right, line) = (720.0, 110.0, 640.0, 34.0);
    let x = Scale { from: [0.0, 1.0], to: [left, right] };
    let mut text = begin(width, 3.0 * line + 8.0, "Share of the variance that is between trucks");
    for (k, (name, known)) in rows.into_iter().enumerate() {
        let Some((trips, share)) = known else { continue };
        let top = line * k as f64 + 6.0;
        let end = x.at(share);
        let _ = writeln!(
            text,
            "<rect class=\"band\" x=\"{end:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"22\"/>\
             <rect class=\"bar\" x=\"{left}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"22\">\
             <title>{name}, {} trips</title></rect>",
            right - end,
            end - left,
            rounded_short(trips),
        );
        words(&mut text, [left - 8.0, top + 16.0], "end", "", name);
        let percent = format!("{:.0} %", 100.0 * share);
        words(&mut text, [right + 8.0, top + 16.0], "start", "", &percent);
    }
    text.push_str("</svg>\n");
    format!(
        "<figure>{text}<figcaption>Share of the variance that is between trucks and their \
         drivers, of a trip, of the mean of a truck's month and of its year; the rest is the \
         chance of its trips. <code>ocmc sensitivity --over truck --shapley</code> shares it out \
         over the factors.</figcaption></figure>\n"
    )
}

/// Truck-years from the lowest to the highest, each with the interval that its trips leave.
fn caterpillar(trucks: &TruckSummary, unit: &str, factor: f64) -> String {
    let all = trucks.rows.iter().filter_map(TruckTime::consumption);
    let scaled = all.map(|(value, [low, high])| [value, low, high].map(|x| factor * x));
    let mut all: Vec<[f64; 3]> = scaled.collect();
    if all.len() < 2 {
        return String::new();
    }
    all.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let count = all.len().min(MOST_SHOWN);
    let place = |k: usize| k * (all.len() - 1) / (count - 1);
    let shown: Vec<[f64; 3]> = (0..count).map(|k| all[place(k)]).collect();
    let (width, height, left, foot) = (720.0, 284.0, 72.0, 34.0);
    let low = shown.iter().map(|row| row[1]).fold(f64::INFINITY, f64::min);
    let high = shown.iter().map(|row| row[2]).fold(f64::NEG_INFINITY, f64::max);
    let x = Scale { from: [0.0, (count - 1) as f64], to: [left + 8.0, width - 10.0] };
    let y = Scale { from: [low, high], to: [height - foot, 12.0] };
    let mut text = begin(width, height, &format!("{unit} of each truck, with 95 % intervals"));
    levels(&mut text, y, [left, width]);
    for (k, [value, low, high]) in shown.iter().enumerate() {
        let (x, top, bottom) = (x.at(k as f64), y.at(*high), y.at(*low));
        let _ = writeln!(
            text,
            "<line class=\"mark\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{top:.1}\" y2=\"{bottom:.1}\"/>\
             <circle class=\"bar\" cx=\"{x:.1}\" cy=\"{:.1}\" r=\"2.5\"/>",
            y.at(*value)
        );
    }
    let along = "trucks, from the lowest to the highest";
    words(&mut text, [width / 2.0, height - 6.0], "middle", "", along);
    text.push_str("</svg>\n");
    let chosen = match all.len() - count {
        0 => String::new(),
        _ => format!(" Of {} truck-years {count}, evenly by rank.", grouped(all.len() as u64)),
    };
    format!(
        "<figure>{text}<figcaption>{unit} of each truck's year with the 95 % interval over other \
         trips of the same truck.{chosen}</figcaption></figure>\n"
    )
}

/// Totals of the fleet.
fn year(trucks: &TruckSummary) -> String {
    let rows = fleet_totals(trucks).into_iter().map(|FleetTotal { name, unit, factor, total }| {
        let other = total.prediction95.map_or("–".to_owned(), |[low, high]| {
            format!("{} to {}", rounded(factor * low), rounded(factor * high))
        });
        cells(&[format!("{name}, {unit}"), rounded(factor * total.total), other])
    });
    let priced = trucks.currency.as_ref().map_or(
        "",
        |_| " The cost is that of the centres of the prices; <code>ocmc cost</code> has its items.",
    );
    format!(
        "<p class=\"soft\">What these trips of the fleet add up to, and where that of another \
         fleet of as many trucks lies in 95 of 100 cases.{priced}</p>\n{}",
        table(&["quantity", "total", "another fleet"], rows)
    )
}

/// The fleet's consumption month by month.
fn seasons(trucks: &TruckSummary, unit: &str, factor: f64) -> String {
    let months = MONTHS.iter().zip(trucks.by_month);
    let known: Vec<(&str, f64)> =
        months.filter_map(|(name, value)| Some((*name, factor * value?))).collect();
    if known.len() < 2 {
        return String::new();
    }
    let all =
        |text_of: &dyn Fn(&(&str, f64)) -> String| known.iter().map(text_of).collect::<String>();
    format!(
        "<p class=\"soft\">{unit} by month of departure, total over total.</p>\n<div \
         class=\"wide\" tabindex=\"0\"><table>\n\
         <thead><tr>{}</tr></thead>\n<tbody><tr>{}</tr></tbody></table></div>\n",
        all(&|(name, _)| format!("<th>{name}</th>")),
        all(&|(_, value)| format!("<td>{}</td>", rounded(*value))),
    )
}

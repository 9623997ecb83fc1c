//! The part of a run's answer that is about trucks: what the fleet adds up to, how their years are
//! spread, and what of the spread of trips is between trucks.

use super::text::table_over;
use crate::named_total::{named_totals, totals_text};
use ocmc_fleet::components::Components;
use ocmc_fleet::summary::Summary;
use ocmc_fleet::truck_arrivals::TruckArrivals;
use ocmc_fleet::truck_year::TruckSummary;
use ocmc_io::label::label;
use ocmc_io::number_text::{count_of, grouped, short};
use std::fmt::Write;

/// Totals of the fleet; nothing where each trip has a truck of its own.
pub(super) fn fleet(summary: &Summary) -> String {
    let Some(trucks) = &summary.trucks else { return String::new() };
    let each = count_of(summary.cycles / trucks.trucks.max(1), "trip");
    let mut text = format!(
        "\n{}, {each} each: totals ± where another fleet of as many would lie\n",
        count_of(trucks.trucks, "truck")
    );
    text += &totals_text(&named_totals(summary));
    if trucks.currency.is_some() {
        text += "The cost is that of the centres of the prices; `ocmc cost` has its items.\n";
    }
    text + &arrivals(summary)
}

/// Nothing where each trip has a truck of its own.
pub(super) fn trucks(summary: &Summary) -> String {
    let Some(trucks) = &summary.trucks else { return String::new() };
    let TruckSummary { trucks: count, years, truck_years, components, note, .. } = trucks;
    let over = if *years > 1 { format!(" over {years} years") } else { String::new() };
    let mut text = format!(
        "\n{}{over}: totals over totals of each truck's year\n{}",
        count_of(*count, "truck"),
        table_over(truck_years, ["of trucks", " each truck-year counted once"])
    );
    if let Some(note) = note {
        let _ = writeln!(text, "Intervals: {note}.");
    }
    let own = summary.consumption();
    if let Some(own) = own
        && let Some(components) = components
    {
        text += &spread(trucks, own.column, components);
    }
    text
}

/// Numbers of trucks whose trips arrive.
fn arrivals(summary: &Summary) -> String {
    let mut text = String::new();
    for (k, arrivals) in summary.truck_arrivals.iter().enumerate() {
        let TruckArrivals { share_of_trips, trucks, of: all, ci95 } = *arrivals;
        let trips = match k {
            0 => "\nTrucks of which all trips arrive".to_owned(),
            _ => format!("Trucks of which {} % of the trips arrive", 100.0 * share_of_trips),
        };
        let [low, high] = ci95.map(|end| format!("{:.0}", 100.0 * end));
        let (trucks, all) = (grouped(trucks), grouped(all));
        let _ = writeln!(text, "{trips}: {trucks} of {all} ({low} to {high} % of such trucks)");
    }
    text
}

/// How the consumption of trips is shared out between trucks and their trips.
fn spread(trucks: &TruckSummary, column: &str, components: &Components) -> String {
    let (name, factor) = label(column);
    let sd = |value: f64| short(factor * value);
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    let sd_of = |statistics: &[ocmc_fleet::statistic::Statistic]| {
        let own = statistics.iter().find(|statistic| statistic.column == column);
        own.and_then(|own| own.sd).map_or("-".to_owned(), sd)
    };
    format!(
        "\n{name}: SD {} between trucks, {} between trips of a truck.\n\
         Trucks are {} of the variance of trips, and {} of that of a truck's mean.\n\
         SD of truck-months {}, of truck-years {} ({} in all).\n",
        sd(components.between_sd),
        sd(components.within_sd),
        percent(components.share_of_trips),
        percent(components.share_of_means),
        sd_of(&trucks.truck_months),
        sd_of(&trucks.truck_years),
        grouped(trucks.rows.len() as u64),
    )
}

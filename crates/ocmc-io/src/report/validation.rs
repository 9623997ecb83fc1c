//! The page of a validation: measured drives over simulated ones.

use super::speed_over_distance::{RoadPicture, ranks};
use super::svg::escaped;
use super::tables::{cells, rows, table};
use super::{STYLE, page_head};
use crate::number_text::{grouped, percent, rounded};
use ocmc_core::energy::Carrier;
use ocmc_estimation::validation::ensemble::DriveScore;
use ocmc_estimation::validation::pooled::Pooled;
use std::fmt::Write;

/// Most roads that are drawn.
const MOST_ROADS: usize = 40;
/// Smaller than this is nothing to four decimals.
const NOTHING: f64 = 5e-5;
/// Colours that only these pictures need.
const COLOURS: &str = "svg .inner { fill: color-mix(in srgb, var(--bar) 55%, var(--band)); }\n\
                       svg .limit { fill: none; stroke: var(--soft); stroke-dasharray: 4 3; }\n\
                       svg polyline.mark { fill: none; }\n\
                       .circular { border-left: .3rem solid var(--mark); padding-left: .6rem; }\n";

/// Label of a quantity for people, and the factor to the unit in which they read it.
pub fn quantity_label(quantity: &str, carrier: Carrier) -> (String, f64) {
    match quantity {
        "speed" => ("speed at all places, km/h".to_owned(), 3.6),
        "duration" => ("time, s".to_owned(), 1.0),
        "moving" => ("time moving, s".to_owned(), 1.0),
        "standstill" => ("standstill, s".to_owned(), 1.0),
        "stops" => ("stops".to_owned(), 1.0),
        "speed_at_a_place" => ("speed at one place, km/h".to_owned(), 3.6),
        "energy" => {
            let declared = carrier.declaration();
            let (_, unit, factor) = declared.units;
            (format!("{}, {unit}", declared.name), factor)
        }
        other => (other.to_owned(), 1.0),
    }
}

/// A number for people; what rounds to nothing has no sign.
pub fn score_text(value: f64) -> String {
    rounded(if value.abs() < NOTHING { 0.0 } else { value })
}

/// A validation, as far as its page needs it.
#[derive(Clone, Copy, Debug)]
pub struct ValidationPage<'a> {
    /// Title: what was validated.
    pub title: &'a str,
    /// Facts about it.
    pub facts: &'a [(&'static str, String)],
    /// Parts that come from the validated logs themselves, in words.
    pub circular: Option<&'a str>,
    /// Carrier that the truck stores.
    pub carrier: Carrier,
    /// Scores over all drives.
    pub pooled: &'a [Pooled],
    /// Scores of each drive.
    pub drives: &'a [DriveScore],
    /// The roads.
    pub roads: &'a [RoadPicture],
}

/// The page: HTML that opens offline in any browser.
pub fn validation_html(page: &ValidationPage) -> String {
    let title = escaped(page.title);
    let mut text = page_head(&format!("{title}: a validation"), &format!("{STYLE}{COLOURS}"));
    let _ = writeln!(
        text,
        "<h1>{title}</h1>\n<p class=\"soft\">Measured drives over simulated ones</p>"
    );
    if let Some(circular) = page.circular {
        let _ = writeln!(text, "<p class=\"circular\"><b>circular</b>: {}</p>", escaped(circular));
    }
    let _ = writeln!(text, "<table><tbody>\n{}</tbody></table>", rows(page.facts));
    text.push_str(&scores(page));
    for road in page.roads.iter().take(MOST_ROADS) {
        let name = escaped(&road.name);
        let _ = writeln!(
            text,
            "<h2>{name}</h2>\n<figure tabindex=\"0\">{}<figcaption>Speed over distance: 90 % and \
             half of the simulated trips, their median, the drives, and the limit \
             (dashed).</figcaption></figure>",
            road.svg()
        );
    }
    if let Some(more) = page.roads.len().checked_sub(MOST_ROADS).filter(|more| *more > 0) {
        let _ = writeln!(
            text,
            "<p class=\"soft\">{} more roads are in the table.</p>",
            grouped(more as u64)
        );
    }
    text.push_str("<h2>Ranks of the drives among the trips</h2>\n<div class=\"charts\">\n");
    for pooled in page.pooled {
        let (label, _) = quantity_label(&pooled.quantity, page.carrier);
        let p = pooled
            .uniform
            .map_or(String::new(), |u| format!(": p = {:.3} that they are even", u.p));
        let _ = writeln!(
            text,
            "<figure><h3>{}</h3>{}<figcaption>{} values{p}</figcaption></figure>",
            escaped(&label),
            ranks(&pooled.pit, &label),
            grouped(pooled.n as u64)
        );
    }
    text.push_str("</div>\n");
    text.push_str(&drives(page));
    text.push_str(super::FOOT);
    text
}

/// The scores over all drives.
fn scores(page: &ValidationPage) -> String {
    let head = [
        "quantity",
        "values",
        "mean error",
        "RMSE",
        "CRPS",
        "in half, %",
        "in 90 %, %",
        "even ranks, p",
    ];
    let rows = page.pooled.iter().map(|pooled| {
        let (label, factor) = quantity_label(&pooled.quantity, page.carrier);
        let with = |share: f64, error: Option<f64>| match error {
            Some(error) => format!("{} ± {}", percent(share), percent(error)),
            None => percent(share),
        };
        cells(&[
            escaped(&label),
            grouped(pooled.n as u64),
            score_text(factor * pooled.mean_error),
            score_text(factor * pooled.rmse),
            score_text(factor * pooled.crps),
            with(pooled.coverage50, pooled.coverage50_error),
            with(pooled.coverage90, pooled.coverage90_error),
            pooled.uniform.map_or("–".to_owned(), |u| format!("{:.3}", u.p)),
        ])
    });
    format!(
        "<h2>Scores</h2>\n<p class=\"soft\">Error: simulated mean less measured. CRPS: continuous \
         ranked probability score, in the same unit. Half and 90 %: how many of the measured \
         values lie in these bands of the trips.</p>\n{}",
        table(&head, rows)
    )
}

/// The scores of each drive.
fn drives(page: &ValidationPage) -> String {
    let head = [
        "drive",
        "from, km",
        "to, km",
        "quantity",
        "measured",
        "simulated",
        "90 % of the trips",
        "CRPS",
        "rank",
    ];
    let rows = page.drives.iter().flat_map(|drive| {
        drive.values.iter().enumerate().map(|(k, (quantity, score))| {
            let (label, factor) = quantity_label(quantity.name(), page.carrier);
            let [from, to] = [drive.from_m, drive.to_m].map(|at_m| rounded(at_m / 1000.0));
            let [name, from, to] =
                if k == 0 { [escaped(&drive.drive), from, to] } else { Default::default() };
            let [low, high] = score.band90.map(|value| score_text(factor * value));
            format!(
                "<tr><td>{name}</td><td>{from}</td><td>{to}</td><td \
                 class=\"words\">{}</td><td>{}</td><td>{}</td><td>{low} to {high}</td>\
                 <td>{}</td><td>{:.3}</td></tr>\n",
                escaped(&label),
                score_text(factor * score.measured),
                score_text(factor * score.simulated),
                score_text(factor * score.crps),
                score.pit
            )
        })
    });
    format!("<h2>Drives</h2>\n{}", table(&head, rows))
}

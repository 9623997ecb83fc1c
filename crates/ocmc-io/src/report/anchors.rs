//! The report's last table: a fleet of tractor-semitrailers beside what is published.

use super::Reported;
use super::svg::escaped;
use super::tables::{self, cells};
use crate::anchor::ANCHORS;
use crate::label::label;
use crate::number_text::rounded;
use ocmc_core::energy::carrier::CARRIERS;
use std::iter::once;

/// Legal gross mass, in kg, from which a truck is beside tractor-semitrailers.
const LEAST_GROSS_KG: f64 = 36_000.0;

/// The table; nothing where the fleet is of other vehicles, or takes what has no figure.
pub(super) fn anchors(run: &Reported) -> String {
    let summary = &run.summary.summary;
    let text = |key: &str| run.manifest.value(key).and_then(|v| Some(v.as_str()?.to_owned()));
    let number = |key: &str| run.manifest.value(key).and_then(|value| value.as_float());
    let is_heavy = number("vehicle.gross_mass_limit_kg").is_some_and(|kg| kg >= LEAST_GROSS_KG);
    let is_truck = text("vehicle.class").is_none_or(|class| class == "truck");
    let own = summary.consumption().filter(|_| is_heavy && is_truck);
    let Some((statistic, mean)) = own.and_then(|statistic| Some((statistic, statistic.mean?)))
    else {
        return String::new();
    };
    let carrier = CARRIERS.iter().find(|c| c.consumption.name == statistic.column);
    let beside: Vec<_> =
        ANCHORS.iter().filter(|a| Some(a.carrier) == carrier.map(|c| c.carrier)).collect();
    if beside.is_empty() {
        return String::new();
    }
    let (unit, _) = label(statistic.column);
    let per_tonne = carrier.and_then(|c| summary.statistic(c.per_tonne.name)?.mean);
    let load = per_tonne
        .filter(|one| *one > 0.0)
        .map_or_else(String::new, |one| format!("{} t in the mean", rounded(mean / one)));
    let speed = summary.statistic("mean_speed_mps").and_then(|speed| speed.mean);
    let road = speed.map_or_else(String::new, |mps| format!("{} km/h", rounded(3.6 * mps)));
    let figure = format!("{} {unit}", rounded(mean));
    let row = |texts: [&str; 5]| cells(&texts.map(escaped));
    let rows = once(row([&run.manifest.study, &load, &road, &figure, "this run"]))
        .chain(beside.iter().map(|anchor| row(anchor.cells())));
    let heads = ["fleet", "load", "road, speed", "figure", "standing"].map(str::to_owned);
    format!(
        "<h2>Beside published figures</h2>\n<p class=\"soft\">Published consumption of \
         tractor-semitrailers, the first row this fleet's. Roads, loads and years differ: a figure \
         says little unless they are alike. F: the source was opened; F2: stated by another \
         author; D: derived.</p>\n{}",
        tables::table(&heads, rows)
    )
}

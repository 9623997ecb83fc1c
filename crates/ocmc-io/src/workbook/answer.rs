//! The answer of a run as sheets: each quantity of the fleet with its interval and its spread, what
//! the run is, and the same by route.

use super::package::Package;
use super::sheet::{Cell, Sheet};
use super::{ANSWER, ROUTES};
use crate::label::{measured, remarks, saturation};
use crate::run_directory::{JudgedMean, Manifest, RunSummary};
use crate::study::NumbersShare;
use ocmc_core::record::Outcome;
use ocmc_fleet::quantile::LEVELS;
use ocmc_fleet::route_summary::RouteSummary;
use ocmc_fleet::statistic::Statistic;
use std::io::{self, Seek, Write};

/// Columns of a quantity.
const HEAD: [&str; 6] = [
    "quantity",
    "unit",
    "mean of the fleet",
    "95 % interval, low",
    "95 % interval, high",
    "SD over cycles",
];
/// Columns of a mean that is adjusted for what was drawn.
const ADJUSTED: [&str; 3] = ["adjusted mean", "adjusted, low", "adjusted, high"];
/// Widths of the first columns.
const WIDTHS: [usize; 2] = [34, 16];

/// Remarks on the table.
const OVER: &str = "Mean: of the fleet, total over total, with its 95 % interval. SD and quantiles \
    count each cycle once. Intervals are those of sampling from the study: they hold neither the \
    error of the models nor that of judged numbers.";

/// Names of the columns of a quantity.
fn names() -> impl Iterator<Item = String> {
    let quantiles = LEVELS.iter().map(|(_, name)| name.to_uppercase());
    let head = HEAD.iter().map(|name| (*name).to_owned());
    head.chain(quantiles).chain(["cycles".to_owned(), "name in files".to_owned()])
}

/// The cells of a quantity, in the unit in which people read it.
fn cells(statistic: &Statistic) -> Vec<Cell<'_>> {
    let (words, unit, factor) = measured(statistic.column);
    let value = |value: Option<f64>| Cell::from(value.map(|value| factor * value));
    let [low, high] = sides(statistic.ci95);
    let mut cells = vec![words.into(), unit.into()];
    cells.extend([statistic.mean, low, high, statistic.sd].map(value));
    cells.extend(statistic.quantiles.iter().map(|quantile| value(quantile.value)));
    cells.extend([statistic.n.into(), statistic.column.into()]);
    cells
}

/// Cells of the adjusted mean of a quantity.
fn adjusted(statistic: &Statistic) -> Vec<Cell<'_>> {
    let (_, _, factor) = measured(statistic.column);
    let Some(adjusted) = &statistic.adjusted else { return Vec::new() };
    let [low, high] = adjusted.ci95;
    [adjusted.mean, low, high].map(|value| (factor * value).into()).into()
}

fn sides(interval: Option<[f64; 2]>) -> [Option<f64>; 2] {
    interval.map_or([None; 2], |sides| sides.map(Some))
}

/// Writes the answer: the quantities, and below them what the run is.
pub(super) fn add<W: Write + Seek>(
    package: Package<W>,
    manifest: &Manifest,
    run: &RunSummary,
) -> io::Result<Package<W>> {
    let summary = &run.summary;
    let is_adjusted = summary.told().any(|statistic| statistic.adjusted.is_some());
    let mut head: Vec<String> = names().collect();
    head.extend(ADJUSTED.iter().filter(|_| is_adjusted).map(|name| (*name).to_owned()));
    let head = head.iter().map(String::as_str);
    let mut sheet = package.sheet(ANSWER, head, &WIDTHS, 0)?;
    for statistic in summary.told().filter(|statistic| statistic.n > 0) {
        sheet.row(cells(statistic).into_iter().chain(adjusted(statistic)))?;
    }
    add_facts(&mut sheet, manifest, run)?;
    sheet.end()
}

/// Writes what the run is, a fact a row: its name, its unit, what it is.
fn add_facts<W: Write>(
    sheet: &mut Sheet<W>,
    manifest: &Manifest,
    run: &RunSummary,
) -> io::Result<()> {
    let summary = &run.summary;
    sheet.row([])?;
    let mut fact = |name: &str, unit: &str, value: Cell| {
        let unit = if unit.is_empty() { Cell::Empty } else { unit.into() };
        sheet.row([name.into(), unit, value])
    };
    fact("study", "", run.study.as_str().into())?;
    fact("hash of the study", "", run.study_hash.as_str().into())?;
    fact("program", "", format!("ocmc {}", manifest.program_version).into())?;
    fact("seed", "", run.seed.into())?;
    fact("first cycle", "", run.first_cycle.into())?;
    fact("status", "", manifest.status.name().into())?;
    fact("cycles asked for", "", manifest.cycles.into())?;
    fact("cycles", "", summary.cycles.into())?;
    for outcome in Outcome::ALL {
        let name = format!("cycles that are {}", outcome.name().replace('_', " "));
        fact(&name, "", summary.outcomes.of(outcome).into())?;
    }
    fact("distance of all cycles", "km", (summary.distance_m / 1000.0).into())?;
    fact("time driven in all cycles", "h", (summary.simulated_s / 3600.0).into())?;
    if let (Some(judged), Some(own)) = (&run.judged, summary.consumption()) {
        let (_, unit, factor) = measured(own.column);
        let half = judged.plus_minus.map(|half| factor * half);
        fact("judged numbers: the mean of the consumption ±", unit, half.into())?;
        fact("judged numbers, the largest", "", of_judged(judged).into())?;
    }
    if let Some(uncertainty) = &summary.parameter_uncertainty {
        let (_, unit, factor) = measured(&uncertainty.column);
        for (name, value) in ["low", "high"].into_iter().zip(uncertainty.ci95) {
            let name = format!("95 % interval with the errors of uncertain numbers, {name}");
            fact(&name, unit, (factor * value).into())?;
        }
    }
    if let Some(worst) = summary.worst_case {
        let (words, unit, factor) = measured(worst.column);
        let name = format!("worst case of failed cycles: {words}");
        fact(&name, unit, (factor * worst.mean).into())?;
    }
    let saturated = saturation(summary).map(|text| text.replace('\n', " "));
    let notes = remarks(summary).into_iter().chain(saturated);
    let note = run.note.map(|note| format!("Intervals: {note}."));
    for note in [OVER.to_owned()].into_iter().chain(notes).chain(note) {
        fact("note", "", note.into())?;
    }
    Ok(())
}

/// Judged numbers with the largest effects.
fn of_judged(judged: &JudgedMean) -> String {
    match &judged.doubt.stored {
        Some(stored) => {
            let shares: Vec<String> = stored.largest.iter().map(NumbersShare::words).collect();
            let about = if stored.is_same { "" } else { "about: " };
            format!("{about}{}", shares.join(", "))
        }
        None if judged.doubt.entries == 0 => "the study does not say which they are".to_owned(),
        None => "not known without driving: ocmc doubt finds it".to_owned(),
    }
}

/// Writes the quantities of each route.
pub(super) fn add_routes<W: Write + Seek>(
    package: Package<W>,
    routes: &[RouteSummary],
) -> io::Result<Package<W>> {
    let own = ["route_id", "route", "file", "distance, km"].map(str::to_owned);
    let head: Vec<String> = own.into_iter().chain(names()).collect();
    let head = head.iter().map(String::as_str);
    let widths = [0, 24, 30, 0, WIDTHS[0], WIDTHS[1]];
    let mut sheet = package.sheet(ROUTES, head, &widths, 0)?;
    for route in routes {
        for statistic in route.statistics.iter().filter(|statistic| statistic.n > 0) {
            let file = route.file.as_deref().map_or(Cell::Empty, Cell::from);
            let (id, km) = (u64::from(route.route_id), route.distance_m / 1000.0);
            let own = [id.into(), route.name().into(), file, km.into()];
            sheet.row(own.into_iter().chain(cells(statistic)))?;
        }
    }
    sheet.end()
}

//! The report of a run: one HTML file that opens offline, on a phone, in print, light and dark,
//! without scripts.

mod energy;
mod gathered;
mod panel;
mod parts;
mod simulator_pictures;
mod simulator_study;
mod speed_over_distance;
mod svg;
mod tables;
mod trucks;
mod validation;

use crate::label::{label, remarks};
use crate::number_text::{grouped, rounded};
use crate::run_directory::{Manifest, RunDirectoryError, RunSummary, StoredRun, read_groups};
use crate::study;
pub use gathered::Gathered;
use ocmc_core::fleet::association::{Association, association, association_beside};
use ocmc_core::fleet::quantity::{RecordQuantity, quantity};
use ocmc_core::fleet::statistic::Statistic;
use ocmc_core::record::{Cell, Record, column};
pub use simulator_pictures::{Picture, pictures};
pub use simulator_study::{
    ComparedNumber, DriveSeries, SimulatorChange, SimulatorCurve, SimulatorDrive, SimulatorEvent,
    SimulatorPage, SimulatorRepetition, simulator_html,
};
pub use speed_over_distance::RoadPicture;
use std::fmt::Write;
use std::path::Path;
use svg::escaped;
pub use validation::{ValidationPage, quantity_label, score_text, validation_html};

/// Name of the report in a run directory.
pub const REPORT: &str = "report.html";

const STYLE: &str = include_str!("style.css");

/// Columns that may explain the consumption, what they are called for people, the factors to the
/// units in which people read them, and what a distance divides.
///
/// The rolling coefficient is not among them: a tyre's coefficient falls with its load, so that the
/// column goes with the payload and would show the payload's effect once more. The factor that is
/// sampled is not in the records; `ocmc sensitivity` has its share.
const EXPLAINING: [(&str, &str, f64, bool); 17] = [
    ("payload_kg", "payload, t", 1e-3, false),
    ("climb_m", "climb, m", 1.0, true),
    ("mean_limit_mps", "mean of the signs, km/h", 3.6, false),
    ("mean_speed_mps", "speed, km/h", 3.6, false),
    ("urban_share", "urban share, %", 100.0, false),
    ("motorway_share", "motorway share, %", 100.0, false),
    ("n_curves", "curves", 1.0, true),
    ("n_stops", "stops", 1.0, true),
    ("n_gear_shifts", "gear shifts", 1.0, true),
    ("air_temperature_k", "air temperature, K", 1.0, false),
    ("head_wind_mps", "head wind, m/s", 1.0, false),
    ("drag_area_m2", "drag area, m²", 1.0, false),
    ("driver_curve_speed_mps", "driver: curve speed, km/h", 3.6, false),
    ("driver_deceleration_mps2", "driver: deceleration, m/s²", 1.0, false),
    ("driver_acceleration_mps2", "driver: acceleration, m/s²", 1.0, false),
    ("driver_compliance", "driver: factor on limits", 1.0, false),
    ("driver_kp", "driver: pedal gain, s/m", 1.0, false),
];

/// Place of the payload among them, beside which the others are seen.
const PAYLOAD: usize = 0;

/// Pictures of what goes with the consumption.
const SHOWN: usize = 9;

/// A run, as far as a report needs it.
#[derive(Clone, Debug)]
pub struct Reported {
    /// What the run is.
    pub manifest: Manifest,
    /// What its cycles add up to.
    pub summary: RunSummary,
    /// What else its records say.
    pub gathered: Gathered,
}

impl Reported {
    /// Reads the run of a directory, whose records are not held.
    ///
    /// # Errors
    /// Where there is no run that was ended, or not what was written.
    pub fn read(directory: &Path) -> Result<Self, RunDirectoryError> {
        let mut gathered = Gathered::default();
        let (manifest, summary) = read_groups(directory, |group| gathered.add(&group.records))?;
        Ok(Self { manifest, summary, gathered })
    }
}

impl From<StoredRun> for Reported {
    fn from(run: StoredRun) -> Self {
        let StoredRun { manifest, records, summary } = run;
        let mut gathered = Gathered::default();
        gathered.add(&records);
        Self { manifest, summary, gathered }
    }
}

/// The whole report.
pub fn html(run: &Reported) -> String {
    let summary = &run.summary.summary;
    let mut page = head(run);
    page.push_str(&tables::key_numbers(run));
    if let Some(statistic) = summary.consumption() {
        page.push_str(&distribution(statistic));
        let told: Vec<Statistic> = summary.told().cloned().collect();
        let remarks = remarks(summary);
        let caption = [&[tables::OVER_CYCLES.to_owned()], remarks.as_slice()].concat().join(" ");
        page.push_str(&tables::statistics(&told, &caption, run.summary.note));
        page.push_str(&parts::parts(&summary.parts));
        page.push_str(&trucks::trucks(summary));
        page.push_str(&energy::breakdown(&run.gathered.sums));
        if let Some(quantity) = quantity(statistic.column) {
            page.push_str(&explained(&run.gathered, quantity, statistic));
            page.push_str(&tables::road_shares(&run.gathered.sums));
            page.push_str(&tables::outliers(run, quantity));
        }
    }
    page.push_str(&tables::failures(run));
    page.push_str(&tables::study(run));
    page.push_str(&tables::provenance(run));
    page.push_str("</body>\n</html>\n");
    page
}

fn head(run: &Reported) -> String {
    let name = escaped(&run.manifest.study);
    let description = run.manifest.value("study.description");
    let description = description.as_ref().and_then(|text| text.as_str()).unwrap_or_default();
    let top = page_head(&format!("{name}: a run of ocmc"), STYLE);
    format!("{top}<h1>{name}</h1>\n<p class=\"soft\">{}</p>\n", escaped(description))
}

/// The head of a page, up to its body.
fn page_head(title: &str, style: &str) -> String {
    // nothing may be fetched, whatever a study's name holds
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<title>{title}</title>\n<style>\n{style}</style>\n</head>\n<body>\n"
    )
}

fn distribution(statistic: &Statistic) -> String {
    let (unit, factor) = label(statistic.column);
    let mut text = format!("<h2>Distribution over the cycles: {}</h2>\n", escaped(unit));
    if let Some(histogram) = statistic.histogram.as_ref().filter(|_| factor == 1.0) {
        let _ = writeln!(
            text,
            "<figure>{}<figcaption>Number of cycles; lines at P5, P50 and P95.{}</figcaption></figure>",
            svg::histogram(histogram, &statistic.quantiles, unit),
            match histogram.below + histogram.above {
                0 => String::new(),
                n => format!(" {} cycles lie outside the picture.", grouped(n)),
            }
        );
    }
    text
}

/// What goes with the consumption: bands over tenths of the cycles, the strongest first.
fn explained(gathered: &Gathered, quantity: &RecordQuantity, statistic: &Statistic) -> String {
    let mut found: Vec<(String, f64, Association)> = Vec::new();
    for (k, (_, label, factor, per_distance)) in EXPLAINING.into_iter().enumerate() {
        let triples = gathered.triples(k, quantity);
        let label = if per_distance { format!("{label} per km") } else { label.to_owned() };
        let association = if k == PAYLOAD {
            association(&triples.iter().map(|(_, x, y)| (*x, *y)).collect::<Vec<_>>())
        } else {
            association_beside(&triples)
        };
        found.extend(association.map(|association| (label, factor, association)));
    }
    if found.is_empty() {
        return String::new();
    }
    found.sort_by(|a, b| b.2.share.total_cmp(&a.2.share));
    found.truncate(SHOWN);
    let (unit, _) = label(statistic.column);
    let all = || found.iter().flat_map(|(_, _, association)| &association.bands);
    let low = all().map(|band| band.y[0]).fold(f64::INFINITY, f64::min);
    let high = all().map(|band| band.y[2]).fold(f64::NEG_INFINITY, f64::max);
    let mut text = format!(
        "<h2>What goes with the spread</h2>\n<p>{} over tenths of the cycles, sorted by each quantity, whose values stand below the first, the \
         middle and the last of them: the line is the median, the band holds 80 % of the cycles. The percentage is the share of the variance between the tenths. All but \
         the payload are seen beside it: what goes with a cycle's payload is taken off its value first. It \
         says what goes together; <code>ocmc sensitivity</code> says what causes the spread.</p>\n<div class=\"charts\">\n",
        escaped(unit)
    );
    for (name, factor, association) in &found {
        let _ = writeln!(
            text,
            "<figure><h3>{}: {:.0} %</h3>{}</figure>",
            escaped(name),
            100.0 * association.share,
            svg::bands(association, name, *factor, [low, high])
        );
    }
    text.push_str("</div>\n");
    text
}

/// A number of a record, by the name of its column.
fn number(record: &Record, name: &str) -> Option<f64> {
    match column(name)?.get(record) {
        Cell::Number(value) => value,
        Cell::Integer(value) => value.map(|value| value as f64),
        Cell::Outcome(_) => None,
    }
}

/// How a command names the study of this run: a built-in name where it is one, otherwise a file to
/// save it to.
fn study_argument(run: &Reported) -> String {
    let none: &[&str] = &[];
    let built_in = study::list().iter().find(|built_in| {
        study::load(built_in.name, none)
            .is_ok_and(|loaded| study::study_hash(&loaded.model) == run.manifest.study_hash)
    });
    built_in.map_or_else(|| "study.toml".to_owned(), |built_in| built_in.name.to_owned())
}

/// The command that shows one cycle of this run step by step, where the study alone gives it.
fn trace_command(run: &Reported, study: &str, cycle_id: u64) -> String {
    if run.manifest.followed.is_some() {
        return "–".to_owned();
    }
    let seed = run.manifest.seed;
    format!(
        "<code>ocmc trace --study {study} --seed {seed} --cycle-id {cycle_id} --out cycle-{cycle_id}.csv</code>"
    )
}

/// A value in its unit for people.
fn shown(value: Option<f64>, factor: f64) -> String {
    value.map_or("–".to_owned(), |value| rounded(factor * value))
}

#[cfg(test)]
mod tests;

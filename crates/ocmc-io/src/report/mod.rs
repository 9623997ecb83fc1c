//! The report of a run: one HTML file that opens offline, on a phone, in print, light and dark,
//! without scripts.

mod anchors;
mod benchmark;
mod charging;
mod charging_pictures;
mod comparison;
mod doubt;
mod energy;
mod gathered;
mod learn;
mod mixed_fleet;
mod opening;
mod panel;
mod parts;
mod repeat;
mod sensitivity;
mod simulator_pictures;
mod simulator_study;
mod speed_over_distance;
mod svg;
mod tables;
mod trip;
mod trucks;
mod validation;

use crate::label::{label, remarks};
use crate::number_text::{grouped, rounded};
use crate::run_directory::{Manifest, RunDirectoryError, RunSummary, StoredRun, read_groups};
pub use benchmark::{
    BenchmarkBar, BenchmarkChange, BenchmarkPage, BenchmarkRanking, benchmark_html,
};
pub use comparison::{ComparisonPage, PairPicture, comparison_html};
pub use doubt::{DoubtBar, DoubtPage, doubt_html};
pub use gathered::Gathered;
pub use learn::{LearnPage, learn_html};
pub use mixed_fleet::{MixedFleetPage, PageTable, mixed_fleet_html};
use ocmc_core::record::{Record, column};
use ocmc_fleet::association::{Association, association, association_beside};
use ocmc_fleet::quantity::{RecordQuantity, quantity};
use ocmc_fleet::statistic::Statistic;
use repeat::Repeat;
pub use sensitivity::{SensitivityPage, sensitivity_html};
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
/// sampled is not in the records; `ocmc sensitivity` has its share. Speed, stops and gear shifts
/// are outcomes, as the consumption is.
const EXPLAINING: [(&str, &str, f64, bool); 14] = [
    ("payload_kg", "payload, t", 1e-3, false),
    ("climb_m", "climb, m", 1.0, true),
    ("mean_limit_mps", "mean of the signs, km/h", 3.6, false),
    ("urban_share", "urban share, %", 100.0, false),
    ("motorway_share", "motorway share, %", 100.0, false),
    ("n_curves", "curves", 1.0, true),
    ("air_temperature_k", "air temperature, °C", 1.0, false),
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

/// Least share that is shown.
const LEAST_SHARE: f64 = 0.005;

/// Pictures of what goes with the consumption.
const SHOWN: usize = 9;

/// A run, as far as a report needs it.
#[derive(Clone, Debug)]
pub struct Reported {
    /// Manifest of the run.
    pub manifest: Manifest,
    /// Totals of its cycles.
    pub summary: RunSummary,
    /// Further data from its records.
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
    let repeat = Repeat::of(&run.manifest);
    let own = summary.consumption().and_then(|statistic| quantity(statistic.column));
    let explaining = own.map_or_else(Vec::new, |own| explaining(&run.gathered, own));
    let mut page = opening::opening(run, &explaining);
    page.push_str(&opening::key_numbers(run));
    if let Some(statistic) = summary.consumption() {
        page.push_str(&trucks::trucks(summary));
        page.push_str(&distribution(statistic));
        let told: Vec<Statistic> = summary.told().cloned().collect();
        let remarks = remarks(summary);
        let caption = [&[tables::OVER_CYCLES.to_owned()], remarks.as_slice()].concat().join(" ");
        page.push_str(&tables::statistics(&told, &caption, run.summary.note));
        page.push_str(&parts::parts(summary));
        page.push_str(&charging::charging(run));
        page.push_str(&energy::breakdown(&run.gathered.sums));
        page.push_str(&charging::waterfall(&run.gathered));
        if let Some(quantity) = quantity(statistic.column) {
            page.push_str(&explained(&explaining, statistic));
            page.push_str(&tables::road_shares(&run.gathered.sums));
            page.push_str(&trip::trip(run, quantity, &repeat));
            page.push_str(&tables::outliers(run, quantity, &repeat));
        }
    }
    page.push_str(&tables::failures(run, &repeat));
    page.push_str(&repeat.section(run));
    page.push_str(&tables::study(run));
    page.push_str(&tables::provenance(run));
    page.push_str(&anchors::anchors(run));
    format!("{}{}{FOOT}", head(run), folded(&page))
}

/// The sections of a page, each of which can be folded away by its heading.
fn folded(page: &str) -> String {
    let mut parts = page.split("<h2>");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (heading, section) = part.split_once("</h2>").unwrap_or((part, ""));
        let _ = writeln!(
            text,
            "<details open><summary><h2>{heading}</h2></summary>{section}</details>"
        );
    }
    text
}

fn head(run: &Reported) -> String {
    let name = escaped(&run.manifest.study);
    let description = run.manifest.value("study.description");
    let description = description.as_ref().and_then(|text| text.as_str()).unwrap_or_default();
    let top = page_head(&format!("{name}: a run of ocmc"), STYLE);
    let day = run.summary.ended_at.get(..10);
    let day = day.map_or_else(String::new, |day| format!(" · {}", escaped(day)));
    let cycles = grouped(run.summary.summary.cycles);
    format!(
        "{top}<h1>{name}</h1>\n<p class=\"soft\">{}<br>{cycles} trips, seed {}{day} · ocmc {}</p>\n\
         ",
        escaped(description),
        run.manifest.seed,
        escaped(&run.manifest.program_version)
    )
}

/// The end of a page.
const FOOT: &str = "</main>\n</body>\n</html>\n";

/// The head of a page, up to its body.
fn page_head(title: &str, style: &str) -> String {
    // nothing may be fetched, whatever a study's name holds
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; \
         style-src 'unsafe-inline'\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<title>{title}</title>\n<style>\n{style}</style>\n\
         </head>\n<body>\n<main>\n"
    )
}

fn distribution(statistic: &Statistic) -> String {
    let (unit, factor) = label(statistic.column);
    let mut text = format!("<h2>Distribution over the cycles: {}</h2>\n", escaped(unit));
    if let Some(histogram) = statistic.histogram.as_ref().filter(|_| factor == 1.0) {
        let _ = writeln!(
            text,
            "<figure>{}<figcaption>Number of cycles; lines at P5, P50 and P95, and, dashed, at the \
             mean of the fleet.{}</figcaption></figure>",
            svg::histogram(histogram, &marks(statistic), unit, "cycles"),
            match histogram.below + histogram.above {
                0 => String::new(),
                n => format!(" {} cycles lie outside the picture.", grouped(n)),
            }
        );
    }
    text
}

/// The lines of a histogram: quantiles, and the mean of the fleet.
fn marks(statistic: &Statistic) -> Vec<svg::Mark> {
    let shown = statistic.quantiles.iter().filter(|q| ["p5", "p50", "p95"].contains(&q.name));
    let lines = shown.filter_map(|q| Some(svg::Mark::quantile(q.value?, q.name.to_uppercase())));
    lines.chain(statistic.mean.map(|mean| svg::Mark::mean(mean, "mean".to_owned()))).collect()
}

/// A quantity that goes with the consumption.
struct Explaining {
    /// Name for people, with its unit.
    name: String,
    /// The factor to that unit.
    factor: f64,
    association: Association,
}

/// Inputs that go with the consumption, the strongest first.
fn explaining(gathered: &Gathered, quantity: &RecordQuantity) -> Vec<Explaining> {
    let mut quantities = Vec::new();
    for (k, (_, label, factor, per_distance)) in EXPLAINING.into_iter().enumerate() {
        let triples = gathered.triples(k, quantity);
        let label = if per_distance { format!("{label} per km") } else { label.to_owned() };
        let association = if k == PAYLOAD {
            association(&triples.iter().map(|(_, x, y)| (*x, *y)).collect::<Vec<_>>())
        } else {
            association_beside(&triples)
        };
        quantities.extend(association.map(|association| Explaining {
            name: label,
            factor,
            association,
        }));
    }
    strongest(quantities)
}

/// Inputs that are shown, the strongest first: a share that chance gives, too, or that rounds to
/// nothing, says nothing.
fn strongest(mut quantities: Vec<Explaining>) -> Vec<Explaining> {
    quantities.retain(|explaining| {
        let Association { share, by_chance, .. } = explaining.association;
        share >= LEAST_SHARE.max(by_chance)
    });
    quantities.sort_by(|a, b| b.association.share.total_cmp(&a.association.share));
    quantities.truncate(SHOWN);
    quantities
}

/// Inputs that go with the consumption: bands over tenths of the cycles.
fn explained(quantities: &[Explaining], statistic: &Statistic) -> String {
    if quantities.is_empty() {
        return String::new();
    }
    let (unit, _) = label(statistic.column);
    let mut text = format!(
        "<h2>What goes with the spread</h2>\n\
         <p>{} over tenths of the cycles, sorted by each quantity, whose values stand below the \
         first, the middle and the last of them: the line is the median, the band holds 80 % of \
         the cycles. The percentage is the share of the variance between the tenths, freed of what \
         chance gives; quantities whose share chance gives, too, are not shown. All but the \
         payload are seen beside it: what goes with a cycle's payload is taken off its value \
         first. It says what goes together; <code>ocmc sensitivity</code> says what causes the \
         spread.</p>\n",
        escaped(unit)
    );
    text.push_str(&panels(quantities, "Consumption"));
    text
}

/// A picture of each quantity that goes with something, all on one scale.
fn panels(quantities: &[Explaining], what: &str) -> String {
    let all = || quantities.iter().flat_map(|explaining| &explaining.association.bands);
    let low = all().map(|band| band.y[0]).fold(f64::INFINITY, f64::min);
    let high = all().map(|band| band.y[2]).fold(f64::NEG_INFINITY, f64::max);
    let mut text = "<div class=\"charts\">\n".to_owned();
    for Explaining { name, factor, association } in quantities {
        let _ = writeln!(
            text,
            "<figure><h3>{}: {:.0} %</h3>{}</figure>",
            escaped(name),
            100.0 * association.share,
            svg::bands(association, [what, name], *factor, [low, high])
        );
    }
    text.push_str("</div>\n");
    text
}

/// A number of a record, by the name of its column.
fn number(record: &Record, name: &str) -> Option<f64> {
    column(name)?.get(record).number()
}

/// A value in its unit for people.
fn shown(value: Option<f64>, factor: f64) -> String {
    value.map_or("–".to_owned(), |value| rounded(factor * value))
}

#[cfg(test)]
mod tests;

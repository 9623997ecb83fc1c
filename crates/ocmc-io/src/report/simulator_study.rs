//! Results of the driving-simulator study: its numbers, events and drives, and the page.

use super::simulator_pictures::Picture;
use super::svg::escaped;
use super::tables::{cells, rows, table};
use super::{STYLE, page_head, shown};
use crate::number_text::rounded;
use ocmc_estimation::fit::analysis_of_variance::VarianceRow;
use serde::Serialize;
use std::fmt::Write;

/// A number of the paper beside the same of all repetitions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComparedNumber {
    /// Table of the paper.
    pub table: &'static str,
    /// Quantity, with its unit.
    pub quantity: &'static str,
    /// Number that the paper prints.
    pub paper: f64,
    /// Median over the repetitions; none where no repetition has it.
    pub median: Option<f64>,
    /// A twentieth of the repetitions lies below; none of fewer than twenty.
    pub p5: Option<f64>,
    /// A twentieth of the repetitions lies above.
    pub p95: Option<f64>,
    /// Repetitions that have it.
    pub n: usize,
}

impl ComparedNumber {
    /// Whether the printed number lies within the inner nine tenths of the repetitions.
    pub fn within(&self) -> Option<bool> {
        let (low, high) = self.p5.zip(self.p95)?;
        Some((low..=high).contains(&self.paper))
    }
}

/// A curve that a driver drove.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SimulatorCurve {
    /// Repetition, from 0.
    pub repetition: u64,
    /// Driver, from 1.
    pub driver: usize,
    /// Radius, in m.
    pub radius_m: f64,
    /// True for a left curve.
    pub left: bool,
    /// Mean speed in its middle third, in m/s.
    pub speed_mps: f64,
}

/// A change of the limit that a driver met.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SimulatorChange {
    /// Repetition, from 0.
    pub repetition: u64,
    /// Driver, from 1.
    pub driver: usize,
    /// Its kind, such as `70-to-40`.
    pub change: String,
    /// Mean acceleration over the window with the largest one, in m/s².
    pub acceleration_mps2: f64,
}

/// Signals over the way.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DriveSeries {
    /// Position, in m.
    pub position_m: Vec<f64>,
    /// Speed, in m/s.
    pub speed_mps: Vec<f64>,
    /// Accelerator pedal.
    pub accelerator: Vec<f64>,
    /// Brake pedal.
    pub brake: Vec<f64>,
}

/// A slope with the gains that were identified on it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SimulatorEvent {
    /// Driver, from 1.
    pub driver: usize,
    /// Its name, such as `+3.5 %`.
    pub event: String,
    /// Slope.
    pub grade: f64,
    /// K_P, in s/m, K_I, in 1/m, and K_D, in s²/m, as identified.
    pub gains: [f64; 3],
    /// The same, as they are.
    pub true_gains: [f64; 3],
    /// Upper bounds of the search.
    pub bounds: [f64; 3],
    /// Names of the parameters that ended at a bound.
    pub at_bound: Vec<&'static str>,
    /// Set speed, as identified, in m/s.
    pub set_speed_mps: f64,
    /// Speed that the driver wants, in m/s.
    pub wanted_mps: f64,
    /// Recorded series.
    #[serde(skip)]
    pub recorded: DriveSeries,
    /// Series of the identified driver.
    #[serde(skip)]
    pub simulated: DriveSeries,
}

/// The whole drive of a driver.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatorDrive {
    /// Signals.
    pub series: DriveSeries,
    /// Limit, in m/s.
    pub limit_mps: Vec<f64>,
}

/// One repetition of the study, as far as its pictures need it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SimulatorRepetition {
    /// The curves.
    pub curves: Vec<SimulatorCurve>,
    /// Exponent and speed at the reference radius: estimated, and with the exponent fixed.
    pub curve_laws: [[f64; 2]; 2],
    /// Reference radius, in m.
    pub reference_radius_m: f64,
    /// The changes.
    pub changes: Vec<SimulatorChange>,
    /// Median of each kind of change that counts, and the one of the paper, in m/s².
    pub medians_mps2: Vec<(&'static str, Option<f64>, f64)>,
    /// Accelerations that do not count, in m/s².
    pub within_mps2: [f64; 2],
    /// The slopes; none where nothing was identified.
    pub events: Vec<SimulatorEvent>,
    /// The drives.
    pub drives: Vec<SimulatorDrive>,
}

/// The page of a study.
#[derive(Clone, Copy, Debug)]
pub struct SimulatorPage<'a> {
    /// Title: what was driven.
    pub title: &'a str,
    /// Facts about it.
    pub facts: &'a [(&'static str, String)],
    /// The paper's numbers beside ours.
    pub compared: &'a [ComparedNumber],
    /// Analysis of variance of the first repetition.
    pub anova: &'a [VarianceRow],
    /// The pictures.
    pub pictures: &'a [Picture],
}

/// The page: HTML that opens offline in any browser.
pub fn simulator_html(page: &SimulatorPage) -> String {
    let title = escaped(page.title);
    let mut before = "";
    let compared = page.compared.iter().map(|row| {
        let name = if row.table == before { "" } else { row.table };
        before = row.table;
        let [median, low, high] = [row.median, row.p5, row.p95].map(|value| shown(value, 1.0));
        format!(
            "<tr><td>{}</td><td class=\"words\">{}</td><td>{}</td><td>{median}</td><td>{low} to \
             {high}</td></tr>\n",
            escaped(name),
            escaped(row.quantity),
            rounded(row.paper)
        )
    });
    let anova = page.anova.iter().map(|row| {
        cells(&[
            row.term.to_string(),
            row.df.to_string(),
            format!("{:.5}", row.sum_sq),
            format!("{:.6}", row.mean_sq),
            row.f.map_or("–".to_owned(), |f| format!("{f:.4}")),
            row.p.map_or("–".to_owned(), |p| format!("{p:.2e}")),
        ])
    });
    let mut text = page_head(&format!("{title}: the paper's simulator study"), STYLE);
    let _ = writeln!(
        text,
        "<h1>{title}</h1>\n<p class=\"soft\">The driving-simulator study of the paper, \
         repeated</p>\n<table><tbody>\n{}</tbody></table>\n<h2>Paper and program</h2>\n<p \
         class=\"soft\">The median of the repetitions, and where nine tenths of them lie.</p>\n\
         {}<h2>Analysis of variance, first repetition</h2>\n{}<h2>Pictures, first repetition</h2>",
        rows(page.facts),
        table(&["table", "quantity", "paper", "program", "90 %"], compared),
        table(&["source", "Df", "Sum Sq", "Mean Sq", "F", "p"], anova)
    );
    for picture in page.pictures {
        let _ = writeln!(
            text,
            "<figure tabindex=\"0\">{}<figcaption>{}</figcaption></figure>",
            picture.svg(),
            escaped(&picture.caption)
        );
    }
    text.push_str(super::FOOT);
    text
}

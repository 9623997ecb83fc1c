//! The machine-readable answer of a run.

use super::{Manifest, indented};
use crate::study::JudgedDoubt;
use ocmc_fleet::precision::Reached;
use ocmc_fleet::summary::Summary;
use schemars::JsonSchema;
use serde::Serialize;

/// Remark on the intervals of a few cycles.
pub const FEW_CYCLES: &str = "fewer than 50 completed cycles: 95 % intervals of skewed quantities \
                              cover about 85 %";

/// A run, and what it adds up to: the machine-readable answer, which `--json` prints and
/// [`super::SUMMARY`] holds.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct RunSummary {
    /// Name of the study.
    pub study: String,
    /// Hash of the resolved study.
    pub study_hash: String,
    /// Master seed.
    pub seed: u64,
    /// Id of the first cycle.
    pub first_cycle: u64,
    /// Totals of the cycles.
    #[serde(flatten)]
    pub summary: Summary,
    /// Effect of judged numbers on the mean; absent where none is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub judged: Option<JudgedMean>,
    /// How well the answer is known, of a run that was to end at a precision.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub precision: Option<Reached>,
    /// Remark on its intervals that has to be known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<&'static str>,
    /// When the run ended, in UTC, as `2026-11-24T21:04:00Z`.
    pub ended_at: String,
    /// How long the run took, in s.
    pub wall_s: f64,
    /// Threads that it took.
    pub threads: usize,
}

/// Effect of judged numbers on a fleet's mean consumption.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct JudgedMean {
    /// Root of the sum of squares of the effects of their plausible ranges on the mean, in the unit
    /// of the column: no confidence interval. None where it is not known without driving.
    pub plus_minus: Option<f64>,
    /// How it is known.
    #[serde(flatten)]
    pub doubt: JudgedDoubt,
}

impl JudgedMean {
    fn new(doubt: &JudgedDoubt, summary: &Summary) -> Self {
        let known = doubt.stored.as_ref().zip(summary.consumption());
        let known = known.filter(|(stored, own)| stored.column == own.column);
        let plus_minus = known.and_then(|(stored, own)| Some(stored.share_of_mean * own.mean?));
        let stored = doubt.stored.clone().filter(|_| plus_minus.is_some());
        Self { plus_minus, doubt: JudgedDoubt { stored, ..*doubt } }
    }
}

impl RunSummary {
    /// Summary of the run of this manifest, which ends now.
    pub fn new(manifest: &Manifest, mut summary: Summary, wall_s: f64, threads: usize) -> Self {
        let routes = if summary.routes.is_empty() { Vec::new() } else { manifest.routes() };
        for route in &mut summary.routes {
            route.file = routes.get(route.route_id as usize).map(|own| own.file.clone());
        }
        Self {
            study: manifest.study.clone(),
            study_hash: manifest.study_hash.clone(),
            seed: manifest.seed,
            first_cycle: manifest.first_cycle,
            note: summary.has_few_cycles().then_some(FEW_CYCLES),
            judged: manifest.judged.as_ref().map(|judged| JudgedMean::new(judged, &summary)),
            summary,
            precision: None,
            ended_at: now(),
            wall_s,
            threads,
        }
    }

    /// The answer as indented JSON, with a line end.
    pub fn to_json(&self) -> String {
        indented(self)
    }
}

/// This second, in UTC.
pub fn now() -> String {
    let now = jiff::Timestamp::now();
    now.strftime("%Y-%m-%dT%H:%M:%SZ").to_string()
}

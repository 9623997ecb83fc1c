//! The machine-readable answer of a run: what `--json` prints and what `summary.json` holds.

use super::Manifest;
use ocmc_core::fleet::precision::Reached;
use ocmc_core::fleet::summary::Summary;
use serde::Serialize;

/// A run, and what it adds up to.
#[derive(Clone, Debug, Serialize)]
pub struct RunSummary {
    /// Name of the study.
    pub study: String,
    /// Hash of the resolved study.
    pub study_hash: String,
    /// Master seed.
    pub seed: u64,
    /// Id of the first cycle.
    pub first_cycle: u64,
    /// What the cycles add up to.
    #[serde(flatten)]
    pub summary: Summary,
    /// How well the answer is known, of a run that was to end at a precision.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub precision: Option<Reached>,
    /// How long the run took, in s.
    pub wall_s: f64,
    /// Threads that it took.
    pub threads: usize,
}

impl RunSummary {
    /// What the run of this manifest adds up to.
    pub fn new(manifest: &Manifest, summary: Summary, wall_s: f64, threads: usize) -> Self {
        Self {
            study: manifest.study.clone(),
            study_hash: manifest.study_hash.clone(),
            seed: manifest.seed,
            first_cycle: manifest.first_cycle,
            summary,
            precision: None,
            wall_s,
            threads,
        }
    }

    /// The answer as indented JSON, with a line end.
    pub fn to_json(&self) -> String {
        let mut text =
            serde_json::to_string_pretty(self).expect("numbers, and keys that are words");
        text.push('\n');
        text
    }
}

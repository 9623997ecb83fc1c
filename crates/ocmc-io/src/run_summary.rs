//! The machine-readable answer of a run: what `--json` prints and what `summary.json` holds.

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
    /// How long the run took, in s.
    pub wall_s: f64,
    /// Threads that it took.
    pub threads: usize,
}

impl RunSummary {
    /// The answer as indented JSON, with a line end.
    pub fn to_json(&self) -> String {
        let mut text =
            serde_json::to_string_pretty(self).expect("numbers, and keys that are words");
        text.push('\n');
        text
    }
}

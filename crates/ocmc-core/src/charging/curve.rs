//! The charge curve: the most power that a battery takes by its state of charge.

use crate::validation::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The most power by state of charge, linear between its points and level beyond them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChargeCurve {
    /// States of charge, rising.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub charge: Vec<f64>,
    /// Power at the battery's terminals there, in W; it may not rise.
    #[schemars(inner(range(min = 100.0, max = 1.0e7)))]
    pub power_w: Vec<f64>,
}

impl ChargeCurve {
    /// As many powers as charges, in order, and no power that rises.
    pub fn validate(&self, problems: &mut Problems) {
        let (charges, powers) = (self.charge.len(), self.power_w.len());
        let pairs = charges == powers && charges > 0;
        let found = format!("{powers} powers for {charges} charges");
        problems.require(pairs, "power_w", found, "one power for each charge, at least one");
        let wrong = |values: &[f64], holds: fn(f64, f64) -> bool| {
            let mut pairs = values.windows(2).enumerate();
            pairs.find(|(_, pair)| !holds(pair[0], pair[1])).map(|(k, pair)| (k + 2, pair.to_vec()))
        };
        if let Some((entry, pair)) = wrong(&self.charge, |before, here| before < here) {
            let shown = format!("{} after {} (entry {entry})", pair[1], pair[0]);
            problems.require(false, "charge", shown, "states of charge that rise");
        }
        if let Some((entry, pair)) = wrong(&self.power_w, |before, here| before >= here) {
            let shown = format!("{} after {} (entry {entry})", pair[1], pair[0]);
            problems.require(false, "power_w", shown, "powers that do not rise with the charge");
        }
    }

    /// The most power at a state of charge, in W.
    pub fn power_w(&self, charge: f64) -> f64 {
        let (charges, powers) = (&self.charge, &self.power_w);
        let above = charges.partition_point(|at| *at <= charge);
        match (above.checked_sub(1), powers.get(above)) {
            (Some(k), Some(next_w)) => {
                let share = (charge - charges[k]) / (charges[above] - charges[k]);
                powers[k] + (next_w - powers[k]) * share
            }
            (Some(k), None) => powers[k],
            (None, Some(first_w)) => *first_w,
            (None, None) => f64::INFINITY,
        }
    }
}

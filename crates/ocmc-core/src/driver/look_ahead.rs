//! Looking ahead: what a driver, or the truck for him, does before lower limits, on descents and at
//! stops to save fuel. All of it is off where a study says nothing else.
//!
//! The rules read the road ahead and the truck's own mass, drag and engine; they know nothing of
//! wind, weather or traffic to come.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Switches and numbers of looking ahead.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LookAheadModel {
    /// Whether the truck coasts in gear before lower limits and stops: from where the deceleration
    /// that the lower speed asks for is the decision factor times that of coasting.
    pub coasting: bool,
    /// Whether the clutch opens on descents that keep the speed without the engine.
    pub eco_roll: bool,
    /// Whether the truck comes to a crest so slowly that the descent behind it gives the speed
    /// back.
    pub predictive_cruise: bool,
    /// Whether the engine stops at stops.
    pub engine_stop: bool,
    /// Speed above which all but the engine's stop is done, in m/s.
    #[schemars(range(min = 0.0, max = 40.0))]
    pub minimum_speed_mps: f64,
    /// Distance that is seen ahead, as a time at the truck's speed, in s.
    #[schemars(range(min = 1.0, max = 300.0))]
    pub preview_s: f64,
    /// Decision factor of coasting before changes of speed that are large or end slow; 1 before
    /// small ones at high speeds.
    #[schemars(range(min = 1.0, max = 10.0))]
    pub decision_factor: f64,
    /// Speed below the desired one down to which the truck rolls at crests and on descents, in m/s.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub underspeed_mps: f64,
    /// Time at a stop after which the engine stops, in s.
    #[schemars(range(min = 0.0, max = 600.0))]
    pub engine_stop_delay_s: f64,
    /// Electric power while it is stopped, in W, given back by the engine afterwards.
    #[schemars(range(min = 0.0, max = 20_000.0))]
    pub engine_stop_power_w: f64,
}

impl LookAheadModel {
    /// Whether a moving truck is driven otherwise than without.
    pub fn drives(&self) -> bool {
        self.coasting || self.eco_roll || self.predictive_cruise
    }
}

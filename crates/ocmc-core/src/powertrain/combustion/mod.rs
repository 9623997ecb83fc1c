//! Combustion: an engine and its fuel behind clutch and gearbox.

mod capability;
mod inverse;
mod powertrain;

pub use powertrain::{CombustionPowertrain, CombustionStage, CombustionState, PredictedTorque};

use super::component::engine::EngineModel;
use super::component::gearbox::GearboxModel;
use crate::validation::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An engine that burns a fuel, behind clutch and gearbox.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CombustionModel {
    /// Engine.
    pub engine: EngineModel,
    /// Gearbox and axle.
    pub gearbox: GearboxModel,
}

impl CombustionModel {
    /// An engine and a gearbox that fit in themselves and to each other.
    pub fn validate(&self, problems: &mut Problems) {
        problems.part("engine", |problems| self.engine.validate(problems));
        let idle_radps = self.engine.idle_speed_radps;
        problems.part("gearbox", |problems| self.gearbox.validate(idle_radps, problems));
    }
}

//! The driver: what speed is wanted (tactical parameters) and how the pedals follow it
//! (operational).

pub mod curve_speed;
pub mod look_ahead;
pub mod pedal;
pub mod speed_change;
pub mod speed_limit;

use crate::random::Streams;
use crate::switch::ModelSwitch;
use crate::validation::Problems;
use curve_speed::{CurveSpeed, CurveSpeedModel};
use look_ahead::LookAheadModel;
use pedal::{PedalModel, Pedals};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use speed_change::{SpeedChange, SpeedChangeModel};
use speed_limit::{SpeedLimit, SpeedLimitModel};

/// A population of drivers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DriverModel {
    /// Speed in curves.
    pub curve_speed: CurveSpeedModel,
    /// Decelerations and accelerations.
    pub speed_change: SpeedChangeModel,
    /// Compliance with limits.
    pub speed_limit: SpeedLimitModel,
    /// Pedal controllers.
    pub pedals: PedalModel,
    /// Looking ahead.
    pub look_ahead: LookAheadModel,
}

/// One driver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driver {
    /// Speed in curves.
    pub curve_speed: CurveSpeed,
    /// Decelerations and accelerations.
    pub speed_change: SpeedChange,
    /// Compliance with limits.
    pub speed_limit: SpeedLimit,
    /// Pedal controller.
    pub pedals: Pedals,
}

impl DriverModel {
    /// The rules between the numbers of each of its models.
    pub fn validate(&self, problems: &mut Problems) {
        problems.part("curve_speed", |problems| self.curve_speed.validate(problems));
        problems.part("speed_limit", |problems| self.speed_limit.validate(problems));
        problems.part("pedals.pid", |problems| self.pedals.pid.validate(problems));
    }

    /// Draws one driver. Without [`ModelSwitch::DriverSpread`] all are the typical one.
    /// `limiter_mps`: speed at which the vehicle's limiter begins to act, in m/s.
    pub fn sample(
        &self,
        streams: &Streams,
        without: &[ModelSwitch],
        stability_limit: f64,
        limiter_mps: f64,
    ) -> Driver {
        let spread = !without.contains(&ModelSwitch::DriverSpread);
        Driver {
            curve_speed: self.curve_speed.sample(streams, spread),
            speed_change: self.speed_change.sample(streams, spread),
            speed_limit: self.speed_limit.sample(streams, spread, limiter_mps),
            pedals: self.pedals.sample(streams, spread, stability_limit),
        }
    }
}

//! How hard a driver brakes and accelerates for a change of the desired speed.
//!
//! a = a₀ exp(e), e ~ N(0, σ²), with the sign apart: the paper's log-normal law, one draw a driver
//! for each direction. The paper's medians (1.16 down, 0.52 up, in m/s²) are those of the *largest*
//! windows; the default study takes 0.6 and 0.5.

use crate::distribution::Quantity;
use crate::lanes::UNBOUNDED;
use crate::random::{Stream, Streams};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Statistical description of speed changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpeedChangeModel {
    /// Deceleration, as a positive number, in m/s².
    #[schemars(range(min = 0.05, max = 5.0))]
    pub deceleration_mps2: Quantity,
    /// Acceleration, in m/s².
    #[schemars(range(min = 0.05, max = 5.0))]
    pub acceleration_mps2: Quantity,
    /// How the desired speed rises.
    pub rise: Rise,
    /// Desired speed at which a standing truck starts, in m/s.
    #[schemars(range(min = 0.5, max = 6.0))]
    pub launch_speed_mps: f64,
    /// The most that the accelerator pedal asks for, over the driver's acceleration; 100: no limit.
    #[schemars(range(min = 0.5, max = 100.0))]
    pub peak_acceleration_ratio: f64,
}

/// How the desired speed rises at a higher limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Rise {
    /// With the driver's acceleration.
    Ramp,
    /// At once, as in the paper.
    Paper,
}

/// One driver's accelerations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedChange {
    /// Deceleration, as a positive number, in m/s².
    pub deceleration_mps2: f64,
    /// Acceleration, in m/s².
    pub acceleration_mps2: f64,
    /// How the desired speed rises.
    pub rise: Rise,
    /// Desired speed at which a standing truck starts, in m/s.
    pub launch_speed_mps: f64,
    /// The most that the accelerator pedal asks for, in m/s²; unbounded where there is no limit.
    pub peak_acceleration_mps2: f64,
}

/// Ratio of the peak acceleration from which on there is no limit.
const NO_PEAK_RATIO: f64 = 100.0;

impl SpeedChangeModel {
    /// Draws one driver; `spread` false gives the typical one.
    pub fn sample(&self, streams: &Streams, spread: bool) -> SpeedChange {
        let mut draws = streams.open(Stream::SpeedChange);
        let mut draw =
            |law: &Quantity| law.drawn_from(spread, streams, Stream::SpeedChange, &mut draws);
        let deceleration_mps2 = draw(&self.deceleration_mps2);
        let acceleration_mps2 = draw(&self.acceleration_mps2);
        let ratio = self.peak_acceleration_ratio;
        let unlimited = ratio >= NO_PEAK_RATIO;
        SpeedChange {
            deceleration_mps2,
            acceleration_mps2,
            rise: self.rise,
            launch_speed_mps: self.launch_speed_mps,
            peak_acceleration_mps2: if unlimited { UNBOUNDED } else { ratio * acceleration_mps2 },
        }
    }
}

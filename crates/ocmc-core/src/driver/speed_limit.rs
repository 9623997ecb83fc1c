//! Response of a driver to a speed limit, to a bump, and to a truck's limiter.
//!
//! Checked: a bump of 4 m × 0.10 m at 2 m/s² is taken at 6.3 m/s, and the minimum of sign, legal
//! speed and v_max holds. The desired speed never lies above v_max (`tests/it/tactical.rs`).

use crate::distribution::Quantity;
use crate::random::{Stream, Streams};
use crate::validation::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Statistical description of compliance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpeedLimitModel {
    /// Factor on the limit.
    #[schemars(range(min = 0.5, max = 1.5))]
    pub compliance: Quantity,
    /// Highest speed that a driver wants, in m/s; 1 km/h below the vehicle's limiter where it is
    /// left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 3.0, max = 70.0))]
    pub maximum_speed_mps: Option<f64>,
    /// How far behind a sign a driver's wanted speed changes, in m; negative before it. At the sign
    /// where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Quantity", range(min = -500.0, max = 500.0))]
    pub sign_offset_m: Option<Quantity>,
    /// Vertical acceleration that a driver accepts at a bump, in m/s².
    #[schemars(range(min = 0.1, max = 20.0))]
    pub bump_acceleration_mps2: Quantity,
    /// Lowest speed at a bump, in m/s.
    #[schemars(range(min = 1.0, max = 20.0))]
    pub bump_minimum_mps: f64,
    /// Highest speed at a bump, in m/s.
    #[schemars(range(min = 1.0, max = 30.0))]
    pub bump_maximum_mps: f64,
}

/// How far below the vehicle's limiter a driver stays, in m/s: 1 km/h, so that it does not act
/// [EJ].
const BELOW_LIMITER_MPS: f64 = 1.0 / 3.6;

impl SpeedLimitModel {
    /// The speeds at bumps are in order.
    pub fn validate(&self, problems: &mut Problems) {
        problems.require(
            self.bump_minimum_mps <= self.bump_maximum_mps,
            "bump_minimum_mps",
            self.bump_minimum_mps,
            "at most bump_maximum_mps",
        );
    }

    /// Highest speed that a driver wants, in m/s, in a vehicle whose limiter acts from a speed on.
    pub fn highest_mps(&self, limiter_mps: f64) -> f64 {
        self.maximum_speed_mps.unwrap_or(limiter_mps - BELOW_LIMITER_MPS)
    }

    /// Draws one driver; `spread` false gives the typical one.
    pub fn sample(&self, streams: &Streams, spread: bool, limiter_mps: f64) -> SpeedLimit {
        let draw = |law: &Quantity, stream| law.drawn(spread, streams, stream);
        let sign_offset_m = self.sign_offset_m.as_ref();
        SpeedLimit {
            compliance: draw(&self.compliance, Stream::Compliance),
            maximum_speed_mps: self.highest_mps(limiter_mps),
            sign_offset_m: sign_offset_m.map_or(0.0, |law| draw(law, Stream::SignOffset)),
            bump_acceleration_mps2: draw(&self.bump_acceleration_mps2, Stream::BumpComfort),
            bump_minimum_mps: self.bump_minimum_mps,
            bump_maximum_mps: self.bump_maximum_mps,
        }
    }
}

/// One driver's compliance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedLimit {
    /// Factor on the limit.
    pub compliance: f64,
    /// Highest speed that the driver wants, in m/s.
    pub maximum_speed_mps: f64,
    /// How far behind a sign the wanted speed changes, in m.
    pub sign_offset_m: f64,
    /// Vertical acceleration at a bump, in m/s².
    pub bump_acceleration_mps2: f64,
    bump_minimum_mps: f64,
    bump_maximum_mps: f64,
}

impl SpeedLimit {
    /// Sign speed: v_sign = min(compliance · min(sign, legal limit), maximum), in m/s.
    pub fn sign_speed_mps(&self, sign_mps: f64, legal_mps: f64) -> f64 {
        (self.compliance * sign_mps.min(legal_mps)).min(self.maximum_speed_mps)
    }

    /// Speed at a bump, in m/s: v = L √(a_z / (8 h)), from the vertical acceleration v²/ρ on a
    /// crest of radius ρ = L²/(8h). Judgement, kept between the driver's bounds.
    pub fn bump_speed_mps(&self, length_m: f64, height_m: f64) -> f64 {
        let speed = length_m * (self.bump_acceleration_mps2 / (8.0 * height_m)).sqrt();
        speed.clamp(self.bump_minimum_mps, self.bump_maximum_mps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bump_of_the_guide() {
        let limit = SpeedLimit {
            compliance: 1.0,
            maximum_speed_mps: 89.0 / 3.6,
            sign_offset_m: 0.0,
            bump_acceleration_mps2: 2.0,
            bump_minimum_mps: 15.0 / 3.6,
            bump_maximum_mps: 35.0 / 3.6,
        };
        // L 4 m, h 0.10 m -> 6.3 m/s
        assert!((limit.bump_speed_mps(4.0, 0.10) - 6.3).abs() < 0.03);
        assert!((limit.sign_speed_mps(120.0 / 3.6, 85.0 / 3.6) - 85.0 / 3.6).abs() < 1e-12);
        assert!((limit.sign_speed_mps(120.0 / 3.6, f64::INFINITY) - 89.0 / 3.6).abs() < 1e-12);
    }
}

//! Turns at junctions: a share of the events at junctions carries one, because there the vehicle
//! leaves the road it was on.
//!
//! R = r₀ + exp(N(ln median, σ²)), over a length R π/2 U(f, 1).

use crate::operating_cycle::road::curvature::Curve;
use crate::random::Draws;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// Turns taken at junctions, the same for all road types.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JunctionTurnModel {
    /// Smallest radius R_turn, in m.
    #[schemars(range(min = 5.0, max = 200.0))]
    pub turn_radius_m: f64,
    /// Median of R − R_turn, in m.
    #[schemars(range(min = 0.1, max = 200.0))]
    pub median_radius_m: f64,
    /// Standard deviation of ln(R − R_turn).
    #[schemars(range(min = 0.0, max = 2.0))]
    pub radius_log_sd: f64,
    /// Shortest turn as a share of a right angle.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub minimum_share: f64,
}

impl JunctionTurnModel {
    /// The turn that begins at `position_m`.
    pub fn sample(&self, position_m: f64, draws: &mut Draws) -> Curve {
        let radius_m = self.turn_radius_m
            + self.median_radius_m * libm::exp(self.radius_log_sd * draws.normal());
        let angle = FRAC_PI_2 * draws.uniform_between(self.minimum_share, 1.0);
        let left = draws.happens(0.5);
        Curve { start_m: position_m, end_m: position_m + angle * radius_m, radius_m, left }
    }
}

//! Forecast by drivers of the way to a charger, before they have driven it.
//!
//! E = (1 + margin) e d + m g Δh + W, e = (E₀ L + e₀ L₀) / (L + L₀): what the trip has taken on L
//! metres without its own climb and without the work of the body, E₀, and what he counts with
//! before he has driven, e₀; L₀ = 20 km. A climb takes its potential energy, and a descent gives it
//! back: what is lost meanwhile is in e. W is what the body of the truck takes at stops of the
//! mission.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Way after which what the trip has taken counts as much as what was expected of it, in m
/// (judgement).
const LEARNED_OVER_M: f64 = 20.0e3;
/// Speed that drivers expect before they have driven, in m/s (judgement: 72 km/h).
const EXPECTED_MPS: f64 = 20.0;

/// How drivers forecast what the way ahead takes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ForecastModel {
    /// Consumption that a driver expects before he has driven, in J/m: afterwards that of his trip.
    #[schemars(range(min = 100.0, max = 50_000.0))]
    pub consumption_j_per_m: f64,
    /// Margin that he adds to the forecast, over it.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub margin: f64,
}

/// A trip as its driver knows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driven {
    /// How far it has come, in m.
    pub way_m: f64,
    /// Its driving time, in s.
    pub time_s: f64,
    /// Energy that the store has given, in J.
    pub drawn_j: f64,
    /// Energy of its climb and of the work of its body, in J.
    pub fixed_j: f64,
}

impl ForecastModel {
    /// Energy for a way, in J. `fixed_j`: the potential energy of its climb and the work of the
    /// body.
    pub fn energy_j(&self, driven: &Driven, way_m: f64, fixed_j: f64) -> f64 {
        let level_j = driven.drawn_j - driven.fixed_j;
        let sum_j = level_j + self.consumption_j_per_m * LEARNED_OVER_M;
        let per_m = sum_j / (driven.way_m + LEARNED_OVER_M);
        (1.0 + self.margin) * per_m * way_m + fixed_j
    }
}

impl Driven {
    /// How long a way takes to drive, in s.
    pub fn time_s(&self, way_m: f64) -> f64 {
        let sum_s = self.time_s + LEARNED_OVER_M / EXPECTED_MPS;
        sum_s / (self.way_m + LEARNED_OVER_M) * way_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_forecast_is_learned_on_the_way_and_knows_the_climb() {
        let model = ForecastModel { consumption_j_per_m: 4000.0, margin: 0.1 };
        let at_start = Driven { way_m: 0.0, time_s: 0.0, drawn_j: 0.0, fixed_j: 0.0 };
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
        close(model.energy_j(&at_start, 50e3, 0.0), 1.1 * 4000.0 * 50e3);
        close(at_start.time_s(50e3), 2500.0);
        // 5000 J/m on 60 km, of which the climb took 60 MJ: 4000 on the level
        let driven = Driven { way_m: 60e3, time_s: 3000.0, drawn_j: 300e6, fixed_j: 60e6 };
        close(model.energy_j(&driven, 50e3, -20e6), 1.1 * 4000.0 * 50e3 - 20e6);
        let thirsty = Driven { fixed_j: 0.0, ..driven };
        close(model.energy_j(&thirsty, 50e3, 0.0), 1.1 * 4750.0 * 50e3);
        close(driven.time_s(50e3), 2500.0);
    }
}

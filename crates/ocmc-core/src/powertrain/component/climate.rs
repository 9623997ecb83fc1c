//! Heating and cooling of cab, saloon and battery: auxiliary power that grows with the distance of
//! the air from comfort (judgement: a straight line).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Power for heating and cooling.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ClimateModel {
    /// Air temperature below which is heated, in K.
    #[schemars(range(min = 200.0, max = 340.0))]
    pub heat_below_k: f64,
    /// Power of heating for each K below, in W/K.
    #[schemars(range(min = 0.0, max = 10_000.0))]
    pub heat_w_per_k: f64,
    /// Air temperature above which is cooled, in K.
    #[schemars(range(min = 200.0, max = 340.0))]
    pub cool_above_k: f64,
    /// Power of cooling for each K above, in W/K.
    #[schemars(range(min = 0.0, max = 10_000.0))]
    pub cool_w_per_k: f64,
    /// Highest power, in W.
    #[schemars(range(min = 0.0, max = 200_000.0))]
    pub maximum_w: f64,
}

impl ClimateModel {
    /// Power at an air temperature, in W.
    pub fn power_w(&self, air_temperature_k: f64) -> f64 {
        let cold = (self.heat_below_k - air_temperature_k).max(0.0) * self.heat_w_per_k;
        let hot = (air_temperature_k - self.cool_above_k).max(0.0) * self.cool_w_per_k;
        (cold + hot).min(self.maximum_w)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comfort_costs_nothing() {
        let climate = ClimateModel {
            heat_below_k: 288.15,
            heat_w_per_k: 150.0,
            cool_above_k: 295.15,
            cool_w_per_k: 100.0,
            maximum_w: 5000.0,
        };
        let at = |celsius: f64| climate.power_w(273.15 + celsius);
        assert_eq!(at(20.0), 0.0);
        assert!((at(5.0) - 1500.0).abs() < 1e-9 && (at(30.0) - 800.0).abs() < 1e-9);
        assert_eq!(at(-30.0), 5000.0);
    }
}

//! Emissions of carriers before they are in a truck: their factors, as a study gives them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Factors from the well to the wheel. What is absent is not counted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EmissionModel {
    /// Fuel, making it included, in kg of CO2 equivalents per L.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub fuel_well_to_wheel_kg_per_l: Option<f64>,
    /// Hydrogen, making it and bringing it included, in kg of CO2 equivalents per kg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub hydrogen_well_to_wheel_kg_per_kg: Option<f64>,
    /// Natural gas or biomethane, making it included, in kg of CO2 equivalents per kg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub methane_well_to_wheel_kg_per_kg: Option<f64>,
    /// Electricity at the meter, in kg of CO2 equivalents per kWh, fuels of the power plants and
    /// losses of the grid included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 5.0))]
    pub electricity_well_to_wheel_kg_per_kwh: Option<f64>,
    /// Electricity from the grid, in kg of CO2 equivalents per kWh: what power plants emit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 5.0))]
    pub electricity_generation_kg_per_kwh: Option<f64>,
    /// Share of the metered electricity that reaches the battery, where neither
    /// `cost.charging_efficiency` nor `charging.efficiency` says it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.3, max = 1.0))]
    pub charging_efficiency: Option<f64>,
}

impl EmissionModel {
    /// The factor of that key for what is filled in.
    pub(crate) fn well_to_wheel(&self, key: &str) -> Option<f64> {
        match key {
            "fuel_well_to_wheel_kg_per_l" => self.fuel_well_to_wheel_kg_per_l,
            "hydrogen_well_to_wheel_kg_per_kg" => self.hydrogen_well_to_wheel_kg_per_kg,
            "methane_well_to_wheel_kg_per_kg" => self.methane_well_to_wheel_kg_per_kg,
            _ => None,
        }
    }
}

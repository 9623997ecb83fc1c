//! Greenhouse gases beside the cost: from the tank, and from the well.
//!
//! From tank to wheel a trip emits the carbon dioxide of the fuel that it burns, a battery nothing.
//! From well to wheel it emits what its litres and its metered kWh are multiplied by here.

use super::costing::{depot_kwh, litres, public_kwh};
use crate::record::Record;
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
    /// Electricity at the meter, in kg of CO2 equivalents per kWh.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 5.0))]
    pub electricity_well_to_wheel_kg_per_kwh: Option<f64>,
}

/// What a completed trip emits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TripEmissions {
    /// Id of its cycle.
    pub cycle_id: u64,
    /// Distance, in km.
    pub km: f64,
    /// Payload times distance, in tkm.
    pub tkm: f64,
    /// From tank to wheel, in kg of CO2.
    pub tank_to_wheel_kg: f64,
    /// From well to wheel, in kg of CO2 equivalents; none without a factor of what it uses.
    pub well_to_wheel_kg: Option<f64>,
}

/// What a trip emits, with what it drove where its battery cut it short; none of one that stalled
/// or timed out.
pub fn of_trip(
    record: &Record,
    factors: Option<&EmissionModel>,
    charging_efficiency: Option<f64>,
) -> Option<TripEmissions> {
    if !record.outcome.counts() || !(record.distance_m > 0.0) {
        return None;
    }
    let km = record.distance_m / 1000.0;
    let well_to_wheel_kg = if record.battery_energy_j.is_some() {
        factors.and_then(|f| f.electricity_well_to_wheel_kg_per_kwh).zip(charging_efficiency).map(
            |(factor, efficiency)| {
                factor * (depot_kwh(record, efficiency) + public_kwh(record, efficiency))
            },
        )
    } else {
        factors.and_then(|f| f.fuel_well_to_wheel_kg_per_l).map(|f| f * litres(record))
    };
    Some(TripEmissions {
        cycle_id: record.cycle_id,
        km,
        tkm: km * record.payload_kg / 1000.0,
        tank_to_wheel_kg: record.co2_g_per_km.unwrap_or(0.0) / 1000.0 * km,
        well_to_wheel_kg,
    })
}

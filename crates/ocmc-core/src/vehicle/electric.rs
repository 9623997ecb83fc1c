//! A battery-electric powertrain: battery, motor, gears between motor and wheels, auxiliaries and charging.
//!
//! It takes the place of engine and gearbox in the exact prescribed-speed mode ([`crate::prescribed`]); the closed loop does not know it yet.

use super::battery::BatteryModel;
use super::climate::ClimateModel;
use super::motor::MotorModel;
use crate::distribution::Quantity;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A battery-electric powertrain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ElectricModel {
    /// Battery.
    pub battery: BatteryModel,
    /// Motor with inverter.
    pub motor: MotorModel,
    /// Ratios between motor and wheels, the axle included, from first to top gear.
    pub ratio: Vec<f64>,
    /// Efficiency of gears and axle, in both directions.
    pub gear_efficiency: f64,
    /// Power of the auxiliaries without heating and cooling, in W, from the battery.
    pub auxiliary_power_w: Quantity,
    /// Heating and cooling; absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub climate: Option<ClimateModel>,
    /// Charging at stops; absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub charging: Option<ChargingModel>,
}

/// Charging at stops of the mission.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChargingModel {
    /// Power of the charger at the terminals, in W.
    pub power_w: f64,
    /// State of charge below which a stop is used to charge.
    pub begin_below: f64,
    /// State of charge at which charging ends.
    pub end_at: f64,
    /// Shortest standstill that is used, in s.
    pub shortest_s: f64,
}

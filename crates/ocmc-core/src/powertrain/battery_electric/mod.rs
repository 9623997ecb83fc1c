//! A battery-electric powertrain: battery, motor, gears between motor and wheels, heating and
//! cooling, charging.
//!
//! Checked: the energy balance closes to 1e-9 in every cycle but those in which the battery is
//! overdrawn (`tests/it/electric.rs`), and the consumption on VECTO's LongHaul
//! (`tests/it/battery.rs`).

mod charge;
mod inverse;
mod powertrain;
mod temperature;

pub(in crate::powertrain) use inverse::InverseBatteryElectric;
pub use powertrain::BatteryState;

use super::component::battery::BatteryModel;
use super::component::climate::ClimateModel;
use super::component::motor::{Motor, MotorModel};
use crate::lanes::{Lanes, one};
use crate::powertrain::component::gearbox::{Gear, ShiftModel, validate_ratios};
use crate::validation::Problems;
use fearless_simd::prelude::*;
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
    #[schemars(inner(range(min = 0.1, max = 200.0)))]
    pub ratio: Vec<f64>,
    /// Efficiency of gears and axle, in both directions.
    #[schemars(range(min = 0.5, max = 1.0))]
    pub gear_efficiency: f64,
    /// Shifting; absent where there is one gear.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shift: Option<ElectricShiftModel>,
    /// Heating and cooling; absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub climate: Option<ClimateModel>,
}

/// When the gears behind a motor are shifted: by lines of its speed that rise with the pedal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ElectricShiftModel {
    /// Time without torque, in s.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub duration_s: f64,
    /// Shortest time from shift to shift, in s.
    #[schemars(range(min = 0.0, max = 60.0))]
    pub interval_s: f64,
    /// Motor speed after an upshift from which there is one, at zero pedal, in rad/s.
    #[schemars(range(min = 1.0, max = 5000.0))]
    pub up_speed_radps: f64,
    /// Its rise with the pedal, in rad/s.
    #[schemars(range(min = 0.0, max = 5000.0))]
    pub up_pedal_radps: f64,
    /// Motor speed below which there is a downshift, at zero pedal, in rad/s.
    #[schemars(range(min = 1.0, max = 5000.0))]
    pub down_speed_radps: f64,
    /// Its rise with the pedal, in rad/s.
    #[schemars(range(min = 0.0, max = 5000.0))]
    pub down_pedal_radps: f64,
}

/// A powertrain prepared for the hot loop.
#[derive(Clone, Debug)]
pub struct BatteryElectricPowertrain {
    /// Motor with the cells of its map.
    pub motor: Motor,
    /// The numbers as given.
    pub model: ElectricModel,
    /// Gears, from first to top.
    pub gears: Vec<Gear>,
}

/// A speed that no motor reaches, in rad/s.
const NEVER_RADPS: f64 = 1e9;
/// Share of the motor's highest speed at which a box shifts up in any case (judgement).
const OVERSPEED_SHARE: f64 = 0.95;
/// Power wanted after an upshift over what the road asks for (judgement, as of the diesel trucks).
const POWER_RESERVE: f64 = 1.19;
/// Shortest time from a shift to the opposite one, in s (judgement, as of the diesel trucks).
const OPPOSITE_INTERVAL_S: f64 = 10.0;
/// Time before a braking ramp without upshifts, in s (judgement, as of the diesel trucks).
const BEFORE_RAMP_S: f64 = 4.0;
/// Acceleration that an upshift leaves, in m/s² (judgement, as of the diesel trucks).
const LEAST_ACCELERATION_MPS2: f64 = 0.1;
/// Speed below which there is no shift, in m/s (judgement, as of the diesel trucks).
const SLOWEST_SHIFT_MPS: f64 = 0.5;

impl ElectricModel {
    /// A battery, a map and gears that fit in themselves.
    pub fn validate(&self, problems: &mut Problems) {
        problems.part("battery", |problems| self.battery.validate(problems));
        problems.part("motor", |problems| self.motor.validate(problems));
        problems.require(
            self.ratio.len() < 2 || self.shift.is_some(),
            "shift",
            "not there",
            "when to shift, where there is more than one gear",
        );
        validate_ratios(&self.ratio, problems);
        self.validate_losses(problems);
    }

    /// A motor that the battery can turn without a torque. What turned it otherwise would come from
    /// nowhere.
    fn validate_losses(&self, problems: &mut Problems) {
        // at any current, whatever the limit of its power
        let mut battery = BatteryModel { discharge_power_w: f64::INFINITY, ..self.battery.aged() };
        let factors = battery.thermal.iter().flat_map(|thermal| &thermal.resistance_factor);
        battery.resistance_ohm *= factors.flatten().copied().reduce(f64::max).unwrap_or(1.0);
        let most_w = battery.discharge_limit_w(battery.minimum_charge);
        let idle = self.motor.map_loss_w.iter().filter_map(|row| row.first());
        let idle_w = idle.copied().fold(0.0, f64::max);
        let allowed =
            format!("below {most_w:.0} without a torque: the least of what the battery can give");
        problems.require(idle_w < most_w, "motor.map_loss_w", idle_w, &allowed);
    }

    /// The gears over a wheel; nothing slips and there is no loss but the efficiency.
    pub fn gears(&self, wheel_radius_m: f64) -> Vec<Gear> {
        let gear = |&ratio: &f64| Gear {
            speed_ratio_per_m: ratio / wheel_radius_m,
            ratio,
            loss_share: 0.0,
            launches: false,
        };
        self.ratio.iter().map(gear).collect()
    }

    /// The strategy in the terms of an engine's gearbox: no clutch, no kick-down, a start in first
    /// gear.
    pub fn strategy(&self) -> ShiftModel {
        let shift = self.shift.as_ref();
        let shift_value =
            |value: fn(&ElectricShiftModel) -> f64, absent| shift.map_or(absent, value);
        ShiftModel {
            duration_s: shift_value(|s| s.duration_s, 0.0),
            interval_s: shift_value(|s| s.interval_s, 0.0),
            opposite_interval_s: OPPOSITE_INTERVAL_S,
            before_ramp_s: BEFORE_RAMP_S,
            minimum_acceleration_mps2: LEAST_ACCELERATION_MPS2,
            minimum_speed_mps: SLOWEST_SHIFT_MPS,
            up_speed_radps: shift_value(|s| s.up_speed_radps, NEVER_RADPS),
            up_pedal_radps: shift_value(|s| s.up_pedal_radps, 0.0),
            down_speed_radps: shift_value(|s| s.down_speed_radps, 0.0),
            down_pedal_radps: shift_value(|s| s.down_pedal_radps, 0.0),
            overspeed_radps: OVERSPEED_SHARE * self.motor.maximum_speed_radps,
            power_share: 1.0,
            power_reserve: POWER_RESERVE,
            most_steps: self.ratio.len() as u32,
            // a pedal that cannot be pressed
            kickdown_pedal: 2.0,
            kickdown_s: 1.0,
            kickdown_speed_radps: 0.0,
            start_gear: 1,
            steep_start_gear: 1,
            steep_slope: 1.0,
            skip_gears: 0,
            launch_gears: 0,
            launch_speed_radps: 0.0,
            open_share: 0.0,
        }
    }

    /// Force at the wheels for a motor torque, and what the gears take on the way, in N; `per_m`:
    /// motor speed for each m/s, in rad/m.
    pub fn wheel_and_lost_n(&self, per_m: f64, torque_nm: f64) -> [f64; 2] {
        self.wheel_and_lost_forces_n(one(per_m), one(torque_nm)).map(|forces| forces[0])
    }

    /// The same for vehicles: gears and axle take their share of what comes from the motor, and of
    /// what goes to it.
    #[inline(always)]
    pub fn wheel_and_lost_forces_n<S: Simd>(
        &self,
        per_m: Lanes<S>,
        torque_nm: Lanes<S>,
    ) -> [Lanes<S>; 2] {
        let plain = per_m * torque_nm;
        let brakes = plain.simd_lt(0.0);
        let inverse = 1.0 / self.gear_efficiency;
        [
            brakes.select(plain * inverse, plain * self.gear_efficiency),
            brakes.select(plain * (1.0 - inverse), plain * (1.0 - self.gear_efficiency)),
        ]
    }

    /// Torque with which the motor brakes at most of a braking force at the wheels, without sign,
    /// in Nm: only driven axles brake by it. `per_m`: motor speed for each m/s, in rad/m.
    pub fn braking_torque_nm(&self, per_m: f64, force_n: f64) -> f64 {
        self.braking_torques_nm(one(per_m), one(force_n))[0]
    }

    /// The same for vehicles.
    #[inline(always)]
    pub fn braking_torques_nm<S: Simd>(&self, per_m: Lanes<S>, force_n: Lanes<S>) -> Lanes<S> {
        force_n * (self.motor.brake_share * self.gear_efficiency) / per_m
    }
}

impl BatteryElectricPowertrain {
    /// Prepares a checked model.
    pub fn new(model: &ElectricModel, wheel_radius_m: f64) -> Self {
        let (motor, gears) = (Motor::new(&model.motor), model.gears(wheel_radius_m));
        let model = ElectricModel { battery: model.battery.aged(), ..model.clone() };
        Self { motor, model, gears }
    }

    /// The torque next to the wanted one, in Nm, at which the terminals' power stays within what
    /// the battery allows, auxiliaries included; towards zero, so that both have one sign.
    pub fn within_battery_nm(
        &self,
        charge: f64,
        auxiliary_w: f64,
        speed_radps: f64,
        torque_nm: f64,
    ) -> f64 {
        let battery = &self.model.battery;
        let most = battery.discharge_limit_w(charge) - auxiliary_w;
        let least = -battery.charge_limit_w(charge) - auxiliary_w;
        self.motor.within_nm(speed_radps, torque_nm, least, most)
    }
}

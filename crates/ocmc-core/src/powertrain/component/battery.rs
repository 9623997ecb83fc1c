//! Traction battery: state of charge, internal resistance, and the limits of its power.
//!
//! The store holds energy E = s E_full at the open-circuit voltage U(s) = U_empty + s (U_full −
//! U_empty). A power P at the terminals (positive: discharge) takes the current I of P = U I − R
//! I², I = 2 P / (U + √(U² − 4 R P)), a form without cancellation. The store loses U I, of which R
//! I² becomes heat. Discharge ends at the power limit or at U²/4R, whichever is lower; charging
//! fades out over the last share of the window, so that a full battery takes nothing.
//!
//! One resistance for both directions, and for all temperatures where the battery has none
//! ([`super::thermal`]). No diffusion: the slow part of a cell's voltage is not there.

use super::ageing::AgeingModel;
use super::thermal::ThermalModel;
use crate::distribution::Quantity;
use crate::lanes::{Bounded, Flags, Lanes, clip, one};
use crate::validation::Problems;
use fearless_simd::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A traction battery.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BatteryModel {
    /// Energy of the full store, in J.
    #[schemars(range(min = 1.0e6, max = 1.0e11), extend("usual" = [1e7, 1e10]))]
    pub capacity_j: f64,
    /// Open-circuit voltage of the empty battery, in V.
    #[schemars(range(min = 10.0, max = 5000.0))]
    pub empty_voltage_v: f64,
    /// Open-circuit voltage of the full battery, in V.
    #[schemars(range(min = 10.0, max = 5000.0))]
    pub full_voltage_v: f64,
    /// Internal resistance, in Ω.
    #[schemars(range(min = 1.0e-6, max = 10.0))]
    pub resistance_ohm: f64,
    /// Highest power of discharge at the terminals, in W.
    #[schemars(range(min = 1000.0, max = 1.0e7))]
    pub discharge_power_w: f64,
    /// Highest power of charging at the terminals, in W.
    #[schemars(range(min = 0.0, max = 1.0e7))]
    pub charge_power_w: f64,
    /// State of charge at which a truck stops.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub minimum_charge: f64,
    /// State of charge above which nothing is charged.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub maximum_charge: f64,
    /// Range below the highest state of charge over which charging fades out.
    #[schemars(range(min = 1.0e-4, max = 1.0))]
    pub charge_fade: f64,
    /// State of charge at departure.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub initial_charge: Quantity,
    /// How old it is; absent: new.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ageing: Option<AgeingModel>,
    /// Its temperature; absent: it does not matter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thermal: Option<ThermalModel>,
}

impl BatteryModel {
    /// Voltages and states of charge in order.
    pub fn validate(&self, problems: &mut Problems) {
        problems.require(
            self.empty_voltage_v < self.full_voltage_v * (1.0 + 1e-9),
            "empty_voltage_v",
            self.empty_voltage_v,
            "at most full_voltage_v",
        );
        problems.require(
            self.minimum_charge < self.maximum_charge,
            "minimum_charge",
            self.minimum_charge,
            "below maximum_charge",
        );
        let least = self.initial_charge.practical_range().0;
        problems.require(
            least > self.minimum_charge,
            "initial_charge",
            least,
            "above minimum_charge, at which a truck stops; a law as well, by its `lower`",
        );
        problems.part_if("ageing", self.ageing.as_ref(), AgeingModel::validate);
        problems.part_if("thermal", self.thermal.as_ref(), ThermalModel::validate);
    }

    /// As it is at its age: less energy, more resistance.
    #[must_use]
    pub fn aged(&self) -> Self {
        let mut aged = self.clone();
        if let Some(ageing) = &self.ageing {
            aged.capacity_j *= ageing.energy_share();
            aged.resistance_ohm *= ageing.resistance_factor();
        }
        aged
    }

    /// Open-circuit voltages at states of charge, in V.
    #[inline(always)]
    pub fn voltages_v<S: Simd>(&self, charge: Lanes<S>) -> Lanes<S> {
        let rise = self.full_voltage_v - self.empty_voltage_v;
        clip(charge, 0.0, 1.0) * rise + self.empty_voltage_v
    }

    /// Highest power of discharge at the terminals, in W.
    pub fn discharge_limit_w(&self, charge: f64) -> f64 {
        let charge = one(charge);
        self.discharge_limits_w(charge, &BatteryLimits::of(charge.simd, self))[0]
    }

    /// The same for vehicles.
    #[inline(always)]
    pub fn discharge_limits_w<S: Simd>(
        &self,
        charge: Lanes<S>,
        limits: &BatteryLimits<S>,
    ) -> Lanes<S> {
        let voltage = self.voltages_v(charge);
        (voltage * voltage * limits.quarter).at_most(limits.discharge_power)
    }

    /// Highest power of charging at the terminals, in W, as a positive number.
    pub fn charge_limit_w(&self, charge: f64) -> f64 {
        let charge = one(charge);
        self.charge_limits_w(charge, &BatteryLimits::of(charge.simd, self))[0]
    }

    /// The same for vehicles.
    #[inline(always)]
    pub fn charge_limits_w<S: Simd>(
        &self,
        charge: Lanes<S>,
        limits: &BatteryLimits<S>,
    ) -> Lanes<S> {
        let room = (self.maximum_charge - charge) * (1.0 / self.charge_fade);
        clip(room, 0.0, 1.0) * limits.charge_power
    }

    /// Flow of the store at a power at the terminals, in W; beyond the highest power the current
    /// stays at its peak.
    pub fn flow(&self, charge: f64, power_w: f64) -> BatteryFlow {
        let charge = one(charge);
        let limits = BatteryLimits::of(charge.simd, self);
        let (store, loss) = self.flows(charge, one(power_w), &limits);
        BatteryFlow { store_w: store[0], loss_w: loss[0] }
    }

    /// The same for vehicles: what the stores lose, and the heat, in W.
    #[inline(always)]
    pub fn flows<S: Simd>(
        &self,
        charge: Lanes<S>,
        power_w: Lanes<S>,
        limits: &BatteryLimits<S>,
    ) -> (Lanes<S>, Lanes<S>) {
        let voltage = self.voltages_v(charge);
        let under = voltage * voltage - power_w * (limits.resistance * 4.0);
        let current = power_w * 2.0 / (voltage + under.at_least(0.0).sqrt());
        (voltage * current, current * current * limits.resistance)
    }

    /// For how long of a time, in s, a truck at rest draws from a store that loses a power, in W:
    /// it stops at the lowest charge.
    pub fn lasts_s(&self, charge: f64, store_w: f64, time_s: f64) -> f64 {
        let left_j = (charge - self.minimum_charge).max(0.0) * self.capacity_j;
        if store_w * time_s > left_j { left_j / store_w } else { time_s }
    }

    /// Whether a power at the terminals, in W, is more than the battery has at any current.
    pub fn is_overdrawn(&self, charge: f64, power_w: f64) -> bool {
        let charge = one(charge);
        self.overdrawn(charge, one(power_w), &BatteryLimits::of(charge.simd, self)).test(0)
    }

    /// The same for vehicles.
    #[inline(always)]
    pub fn overdrawn<S: Simd>(
        &self,
        charge: Lanes<S>,
        power_w: Lanes<S>,
        limits: &BatteryLimits<S>,
    ) -> Flags<S> {
        let voltage = self.voltages_v(charge);
        (voltage * voltage).simd_lt(power_w * (limits.resistance * 4.0))
    }
}

/// Limits of power that batteries can give and take as they are now, lane by lane.
#[derive(Clone, Copy, Debug)]
pub struct BatteryLimits<S: Simd> {
    /// Internal resistance, in Ω.
    resistance: Lanes<S>,
    /// A little less than a quarter of its inverse, in 1/Ω: U²/4R is the most that there is.
    quarter: Lanes<S>,
    /// Highest power of discharge at the terminals, in W.
    discharge_power: Lanes<S>,
    /// Highest power of charging at the terminals, in W.
    charge_power: Lanes<S>,
}

impl<S: Simd> BatteryLimits<S> {
    /// Limits of one battery in all lanes.
    #[inline(always)]
    pub fn of(simd: S, battery: &BatteryModel) -> Self {
        let all = |value| Lanes::splat(simd, value);
        Self {
            resistance: all(battery.resistance_ohm),
            quarter: all(BELOW_QUARTER / battery.resistance_ohm),
            discharge_power: all(battery.discharge_power_w),
            charge_power: all(battery.charge_power_w),
        }
    }

    /// Sets the highest powers of discharge at the terminals, in W.
    #[inline(always)]
    pub fn set_discharge_power(&mut self, power_w: Lanes<S>) {
        self.discharge_power = power_w;
    }

    /// Puts resistance, in Ω, and the powers that a battery gives and takes, in W, into a lane.
    pub fn set(&mut self, lane: usize, [resistance_ohm, give_w, take_w]: [f64; 3]) {
        self.resistance[lane] = resistance_ohm;
        self.quarter[lane] = BELOW_QUARTER / resistance_ohm;
        self.discharge_power[lane] = give_w;
        self.charge_power[lane] = take_w;
    }
}

/// A little less than a quarter: at U²/4R the current would double for nothing.
const BELOW_QUARTER: f64 = 0.249;

/// Flow of the store at a power at the terminals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatteryFlow {
    /// Power that the store loses, U I, in W; negative while it is charged.
    pub store_w: f64,
    /// Heat, R I², in W.
    pub loss_w: f64,
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn pack() -> BatteryModel {
        BatteryModel {
            capacity_j: 540.0 * 3.6e6,
            empty_voltage_v: 600.0,
            full_voltage_v: 720.0,
            resistance_ohm: 0.05,
            discharge_power_w: 500e3,
            charge_power_w: 300e3,
            minimum_charge: 0.1,
            maximum_charge: 0.9,
            charge_fade: 0.05,
            initial_charge: Quantity::Number(0.9),
            ageing: None,
            thermal: None,
        }
    }

    #[test]
    fn the_circuit_is_kirchhoffs() {
        let pack = pack();
        for charge in [0.1, 0.5, 0.9] {
            for power in [-300e3, -10.0, 0.0, 10.0, 150e3, 500e3] {
                let flow = pack.flow(charge, power);
                let voltage = 600.0 + 120.0 * charge;
                let current = flow.store_w / voltage;
                // P = U I − R I²
                let terminals = voltage * current - 0.05 * current * current;
                assert!(
                    (terminals - power).abs() < 1e-9 * power.abs().max(1.0),
                    "{charge} {power}"
                );
                assert!((flow.loss_w - 0.05 * current * current).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_round_trip_loses_twice_the_resistance() {
        // 100 kW out and in at 660 V: I ≈ 151.5 A, R I² = 1.15 kW each way
        let pack = pack();
        let out = pack.flow(0.5, 100e3).loss_w;
        let back = pack.flow(0.5, -100e3).loss_w;
        let plain = 0.05 * (100e3f64 / 660.0).powi(2);
        assert!((out / plain - 1.0).abs() < 0.05 && (back / plain - 1.0).abs() < 0.05);
        assert!(out > plain && back < plain);
    }

    #[test]
    fn limits_fade_and_nothing_is_not_a_number() {
        let pack = pack();
        assert_eq!(pack.charge_limit_w(0.9), 0.0);
        assert_eq!(pack.charge_limit_w(0.95), 0.0);
        assert!((pack.charge_limit_w(0.875) - 150e3).abs() < 1e-6);
        assert_eq!(pack.charge_limit_w(0.3), 300e3);
        let weak = BatteryModel { resistance_ohm: 1.0, ..pack };
        let limit = weak.discharge_limit_w(0.0);
        assert!((limit - 0.249 * 600.0 * 600.0).abs() < 1e-6);
        for charge in [-1.0, 0.0, 2.0] {
            for power in [-1e7, 0.0, 1e7] {
                let flow = weak.flow(charge, power);
                assert!(flow.store_w.is_finite() && flow.loss_w.is_finite());
                // U²/4R is 90 kW empty and 130 kW full
                assert_eq!(weak.is_overdrawn(charge, power), power > 0.0);
            }
        }
        assert!(!weak.is_overdrawn(0.0, 89.9e3) && weak.is_overdrawn(0.0, 90.1e3));
    }
}

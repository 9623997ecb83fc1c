//! A battery-electric powertrain in the backward mode: the gear with the least draw, braking by the
//! motor as far as motor and battery reach.

use super::BatteryElectricPowertrain;
use crate::energy::ledger::{Ledger, Mode, Term};
use crate::powertrain::{
    InversePowertrain, InverseStep, Powertrain, SpeedStep, StepCost, TruckInputs,
};
use crate::record::Record;

/// The powertrain and the state of its battery.
#[derive(Clone, Debug)]
pub(in crate::powertrain) struct InverseBatteryElectric<'a> {
    powertrain: &'a BatteryElectricPowertrain,
    auxiliary_w: f64,
    /// State of charge.
    charge: f64,
    gear: usize,
    n_shifts: u32,
    depleted_s: f64,
}

/// How a gear carries a step.
#[derive(Clone, Copy)]
struct Fit {
    gear: usize,
    motor_nm: f64,
    wheel_n: f64,
    lost_n: f64,
    terminals_w: f64,
    limited: bool,
}

impl<'a> InverseBatteryElectric<'a> {
    pub(in crate::powertrain) fn new(
        powertrain: &'a BatteryElectricPowertrain,
        truck: &TruckInputs,
    ) -> Self {
        Self {
            powertrain,
            auxiliary_w: truck.auxiliary_power_w,
            charge: truck.initial_charge.unwrap_or(0.0),
            gear: 0,
            n_shifts: 0,
            depleted_s: 0.0,
        }
    }

    /// State of charge.
    pub(in crate::powertrain) fn charge(&self) -> f64 {
        self.charge
    }

    /// Power of the auxiliaries from here on, in W, less what another source gives.
    pub(in crate::powertrain) fn set_auxiliary_w(&mut self, auxiliary_w: f64) {
        self.auxiliary_w = auxiliary_w;
    }

    /// Motor speed for each m/s, in rad/m.
    fn per_m(&self, gear: usize) -> f64 {
        self.powertrain.gears[gear].speed_ratio_per_m
    }

    fn fit(&self, gear: usize, step: &SpeedStep, force_n: f64) -> Option<Fit> {
        let model = &self.powertrain.model;
        let motor = &model.motor;
        let per_m = self.per_m(gear);
        let speed = per_m * step.mean_mps();
        if speed > motor.maximum_speed_radps && gear + 1 < model.ratio.len() {
            return None;
        }
        let wanted = if force_n >= 0.0 {
            force_n / (per_m * model.gear_efficiency)
        } else {
            -model.braking_torque_nm(per_m, -force_n)
        };
        let lowest = -motor.brake_limit_nm(speed, step.mean_mps());
        let able = wanted.max(lowest).min(motor.drive_limit_nm(speed));
        let motor_nm =
            self.powertrain.within_battery_nm(self.charge, self.auxiliary_w, speed, able);
        let [wheel_n, lost_n] = model.wheel_and_lost_n(per_m, motor_nm);
        let terminals_w = self.powertrain.motor.terminals_w(speed, motor_nm) + self.auxiliary_w;
        // a brake that the motor does not serve is the service brakes'
        let limited = force_n >= 0.0 && motor_nm < wanted;
        Some(Fit { gear, motor_nm, wheel_n, lost_n, terminals_w, limited })
    }

    /// The gear that gives the most of what is wanted, among equals the one with the least draw;
    /// none of it at a standstill.
    fn choose(&self, step: &SpeedStep, wanted: f64) -> Fit {
        let idle = Fit {
            gear: self.gear,
            motor_nm: 0.0,
            wheel_n: 0.0,
            lost_n: 0.0,
            terminals_w: self.auxiliary_w,
            limited: false,
        };
        if step.distance_m() <= 0.0 {
            return idle;
        }
        let better = |a: &Fit, b: &Fit| {
            let short = |fit: &Fit| (wanted - fit.wheel_n).abs().max(1e-6 * wanted.abs());
            let closer = short(b).total_cmp(&short(a));
            let sparing = b.terminals_w.total_cmp(&a.terminals_w);
            if (short(a) - short(b)).abs() > 1e-3 * wanted.abs() { closer } else { sparing }
        };
        let gears = 0..self.powertrain.gears.len();
        let fits = gears.filter_map(|gear| self.fit(gear, step, wanted));
        fits.max_by(better).unwrap_or(idle)
    }
}

impl InversePowertrain for InverseBatteryElectric<'_> {
    fn terms(&self) -> &'static [Term] {
        BatteryElectricPowertrain::TERMS
    }

    fn stores(&self) -> &'static [Term] {
        &[Term::Battery]
    }

    /// At the state of charge that the battery has now.
    fn cost(&self, step: &SpeedStep, force_n: f64, _shaft_radps: f64) -> StepCost {
        let chosen = self.choose(step, force_n);
        let flow = self.powertrain.model.battery.flow(self.charge, chosen.terminals_w);
        let energy_j = flow.store_w * step.dt_s;
        StepCost { energy_j, wheel_n: chosen.wheel_n, ..StepCost::default() }
    }

    fn step(&mut self, step: &SpeedStep, force_n: f64, ledger: &mut Ledger<f64>) -> InverseStep {
        let model = &self.powertrain.model;
        let battery = &model.battery;
        let standing = step.distance_m() <= 0.0;
        let empty = self.charge <= battery.minimum_charge;
        if empty {
            self.depleted_s += step.dt_s;
        }
        let wanted = if standing || (empty && force_n > 0.0) { 0.0 } else { force_n };
        let chosen = self.choose(step, wanted);
        if chosen.gear != self.gear {
            self.gear = chosen.gear;
            self.n_shifts += 1;
        }
        let flow = battery.flow(self.charge, chosen.terminals_w);
        let overdrawn = battery.is_overdrawn(self.charge, chosen.terminals_w);
        ledger[Term::Battery] += flow.store_w * step.dt_s;
        ledger[Term::BatteryLoss] += flow.loss_w * step.dt_s;
        self.charge -= flow.store_w * step.dt_s / battery.capacity_j;
        let per_m = self.per_m(chosen.gear);
        let shaft_w = chosen.motor_nm * per_m * step.mean_mps();
        let motor_loss_w = chosen.terminals_w - self.auxiliary_w - shaft_w;
        ledger[Term::MotorLoss] += motor_loss_w * step.dt_s;
        if chosen.motor_nm < 0.0 {
            let back_w = (self.auxiliary_w - chosen.terminals_w).max(0.0);
            ledger[Term::Regenerated] += back_w * step.dt_s;
        }
        ledger[Term::Crankshaft] += shaft_w * step.dt_s;
        ledger[Term::Auxiliary] += self.auxiliary_w * step.dt_s;
        ledger[Term::Transmission] += chosen.lost_n * step.distance_m();
        let covers = || model.motor.map_covers(per_m * step.mean_mps(), chosen.motor_nm);
        if overdrawn || !standing && !covers() {
            ledger[Term::OutsideMap] += (flow.store_w * step.dt_s).max(0.0);
        }
        InverseStep {
            wheel_n: chosen.wheel_n,
            engine_brake_reach_n: 0.0,
            limited: chosen.limited || (empty && force_n > 0.0),
            shaft_j: chosen.motor_nm * self.per_m(chosen.gear) * step.distance_m(),
        }
    }

    /// The motor's inertia in its top gear is small beside the truck; it moves with the mass.
    fn rotating_mass_kg(&self) -> f64 {
        let top = self.per_m(self.powertrain.gears.len() - 1);
        self.powertrain.model.motor.inertia_kgm2 * top * top
    }

    fn n_shifts(&self) -> u32 {
        self.n_shifts
    }

    fn depleted_s(&self) -> f64 {
        self.depleted_s
    }

    fn record(&self, ledger: &Ledger<f64>, record: &mut Record) {
        BatteryElectricPowertrain::record_battery(self.charge, ledger, Mode::Followed, record);
    }
}

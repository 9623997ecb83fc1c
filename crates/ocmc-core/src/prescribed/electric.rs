//! A battery-electric driveline in prescribed speed: the gear with the least draw, braking by the motor as far as motor and battery reach.

use super::drive_cycle::CycleStep;
use super::driveline::DrivelineStep;
use crate::powertrain::battery_electric::BatteryElectricPowertrain;

/// The driveline and the state of its battery.
#[derive(Clone, Debug)]
pub(super) struct ElectricDriveline<'a> {
    drive: &'a BatteryElectricPowertrain,
    wheel_radius_m: f64,
    auxiliary_w: f64,
    /// State of charge.
    pub(super) charge: f64,
    gear: usize,
    pub(super) n_shifts: u32,
    /// Sums, in J.
    pub(super) electric: ElectricSums,
}

/// What a battery-electric driveline adds up, in J unless a name says otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ElectricSums {
    /// Energy that the store has lost, charging at stops not counted.
    pub store_j: f64,
    /// Heat in the battery, charging at stops not counted.
    pub battery_loss_j: f64,
    /// Losses of motor and inverter.
    pub motor_loss_j: f64,
    /// Energy that braking brought back to the terminals.
    pub regenerated_j: f64,
    /// Energy charged at stops, in the store.
    pub charged_j: f64,
    /// Heat in the battery while it was charged at stops.
    pub charging_loss_j: f64,
    /// Time after the battery had run empty, in s.
    pub depleted_s: f64,
    /// State of charge at the end.
    pub final_charge: f64,
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

impl<'a> ElectricDriveline<'a> {
    pub(super) fn new(
        drive: &'a BatteryElectricPowertrain,
        wheel_radius_m: f64,
        auxiliary_w: f64,
        charge: f64,
    ) -> Self {
        Self {
            drive,
            wheel_radius_m,
            auxiliary_w,
            charge,
            gear: 0,
            n_shifts: 0,
            electric: ElectricSums { final_charge: charge, ..ElectricSums::default() },
        }
    }

    /// Motor inertia in its lowest gear's place is small beside the truck; it moves with the mass, in kg.
    pub(super) fn rotating_mass_kg(&self) -> f64 {
        let model = &self.drive.model;
        let top = model.ratio[model.ratio.len() - 1] / self.wheel_radius_m;
        model.motor.inertia_kgm2 * top * top
    }

    fn fit(&self, gear: usize, step: &CycleStep, force_n: f64) -> Option<Fit> {
        let model = &self.drive.model;
        let motor = &model.motor;
        let per_m = model.ratio[gear] / self.wheel_radius_m;
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
        let motor_nm = self.drive.within_battery_nm(self.charge, self.auxiliary_w, speed, able);
        let [wheel_n, lost_n] = model.wheel_and_lost_n(per_m, motor_nm);
        let terminals_w = self.drive.motor.terminals_w(speed, motor_nm) + self.auxiliary_w;
        // a brake that the motor does not serve is the service brakes'
        let limited = force_n >= 0.0 && motor_nm < wanted;
        Some(Fit { gear, motor_nm, wheel_n, lost_n, terminals_w, limited })
    }

    /// Carries one step with that force wanted at the wheels.
    pub(super) fn step(&mut self, step: &CycleStep, force_n: f64) -> DrivelineStep {
        let model = &self.drive.model;
        let battery = &model.battery;
        let standing = step.distance_m() <= 0.0;
        let empty = self.charge <= battery.minimum_charge;
        if empty {
            self.electric.depleted_s += step.dt_s;
        }
        let wanted = if standing || (empty && force_n > 0.0) { 0.0 } else { force_n };
        let fits = (0..model.ratio.len()).filter_map(|gear| self.fit(gear, step, wanted));
        let better = |a: &Fit, b: &Fit| {
            // the most of what is wanted first, then the least draw
            let short = |fit: &Fit| (wanted - fit.wheel_n).abs().max(1e-6 * wanted.abs());
            let closer = short(b).total_cmp(&short(a));
            let sparing = b.terminals_w.total_cmp(&a.terminals_w);
            if (short(a) - short(b)).abs() > 1e-3 * wanted.abs() { closer } else { sparing }
        };
        let idle = Fit {
            gear: self.gear,
            motor_nm: 0.0,
            wheel_n: 0.0,
            lost_n: 0.0,
            terminals_w: self.auxiliary_w,
            limited: false,
        };
        let chosen = if standing { idle } else { fits.max_by(better).unwrap_or(idle) };
        if chosen.gear != self.gear {
            self.gear = chosen.gear;
            self.n_shifts += 1;
        }
        let flow = battery.flow(self.charge, chosen.terminals_w);
        let overdrawn = battery.is_overdrawn(self.charge, chosen.terminals_w);
        let sums = &mut self.electric;
        sums.store_j += flow.store_w * step.dt_s;
        sums.battery_loss_j += flow.loss_w * step.dt_s;
        self.charge -= flow.store_w * step.dt_s / battery.capacity_j;
        let per_m = model.ratio[chosen.gear] / self.wheel_radius_m;
        let shaft_w = chosen.motor_nm * per_m * step.mean_mps();
        let motor_loss_w = chosen.terminals_w - self.auxiliary_w - shaft_w;
        sums.motor_loss_j += motor_loss_w * step.dt_s;
        if chosen.motor_nm < 0.0 {
            sums.regenerated_j += (self.auxiliary_w - chosen.terminals_w).max(0.0) * step.dt_s;
        }
        if standing && let Some(charging) = &model.charging {
            let charged = battery.charge_at_rest(charging, self.charge, step.dt_s);
            sums.charged_j += charged.gained_j;
            sums.charging_loss_j += charged.loss_j;
            self.charge += charged.gained_j / battery.capacity_j;
        }
        self.electric.final_charge = self.charge;
        DrivelineStep {
            wheel_n: chosen.wheel_n,
            crankshaft_j: shaft_w * step.dt_s,
            auxiliary_j: self.auxiliary_w * step.dt_s,
            transmission_j: chosen.lost_n * step.distance_m(),
            limited: chosen.limited || (empty && force_n > 0.0),
            outside_map: overdrawn
                || !standing && !model.motor.map_covers(per_m * step.mean_mps(), chosen.motor_nm),
            ..DrivelineStep::default()
        }
    }
}

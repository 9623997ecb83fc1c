//! A battery-electric driveline in prescribed speed: the gear with the least draw, braking by the motor as far as motor and battery reach.

use super::drive_cycle::DriveStep;
use super::driveline::DrivelineStep;
use crate::vehicle::electric::ElectricModel;

/// The driveline and the state of its battery.
#[derive(Clone, Debug)]
pub(super) struct ElectricDriveline<'a> {
    model: &'a ElectricModel,
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
    /// Heat in the battery, charging at stops included.
    pub battery_loss_j: f64,
    /// Losses of motor and inverter.
    pub motor_loss_j: f64,
    /// Energy that braking brought back to the terminals.
    pub regenerated_j: f64,
    /// Energy charged at stops, in the store.
    pub charged_j: f64,
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
    terminals_w: f64,
    limited: bool,
}

impl<'a> ElectricDriveline<'a> {
    pub(super) fn new(
        model: &'a ElectricModel,
        wheel_radius_m: f64,
        auxiliary_w: f64,
        charge: f64,
    ) -> Self {
        Self {
            model,
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
        let top = self.model.ratio[self.model.ratio.len() - 1] / self.wheel_radius_m;
        self.model.motor.inertia_kgm2 * top * top
    }

    fn fit(&self, gear: usize, step: &DriveStep, force_n: f64) -> Option<Fit> {
        let motor = &self.model.motor;
        let per_m = self.model.ratio[gear] / self.wheel_radius_m;
        let speed = per_m * step.mean_mps();
        if speed > motor.maximum_speed_radps && gear + 1 < self.model.ratio.len() {
            return None;
        }
        let efficiency = self.model.gear_efficiency;
        let (motor_nm, limited) = if force_n >= 0.0 {
            let wanted = force_n / (per_m * efficiency);
            let limit = motor.drive_limit_nm(speed);
            (wanted.min(limit), wanted > limit)
        } else {
            // of a wheel force that brakes, gears and axle take their share before the motor
            let wanted = -force_n * motor.brake_share * efficiency / per_m;
            (-wanted.min(motor.brake_limit_nm(speed, step.mean_mps())), false)
        };
        let (motor_nm, limited) = self.within_battery(speed, motor_nm, limited);
        let wheel_n = if motor_nm >= 0.0 {
            motor_nm * per_m * efficiency
        } else {
            motor_nm * per_m / efficiency
        };
        let terminals_w = motor.terminals_w(speed, motor_nm) + self.auxiliary_w;
        Some(Fit { gear, motor_nm, wheel_n, terminals_w, limited })
    }

    /// The torque that the battery allows.
    fn within_battery(&self, speed: f64, motor_nm: f64, limited: bool) -> (f64, bool) {
        let (motor, battery) = (&self.model.motor, &self.model.battery);
        let most = battery.discharge_limit_w(self.charge);
        let least = -battery.charge_limit_w(self.charge);
        let draw = |torque: f64| motor.terminals_w(speed, torque) + self.auxiliary_w;
        let drawn = draw(motor_nm);
        if drawn <= most && drawn >= least.min(draw(0.0)) {
            return (motor_nm, limited);
        }
        // the draw rises with the torque: halve the range until the limit is met
        let goal = if drawn > most { most } else { least };
        let (mut inside, mut outside) = (0.0, motor_nm);
        for _ in 0..40 {
            let middle = 0.5 * (inside + outside);
            let fits = if motor_nm > 0.0 { draw(middle) <= goal } else { draw(middle) >= goal };
            if fits { inside = middle } else { outside = middle }
        }
        (inside, limited || motor_nm > 0.0)
    }

    /// Carries one step with that force wanted at the wheels.
    pub(super) fn step(&mut self, step: &DriveStep, force_n: f64) -> DrivelineStep {
        let battery = &self.model.battery;
        let standing = step.distance_m() <= 0.0;
        let empty = self.charge <= battery.minimum_charge;
        if empty {
            self.electric.depleted_s += step.dt_s;
        }
        let wanted = if standing || (empty && force_n > 0.0) { 0.0 } else { force_n };
        let fits = (0..self.model.ratio.len()).filter_map(|gear| self.fit(gear, step, wanted));
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
            terminals_w: self.auxiliary_w,
            limited: false,
        };
        let chosen = if standing { idle } else { fits.max_by(better).unwrap_or(idle) };
        if chosen.gear != self.gear {
            self.gear = chosen.gear;
            self.n_shifts += 1;
        }
        let flow = battery.flow(self.charge, chosen.terminals_w);
        let sums = &mut self.electric;
        sums.store_j += flow.store_w * step.dt_s;
        sums.battery_loss_j += flow.loss_w * step.dt_s;
        self.charge -= flow.store_w * step.dt_s / battery.capacity_j;
        let per_m = self.model.ratio[chosen.gear] / self.wheel_radius_m;
        let shaft_w = chosen.motor_nm * per_m * step.mean_mps();
        let motor_loss_w = chosen.terminals_w - self.auxiliary_w - shaft_w;
        sums.motor_loss_j += motor_loss_w * step.dt_s;
        if chosen.motor_nm < 0.0 {
            sums.regenerated_j += (self.auxiliary_w - chosen.terminals_w).max(0.0) * step.dt_s;
        }
        if standing {
            self.charge_at_rest(step.dt_s);
        }
        self.electric.final_charge = self.charge;
        DrivelineStep {
            wheel_n: chosen.wheel_n,
            crankshaft_j: shaft_w * step.dt_s,
            auxiliary_j: self.auxiliary_w * step.dt_s,
            transmission_j: shaft_w * step.dt_s - chosen.wheel_n * step.distance_m(),
            limited: chosen.limited || (empty && force_n > 0.0),
            ..DrivelineStep::default()
        }
    }

    /// Charges during one step at rest.
    fn charge_at_rest(&mut self, dt_s: f64) {
        let Some(charging) = &self.model.charging else { return };
        let battery = &self.model.battery;
        if dt_s < charging.shortest_s || self.charge >= charging.begin_below {
            return;
        }
        // minute by minute: the limit falls as the battery fills
        let mut left_s = dt_s;
        while left_s > 0.0 && self.charge < charging.end_at {
            let slice_s = left_s.min(60.0);
            let power_w = charging.power_w.min(battery.charge_limit_w(self.charge));
            let flow = battery.flow(self.charge, -power_w);
            let room_j = (charging.end_at - self.charge) * battery.capacity_j;
            let gained_j = (-flow.store_w * slice_s).min(room_j);
            let share = if flow.store_w < 0.0 { gained_j / (-flow.store_w * slice_s) } else { 0.0 };
            self.electric.charged_j += gained_j;
            self.electric.battery_loss_j += flow.loss_w * slice_s * share;
            self.charge += gained_j / battery.capacity_j;
            left_s -= slice_s;
            if share == 0.0 {
                return;
            }
        }
    }
}

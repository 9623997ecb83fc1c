//! From the force at the wheels back to what the engine burns, in one step of prescribed speed.
//!
//! The same functions serve here and in the closed loop: gearbox and axle losses, engine curves and map. Here they are run backwards.

use super::drive_cycle::CycleStep;
use crate::powertrain::efficiency::EfficiencyCurve;
use crate::vehicle::{DieselPowertrain, Vehicle, VehicleParameters};

/// What the driveline did in one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct DrivelineStep {
    /// Force of the driveline at the wheels, in N; less than was asked for where the engine is at its limit, more where brakes have
    /// to help.
    pub(super) wheel_n: f64,
    /// Work of the engine at the crankshaft, in J.
    pub(super) crankshaft_j: f64,
    /// Work of the auxiliaries, in J.
    pub(super) auxiliary_j: f64,
    /// Loss of the slipping clutch, in J.
    pub(super) clutch_j: f64,
    /// Loss of gearbox, retarder and axle, in J.
    pub(super) transmission_j: f64,
    /// Kinetic energy of the engine lost in jumps of its speed, signed, in J.
    pub(super) shift_j: f64,
    /// Energy of the fuel, in J.
    pub(super) fuel_j: f64,
    /// Largest force of the engine brake at the wheels, in N.
    pub(super) engine_brake_reach_n: f64,
    /// Engine speed at the end, in rad/s.
    pub(super) engine_radps: f64,
    /// Whether the engine is at its limit.
    pub(super) limited: bool,
    /// Whether it is beyond the points of its map.
    pub(super) outside_map: bool,
}

/// A gearbox behind an engine with its map, and where both are.
#[derive(Clone, Debug)]
pub(super) struct GearedDriveline<'a> {
    powertrain: &'a VehicleParameters,
    diesel: &'a DieselPowertrain,
    auxiliary_power_w: f64,
    fuel_factor: f64,
    gear: usize,
    engine_radps: f64,
    /// Shifts so far.
    pub(super) n_shifts: u32,
}

/// How a gear would carry a step.
#[derive(Clone, Copy)]
struct Fit {
    gear: usize,
    /// Engine speed at the mean vehicle speed, in rad/s.
    engine_radps: f64,
    closed: bool,
    /// Whether the clutch slips (otherwise, not closed, it is open).
    slips: bool,
    /// Torque wanted at the gearbox's input, in Nm.
    gearbox_nm: f64,
    /// Torque wanted of the engine, in Nm.
    engine_nm: f64,
    full_nm: f64,
    drag_nm: f64,
}

impl<'a> GearedDriveline<'a> {
    pub(super) fn new(
        powertrain: &'a VehicleParameters,
        diesel: &'a DieselPowertrain,
        vehicle: &Vehicle,
    ) -> Self {
        let engine_radps = diesel.engine_model.idle_speed_radps;
        Self {
            powertrain,
            diesel,
            auxiliary_power_w: vehicle.auxiliary_power_w,
            fuel_factor: vehicle.fuel_factor,
            gear: powertrain.shift.start_gear as usize - 1,
            engine_radps,
            n_shifts: 0,
        }
    }

    /// Kinetic energy of the engine, in J.
    pub(super) fn kinetic_j(&self) -> f64 {
        0.5 * self.diesel.engine_model.inertia_kgm2 * self.engine_radps * self.engine_radps
    }

    /// Axle ratio over wheel radius, in 1/m.
    fn axle_per_m(&self) -> f64 {
        self.diesel.gearbox.axle_ratio / self.powertrain.model.wheel_radius_m
    }

    fn fit(&self, gear: usize, step: &CycleStep, force_n: f64) -> Fit {
        let (model, engine) = (&self.diesel.engine_model, &self.diesel.engine);
        let shift = &self.powertrain.shift;
        let here = &self.powertrain.gears[gear];
        let speed_radps = here.speed_ratio_per_m * step.mean_mps();
        let gearbox_nm = self.diesel.gearbox.input_torque_nm(here, self.axle_per_m(), force_n);
        let slow = shift.open_share * model.idle_speed_radps;
        let slips = here.launches && speed_radps < shift.launch_speed_radps && gearbox_nm > 0.0;
        let closed = !slips && speed_radps >= slow;
        let engine_radps = if closed {
            speed_radps
        } else if slips {
            shift.launch_speed_radps
        } else {
            model.idle_speed_radps
        };
        // the engine's own inertia has to be turned up, too
        let inertia_nm = if closed {
            model.inertia_kgm2 * here.speed_ratio_per_m * step.acceleration_mps2()
        } else {
            0.0
        };
        let passes = if closed || slips { gearbox_nm } else { 0.0 };
        Fit {
            gear,
            engine_radps,
            closed,
            slips,
            gearbox_nm,
            engine_nm: passes + inertia_nm + self.auxiliary_power_w / engine_radps,
            full_nm: engine.full_load_nm(engine_radps),
            drag_nm: engine.drag_nm(engine_radps),
        }
    }

    /// The highest gear above the upshift line that has the torque; where there is none, the highest that has it; where none has it,
    /// the strongest. The gear that is engaged stays while it is above the downshift line and has the torque.
    fn choose(&self, step: &CycleStep, force_n: f64) -> Fit {
        let shift = &self.powertrain.shift;
        let fits: Vec<Fit> =
            (0..self.powertrain.gears.len()).map(|gear| self.fit(gear, step, force_n)).collect();
        let now = fits[self.gear];
        let strong = |fit: &Fit| fit.engine_nm <= shift.power_share * fit.full_nm;
        let turns = |fit: &Fit| fit.engine_radps <= shift.overspeed_radps;
        let drives = |fit: &Fit| fit.closed || fit.slips || fit.gearbox_nm <= 0.0;
        let fast = |fit: &Fit| fit.engine_radps >= shift.up_speed_radps;
        let fast_enough = |fit: &Fit| fit.engine_radps >= shift.down_speed_radps;
        if now.closed && fast_enough(&now) && strong(&now) && turns(&now) && !fast(&now) {
            return now;
        }
        let highest =
            |good: &dyn Fn(&Fit) -> bool| fits.iter().rev().find(|fit| good(fit)).copied();
        highest(&|fit| fit.closed && fast(fit) && strong(fit) && turns(fit))
            .or_else(|| {
                highest(&|fit| drives(fit) && strong(fit) && turns(fit) && fit.gear == self.gear)
            })
            .or_else(|| highest(&|fit| drives(fit) && strong(fit) && turns(fit)))
            .unwrap_or_else(|| {
                let power =
                    |fit: &Fit| if drives(fit) { fit.full_nm * fit.engine_radps } else { -1.0 };
                let able = fits.iter().filter(|fit| turns(fit));
                let best = able.max_by(|a, b| power(a).total_cmp(&power(b)));
                *best.unwrap_or(&fits[fits.len() - 1])
            })
    }

    /// Carries one step with that force wanted at the wheels.
    pub(super) fn step(&mut self, step: &CycleStep, force_n: f64) -> DrivelineStep {
        let fit = if step.distance_m() > 0.0 {
            self.choose(step, force_n)
        } else {
            Fit { closed: false, slips: false, ..self.fit(self.gear, step, -1.0) }
        };
        if fit.gear != self.gear && step.distance_m() > 0.0 {
            self.gear = fit.gear;
            self.n_shifts += 1;
        }
        let model = &self.diesel.engine_model;
        let gear = &self.powertrain.gears[fit.gear];
        let inertia_kgm2 = model.inertia_kgm2;
        let auxiliary_nm = self.auxiliary_power_w / fit.engine_radps;
        let engaged = fit.closed || fit.slips;
        let (engine_nm, limited) = if engaged {
            (fit.engine_nm.max(fit.drag_nm).min(fit.full_nm), fit.engine_nm > fit.full_nm)
        } else {
            (auxiliary_nm, false)
        };
        let inertia_nm = if fit.closed {
            inertia_kgm2 * gear.speed_ratio_per_m * step.acceleration_mps2()
        } else {
            0.0
        };
        let gearbox_nm = if engaged { engine_nm - auxiliary_nm - inertia_nm } else { 0.0 };
        let [wheel_n, lost_n] =
            self.diesel.gearbox.wheel_and_lost_n(gear, self.axle_per_m(), gearbox_nm);
        let way_m = step.distance_m();
        let turned_rad = fit.engine_radps * step.dt_s;
        let gearbox_rad = gear.speed_ratio_per_m * way_m;
        // the engine's speed jumps where the step does not begin as the last one ended
        let (start, end) = if fit.closed {
            (gear.speed_ratio_per_m * step.start_mps, gear.speed_ratio_per_m * step.end_mps)
        } else {
            (fit.engine_radps, fit.engine_radps)
        };
        let jump = self.engine_radps * self.engine_radps - start * start;
        self.engine_radps = end;
        let fuel_kgps = self.diesel.engine.fuel_kgps(fit.engine_radps, engine_nm);
        let heating = model.fuel.heating_value_jpkg;
        let brake_nms = self.powertrain.model.brakes.engine_brake_nms();
        DrivelineStep {
            wheel_n,
            crankshaft_j: engine_nm * turned_rad,
            auxiliary_j: auxiliary_nm * turned_rad,
            clutch_j: gearbox_nm * (turned_rad - gearbox_rad),
            transmission_j: lost_n * way_m,
            shift_j: 0.5 * inertia_kgm2 * jump,
            fuel_j: fuel_kgps * self.fuel_factor * heating * step.dt_s,
            engine_brake_reach_n: if engaged {
                brake_nms * fit.engine_radps * gear.speed_ratio_per_m
            } else {
                0.0
            },
            engine_radps: end,
            limited,
            outside_map: !model.map_covers(fit.engine_radps, engine_nm),
        }
    }
}

/// A driveline of which only efficiencies are known, as in FASTSim: no gears, no drag torque, no engine brake.
#[derive(Clone, Debug, PartialEq)]
pub struct EfficiencyDriveline {
    /// Efficiency from engine to wheels.
    pub transmission_efficiency: f64,
    /// The engine.
    pub engine: EfficiencyCurve,
    /// Power of the auxiliaries, in W.
    pub auxiliary_power_w: f64,
}

impl EfficiencyDriveline {
    /// Carries one step with that force wanted at the wheels.
    pub(super) fn step(&self, step: &CycleStep, force_n: f64) -> DrivelineStep {
        let wanted_w = (force_n * step.mean_mps()).max(0.0);
        let most_w = (self.engine.rated_power_w - self.auxiliary_power_w).max(0.0);
        let gearbox_w = (wanted_w / self.transmission_efficiency).min(most_w);
        let wheel_w = gearbox_w * self.transmission_efficiency;
        let engine_w = gearbox_w + self.auxiliary_power_w;
        let wheel_n = if step.mean_mps() > 0.0 { wheel_w / step.mean_mps() } else { 0.0 };
        DrivelineStep {
            wheel_n,
            crankshaft_j: engine_w * step.dt_s,
            auxiliary_j: self.auxiliary_power_w * step.dt_s,
            transmission_j: (gearbox_w - wheel_w) * step.dt_s,
            fuel_j: self.engine.input_w(engine_w) * step.dt_s,
            limited: wanted_w / self.transmission_efficiency > most_w,
            ..DrivelineStep::default()
        }
    }
}

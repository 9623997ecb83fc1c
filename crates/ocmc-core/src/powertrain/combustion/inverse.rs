//! A diesel engine behind clutch and gearbox in the backward mode: from the force at the wheels to
//! what the engine burns, in one step of prescribed speed.

use super::powertrain::CombustionPowertrain;
use crate::energy::ledger::{Ledger, Mode, Term};
use crate::powertrain::{
    GearChoice, GearOrder, InversePowertrain, InverseStep, Powertrain, ShiftConvention, SpeedStep,
    StepCost, TruckInputs,
};
use crate::record::Record;

/// The powertrain, its gear and its engine speed.
#[derive(Clone, Debug)]
pub(super) struct InverseCombustion<'a> {
    powertrain: &'a CombustionPowertrain,
    truck: TruckInputs,
    gear: usize,
    engine_radps: f64,
    /// Whether the engine drove in the last step.
    pulled: bool,
    /// Whether a gear has been engaged.
    has_moved: bool,
    convention: ShiftConvention,
    n_shifts: u32,
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
    /// Torque of the engine for each Nm at the gearbox's input.
    engine_per_input: f64,
    /// Engine speeds at the step's start and end, in rad/s.
    start_radps: f64,
    end_radps: f64,
    /// To turn up the engine itself, in Nm.
    inertia_nm: f64,
    /// Torque wanted of the engine, in Nm.
    engine_nm: f64,
    full_nm: f64,
    drag_nm: f64,
}

/// Work of an engine in a step.
#[derive(Clone, Copy)]
struct Work {
    /// Torque of the engine, in Nm.
    engine_nm: f64,
    /// Torque at the gearbox's input, in Nm.
    gearbox_nm: f64,
    /// Force at the wheels, and what is lost on the way there, in N.
    wheel_n: f64,
    lost_n: f64,
    /// Energy of the fuel, in J.
    fuel_j: f64,
    /// Whether the engine passes torque.
    engaged: bool,
    limited: bool,
}

impl<'a> InverseCombustion<'a> {
    pub(super) fn new(powertrain: &'a CombustionPowertrain, truck: &TruckInputs) -> Self {
        let gear = powertrain.gearbox.shift.start_gear as usize - 1;
        let engine_radps = powertrain.clutch.idle_radps;
        Self {
            powertrain,
            truck: *truck,
            gear,
            engine_radps,
            pulled: false,
            has_moved: false,
            convention: ShiftConvention::default(),
            n_shifts: 0,
        }
    }

    fn returns(&self) -> bool {
        self.convention == ShiftConvention::Returned
    }

    fn fit(&self, gear: usize, step: &SpeedStep, force_n: f64) -> Fit {
        let CombustionPowertrain { engine, engine_model: model, gearbox, clutch, .. } =
            self.powertrain;
        let here = &self.powertrain.gears[gear];
        let speed_radps = here.speed_ratio_per_m * step.mean_mps();
        let axle_per_m = self.powertrain.axle_per_m;
        let gearbox_nm = gearbox.input_torque_nm(here, axle_per_m, step.mean_mps(), force_n);
        let slips_below = here.slips_below_radps(&gearbox.shift);
        let (closed, slips, free_radps) =
            clutch.engage_one(speed_radps, slips_below, gearbox_nm > 0.0);
        let engine_radps = if closed { speed_radps } else { free_radps };
        let at = |speed_mps| if closed { here.speed_ratio_per_m * speed_mps } else { free_radps };
        let (mut start_radps, end_radps) = (at(step.start_mps), at(step.end_mps));
        // the engine's own inertia has to be turned up, too
        let inertia_nm = if self.returns() && step.gear != GearOrder::Free {
            start_radps = self.engine_radps;
            let change = end_radps * end_radps - start_radps * start_radps;
            0.5 * model.inertia_kgm2 * change / (engine_radps * step.dt_s)
        } else if closed {
            model.inertia_kgm2 * here.speed_ratio_per_m * step.acceleration_mps2()
        } else {
            0.0
        };
        let passes_power = slips && self.returns();
        let engine_per_input = if passes_power { speed_radps / engine_radps } else { 1.0 };
        let [full_nm, drag_nm] = engine.full_and_drag_nm(engine_radps);
        let passes = if closed || slips { gearbox_nm * engine_per_input } else { 0.0 };
        Fit {
            gear,
            engine_radps,
            closed,
            slips,
            gearbox_nm,
            engine_per_input,
            start_radps,
            end_radps,
            inertia_nm,
            engine_nm: passes + inertia_nm + self.truck.auxiliary_power_w / engine_radps,
            full_nm,
            drag_nm,
        }
    }

    /// A moving truck whose engine is let go at a speed in rad/s.
    fn let_go(&self, step: &SpeedStep, engine_radps: f64) -> Fit {
        let CombustionPowertrain { engine, engine_model: model, clutch, .. } = self.powertrain;
        let start_radps = engine_radps.max(clutch.idle_radps);
        let holds = self.returns() && self.pulled;
        let slowing_nm = engine.drag_nm(start_radps) - self.truck.auxiliary_power_w / start_radps;
        let change_radps = if holds { 0.0 } else { slowing_nm / model.inertia_kgm2 * step.dt_s };
        let end_radps = (start_radps + change_radps).max(clutch.idle_radps);
        let engine_radps = 0.5 * (start_radps + end_radps);
        let inertia_nm = model.inertia_kgm2 * (end_radps - start_radps) / step.dt_s;
        let [full_nm, drag_nm] = engine.full_and_drag_nm(engine_radps);
        Fit {
            gear: self.gear,
            engine_radps,
            closed: false,
            slips: false,
            gearbox_nm: 0.0,
            engine_per_input: 1.0,
            start_radps,
            end_radps,
            inertia_nm,
            engine_nm: self.truck.auxiliary_power_w / engine_radps + inertia_nm,
            full_nm,
            drag_nm,
        }
    }

    /// How the truck is carried through a step by what is said of its gear.
    fn ordered(&self, step: &SpeedStep, force_n: f64, engine_radps: f64) -> Fit {
        match step.gear {
            _ if step.distance_m() <= 0.0 => {
                let fit = self.fit(self.gear, step, -1.0);
                Fit { closed: false, slips: false, inertia_nm: 0.0, engine_per_input: 1.0, ..fit }
            }
            GearOrder::Free => self.choose(step, force_n),
            GearOrder::Engaged(gear) => {
                self.fit(gear.min(self.powertrain.gears.len() - 1), step, force_n)
            }
            GearOrder::Open => self.let_go(step, engine_radps),
        }
    }

    /// Work of the engine in a step that is carried so.
    fn work(&self, fit: &Fit, step: &SpeedStep) -> Work {
        let CombustionPowertrain { engine, engine_model: model, losses, .. } = self.powertrain;
        let gear = &self.powertrain.gears[fit.gear];
        let auxiliary_nm = self.truck.auxiliary_power_w / fit.engine_radps;
        let engaged = fit.closed || fit.slips;
        let (engine_nm, limited) = if engaged {
            (fit.engine_nm.max(fit.drag_nm).min(fit.full_nm), fit.engine_nm > fit.full_nm)
        } else {
            (auxiliary_nm + fit.inertia_nm, false)
        };
        let passed_nm = if engaged { engine_nm - auxiliary_nm - fit.inertia_nm } else { 0.0 };
        let gearbox_nm = passed_nm / fit.engine_per_input;
        let [wheel_n, lost_n] = losses.wheel_and_lost_n(gear, step.mean_mps(), gearbox_nm);
        let fuel_kgps = engine.fuel_of_kgps(fit.engine_radps, engine_nm, fit.drag_nm);
        let heating = model.fuel.heating_value_jpkg;
        let fuel_j = fuel_kgps * self.truck.map_factor * heating * step.dt_s;
        Work { engine_nm, gearbox_nm, wheel_n, lost_n, fuel_j, engaged, limited }
    }

    /// The highest gear above the upshift line that has the torque; where there is none, the
    /// highest that has it; where none has it, the strongest. The gear that is engaged stays while
    /// it is above the downshift line and has the torque.
    fn choose(&self, step: &SpeedStep, force_n: f64) -> Fit {
        let shift = &self.powertrain.gearbox.shift;
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
}

impl InversePowertrain for InverseCombustion<'_> {
    fn terms(&self) -> &'static [Term] {
        CombustionPowertrain::TERMS
    }

    fn stores(&self) -> &'static [Term] {
        &[Term::FuelEnergy]
    }

    fn gear_choice(&self) -> Option<GearChoice> {
        let CombustionPowertrain { engine_model: model, gearbox, gears, clutch, .. } =
            self.powertrain;
        let shift = &gearbox.shift;
        Some(GearChoice {
            per_m: gears.iter().map(|gear| gear.speed_ratio_per_m).collect(),
            inertia_kgm2: model.inertia_kgm2,
            launch_gears: gears.iter().filter(|gear| gear.launches).count(),
            slowest_radps: clutch.idle_radps,
            fastest_radps: shift.overspeed_radps,
            minimum_speed_mps: shift.minimum_speed_mps,
            gap_s: shift.duration_s,
            interval_s: shift.interval_s,
            most_up: shift.most_steps as usize,
        })
    }

    fn cost(&self, step: &SpeedStep, force_n: f64, shaft_radps: f64) -> StepCost {
        let fit = self.ordered(step, force_n, shaft_radps);
        let work = self.work(&fit, step);
        let kinetic_j = |radps| 0.5 * self.powertrain.engine_model.inertia_kgm2 * radps * radps;
        StepCost {
            energy_j: work.fuel_j,
            wheel_n: work.wheel_n,
            shaft_start_j: kinetic_j(fit.start_radps),
            shaft_end_j: kinetic_j(fit.end_radps),
        }
    }

    fn step(&mut self, step: &SpeedStep, force_n: f64, ledger: &mut Ledger<f64>) -> InverseStep {
        let moves = step.distance_m() > 0.0;
        let fit = self.ordered(step, force_n, self.engine_radps);
        if fit.gear != self.gear && moves {
            // the first gear that is ordered is no shift
            self.n_shifts += u32::from(self.has_moved || step.gear == GearOrder::Free);
            self.gear = fit.gear;
        }
        self.has_moved |= moves && step.gear != GearOrder::Open;
        let model = &self.powertrain.engine_model;
        let gear = &self.powertrain.gears[fit.gear];
        let auxiliary_nm = self.truck.auxiliary_power_w / fit.engine_radps;
        let Work { engine_nm, gearbox_nm, wheel_n, lost_n, fuel_j, engaged, limited } =
            self.work(&fit, step);
        let distance_m = step.distance_m();
        let turned_rad = fit.engine_radps * step.dt_s;
        let gearbox_rad = gear.speed_ratio_per_m * distance_m;
        // the engine's speed jumps where the step does not begin as the last one ended
        let jump = self.engine_radps * self.engine_radps - fit.start_radps * fit.start_radps;
        self.engine_radps = fit.end_radps;
        self.pulled = engaged && engine_nm > auxiliary_nm;
        ledger[Term::Crankshaft] += engine_nm * turned_rad;
        ledger[Term::Auxiliary] += auxiliary_nm * turned_rad;
        ledger[Term::Clutch] += gearbox_nm * (fit.engine_per_input * turned_rad - gearbox_rad);
        ledger[Term::Transmission] += lost_n * distance_m;
        ledger[Term::Shift] += 0.5 * model.inertia_kgm2 * jump;
        ledger[Term::FuelEnergy] += fuel_j;
        if !model.map_covers(fit.engine_radps, engine_nm) {
            ledger[Term::OutsideMap] += fuel_j;
        }
        let reach_nms = self.powertrain.engine_brake_nms * fit.engine_radps;
        InverseStep {
            wheel_n,
            engine_brake_reach_n: if engaged { reach_nms * gear.speed_ratio_per_m } else { 0.0 },
            limited,
            shaft_j: engine_nm * turned_rad,
        }
    }

    fn set_convention(&mut self, convention: ShiftConvention) {
        self.convention = convention;
    }

    fn kinetic_j(&self) -> f64 {
        let inertia_kgm2 = self.powertrain.engine_model.inertia_kgm2;
        0.5 * inertia_kgm2 * self.engine_radps * self.engine_radps
    }

    fn n_shifts(&self) -> u32 {
        self.n_shifts
    }

    fn record(&self, ledger: &Ledger<f64>, record: &mut Record) {
        let fuel_energy_j = ledger[Term::FuelEnergy];
        let fuel_kg = fuel_energy_j / self.powertrain.engine_model.fuel.heating_value_jpkg;
        self.powertrain.record_fuel(fuel_kg, fuel_energy_j, ledger, Mode::Followed, record);
    }
}

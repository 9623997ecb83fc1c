//! A diesel engine behind clutch and gearbox, in the step of the kernel.

use super::inverse::InverseCombustion;
use crate::energy::Carrier;
use crate::energy::ledger::{Ledger, Mode, StepLedger, Term};
use crate::first_order_lag::FirstOrderLag;
use crate::lanes::{Bounded, Flags, Lanes, lerp, masked, scheduling_barrier};
use crate::powertrain::component::clutch::Clutch;
use crate::powertrain::component::engine::{Curves, Engine, EngineModel};
use crate::powertrain::component::gearbox::{DrivelineLosses, Gear, GearLanes, GearboxModel};
use crate::powertrain::{
    Coupling, Demand, InversePowertrain, PedalForces, Powertrain, PowertrainConstants, ShaftStep,
    SignalNames, StepOutcome, TractiveEffort, TruckInputs,
};
use crate::record::Record;
use fearless_simd::prelude::*;

/// A diesel engine and its gearbox, prepared for the hot loop.
#[derive(Clone, Debug)]
pub struct CombustionPowertrain {
    /// Engine curves and map.
    pub engine: Engine,
    /// The engine as given.
    pub engine_model: EngineModel,
    /// The gearbox as given.
    pub gearbox: GearboxModel,
    /// Gears, from first to top.
    pub gears: Vec<Gear>,
    /// The clutch.
    pub(super) clutch: Clutch,
    /// Axle ratio over wheel radius, in 1/m.
    pub(super) axle_per_m: f64,
    /// Engine-brake torque for each rad/s, in Nm s.
    pub(super) engine_brake_nms: f64,
    /// Losses between gearbox and wheels.
    pub losses: DrivelineLosses,
}

/// The engines of a block.
#[derive(Clone, Debug)]
pub struct CombustionState<S: Simd> {
    /// Torque of the engine when it drives the wheels, in Nm.
    pub torque: Lanes<S>,
    /// Power of the auxiliaries, in W.
    pub auxiliary_power: Lanes<S>,
    /// Factor on the fuel map.
    pub fuel_factor: Lanes<S>,
    /// Accelerator from which on an engine at the speed of a slipping clutch drives; with less the
    /// clutch does not slip.
    slips_from: Lanes<S>,
    /// Force of the engine brake for each rad/s in this step, in N s.
    engine_brake: Lanes<S>,
    /// Full load and drag in this step.
    curves: Curves<S>,
}

/// Engine torques of one stage, in Nm.
#[derive(Clone, Copy)]
pub struct CombustionStage<S: Simd> {
    /// Command that the engine's torque follows, in Nm.
    command: Lanes<S>,
    full_load: Lanes<S>,
    drag: Lanes<S>,
    auxiliary: Lanes<S>,
}

/// Torque of the second stage but for what comes to it for each Nm of its command, and that.
#[derive(Clone, Copy)]
pub struct PredictedTorque<S: Simd> {
    torque: Lanes<S>,
    response: Lanes<S>,
}

impl CombustionPowertrain {
    /// Prepares checked models. `engine_brake_nms`: torque of the engine brake for each rad/s.
    pub fn new(
        engine_model: &EngineModel,
        gearbox: &GearboxModel,
        wheel_radius_m: f64,
        engine_brake_nms: f64,
    ) -> Self {
        let axle_per_m = gearbox.axle_ratio / wheel_radius_m;
        Self {
            engine: Engine::new(engine_model),
            engine_model: engine_model.clone(),
            gearbox: gearbox.clone(),
            gears: gearbox.gears(wheel_radius_m),
            clutch: Clutch::new(&gearbox.shift, engine_model.idle_speed_radps),
            axle_per_m,
            engine_brake_nms,
            losses: gearbox.losses(axle_per_m),
        }
    }

    /// The engine turns in a truck that stands, at a speed in rad/s and a power in W.
    fn run_at_rest(
        &self,
        [speed_radps, power_w]: [f64; 2],
        fuel_factor: f64,
        time_s: f64,
        ledger: &mut Ledger<f64>,
    ) {
        let torque_nm = power_w / speed_radps;
        let fuel_kg = self.engine.fuel_kgps(speed_radps, torque_nm) * fuel_factor * time_s;
        ledger[Term::Fuel] += fuel_kg;
        ledger[Term::Crankshaft] += power_w * time_s;
        ledger[Term::Auxiliary] += power_w * time_s;
        if !self.engine_model.map_covers(speed_radps, torque_nm) {
            ledger[Term::OutsideMap] += fuel_kg * self.engine_model.fuel.heating_value_jpkg;
        }
    }

    /// Fills in the columns of the fuel, by its mass and its energy.
    pub(super) fn record_fuel(
        &self,
        fuel_kg: f64,
        fuel_energy_j: f64,
        ledger: &Ledger<f64>,
        mode: Mode,
        record: &mut Record,
    ) {
        let fuel = &self.engine_model.fuel;
        let litres = fuel_kg / fuel.density_kgpm3 * 1000.0;
        let co2 = record.per_distance(fuel_kg * fuel.co2_kg_per_kg, mode);
        let by_litre = fuel.carrier.declaration().sold.is_some();
        record.take(fuel.carrier, fuel_kg, if by_litre { litres } else { fuel_kg }, mode);
        record.co2_g_per_km = co2.map(|per_m| per_m * 1e6);
        record.fuel_energy_j = Some(fuel_energy_j);
        record.engine_loss_j = Some(fuel_energy_j - ledger[Term::Crankshaft]);
    }
}

impl Powertrain for CombustionPowertrain {
    type State<S: Simd> = CombustionState<S>;
    type Stage<S: Simd> = CombustionStage<S>;
    type Predicted<S: Simd> = PredictedTorque<S>;

    const SOURCES: &'static [Term] = &[Term::Crankshaft];
    const STORES: &'static [Term] = &[Term::Fuel];
    const TERMS: &'static [Term] = &[Term::Fuel, Term::Crankshaft, Term::Clutch, Term::EngineBrake];
    const SIGNALS: SignalNames = SignalNames {
        speed: "engine_speed_radps",
        torque: "engine_torque_nm",
        source_rate: "fuel_rate_kgps",
        state: "clutch_closed",
    };

    fn carriers(&self) -> &'static [Carrier] {
        self.engine_model.fuel.carrier.alone()
    }

    fn constants(&self) -> PowertrainConstants {
        PowertrainConstants {
            inertia_kgm2: self.engine_model.inertia_kgm2,
            idle_radps: self.clutch.idle_radps,
            peak_torque_nm: self.engine.peak_torque_nm(),
            torque_lag_s: Some(self.engine_model.torque_lag_s),
        }
    }

    fn full_load_nm(&self, speed_radps: f64) -> f64 {
        self.engine.full_load_nm(speed_radps)
    }

    /// The cab is heated by the engine's waste heat; what it is cooled with is among the
    /// auxiliaries.
    fn parked<S: Simd>(&self, simd: S) -> CombustionState<S> {
        let zero = Lanes::splat(simd, 0.0);
        CombustionState {
            torque: zero,
            auxiliary_power: zero,
            fuel_factor: zero,
            slips_from: zero,
            engine_brake: zero,
            curves: Curves { lines: [zero; 4], bounds: [zero; 4], map_torque: zero },
        }
    }

    fn park<S: Simd>(&self, state: &mut CombustionState<S>, lane: usize) {
        state.torque[lane] = 0.0;
    }

    fn enter<S: Simd>(
        &self,
        state: &mut CombustionState<S>,
        lane: usize,
        truck: &TruckInputs,
        _air_temperature_k: f64,
    ) {
        state.auxiliary_power[lane] = truck.auxiliary_power_w;
        state.fuel_factor[lane] = truck.map_factor;
        state.slips_from[lane] = self.slips_from(truck.auxiliary_power_w);
    }

    fn start<S: Simd>(&self, state: &mut CombustionState<S>, lane: usize) {
        state.torque[lane] = 0.0;
        let [row, bounds] = self.engine.curve_rows(self.clutch.idle_radps);
        let Curves { lines, bounds: ends, .. } = &mut state.curves;
        for (column, value) in lines.iter_mut().chain(ends).zip(row.iter().chain(bounds)) {
            column[lane] = *value;
        }
    }

    fn settle<S: Simd>(
        &self,
        state: &mut CombustionState<S>,
        lane: usize,
        speed_radps: f64,
        accelerator: f64,
    ) {
        let full_nm = self.engine.full_load_nm(speed_radps);
        let drag_nm = self.engine.drag_nm(speed_radps);
        state.torque[lane] = drag_nm + accelerator * (full_nm - drag_nm);
    }

    /// The engine idles.
    fn stand<S: Simd>(
        &self,
        state: &mut CombustionState<S>,
        lane: usize,
        time_s: f64,
        ledger: &mut Ledger<f64>,
    ) {
        let (power_w, idle_radps) = (state.auxiliary_power[lane], self.clutch.idle_radps);
        self.run_at_rest([idle_radps, power_w], state.fuel_factor[lane], time_s, ledger);
    }

    /// The engine turns as fast as the body needs, and gives it what it can.
    fn stand_working<S: Simd>(
        &self,
        state: &mut CombustionState<S>,
        lane: usize,
        time_s: f64,
        power_w: f64,
        ledger: &mut Ledger<f64>,
    ) -> f64 {
        let speed_radps = self.engine_model.working_radps();
        let auxiliary_w = state.auxiliary_power[lane];
        let taken_w = power_w.min(self.power_take_off_w(auxiliary_w));
        let factor = state.fuel_factor[lane];
        self.run_at_rest([speed_radps, auxiliary_w + taken_w], factor, time_s, ledger);
        taken_w * time_s
    }

    /// The engine is off; afterwards it gives back the energy at the fuel that a Nm more costs at
    /// idle.
    fn stand_stopped<S: Simd>(
        &self,
        state: &mut CombustionState<S>,
        lane: usize,
        time_s: f64,
        power_w: f64,
        ledger: &mut Ledger<f64>,
    ) {
        let idle_radps = self.clutch.idle_radps;
        let torque_nm = state.auxiliary_power[lane] / idle_radps;
        let rate = |torque_nm| self.engine.fuel_kgps(idle_radps, torque_nm);
        let per_j = (rate(torque_nm + 1.0) - rate(torque_nm)) / idle_radps;
        let energy_j = power_w * time_s;
        ledger[Term::Fuel] += per_j * energy_j * state.fuel_factor[lane];
        ledger[Term::Crankshaft] += energy_j;
        ledger[Term::Auxiliary] += energy_j;
    }

    #[inline(always)]
    fn couple<S: Simd>(
        &self,
        state: &mut CombustionState<S>,
        gear: &GearLanes<S>,
        speed: Lanes<S>,
        shifting: Flags<S>,
        opens: Flags<S>,
        accelerator: Lanes<S>,
    ) -> Coupling<S> {
        let speed = speed * gear.speed_ratio;
        // launch clutch: with a pedal that asks for no torque there is nothing to slip for; a
        // clutch that released a braking engine at the first touch of the accelerator would make
        // truck and pedals chatter
        let drives = accelerator.simd_gt(state.slips_from);
        let clutch = self.clutch.engage(speed, gear.slips_below, drives);
        let closed = clutch.closed & !opens;
        let engaged = (clutch.slips | closed) & !(shifting | opens);
        let start_speed = closed.select(speed, clutch.free_speed);
        state.engine_brake = masked(engaged, gear.speed_ratio * self.engine_brake_nms);
        state.curves = self.engine.curves_at(start_speed);
        Coupling { closed, engaged, free_speed: clutch.free_speed, start_speed }
    }

    #[inline(always)]
    fn pedal_forces<S: Simd>(
        &self,
        state: &CombustionState<S>,
        gear: &GearLanes<S>,
        speed: Lanes<S>,
    ) -> PedalForces<S> {
        let [full_0, full_1, drag_0, drag_1] = state.curves.lines;
        let (ratio, share) = (gear.speed_ratio, gear.loss_share);
        let turns = speed * ratio;
        // the accelerator makes the clutch slip in the launching gears
        let engine = turns.at_least(gear.slips_below).at_least(self.clutch.open_radps);
        let (losses, full, drag) =
            (&self.losses, full_0 + full_1 * engine, drag_0 + drag_1 * engine);
        let [pressed, _] = losses.wheel_and_lost_forces_n(ratio, share, speed, full);
        let [released, _] = losses.wheel_and_lost_forces_n(ratio, share, speed, drag);
        let span = (pressed - released).at_least(PedalForces::<S>::LEAST_SPAN_N);
        // one division serves the torque of the auxiliaries and the span of the pedal
        let inverse = 1.0 / (engine * span);
        let released = released - state.auxiliary_power * ratio * span * inverse;
        let closed = !turns.simd_lt(self.clutch.open_radps);
        PedalForces { coasting: masked(closed, released), released, per_force: engine * inverse }
    }

    #[inline(always)]
    fn tractive_effort<S: Simd>(
        &self,
        state: &CombustionState<S>,
        gear: &GearLanes<S>,
        coupling: &Coupling<S>,
        demand: &Demand<S>,
        predicted: Option<&PredictedTorque<S>>,
    ) -> TractiveEffort<S, CombustionStage<S>> {
        let engine_speed = demand.shaft_speed;
        // the clutch opens at the next step: until then an engine that is braked below turns no
        // slower for its auxiliaries
        let turning = engine_speed.at_least(self.clutch.open_radps);
        // one division serves the torque of the auxiliaries and the angle of the wind
        let inverse = 1.0 / (turning * demand.air);

        let [_, _, drag_0, drag_1] = state.curves.lines;
        let full_load = state.curves.full_load_nm(engine_speed);
        let drag = drag_0 + drag_1 * engine_speed;
        let command = drag + demand.accelerator * (full_load - drag);
        // grip: what the driven axles cannot hold behind all losses the engine does not give,
        // beside its auxiliaries; what the driver does not let, neither: a torque is cut at once
        let auxiliary = state.auxiliary_power * demand.air * inverse;
        let held = self.losses.driving_torques_nm(gear, demand.speed, demand.traction);
        let full_load = full_load.at_most(held + auxiliary);
        let reached = match predicted {
            Some(predicted) => predicted.torque + predicted.response * command,
            None => state.torque,
        };
        let available = reached.at_least(drag).at_most(full_load);
        let driving = masked(coupling.engaged, available - auxiliary);
        // a slipping clutch takes nothing from wheels that turn slower than the engine
        let gearbox_torque = coupling.closed.select(driving, driving.at_least(0.0));

        let (ratio, share) = (gear.speed_ratio, gear.loss_share);
        let losses = &self.losses;
        let [wheel, lost] =
            losses.wheel_and_lost_forces_n(ratio, share, demand.speed, gearbox_torque);
        TractiveEffort {
            gearbox_torque,
            wheel,
            lost,
            brake: demand.brake,
            engine_brake: demand.brake.at_most(engine_speed * state.engine_brake),
            wind_tangent: demand.cross * turning * inverse,
            own: CombustionStage { command, full_load, drag, auxiliary },
        }
    }

    #[inline(always)]
    fn predict<S: Simd>(
        &self,
        state: &CombustionState<S>,
        lag: FirstOrderLag<S>,
        first: &CombustionStage<S>,
    ) -> PredictedTorque<S> {
        let command = first.command;
        let response = lag.twice_mean_of_change();
        let torque =
            state.torque + lag.twice_mean() * (command - state.torque) - response * command;
        scheduling_barrier(torque);
        PredictedTorque { torque, response }
    }

    #[inline(always)]
    fn consume<S: Simd>(
        &self,
        state: &mut CombustionState<S>,
        shaft: &ShaftStep<S>,
        first: &CombustionStage<S>,
        second: &CombustionStage<S>,
        ledger: &mut StepLedger<S>,
    ) -> [Lanes<S>; 2] {
        let auxiliary = lerp(shaft.weight, first.auxiliary, second.auxiliary);
        let torque = shaft.gearbox_torque + auxiliary;
        let [_, _, drag_0, drag_1] = state.curves.lines;
        let drag = drag_0 + drag_1 * shaft.speed;
        let rate = self.engine.fuel_rates(shaft.speed, torque, drag) * state.fuel_factor;
        ledger.add(Term::Crankshaft, torque * shaft.angle);
        let fuel = rate * shaft.dt;
        ledger.add(Term::Fuel, fuel);
        ledger.add(Term::Auxiliary, auxiliary * shaft.angle);
        let outside = torque.simd_gt(state.curves.map_torque);
        let heating = self.engine_model.fuel.heating_value_jpkg;
        ledger.add(Term::OutsideMap, masked(outside, fuel * heating));
        let slipped = shaft.angle - shaft.gearbox_angle;
        ledger.add(Term::Clutch, shaft.gearbox_torque * slipped);
        ledger.add(Term::EngineBrake, shaft.engine_brake);
        [torque, rate]
    }

    #[inline(always)]
    fn commit<S: Simd>(
        &self,
        state: &mut CombustionState<S>,
        outcome: &StepOutcome<S>,
        first: &CombustionStage<S>,
        second: &CombustionStage<S>,
    ) {
        let weight = outcome.weight;
        let change = (weight + weight) * (second.command - first.command);
        let driven = (state.torque + outcome.lag.response(first.command - state.torque, change))
            .at_least(second.drag)
            .at_most(second.full_load);
        // the limits are those at the end of the step, which a step that is taken back has not
        // come to
        let driven = outcome.too_long.select(state.torque, driven);
        state.torque = masked(outcome.engaged, driven);
    }

    #[inline(always)]
    fn depleted<S: Simd>(&self, state: &CombustionState<S>) -> Flags<S> {
        Flags::splat(state.torque.simd, false)
    }

    fn state_signal<S: Simd>(
        &self,
        _state: &CombustionState<S>,
        _lane: usize,
        closed: bool,
    ) -> f64 {
        f64::from(u8::from(closed))
    }

    fn standing_signals(&self, added: &Ledger<f64>, time_s: f64, speed_radps: f64) -> [f64; 2] {
        let per_second = |term| if time_s > 0.0 { added[term] / time_s } else { 0.0 };
        [per_second(Term::Crankshaft) / speed_radps, per_second(Term::Fuel)]
    }

    fn record<S: Simd>(
        &self,
        _state: &CombustionState<S>,
        _lane: usize,
        ledger: &Ledger<f64>,
        record: &mut Record,
    ) {
        let fuel_kg = ledger[Term::Fuel];
        let fuel_energy_j = fuel_kg * self.engine_model.fuel.heating_value_jpkg;
        self.record_fuel(fuel_kg, fuel_energy_j, ledger, Mode::Driven, record);
    }

    fn inverse<'a>(&'a self, truck: &TruckInputs) -> Box<dyn InversePowertrain + 'a> {
        Box::new(InverseCombustion::new(self, truck))
    }
}

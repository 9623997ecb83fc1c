//! A diesel engine behind clutch and gearbox, in the step.

use super::powertrain::{Add, Coupling, Demand, Powertrain, ShaftStep, TractiveEffort};
use super::record::Record;
use super::state::{State, Total};
use crate::lanes::{Flags, Lanes, masked};
use crate::powertrain::diesel::engine::{Engine, EngineModel};
use crate::powertrain::gearbox::DrivelineLosses;
use crate::vehicle::{DieselPowertrain, Vehicle, VehicleModel};
use fearless_simd::prelude::*;

/// Engine and gearbox, and what the step reads of them.
#[derive(Clone, Copy, Debug)]
pub struct Diesel<'a> {
    drive: &'a DieselPowertrain,
    engine: &'a Engine,
    model: &'a EngineModel,
    losses: DrivelineLosses,
    /// Engine speed while the clutch slips, in rad/s.
    launch_radps: f64,
    /// Idle speed, in rad/s.
    idle_radps: f64,
    /// Engine speed below which the clutch opens, in rad/s.
    open_radps: f64,
    /// Engine-brake torque for each rad/s, in Nm s.
    engine_brake_nms: f64,
}

impl<'a> Diesel<'a> {
    /// Of a vehicle.
    pub fn new(drive: &'a DieselPowertrain, vehicle: &VehicleModel) -> Self {
        let (model, gearbox) = (&drive.engine_model, &drive.gearbox);
        Self {
            drive,
            engine: &drive.engine,
            model,
            losses: gearbox.losses(gearbox.axle_ratio / vehicle.wheel_radius_m),
            launch_radps: gearbox.shift.launch_speed_radps,
            idle_radps: model.idle_speed_radps,
            open_radps: gearbox.shift.open_share * model.idle_speed_radps,
            engine_brake_nms: vehicle.brakes.engine_brake_nms(),
        }
    }
}

impl Powertrain for Diesel<'_> {
    fn inertia_kgm2(&self) -> f64 {
        self.model.inertia_kgm2
    }

    fn idle_radps(&self) -> f64 {
        self.idle_radps
    }

    #[inline(always)]
    fn peak_torque_nm(&self) -> f64 {
        self.engine.peak_torque_nm()
    }

    fn torque_lag_s(&self) -> f64 {
        self.model.torque_lag_s
    }

    fn full_load_nm(&self, speed_radps: f64) -> f64 {
        self.engine.full_load_nm(speed_radps)
    }

    fn settled_torque_nm(&self, speed_radps: f64, accelerator: f64) -> f64 {
        let (full, drag) =
            (self.engine.full_load_nm(speed_radps), self.engine.drag_nm(speed_radps));
        drag + accelerator * (full - drag)
    }

    /// The cab is heated by the engine's waste heat; what it is cooled with is among the auxiliaries.
    fn climate_w(&self, _air_temperature_k: f64) -> f64 {
        0.0
    }

    #[inline(always)]
    fn couple<S: Simd>(&self, state: &mut State<S>, accelerator: Lanes<S>) -> Coupling<S> {
        let speed = state.speed * state.gear_speed;
        // with a pedal that asks for no torque there is nothing to slip for: where the clutch would let go of a braking engine at the
        // first touch of the accelerator, truck and pedals would chatter
        let drives = accelerator.simd_gt(state.slips_from);
        let slips = speed.simd_lt(state.slips_below) & drives;
        let slow = speed.simd_lt(self.open_radps);
        let closed = !(slips | slow);
        let shifting = state.shift_left.simd_gt(0.0);
        let engaged = (slips | closed) & !shifting;
        let simd = speed.simd;
        let free_speed = slips
            .select(Lanes::splat(simd, self.launch_radps), Lanes::splat(simd, self.idle_radps));
        let start_speed = closed.select(speed, free_speed);
        let inverse_mass = closed.select(state.inverse_mass_closed, state.inverse_mass_open);
        let engine_brake = masked(engaged, state.gear_speed * self.engine_brake_nms);
        state.curves = self.engine.curves_at(start_speed);
        Coupling { closed, engaged, free_speed, start_speed, inverse_mass, engine_brake }
    }

    #[inline(always)]
    fn tractive_effort<S: Simd>(
        &self,
        state: &State<S>,
        at: &Demand<S>,
        coupling: &Coupling<S>,
    ) -> TractiveEffort<S> {
        let engine_speed = at.engine_speed;
        // the clutch opens at the next step: until then an engine that is braked below turns no slower for its auxiliaries
        let turning = engine_speed.max(self.open_radps);
        // one division serves the torque of the auxiliaries and the angle of the wind
        let inverse = 1.0 / (turning * at.air);

        let [full_0, full_1, drag_0, drag_1] = state.curves.lines;
        let full_load = full_0 + full_1 * engine_speed;
        let drag_torque = drag_0 + drag_1 * engine_speed;
        let command = drag_torque + at.accelerator * (full_load - drag_torque);
        let reached = match at.follow {
            Some(follow) => at.torque + follow * command,
            None => at.torque,
        };
        let available = reached.max(drag_torque).min(full_load);
        let auxiliary_torque = state.auxiliary_power * at.air * inverse;
        let driving = masked(coupling.engaged, available - auxiliary_torque);
        // a slipping clutch takes nothing from wheels that turn slower than the engine
        let gearbox_torque = coupling.closed.select(driving, driving.max(0.0));

        let (per_m, share) = (state.gear_speed, state.gear_loss);
        let [wheel, lost] = self.losses.wheel_and_lost_forces_n(per_m, share, gearbox_torque);
        let engine_brake = at.brake.min(engine_speed * coupling.engine_brake);
        TractiveEffort {
            command,
            full_load,
            drag_torque,
            auxiliary_torque,
            gearbox_torque,
            wheel,
            lost,
            brake: at.brake,
            engine_brake,
            wind_tangent: at.cross * turning * inverse,
        }
    }

    #[inline(always)]
    fn consume<S: Simd>(
        &self,
        state: &mut State<S>,
        shaft: &ShaftStep<S>,
        added: &mut [Lanes<S>; Total::COUNT],
    ) -> Lanes<S> {
        let [_, _, drag_0, drag_1] = state.curves.lines;
        let drag_torque = drag_0 + drag_1 * shaft.speed;
        let rate =
            self.engine.fuel_rates(shaft.speed, shaft.torque, drag_torque) * state.fuel_factor;
        state.add(Total::Fuel, rate * shaft.dt, added);
        state.add(Total::Auxiliary, shaft.auxiliary * shaft.angle, added);
        let outside = shaft.torque.simd_gt(state.curves.map_torque);
        state.add(Total::OutsideMap, masked(outside, shaft.dt), added);
        rate
    }

    #[inline(always)]
    fn is_empty<S: Simd>(&self, state: &State<S>) -> Flags<S> {
        Flags::splat(state.speed.simd, false)
    }

    fn is_stranded<S: Simd>(&self, _state: &State<S>, _lane: usize) -> bool {
        false
    }

    fn enter<S: Simd>(&self, state: &mut State<S>, lane: usize, vehicle: &Vehicle) {
        state.fuel_factor[lane] = vehicle.fuel_factor;
        state.slips_from[lane] = self.drive.slips_from(vehicle.auxiliary_power_w);
    }

    /// The engine idles.
    fn stand<S: Simd>(&self, state: &mut State<S>, lane: usize, time_s: f64, add: Add) {
        let power_w = state.auxiliary_power[lane];
        let torque = power_w / self.idle_radps;
        let idle_rate = self.engine.fuel_kgps(self.idle_radps, torque);
        add(Total::Fuel, idle_rate * state.fuel_factor[lane] * time_s);
        add(Total::Crankshaft, power_w * time_s);
        add(Total::Auxiliary, power_w * time_s);
        if !self.model.map_covers(self.idle_radps, torque) {
            add(Total::OutsideMap, time_s);
        }
    }

    fn record<S: Simd>(&self, state: &State<S>, lane: usize, plain: Record) -> Record {
        let total = |total| state.total(lane, total);
        let fuel = &self.model.fuel;
        let fuel_kg = total(Total::Fuel);
        let litres = fuel_kg / fuel.density_kgpm3 * 1000.0;
        let payload_t = plain.payload_kg / 1000.0;
        let fuel_energy_j = fuel_kg * fuel.heating_value_jpkg;
        let per_100km = plain.per_distance(litres) * 1e5;
        Record {
            brake_energy_j: total(Total::ServiceBrake) + total(Total::EngineBrake),
            fuel_kg: Some(fuel_kg),
            consumption_l_per_100km: Some(per_100km),
            consumption_l_per_100tkm: (payload_t > 0.0).then(|| per_100km / payload_t),
            co2_g_per_km: Some(plain.per_distance(fuel_kg * fuel.co2_kg_per_kg) * 1e6),
            fuel_energy_j: Some(fuel_energy_j),
            engine_loss_j: Some(fuel_energy_j - total(Total::Crankshaft)),
            crankshaft_work_j: Some(total(Total::Crankshaft)),
            clutch_loss_j: Some(total(Total::Clutch)),
            engine_brake_energy_j: Some(total(Total::EngineBrake)),
            ..plain
        }
    }
}

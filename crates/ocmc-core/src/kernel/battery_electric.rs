//! A battery and a motor, in the step.
//!
//! The motor's torque follows the pedals at once: accelerator times the highest torque, less the motor's share of what the brake pedal asks
//! for. Where the battery cannot give or take so much, the torque is brought back to what it can. At rest and in a shift there is none.
//! State of charge is frozen over a step. Of a step the motor's loss is the map at the step's mean speed and torque, the battery's the circuit at its mean
//! power: shaft work, losses and auxiliaries are integrated each on its own.

use super::powertrain::{Add, Coupling, Demand, Powertrain, ShaftStep, TractiveEffort};
use super::record::Record;
use super::state::{State, Total};
use crate::lanes::{Flags, Lanes, WIDTH, masked};
use crate::powertrain::battery_electric::BatteryElectricPowertrain;
use crate::vehicle::Vehicle;
use fearless_simd::prelude::*;

/// Battery, motor and gears.
#[derive(Clone, Copy, Debug)]
pub struct BatteryElectric<'a> {
    drive: &'a BatteryElectricPowertrain,
}

impl<'a> BatteryElectric<'a> {
    /// Of a vehicle.
    pub fn new(drive: &'a BatteryElectricPowertrain) -> Self {
        Self { drive }
    }

    /// The torques within the battery's limits, in Nm.
    #[inline(always)]
    fn within_battery<S: Simd>(
        self,
        state: &State<S>,
        speed: Lanes<S>,
        torque: Lanes<S>,
    ) -> Lanes<S> {
        let battery = &self.drive.model.battery;
        let drawn =
            speed * torque + self.drive.motor.losses_w(speed, torque) + state.auxiliary_power;
        let beyond = drawn.simd_gt(battery.discharge_limits_w(state.charge))
            | drawn.simd_lt(-battery.charge_limits_w(state.charge));
        if beyond.any_true() {
            return self.limited_torque(state, beyond.to_bitmask(), speed.into(), torque);
        }
        torque
    }

    #[cold]
    #[inline(never)]
    fn limited_torque<S: Simd>(
        self,
        state: &State<S>,
        lanes: u64,
        speed: [f64; WIDTH],
        mut torque: Lanes<S>,
    ) -> Lanes<S> {
        for lane in (0..WIDTH).filter(|lane| lanes >> lane & 1 != 0) {
            let (charge, auxiliary_w) = (state.charge[lane], state.auxiliary_power[lane]);
            torque[lane] =
                self.drive.within_battery_nm(charge, auxiliary_w, speed[lane], torque[lane]);
        }
        torque
    }
}

impl Powertrain for BatteryElectric<'_> {
    fn inertia_kgm2(&self) -> f64 {
        self.drive.model.motor.inertia_kgm2
    }

    fn idle_radps(&self) -> f64 {
        0.0
    }

    #[inline(always)]
    fn peak_torque_nm(&self) -> f64 {
        self.drive.model.motor.torque_nm
    }

    fn torque_lag_s(&self) -> f64 {
        1.0
    }

    fn full_load_nm(&self, speed_radps: f64) -> f64 {
        self.drive.model.motor.drive_limit_nm(speed_radps)
    }

    fn settled_torque_nm(&self, _speed_radps: f64, _accelerator: f64) -> f64 {
        0.0
    }

    fn climate_w(&self, air_temperature_k: f64) -> f64 {
        let climate = self.drive.model.climate.as_ref();
        climate.map_or(0.0, |climate| climate.power_w(air_temperature_k))
    }

    #[inline(always)]
    fn couple<S: Simd>(&self, state: &mut State<S>, _accelerator: Lanes<S>) -> Coupling<S> {
        let start_speed = state.speed * state.gear_speed;
        let simd = start_speed.simd;
        Coupling {
            closed: Flags::splat(simd, true),
            engaged: !state.shift_left.simd_gt(0.0),
            free_speed: Lanes::splat(simd, 0.0),
            start_speed,
            inverse_mass: state.inverse_mass_closed,
            engine_brake: Lanes::splat(simd, 0.0),
        }
    }

    #[inline(always)]
    fn tractive_effort<S: Simd>(
        &self,
        state: &State<S>,
        at: &Demand<S>,
        coupling: &Coupling<S>,
    ) -> TractiveEffort<S> {
        let model = &self.drive.model;
        let motor = &model.motor;
        let zero = Lanes::splat(at.speed.simd, 0.0);
        let speed = at.engine_speed;
        let driving = at.accelerator * motor.drive_limits_nm(speed);
        let braking = model
            .braking_torques_nm(state.gear_speed, at.brake)
            .min(motor.brake_limits_nm(speed, at.speed));
        let wanted = masked(coupling.engaged, driving - braking);
        let torque = self.within_battery(state, speed, wanted);
        let [wheel, lost] = model.wheel_and_lost_forces_n(state.gear_speed, torque);
        TractiveEffort {
            command: zero,
            full_load: zero,
            drag_torque: zero,
            auxiliary_torque: zero,
            gearbox_torque: torque,
            wheel,
            lost,
            // the service brakes do what the motor does not
            brake: (at.brake + wheel.min(0.0)).max(0.0),
            engine_brake: zero,
            wind_tangent: at.cross / at.air,
        }
    }

    #[inline(always)]
    fn consume<S: Simd>(
        &self,
        state: &mut State<S>,
        shaft: &ShaftStep<S>,
        added: &mut [Lanes<S>; Total::COUNT],
    ) -> Lanes<S> {
        let (battery, dt) = (&self.drive.model.battery, shaft.dt);
        let loss = self.drive.motor.losses_w(shaft.speed, shaft.torque);
        let motor = shaft.speed * shaft.torque + loss;
        let terminals = motor + state.auxiliary_power;
        let charge = state.charge;
        let (store, heat) = battery.flows(charge, terminals);
        let back = masked(shaft.torque.simd_lt(0.0), (-motor).max(0.0));
        state.add(Total::Battery, store * dt, added);
        state.add(Total::BatteryLoss, heat * dt, added);
        state.add(Total::MotorLoss, loss * dt, added);
        state.add(Total::Auxiliary, state.auxiliary_power * dt, added);
        state.add(Total::Regenerated, back * dt, added);
        state.charge -= store * dt * (1.0 / battery.capacity_j);
        let covered = self.drive.model.motor.maps_cover(shaft.speed, shaft.torque)
            & !battery.overdrawn(charge, terminals);
        state.add(Total::OutsideMap, masked(!covered, dt), added);
        terminals
    }

    #[inline(always)]
    fn is_empty<S: Simd>(&self, state: &State<S>) -> Flags<S> {
        !state.charge.simd_gt(self.drive.model.battery.minimum_charge)
    }

    fn is_stranded<S: Simd>(&self, state: &State<S>, lane: usize) -> bool {
        state.charge[lane] <= self.drive.model.battery.minimum_charge
    }

    fn enter<S: Simd>(&self, state: &mut State<S>, lane: usize, vehicle: &Vehicle) {
        state.charge[lane] = vehicle.initial_charge.unwrap_or(0.0);
    }

    /// The auxiliaries draw, and a charger may charge.
    fn stand<S: Simd>(&self, state: &mut State<S>, lane: usize, time_s: f64, add: Add) {
        let (battery, power_w) = (&self.drive.model.battery, state.auxiliary_power[lane]);
        let flow = battery.flow(state.charge[lane], power_w);
        add(Total::Battery, flow.store_w * time_s);
        add(Total::BatteryLoss, flow.loss_w * time_s);
        add(Total::Auxiliary, power_w * time_s);
        if battery.is_overdrawn(state.charge[lane], power_w) {
            add(Total::OutsideMap, time_s);
        }
        let mut charge = state.charge[lane] - flow.store_w * time_s / battery.capacity_j;
        if let Some(charging) = &self.drive.model.charging {
            let charged = battery.charge_at_rest(charging, charge, time_s);
            add(Total::Charged, charged.gained_j);
            add(Total::ChargingLoss, charged.loss_j);
            charge += charged.gained_j / battery.capacity_j;
        }
        state.charge[lane] = charge;
    }

    fn record<S: Simd>(&self, state: &State<S>, lane: usize, plain: Record) -> Record {
        let total = |total| state.total(lane, total);
        let store_j = total(Total::Battery);
        Record {
            brake_energy_j: total(Total::ServiceBrake),
            battery_energy_j: Some(store_j),
            regenerated_energy_j: Some(total(Total::Regenerated)),
            consumption_kwh_per_km: Some(plain.per_distance(store_j) / 3600.0),
            battery_loss_j: Some(total(Total::BatteryLoss)),
            motor_loss_j: Some(total(Total::MotorLoss)),
            charged_energy_j: Some(total(Total::Charged)),
            charging_loss_j: Some(total(Total::ChargingLoss)),
            final_charge: Some(state.charge[lane]),
            ..plain
        }
    }
}

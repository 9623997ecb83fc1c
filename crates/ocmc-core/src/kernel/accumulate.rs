//! Accumulation: what a step adds to the integrals over a cycle.

use super::powertrain::{Coupling, Powertrain, ShaftStep};
use super::state::{KernelParameters, State, Total};
use super::step::Stages;
use crate::lanes::{Lanes, lerp};
use fearless_simd::prelude::*;

/// Keeps a quotient finite, in N.
const SMALLEST_FORCE_N: f64 = 1e-9;

/// What a step adds to the totals, and what the step shows of it.
#[derive(Clone, Copy)]
pub(super) struct StepTotals<S: Simd> {
    pub added: [Lanes<S>; Total::COUNT],
    pub drag: Lanes<S>,
    /// Mean speed of the engine, and its speed at the end, in rad/s.
    pub engine_speed: Lanes<S>,
    pub end_speed: Lanes<S>,
    pub engine_torque: Lanes<S>,
    pub store_rate: Lanes<S>,
}

impl<S: Simd> State<S> {
    /// Adds the step to the integrals over the cycle.
    #[inline(always)]
    pub(super) fn accumulate<T: Powertrain>(
        &mut self,
        stages: &Stages<S>,
        parameters: &KernelParameters<T>,
    ) -> StepTotals<S> {
        let half = 0.5;
        let Stages { decision, first, second, step_end, .. } = stages;
        let (dt, dx) = (step_end.dt, step_end.dx);
        let simd = dt.simd;
        let Coupling { closed, free_speed, start_speed, .. } = decision.coupling;
        let end_speed = self.engine_speed_at(step_end.speed, &decision.coupling);
        let mean_speed = (start_speed + end_speed) * half;

        let angle = closed.select(dx * self.gear_speed, dt * free_speed);
        let weight = step_end.weight;
        let gearbox_torque =
            lerp(weight, first.effort.gearbox_torque, second.effort.gearbox_torque);
        let auxiliary = lerp(weight, first.effort.auxiliary_torque, second.effort.auxiliary_torque);
        let torque = gearbox_torque + auxiliary;
        let jump = self.engine_speed * self.engine_speed - start_speed * start_speed;
        let drag = lerp(weight, first.drag, second.drag);
        let engine_brake = lerp(weight, first.effort.engine_brake, second.effort.engine_brake);
        let service_brake = lerp(weight, first.effort.brake, second.effort.brake) - engine_brake;
        let half_change = weight * (second.effort.wheel - first.effort.wheel);
        let wheel = first.effort.wheel + half_change;
        // the mean of the positive part of a force that changes evenly
        let wheel_end = wheel + half_change;
        let positive = first.effort.wheel.max(0.0) + wheel_end.max(0.0);
        let twice = first.effort.wheel.abs() + wheel_end.abs();
        let driving = positive * positive / (twice + twice + SMALLEST_FORCE_N);
        let mut added = [Lanes::splat(simd, 0.0); Total::COUNT];
        self.add(Total::Time, dt, &mut added);
        self.add(Total::Distance, dx, &mut added);
        self.add(Total::Crankshaft, torque * angle, &mut added);
        let shaft = ShaftStep { dt, angle, speed: mean_speed, torque, auxiliary };
        let store_rate = parameters.powertrain.consume(self, &shaft, &mut added);
        self.add(Total::Clutch, gearbox_torque * (angle - dx * self.gear_speed), &mut added);
        let lost = lerp(weight, first.effort.lost, second.effort.lost);
        self.add(Total::Transmission, lost * dx, &mut added);
        self.add(Total::Shift, jump * (0.5 * parameters.engine_inertia_kgm2), &mut added);
        self.add(Total::Drag, drag * dx, &mut added);
        self.add(Total::InitialMotion, decision.rolling * dx, &mut added);
        self.add(Total::Grade, decision.grade * dx, &mut added);
        self.add(Total::ServiceBrake, service_brake * dx, &mut added);
        self.add(Total::EngineBrake, engine_brake * dx, &mut added);
        self.add(Total::Wheel, driving * dx, &mut added);
        StepTotals {
            added,
            drag,
            engine_speed: mean_speed,
            end_speed,
            engine_torque: torque,
            store_rate,
        }
    }

    /// Adds to a total.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        total: Total,
        amount: Lanes<S>,
        added: &mut [Lanes<S>; Total::COUNT],
    ) {
        self.totals[total as usize] += amount;
        added[total as usize] = amount;
    }
}

//! The books of a step: what it adds to the totals of a cycle.

use super::powertrain::{Coupling, Traction, Turn};
use super::state::{Shared, State, Total};
use super::step::Stages;
use crate::lanes::{Lanes, mix};
use fearless_simd::prelude::*;

/// Keeps a quotient finite, in N.
const SMALLEST_FORCE_N: f64 = 1e-9;

/// What a step adds to the totals, and what the step shows of it.
#[derive(Clone, Copy)]
pub(super) struct Books<S: Simd> {
    pub added: [Lanes<S>; Total::COUNT],
    pub drag: Lanes<S>,
    /// Mean speed of the engine, and its speed at the end, in rad/s.
    pub engine_speed: Lanes<S>,
    pub end_speed: Lanes<S>,
    pub engine_torque: Lanes<S>,
    pub store_rate: Lanes<S>,
}

impl<S: Simd> State<S> {
    /// The books.
    #[inline(always)]
    pub(super) fn books<T: Traction>(
        &mut self,
        stages: &Stages<S>,
        shared: &Shared<T>,
    ) -> Books<S> {
        let half = 0.5;
        let Stages { decision, first, second, ending, .. } = stages;
        let (dt, dx) = (ending.dt, ending.dx);
        let simd = dt.simd;
        let Coupling { closed, free_speed, start_speed, .. } = decision.coupling;
        let end_speed = self.engine_speed_at(ending.speed, &decision.coupling);
        let mean_speed = (start_speed + end_speed) * half;

        let angle = closed.select(dx * self.gear_speed, dt * free_speed);
        let weight = ending.weight;
        let gearbox_torque = mix(weight, first.pull.gearbox_torque, second.pull.gearbox_torque);
        let auxiliary = mix(weight, first.pull.auxiliary_torque, second.pull.auxiliary_torque);
        let torque = gearbox_torque + auxiliary;
        let jump = self.engine_speed * self.engine_speed - start_speed * start_speed;
        let drag = mix(weight, first.drag, second.drag);
        let engine_brake = mix(weight, first.pull.engine_brake, second.pull.engine_brake);
        let service_brake = mix(weight, first.pull.brake, second.pull.brake) - engine_brake;
        let half_change = weight * (second.pull.wheel - first.pull.wheel);
        let wheel = first.pull.wheel + half_change;
        // the mean of the positive part of a force that changes evenly
        let wheel_end = wheel + half_change;
        let positive = first.pull.wheel.max(0.0) + wheel_end.max(0.0);
        let twice = first.pull.wheel.abs() + wheel_end.abs();
        let driving = positive * positive / (twice + twice + SMALLEST_FORCE_N);
        let mut added = [Lanes::splat(simd, 0.0); Total::COUNT];
        self.book(Total::Time, dt, &mut added);
        self.book(Total::Distance, dx, &mut added);
        self.book(Total::Crankshaft, torque * angle, &mut added);
        let turn = Turn { dt, angle, speed: mean_speed, torque, auxiliary };
        let store_rate = shared.traction.spend(self, &turn, &mut added);
        self.book(Total::Clutch, gearbox_torque * (angle - dx * self.gear_speed), &mut added);
        let lost = mix(weight, first.pull.lost, second.pull.lost);
        self.book(Total::Transmission, lost * dx, &mut added);
        self.book(Total::Shift, jump * (0.5 * shared.engine_inertia_kgm2), &mut added);
        self.book(Total::Drag, drag * dx, &mut added);
        self.book(Total::Rolling, decision.rolling * dx, &mut added);
        self.book(Total::Grade, decision.grade * dx, &mut added);
        self.book(Total::ServiceBrake, service_brake * dx, &mut added);
        self.book(Total::EngineBrake, engine_brake * dx, &mut added);
        self.book(Total::Wheel, driving * dx, &mut added);
        Books {
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
    pub(super) fn book(
        &mut self,
        total: Total,
        amount: Lanes<S>,
        added: &mut [Lanes<S>; Total::COUNT],
    ) {
        self.totals[total as usize] += amount;
        added[total as usize] = amount;
    }
}

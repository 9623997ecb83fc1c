//! The two stages of a step: what driver, powertrain, air and road do at its start, and where that would lead.

use super::control::{Control, clamp_integral};
use super::first_order_lag::first_order_lags;
use super::powertrain::{Coupling, Demand, Powertrain, TractiveEffort};
use super::road_row::RoadRow;
use super::state::{KernelParameters, State};
use crate::lanes::{Flags, Lanes, WIDTH, columns, scheduling_barrier};
use crate::vehicle::resistance::drag_forces_n;
use fearless_simd::prelude::*;

/// The road rows under the trucks, by the columns of [`RoadRow`].
pub(super) type Row<S> = [Lanes<S>; RoadRow::COLUMNS];

/// The target of the driver at the step's start.
#[derive(Clone, Copy)]
pub(super) struct SpeedTarget<S: Simd> {
    pub row: Row<S>,
    /// Desired speed, in m/s, and the braking branch of its square.
    pub path: (Lanes<S>, Lanes<S>),
    pub hold: Flags<S>,
    pub held: Lanes<S>,
}

/// What is decided at the step's start.
#[derive(Clone, Copy)]
pub(super) struct Decision<S: Simd> {
    pub row: Row<S>,
    /// Braking branch of the squared desired speed at the start.
    pub backward: Lanes<S>,
    pub control: Control<S>,
    pub hold: Flags<S>,
    pub held: Lanes<S>,
    pub coupling: Coupling<S>,
    /// Forces of the road, in N, and their sum: the same over the step.
    pub rolling: Lanes<S>,
    pub grade: Lanes<S>,
    pub road: Lanes<S>,
}

/// Torques and forces of one stage.
#[derive(Clone, Copy)]
pub(super) struct Forces<S: Simd> {
    pub acceleration: Lanes<S>,
    pub drag: Lanes<S>,
    pub effort: TractiveEffort<S>,
}

/// The state at the end of a step that follows its first stage all the way.
#[derive(Clone, Copy)]
pub(super) struct Predicted<S: Simd> {
    /// Time to the segment's end, in s.
    pub to_end: Lanes<S>,
    pub dt: Lanes<S>,
    pub speed: Lanes<S>,
    pub left: Lanes<S>,
    /// Torque of the second stage but for what comes to it for each Nm of its command, and that.
    pub torque: Lanes<S>,
    pub follow: Lanes<S>,
    pub integral: Lanes<S>,
    pub filtered: Lanes<S>,
}

/// The slowest pace at which a step is cut for a segment's end, in m/s.
const SMALLEST_SPEED: f64 = 1e-9;

impl<S: Simd> State<S> {
    /// Advances to the next segment where one has ended; returns the rows under the trucks.
    #[inline(always)]
    pub(super) fn advance_segment(&mut self) -> Row<S> {
        let simd = self.left.simd;
        let turns = self.left.simd_le(0.0);
        let bits = turns.to_bitmask() as usize;
        for lane in 0..WIDTH {
            self.at[lane] += bits >> lane & 1;
        }
        let rows = [
            self.row(0).quads(),
            self.row(1).quads(),
            self.row(2).quads(),
            self.row(3).quads(),
            self.row(4).quads(),
            self.row(5).quads(),
            self.row(6).quads(),
            self.row(7).quads(),
        ];
        let [a, b, c, d] = columns(
            simd,
            #[inline(always)]
            |lane| &rows[lane][0],
        );
        let [e, f, g, h] = columns(
            simd,
            #[inline(always)]
            |lane| &rows[lane][1],
        );
        let [i, j, k, l] = columns(
            simd,
            #[inline(always)]
            |lane| &rows[lane][2],
        );
        let row = [a, b, c, d, e, f, g, h, i, j, k, l];
        self.left = turns.select(row[RoadRow::LENGTH], self.left);
        row
    }

    /// The target of the driver at the step's start.
    #[inline(always)]
    pub(super) fn speed_target<T: Powertrain>(
        &self,
        row: Row<S>,
        parameters: &KernelParameters<T>,
    ) -> SpeedTarget<S> {
        let path = self.desired(&row, self.left, parameters);
        let error = path.0 - self.speed;
        // whose truck has come to rest wants to go on, however slowly
        let hold = error.abs().simd_lt(self.threshold) & self.speed.simd_gt(0.0);
        // what is held is the output at the moment when holding began
        let held = self.holding.simd_gt(0.0).select(self.held, self.proportional * error);
        // a held brake is released when e >= 0, unless the driver holds as printed in the paper
        let held = error.simd_lt(0.0).select(held, held.max(self.lowest_held));
        scheduling_barrier(path.0);
        SpeedTarget { row, path, hold, held }
    }

    #[inline(always)]
    pub(super) fn control_at_start<T: Powertrain>(
        &self,
        speed_target: &SpeedTarget<S>,
        parameters: &KernelParameters<T>,
    ) -> Control<S> {
        let (limit, speed) = (speed_target.row[RoadRow::LIMIT], self.speed);
        let (hold, held) = (speed_target.hold, speed_target.held);
        let control = self.control(
            limit,
            speed,
            speed_target.path,
            self.integral,
            self.filtered,
            hold,
            held,
            parameters,
        );
        scheduling_barrier(control.accelerator);
        control
    }

    /// Pedals, clutch and hold at the step's start.
    #[inline(always)]
    pub(super) fn decide<T: Powertrain>(
        &mut self,
        speed_target: SpeedTarget<S>,
        control: Control<S>,
        parameters: &KernelParameters<T>,
    ) -> Decision<S> {
        let coupling = parameters.powertrain.couple(self, control.accelerator);
        let SpeedTarget { row, path, hold, held } = speed_target;
        let rolling = self.mass * row[RoadRow::ROLLING];
        let grade = self.mass * row[RoadRow::GRADE];
        let road = rolling + grade;
        scheduling_barrier(coupling.start_speed);
        Decision { row, backward: path.1, control, hold, held, coupling, rolling, grade, road }
    }

    #[inline(always)]
    pub(super) fn tractive_effort<T: Powertrain>(
        &self,
        speed: Lanes<S>,
        engine_speed: Lanes<S>,
        torque: Lanes<S>,
        follow: Option<Lanes<S>>,
        control: &Control<S>,
        decision: &Decision<S>,
        parameters: &KernelParameters<T>,
    ) -> TractiveEffort<S> {
        let row = &decision.row;
        let relative = speed + row[RoadRow::HEAD_WIND];
        let cross = row[RoadRow::CROSS_WIND];
        let demand = Demand {
            speed,
            engine_speed,
            torque,
            follow,
            accelerator: control.accelerator,
            brake: self.mass * (control.braking * parameters.brake_mps2).min(row[RoadRow::GRIP]),
            air: relative.max(1.0),
            cross,
        };
        let effort = parameters.powertrain.tractive_effort(self, &demand, &decision.coupling);
        scheduling_barrier(effort.wheel);
        effort
    }

    /// Forces at one stage.
    #[inline(always)]
    pub(super) fn net<T: Powertrain>(
        &self,
        speed: Lanes<S>,
        effort: TractiveEffort<S>,
        decision: &Decision<S>,
        parameters: &KernelParameters<T>,
    ) -> Forces<S> {
        let row = &decision.row;
        let relative = speed + row[RoadRow::HEAD_WIND];
        let cross = row[RoadRow::CROSS_WIND];
        let wind = &parameters.vehicle.cross_wind;
        let tangent = effort.wind_tangent.min(wind.maximum_tangent);
        let [c1, c2, c3, c4] = wind.coefficients_m2;
        let increment = (((tangent * c4 + c3) * tangent + c2) * tangent + c1) * tangent;
        let half_density = row[RoadRow::HALF_DENSITY];
        let drag = drag_forces_n(half_density, relative, cross, self.drag_area + increment);

        let net = effort.wheel - drag - decision.road - effort.brake;
        let acceleration = net * decision.coupling.inverse_mass;
        scheduling_barrier(acceleration);
        Forces { acceleration, drag, effort }
    }

    #[inline(always)]
    pub(super) fn first_effort<T: Powertrain>(
        &self,
        decision: &Decision<S>,
        parameters: &KernelParameters<T>,
    ) -> TractiveEffort<S> {
        let engine_speed = decision.coupling.start_speed;
        self.tractive_effort(
            self.speed,
            engine_speed,
            self.torque,
            None,
            &decision.control,
            decision,
            parameters,
        )
    }

    #[inline(always)]
    pub(super) fn second_effort<T: Powertrain>(
        &self,
        decision: &Decision<S>,
        predicted: &Predicted<S>,
        control: &Control<S>,
        parameters: &KernelParameters<T>,
    ) -> TractiveEffort<S> {
        let &Predicted { speed, torque, follow, .. } = predicted;
        let engine_speed = self.engine_speed_at(speed, &decision.coupling);
        self.tractive_effort(
            speed,
            engine_speed,
            torque,
            Some(follow),
            control,
            decision,
            parameters,
        )
    }

    /// Speed of the engine or motor at a speed of the truck.
    #[inline(always)]
    pub(super) fn engine_speed_at(&self, speed: Lanes<S>, coupling: &Coupling<S>) -> Lanes<S> {
        coupling.closed.select(speed * self.gear_speed, coupling.free_speed)
    }

    /// How far the step may go, and the state there.
    #[inline(always)]
    pub(super) fn predict<T: Powertrain>(
        &self,
        decision: &Decision<S>,
        first: &Forces<S>,
        parameters: &KernelParameters<T>,
    ) -> Predicted<S> {
        let half = 0.5;
        let longest = self.longest;
        let whole = self.shift_left.simd_gt(0.0).select(self.shift_left.min(longest), longest);
        let whole = self.hold_left.simd_gt(0.0).select(self.hold_left.min(whole), whole);
        let pace = (self.speed + first.acceleration * whole * half).max(SMALLEST_SPEED);
        let to_end = self.left / pace;
        let dt = whole.min(to_end);

        let speed = (self.speed + dt * first.acceleration).max(0.0);
        let left = (self.left - dt * (self.speed + speed) * half).max(0.0);
        let [engine, filter] = first_order_lags(dt, parameters.per_lag_s);
        // so that the mean of both stages is the mean of the step
        let command = first.effort.command;
        let follow = engine.twice_mean_of_change();
        let torque = self.torque + engine.twice_mean() * (command - self.torque) - follow * command;
        let rates = &decision.control;
        let integral = clamp_integral(self.integral + dt * rates.integral_rate, parameters);
        let filtered =
            self.filtered + filter.response(self.speed - self.filtered, speed - self.speed);
        scheduling_barrier(torque);
        Predicted { to_end, dt, speed, left, torque, follow, integral, filtered }
    }

    /// The pedals there.
    #[inline(always)]
    pub(super) fn control_at_end<T: Powertrain>(
        &self,
        decision: &Decision<S>,
        predicted: &Predicted<S>,
        parameters: &KernelParameters<T>,
    ) -> Control<S> {
        let Predicted { speed, left, integral, filtered, .. } = *predicted;
        let path = self.desired_at_end(decision, left, parameters);
        let limit = decision.row[RoadRow::LIMIT];
        let (hold, held) = (decision.hold, decision.held);
        let control = self.control(limit, speed, path, integral, filtered, hold, held, parameters);
        scheduling_barrier(control.accelerator);
        control
    }
}

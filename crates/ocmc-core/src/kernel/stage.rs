//! The two stages of a step: what driver, powertrain, air and road do at its start, and where that would lead.

use super::control::{Control, clamp_integral};
use super::first_order_lag::following;
use super::powertrain::{Coupling, Demand, Pull, Traction};
use super::road_row::RoadRow;
use super::state::{Shared, State};
use crate::lanes::{Flags, Lanes, WIDTH, columns, mark};
use crate::vehicle::resistance::drag_forces_n;
use fearless_simd::prelude::*;

/// The road rows under the trucks, by the columns of [`RoadRow`].
pub(super) type Row<S> = [Lanes<S>; RoadRow::COLUMNS];

/// What the driver wants at the step's start.
#[derive(Clone, Copy)]
pub(super) struct Wish<S: Simd> {
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
    pub pull: Pull<S>,
}

/// The state at the end of a step that follows its first stage all the way.
#[derive(Clone, Copy)]
pub(super) struct Ahead<S: Simd> {
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
    /// Where a segment has ended the next one begins; the rows under the trucks.
    #[inline(always)]
    pub(super) fn turn_to_row(&mut self) -> Row<S> {
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

    /// What the driver wants at the step's start.
    #[inline(always)]
    pub(super) fn wish<T: Traction>(&self, row: Row<S>, shared: &Shared<T>) -> Wish<S> {
        let path = self.desired(&row, self.left, shared);
        let error = path.0 - self.speed;
        // whose truck has come to rest wants to go on, however slowly
        let hold = error.abs().simd_lt(self.threshold) & self.speed.simd_gt(0.0);
        // what is held is the output at the moment when holding began
        let held = self.holding.simd_gt(0.0).select(self.held, self.proportional * error);
        // a held brake is released when e >= 0, unless the driver holds as printed in the paper
        let held = error.simd_lt(0.0).select(held, held.max(self.lowest_held));
        mark(path.0);
        Wish { row, path, hold, held }
    }

    #[inline(always)]
    pub(super) fn control_now<T: Traction>(
        &self,
        wish: &Wish<S>,
        shared: &Shared<T>,
    ) -> Control<S> {
        let (limit, speed) = (wish.row[RoadRow::LIMIT], self.speed);
        let (hold, held) = (wish.hold, wish.held);
        let control =
            self.control(limit, speed, wish.path, self.integral, self.filtered, hold, held, shared);
        mark(control.accelerator);
        control
    }

    /// Pedals, clutch and hold at the step's start.
    #[inline(always)]
    pub(super) fn decide<T: Traction>(
        &mut self,
        wish: Wish<S>,
        control: Control<S>,
        shared: &Shared<T>,
    ) -> Decision<S> {
        let coupling = shared.traction.couple(self, control.accelerator);
        let Wish { row, path, hold, held } = wish;
        let rolling = self.mass * row[RoadRow::ROLLING];
        let grade = self.mass * row[RoadRow::GRADE];
        let road = rolling + grade;
        mark(coupling.start_speed);
        Decision { row, backward: path.1, control, hold, held, coupling, rolling, grade, road }
    }

    #[inline(always)]
    pub(super) fn pull<T: Traction>(
        &self,
        speed: Lanes<S>,
        engine_speed: Lanes<S>,
        torque: Lanes<S>,
        follow: Option<Lanes<S>>,
        control: &Control<S>,
        decision: &Decision<S>,
        shared: &Shared<T>,
    ) -> Pull<S> {
        let row = &decision.row;
        let relative = speed + row[RoadRow::HEAD_WIND];
        let cross = row[RoadRow::CROSS_WIND];
        let demand = Demand {
            speed,
            engine_speed,
            torque,
            follow,
            accelerator: control.accelerator,
            brake: self.mass * (control.braking * shared.brake_mps2).min(row[RoadRow::GRIP]),
            air: relative.max(1.0),
            cross,
        };
        let pull = shared.traction.pull(self, &demand, &decision.coupling);
        mark(pull.wheel);
        pull
    }

    /// Forces at one stage.
    #[inline(always)]
    pub(super) fn net<T: Traction>(
        &self,
        speed: Lanes<S>,
        pull: Pull<S>,
        decision: &Decision<S>,
        shared: &Shared<T>,
    ) -> Forces<S> {
        let row = &decision.row;
        let relative = speed + row[RoadRow::HEAD_WIND];
        let cross = row[RoadRow::CROSS_WIND];
        let wind = &shared.powertrain.cross_wind;
        let tangent = pull.wind_tangent.min(wind.maximum_tangent);
        let [c1, c2, c3, c4] = wind.coefficients_m2;
        let increment = (((tangent * c4 + c3) * tangent + c2) * tangent + c1) * tangent;
        let half_density = row[RoadRow::HALF_DENSITY];
        let drag = drag_forces_n(half_density, relative, cross, self.drag_area + increment);

        let net = pull.wheel - drag - decision.road - pull.brake;
        let acceleration = net * decision.coupling.inverse_mass;
        mark(acceleration);
        Forces { acceleration, drag, pull }
    }

    #[inline(always)]
    pub(super) fn first_pull<T: Traction>(
        &self,
        decision: &Decision<S>,
        shared: &Shared<T>,
    ) -> Pull<S> {
        let engine_speed = decision.coupling.start_speed;
        self.pull(self.speed, engine_speed, self.torque, None, &decision.control, decision, shared)
    }

    #[inline(always)]
    pub(super) fn second_pull<T: Traction>(
        &self,
        decision: &Decision<S>,
        ahead: &Ahead<S>,
        control: &Control<S>,
        shared: &Shared<T>,
    ) -> Pull<S> {
        let &Ahead { speed, torque, follow, .. } = ahead;
        let engine_speed = self.engine_speed_at(speed, &decision.coupling);
        self.pull(speed, engine_speed, torque, Some(follow), control, decision, shared)
    }

    /// Speed of the engine or motor at a speed of the truck.
    #[inline(always)]
    pub(super) fn engine_speed_at(&self, speed: Lanes<S>, coupling: &Coupling<S>) -> Lanes<S> {
        coupling.closed.select(speed * self.gear_speed, coupling.free_speed)
    }

    /// How far the step may go, and the state there.
    #[inline(always)]
    pub(super) fn length<T: Traction>(
        &self,
        decision: &Decision<S>,
        first: &Forces<S>,
        shared: &Shared<T>,
    ) -> Ahead<S> {
        let half = 0.5;
        let longest = self.longest;
        let whole = self.shift_left.simd_gt(0.0).select(self.shift_left.min(longest), longest);
        let whole = self.hold_left.simd_gt(0.0).select(self.hold_left.min(whole), whole);
        let pace = (self.speed + first.acceleration * whole * half).max(SMALLEST_SPEED);
        let to_end = self.left / pace;
        let dt = whole.min(to_end);

        let speed = (self.speed + dt * first.acceleration).max(0.0);
        let left = (self.left - dt * (self.speed + speed) * half).max(0.0);
        let [engine, filter] = following(dt, shared.per_lag_s);
        // so that the mean of both stages is the mean of the step
        let command = first.pull.command;
        let follow = engine.twice_mean_of_change();
        let torque = self.torque + engine.twice_mean() * (command - self.torque) - follow * command;
        let rates = &decision.control;
        let integral = clamp_integral(self.integral + dt * rates.integral_rate, shared);
        let filtered = self.filtered + filter.way(self.speed - self.filtered, speed - self.speed);
        mark(torque);
        Ahead { to_end, dt, speed, left, torque, follow, integral, filtered }
    }

    /// The pedals there.
    #[inline(always)]
    pub(super) fn control_ahead<T: Traction>(
        &self,
        decision: &Decision<S>,
        ahead: &Ahead<S>,
        shared: &Shared<T>,
    ) -> Control<S> {
        let Ahead { speed, left, integral, filtered, .. } = *ahead;
        let path = self.desired_ahead(decision, left, shared);
        let limit = decision.row[RoadRow::LIMIT];
        let (hold, held) = (decision.hold, decision.held);
        let control = self.control(limit, speed, path, integral, filtered, hold, held, shared);
        mark(control.accelerator);
        control
    }
}

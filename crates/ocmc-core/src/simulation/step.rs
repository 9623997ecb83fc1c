//! One step of eight trucks: controller, powertrain, resistances, and the books.
//!
//! Heun's method: v₁ = v + dt (a₁ + σ (a₂ − a₁)/2), dx = dt (v + v₁)/2, where σ is the share of the predicted step that is left
//! where it is cut, otherwise 1. Each force's work is its mean, weighted alike, times dx, so m (v₁² − v²)/2 equals the net work
//! exactly and the energy balance closes without a remainder. The crankshaft's work is the mean torque times the crank angle,
//! which is k dx with the clutch closed and w dt while it slips or is open. Fuel is the map at the step's mean speed and torque.
//!
//! The step is cut where the segment ends, where a shift or the time until the next one ends, where the truck comes to rest, and
//! where a driver or the gearbox changes its mind. Gear, clutch and hold are decided at the step's start and frozen over both
//! stages.

use super::control::Control;
use super::lag::following;
use super::road_row::RoadRow;
use super::state::{Shared, State, Total};
use super::step_length::{is_too_long, longest_next};
use super::step_view::StepView;
use super::traction::{Coupling, Demand, Pull, Traction, Turn};
use crate::lanes::{Flags, Lanes, WIDTH, columns, mix, where_set};
use crate::vehicle::resistance::drag_forces_n;
use fearless_simd::prelude::*;

/// The road rows under the trucks, by the columns of [`RoadRow`].
pub(super) type Row<S> = [Lanes<S>; RoadRow::COLUMNS];

/// What is decided at the step's start.
#[derive(Clone, Copy)]
pub(super) struct Decision<S: Simd> {
    pub row: Row<S>,
    pub control: Control<S>,
    pub hold: Flags<S>,
    pub held: Lanes<S>,
    coupling: Coupling<S>,
}

/// Torques and forces of one stage.
#[derive(Clone, Copy)]
struct Forces<S: Simd> {
    acceleration: Lanes<S>,
    drag: Lanes<S>,
    pull: Pull<S>,
}

/// The state at the end of a step that follows its first stage all the way.
#[derive(Clone, Copy)]
pub(super) struct Prediction<S: Simd> {
    /// Time to the segment's end, in s.
    to_end: Lanes<S>,
    dt: Lanes<S>,
    pub speed: Lanes<S>,
    /// Torque of the second stage, and what comes to it for each Nm of its command.
    torque: Lanes<S>,
    follow: Lanes<S>,
    pub control: Control<S>,
}

/// How a step ends.
#[derive(Clone, Copy)]
struct Ending<S: Simd> {
    /// Flag: it was too long. It is taken back: nothing of it happens, and the next one is short.
    too_long: Flags<S>,
    /// Flag: where a mind changes.
    jumps: Flags<S>,
    /// Flag: at the end of the segment.
    reaches: Flags<S>,
    /// Share that the second stage has in the means over the step.
    weight: Lanes<S>,
    dt: Lanes<S>,
    dx: Lanes<S>,
    speed: Lanes<S>,
    /// Mean acceleration, in m/s².
    acceleration: Lanes<S>,
}

/// The slowest pace at which a step is cut for a segment's end, in m/s.
const SMALLEST_SPEED: f64 = 1e-9;
/// Keeps a quotient finite, in N.
const SMALLEST_FORCE_N: f64 = 1e-9;

/// All of a step but the books.
#[derive(Clone, Copy)]
pub struct Stages<S: Simd> {
    decision: Decision<S>,
    first: Forces<S>,
    predicted: Prediction<S>,
    second: Forces<S>,
    ending: Ending<S>,
}

/// The stages of the next step of two blocks of trucks, cut for each of them where something ends.
///
/// A step is one long chain of operations. The blocks take its parts in turns: the parts are short enough that the CPU
/// works on the other block's while it waits for results of this one's.
#[inline(always)]
pub fn stages<S: Simd, T: Traction>(
    (front, back): (&mut State<S>, &mut State<S>),
    shared: &Shared<T>,
) -> (Stages<S>, Stages<S>) {
    let decisions = (front.decide(shared), back.decide(shared));
    let firsts = (front.first(&decisions.0, shared), back.first(&decisions.1, shared));
    let ahead = (
        front.predict(&decisions.0, &firsts.0, shared),
        back.predict(&decisions.1, &firsts.1, shared),
    );
    let seconds =
        (front.second(&decisions.0, &ahead.0, shared), back.second(&decisions.1, &ahead.1, shared));
    let ends = (
        front.end(&decisions.0, &firsts.0, &ahead.0, &seconds.0, shared),
        back.end(&decisions.1, &firsts.1, &ahead.1, &seconds.1, shared),
    );
    (
        Stages {
            decision: decisions.0,
            first: firsts.0,
            predicted: ahead.0,
            second: seconds.0,
            ending: ends.0,
        },
        Stages {
            decision: decisions.1,
            first: firsts.1,
            predicted: ahead.1,
            second: seconds.1,
            ending: ends.1,
        },
    )
}

impl<S: Simd> State<S> {
    /// Advances one block alone by one step.
    #[inline(always)]
    pub fn step<T: Traction>(&mut self, shared: &Shared<T>) -> StepView<S> {
        let decision = self.decide(shared);
        let first = self.first(&decision, shared);
        let predicted = self.predict(&decision, &first, shared);
        let second = self.second(&decision, &predicted, shared);
        let ending = self.end(&decision, &first, &predicted, &second, shared);
        self.advance(&Stages { decision, first, predicted, second, ending }, shared)
    }

    /// Where a segment has ended the next one begins; the rows under the trucks.
    #[inline(always)]
    fn turn_to_row(&mut self) -> Row<S> {
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

    /// Pedals, clutch and hold at the step's start.
    #[inline(always)]
    fn decide<T: Traction>(&mut self, shared: &Shared<T>) -> Decision<S> {
        let row = self.turn_to_row();
        let (desired, backward) = self.desired(&row, self.left, shared);
        let error = desired - self.speed;
        let hold = error.abs().simd_lt(self.threshold);
        // what is held is the output at the moment when holding began
        let held = self.holding.simd_gt(0.0).select(self.held, self.proportional * error);
        // a held brake is released when e >= 0, unless the driver holds as printed in the paper
        let released = error.simd_lt(0.0).select(held, held.max(0.0));
        let held = self.holds_brake.simd_gt(0.0).select(held, released);
        let path = (desired, backward);
        let (limit, speed) = (row[RoadRow::LIMIT], self.speed);
        let control =
            self.control(limit, speed, path, self.integral, self.filtered, hold, held, shared);

        let coupling = shared.traction.couple(self, control.accelerator);
        Decision { row, control, hold, held, coupling }
    }

    /// Torques and forces at one stage.
    #[inline(always)]
    fn forces<T: Traction>(
        &self,
        speed: Lanes<S>,
        torque: Lanes<S>,
        follow: Lanes<S>,
        control: &Control<S>,
        decision: &Decision<S>,
        shared: &Shared<T>,
    ) -> Forces<S> {
        let row = &decision.row;
        let relative = speed + row[RoadRow::HEAD_WIND];
        let cross = row[RoadRow::CROSS_WIND];
        let full = shared.powertrain.model.brakes.full_deceleration_mps2;
        let demand = Demand {
            speed,
            torque,
            follow,
            accelerator: control.accelerator,
            brake: self.mass * (control.brake * full).min(row[RoadRow::GRIP]),
            air: relative.max(1.0),
            cross,
        };
        let pull = shared.traction.pull(self, &demand, &decision.coupling);

        let wind = &shared.powertrain.cross_wind;
        let tangent = pull.wind_tangent.min(wind.maximum_tangent);
        let [c1, c2, c3, c4, c5] = wind.coefficients_m2;
        let increment =
            ((((tangent * c5 + c4) * tangent + c3) * tangent + c2) * tangent + c1) * tangent;
        let half_density = row[RoadRow::HALF_DENSITY];
        let drag = drag_forces_n(half_density, relative, cross, self.drag_area + increment);

        let rolling = self.mass * row[RoadRow::ROLLING];
        let grade = self.mass * row[RoadRow::GRADE];
        let net = pull.wheel - drag - rolling - grade - pull.brake;
        Forces { acceleration: net * decision.coupling.inverse_mass, drag, pull }
    }

    #[inline(always)]
    fn first<T: Traction>(&self, decision: &Decision<S>, shared: &Shared<T>) -> Forces<S> {
        self.forces(
            self.speed,
            self.torque,
            Lanes::splat(self.speed.simd, 0.0),
            &decision.control,
            decision,
            shared,
        )
    }

    #[inline(always)]
    fn second<T: Traction>(
        &self,
        decision: &Decision<S>,
        end: &Prediction<S>,
        shared: &Shared<T>,
    ) -> Forces<S> {
        self.forces(end.speed, end.torque, end.follow, &end.control, decision, shared)
    }

    /// How far the step may go, and the state and the pedals there.
    #[inline(always)]
    fn predict<T: Traction>(
        &self,
        decision: &Decision<S>,
        first: &Forces<S>,
        shared: &Shared<T>,
    ) -> Prediction<S> {
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
        let torque = self.torque + (engine.mean + engine.mean) * (command - self.torque)
            - (engine.change + engine.change) * command;
        let follow = engine.change + engine.change;
        let rates = &decision.control;
        let integral = self.clamp_integral(self.integral + dt * rates.integral_rate, shared);
        let filtered = self.filtered
            + filter.end * (self.speed - self.filtered)
            + filter.mean * (speed - self.speed);
        let path = self.desired_ahead(decision, left, shared);
        let limit = decision.row[RoadRow::LIMIT];
        let (hold, held) = (decision.hold, decision.held);
        let control = self.control(limit, speed, path, integral, filtered, hold, held, shared);
        Prediction { to_end, dt, speed, torque, follow, control }
    }

    /// The ends of a step: its time is over, a mind changes, the segment ends, the truck comes to rest.
    #[inline(always)]
    fn end<T: Traction>(
        &self,
        decision: &Decision<S>,
        first: &Forces<S>,
        predicted: &Prediction<S>,
        second: &Forces<S>,
        shared: &Shared<T>,
    ) -> Ending<S> {
        let half = 0.5;
        let dt = predicted.dt;
        let change = second.acceleration - first.acceleration;
        let too_long = is_too_long(dt, change, shared);
        let mind = self.change_of_mind(decision, predicted, shared);
        let jumps = mind.simd_lt(1.0);
        let share = where_set(!too_long, mind);
        let weight = share * half;
        let dt = dt * share;

        // a truck at rest does not roll back: the brakes hold it, without work
        let free = first.acceleration + weight * change;
        let mean = self.speed.simd_gt(0.0).select(free, free.max(0.0));
        let way = dt * (self.speed + mean * dt * half);
        let square = self.speed * self.speed + mean * self.left * 2.0;
        let at_end = square.max(0.0).sqrt();
        let far = self.left.simd_lt(way) | predicted.to_end.simd_le(predicted.dt) & !jumps;
        let reaches = square.simd_gt(0.0) & far & !too_long;
        let timed = self.speed + mean * dt;
        let rests = timed.simd_lt(0.0) & !reaches & !too_long;
        let over = reaches.select(self.left * 2.0, rests.select(self.speed, dt));
        let under =
            reaches.select(self.speed + at_end, rests.select(-mean, Lanes::splat(dt.simd, 1.0)));
        let dt = over / under;
        let timed = where_set(!(rests | reaches), self.speed + mean * dt);
        let speed = reaches.select(at_end, timed.max(0.0));
        let dx = reaches.select(self.left, dt * (self.speed + speed) * half);
        Ending { too_long, jumps, reaches, weight, dt, dx, speed, acceleration: mean }
    }

    /// The books, the new state, and whether somebody has to look at it.
    #[inline(always)]
    pub fn advance<T: Traction>(&mut self, stages: &Stages<S>, shared: &Shared<T>) -> StepView<S> {
        let half = 0.5;
        let Stages { decision, first, predicted, second, ending } = stages;
        let second_control = &predicted.control;
        let (dt, dx) = (ending.dt, ending.dx);
        let simd = dt.simd;
        let Coupling { closed, engaged, free_speed, start_speed, .. } = decision.coupling;

        let angle = closed.select(dx * self.gear_speed, dt * free_speed);
        let weight = ending.weight;
        let gearbox_torque = mix(weight, first.pull.gearbox_torque, second.pull.gearbox_torque);
        let auxiliary = mix(weight, first.pull.auxiliary_torque, second.pull.auxiliary_torque);
        let torque = gearbox_torque + auxiliary;
        let mean_speed =
            closed.select((self.speed + ending.speed) * self.gear_speed * half, free_speed);
        let jump = self.engine_speed * self.engine_speed - start_speed * start_speed;
        let drag = mix(weight, first.drag, second.drag);
        let rolling = self.mass * decision.row[RoadRow::ROLLING];
        let grade = self.mass * decision.row[RoadRow::GRADE];
        let engine_brake = mix(weight, first.pull.engine_brake, second.pull.engine_brake);
        let service_brake = mix(weight, first.pull.brake, second.pull.brake) - engine_brake;
        let wheel = mix(weight, first.pull.wheel, second.pull.wheel);
        // the mean of the positive part of a force that changes evenly
        let wheel_end = mix(weight + weight, first.pull.wheel, second.pull.wheel);
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
        let lost = gearbox_torque * self.gear_speed - wheel;
        self.book(Total::Transmission, lost * dx, &mut added);
        self.book(Total::Shift, jump * (0.5 * shared.engine_inertia_kgm2), &mut added);
        self.book(Total::Drag, drag * dx, &mut added);
        self.book(Total::Rolling, rolling * dx, &mut added);
        self.book(Total::Grade, grade * dx, &mut added);
        self.book(Total::ServiceBrake, service_brake * dx, &mut added);
        self.book(Total::EngineBrake, engine_brake * dx, &mut added);
        self.book(Total::Wheel, driving * dx, &mut added);

        let [engine, filter] = following(dt, shared.per_lag_s);
        let command = first.pull.command;
        let change = (weight + weight) * (second.pull.command - command);
        let driven = (self.torque + engine.end * (command - self.torque) + engine.mean * change)
            .max(second.pull.drag_torque)
            .min(second.pull.full_load);
        // the limits are those at the end of the step, which a step that is taken back has not come to
        let driven = ending.too_long.select(self.torque, driven);
        self.torque = where_set(engaged, driven);
        let first_control = &decision.control;
        self.integral = self.clamp_integral(
            self.integral
                + dt * mix(weight, first_control.integral_rate, second_control.integral_rate),
            shared,
        );
        self.filtered +=
            filter.end * (self.speed - self.filtered) + filter.mean * (ending.speed - self.speed);
        self.holding = where_set(decision.hold, Lanes::splat(simd, 1.0));
        self.held = decision.held;
        self.speed = ending.speed;
        self.left = where_set(!ending.reaches, self.left - dx);
        self.engine_speed = closed.select(ending.speed * self.gear_speed, free_speed);
        self.shift_left = (self.shift_left - dt).max(0.0);
        self.hold_left = (self.hold_left - dt).max(0.0);
        let shift = &shared.powertrain.shift;
        let pressed = second_control.accelerator.simd_gt(shift.kickdown_pedal);
        let kick_left = (self.kick_left - dt).max(0.0);
        self.kick_left =
            (pressed | ending.too_long).select(kick_left, Lanes::splat(simd, shift.kickdown_s));
        self.steps_left -= 1.0;
        let change = second.acceleration - first.acceleration;
        let longest = longest_next(predicted.dt, change, shared);
        let longest = ending.jumps.select(Lanes::splat(simd, shared.step_after_jump_s), longest);
        self.longest = ending.too_long.select(Lanes::splat(simd, shared.short_step_s), longest);

        let slowing = ending.acceleration.simd_lt(0.0);
        let road_power = (drag + rolling + grade) * ending.speed;
        let wants_shift =
            self.wants_shift(second_control.accelerator, slowing, closed, road_power, shared);
        StepView {
            dt,
            dx,
            grade: decision.row[RoadRow::GRADE],
            desired: first_control.desired,
            accelerator: second_control.accelerator,
            brake: second_control.brake,
            engine_speed: mean_speed,
            engine_torque: torque,
            store_rate,
            acceleration: ending.acceleration,
            closed,
            added,
            alarm: self.alarm(&decision.row, wants_shift, shared) & !ending.too_long,
            wants_shift,
            slowing,
            road_power,
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

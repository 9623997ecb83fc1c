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

use super::accumulate::Books;
use super::control::{Control, clamp_integral};
use super::first_order_lag::following;
use super::powertrain::{Coupling, Traction};
use super::road_row::RoadRow;
use super::stage::{Ahead, Decision, Forces};
use super::state::{Shared, State};
use super::step_end::Ending;
use super::step_length::longest_next;
use super::step_view::StepView;
use crate::lanes::{Lanes, mix, where_set};
use fearless_simd::prelude::*;

/// What the step of a truck that makes way counts of the steps until the next look at the progress.
pub(super) const FAST_STEP: f64 = 1.0 / 16.0;

/// All of a step but the books.
#[derive(Clone, Copy)]
pub(super) struct Stages<S: Simd> {
    pub decision: Decision<S>,
    pub first: Forces<S>,
    pub ahead: Ahead<S>,
    /// The pedals there.
    pub control: Control<S>,
    pub second: Forces<S>,
    pub ending: Ending<S>,
}

/// Advances two blocks of trucks by one step, which is cut for each truck where something ends.
///
/// A step is one long chain of operations. The blocks take its parts in turns: the parts are short enough that the CPU
/// works on the other block's while it waits for results of this one's. Each part ends with a [`crate::lanes::mark`], so
/// that the compiler leaves the turns as they are.
#[inline(always)]
pub fn steps<S: Simd, T: Traction>(
    (front, back): (&mut State<S>, &mut State<S>),
    shared: &Shared<T>,
) -> (StepView<S>, StepView<S>) {
    let rows = (front.turn_to_row(), back.turn_to_row());
    let wishes = (front.wish(rows.0, shared), back.wish(rows.1, shared));
    let controls = (front.control_now(&wishes.0, shared), back.control_now(&wishes.1, shared));
    let decisions =
        (front.decide(wishes.0, controls.0, shared), back.decide(wishes.1, controls.1, shared));
    let pulls = (front.first_pull(&decisions.0, shared), back.first_pull(&decisions.1, shared));
    let firsts = (
        front.net(front.speed, pulls.0, &decisions.0, shared),
        back.net(back.speed, pulls.1, &decisions.1, shared),
    );
    let ahead = (
        front.length(&decisions.0, &firsts.0, shared),
        back.length(&decisions.1, &firsts.1, shared),
    );
    let controls = (
        front.control_ahead(&decisions.0, &ahead.0, shared),
        back.control_ahead(&decisions.1, &ahead.1, shared),
    );
    let pulls = (
        front.second_pull(&decisions.0, &ahead.0, &controls.0, shared),
        back.second_pull(&decisions.1, &ahead.1, &controls.1, shared),
    );
    let seconds = (
        front.net(ahead.0.speed, pulls.0, &decisions.0, shared),
        back.net(ahead.1.speed, pulls.1, &decisions.1, shared),
    );
    let minds = (
        front.change_of_mind(&decisions.0, &ahead.0, &controls.0, shared),
        back.change_of_mind(&decisions.1, &ahead.1, &controls.1, shared),
    );
    let ends = (
        front.end(minds.0, &firsts.0, &ahead.0, &seconds.0, shared),
        back.end(minds.1, &firsts.1, &ahead.1, &seconds.1, shared),
    );
    let stages = (
        Stages {
            decision: decisions.0,
            first: firsts.0,
            ahead: ahead.0,
            control: controls.0,
            second: seconds.0,
            ending: ends.0,
        },
        Stages {
            decision: decisions.1,
            first: firsts.1,
            ahead: ahead.1,
            control: controls.1,
            second: seconds.1,
            ending: ends.1,
        },
    );
    let books = (front.books(&stages.0, shared), back.books(&stages.1, shared));
    (front.renew(&stages.0, &books.0, shared), back.renew(&stages.1, &books.1, shared))
}

impl<S: Simd> State<S> {
    /// Advances one block alone by one step.
    #[inline(always)]
    pub fn step<T: Traction>(&mut self, shared: &Shared<T>) -> StepView<S> {
        let row = self.turn_to_row();
        let wish = self.wish(row, shared);
        let control = self.control_now(&wish, shared);
        let decision = self.decide(wish, control, shared);
        let pull = self.first_pull(&decision, shared);
        let first = self.net(self.speed, pull, &decision, shared);
        let ahead = self.length(&decision, &first, shared);
        let control = self.control_ahead(&decision, &ahead, shared);
        let pull = self.second_pull(&decision, &ahead, &control, shared);
        let second = self.net(ahead.speed, pull, &decision, shared);
        let mind = self.change_of_mind(&decision, &ahead, &control, shared);
        let ending = self.end(mind, &first, &ahead, &second, shared);
        let stages = Stages { decision, first, ahead, control, second, ending };
        let books = self.books(&stages, shared);
        self.renew(&stages, &books, shared)
    }

    /// The new state, and whether somebody has to look at it.
    #[inline(always)]
    fn renew<T: Traction>(
        &mut self,
        stages: &Stages<S>,
        books: &Books<S>,
        shared: &Shared<T>,
    ) -> StepView<S> {
        let Stages { decision, first, ahead, control: second_control, second, ending } = stages;
        let Coupling { closed, engaged, .. } = decision.coupling;
        let (dt, dx, weight) = (ending.dt, ending.dx, ending.weight);
        let simd = dt.simd;
        let [engine, filter] = following(dt, shared.per_lag_s);
        let command = first.pull.command;
        let change = (weight + weight) * (second.pull.command - command);
        let driven = (self.torque + engine.way(command - self.torque, change))
            .max(second.pull.drag_torque)
            .min(second.pull.full_load);
        // the limits are those at the end of the step, which a step that is taken back has not come to
        let driven = ending.too_long.select(self.torque, driven);
        self.torque = where_set(engaged, driven);
        let first_control = &decision.control;
        self.integral = clamp_integral(
            self.integral
                + dt * mix(weight, first_control.integral_rate, second_control.integral_rate),
            shared,
        );
        self.filtered += filter.way(self.speed - self.filtered, ending.speed - self.speed);
        self.holding = where_set(decision.hold, Lanes::splat(simd, 1.0));
        self.held = decision.held;
        self.speed = ending.speed;
        self.left -= dx;
        self.engine_speed = books.end_speed;
        self.shift_left = (self.shift_left - dt).max(0.0);
        self.hold_left = (self.hold_left - dt).max(0.0);
        let shift = &shared.powertrain.shift;
        let pressed = second_control.accelerator.simd_gt(shift.kickdown_pedal);
        let kick_left = (self.kick_left - dt).max(0.0);
        self.kick_left =
            (pressed | ending.too_long).select(kick_left, Lanes::splat(simd, shift.kickdown_s));
        let slow = ending.speed.simd_lt(shared.slow_mps);
        self.steps_left -= slow.select(Lanes::splat(simd, 1.0), Lanes::splat(simd, FAST_STEP));
        let change = second.acceleration - first.acceleration;
        let longest = longest_next(ahead.dt, change, shared);
        let brakes = second_control.braking.simd_gt(0.0);
        let longest = brakes.select(longest.min(self.brake_step), longest);
        let longest = ending.jumps.select(Lanes::splat(simd, shared.step_after_jump_s), longest);
        self.longest = ending.too_long.select(Lanes::splat(simd, shared.short_step_s), longest);

        let slowing = ending.acceleration.simd_lt(0.0);
        let road_power = (books.drag + decision.road) * ending.speed;
        let wants_shift =
            self.wants_shift(second_control.accelerator, slowing, closed, road_power, shared);
        StepView {
            dt,
            dx,
            grade: decision.row[RoadRow::GRADE],
            desired: first_control.desired,
            accelerator: second_control.accelerator,
            brake: second_control.brake,
            engine_speed: books.engine_speed,
            engine_torque: books.engine_torque,
            store_rate: books.store_rate,
            acceleration: ending.acceleration,
            closed,
            added: books.added,
            alarm: self.alarm(&decision.row, wants_shift, shared) & !ending.too_long,
            wants_shift,
            slowing,
            road_power,
        }
    }
}

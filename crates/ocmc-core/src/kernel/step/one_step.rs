//! One step of eight trucks: controller, powertrain, resistances, and the energy ledger.
//!
//! Heun's method: v₁ = v + dt (a₁ + σ (a₂ − a₁)/2), dx = dt (v + v₁)/2, where σ is the share of the
//! predicted step that is left where it is cut, otherwise 1. Each force's work is its mean,
//! weighted alike, times dx, so m (v₁² − v²)/2 equals the net work exactly and the energy balance
//! closes without a remainder. The crankshaft's work is the mean torque times the crank angle,
//! which is k dx with the clutch closed and w dt while it slips or is open. Fuel is the map at the
//! step's mean speed and torque.
//!
//! The step is cut where the segment ends, where a shift or the time until the next one ends, where
//! the truck comes to rest, and where a switching function of the driver or of the gearbox crosses
//! zero. Gear, clutch and hold are decided at the step's start and frozen over both stages.

use super::accumulate::StepTotals;
use super::control::{Control, clamp_integral};
use super::event_flag::ShiftLanes;
use super::stage::{Decision, Forces, Predicted};
use super::state::{KernelParameters, State};
use super::step_end::StepEnd;
use super::step_length::longest_next;
use super::step_view::StepView;
use crate::first_order_lag::first_order_lags;
use crate::lanes::{Bounded, Lanes, lerp, masked};
use crate::powertrain::{Coupling, Powertrain, StepOutcome};
use fearless_simd::prelude::*;

/// How much the step of a moving truck counts of the steps until the next check of progress.
pub(crate) const FAST_STEP: f64 = 1.0 / 16.0;

/// All of a step but what it adds to the integrals.
pub(super) struct Stages<S: Simd, P: Powertrain> {
    pub decision: Decision<S>,
    pub first: Forces<S, P>,
    pub predicted: Predicted<S, P>,
    /// The pedals there.
    pub control: Control<S>,
    pub second: Forces<S, P>,
    pub end: StepEnd<S>,
}

/// Advances two blocks of trucks by one step, which is cut for each truck where something ends.
///
/// A step is one long chain of operations. The parts of the two blocks are interleaved: they are
/// short enough that the CPU works on the other block's while it waits for results of this one's.
/// Each part ends with a [`scheduling_barrier`](crate::lanes::scheduling_barrier), so that the
/// compiler keeps this order.
#[inline(always)]
pub fn steps<S: Simd, P: Powertrain>(
    (front, back): (&mut State<S, P>, &mut State<S, P>),
    parameters: &KernelParameters<P>,
) -> (StepView<S>, StepView<S>) {
    let rows = (front.advance_segment(), back.advance_segment());
    let targets = (front.speed_target(rows.0, parameters), back.speed_target(rows.1, parameters));
    let controls = (
        front.control_at_start(&targets.0, parameters),
        back.control_at_start(&targets.1, parameters),
    );
    let decisions = (
        front.decide(targets.0, controls.0, parameters),
        back.decide(targets.1, controls.1, parameters),
    );
    let efforts =
        (front.first_effort(&decisions.0, parameters), back.first_effort(&decisions.1, parameters));
    let firsts = (
        State::net(front.motion.speed, efforts.0, &decisions.0, parameters),
        State::net(back.motion.speed, efforts.1, &decisions.1, parameters),
    );
    let predicted = (
        front.predict(&decisions.0, &firsts.0, parameters),
        back.predict(&decisions.1, &firsts.1, parameters),
    );
    let controls = (
        front.control_at_end(&decisions.0, &predicted.0, parameters),
        back.control_at_end(&decisions.1, &predicted.1, parameters),
    );
    let efforts = (
        front.second_effort(&decisions.0, &predicted.0, &controls.0, parameters),
        back.second_effort(&decisions.1, &predicted.1, &controls.1, parameters),
    );
    let seconds = (
        State::net(predicted.0.speed, efforts.0, &decisions.0, parameters),
        State::net(predicted.1.speed, efforts.1, &decisions.1, parameters),
    );
    let crossings = (
        front.locate_crossing(&decisions.0, &predicted.0, &controls.0, parameters),
        back.locate_crossing(&decisions.1, &predicted.1, &controls.1, parameters),
    );
    let ends = (
        front.end_step(crossings.0, &firsts.0, &predicted.0, &seconds.0, parameters),
        back.end_step(crossings.1, &firsts.1, &predicted.1, &seconds.1, parameters),
    );
    let stages = (
        Stages {
            decision: decisions.0,
            first: firsts.0,
            predicted: predicted.0,
            control: controls.0,
            second: seconds.0,
            end: ends.0,
        },
        Stages {
            decision: decisions.1,
            first: firsts.1,
            predicted: predicted.1,
            control: controls.1,
            second: seconds.1,
            end: ends.1,
        },
    );
    let totals = (front.accumulate(&stages.0, parameters), back.accumulate(&stages.1, parameters));
    (
        front.commit_step(&stages.0, &totals.0, parameters),
        back.commit_step(&stages.1, &totals.1, parameters),
    )
}

impl<S: Simd, P: Powertrain> State<S, P> {
    /// Advances one block alone by one step.
    #[inline(always)]
    pub fn step(&mut self, parameters: &KernelParameters<P>) -> StepView<S> {
        let row = self.advance_segment();
        let speed_target = self.speed_target(row, parameters);
        let control = self.control_at_start(&speed_target, parameters);
        let decision = self.decide(speed_target, control, parameters);
        let effort = self.first_effort(&decision, parameters);
        let first = Self::net(self.motion.speed, effort, &decision, parameters);
        let predicted = self.predict(&decision, &first, parameters);
        let control = self.control_at_end(&decision, &predicted, parameters);
        let effort = self.second_effort(&decision, &predicted, &control, parameters);
        let second = Self::net(predicted.speed, effort, &decision, parameters);
        let crossing = self.locate_crossing(&decision, &predicted, &control, parameters);
        let end = self.end_step(crossing, &first, &predicted, &second, parameters);
        let stages = Stages { decision, first, predicted, control, second, end };
        let totals = self.accumulate(&stages, parameters);
        self.commit_step(&stages, &totals, parameters)
    }

    /// The new state, and the events of the lanes.
    #[inline(always)]
    fn commit_step(
        &mut self,
        stages: &Stages<S, P>,
        totals: &StepTotals<S>,
        parameters: &KernelParameters<P>,
    ) -> StepView<S> {
        let Stages { decision, first, predicted, control: second_control, second, end } = stages;
        let (dt, dx, weight) = (end.dt, end.dx, end.weight);
        let simd = dt.simd;
        let [torque_lag, filter_lag] = first_order_lags(dt, parameters.per_lag_s);
        let Coupling { closed, engaged, .. } = decision.coupling;
        let outcome = StepOutcome { engaged, too_long: end.too_long, weight, lag: torque_lag };
        let (first_own, second_own) = (&first.effort.own, &second.effort.own);
        parameters.powertrain.commit(&mut self.powertrain, &outcome, first_own, second_own);
        let motion = &mut self.motion;
        let first_control = &decision.control;
        motion.integral = clamp_integral(
            motion.integral
                + dt * lerp(weight, first_control.integral_rate, second_control.integral_rate),
            parameters,
        );
        // behind a ramp the integral part begins with the pedal that keeps the speed
        let stance = &decision.stance;
        let begins =
            (stance.feeds | stance.look_ahead.coasts) & self.constants.integral_gain.simd_gt(0.0);
        motion.integral =
            begins.select(clamp_integral(stance.forecast.holding, parameters), motion.integral);
        motion.filtered +=
            filter_lag.response(motion.speed - motion.filtered, end.speed - motion.speed);
        motion.holding = masked(stance.hold, Lanes::splat(simd, 1.0));
        motion.held = stance.held;
        motion.rolling = masked(stance.look_ahead.rolls, Lanes::splat(simd, 1.0));
        motion.drag = lerp(weight + weight, first.drag, second.drag);
        motion.speed = end.speed;
        motion.left -= dx;
        motion.engine_speed = totals.end_speed;
        motion.shift_left = (motion.shift_left - dt).at_least(0.0);
        motion.up_left = (motion.up_left - dt).at_least(0.0);
        motion.down_left = (motion.down_left - dt).at_least(0.0);
        let shift = &parameters.vehicle.shift;
        let pressed = second_control.accelerator.simd_gt(shift.kickdown_pedal);
        let kick_left = (motion.kick_left - dt).at_least(0.0);
        motion.kick_left =
            (pressed | end.too_long).select(kick_left, Lanes::splat(simd, shift.kickdown_s));
        let slow = end.speed.simd_lt(parameters.slow_mps);
        motion.steps_left -= slow.select(Lanes::splat(simd, 1.0), Lanes::splat(simd, FAST_STEP));
        let change = second.acceleration - first.acceleration;
        let longest = longest_next(predicted.dt, change, parameters);
        let brakes = second_control.braking.simd_gt(0.0);
        let longest = brakes.select(longest.at_most(self.constants.brake_step), longest);
        // on a ramp what the driver knows of the truck is that of the step's start
        let longest = stance.feeds.select(longest.at_most(parameters.short_step_s), longest);
        let longest = end.jumps.select(Lanes::splat(simd, parameters.step_after_jump_s), longest);
        motion.longest = end.too_long.select(Lanes::splat(simd, parameters.short_step_s), longest);

        let risen = self.ceiling_after(decision.desired.speed, dt);
        let desired = self.desired(&decision.row, self.motion.left, risen);
        self.motion.ceiling = desired.squared().at_least(self.constants.least_ceiling);

        let slowing = end.acceleration.simd_lt(0.0);
        let road_power = (totals.drag + decision.road) * end.speed;
        // no upshift just before the driver brakes
        let braking = second_control.braking.simd_gt(0.0);
        let before = self.motion.speed * self.constants.before_ramp;
        let soon = desired.ramp_function(before).simd_gt(0.0);
        let inputs = ShiftLanes {
            accelerator: second_control.accelerator,
            slowing,
            gathers: stance.gathers,
            closed,
            road_power,
            brakes: braking | soon,
        };
        let wants_shift = self.wants_shift(&inputs, parameters);
        StepView {
            dt,
            dx,
            desired: first_control.desired,
            accelerator: second_control.accelerator,
            brake: second_control.brake,
            engine_speed: totals.engine_speed,
            engine_torque: totals.engine_torque,
            source_rate: totals.source_rate,
            acceleration: end.acceleration,
            closed,
            added: totals.added,
            event: self.event_flags(&decision.row, wants_shift, parameters) & !end.too_long,
            wants_shift,
            shift: inputs,
        }
    }
}

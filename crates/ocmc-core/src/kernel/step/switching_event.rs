//! Switching functions of driver and gearbox, and event location: a step is cut where one of them
//! crosses zero. Without the cut the switch would come up to a step too late, and the error would
//! be of first order in the step.

use super::control::{Control, DesiredSpeed};
use super::stage::{Decision, Predicted};
use super::state::{KernelParameters, State};
use crate::lanes::{Bounded, Flags, Lanes, scheduling_barrier};
use crate::powertrain::Powertrain;
use crate::powertrain::component::gearbox::ShiftModel;
use fearless_simd::prelude::*;

/// How far beyond the zero of a switching function a step goes, as a share of what is left of the
/// step.
const OVERSHOOT: f64 = 2e-3;

/// Where in a step a switching function crosses zero, as a quotient of two negative numbers: the
/// division is made once, of the earliest crossing.
#[derive(Clone, Copy)]
struct Crossing<S: Simd> {
    numerator: Lanes<S>,
    denominator: Lanes<S>,
}

impl<S: Simd> Crossing<S> {
    /// Where the line between two values rises through zero; 1 where it does not.
    #[inline(always)]
    fn of_rise(before: Lanes<S>, after: Lanes<S>) -> Self {
        let minus_one = Lanes::splat(before.simd, -1.0);
        let rises = before.simd_lt(0.0) & after.simd_gt(0.0);
        Self {
            numerator: rises.select(before, minus_one),
            denominator: rises.select(before - after, minus_one),
        }
    }

    #[inline(always)]
    fn or_earlier(self, other: Self) -> Self {
        let is_earlier =
            (other.numerator * self.denominator).simd_lt(self.numerator * other.denominator);
        Self {
            numerator: is_earlier.select(other.numerator, self.numerator),
            denominator: is_earlier.select(other.denominator, self.denominator),
        }
    }
}

impl<S: Simd, P: Powertrain> State<S, P> {
    /// The share of the step after which a driver goes from one pedal to the other comes to a
    /// braking ramp or to the end of a rise, a switched driver begins or ends to hold, an engine
    /// speed crosses a shifting line, or a slipping clutch has nothing left to slip; 1 where none
    /// of it happens.
    ///
    /// All of it is computed in every step: in a block of eight trucks it happens every other time,
    /// and no CPU foresees when.
    #[inline(always)]
    pub(super) fn locate_crossing(
        &self,
        decision: &Decision<S>,
        predicted: &Predicted<S, P>,
        second: &Control<S>,
        parameters: &KernelParameters<P>,
    ) -> Lanes<S> {
        let first = &decision.control;
        let errors = [first.desired - self.motion.speed, second.desired - predicted.speed];
        let stance = &decision.stance;
        let releases = stance.hold
            & stance.held.simd_lt(self.constants.lowest_held)
            & errors[0].simd_lt(errors[1]);
        let shift = &parameters.vehicle.shift;
        let driver = Crossing::of_rise(
            self.driver_function(errors[0], releases, decision, first),
            self.driver_function(errors[1], releases, decision, second),
        );
        // an engine that is below the downshift line already may come to where the clutch opens
        let turns = self.motion.speed * self.gear.speed_ratio;
        let is_low = down_function(turns, first.accelerator, shift).simd_gt(0.0);
        let speed = self.motion.speed;
        let gear = Crossing::of_rise(
            self.gear_function(speed, first, decision, is_low, parameters),
            self.gear_function(predicted.speed, second, decision, is_low, parameters),
        );
        let plan = Crossing::of_rise(
            self.plan_function(decision, &decision.desired, self.motion.speed, parameters),
            self.plan_function(decision, &predicted.desired, predicted.speed, parameters),
        );
        let earliest = driver.or_earlier(gear).or_earlier(plan);
        let share = earliest.numerator / earliest.denominator;
        // a little later, so that the change is seen
        let crossing = share - (share - 1.0) * OVERSHOOT;
        scheduling_barrier(crossing);
        crossing
    }

    /// Rises through zero where a braking ramp or coasting before one begins, or where the desired
    /// speed has risen to the plan.
    #[inline(always)]
    fn plan_function(
        &self,
        decision: &Decision<S>,
        desired: &DesiredSpeed<S>,
        speed: Lanes<S>,
        parameters: &KernelParameters<P>,
    ) -> Lanes<S> {
        let ramp = desired.ramp_function(desired.speed * self.constants.lead);
        let plan = decision.stance.rises.select(ramp.at_least(desired.rise_function), ramp);
        if !parameters.looks_ahead {
            return plan;
        }
        let (row, forecast) = (&decision.row, &decision.stance.forecast);
        plan.at_least(self.coasting_function(row, speed, desired, forecast, parameters))
    }

    /// Rises through zero where a driver changes pedals or a switched one begins or ends to hold.
    #[inline(always)]
    fn driver_function(
        &self,
        error: Lanes<S>,
        releases: Flags<S>,
        decision: &Decision<S>,
        control: &Control<S>,
    ) -> Lanes<S> {
        let hold = decision.stance.hold;
        let leaves = error.abs() - self.constants.threshold;
        let held = releases.select(error, leaves);
        // on a ramp a switched driver has nothing to hold
        let enters = self.constants.entry_threshold - error.abs();
        let enters = decision.stance.feeds.select(-enters.abs(), enters);
        let pedals = control.pedal_function(&decision.control);
        let balances = self.constants.balances.simd_gt(0.0);
        hold.select(balances.select(held.at_least(pedals), held), enters.at_least(pedals))
    }

    /// Rises through zero where the engine would reach the upshift line in the next gear, and where
    /// it falls below the downshift line, or below it to where the clutch opens: it is far from the
    /// one where it is near the other. With a clutch that is not closed, where the gear has come to
    /// the engine's speed.
    #[inline(always)]
    fn gear_function(
        &self,
        speed: Lanes<S>,
        control: &Control<S>,
        decision: &Decision<S>,
        is_low: Flags<S>,
        parameters: &KernelParameters<P>,
    ) -> Lanes<S> {
        let (coupling, gathers) = (&decision.coupling, decision.stance.gathers);
        let (shift, accelerator) = (&parameters.vehicle.shift, control.accelerator);
        let turns = speed * self.gear.speed_ratio;
        let up = speed * self.gear.upshift_ratio(gathers)
            - shift.up_speed_radps
            - accelerator * shift.up_pedal_radps;
        let open = parameters.idle_radps * shift.open_share;
        let down = is_low.select(open - turns, down_function(turns, accelerator, shift));
        coupling.closed.select(up.at_least(down), turns - coupling.free_speed)
    }
}

/// Rises through zero where an engine falls below the downshift line.
#[inline(always)]
fn down_function<S: Simd>(turns: Lanes<S>, accelerator: Lanes<S>, shift: &ShiftModel) -> Lanes<S> {
    accelerator * shift.down_pedal_radps + shift.down_speed_radps - turns
}

impl<S: Simd> Control<S> {
    /// Rises through zero where a driver leaves the pedal that was pressed at the step's start, or
    /// presses one.
    #[inline(always)]
    fn pedal_function(&self, start: &Self) -> Lanes<S> {
        let coasting = self.output.at_least(-self.demand);
        let off_accelerator = start.output.simd_gt(0.0);
        let off_brake = start.demand.simd_lt(0.0);
        off_accelerator.select(-self.output, off_brake.select(self.demand, coasting))
    }
}

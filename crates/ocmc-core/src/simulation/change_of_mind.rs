//! Where a step is cut because a driver or the gearbox changes its mind. Without the cut it would be decided up to a step too
//! late, and the error would be of first order in the step.

use super::state::{Shared, State};
use super::step::{Decision, Prediction};
use super::traction::Traction;
use crate::lanes::{Flags, Lanes, where_set};
use crate::vehicle::gearbox::ShiftModel;
use fearless_simd::prelude::*;

/// How far beyond the zero of a switching function a step goes, as a share of what is left of it.
const PASSING: f64 = 2e-3;

/// Where a line rises through zero.
#[inline(always)]
fn crossed<S: Simd>(before: Lanes<S>, after: Lanes<S>) -> Flags<S> {
    before.simd_lt(0.0) & after.simd_gt(0.0)
}

/// Rises through zero where a line changes its sign.
#[inline(always)]
fn reversal<S: Simd>(before: Lanes<S>, after: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
    let turns = (before * after).simd_lt(0.0);
    (-before.abs(), where_set(turns, after.abs()))
}

impl<S: Simd> State<S> {
    /// The share of the step after which a driver goes from one pedal to the other, a switched driver begins or ends to
    /// hold, or an engine speed crosses a shifting line; 1 where none of it happens.
    #[inline(always)]
    pub(super) fn change_of_mind<T: Traction>(
        &self,
        decision: &Decision<S>,
        predicted: &Prediction<S>,
        shared: &Shared<T>,
    ) -> Lanes<S> {
        let shift = &shared.powertrain.shift;
        let (first, second) = (&decision.control, &predicted.control);
        let (error_1, error_2) = (first.desired - self.speed, second.desired - predicted.speed);
        let releases = decision.hold
            & decision.held.simd_lt(0.0)
            & !self.holds_brake.simd_gt(0.0)
            & error_1.simd_lt(error_2);
        // functions that rise through zero where a mind changes
        let lines = [
            (
                self.hold_line(error_1, decision.hold, releases),
                self.hold_line(error_2, decision.hold, releases),
            ),
            (
                self.up_line(self.speed, first.accelerator, shift),
                self.up_line(predicted.speed, second.accelerator, shift),
            ),
            (
                self.down_line(self.speed, first.accelerator, shift),
                self.down_line(predicted.speed, second.accelerator, shift),
            ),
            reversal(first.output, second.output),
            reversal(first.demand, second.demand),
        ];
        let mut over = Lanes::splat(error_1.simd, 1.0);
        let mut under = over;
        if (crossed(lines[0].0, lines[0].1)
            | crossed(lines[1].0, lines[1].1)
            | crossed(lines[2].0, lines[2].1)
            | crossed(lines[3].0, lines[3].1)
            | crossed(lines[4].0, lines[4].1))
        .any_true()
        {
            for (before, after) in lines {
                // the zero of the line between both, and a little more, so that the change is seen
                let part = after * PASSING - before;
                let whole = after - before;
                let first = crossed(before, after) & (part * under).simd_lt(over * whole);
                over = first.select(part, over);
                under = first.select(whole, under);
            }
            return over / under;
        }
        over
    }

    /// Rises through zero where a switched driver begins or ends to hold.
    #[inline(always)]
    fn hold_line(&self, error: Lanes<S>, hold: Flags<S>, releases: Flags<S>) -> Lanes<S> {
        let outside = error.abs() - self.threshold;
        releases.select(error, hold.select(outside, -outside))
    }

    /// Rises through zero where the engine would reach the upshift line in the next gear.
    #[inline(always)]
    fn up_line(&self, speed: Lanes<S>, accelerator: Lanes<S>, shift: &ShiftModel) -> Lanes<S> {
        speed * self.gear_speed_up - shift.up_speed_radps - accelerator * shift.up_pedal_radps
    }

    /// Rises through zero where the engine falls below the downshift line.
    #[inline(always)]
    fn down_line(&self, speed: Lanes<S>, accelerator: Lanes<S>, shift: &ShiftModel) -> Lanes<S> {
        accelerator * shift.down_pedal_radps + shift.down_speed_radps - speed * self.gear_speed
    }
}

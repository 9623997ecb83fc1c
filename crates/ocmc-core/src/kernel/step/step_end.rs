//! How a step ends: its time is over, a switching function crosses zero, the segment ends, the
//! truck comes to rest.

use super::stage::{Forces, Predicted};
use super::state::{KernelParameters, State};
use super::step_length::is_too_long;
use crate::lanes::{Bounded, Flags, Lanes, masked, scheduling_barrier};
use crate::powertrain::Powertrain;
use fearless_simd::prelude::*;

/// How a step ends.
#[derive(Clone, Copy)]
pub(super) struct StepEnd<S: Simd> {
    /// Flag: it was too long. It is taken back: nothing of it happens, and the next one is short.
    pub too_long: Flags<S>,
    /// Flag: a switching function crosses zero within the step.
    pub jumps: Flags<S>,
    /// Share that the second stage has in the means over the step.
    pub weight: Lanes<S>,
    pub dt: Lanes<S>,
    pub dx: Lanes<S>,
    pub speed: Lanes<S>,
    /// Mean acceleration, in m/s².
    pub acceleration: Lanes<S>,
}

impl<S: Simd, P: Powertrain> State<S, P> {
    /// The ends of a step: its time is over, a switching function crosses zero, the segment ends,
    /// the truck comes to rest.
    #[inline(always)]
    pub(super) fn end_step(
        &self,
        crossing: Lanes<S>,
        first: &Forces<S, P>,
        predicted: &Predicted<S, P>,
        second: &Forces<S, P>,
        parameters: &KernelParameters<P>,
    ) -> StepEnd<S> {
        let half = 0.5;
        let dt = predicted.dt;
        let change = second.acceleration - first.acceleration;
        let too_long = is_too_long(dt, change, parameters);
        let jumps = crossing.simd_lt(1.0);
        let share = masked(!too_long, crossing);
        let weight = share * half;
        let dt = dt * share;

        // a truck at rest does not roll back: the brakes hold it, without work
        let free = first.acceleration + weight * change;
        let mean = self.motion.speed.simd_gt(0.0).select(free, free.at_least(0.0));
        let timed = self.motion.speed + mean * dt;
        let distance = dt * (self.motion.speed + timed) * half;
        let twice_left = self.motion.left + self.motion.left;
        let square = self.motion.speed * self.motion.speed + mean * twice_left;
        let at_end = square.at_least(0.0).sqrt();
        // it is driven past, too, by a truck that comes to rest within the step, but behind it
        let far = self.motion.left.simd_lt(distance)
            | predicted.to_end.simd_le(predicted.dt) & !jumps
            | timed.simd_lt(0.0);
        let reaches = square.simd_gt(0.0) & far & !too_long;
        let rests = timed.simd_lt(0.0) & !reaches;
        let over = reaches.select(twice_left, rests.select(self.motion.speed, dt));
        let under = reaches
            .select(self.motion.speed + at_end, rests.select(-mean, Lanes::splat(dt.simd, 1.0)));
        let dt = over / under;
        let timed = masked(!rests, self.motion.speed + mean * dt);
        let speed = reaches.select(at_end, timed.at_least(0.0));
        let dx = reaches.select(self.motion.left, dt * (self.motion.speed + speed) * half);
        scheduling_barrier(speed);
        StepEnd { too_long, jumps, weight, dt, dx, speed, acceleration: mean }
    }
}

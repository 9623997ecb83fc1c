//! The bounds of many cycles, on several threads.

use super::{Bound, BoundError, Fineness, Potential, potential};
use crate::run::{RunPlan, each};
use ocmc_core::study::Study;
use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;

/// A bound with its potential, or why there is none.
pub type TripBound = Result<(Bound, Option<Potential>), BoundError>;

/// Results of `of` for the bounds of the cycles of a plan, in order of the cycle ids; it does not
/// depend on the threads. `progress` receives the number of cycles done, several times a second;
/// breaking ends the work.
pub fn bounds<T: Send, B>(
    study: &Study,
    plan: &RunPlan,
    fineness: Fineness,
    answer_of: &(dyn Fn(TripBound) -> T + Sync),
    progress: impl FnMut(u64) -> ControlFlow<B>,
) -> ControlFlow<B, Vec<T>> {
    let one = |id: u64, stop: &AtomicBool| {
        let scenario = study.sample_pick_freeze(plan.seed, id, plan.pick_freeze);
        answer_of(potential(study, &scenario, fineness, stop))
    };
    each(plan, &one, progress)
}

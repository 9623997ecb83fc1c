//! How long a step may be. `step_s` is for a truck whose acceleration hardly changes.

use super::state::KernelParameters;
use crate::lanes::{Bounded, Flags, Lanes};
use crate::powertrain::Powertrain;
use fearless_simd::prelude::*;

/// Share of the longest step that is taken right after a jump of the pedals: its effect on the
/// gearbox is seen at once.
pub(super) const AFTER_JUMP: f64 = 0.07;
/// Change of acceleration over a step that its length aims at, in m/s².
const AIM_MPS2: f64 = 0.03;
/// Change of acceleration at which a step that is longer than the short one is taken back, in m/s².
const TOO_MUCH_MPS2: f64 = 0.05;
/// Keeps a quotient finite, in m/s².
const SMALLEST_MPS2: f64 = 1e-9;

/// Flag: the step was too long for what happened in it.
#[inline(always)]
pub(super) fn is_too_long<S: Simd, P: Powertrain>(
    dt: Lanes<S>,
    change: Lanes<S>,
    parameters: &KernelParameters<P>,
) -> Flags<S> {
    change.abs().simd_gt(TOO_MUCH_MPS2) & dt.simd_gt(parameters.short_step_s)
}

/// Longest next step, in s, after one in which acceleration would have changed so much, in m/s².
#[inline(always)]
pub(super) fn longest_next<S: Simd, P: Powertrain>(
    dt: Lanes<S>,
    change: Lanes<S>,
    parameters: &KernelParameters<P>,
) -> Lanes<S> {
    let aimed = dt * AIM_MPS2 / (change.abs() + SMALLEST_MPS2);
    aimed.at_least(parameters.short_step_s).at_most(parameters.simulation.step_s)
}

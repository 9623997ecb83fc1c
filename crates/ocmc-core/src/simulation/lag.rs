//! Quantities that follow others with a time constant: the engine's torque its command, the filtered speed the speed.
//!
//! They follow at the pace of half a second, and a step may be longer. So a step takes the solution for a leader that changes
//! evenly, with exp(−x), x = dt/T, in its Padé approximation (1 − x/2 + x²/12) / (1 + x/2 + x²/12): right to the fourth order, and
//! damped for steps of any length.

use crate::lanes::Lanes;
use fearless_simd::Simd;

/// How a quantity follows its leader over a step.
#[derive(Clone, Copy)]
pub(super) struct Following<S: Simd> {
    /// Share of the way to where the leader was at the start, that is done at the end.
    pub end: Lanes<S>,
    /// The same on average over the step; also the share of the leader's change, at the end.
    pub mean: Lanes<S>,
    /// Share of the leader's change, on average over the step.
    pub change: Lanes<S>,
}

/// Of two time constants, given by their inverses in 1/s: one division serves both.
#[inline(always)]
pub(super) fn following<S: Simd>(dt: Lanes<S>, per_s: [f64; 2]) -> [Following<S>; 2] {
    let [x, y] = per_s.map(|per_s| dt * per_s);
    let (over_x, over_y) = ((x * (1.0 / 12.0) + 0.5) * x, (y * (1.0 / 12.0) + 0.5) * y);
    let (under_x, under_y) = (over_x + 1.0, over_y + 1.0);
    let both = 1.0 / (under_x * under_y);
    let one = |x, over, inverse| Following {
        end: x * inverse,
        mean: over * inverse,
        change: (x * (1.0 / 24.0) + 1.0 / 6.0) * x * inverse,
    };
    [one(x, over_x, both * under_y), one(y, over_y, both * under_x)]
}

//! First-order lags: the engine's torque follows its command, the filtered speed follows the speed.
//!
//! Time constants are half a second, and a step may be longer. So a step takes the solution for an
//! input that changes linearly, with exp(−x), x = dt/T, in its Padé approximation (1 − x/2 + x²/12)
//! / (1 + x/2 + x²/12): right to the fourth order, and damped for steps of any length.

use crate::lanes::Lanes;
use fearless_simd::Simd;

/// A first-order lag over a step: with x = dt/T the share 1 − exp(−x) of a gap is x · inverse, its
/// mean over the step is over · inverse.
#[derive(Clone, Copy)]
pub struct FirstOrderLag<S: Simd> {
    x: Lanes<S>,
    over: Lanes<S>,
    inverse: Lanes<S>,
}

/// The lags of two time constants, given by their inverses in 1/s: one division serves both.
#[inline(always)]
pub fn first_order_lags<S: Simd>(dt: Lanes<S>, per_s: [f64; 2]) -> [FirstOrderLag<S>; 2] {
    let (x, y) = (dt * per_s[0], dt * per_s[1]);
    let (over_x, over_y) = ((x * (1.0 / 12.0) + 0.5) * x, (y * (1.0 / 12.0) + 0.5) * y);
    let (under_x, under_y) = (over_x + 1.0, over_y + 1.0);
    let both = 1.0 / (under_x * under_y);
    let [inverse_x, inverse_y] = [both * under_y, both * under_x];
    [
        FirstOrderLag { x, over: over_x, inverse: inverse_x },
        FirstOrderLag { x: y, over: over_y, inverse: inverse_y },
    ]
}

impl<S: Simd> FirstOrderLag<S> {
    /// The response over the step to the gap between input and output at the start and to the
    /// input's change.
    #[inline(always)]
    pub fn response(self, gap: Lanes<S>, change: Lanes<S>) -> Lanes<S> {
        (self.x * gap + self.over * change) * self.inverse
    }

    /// Twice the mean response over the step to a gap of 1 at the start.
    #[inline(always)]
    pub fn twice_mean(self) -> Lanes<S> {
        (self.over + self.over) * self.inverse
    }

    /// Twice the mean response over the step to an input that changes by 1.
    #[inline(always)]
    pub fn twice_mean_of_change(self) -> Lanes<S> {
        (self.over - self.x * (1.0 / 6.0)) * self.inverse
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, SimdBase, dispatch};

    /// End, mean and change for x = dt/T, from exp and its series.
    fn exact(x: f64) -> [f64; 3] {
        let mean = -libm::expm1(-x) / x;
        [x * mean, 1.0 - mean, 0.5 - (1.0 - mean) / x]
    }

    /// The same of the step.
    fn after_step(x: f64, other: f64) -> [f64; 3] {
        dispatch!(Level::baseline(), simd => {
            let [one, _] = first_order_lags(Lanes::splat(simd, x), [1.0, other]);
            let (none, unit) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
            assert!((one.response(none, unit)[0] - 0.5 * one.twice_mean()[0]).abs() < 1e-15);
            let (mean, of_change) = (one.twice_mean()[0], one.twice_mean_of_change()[0]);
            [one.response(unit, none)[0], 0.5 * mean, 0.5 * of_change]
        })
    }

    #[test]
    fn followers_are_the_exponential_to_the_fourth_order() {
        for (x, bound) in [(2.0, 1e-2), (1.0, 2e-3), (0.5, 2e-4), (0.25, 2e-5)] {
            for (stepped, exact) in after_step(x, 2.0).into_iter().zip(exact(x)) {
                assert!((stepped - exact).abs() < bound, "{x}: {stepped} {exact}");
            }
        }
        let error = |x: f64| (after_step(x, 2.0)[0] - exact(x)[0]).abs();
        let order = libm::log2(error(0.5) / error(0.25));
        assert!((4.5..5.5).contains(&order), "{order}");
    }

    #[test]
    fn nothing_follows_in_no_time_and_nothing_runs_away_in_much() {
        assert_eq!(after_step(0.0, 2.0), [0.0; 3]);
        for x in [3.0, 10.0, 100.0] {
            let [end, mean, _] = after_step(x, 0.5);
            // what is left of a deviation shrinks
            assert!((1.0 - end).abs() < 1.0 && (0.0..1.0).contains(&mean), "{x}: {end} {mean}");
        }
    }
}

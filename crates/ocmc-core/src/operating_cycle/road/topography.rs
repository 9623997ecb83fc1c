//! Topography: a Gaussian first-order autoregression of the slope on steps of fixed length.
//!
//! Y_k = a Y_{k-1} + e_k, e_k ~ N(0, σ²(1 − a²)), with a = cos(2π L_s / L_h), where L_s is the step
//! and L_h the mean distance between upcrossings of zero (one hill: up and down). Exact for a
//! Gaussian AR(1), because P(sign change) = arccos(a)/π; valid for L_h > 4 L_s. L_h has no meaning
//! without L_s.
//!
//! Y is the climb per metre of road, dz/ds = sin θ: that is what an odometer and an altimeter
//! measure, and it makes the net climb a linear condition. (Rise over run, tan θ, differs by 0.1 %
//! at a slope of 5 %.)
//!
//! At a change of road type the standardised state carries over and (a, σ) change, so the variance
//! is right on both sides without a jump. A draw beyond the slope limit is redrawn. Elevation
//! drifts like a random walk, 400 m over 100 km at σ = 2 %; the bridge removes the mean slope so
//! that the net climb is exact.
//!
//! Checked: variance, lag-1 product and upcrossings of 1000 stationary roads of 100 km lie within
//! four standard errors, for seeds 1, 2 and 3. The bridge is exact to 1e-7 m, keeps the limits, and
//! says where they leave no way.

use super::Road;
use super::road_type::Section;
use crate::random::Draws;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Slope statistics of one road type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TopographyModel {
    /// Standard deviation of the slope.
    #[schemars(range(min = 1.0e-6, max = 0.15))]
    pub slope_sd: f64,
    /// Mean distance between upcrossings of zero, in m.
    #[schemars(range(min = 50.0, max = 100_000.0))]
    pub hill_length_m: f64,
    /// Largest slope, up or down.
    #[schemars(range(min = 0.001, max = 0.25))]
    pub slope_limit: f64,
}

/// How the elevation drifts over a mission.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ClimbRule {
    /// The mean slope is shifted so that the net climb is exactly the mission's.
    Bridge,
    /// The random walk of elevation is left alone.
    Free,
}

impl TopographyModel {
    /// The autoregression's coefficient for steps of the given length.
    pub fn coefficient(&self, step_m: f64) -> f64 {
        libm::cos(TAU * step_m / self.hill_length_m)
    }
}

/// Normals that are drawn at once.
const DRAWN_AT_ONCE: usize = 64;

/// Slopes on steps of `step_m` from 0 to the end of the last section, of the model of each. It
/// takes all that is left of the stream.
pub fn sample_slopes<'a>(
    model_of: impl Fn(&Section) -> &'a TopographyModel,
    step_m: f64,
    sections: &[Section],
    draws: &mut Draws,
    slopes: &mut Vec<f64>,
) {
    slopes.clear();
    let end_m = sections.last().map_or(0.0, |s| s.end_m);
    let count = libm::ceil(end_m / step_m) as usize;
    slopes.reserve(count);
    let mut normals = [0.0; DRAWN_AT_ONCE];
    let mut used = DRAWN_AT_ONCE;
    let mut normal = || {
        if used == DRAWN_AT_ONCE {
            draws.normals(&mut normals);
            used = 0;
        }
        used += 1;
        normals[used - 1]
    };
    let mut state = normal();
    for section in sections {
        let model = model_of(section);
        let a = model.coefficient(step_m);
        let innovation_sd = (1.0 - a * a).sqrt();
        let limit = model.slope_limit / model.slope_sd;
        let last = (libm::ceil(section.end_m / step_m) as usize).min(count);
        while slopes.len() < last {
            let mut next = a * state + innovation_sd * normal();
            let mut tries = 0;
            while next.abs() > limit {
                tries += 1;
                next = if tries < 100 {
                    a * state + innovation_sd * normal()
                } else {
                    limit.copysign(next)
                };
            }
            state = next;
            slopes.push(model.slope_sd * state);
        }
    }
}

/// Shifts the slopes so that the road of length `length_m` climbs exactly `net_climb_m`, each slope
/// within the limit of its place: `limits` are the ends of stretches, as an index, and the limits
/// on them. Returns false where the limits leave no solution.
pub fn bridge(
    slopes: &mut [f64],
    step_m: f64,
    length_m: f64,
    net_climb_m: f64,
    limits: &[(usize, f64)],
) -> bool {
    let Some(last) = slopes.len().checked_sub(1) else {
        return net_climb_m == 0.0;
    };
    let last_length_m = length_m - step_m * last as f64;
    let climb_m = |slopes: &[f64]| step_m * sum(&slopes[..last]) + last_length_m * slopes[last];
    let tolerance = 1e-9 * (1.0 + length_m * 1e-3);
    for _ in 0..200 {
        let missing_m = net_climb_m - climb_m(slopes);
        if missing_m.abs() <= tolerance {
            return true;
        }
        // only slopes that are not at their limit in that direction can take the shift
        let sign = missing_m.signum();
        let (mut free, mut begin) = (0, 0);
        for &(end, limit) in limits {
            free += slopes[begin..end].iter().filter(|slope| **slope * sign < limit).count();
            begin = end;
        }
        let last_is_free = limits.last().is_some_and(|(_, limit)| slopes[last] * sign < *limit);
        let free_m = step_m * (free - usize::from(last_is_free)) as f64
            + if last_is_free { last_length_m } else { 0.0 };
        if free_m <= 0.0 {
            return false;
        }
        // a slope at its limit is pushed against it, and stays
        let shift = missing_m / free_m;
        begin = 0;
        for &(end, limit) in limits {
            for slope in &mut slopes[begin..end] {
                *slope = (*slope + shift).clamp(-limit, limit);
            }
            begin = end;
        }
    }
    (net_climb_m - climb_m(slopes)).abs() <= tolerance
}

impl Road {
    /// Climb from one place to one behind it, all in m; negative for a descent.
    pub fn climb_m(&self, [from_m, to_m]: [f64; 2]) -> f64 {
        let Self { slopes, slope_step_m: step_m, .. } = self;
        let place = |at_m: f64| {
            let step = ((at_m / step_m) as usize).min(slopes.len() - 1);
            (step, at_m - step_m * step as f64)
        };
        let [(first, before_m), (last, within_m)] = [from_m, to_m].map(place);
        step_m * sum(&slopes[first..last]) - before_m * slopes[first] + within_m * slopes[last]
    }
}

/// A sum in eight parts, which does not wait for each addition.
fn sum(values: &[f64]) -> f64 {
    let (blocks, rest) = values.as_chunks::<8>();
    let mut parts = [0.0; 8];
    for block in blocks {
        for (part, value) in parts.iter_mut().zip(block) {
            *part += value;
        }
    }
    parts.iter().sum::<f64>() + rest.iter().sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    const STEP_M: f64 = 25.0;

    #[test]
    fn the_climb_between_two_places_is_what_the_slopes_add_up_to() {
        let slopes: Vec<f64> = (0..40).map(|k| 0.01 * f64::from(k % 7) - 0.02).collect();
        let by_hand = |from_m: f64, to_m: f64| {
            let within = |k: usize| {
                let (start_m, end_m) = (25.0 * k as f64, 25.0 * (k + 1) as f64);
                (to_m.min(end_m) - from_m.max(start_m)).max(0.0)
            };
            (0..40).map(|k| slopes[k] * within(k)).sum::<f64>()
        };
        let road = Road { slopes: slopes.clone(), slope_step_m: 25.0, ..Road::default() };
        for [from_m, to_m] in
            [[0.0, 1000.0], [12.5, 20.0], [12.5, 37.5], [25.0, 50.0], [30.0, 999.0], [80.0, 80.0]]
        {
            let climb_m = road.climb_m([from_m, to_m]);
            assert!((climb_m - by_hand(from_m, to_m)).abs() < 1e-12, "{from_m} {to_m}");
        }
    }

    fn road(seed: u64, cycle: u64, model: &TopographyModel, length_m: f64) -> Vec<f64> {
        let sections = [Section { start_m: 0.0, end_m: length_m, road_type: 0 }];
        let mut draws = Draws::new(seed, cycle, Stream::Topography);
        let mut slopes = Vec::new();
        sample_slopes(|_| model, STEP_M, &sections, &mut draws, &mut slopes);
        slopes
    }

    fn mean_and_error(values: &[f64]) -> (f64, f64) {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let var = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, (var / n).sqrt())
    }

    #[test]
    fn thousand_stationary_roads_have_the_wanted_statistics() {
        let model = TopographyModel { slope_sd: 0.021, hill_length_m: 660.0, slope_limit: 1.0 };
        let a = model.coefficient(STEP_M);
        for seed in 1..=3 {
            let (mut squares, mut products, mut crossings) = (Vec::new(), Vec::new(), Vec::new());
            for cycle in 0..1000 {
                let y = road(seed, cycle, &model, 100_000.0);
                let n = y.len() as f64;
                squares.push(y.iter().map(|v| v * v).sum::<f64>() / n);
                products.push(y.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / (n - 1.0));
                let ups = y.windows(2).filter(|w| w[0] <= 0.0 && w[1] > 0.0).count();
                crossings.push(ups as f64 / ((n - 1.0) * STEP_M));
            }
            let variance = 0.021 * 0.021;
            let (mean, error) = mean_and_error(&squares);
            assert!((mean - variance).abs() < 4.0 * error, "variance {mean}");
            let (mean, error) = mean_and_error(&products);
            assert!((mean - a * variance).abs() < 4.0 * error, "lag-1 {}", mean / variance);
            let (mean, error) = mean_and_error(&crossings);
            assert!((mean - 1.0 / 660.0).abs() < 4.0 * error, "hill length {}", 1.0 / mean);
        }
    }

    #[test]
    fn bridge_is_exact_and_keeps_the_limits() {
        let model = TopographyModel { slope_sd: 0.03, hill_length_m: 660.0, slope_limit: 0.07 };
        for cycle in 0..50 {
            let length_m = 10_010.0;
            let mut y = road(2, cycle, &model, length_m);
            assert!(bridge(&mut y, STEP_M, length_m, 55.0, &[(30, 0.07), (401, 0.07)]));
            let last = y.len() - 1;
            let climb = STEP_M * y[..last].iter().sum::<f64>()
                + (length_m - STEP_M * last as f64) * y[last];
            assert!((climb - 55.0).abs() < 1e-7);
            assert!(y.iter().all(|s| s.abs() <= 0.07));
        }
        assert!(!bridge(&mut [0.0, 0.0], STEP_M, 50.0, 10.0, &[(2, 0.07)]));
    }

    #[test]
    fn printed_coefficients() {
        // L_h 300/500/1000/2000 m -> .8660/.9511/.9877/.9969
        for (hill, printed) in
            [(300.0, 0.8660), (500.0, 0.9511), (1000.0, 0.9877), (2000.0, 0.9969)]
        {
            let model = TopographyModel { slope_sd: 0.02, hill_length_m: hill, slope_limit: 0.1 };
            assert!((model.coefficient(STEP_M) - printed).abs() < 5e-5);
        }
    }
}

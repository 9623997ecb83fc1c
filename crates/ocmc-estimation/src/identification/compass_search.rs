//! Least squares within a box without derivatives: steps along the axes, halved when none helps.
//!
//! For residuals that jump, such as those of a driver who switches: derivatives would see the jumps
//! only by chance.

use std::slice::from_ref;

/// First step and last step, as shares of the box.
const FIRST_STEP: f64 = 0.08;
const LAST_STEP: f64 = 2e-5;

/// The best point found from `start`, and its value. `values` gives those of some points, which may
/// be worked out side by side.
pub fn descend(
    values: &mut dyn FnMut(&[Vec<f64>]) -> Vec<f64>,
    start: &[f64],
    bounds: &[[f64; 2]],
) -> (Vec<f64>, f64) {
    let count = start.len();
    let within = |value: f64, k: usize| value.clamp(bounds[k][0], bounds[k][1]);
    let mut best: Vec<f64> = (0..count).map(|k| within(start[k], k)).collect();
    let mut lowest = values(from_ref(&best))[0];
    let mut step = FIRST_STEP;
    while step >= LAST_STEP {
        let before = best.clone();
        let (mut improved, mut from) = (false, 0);
        // an improvement along an axis is the ground for the axes behind it
        while from < count {
            let trial = |k: usize, side: f64| {
                let mut trial = best.clone();
                trial[k] = within(trial[k] + side * step * (bounds[k][1] - bounds[k][0]), k);
                trial
            };
            let trials: Vec<Vec<f64>> =
                (from..count).flat_map(|k| [1.0, -1.0].map(|side| trial(k, side))).collect();
            let at_trials = values(&trials);
            let Some(place) = at_trials.iter().position(|here| *here < lowest) else { break };
            (best, lowest) = (trials[place].clone(), at_trials[place]);
            improved = true;
            from += place / 2 + 1;
        }
        if !improved {
            step *= 0.5;
            continue;
        }
        // go on in the direction of all improvements together
        let ahead: Vec<f64> = (0..count).map(|k| within(2.0 * best[k] - before[k], k)).collect();
        let here = values(from_ref(&ahead))[0];
        if here < lowest {
            (best, lowest) = (ahead, here);
        }
    }
    (best, lowest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_lowest_point_of_steps_and_of_a_corner() {
        let stairs = |x: &Vec<f64>| libm::floor(20.0 * (x[0] - 0.3).abs()) + (x[1] - 0.7).abs();
        let mut stairs = |points: &[Vec<f64>]| points.iter().map(stairs).collect();
        let (x, value) = descend(&mut stairs, &[0.9, 0.1], &[[0.0, 1.0]; 2]);
        assert!((x[0] - 0.3).abs() < 0.05 && (x[1] - 0.7).abs() < 1e-3 && value < 1e-3, "{x:?}");
        let mut slope = |points: &[Vec<f64>]| points.iter().map(|x| x[0] + x[1]).collect();
        let (x, _) = descend(&mut slope, &[0.9, 0.1], &[[0.2, 1.0], [0.0, 1.0]]);
        assert_eq!(x, [0.2, 0.0]);
    }
}

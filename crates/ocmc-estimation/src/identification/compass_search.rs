//! Least squares within a box without derivatives: steps along the axes, halved when none helps.
//!
//! For residuals that jump, such as those of a driver who switches: derivatives would see the jumps
//! only by chance.

/// First step and last step, as shares of the box.
const FIRST_STEP: f64 = 0.08;
const LAST_STEP: f64 = 2e-5;

/// The best point found from `start`, and its value.
pub fn descend(
    value: &mut dyn FnMut(&[f64]) -> f64,
    start: &[f64],
    bounds: &[[f64; 2]],
) -> (Vec<f64>, f64) {
    let within = |value: f64, k: usize| value.clamp(bounds[k][0], bounds[k][1]);
    let mut best: Vec<f64> = (0..start.len()).map(|k| within(start[k], k)).collect();
    let mut lowest = value(&best);
    let mut step = FIRST_STEP;
    while step >= LAST_STEP {
        let before = best.clone();
        let mut improved = false;
        for k in 0..best.len() {
            for side in [1.0, -1.0] {
                let mut trial = best.clone();
                trial[k] = within(trial[k] + side * step * (bounds[k][1] - bounds[k][0]), k);
                let here = value(&trial);
                if here < lowest {
                    (best, lowest) = (trial, here);
                    improved = true;
                    break;
                }
            }
        }
        if !improved {
            step *= 0.5;
            continue;
        }
        // go on in the direction of all improvements together
        let ahead: Vec<f64> =
            (0..best.len()).map(|k| within(2.0 * best[k] - before[k], k)).collect();
        let here = value(&ahead);
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
        let mut stairs = |x: &[f64]| libm::floor(20.0 * (x[0] - 0.3).abs()) + (x[1] - 0.7).abs();
        let (x, value) = descend(&mut stairs, &[0.9, 0.1], &[[0.0, 1.0]; 2]);
        assert!((x[0] - 0.3).abs() < 0.05 && (x[1] - 0.7).abs() < 1e-3 && value < 1e-3, "{x:?}");
        let mut slope = |x: &[f64]| x[0] + x[1];
        let (x, _) = descend(&mut slope, &[0.9, 0.1], &[[0.2, 1.0], [0.0, 1.0]]);
        assert_eq!(x, [0.2, 0.0]);
    }
}

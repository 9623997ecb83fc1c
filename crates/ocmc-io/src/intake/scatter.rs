//! Points of a receiver that scatter.
//!
//! A road is made of them that is smooth ([`ocmc_core::operating_cycle::road::route_noise`]), which
//! is said. What it costs was found on 200 random roads of 6 to 15 km, with errors of 0.1 to 5 m to
//! the side and 0.1 to 4 m in height (`tests/it/odd_inputs.rs`): half of the answers lie within 1 %
//! of that without errors, and nine of ten within 3.5 %. Errors that fade from point to point over
//! some tens of metres look like bends; they are told by the scatter of every second or fourth
//! point, which is then larger, and are warned of.

use super::Finding;
use crate::number_text::rounded;
use ocmc_core::operating_cycle::road::route_noise::{LEAST_NOISE_M, noise_of_points};

const NAME: &str = "scatter";
/// Scatter of points farther apart over that of neighbours from which on errors have a memory.
const GROWS: f64 = 1.4;

/// Farthest points that are compared, in m.
const FARTHEST_M: f64 = 60.0;

/// Says how much positions or altitudes scatter, in m, where they were smoothed.
pub fn smoothed(what: &str, noise_m: f64) -> Finding {
    let text = format!(
        "its {what} scatter by {} m: the road is what was smoothed of them, and the consumption is \
         off by up to about 3 %",
        rounded(noise_m)
    );
    Finding::mended(NAME, [noise_m, LEAST_NOISE_M], text)
}

/// Looks for errors that fade from point to point.
pub fn with_memory(x_m: &[f64], y_m: &[f64]) -> Option<Finding> {
    let noise_m = |every: usize| {
        let [x_m, y_m] =
            [x_m, y_m].map(|values| values.iter().copied().step_by(every).collect::<Vec<f64>>());
        noise_of_points(&x_m, &y_m)
    };
    let mut steps_m: Vec<f64> =
        (1..x_m.len()).map(|k| libm::hypot(x_m[k] - x_m[k - 1], y_m[k] - y_m[k - 1])).collect();
    steps_m.sort_by(f64::total_cmp);
    let step_m = *steps_m.get(steps_m.len() / 2)?;
    let near_m = noise_m(1);
    // points farther apart tell bends
    let near_enough = |every: &usize| step_m * *every as f64 <= FARTHEST_M;
    let far_m = [2, 4].into_iter().filter(near_enough).map(noise_m).fold(0.0, f64::max);
    if near_m <= 0.0 || far_m < LEAST_NOISE_M || far_m < GROWS * near_m {
        return None;
    }
    let text = format!(
        "its points scatter by {} m from one to the next and by {} m over some of them: errors \
         that fade so slowly look like bends",
        rounded(near_m),
        rounded(far_m)
    );
    let remedy = "the curves of such a track are not those of the road: use a road of a map, or a \
                  column `curvature_per_m`";
    Some(Finding::warned(NAME, [far_m / near_m, GROWS], text, remedy))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    #[test]
    fn errors_with_a_memory_are_told_from_white_ones() {
        for seed in 1..=20 {
            let mut draws = Draws::new(seed, 0, Stream::Pedals);
            let mut track = |memory: f64| {
                let fresh = 2.0 * (1.0 - memory * memory).sqrt();
                let (mut x_m, mut y_m) = (Vec::new(), Vec::new());
                let mut error = [0.0; 2];
                for k in 0..800 {
                    let at_m = 12.0 * f64::from(k);
                    error = error.map(|error| memory * error + fresh * draws.normal());
                    x_m.push(at_m + error[0]);
                    y_m.push(200.0 * f64::sin(at_m / 900.0) + error[1]);
                }
                with_memory(&x_m, &y_m)
            };
            assert_eq!(track(0.0), None, "{seed}");
            assert!(track(0.75).is_some(), "{seed}");
        }
    }
}

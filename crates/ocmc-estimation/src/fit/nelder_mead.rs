//! The smallest value of a function of few variables, without derivatives.
//!
//! Source: J. A. Nelder, R. Mead, A simplex method for function minimization, The Computer Journal
//! 7 (1965), 308-313, with reflection 1, expansion 2, contraction and shrinkage 1/2. The search is
//! begun again from what it found until that changes nothing, since a simplex may collapse early.

/// Most evaluations of one search.
const MOST_EVALUATIONS: usize = 4000;

/// Most searches.
const MOST_SEARCHES: usize = 8;

/// Where the function is smallest, and its value there; `step` is the size of the first simplex.
pub(crate) fn minimise<const D: usize>(
    function: impl Fn(&[f64; D]) -> f64,
    start: [f64; D],
    step: f64,
) -> ([f64; D], f64) {
    let (mut best, mut value) = (start, function(&start));
    for _ in 0..MOST_SEARCHES {
        let (point, lowest) = search(&function, best, step);
        let settled = !(lowest < value - 1e-12 * (1.0 + value.abs()));
        if lowest <= value {
            (best, value) = (point, lowest);
        }
        if settled {
            break;
        }
    }
    (best, value)
}

fn search<const D: usize>(
    function: &impl Fn(&[f64; D]) -> f64,
    start: [f64; D],
    step: f64,
) -> ([f64; D], f64) {
    let mut corners: Vec<([f64; D], f64)> = Vec::with_capacity(D + 1);
    corners.push((start, function(&start)));
    for j in 0..D {
        let mut point = start;
        point[j] += step;
        corners.push((point, function(&point)));
    }
    for _ in 0..MOST_EVALUATIONS / 2 {
        corners.sort_by(|a, b| a.1.total_cmp(&b.1));
        let (best, worst) = (corners[0].1, corners[D].1);
        let size = (0..D).map(|j| (corners[D].0[j] - corners[0].0[j]).abs()).fold(0.0, f64::max);
        if worst - best <= 1e-14 * (1.0 + best.abs()) && size < 1e-7 {
            break;
        }
        let mut centre = [0.0; D];
        for (point, _) in &corners[..D] {
            for j in 0..D {
                centre[j] += point[j] / D as f64;
            }
        }
        let along = |t: f64| {
            let mut point = centre;
            for j in 0..D {
                point[j] += t * (centre[j] - corners[D].0[j]);
            }
            let value = function(&point);
            (point, if value.is_nan() { f64::INFINITY } else { value })
        };
        let reflected = along(1.0);
        let replacement = if reflected.1 < best {
            let expanded = along(2.0);
            Some(if expanded.1 < reflected.1 { expanded } else { reflected })
        } else if reflected.1 < corners[D - 1].1 {
            Some(reflected)
        } else {
            let contracted = if reflected.1 < worst { along(0.5) } else { along(-0.5) };
            (contracted.1 < worst.min(reflected.1)).then_some(contracted)
        };
        if let Some(corner) = replacement {
            corners[D] = corner;
        } else {
            let anchor = corners[0].0;
            for (point, value) in &mut corners[1..] {
                for j in 0..D {
                    point[j] = 0.5 * (point[j] + anchor[j]);
                }
                *value = function(point);
            }
        }
    }
    corners.sort_by(|a, b| a.1.total_cmp(&b.1));
    corners[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_end_of_rosenbrocks_valley() {
        let valley = |x: &[f64; 2]| (1.0 - x[0]).powi(2) + 100.0 * (x[1] - x[0] * x[0]).powi(2);
        let (point, value) = minimise(valley, [-1.2, 1.0], 0.5);
        assert!(value < 1e-12 && (point[0] - 1.0).abs() < 1e-5, "{point:?} {value}");
    }

    #[test]
    fn one_variable() {
        let (point, _) = minimise(|x: &[f64; 1]| (x[0] - 3.0).powi(2), [0.0], 1.0);
        assert!((point[0] - 3.0).abs() < 1e-6);
    }
}

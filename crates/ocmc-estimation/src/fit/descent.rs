//! The smallest value of a smooth function of few variables, by Newton's method on differences.
//!
//! Gradient and Hessian are central differences; a step goes along the Hessian's own directions,
//! each by its slope over its curvature, whichever sign that has, and is halved until it descends.
//! Made for likelihoods in the logarithms of standard deviations, which one digit of the variable
//! changes smoothly and whose evaluation is dear.
//!
//! Source: J. Nocedal, S. J. Wright, Numerical Optimization (2006), section 3.4 \[PK\].

use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Distance of the points of a difference.
const STEP: f64 = 2e-4;
/// Longest step of the search.
const LONGEST: f64 = 2.0;
/// Most steps.
const MOST_STEPS: usize = 60;
/// Most halvings of a step.
const MOST_HALVINGS: usize = 20;
/// Range of the variables: an SD ratio of 1e-6 to 1e6.
const REACH: f64 = 13.8;

/// Where the function is smallest, and its value there. It ends where a step promises less than
/// `tolerance`.
pub(crate) fn descend(
    function: &impl Fn(&[f64]) -> f64,
    start: &[f64],
    tolerance: f64,
) -> (Vec<f64>, f64) {
    let mut point = start.to_vec();
    let mut value = function(&point);
    for _ in 0..MOST_STEPS {
        let (gradient, hessian) = differences(function, &point, value, STEP);
        if !(hessian.iter().all(|x| x.is_finite()) && gradient.iter().all(|x| x.is_finite())) {
            break;
        }
        let own = SymmetricEigen::new(hessian);
        let mut step = DVector::zeros(point.len());
        let mut promised = 0.0;
        for (vector, curvature) in own.eigenvectors.column_iter().zip(own.eigenvalues.iter()) {
            let slope = vector.dot(&gradient);
            let along = -slope / curvature.abs().max(1e-6);
            step += vector * along.clamp(-LONGEST, LONGEST);
            promised += 0.5 * slope * slope / curvature.abs().max(1e-6);
        }
        if !(promised > tolerance) {
            break;
        }
        let mut share = 1.0;
        let mut moved = None;
        for _ in 0..MOST_HALVINGS {
            let trial: Vec<f64> = point
                .iter()
                .zip(&step)
                .map(|(x, s)| (x + share * s).clamp(-REACH, REACH))
                .collect();
            let at = function(&trial);
            if at < value {
                moved = Some((trial, at));
                break;
            }
            share *= 0.5;
        }
        let Some(lower) = moved else { break };
        (point, value) = lower;
    }
    (point, value)
}

/// Gradient and Hessian by central differences; `value` is the function's at the point.
pub(crate) fn differences(
    function: &impl Fn(&[f64]) -> f64,
    point: &[f64],
    value: f64,
    step: f64,
) -> (DVector<f64>, DMatrix<f64>) {
    let count = point.len();
    let at = |moves: &[(usize, f64)]| {
        let mut moved = point.to_vec();
        for (j, by) in moves {
            moved[*j] += by * step;
        }
        function(&moved)
    };
    let sides: Vec<[f64; 2]> = (0..count).map(|j| [at(&[(j, -1.0)]), at(&[(j, 1.0)])]).collect();
    let gradient = sides.iter().map(|[low, high]| (high - low) / (2.0 * step));
    let gradient = DVector::from_iterator(count, gradient);
    let mut hessian = DMatrix::zeros(count, count);
    for j in 0..count {
        let [low, high] = sides[j];
        hessian[(j, j)] = (low + high - 2.0 * value) / (step * step);
        for k in 0..j {
            let both = at(&[(j, 1.0), (k, 1.0)]) + at(&[(j, -1.0), (k, -1.0)]);
            let singly = low + high + sides[k][0] + sides[k][1];
            let mixed = (both - singly + 2.0 * value) / (2.0 * step * step);
            hessian[(j, k)] = mixed;
            hessian[(k, j)] = mixed;
        }
    }
    (gradient, hessian)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_end_of_a_bent_valley() {
        let valley = |x: &[f64]| (1.0 - x[0]).powi(2) + 20.0 * (x[1] - x[0] * x[0]).powi(2);
        let (point, value) = descend(&valley, &[-1.2, 1.0], 1e-12);
        assert!(value < 1e-9 && (point[0] - 1.0).abs() < 1e-4, "{point:?} {value}");
    }

    #[test]
    fn leaves_a_hump_and_goes_along_a_falling_tail() {
        // a maximum at 0, minima at ±1
        let (point, _) = descend(&|x: &[f64]| (x[0] * x[0] - 1.0).powi(2), &[0.1], 1e-14);
        assert!((point[0].abs() - 1.0).abs() < 1e-6, "{point:?}");
        let (point, _) = descend(&|x: &[f64]| (2.0 * x[0]).exp(), &[0.0], 1e-8);
        assert!(point[0] < -7.0, "{point:?}");
    }

    #[test]
    fn curvatures_of_a_quadratic() {
        let f = |x: &[f64]| 3.0 * x[0] * x[0] - 2.0 * x[0] * x[1] + x[1] * x[1] + x[0];
        let (gradient, hessian) = differences(&f, &[0.5, -1.0], f(&[0.5, -1.0]), 1e-3);
        assert!((gradient[0] - 6.0).abs() < 1e-8 && (gradient[1] + 3.0).abs() < 1e-8);
        let wanted = DMatrix::from_row_slice(2, 2, &[6.0, -2.0, -2.0, 2.0]);
        assert!((hessian - wanted).amax() < 1e-7);
    }
}

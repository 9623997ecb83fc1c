//! Nonlinear least squares within a box: Levenberg and Marquardt's method.
//!
//! min ½ Σ r_i(x)²,   lower <= x <= upper
//!
//! Each step solves the damped linear problem [J; √μ D] δ = [−r; 0] by QR, never by normal
//! equations, with J by central differences, D the largest norms that the columns of J have had
//! (Moré, 1978), and the damping μ by the ratio of the real to the predicted gain (Nielsen, 1999).
//! A parameter at a bound with a gradient out of the box is held there; a step that leaves the box
//! is cut at it. Residuals that are not finite refuse a step. Certified on the nonlinear problems
//! of NIST in `tests/nist_nonlinear`.
//!
//! J. J. Moré, "The Levenberg-Marquardt algorithm: implementation and theory", Lecture Notes in
//! Mathematics 630 (1978) 105-116. H. B. Nielsen, "Damping parameter in Marquardt's method", report
//! IMM-REP-1999-05, DTU (1999).

use nalgebra::{DMatrix, DVector};

/// Relative step of the central differences: near the cube root of the rounding error.
const DIFFERENCE: f64 = 6e-6;
/// First damping, relative to the scaled problem.
const FIRST_DAMPING: f64 = 1e-3;
/// Dampings that are tried side by side once the first one has not helped.
const TRIALS: usize = 8;
/// A damping above this finds nothing any more.
const LARGEST_DAMPING: f64 = 1e30;

/// When to stop, and how derivatives are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Relative gain of the sum of squares below which the search ends.
    pub gain: f64,
    /// Relative change of all parameters below which it ends.
    pub step: f64,
    /// Most iterations.
    pub most_iterations: usize,
    /// Relative step of the differences.
    pub difference: f64,
}

impl Default for Tolerances {
    fn default() -> Self {
        Self { gain: 1e-14, step: 1e-11, most_iterations: 1000, difference: DIFFERENCE }
    }
}

/// Where the search ended.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Optimum {
    /// The parameters.
    pub parameters: Vec<f64>,
    /// Σ r².
    pub sum_of_squares: f64,
    /// Derivatives of the residuals there, a row a residual.
    pub jacobian: DMatrix<f64>,
    /// Iterations.
    pub iterations: usize,
    /// Whether a tolerance was met.
    pub converged: bool,
}

/// A step that may be taken.
struct Trial {
    to: Vec<f64>,
    damping: f64,
    is_small: bool,
}

/// The residuals at each of some points, which may be worked out side by side.
pub type ResidualsAt<'a> = &'a mut dyn FnMut(&[Vec<f64>]) -> Vec<Vec<f64>>;

/// Residuals of one point, asked for some points one after the other.
pub fn one_by_one(
    mut residuals: impl FnMut(&[f64]) -> Vec<f64>,
) -> impl FnMut(&[Vec<f64>]) -> Vec<Vec<f64>> {
    move |points| points.iter().map(|x| residuals(x)).collect()
}

/// Minimises the sum of squares of the residuals, from `start`, within the box.
///
/// All points have the same number of residuals.
pub fn minimise(
    residuals: ResidualsAt,
    start: &[f64],
    bounds: &[[f64; 2]],
    tolerances: &Tolerances,
) -> Optimum {
    let count = start.len();
    let within = |value: f64, k: usize| value.clamp(bounds[k][0], bounds[k][1]);
    let mut x: Vec<f64> = (0..count).map(|k| within(start[k], k)).collect();
    let mut r = residuals(&[x.clone()]).pop().expect("one point has its residuals");
    let mut sum = square_sum(&r);
    let mut scale = vec![0.0f64; count];
    let mut damping = FIRST_DAMPING;
    let mut growth = 2.0;
    // derivatives where the search has come to
    let mut ahead: Option<DMatrix<f64>> = None;
    let mut optimum = Optimum {
        parameters: x.clone(),
        sum_of_squares: sum,
        jacobian: DMatrix::zeros(r.len(), count),
        iterations: 0,
        converged: false,
    };
    while optimum.iterations < tolerances.most_iterations && sum.is_finite() {
        optimum.iterations += 1;
        let jacobian = ahead.take().unwrap_or_else(|| {
            let differences = Differences::at(&x, bounds, tolerances.difference);
            differences.jacobian(&residuals(&differences.points), r.len(), count)
        });
        for k in 0..count {
            let norm = jacobian.column(k).norm();
            scale[k] = if norm.is_finite() { scale[k].max(norm) } else { scale[k] };
        }
        // half the slope of the sum of squares along each parameter
        let dot = |k: usize| jacobian.column(k).iter().zip(&r).map(|(a, b)| a * b).sum();
        let slopes: Vec<f64> = (0..count).map(dot).collect();
        let free: Vec<usize> = (0..count)
            .filter(|&k| {
                let [lower, upper] = bounds[k];
                let outwards =
                    (x[k] <= lower && slopes[k] > 0.0) || (x[k] >= upper && slopes[k] < 0.0);
                scale[k] > 0.0 && slopes[k].is_finite() && !outwards
            })
            .collect();
        optimum.jacobian = jacobian;
        // the angle between residual and every direction is right
        let flat = free.iter().all(|&k| slopes[k].abs() <= 1e-14 * scale[k] * sum.sqrt());
        if free.is_empty() || flat || sum == 0.0 {
            optimum.converged = true;
            break;
        }
        let mut moved = false;
        let mut side_by_side = 1;
        while damping < LARGEST_DAMPING && !moved && !optimum.converged {
            let mut trials: Vec<Trial> = Vec::new();
            while trials.len() < side_by_side && damping < LARGEST_DAMPING {
                let step = damped_step(&optimum.jacobian, &r, &free, &scale, damping);
                if let Some(step) = step {
                    let mut to = x.clone();
                    for (place, &k) in free.iter().enumerate() {
                        to[k] = within(x[k] + step[place], k);
                    }
                    let is_small = (0..count).all(|k| {
                        (to[k] - x[k]).abs() <= tolerances.step * (x[k].abs() + tolerances.step)
                    });
                    trials.push(Trial { to, damping, is_small });
                }
                damping *= growth;
                growth *= 2.0;
                if trials.last().is_some_and(|trial| trial.is_small) {
                    break; // no damping behind it is tried
                }
            }
            let mut points: Vec<Vec<f64>> = trials.iter().map(|trial| trial.to.clone()).collect();
            // most first steps are taken: what the next one needs is worked out beside them
            let next = match &points[..] {
                [to] => Differences::at(to, bounds, tolerances.difference),
                _ => Differences::default(),
            };
            points.extend(next.points.iter().cloned());
            let mut at_points = residuals(&points);
            let beside = at_points.split_off(trials.len());
            for (trial, new_r) in trials.into_iter().zip(at_points) {
                let new_sum = square_sum(&new_r);
                if new_sum < sum {
                    let taken: Vec<f64> = (0..count).map(|k| trial.to[k] - x[k]).collect();
                    let predicted = sum - linear_sum(&optimum.jacobian, &r, &taken);
                    let gain = sum - new_sum;
                    let little =
                        gain <= tolerances.gain * sum && predicted <= tolerances.gain * sum;
                    let cube = 2.0 * gain / predicted.max(f64::MIN_POSITIVE) - 1.0;
                    damping = trial.damping * (1.0 - cube * cube * cube).max(1.0 / 3.0);
                    growth = 2.0;
                    (x, r, sum) = (trial.to, new_r, new_sum);
                    ahead = (!beside.is_empty()).then(|| next.jacobian(&beside, r.len(), count));
                    moved = true;
                    optimum.converged = little || trial.is_small;
                    break;
                }
                if trial.is_small {
                    optimum.converged = true;
                    break;
                }
            }
            side_by_side = TRIALS;
        }
        optimum.parameters.clone_from(&x);
        optimum.sum_of_squares = sum;
        if optimum.converged || !moved {
            break;
        }
    }
    optimum
}

/// Central differences, one-sided at a bound.
#[derive(Default)]
struct Differences {
    /// Where the residuals are needed: above and below for each of the parameters that can move.
    points: Vec<Vec<f64>>,
    /// These parameters, and how far the two points are apart.
    widths: Vec<(usize, f64)>,
}

impl Differences {
    fn at(x: &[f64], bounds: &[[f64; 2]], relative: f64) -> Self {
        let moved = |k: usize, to: f64| {
            let mut point = x.to_vec();
            point[k] = to;
            point
        };
        let mut differences = Self::default();
        for (k, [lower, upper]) in bounds.iter().enumerate() {
            let width = upper - lower;
            // of a parameter at zero the bounds give the size
            let size = if width.is_finite() { x[k].abs().max(1e-3 * width) } else { x[k].abs() };
            let step = relative * if size > 0.0 { size } else { 1.0 };
            let (high, low) = ((x[k] + step).min(*upper), (x[k] - step).max(*lower));
            if high > low {
                differences.widths.push((k, high - low));
                differences.points.extend([moved(k, high), moved(k, low)]);
            }
        }
        differences
    }

    /// The derivatives, from the residuals at the points.
    fn jacobian(&self, at_points: &[Vec<f64>], rows: usize, count: usize) -> DMatrix<f64> {
        let mut jacobian = DMatrix::zeros(rows, count);
        for ((k, wide), [above, below]) in self.widths.iter().zip(at_points.as_chunks().0) {
            for row in 0..rows {
                jacobian[(row, *k)] = (above[row] - below[row]) / wide;
            }
        }
        jacobian
    }
}

/// The step of the free parameters that solves the damped linear problem.
fn damped_step(
    jacobian: &DMatrix<f64>,
    r: &[f64],
    free: &[usize],
    scale: &[f64],
    damping: f64,
) -> Option<Vec<f64>> {
    let (rows, count) = (r.len(), free.len());
    let mut matrix = DMatrix::zeros(rows + count, count);
    let mut right = DVector::zeros(rows + count);
    for (place, &k) in free.iter().enumerate() {
        matrix.view_mut((0, place), (rows, 1)).copy_from(&jacobian.column(k));
        matrix[(rows + place, place)] = damping.sqrt() * scale[k];
    }
    for (row, value) in r.iter().enumerate() {
        right[row] = -value;
    }
    let factors = matrix.qr();
    let projected = factors.q().transpose() * right;
    let step = factors.r().solve_upper_triangular(&projected.rows(0, count))?;
    step.iter().all(|value| value.is_finite()).then(|| step.iter().copied().collect())
}

fn square_sum(r: &[f64]) -> f64 {
    let sum: f64 = r.iter().map(|value| value * value).sum();
    if sum.is_finite() { sum } else { f64::INFINITY }
}

/// Σ (r + J δ)².
fn linear_sum(jacobian: &DMatrix<f64>, r: &[f64], step: &[f64]) -> f64 {
    let moved = jacobian * DVector::from_column_slice(step);
    r.iter().zip(moved.iter()).map(|(r, m)| (r + m) * (r + m)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rosenbrock(x: &[f64]) -> Vec<f64> {
        vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]
    }

    #[test]
    fn rosenbrock_with_and_without_a_box() {
        let free = [[f64::NEG_INFINITY, f64::INFINITY]; 2];
        let tolerances = Tolerances::default();
        let minimum = minimise(&mut one_by_one(rosenbrock), &[-1.2, 1.0], &free, &tolerances);
        assert!(minimum.converged && minimum.sum_of_squares < 1e-20, "{minimum:?}");
        // with x0 <= 0.5 the best is at the bound: x1 = 0.25
        let bounds = [[f64::NEG_INFINITY, 0.5], [f64::NEG_INFINITY, 2.0]];
        let minimum = minimise(&mut one_by_one(rosenbrock), &[-1.2, 1.0], &bounds, &tolerances);
        assert!(minimum.parameters[0] == 0.5 && (minimum.parameters[1] - 0.25).abs() < 1e-6);
        assert!(minimum.converged && (minimum.sum_of_squares - 0.25).abs() < 1e-10);
    }

    #[test]
    fn what_is_not_finite_is_not_taken() {
        let mut logarithm = one_by_one(|x| vec![libm::log(x[0]) - 1.0]);
        let free = [[f64::NEG_INFINITY, f64::INFINITY]];
        let minimum = minimise(&mut logarithm, &[20.0], &free, &Tolerances::default());
        assert!((minimum.parameters[0] - std::f64::consts::E).abs() < 1e-9, "{minimum:?}");
    }
}

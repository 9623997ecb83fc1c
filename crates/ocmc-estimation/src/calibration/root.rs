//! Root of a simulated function within a box: Newton's chord method, on samples that grow.
//!
//! The function is a mean over simulated cycles. With the same random numbers at every point it is
//! a fixed function of the point, its root that of the sample; a small sample finds the
//! neighbourhood, a larger one the root: retrospective approximation (Pasupathy, Schmeiser,
//! Root-finding via DARTS, ACM TOMACS 19, 2009). The derivatives are taken once a sample, over
//! steps that are large against what is left of chance: updating them from step to step (Broyden)
//! takes chance for slope.
//!
//! A coordinate that would leave the box stays on its bound, and the equation of the same number is
//! left out: then the others are solved as far as they go.

use nalgebra::{DMatrix, DVector, SMatrix};

/// Most evaluations on one sample after the derivatives.
const MOST_STEPS: usize = 12;
/// Most halvings of a step that leads away.
const MOST_HALVINGS: usize = 3;

/// A box, and what is near enough.
#[derive(Clone, Copy, Debug)]
pub struct Search<const N: usize> {
    /// Lowest coordinates.
    pub lower: [f64; N],
    /// Highest coordinates.
    pub upper: [f64; N],
    /// Steps of the derivatives.
    pub step: [f64; N],
    /// Largest residuals at a root.
    pub tolerance: [f64; N],
}

/// Where a search ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Root<const N: usize> {
    /// The point.
    pub point: [f64; N],
    /// Residual of the function there.
    pub residual: [f64; N],
    /// Coordinates that stay on a bound: their equations are not solved.
    pub at_bound: [bool; N],
    /// Whether all other equations are solved.
    pub solved: bool,
    /// Times that the function was evaluated.
    pub evaluations: usize,
}

/// Forward differences of a function at a point where its value is known; column `k` is the
/// derivative by coordinate `k`. Steps go down where they would leave the box.
///
/// # Errors
/// Those of the function.
pub fn derivatives<const N: usize, Error>(
    function: &mut impl FnMut(&[f64; N]) -> Result<[f64; N], Error>,
    search: &Search<N>,
    point: &[f64; N],
    value: &[f64; N],
) -> Result<SMatrix<f64, N, N>, Error> {
    let mut jacobian = SMatrix::zeros();
    for k in 0..N {
        let mut beside = *point;
        beside[k] += search.step[k];
        if beside[k] > search.upper[k] {
            beside[k] = point[k] - search.step[k];
        }
        let there = function(&beside)?;
        let step = beside[k] - point[k];
        for (row, (a, b)) in there.iter().zip(value).enumerate() {
            jacobian[(row, k)] = (a - b) / step;
        }
    }
    Ok(jacobian)
}

/// Finds a root from a point on, with derivatives that belong near it.
///
/// # Errors
/// Those of the function.
pub fn solve<const N: usize, Error>(
    function: &mut impl FnMut(&[f64; N]) -> Result<[f64; N], Error>,
    search: &Search<N>,
    start: &[f64; N],
    jacobian: &SMatrix<f64, N, N>,
) -> Result<Root<N>, Error> {
    let mut point = *start;
    let mut value = function(&point)?;
    let mut evaluations = 1;
    let mut at_bound = [false; N];
    for _ in 0..MOST_STEPS {
        let Some((step, held)) = search.newton(&point, &value, jacobian) else { break };
        at_bound = held;
        let is_on_bounds = (0..N).all(|k| !at_bound[k] || step[k] == 0.0);
        if is_on_bounds && search.is_root(&value, &at_bound) {
            break;
        }
        let before = search.size(&value, &at_bound);
        let mut share = 1.0;
        for halving in 0..=MOST_HALVINGS {
            let next = std::array::from_fn(|k| {
                (point[k] + share * step[k]).max(search.lower[k]).min(search.upper[k])
            });
            let there = function(&next)?;
            evaluations += 1;
            if search.size(&there, &at_bound) < before || halving == MOST_HALVINGS {
                (point, value) = (next, there);
                break;
            }
            share *= 0.5;
        }
    }
    // where all stay on a bound no equation is solved
    let solved = search.is_root(&value, &at_bound) && at_bound.contains(&false);
    Ok(Root { point, residual: value, at_bound, solved, evaluations })
}

impl<const N: usize> Search<N> {
    fn is_root(&self, value: &[f64; N], at_bound: &[bool; N]) -> bool {
        (0..N).all(|k| at_bound[k] || value[k].abs() <= self.tolerance[k])
    }

    /// Sum of squares in units of the tolerances, without equations that are left out.
    fn size(&self, value: &[f64; N], at_bound: &[bool; N]) -> f64 {
        let parts = (0..N).filter(|k| !at_bound[*k]).map(|k| value[k] / self.tolerance[k]);
        parts.map(|part| part * part).sum()
    }

    /// Newton's step within the box, and which coordinates stay on a bound; none where the
    /// derivatives are singular.
    fn newton(
        &self,
        point: &[f64; N],
        value: &[f64; N],
        jacobian: &SMatrix<f64, N, N>,
    ) -> Option<([f64; N], [bool; N])> {
        let mut held = [None; N];
        // each pass holds at least one coordinate more
        for _ in 0..=N {
            let mut matrix = DMatrix::from_fn(N, N, |i, k| jacobian[(i, k)]);
            let mut right = DVector::from_fn(N, |k, _| -value[k]);
            for (k, bound) in held.iter().enumerate() {
                if let Some(bound) = bound {
                    matrix.row_mut(k).fill(0.0);
                    matrix[(k, k)] = 1.0;
                    right[k] = bound - point[k];
                }
            }
            let step = matrix.lu().solve(&right)?;
            let mut leaves = false;
            for k in (0..N).filter(|k| held[*k].is_none()).collect::<Vec<_>>() {
                let next = point[k] + step[k];
                if next < self.lower[k] || next > self.upper[k] {
                    held[k] = Some(next.max(self.lower[k]).min(self.upper[k]));
                    leaves = true;
                }
            }
            if !leaves {
                return Some((std::array::from_fn(|k| step[k]), held.map(|bound| bound.is_some())));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    const SEARCH: Search<2> = Search {
        lower: [-2.0, 0.0],
        upper: [2.0, 4.0],
        step: [1e-3, 1e-3],
        tolerance: [1e-4, 1e-4],
    };

    fn root(function: impl Fn(&[f64; 2]) -> [f64; 2], start: [f64; 2]) -> Root<2> {
        let mut function = |x: &[f64; 2]| Ok::<_, Infallible>(function(x));
        let value = function(&start).unwrap();
        let jacobian = derivatives(&mut function, &SEARCH, &start, &value).unwrap();
        solve(&mut function, &SEARCH, &start, &jacobian).unwrap()
    }

    #[test]
    fn a_root_within_the_box_is_found() {
        // x² e^y = e and x + y = 2 at (1, 1)
        let e = std::f64::consts::E;
        let solution = root(|x| [x[0] * x[0] * libm::exp(x[1]) - e, x[0] + x[1] - 2.0], [0.7, 0.8]);
        assert!(solution.solved, "{solution:?}");
        assert!((solution.point[0] - 1.0).abs() < 1e-3 && (solution.point[1] - 1.0).abs() < 1e-3);
        assert_eq!(solution.at_bound, [false; 2]);
    }

    #[test]
    fn where_all_coordinates_stay_on_a_bound_nothing_is_solved() {
        let solution = root(|x| [x[0] - 3.0, x[1] + 1.0], [0.0, 1.0]);
        // it is on its way to the corner
        assert!(solution.point[0] > 1.5 && solution.point[1] < 0.5, "{solution:?}");
        assert!(solution.at_bound == [true; 2] && !solution.solved, "{solution:?}");
    }

    #[test]
    fn beyond_the_box_a_coordinate_stays_on_its_bound_and_the_other_is_solved() {
        // the root is at (0.5 + 0.1 · −1, −1); y stays at 0, where x = 0.5
        let solution = root(|x| [x[0] - 0.5 - 0.1 * x[1], x[1] + 1.0], [0.0, 1.0]);
        assert_eq!(solution.at_bound, [false, true]);
        assert!(solution.solved && (solution.point[0] - 0.5).abs() < 1e-3, "{solution:?}");
        assert!(solution.point[1] == 0.0 && (solution.residual[1] - 1.0).abs() < 1e-12);
    }
}

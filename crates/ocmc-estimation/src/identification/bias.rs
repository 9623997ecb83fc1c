//! The bias of nonlinear least squares: how far the curvature of the residuals moves the mean of
//! the estimates.
//!
//! b = −½ s² (JᵀJ)⁻¹ Jᵀ m,   m_i = tr[(JᵀJ)⁻¹ H_i]
//!
//! with the derivatives J and the second derivatives H_i of the residuals r_i, whose noise has the
//! standard deviation s (Box, 1971). It is of second order in the noise.
//! With (JᵀJ)⁻¹ = Σ l lᵀ the trace is the sum of the second derivatives along the directions l, so
//! that two drives for each parameter tell it: one standard error ahead and one back.
//!
//! M. J. Box, "Bias in nonlinear estimation", Journal of the Royal Statistical Society B 33 (1971)
//! 171-201; the formula was read in the documentation of SAS/STAT's procedure NLIN ("Box's measure
//! of bias").
//!
//! Checked against the biases of a root and of a ratio; on events with noise in
//! `examples/identification_study.rs`.

use super::bounded_least_squares::ResidualsAt;
use nalgebra::{DMatrix, DVector};

/// Shortest step ahead and back that is one, in standard errors: a bound may be nearer.
const SHORTEST: f64 = 0.05;

/// The bias of each parameter at an optimum with these derivatives, within the box; 0 of those that
/// do not move there. None where the derivatives or the box do not tell it.
pub(super) fn bias(
    residuals: ResidualsAt,
    optimum: &[f64],
    jacobian: &DMatrix<f64>,
    bounds: &[[f64; 2]],
    deviation: f64,
) -> Option<Vec<f64>> {
    let inside = |k: &usize| {
        let [lower, upper] = bounds[*k];
        optimum[*k] > lower && optimum[*k] < upper && jacobian.column(*k).norm() > 0.0
    };
    let free: Vec<usize> = (0..optimum.len()).filter(inside).collect();
    let factors = jacobian.select_columns(&free).qr();
    let identity = DMatrix::identity(free.len(), free.len());
    let directions = factors.r().solve_upper_triangular(&identity)?;
    let mut points = vec![optimum.to_vec()];
    let mut lengths = Vec::new();
    for direction in directions.column_iter() {
        // as far as both sides stay within the box
        let room = free.iter().zip(direction.iter()).map(|(&k, along)| {
            let [lower, upper] = bounds[k];
            (optimum[k] - lower).min(upper - optimum[k]) / along.abs()
        });
        let length = room.fold(1.0, f64::min);
        if !(length >= SHORTEST) {
            return None;
        }
        lengths.push(length);
        points.extend([length, -length].map(|length| {
            let mut point = optimum.to_vec();
            for (&k, along) in free.iter().zip(direction.iter()) {
                point[k] += length * along;
            }
            point
        }));
    }
    let at_points = residuals(&points);
    let here = &at_points[0];
    let mut traces = DVector::zeros(here.len());
    for ([ahead, back], length) in at_points[1..].as_chunks().0.iter().zip(&lengths) {
        for (row, trace) in traces.iter_mut().enumerate() {
            *trace += (ahead[row] - 2.0 * here[row] + back[row]) / (length * length);
        }
    }
    let moved = factors.r().solve_upper_triangular(&factors.q().tr_mul(&traces))?;
    let mut bias = vec![0.0; optimum.len()];
    for (&k, moved) in free.iter().zip(moved.iter()) {
        bias[k] = -0.5 * deviation * deviation * moved;
    }
    bias.iter().all(|bias| bias.is_finite()).then_some(bias)
}

#[cfg(test)]
mod tests {
    use super::super::bounded_least_squares::one_by_one;
    use super::*;

    const FREE: [f64; 2] = [-100.0, 100.0];

    #[test]
    fn the_bias_of_a_root_and_of_a_ratio() {
        // the mean of n rows is θ²: the root of it has the bias −s² / (8 n θ³)
        let (n, root, sd) = (40, 0.8, 0.05);
        let mut squares = one_by_one(|x| vec![root * root - x[0] * x[0]; n]);
        let jacobian = DMatrix::from_element(n, 1, -2.0 * root);
        let biases = bias(&mut squares, &[root], &jacobian, &[FREE], sd).expect("it is determined");
        let expected = -sd * sd / (8.0 * n as f64 * root.powi(3));
        assert!((biases[0] / expected - 1.0).abs() < 1e-9, "{biases:?}, {expected}");
        // y₁ = a b and y₂ = b, a measurement each: a = y₁ / y₂ has the bias a s² / b², b none
        let (a, b) = (3.0, 2.0);
        let mut ratio = one_by_one(|x| vec![a * b - x[0] * x[1], b - x[1]]);
        let jacobian = DMatrix::from_row_slice(2, 2, &[-b, -a, 0.0, -1.0]);
        let biases =
            bias(&mut ratio, &[a, b], &jacobian, &[FREE; 2], sd).expect("it is determined");
        assert!((biases[0] / (a * sd * sd / (b * b)) - 1.0).abs() < 1e-9, "{biases:?}");
        assert!(biases[1].abs() < 1e-12, "{biases:?}");
    }

    #[test]
    fn straight_residuals_have_none_and_a_bound_says_nothing() {
        let mut line = one_by_one(|x| vec![1.0 - x[0] - x[1], x[0] - 3.0 * x[1], 0.5 - x[1]]);
        let jacobian = DMatrix::from_row_slice(3, 2, &[-1.0, -1.0, 1.0, -3.0, 0.0, -1.0]);
        let biases = bias(&mut line, &[0.4, 0.3], &jacobian, &[FREE; 2], 0.1).expect("determined");
        assert!(biases.iter().all(|bias| bias.abs() < 1e-12), "{biases:?}");
        // one that stands at its bound stays there, one that is close to it is not known
        let held = bias(&mut line, &[0.4, 0.3], &jacobian, &[FREE, [0.3, 1.0]], 0.1);
        assert_eq!(held.expect("the other one is determined")[1], 0.0);
        let close = [FREE, [0.3 - 1e-6, 1.0]];
        assert_eq!(bias(&mut line, &[0.4, 0.3], &jacobian, &close, 0.1), None);
    }
}

//! The delta method: errors of a root from those of what it answers.

use nalgebra::Matrix4;

/// Correlation of errors from their covariance; of what has no error none.
pub(super) fn correlation(covariance: &Matrix4<f64>) -> [[f64; 4]; 4] {
    let sd = |k: usize| libm::sqrt(covariance[(k, k)].max(0.0));
    std::array::from_fn(|i| {
        std::array::from_fn(|k| {
            let product = sd(i) * sd(k);
            match (i == k, product > 0.0) {
                (true, _) => 1.0,
                (false, true) => (covariance[(i, k)] / product).clamp(-1.0, 1.0),
                (false, false) => 0.0,
            }
        })
    })
}

/// Covariance of a root's coordinates: J⁻¹ Σ J⁻ᵀ; what stays on a bound has no error, and is held.
pub(super) fn delta_covariance(
    jacobian: &Matrix4<f64>,
    covariance: &Matrix4<f64>,
    at_bound: [bool; 4],
) -> Matrix4<f64> {
    let (mut matrix, mut covariance) = (*jacobian, *covariance);
    for k in (0..4).filter(|k| at_bound[*k]) {
        matrix.row_mut(k).fill(0.0);
        matrix[(k, k)] = 1.0;
        covariance.row_mut(k).fill(0.0);
        covariance.column_mut(k).fill(0.0);
    }
    let inverse = matrix.try_inverse();
    inverse.map_or_else(
        || Matrix4::repeat(f64::NAN),
        |inverse| inverse * covariance * inverse.transpose(),
    )
}

//! Standard errors of what is estimated from a series that remembers: values an hour apart go
//! together with φ, and k hours apart with φ^k.
//!
//! The covariance of Σ z_t e_t, e with unit variance, is Σ_s Σ_t z_s z_t' φ^|t − s|, summed in one
//! pass over the times, gaps included. A function f of a normal score has the covariances Σ_m a_m²
//! φ^(m k), where a_m are its Hermite coefficients (Mehler's formula).

use nalgebra::DMatrix;

/// Hermite coefficients that are kept.
const ORDERS: usize = 16;
/// Reach and step of the integrals over a normal score.
const REACH: f64 = 8.0;
const STEP: f64 = 0.02;

/// Σ_s Σ_t z_s z_t' φ^|t − s| of rows (time in h, z), in order of time.
pub(super) fn long_run<const K: usize>(
    rows: impl IntoIterator<Item = (f64, [f64; K])>,
    phi: f64,
) -> DMatrix<f64> {
    let mut sum = DMatrix::zeros(K, K);
    // Σ_{s < t} φ^(t − s) z_s
    let mut remembered = [0.0; K];
    let mut last_h = f64::NEG_INFINITY;
    let log_phi = libm::log(phi.clamp(0.0, 1.0 - 1e-9));
    for (time_h, z) in rows {
        let kept = libm::exp(log_phi * (time_h - last_h));
        let kept = if kept.is_finite() { kept } else { 0.0 };
        last_h = time_h;
        for a in 0..K {
            remembered[a] *= kept;
        }
        for a in 0..K {
            for b in 0..K {
                sum[(a, b)] += z[a] * z[b] + z[a] * remembered[b] + remembered[a] * z[b];
            }
        }
        for a in 0..K {
            remembered[a] += z[a];
        }
    }
    sum
}

/// Σ over all lags of φ^|k|: by what memory enlarges the variance of a mean.
pub(super) fn inflation(phi: f64) -> f64 {
    let phi = phi.clamp(0.0, 1.0 - 1e-9);
    (1.0 + phi) / (1.0 - phi)
}

/// Standard error of the standard deviation of a normal series of `n` values.
pub(super) fn sd_error(sd: f64, phi: f64, n: usize) -> f64 {
    sd * libm::sqrt(inflation(phi * phi) / (2.0 * n as f64))
}

/// Coefficients a_1, a_2, … of functions of a normal score: E f(g) He_m(g) / √m!.
pub(super) fn hermite<const F: usize>(f: impl Fn(f64) -> [f64; F]) -> [[f64; F]; ORDERS] {
    let mut coefficients = [[0.0; F]; ORDERS];
    let nodes = libm::round(2.0 * REACH / STEP) as usize;
    for node in 0..=nodes {
        let g = STEP * node as f64 - REACH;
        let weight = STEP * libm::exp(-0.5 * g * g) / libm::sqrt(2.0 * std::f64::consts::PI);
        let values = f(g);
        // He_m / √m! by its recursion
        let (mut before, mut here) = (1.0, g);
        for (m, sums) in coefficients.iter_mut().enumerate() {
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += weight * value * here;
            }
            let order = (m + 1) as f64;
            let next = (g * here - libm::sqrt(order) * before) / libm::sqrt(order + 1.0);
            (before, here) = (here, next);
        }
    }
    coefficients
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pass_is_the_double_sum() {
        let rows = [(0.0, [1.0, 2.0]), (1.0, [0.5, -1.0]), (4.0, [2.0, 0.3]), (5.0, [1.0, 1.0])];
        let sums = long_run(rows, 0.7);
        for a in 0..2 {
            for b in 0..2 {
                let pairs = rows.iter().flat_map(|s| rows.iter().map(move |t| (s, t)));
                let wanted: f64 =
                    pairs.map(|(s, t)| s.1[a] * t.1[b] * 0.7f64.powf((s.0 - t.0).abs())).sum();
                assert!((sums[(a, b)] - wanted).abs() < 1e-12);
            }
        }
        // nothing is remembered
        assert!((long_run(rows, 0.0)[(0, 0)] - 6.25).abs() < 1e-12);
    }

    #[test]
    fn squares_and_cubes_have_their_hermite_coefficients() {
        let coefficients = hermite(|g| [g * g, g * g * g]);
        // g² = He_2 + 1, g³ = He_3 + 3 He_1
        for (m, wanted) in
            [[0.0, 3.0], [2f64.sqrt(), 0.0], [0.0, 6f64.sqrt()], [0.0, 0.0]].into_iter().enumerate()
        {
            for (a, b) in coefficients[m].iter().zip(wanted) {
                assert!((a - b).abs() < 1e-9, "{m}: {a} {b}");
            }
        }
    }
}

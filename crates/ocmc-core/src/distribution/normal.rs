//! Normal law, truncated where a quantity has bounds: compliance with a limit, a departure time.
//!
//! Density φ((x − μ)/σ)/σ, φ(z) = exp(−z²/2)/√(2π), on [lower, upper] divided by its mass there.
//! Sampled by inversion, x = μ + σ Φ⁻¹(Φ(a) + u (Φ(b) − Φ(a))), exactly one uniform a draw. Bounds
//! more than about eight standard deviations above the mean leave no digits of 1 − Φ and give the
//! bound itself.

use super::{Law, moments};
use crate::special_functions::normal_quantile;
use std::f64::consts::SQRT_2;

/// Quantile for p in (0, 1).
pub fn quantile(mean: f64, sd: f64, lower: Option<f64>, upper: Option<f64>, p: f64) -> f64 {
    let limit = |bound: Option<f64>| bound.map(|b| (b - mean) / sd);
    mean + sd * truncated_quantile(limit(lower), limit(upper), p)
}

/// Fits mean and standard deviation (divisor n − 1) without truncation; none for fewer than two
/// different values.
pub fn fit(values: &[f64]) -> Option<Law> {
    let (mean, sd) = moments(values.iter().copied())?;
    (sd > 0.0).then_some(Law::Normal { mean, sd, lower: None, upper: None })
}

/// Quantile of the standard normal truncated to [`lower`, `upper`].
pub(super) fn truncated_quantile(lower: Option<f64>, upper: Option<f64>, p: f64) -> f64 {
    if lower.is_none() && upper.is_none() {
        return normal_quantile(p);
    }
    let cdf = |x: f64| 0.5 * libm::erfc(-x / SQRT_2);
    let a = lower.map_or(0.0, cdf);
    let b = upper.map_or(1.0, cdf);
    let p = (a + (b - a) * p).clamp(f64::MIN_POSITIVE, 1.0 - f64::EPSILON / 2.0);
    normal_quantile(p).clamp(lower.unwrap_or(f64::NEG_INFINITY), upper.unwrap_or(f64::INFINITY))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{SEEDS, assert_follows, assert_near};
    use crate::testing::hundred_thousand;
    use statrs::distribution::{ContinuousCDF, Normal};

    #[test]
    fn draws_follow_the_law_and_fit_back() {
        let law = Law::Normal { mean: 3.0, sd: 2.0, lower: None, upper: None };
        let exact = Normal::new(3.0, 2.0).unwrap();
        for seed in SEEDS {
            let values = hundred_thousand(&law, seed);
            let n = values.len() as f64;
            let Some(Law::Normal { mean, sd, .. }) = fit(&values) else { panic!("a fit") };
            assert_near("mean", mean, 3.0, 2.0 / n.sqrt());
            assert_near("sd", sd, 2.0, 2.0 / (2.0 * n).sqrt());
            assert_follows("normal", values, |x| exact.cdf(x));
        }
    }

    #[test]
    fn truncated_draws_follow_the_law() {
        let exact = Normal::new(1.0, 0.03).unwrap();
        for (lower, upper) in [(Some(0.92), Some(1.05)), (Some(1.02), None), (None, Some(0.95))] {
            let law = Law::Normal { mean: 1.0, sd: 0.03, lower, upper };
            let (a, b) = (lower.map_or(0.0, |x| exact.cdf(x)), upper.map_or(1.0, |x| exact.cdf(x)));
            for seed in SEEDS {
                let values = hundred_thousand(&law, seed);
                assert!(values.iter().all(|x| (law.support().0..=law.support().1).contains(x)));
                assert_follows("truncated", values, |x| (exact.cdf(x) - a) / (b - a));
            }
        }
    }

    #[test]
    fn no_spread_no_fit() {
        assert!(fit(&[]).is_none() && fit(&[1.0]).is_none() && fit(&[2.0, 2.0]).is_none());
        assert!(fit(&[1.0, f64::NAN]).is_none());
    }
}

//! Weibull law: wind speeds.
//!
//! P(x > t) = exp(−(t/λ)^k), shape k, scale λ = mean/Γ(1 + 1/k). Sampled by inversion, one uniform
//! a draw.

use super::{Law, all_positive, practical_exponential};
use crate::random::Draws;

/// One draw.
pub fn sample(mean: f64, shape: f64, draws: &mut Draws) -> f64 {
    scale(mean, shape) * libm::pow(practical_exponential(draws), 1.0 / shape)
}

/// Quantile for p in (0, 1).
pub fn quantile(mean: f64, shape: f64, p: f64) -> f64 {
    scale(mean, shape) * libm::pow(-libm::log1p(-p), 1.0 / shape)
}

/// Maximum likelihood: the shape k of Σ x^k ln x / Σ x^k − 1/k = mean(ln x) by Newton's method from
/// the moments of ln x, and λ^k = mean(x^k). None without values, where one is not positive, or
/// where all are equal.
pub fn fit(values: &[f64]) -> Option<Law> {
    if !all_positive(values) {
        return None;
    }
    let n = values.len() as f64;
    let logs: Vec<f64> = values.iter().map(|x| libm::log(*x)).collect();
    let mean_log = logs.iter().sum::<f64>() / n;
    let spread = logs.iter().map(|y| (y - mean_log) * (y - mean_log)).sum::<f64>() / n;
    if spread.is_nan() || spread <= 0.0 {
        return None;
    }
    // SD(ln x) = π / (k √6)
    let mut shape = std::f64::consts::PI / (6.0 * spread).sqrt();
    let mut power = 1.0;
    for _ in 0..100 {
        // of x^k around the geometric mean, so that no power overflows
        let (mut sum, mut first, mut second) = (0.0, 0.0, 0.0);
        for log in &logs {
            let y = log - mean_log;
            let weight = libm::exp(shape * y);
            sum += weight;
            first += weight * y;
            second += weight * y * y;
        }
        power = sum / n;
        let (first, second) = (first / sum, second / sum);
        let error = first - 1.0 / shape;
        let slope = second - first * first + 1.0 / (shape * shape);
        // at most halved or doubled
        let next = (shape - error / slope).clamp(0.5 * shape, 2.0 * shape);
        let change = (next - shape).abs();
        shape = next;
        if change < 1e-12 * shape {
            break;
        }
    }
    let scale = libm::exp(mean_log) * libm::pow(power, 1.0 / shape);
    let mean = scale * libm::tgamma(1.0 + 1.0 / shape);
    (shape.is_finite() && mean.is_finite()).then_some(Law::Weibull { mean, shape })
}

/// Scale of a mean and shape.
fn scale(mean: f64, shape: f64) -> f64 {
    mean / libm::tgamma(1.0 + 1.0 / shape)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{SEEDS, assert_follows, assert_near};
    use crate::testing::hundred_thousand;
    use statrs::distribution::{ContinuousCDF, Weibull};

    #[test]
    fn draws_follow_the_law_and_fit_back() {
        for (mean, shape) in [(4.0, 2.0), (1.0, 0.8)] {
            let law = Law::Weibull { mean, shape };
            let exact = Weibull::new(shape, scale(mean, shape)).unwrap();
            for seed in SEEDS {
                let values = hundred_thousand(&law, seed);
                let n = values.len() as f64;
                let Some(Law::Weibull { mean: fitted, shape: k }) = fit(&values) else {
                    panic!("a fit")
                };
                // inverse Fisher information: Var(k) = 0.608 k²/n, Var(ln λ) = 1.109/(k² n)
                assert_near("shape", k, shape, shape * (0.607_9 / n).sqrt());
                let log_scale = self::scale(fitted, k).ln();
                let error = (1.108_7 / n).sqrt() / shape;
                assert_near("scale", log_scale, self::scale(mean, shape).ln(), error);
                assert_follows("Weibull", values, |x| exact.cdf(x));
            }
        }
    }

    #[test]
    fn no_spread_no_fit() {
        assert!(fit(&[]).is_none() && fit(&[2.0, 2.0]).is_none() && fit(&[1.0, 0.0]).is_none());
    }
}

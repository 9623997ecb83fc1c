//! Log-normal law: a positive quantity that varies by factors, such as a drag area, a gain, an
//! acceleration.
//!
//! ln x is normal with mean ln(median) and standard deviation `log_sd`; truncation, by inversion,
//! where there are bounds.

use super::normal::truncated_quantile;
use super::{Law, all_positive, moments};

/// Quantile for p in (0, 1).
pub fn quantile(median: f64, log_sd: f64, lower: Option<f64>, upper: Option<f64>, p: f64) -> f64 {
    let limit = |bound: Option<f64>| bound.map(|b| libm::log(b / median) / log_sd);
    let z = truncated_quantile(limit(lower), limit(upper), p);
    let x = median * libm::exp(log_sd * z);
    x.clamp(lower.unwrap_or(0.0), upper.unwrap_or(f64::INFINITY))
}

/// Fits mean and standard deviation (divisor n − 1) of ln x without truncation; none where a value
/// is not positive or all are equal.
pub fn fit(values: &[f64]) -> Option<Law> {
    if !all_positive(values) {
        return None;
    }
    let (log_median, log_sd) = moments(values.iter().map(|x| libm::log(*x)))?;
    let median = libm::exp(log_median);
    (log_sd > 0.0).then_some(Law::LogNormal { median, log_sd, lower: None, upper: None })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{SEEDS, assert_follows, assert_near};
    use crate::testing::hundred_thousand;
    use statrs::distribution::{ContinuousCDF, LogNormal};

    #[test]
    fn draws_follow_the_law_and_fit_back() {
        let law = Law::LogNormal { median: 120.0, log_sd: 0.9, lower: None, upper: None };
        let exact = LogNormal::new(120f64.ln(), 0.9).unwrap();
        for seed in SEEDS {
            let values = hundred_thousand(&law, seed);
            let n = values.len() as f64;
            let Some(Law::LogNormal { median, log_sd, .. }) = fit(&values) else { panic!("a fit") };
            assert_near("median", median.ln(), 120f64.ln(), 0.9 / n.sqrt());
            assert_near("log_sd", log_sd, 0.9, 0.9 / (2.0 * n).sqrt());
            assert_follows("log-normal", values, |x| exact.cdf(x));
        }
    }

    #[test]
    fn truncated_draws_follow_the_law() {
        let exact = LogNormal::new(0.47f64.ln(), 0.4).unwrap();
        let law = Law::LogNormal { median: 0.47, log_sd: 0.4, lower: Some(0.2), upper: Some(1.0) };
        let (a, b) = (exact.cdf(0.2), exact.cdf(1.0));
        for seed in SEEDS {
            let values = hundred_thousand(&law, seed);
            assert!(values.iter().all(|x| (0.2..=1.0).contains(x)));
            assert_follows("truncated", values, |x| (exact.cdf(x) - a) / (b - a));
        }
    }

    #[test]
    fn a_value_that_is_not_positive_does_not_fit() {
        assert!(fit(&[1.0, 0.0]).is_none() && fit(&[1.0, -1.0]).is_none());
        assert!(fit(&[2.0, 2.0]).is_none());
    }
}

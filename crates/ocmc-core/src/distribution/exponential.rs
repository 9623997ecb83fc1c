//! Exponential law: gaps of a Poisson process, waits without memory.
//!
//! P(x > t) = exp(−t/mean). Sampled by inversion, one uniform a draw.

use super::{Law, all_positive, practical_exponential};
use crate::random::Draws;

/// One draw.
pub fn sample(mean: f64, draws: &mut Draws) -> f64 {
    mean * practical_exponential(draws)
}

/// Quantile for p in (0, 1).
pub fn quantile(mean: f64, p: f64) -> f64 {
    -mean * libm::log1p(-p)
}

/// Maximum likelihood: the mean. None without values, or where one is not positive.
pub fn fit(values: &[f64]) -> Option<Law> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (!values.is_empty() && all_positive(values)).then_some(Law::Exponential { mean })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{SEEDS, assert_follows, assert_near};
    use crate::testing::hundred_thousand;
    use statrs::distribution::{ContinuousCDF, Exp};

    #[test]
    fn draws_follow_the_law_and_fit_back() {
        let law = Law::Exponential { mean: 6.0 };
        let exact = Exp::new(1.0 / 6.0).unwrap();
        for seed in SEEDS {
            let values = hundred_thousand(&law, seed);
            let Some(Law::Exponential { mean }) = fit(&values) else { panic!("a fit") };
            assert_near("mean", mean, 6.0, 6.0 / (values.len() as f64).sqrt());
            assert_follows("exponential", values, |x| exact.cdf(x));
        }
    }

    #[test]
    fn nothing_and_negative_values_do_not_fit() {
        assert!(fit(&[]).is_none() && fit(&[1.0, -1.0]).is_none());
    }
}

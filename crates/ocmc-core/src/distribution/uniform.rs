//! Uniform law on (`lower`, `upper`): a range that is all one knows, such as the standstill at a
//! stop sign.

use super::Law;
use crate::random::Draws;

/// One draw.
pub fn sample(lower: f64, upper: f64, draws: &mut Draws) -> f64 {
    draws.uniform_between(lower, upper)
}

/// Quantile for p in (0, 1).
pub fn quantile(lower: f64, upper: f64, p: f64) -> f64 {
    lower + (upper - lower) * p
}

/// Fits the ends without bias: the extremes of n values (the maximum-likelihood estimate) lie
/// (upper − lower)/(n + 1) inside the ends on the average, and are moved out by their range over n
/// − 1. None for fewer than two different values.
pub fn fit(values: &[f64]) -> Option<Law> {
    let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let beyond = (largest - smallest) / (values.len() as f64 - 1.0);
    let finite = values.iter().all(|x| x.is_finite());
    (finite && largest > smallest)
        .then_some(Law::Uniform { lower: smallest - beyond, upper: largest + beyond })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{SEEDS, assert_follows, assert_near};
    use crate::testing::hundred_thousand;

    #[test]
    fn draws_follow_the_law_and_fit_back() {
        let law = Law::Uniform { lower: 2.0, upper: 8.0 };
        for seed in SEEDS {
            let values = hundred_thousand(&law, seed);
            // an extreme lies about 6/n inside its end, and so does its standard error
            let error = 6.0 / values.len() as f64;
            let Some(Law::Uniform { lower, upper }) = fit(&values) else { panic!("a fit") };
            assert_near("lower", lower, 2.0, error);
            assert_near("upper", upper, 8.0, error);
            assert_follows("uniform", values, |x| (x - 2.0) / 6.0);
        }
    }

    #[test]
    fn no_range_no_fit() {
        assert!(fit(&[]).is_none() && fit(&[1.0]).is_none() && fit(&[2.0, 2.0]).is_none());
        assert!(fit(&[1.0, 2.0, f64::NAN]).is_none());
    }
}

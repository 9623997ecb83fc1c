//! Beta law on (0, `scale`): a share of a limit, such as a payload of the room there is.
//!
//! Density proportional to (x/s)^(α−1) (1 − x/s)^(β−1). Sampled as G_α/(G_α + G_β) of two gamma
//! variables.

use super::gamma::{log_standard_gamma, standard_gamma};
use crate::random::Draws;

/// One draw.
pub fn sample(alpha: f64, beta: f64, scale: f64, draws: &mut Draws) -> f64 {
    if alpha < 1.0 || beta < 1.0 {
        // both may be too small for a number, but not their logarithms
        let a = log_standard_gamma(draws, alpha);
        return scale / (1.0 + libm::exp(log_standard_gamma(draws, beta) - a));
    }
    let a = standard_gamma(draws, alpha);
    scale * a / (a + standard_gamma(draws, beta))
}

#[cfg(test)]
mod tests {
    use crate::distribution::Law;
    use crate::statistics::{SEEDS, assert_follows};
    use crate::testing::hundred_thousand;
    use statrs::distribution::{Beta, ContinuousCDF};

    #[test]
    fn all_or_nothing() {
        // the sharpest that a study may have: nearly a coin
        let sharpest = Law::LEAST_SHAPE;
        let law = Law::Beta { alpha: sharpest, beta: sharpest, scale: 1.0 };
        assert!(law.fault().is_none());
        assert!(Law::Beta { alpha: 0.9 * sharpest, beta: 1.0, scale: 1.0 }.fault().is_some());
        let values = hundred_thousand(&law, 1);
        assert!(values.iter().all(|x| (0.0..=1.0).contains(x)));
        let ends = values.iter().filter(|x| **x < 1e-9 || **x > 1.0 - 1e-9).count();
        assert!(ends > 90_000, "{ends}");
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        assert!((mean - 0.5).abs() < 4.0 * 0.5 / (values.len() as f64).sqrt(), "{mean}");
    }

    #[test]
    fn draws_follow_the_law() {
        for (alpha, beta) in [(4.0, 2.0), (0.5, 0.7)] {
            let law = Law::Beta { alpha, beta, scale: 24_300.0 };
            let exact = Beta::new(alpha, beta).unwrap();
            for seed in SEEDS {
                let values = hundred_thousand(&law, seed);
                assert_follows("beta", values, |x| exact.cdf((x / 24_300.0).clamp(0.0, 1.0)));
            }
        }
    }
}

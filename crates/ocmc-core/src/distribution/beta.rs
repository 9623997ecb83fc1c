//! Beta law on (0, `scale`): a share of a limit, such as a payload of the room there is.
//!
//! Density proportional to (x/s)^(α−1) (1 − x/s)^(β−1). Sampled as G_α/(G_α + G_β) of two gamma variables.

use super::standard_gamma;
use crate::random::Draws;

/// One draw.
pub fn sample(alpha: f64, beta: f64, scale: f64, draws: &mut Draws) -> f64 {
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

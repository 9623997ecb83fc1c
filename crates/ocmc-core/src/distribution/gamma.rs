//! Gamma law: amounts that add up, such as rain in an hour or the variance of a block of road.
//!
//! Density x^(k−1) exp(−x/θ) / (Γ(k) θ^k) with shape k and scale θ = mean/k; the coefficient of
//! variation is 1/√k.

use super::{Law, all_positive};
use crate::random::Draws;

/// Shapes beyond this are a constant for all purposes.
const LARGEST_SHAPE: f64 = 1e12;

/// One draw.
pub fn sample(mean: f64, shape: f64, draws: &mut Draws) -> f64 {
    mean / shape * standard_gamma(draws, shape)
}

/// Gamma with scale 1. G. Marsaglia and W. W. Tsang, "A simple method for generating gamma
/// variables", ACM Transactions on Mathematical Software 26 (2000) 363-372.
pub fn standard_gamma(draws: &mut Draws, shape: f64) -> f64 {
    if shape < 1.0 {
        let boost = libm::pow(draws.uniform(), 1.0 / shape);
        return boost * standard_gamma(draws, shape + 1.0);
    }
    let d = shape - 1.0 / 3.0;
    let c = 1.0 / (9.0 * d).sqrt();
    loop {
        let x = draws.normal();
        let t = 1.0 + c * x;
        if t <= 0.0 {
            continue;
        }
        let (v, x_2, u) = (t * t * t, x * x, draws.uniform());
        // the squeeze of the source: where it holds, the inequality of the logarithms does
        if u < 1.0 - 0.0331 * x_2 * x_2 || libm::log(u) < 0.5 * x_2 + d - d * v + d * libm::log(v) {
            return d * v;
        }
    }
}

/// Its logarithm, also where the number itself is too small for a double.
pub fn log_standard_gamma(draws: &mut Draws, shape: f64) -> f64 {
    if shape < 1.0 {
        let boost = libm::log(draws.uniform()) / shape;
        return boost + libm::log(standard_gamma(draws, shape + 1.0));
    }
    libm::log(standard_gamma(draws, shape))
}

/// Maximum likelihood: the mean, and the shape k of ln k − ψ(k) = ln(mean) − mean(ln x), by the
/// iteration of T. P. Minka, "Estimating a gamma distribution" (2002), a Newton step on 1/k that
/// converges within a few rounds. None without values, where one is not positive, or where all are
/// equal.
pub fn fit(values: &[f64]) -> Option<Law> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let mean_log = values.iter().map(|x| libm::log(*x)).sum::<f64>() / n;
    let excess = libm::log(mean) - mean_log;
    if !all_positive(values) || excess.is_nan() || excess <= 0.0 {
        return None;
    }
    let mut shape = 0.5 / excess;
    for _ in 0..100 {
        let slope = shape * shape * (1.0 / shape - trigamma(shape));
        let step = (libm::log(shape) - digamma(shape) - excess) / slope;
        let next = 1.0 / (1.0 / shape + step);
        let change = (next - shape).abs();
        shape = next;
        if change < 1e-12 * shape {
            break;
        }
    }
    (shape > 0.0 && shape < LARGEST_SHAPE).then_some(Law::Gamma { mean, shape })
}

/// ψ(x) for x > 0: the recurrence up to 10, then the asymptotic series (Abramowitz and Stegun
/// 6.3.5, 6.3.18).
pub fn digamma(x: f64) -> f64 {
    let (mut x, mut below) = (x, 0.0);
    while x < 10.0 {
        below += 1.0 / x;
        x += 1.0;
    }
    let y = 1.0 / (x * x);
    let series =
        y * (1.0 / 12.0 - y * (1.0 / 120.0 - y * (1.0 / 252.0 - y * (1.0 / 240.0 - y / 132.0))));
    libm::log(x) - 0.5 / x - series - below
}

/// ψ′(x) for x > 0, likewise (6.4.6, 6.4.12).
pub fn trigamma(x: f64) -> f64 {
    let (mut x, mut below) = (x, 0.0);
    while x < 10.0 {
        below += 1.0 / (x * x);
        x += 1.0;
    }
    let y = 1.0 / (x * x);
    let series = y / x * (1.0 / 6.0 - y * (1.0 / 30.0 - y * (1.0 / 42.0 - y / 30.0)));
    1.0 / x + 0.5 * y + series + below
}

/// About the quantile, by the cube root of a gamma variable being nearly normal (E. B. Wilson and
/// M. M. Hilferty, 1931): good to a few per cent in the tails.
pub fn approximate_quantile(mean: f64, shape: f64, p: f64) -> f64 {
    let root = 1.0 - 1.0 / (9.0 * shape)
        + crate::special_functions::normal_quantile(p) / (3.0 * shape.sqrt());
    let root = root.max(0.0);
    mean * root * root * root
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{SEEDS, assert_follows, assert_near};
    use crate::testing::hundred_thousand;
    use statrs::distribution::{ContinuousCDF, Gamma};

    #[test]
    fn draws_follow_the_law_and_fit_back() {
        for (mean, shape) in [(0.8, 0.7), (5.0, 2.5), (1.0, 1.0), (2.0, 30.0)] {
            let law = Law::Gamma { mean, shape };
            let exact = Gamma::new(shape, shape / mean).unwrap();
            for seed in SEEDS {
                let values = hundred_thousand(&law, seed);
                let n = values.len() as f64;
                let Some(Law::Gamma { mean: fitted, shape: k }) = fit(&values) else {
                    panic!("a fit")
                };
                assert_near("mean", fitted, mean, mean / (shape * n).sqrt());
                // inverse Fisher information; mean and shape are orthogonal
                let error = 1.0 / (n * (trigamma(shape) - 1.0 / shape)).sqrt();
                assert_near("shape", k, shape, error);
                assert_follows("gamma", values, |x| exact.cdf(x));
            }
        }
    }

    #[test]
    fn digamma_and_trigamma_at_one() {
        // Euler's constant and pi²/6
        assert!((digamma(1.0) + 0.577_215_664_901_532_9).abs() < 1e-13);
        assert!((trigamma(1.0) - std::f64::consts::PI.powi(2) / 6.0).abs() < 1e-12);
    }

    #[test]
    fn no_spread_no_fit() {
        assert!(fit(&[]).is_none() && fit(&[2.0, 2.0]).is_none() && fit(&[1.0, 0.0]).is_none());
    }
}

//! Test of a normal law with estimated mean and standard deviation, by Anderson and Darling.
//!
//! A² = −n − (1/n) Σ (2i − 1) (ln Φ(z_i) + ln(1 − Φ(z_{n+1−i}))), of the ordered z = (x − mean)/SD;
//! A*² = A² (1 + 0.75/n + 2.25/n²).
//!
//! Source of the p of A*²: R. B. D'Agostino, M. A. Stephens, Goodness-of-Fit Techniques, 1986,
//! table 4.9 \[PK\].

use super::p_value::ln_normal_tail;
use crate::moments::Moments;

/// A*² beyond which the formula of p turns upwards; p is then at most the one here, 3.7e-24.
const LARGEST: f64 = 10.0;

/// A² of values, and p of a normal law; none with fewer than eight values or without spread.
pub fn normal(values: &[f64]) -> Option<(f64, f64)> {
    let moments = Moments::of(values);
    let (n, mean, sd) = (moments.n, moments.mean, moments.sd());
    if values.len() < 8 || !(sd > 0.0) {
        return None;
    }
    let mut z: Vec<f64> = values.iter().map(|x| (x - mean) / sd).collect();
    z.sort_by(f64::total_cmp);
    let sum: f64 = (0..z.len())
        .map(|i| {
            let weight = 2.0 * i as f64 + 1.0;
            weight * (ln_normal_tail(-z[i]) + ln_normal_tail(z[z.len() - 1 - i]))
        })
        .sum();
    let a2 = -n - sum / n;
    let a = a2 * (1.0 + 0.75 / n + 2.25 / (n * n));
    let p = if a >= 0.6 {
        let a = a.min(LARGEST);
        libm::exp(1.2937 - 5.709 * a + 0.0186 * a * a)
    } else if a > 0.34 {
        libm::exp(0.9177 - 4.279 * a - 1.38 * a * a)
    } else if a > 0.2 {
        1.0 - libm::exp(-8.318 + 42.796 * a - 59.938 * a * a)
    } else {
        1.0 - libm::exp(-13.436 + 101.14 * a - 223.73 * a * a)
    };
    Some((a2, p.clamp(0.0, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    #[test]
    fn rejects_a_true_normal_law_as_often_as_it_says() {
        let mut draws = Draws::new(1, 0, Stream::Vehicle);
        let trials = 4000;
        for limit in [0.05, 0.2, 0.5] {
            let rejected = (0..trials)
                .filter(|_| {
                    let values: Vec<f64> = (0..30).map(|_| 3.0 + 2.0 * draws.normal()).collect();
                    normal(&values).unwrap().1 < limit
                })
                .count() as f64;
            let error = (limit * (1.0 - limit) / trials as f64).sqrt();
            let share = rejected / trials as f64;
            assert!((share - limit).abs() < 4.0 * error, "{limit}: {share}");
        }
    }

    #[test]
    fn rejects_an_exponential_law() {
        let mut draws = Draws::new(1, 0, Stream::Vehicle);
        let values: Vec<f64> = (0..100).map(|_| draws.exponential()).collect();
        assert!(normal(&values).unwrap().1 < 1e-3);
        let many: Vec<f64> = (0..20_000).map(|_| draws.exponential()).collect();
        assert!(normal(&many).unwrap().1 < 1e-20);
        assert!(normal(&values[..7]).is_none() && normal(&[1.0; 20]).is_none());
    }
}

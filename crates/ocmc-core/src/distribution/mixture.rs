//! Mixture: one of several numbers or laws, such as empty and loaded runs, or shifts of the day.
//!
//! P(x ≤ t) = Σ w_i F_i(t) / Σ w_i. One uniform chooses the part, which then takes its own.

use super::Quantity;
use crate::random::Draws;

/// One draw.
pub fn sample(weights: &[f64], components: &[Quantity], draws: &mut Draws) -> f64 {
    let part = draws.index(weights);
    components[part].sample(draws)
}

/// Weighted centre of the parts.
pub fn centre(weights: &[f64], components: &[Quantity]) -> f64 {
    let total: f64 = weights.iter().sum();
    weights.iter().zip(components).map(|(w, c)| w * c.centre()).sum::<f64>() / total
}

/// Smallest and largest possible value.
pub fn support(components: &[Quantity]) -> (f64, f64) {
    span(components.iter().map(|part| match part {
        Quantity::Number(value) => (*value, *value),
        Quantity::Law(law) => law.support(),
        Quantity::Levelled(levelled) => levelled.law.support(),
    }))
}

/// See [`super::Law::practical_range`]; parts without weight do not count.
pub fn practical_range(weights: &[f64], components: &[Quantity]) -> (f64, f64) {
    let drawn = weights.iter().zip(components).filter(|(weight, _)| **weight > 0.0);
    span(drawn.map(|(_, part)| part.practical_range()))
}

/// From the lowest to the highest of several ranges.
fn span(ranges: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    ranges.fold((f64::INFINITY, f64::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::Law;
    use crate::statistics::{SEEDS, assert_follows, assert_share};
    use crate::testing::hundred_thousand;
    use statrs::distribution::{ContinuousCDF, Exp, Normal};

    #[test]
    fn draws_follow_the_law() {
        let part = Quantity::Law;
        let law = Law::Mixture {
            weights: vec![3.0, 1.0],
            components: vec![
                part(Law::Normal { mean: 6.0, sd: 1.0, lower: None, upper: None }),
                part(Law::Exponential { mean: 2.0 }),
            ],
        };
        let (normal, wait) = (Normal::new(6.0, 1.0).unwrap(), Exp::new(0.5).unwrap());
        for seed in SEEDS {
            let values = hundred_thousand(&law, seed);
            assert_follows("mixture", values, |x| 0.75 * normal.cdf(x) + 0.25 * wait.cdf(x));
        }
    }

    #[test]
    fn a_number_has_its_weight() {
        let law = Law::Mixture {
            weights: vec![0.2, 0.8],
            components: vec![0.0.into(), Quantity::Law(Law::Uniform { lower: 1.0, upper: 2.0 })],
        };
        assert!((law.centre() - 1.2).abs() < 1e-12);
        assert!(law.support() == (0.0, 2.0));
        for seed in SEEDS {
            let values = hundred_thousand(&law, seed);
            let empty = values.iter().filter(|x| **x == 0.0).count();
            assert_share("number", empty, values.len(), 0.2);
        }
    }
}

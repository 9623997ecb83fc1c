//! Empirical law: one of given values, with weights or with equal ones.

use crate::random::Draws;

/// One draw: exactly one uniform.
pub fn sample(values: &[f64], weights: Option<&[f64]>, draws: &mut Draws) -> f64 {
    match weights {
        Some(weights) => values[draws.index(weights)],
        None => values[(draws.uniform() * values.len() as f64) as usize],
    }
}

/// Weighted mean of the values.
pub fn mean(values: &[f64], weights: Option<&[f64]>) -> f64 {
    match weights {
        Some(weights) => {
            let total: f64 = weights.iter().sum();
            weights.iter().zip(values).map(|(w, v)| w * v).sum::<f64>() / total
        }
        None => values.iter().sum::<f64>() / values.len() as f64,
    }
}

/// Smallest and largest value.
pub fn support(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |a, &v| (a.0.min(v), a.1.max(v)))
}

#[cfg(test)]
mod tests {
    use crate::distribution::Law;
    use crate::statistics::{SEEDS, assert_share};
    use crate::testing::hundred_thousand;

    #[test]
    fn each_value_has_its_share() {
        let values = vec![5.0, 1.0, 3.0, 2.0];
        for weights in [None, Some(vec![1.0, 2.0, 0.0, 5.0])] {
            let law = Law::Empirical { values: values.clone(), weights: weights.clone() };
            let weights = weights.unwrap_or(vec![2.0; 4]);
            for seed in SEEDS {
                let drawn = hundred_thousand(&law, seed);
                for (value, weight) in values.iter().zip(&weights) {
                    let count = drawn.iter().filter(|x| *x == value).count();
                    assert_share("value", count, drawn.len(), weight / 8.0);
                }
            }
        }
    }
}

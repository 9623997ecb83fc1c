//! Whether ranks are uniform: the test of Kolmogorov and Smirnov.
//!
//! D = sup |Fₙ(u) − u|; p = Q((√n + 0.12 + 0.11/√n) D), Q(λ) = 2 Σ (−1)^(j−1) exp(−2 j² λ²).
//! Source of the finite-n form: Stephens, *Journal of the Royal Statistical Society B* 32 (1970)
//! 115. Ranks among one sample of m simulated values share its chance: as in the test of two
//! samples n m / (n + m) stands for n.

use serde::Serialize;

/// Fewest values that are tested.
const FEWEST: usize = 8;
/// Terms of the series: beyond them nothing is left where λ is above 0.2.
const TERMS: i32 = 100;
/// λ below which Q is 1 to twelve digits.
const SMALLEST_LAMBDA: f64 = 0.2;

/// The test of some ranks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Uniformity {
    /// Number of values.
    pub n: usize,
    /// Largest distance D from the uniform law.
    pub distance: f64,
    /// Probability of a larger one where the ranks are uniform.
    pub p: f64,
}

impl Uniformity {
    /// Uniformity of independent ranks among samples of their own, or all among one sample of
    /// `shared` values; none of fewer than 8.
    pub fn of(ranks: &[f64], shared: Option<usize>) -> Option<Self> {
        let mut sorted: Vec<f64> = ranks.iter().copied().filter(|rank| rank.is_finite()).collect();
        if sorted.len() < FEWEST {
            return None;
        }
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len() as f64;
        let apart = sorted.iter().enumerate().map(|(k, u)| {
            let (before, after) = (k as f64 / n, (k + 1) as f64 / n);
            (u - before).max(after - u)
        });
        let distance = apart.fold(0.0, f64::max);
        let size = shared.map_or(n, |m| n * m as f64 / (n + m as f64));
        let root = size.sqrt();
        let p = kolmogorov_tail((root + 0.12 + 0.11 / root) * distance);
        Some(Self { n: sorted.len(), distance, p })
    }
}

/// Q(λ): the probability of a larger distance.
fn kolmogorov_tail(lambda: f64) -> f64 {
    if !(lambda > SMALLEST_LAMBDA) {
        return 1.0;
    }
    let term = |j: i32| {
        let j = f64::from(j);
        libm::exp(-2.0 * j * j * lambda * lambda)
    };
    let sum: f64 = (1..=TERMS).map(|j| if j % 2 == 1 { term(j) } else { -term(j) }).sum();
    (2.0 * sum).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn critical_values_are_those_of_the_tables() {
        // the limits of the Kolmogorov law: Smirnov, Annals of Mathematical Statistics 19 (1948)
        // 279
        for (lambda, p) in [(1.2238, 0.10), (1.3581, 0.05), (1.6276, 0.01)] {
            assert!((kolmogorov_tail(lambda) - p).abs() < 1e-4, "{lambda}");
        }
        assert_eq!((kolmogorov_tail(0.0), kolmogorov_tail(f64::NAN)), (1.0, 1.0));
        assert!(kolmogorov_tail(20.0) < 1e-300);
    }

    #[test]
    fn what_is_not_uniform_is_found() {
        let even: Vec<f64> = (0..100).map(|k| (f64::from(k) + 0.5) / 100.0).collect();
        let uniformity = Uniformity::of(&even, None).unwrap();
        assert!((uniformity.distance - 0.005).abs() < 1e-12 && uniformity.p > 0.999);
        let narrow: Vec<f64> = even.iter().map(|u| 0.5 + 0.5 * (u - 0.5)).collect();
        assert!(Uniformity::of(&narrow, None).unwrap().p < 1e-4);
        // the chance of a small sample makes distances larger
        let [alone, shared] = [None, Some(100)].map(|m| Uniformity::of(&narrow, m).unwrap().p);
        assert!(shared > alone);
        assert!(Uniformity::of(&even[..7], None).is_none());
        assert!(Uniformity::of(&[f64::NAN; 20], None).is_none());
    }
}

//! Estimators of the shares of a variance, from the outputs of a design of two samples and of one
//! for each group in which this group alone is taken from the other sample.
//!
//! With f the outputs of A, B and AB_i, centred by their common mean, and V the variance of A and B
//! together:
//!
//! first order  S_i = mean f(B) (f(AB_i) − f(A)) / V       share that the group explains alone
//! total        T_i = mean (f(A) − f(AB_i))² / 2 V         share that would be gone if the group
//! were fixed, joint effects included
//!
//! Sources: A. Saltelli et al., *Computer Physics Communications* 181 (2010) 259, table 2 (b) and
//! (f), the latter from M. J. W. Jansen, *Computer Physics Communications* 117 (1999) 35 \[PK\].
//! Intervals are percentiles of bootstrap samples of independent groups of rows; below
//! [`LEAST_GROUPS`] groups there is no interval. Estimates are reported as they are: one of a small
//! share may be negative.

use super::quantile::quantile;
use ocmc_core::random::{Draws, Stream};

/// Bootstrap samples behind an interval.
pub const BOOTSTRAP_SAMPLES: u64 = 1000;

/// Fewest independent groups of rows for which intervals are: resampled from fewer, they are far
/// too narrow.
pub const LEAST_GROUPS: usize = 10;

/// Outputs of the design: those of A and B, and of each AB_i.
#[derive(Clone, Debug)]
pub(super) struct Outputs {
    pub a: Vec<f64>,
    pub b: Vec<f64>,
    pub ab: Vec<Vec<f64>>,
    /// Rows that depend on one another; groups of them do not.
    pub groups: Vec<Vec<usize>>,
}

/// The estimates of one group.
#[derive(Clone, Copy, Debug)]
pub(super) struct Share {
    pub first: f64,
    pub first_ci95: Option<[f64; 2]>,
    pub total: f64,
    pub total_ci95: Option<[f64; 2]>,
}

/// Terms of one row, outputs centred by the mean of the whole sample; the estimators are quotients
/// of their sums.
#[derive(Clone, Copy, Debug)]
struct Term {
    /// f(B) (f(AB) − f(A))
    product: f64,
    /// f(AB) − f(A)
    difference: f64,
    /// (f(AB) − f(A))²
    square: f64,
}

impl Outputs {
    /// Mean and variance (divisor 2 n − 1) of A and B together.
    pub(super) fn moments(&self) -> (f64, f64) {
        let n = 2.0 * self.a.len() as f64;
        let all = || self.a.iter().chain(&self.b);
        let mean = all().sum::<f64>() / n;
        (mean, all().map(|f| (f - mean) * (f - mean)).sum::<f64>() / (n - 1.0))
    }

    /// First and total shares of each group, with bootstrap intervals whose draws the seed fixes.
    pub(super) fn shares(&self, seed: u64) -> Vec<Share> {
        let (mean, _) = self.moments();
        let n = self.a.len();
        let sums: Vec<f64> = (0..n).map(|k| (self.a[k] - mean) + (self.b[k] - mean)).collect();
        let squares: Vec<f64> = (0..n)
            .map(|k| {
                (self.a[k] - mean) * (self.a[k] - mean) + (self.b[k] - mean) * (self.b[k] - mean)
            })
            .collect();
        let terms: Vec<Vec<Term>> = self
            .ab
            .iter()
            .map(|ab| {
                let term = |k: usize| {
                    let difference = ab[k] - self.a[k];
                    let product = (self.b[k] - mean) * difference;
                    Term { product, difference, square: difference * difference }
                };
                (0..n).map(term).collect()
            })
            .collect();
        let estimate = |rows: &[usize]| -> Vec<(f64, f64)> {
            let n = rows.len() as f64;
            // the sample's own mean, as seen from that of the whole
            let shift = rows.iter().map(|&k| sums[k]).sum::<f64>() / (2.0 * n);
            let square = rows.iter().map(|&k| squares[k]).sum::<f64>();
            let variance = (square - 2.0 * n * shift * shift) / (2.0 * n - 1.0);
            let share = |terms: &Vec<Term>| {
                let (mut product, mut difference, mut square) = (0.0, 0.0, 0.0);
                for &k in rows {
                    product += terms[k].product;
                    difference += terms[k].difference;
                    square += terms[k].square;
                }
                let first = (product - shift * difference) / (n * variance);
                (first, square / (2.0 * n * variance))
            };
            terms.iter().map(share).collect()
        };
        let all: Vec<usize> = (0..n).collect();
        let estimates = estimate(&all);
        let mut samples = vec![(Vec::new(), Vec::new()); estimates.len()];
        let count = self.groups.len();
        let bootstrap = if count < LEAST_GROUPS { 0 } else { BOOTSTRAP_SAMPLES };
        for number in 0..bootstrap {
            let drawn = drawn_again(seed, number, count);
            let rows: Vec<usize> = drawn.flat_map(|group| self.groups[group].clone()).collect();
            for (sample, (first, total)) in samples.iter_mut().zip(estimate(&rows)) {
                sample.0.push(first);
                sample.1.push(total);
            }
        }
        estimates
            .into_iter()
            .zip(samples)
            .map(|((first, total), (firsts, totals))| Share {
                first,
                first_ci95: percentiles(firsts),
                total,
                total_ci95: percentiles(totals),
            })
            .collect()
    }
}

/// Parts, of `count`, that a bootstrap sample of that number has, drawn with replacement.
pub(super) fn drawn_again(seed: u64, number: u64, count: usize) -> impl Iterator<Item = usize> {
    let mut draws = Draws::new(seed, number, Stream::Bootstrap);
    (0..count).map(move |_| (draws.uniform() * count as f64) as usize)
}

/// 2.5 % and 97.5 % points of bootstrap estimates, where there are any.
pub(super) fn percentiles(mut estimates: Vec<f64>) -> Option<[f64; 2]> {
    estimates.sort_unstable_by(f64::total_cmp);
    Some([quantile(&estimates, 0.025)?, quantile(&estimates, 0.975)?])
}

/// Whether a known share lies in its interval: 1 or 0.
#[cfg(test)]
pub(super) fn inside(ci95: Option<[f64; 2]>, known: f64) -> u64 {
    let [low, high] = ci95.expect("enough rows");
    u64::from(low <= known && known <= high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Outputs of a function of `D` independent uniforms under the design.
    fn outputs<const D: usize>(f: impl Fn([f64; D]) -> f64, rows: usize, seed: u64) -> Outputs {
        let mut first = Draws::new(seed, 0, Stream::Curve);
        let mut second = Draws::of_second_sample(seed, 0, Stream::Curve);
        let groups = (0..rows).map(|row| vec![row]).collect();
        let mut design = Outputs { a: Vec::new(), b: Vec::new(), ab: vec![Vec::new(); D], groups };
        for _ in 0..rows {
            let a: [f64; D] = std::array::from_fn(|_| first.uniform());
            let b: [f64; D] = std::array::from_fn(|_| second.uniform());
            design.a.push(f(a));
            design.b.push(f(b));
            for i in 0..D {
                let mut ab = a;
                ab[i] = b[i];
                design.ab[i].push(f(ab));
            }
        }
        design
    }

    fn ishigami(u: [f64; 3]) -> f64 {
        let x = u.map(|u| PI * (2.0 * u - 1.0));
        libm::sin(x[0]) * (1.0 + 0.1 * libm::pow(x[2], 4.0)) + 7.0 * libm::pow(libm::sin(x[1]), 2.0)
    }

    /// T. Ishigami, T. Homma (1990), a = 7, b = 0.1: V₁ = (1 + b π⁴/5)²/2, V₂ = a²/8, V₁₃ = b² π⁸
    /// (1/18 − 1/50).
    fn ishigami_shares() -> ([f64; 3], [f64; 3]) {
        let v1 = (1.0 + 0.1 * PI.powi(4) / 5.0).powi(2) / 2.0;
        let v2 = 49.0 / 8.0;
        let v13 = 0.01 * PI.powi(8) * (1.0 / 18.0 - 1.0 / 50.0);
        let v = v1 + v2 + v13;
        ([v1 / v, v2 / v, 0.0], [(v1 + v13) / v, v2 / v, v13 / v])
    }

    const G: [f64; 4] = [0.0, 1.0, 4.5, 9.0];

    /// Sobol's g function.
    fn g(u: [f64; 4]) -> f64 {
        u.iter().zip(G).map(|(u, a)| (libm::fabs(4.0 * u - 2.0) + a) / (1.0 + a)).product()
    }

    /// V_i = 1/(3 (1 + a_i)²), V = Π (1 + V_i) − 1, T_i = V_i Π_{j≠i} (1 + V_j) / V.
    fn g_shares() -> ([f64; 4], [f64; 4]) {
        let v = G.map(|a| 1.0 / (3.0 * (1.0 + a) * (1.0 + a)));
        let product: f64 = v.iter().map(|v| 1.0 + v).product();
        let whole = product - 1.0;
        (v.map(|v| v / whole), v.map(|v| v * product / (1.0 + v) / whole))
    }

    fn check<const D: usize>(
        f: impl Fn([f64; D]) -> f64 + Copy,
        (first, total): ([f64; D], [f64; D]),
    ) {
        for seed in 1..=3 {
            for (i, share) in outputs(f, 4000, seed).shares(seed).into_iter().enumerate() {
                for (estimate, ci95, known) in [
                    (share.first, share.first_ci95, first[i]),
                    (share.total, share.total_ci95, total[i]),
                ] {
                    let [low, high] = ci95.expect("4000 rows");
                    // half of a 95 % interval is 1.96 standard errors
                    let error = (high - low) / 3.92;
                    let off = (estimate - known).abs();
                    assert!(
                        off < 4.0 * error + 1e-12,
                        "seed {seed}, {i}: {estimate} {known} {error}"
                    );
                    assert!(error < 0.03, "{error}");
                }
            }
        }
    }

    #[test]
    fn shares_of_the_ishigami_function_are_the_known_ones() {
        check(ishigami, ishigami_shares());
    }

    #[test]
    fn shares_of_sobols_g_function_are_the_known_ones() {
        check(g, g_shares());
    }

    #[test]
    fn intervals_cover_the_known_shares_about_as_often_as_they_should() {
        const RUNS: u64 = 100;
        let (first, total) = g_shares();
        let mut covered = 0;
        for seed in 0..RUNS {
            for (i, share) in outputs(g, 300, 1000 + seed).shares(seed).into_iter().enumerate() {
                covered += inside(share.first_ci95, first[i]) + inside(share.total_ci95, total[i]);
            }
        }
        // percentile intervals of skewed estimates cover a little less; the eight of one run are
        // not independent
        let share = covered as f64 / (8 * RUNS) as f64;
        assert!((0.90..0.98).contains(&share), "{share}");
    }

    #[test]
    fn the_mean_of_the_outputs_does_not_matter() {
        let far = outputs(|u| 1e6 + ishigami(u), 500, 1).shares(1);
        for (far, near) in far.into_iter().zip(outputs(ishigami, 500, 1).shares(1)) {
            assert!((far.first - near.first).abs() < 1e-7 && (far.total - near.total).abs() < 1e-7);
        }
    }
}

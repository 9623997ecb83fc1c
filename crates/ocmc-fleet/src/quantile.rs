//! Quantiles of a sample and their confidence intervals by order statistics, which assume no law.

use super::clustering::Clusters;

/// The quantiles that a summary reports, with their names.
pub const LEVELS: [(f64, &str); 6] =
    [(0.05, "p5"), (0.25, "p25"), (0.5, "p50"), (0.75, "p75"), (0.95, "p95"), (0.99, "p99")];

/// Probability that each tail of a 95 % interval may hold.
pub(super) const TAIL: f64 = 0.025;

/// Weights of the binomial law below this share of its largest are left out of its sum.
const NEGLIGIBLE: f64 = 1e-20;

/// The quantile of a sorted sample, linear between order statistics: x₍ₕ₎ with h = 1 + (n − 1) p.
///
/// This is type 7 of Hyndman and Fan, *The American Statistician* 50 (1996) 361, the default of
/// NumPy and R.
pub fn quantile(sorted: &[f64], level: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let place = last as f64 * level;
    let below = libm::floor(place);
    let low = sorted[(below as usize).min(last)];
    let high = sorted[(below as usize + 1).min(last)];
    Some(low + (place - below) * (high - low))
}

/// The 95 % interval [x₍ₗ₎, x₍ᵤ₎] of a quantile of a sorted sample; none where the sample is too
/// small.
///
/// With B ~ Bin(n, p), the number of values below the quantile: l is the largest rank with P(B < l)
/// <= 2.5 %, u the smallest with P(B >= u) <= 2.5 %. P99 needs 368 values, P5 and P95 need 72.
///
/// Source: David and Nagaraja, *Order Statistics*, 3rd ed. (2003), section 7.1.
pub fn interval(sorted: &[f64], level: f64) -> Option<[f64; 2]> {
    let (low, high) = ranks(sorted.len(), level)?;
    Some([sorted[low - 1], sorted[high - 1]])
}

/// As [`interval`], for values of cycles that depend on one another, given with their ids in the
/// order of these.
///
/// With F the share of values up to the quantile and h half of its 95 % interval as a ratio of
/// clusters ([`super::dependence`], [`super::clustering`]): the order statistics at the levels
/// p − h and p + h, rounded outwards.
///
/// Source: R. S. Woodruff, *Journal of the American Statistical Association* 47 (1952) 635 \[PK\].
pub fn interval_of_clusters(
    sorted: &[f64],
    level: f64,
    clusters: &Clusters,
    values: impl Iterator<Item = (u64, f64)> + Clone,
) -> Option<[f64; 2]> {
    // where independent values are too few, so are these
    let independent = interval(sorted, level)?;
    if clusters.are_independent() {
        return Some(independent);
    }
    let quantile = quantile(sorted, level)?;
    let below = values.map(|(cycle_id, x)| (cycle_id, f64::from(x <= quantile), 1.0));
    let [low, high] = clusters.ratio(below)?.ci95?;
    let half_width = (high - low) / 2.0;
    let n = sorted.len() as f64;
    let low = libm::floor(n * (level - half_width));
    let high = libm::ceil(n * (level + half_width)) + 1.0;
    (low >= 1.0 && high <= n).then(|| [sorted[low as usize - 1], sorted[high as usize - 1]])
}

/// Ranks l and u of [`interval`], from 1.
fn ranks(n: usize, level: f64) -> Option<(usize, usize)> {
    let (first, weights) = binomial_weights(n, level);
    let total: f64 = weights.iter().sum();
    let allowed = TAIL * total;
    // P(B < l) grows with l: take ranks while the tail fits
    let within = |weights: &mut dyn Iterator<Item = &f64>| {
        let mut tail = 0.0;
        let fits = |weight: &&f64| {
            tail += **weight;
            tail <= allowed
        };
        weights.take_while(fits).count()
    };
    let low = first + within(&mut weights.iter());
    let high = first + weights.len() - within(&mut weights.iter().rev());
    (low >= 1 && high <= n).then_some((low, high))
}

/// P(B <= k) and P(B >= k) of a binomial law.
pub(super) fn binomial_tails(n: usize, p: f64, k: usize) -> [f64; 2] {
    let (first, weights) = binomial_weights(n, p);
    let total: f64 = weights.iter().sum();
    let place = |k: usize| k.saturating_sub(first).min(weights.len());
    let below: f64 = weights[..place(k + 1)].iter().sum();
    let above: f64 = weights[place(k)..].iter().sum();
    [below / total, above / total]
}

/// Probabilities of a binomial law relative to its mode, from the returned value on. Their number
/// grows as √n.
///
/// P(k + 1) / P(k) = (n − k)/(k + 1) · p/(1 − p), so no factorial and no logarithm is needed.
fn binomial_weights(n: usize, p: f64) -> (usize, Vec<f64>) {
    let mode = (((n + 1) as f64 * p) as usize).min(n);
    let odds = p / (1.0 - p);
    let mut weights = Vec::new();
    let mut weight = 1.0;
    let mut first = mode;
    while first > 0 {
        weight *= first as f64 / ((n - first + 1) as f64 * odds);
        if weight < NEGLIGIBLE {
            break;
        }
        weights.push(weight);
        first -= 1;
    }
    weights.reverse();
    weights.push(1.0);
    weight = 1.0;
    for k in mode..n {
        weight *= (n - k) as f64 / (k + 1) as f64 * odds;
        if weight < NEGLIGIBLE {
            break;
        }
        weights.push(weight);
    }
    (first, weights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dependence::Dependence;
    use ocmc_core::random::{Stream, Streams};

    /// Exact coverage of the interval for a continuous law: P(l <= B < u).
    fn coverage(n: usize, level: f64) -> f64 {
        let (low, high) = ranks(n, level).expect("large enough");
        let (first, weights) = binomial_weights(n, level);
        let total: f64 = weights.iter().sum();
        let inside = |k: usize| low <= k && k < high;
        weights.iter().enumerate().filter(|(i, _)| inside(first + i)).map(|(_, w)| w).sum::<f64>()
            / total
    }

    #[test]
    fn small_samples_by_hand() {
        assert_eq!(quantile(&[], 0.5), None);
        assert_eq!(quantile(&[7.0], 0.99), Some(7.0));
        assert_eq!(quantile(&[1.0, 2.0, 4.0, 8.0], 0.5), Some(3.0));
        assert_eq!(quantile(&[1.0, 2.0, 4.0, 8.0], 0.25), Some(1.75));
        assert_eq!(interval(&[], 0.5), None);
        assert_eq!(interval(&[1.0], 0.5), None);
        // P(B = 0) = 1/32 > 2.5 % for n = 5, and 1/64 for n = 6: the whole sample is the interval
        assert_eq!(interval(&[1.0, 2.0, 3.0, 4.0, 5.0], 0.5), None);
        assert_eq!(interval(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 0.5), Some([1.0, 6.0]));
    }

    #[test]
    fn ranks_are_those_of_the_tables() {
        // median of 100: ranks 40 and 61 (David and Nagaraja; exact coverage 96.48 %)
        assert_eq!(ranks(100, 0.5), Some((40, 61)));
        assert!((coverage(100, 0.5) - 0.9648).abs() < 1e-4);
    }

    #[test]
    fn ranks_of_batches_by_hand() {
        let sorted: Vec<f64> = (1..=32).map(f64::from).collect();
        // the values 1 to 32 in batches of four: of each batch so many are among the lowest
        let ranks = |batch: u64, level: f64, lowest: [u64; 8]| {
            let count: u64 = lowest.iter().sum();
            let (mut low, mut high) = (1..=count, count + 1..=32);
            let cycles: Vec<(u64, f64)> = (0..32)
                .map(|id| {
                    let is_low = id % 4 < lowest[id as usize / 4];
                    let value = if is_low { low.next() } else { high.next() };
                    (id, value.expect("so many of each") as f64)
                })
                .collect();
            let dependence = Dependence { batch, ..Dependence::default() };
            interval_of_clusters(&sorted, level, &dependence.into(), cycles.into_iter())
        };
        let halves = [0, 1, 1, 2, 2, 3, 3, 4];
        // R = 16/32; squares of y - 4 R: 12; se = √(8/7 · 12)/32 = 0.115728; t₀.₉₇₅(7) = 2.364624;
        // h = 0.273652: ranks ⌊32 (0.5 − h)⌋ = ⌊7.243⌋ and ⌈32 (0.5 + h)⌉ + 1 = ⌈24.757⌉ + 1
        assert_eq!(ranks(4, 0.5, halves), Some([7.0, 26.0]));
        // independent values: P(B < 10) = 1.003 % and P(B < 11) = 2.505 % of Bin(32, 1/2)
        assert_eq!(ranks(1, 0.5, halves), Some([10.0, 23.0]));
        // one batch has no spread
        assert_eq!(ranks(32, 0.5, halves), None);
        // R = 8/32; squares of y - 4 R: 2; h = 2.364624 √(8/7 · 2)/32 = 0.111718: ⌊4.425⌋ and
        // ⌈11.575⌉ + 1
        assert_eq!(ranks(4, 0.25, [1, 1, 1, 1, 1, 1, 2, 0]), Some([4.0, 13.0]));
        // squares: 8; h = 0.223436: ⌊0.850⌋ is no rank
        assert_eq!(ranks(4, 0.25, [2, 2, 2, 2, 0, 0, 0, 0]), None);
    }

    #[test]
    fn smallest_samples_of_each_quantile() {
        for (level, n) in [(0.99, 368), (0.95, 72), (0.05, 72), (0.5, 6)] {
            assert_eq!(ranks(n - 1, level), None, "{level}");
            assert!(ranks(n, level).is_some(), "{level}");
        }
    }

    #[test]
    fn never_below_95_percent_and_close_to_it_in_large_samples() {
        for (level, _) in LEVELS {
            for n in [400, 5_000, 1_000_000] {
                assert!(coverage(n, level) >= 0.95, "{level} {n}");
            }
            assert!(coverage(1_000_000, level) < 0.9525, "{level}");
        }
    }

    #[test]
    fn intervals_cover_known_quantiles_as_often_as_they_should() {
        const RUNS: u64 = 2000;
        const SIZE: usize = 400;
        for seed in 1..=3 {
            let mut covered = [0_u32; LEVELS.len()];
            for run in 0..RUNS {
                let streams = Streams::new(seed, run);
                let mut draws = streams.open(Stream::CurveResidual);
                let mut sample: Vec<f64> = (0..SIZE).map(|_| draws.uniform()).collect();
                sample.sort_unstable_by(f64::total_cmp);
                for (k, (level, _)) in LEVELS.into_iter().enumerate() {
                    let [low, high] = interval(&sample, level).expect("400 values");
                    covered[k] += u32::from(low <= level && level <= high);
                }
            }
            for (k, (level, name)) in LEVELS.into_iter().enumerate() {
                let expected = coverage(SIZE, level);
                let share = f64::from(covered[k]) / RUNS as f64;
                let standard_error = libm::sqrt(expected * (1.0 - expected) / RUNS as f64);
                assert!(
                    (share - expected).abs() < 4.0 * standard_error,
                    "seed {seed}, {name}: {share}, expected {expected}"
                );
            }
        }
    }
}

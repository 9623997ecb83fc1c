//! Ratio of two fleet totals, such as all fuel over all distance, with its confidence interval.
//!
//! R = Σ yᵢ / Σ xᵢ,  se² = n/(n−1) · Σ (yᵢ − R xᵢ)² / (Σ xᵢ)²,  interval R ± t₀.₉₇₅(n−1) · se
//!
//! The linearised variance of the ratio estimator: Cochran, *Sampling Techniques*, 3rd ed. (1977),
//! section 6.4. Its bias is of order 1/n and is left alone. With every xᵢ = 1 this is the plain
//! mean and its Student interval.

/// A ratio and its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ratio {
    /// Total over total.
    pub ratio: f64,
    /// 95 % interval; none from a single pair.
    pub ci95: Option<[f64; 2]>,
}

impl Ratio {
    /// Estimates Σ y / Σ x from pairs (y, x), summed up in the order given. None where Σ x is not
    /// positive.
    pub fn estimate(pairs: impl Iterator<Item = (f64, f64)> + Clone) -> Option<Self> {
        let (mut n, mut sum_y, mut sum_x) = (0_u64, 0.0, 0.0);
        for (y, x) in pairs.clone() {
            n += 1;
            sum_y += y;
            sum_x += x;
        }
        if sum_x.is_nan() || sum_x <= 0.0 {
            return None;
        }
        let ratio = sum_y / sum_x;
        if n < 2 {
            return Some(Self { ratio, ci95: None });
        }
        let squares: f64 = pairs.map(|(y, x)| (y - ratio * x) * (y - ratio * x)).sum();
        let n = n as f64;
        let standard_error = libm::sqrt(n / (n - 1.0) * squares) / sum_x;
        let half_width = student_975(n - 1.0) * standard_error;
        Some(Self { ratio, ci95: Some([ratio - half_width, ratio + half_width]) })
    }
}

/// 97.5 % quantile of the standard normal law.
pub(super) const NORMAL_975: f64 = 1.959963984540054;

/// 97.5 % quantiles of Student's law with 1 to 4 degrees of freedom, where the expansion below is
/// too coarse.
const STUDENT_975: [f64; 4] =
    [12.706204736174694, 4.302652729749462, 3.182446305283708, 2.7764451051977934];

/// 97.5 % quantile of Student's law: expansion in 1/ν around the normal law, error below 3e-4 from
/// ν = 5 on.
///
/// Source: Abramowitz and Stegun, *Handbook of Mathematical Functions*, 26.7.5.
pub(super) fn student_975(degrees: f64) -> f64 {
    if degrees < 5.0 {
        return STUDENT_975[(degrees as usize).clamp(1, 4) - 1];
    }
    let x = NORMAL_975;
    let x2 = x * x;
    let g1 = x * (x2 + 1.0) / 4.0;
    let g2 = x * ((5.0 * x2 + 16.0) * x2 + 3.0) / 96.0;
    let g3 = x * (((3.0 * x2 + 19.0) * x2 + 17.0) * x2 - 15.0) / 384.0;
    let g4 = x * ((((79.0 * x2 + 776.0) * x2 + 1482.0) * x2 - 1920.0) * x2 - 945.0) / 92160.0;
    let r = 1.0 / degrees;
    x + r * (g1 + r * (g2 + r * (g3 + r * g4)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Stream, Streams};

    fn estimate(pairs: &[(f64, f64)]) -> Option<Ratio> {
        Ratio::estimate(pairs.iter().copied())
    }

    #[test]
    fn student_quantiles_are_those_of_the_tables() {
        for (degrees, t) in
            [(1.0, 12.7062), (4.0, 2.7764), (5.0, 2.5706), (9.0, 2.2622), (30.0, 2.0423)]
        {
            assert!((student_975(degrees) - t).abs() < 4e-4, "{degrees}: {}", student_975(degrees));
        }
        assert!((student_975(1e9) - NORMAL_975).abs() < 1e-8);
    }

    #[test]
    fn small_cases_by_hand() {
        assert_eq!(estimate(&[]), None);
        assert_eq!(estimate(&[(1.0, 0.0)]), None);
        assert_eq!(estimate(&[(6.0, 2.0)]), Some(Ratio { ratio: 3.0, ci95: None }));
        // R = 12/4 = 3; residuals 2 − 3 = −1 and 10 − 9 = 1; se² = 2/1 · 2 / 16 = 1/4
        let Some(Ratio { ratio, ci95: Some([low, high]) }) = estimate(&[(2.0, 1.0), (10.0, 3.0)])
        else {
            panic!("two pairs have an interval");
        };
        assert!((ratio - 3.0).abs() < 1e-15);
        assert!((high - 3.0 - 0.5 * STUDENT_975[0]).abs() < 1e-12);
        assert!((low + high - 6.0).abs() < 1e-12);
    }

    #[test]
    fn interval_covers_the_ratio_of_a_known_population_95_times_in_100() {
        // x log-normal with median 1 and log-SD 0.5; y = x (2 + noise) + noise, both centred: R = 2
        const RUNS: u32 = 2000;
        const SIZE: usize = 200;
        for seed in 1..=3 {
            let mut covered = 0;
            for run in 0..RUNS {
                let streams = Streams::new(seed, u64::from(run));
                let mut draws = streams.open(Stream::CurveResidual);
                let mut normal = || draws.normal();
                let pairs: Vec<(f64, f64)> = (0..SIZE)
                    .map(|_| {
                        let x = libm::exp(0.5 * normal());
                        (x * (2.0 + 0.3 * normal()) + 0.2 * normal(), x)
                    })
                    .collect();
                let interval = estimate(&pairs).and_then(|r| r.ci95).expect("200 pairs");
                covered += u32::from(interval[0] <= 2.0 && 2.0 <= interval[1]);
            }
            let share = f64::from(covered) / f64::from(RUNS);
            let standard_error = libm::sqrt(0.95 * 0.05 / f64::from(RUNS));
            assert!((share - 0.95).abs() < 4.0 * standard_error, "seed {seed}: {share}");
        }
    }
}

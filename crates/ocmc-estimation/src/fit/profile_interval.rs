//! The interval of a standard deviation by its profile likelihood, and the standard deviation
//! between groups whose values are known with errors.
//!
//! D(τ) is twice the restricted log-likelihood, negative, with all else at its best. The interval
//! is where D(τ) − D(τ̂) <= 3.84 (1 + 1/(3 f)), f one less than groups. The factor is the mean of
//! the left side for balanced groups to first order (Bartlett's correction): with x = χ²_f/f the
//! left side is f (x − 1 − ln x), and E ln x = −1/f − 1/(3 f²) \[D\].
//!
//! Sources: J. C. Pinheiro, D. M. Bates, Mixed-Effects Models in S and S-PLUS (2000), section 2.4
//! \[PK\]; two-stage REML: D. Harville, Journal of the American Statistical Association 72 (1977)
//! \[PK\].

use super::nelder_mead::minimise;

/// The chi-square quantile of 95 % with one degree of freedom.
const REACH: f64 = 3.841_458_820_694_124;
/// Most evaluations for one end of an interval.
const MOST_EVALUATIONS: usize = 60;
/// Relative error of an end.
const END_ERROR: f64 = 1e-6;

/// An estimated standard deviation between groups.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpreadOfGroups {
    /// The standard deviation; 0 where the groups differ by no more than by chance.
    pub sd: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
    /// The mean, each group weighted by what is known of it.
    pub mean: f64,
    /// Standard error of the mean.
    pub mean_standard_error: f64,
}

/// The 95 % interval of a standard deviation that is best at `best`; `deviance` is D(τ) for τ from
/// 0 on, `groups` is their number, two or more.
pub fn sd_interval(best: f64, groups: usize, deviance: impl Fn(f64) -> f64) -> [f64; 2] {
    let reach = REACH * (1.0 + 1.0 / (3.0 * (groups as f64 - 1.0)));
    let wanted = deviance(best) + reach;
    let off = |sd: f64| deviance(sd) - wanted;
    let lower = if off(0.0) <= 0.0 { 0.0 } else { crossing(best, 0.0, &off) };
    let mut outer = 2.0 * best;
    if !(outer > 0.0) {
        outer = 1e-3;
    }
    for _ in 0..MOST_EVALUATIONS {
        if !(off(outer) < 0.0) {
            return [lower, crossing(best, outer, &off)];
        }
        outer *= 2.0;
    }
    [lower, f64::INFINITY]
}

/// Where a function that is negative inside and positive outside is zero: false position with the
/// halving of Illinois.
fn crossing(mut inside: f64, mut outside: f64, off: &impl Fn(f64) -> f64) -> f64 {
    let (mut below, mut above) = (off(inside), off(outside));
    let mut last = 0;
    for _ in 0..MOST_EVALUATIONS {
        let middle = if above.is_finite() {
            (inside * above - outside * below) / (above - below)
        } else {
            0.5 * (inside + outside)
        };
        let at = off(middle);
        if at == 0.0 || (outside - inside).abs() <= END_ERROR * outside.abs().max(inside.abs()) {
            return middle;
        }
        if at < 0.0 {
            (inside, below) = (middle, at);
            if last == -1 {
                above *= 0.5;
            }
            last = -1;
        } else {
            (outside, above) = (middle, at);
            if last == 1 {
                below *= 0.5;
            }
            last = 1;
        }
    }
    0.5 * (inside + outside)
}

/// The standard deviation between groups of which each has a value with its variance, by REML:
/// value_g ~ N(μ, τ² + variance_g).
///
/// None with fewer than two groups, or where a variance is not above 0.
pub fn between_groups(values: &[f64], variances: &[f64]) -> Option<SpreadOfGroups> {
    let known = variances.iter().all(|variance| *variance > 0.0 && variance.is_finite());
    if values.len() < 2 || values.len() != variances.len() || !known {
        return None;
    }
    let weighted = |tau: f64| {
        let weights = variances.iter().map(|variance| 1.0 / (tau * tau + variance));
        let sum: f64 = weights.clone().sum();
        let mean = values.iter().zip(weights).map(|(value, w)| value * w).sum::<f64>() / sum;
        (mean, sum)
    };
    let deviance = |tau: f64| {
        let (mean, sum) = weighted(tau);
        let rows = values.iter().zip(variances).map(|(value, variance)| {
            let total = tau * tau + variance;
            libm::log(total) + (value - mean) * (value - mean) / total
        });
        rows.sum::<f64>() + libm::log(sum)
    };
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let spread =
        values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / (n - 1.0);
    let start = libm::sqrt(spread).max(1e-12);
    let (lowest, value) = minimise(|tau: &[f64; 1]| deviance(tau[0]), [start], 0.5 * start);
    // at the boundary the search ends within its own accuracy of 0
    let sd = if deviance(0.0) <= value + 1e-9 { 0.0 } else { lowest[0].abs() };
    let (mean, sum) = weighted(sd);
    Some(SpreadOfGroups {
        sd,
        ci95: sd_interval(sd, values.len(), deviance),
        mean,
        mean_standard_error: libm::sqrt(1.0 / sum),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    #[test]
    fn equal_errors_have_the_closed_form() {
        // τ² = sample variance less the variance of the values
        let values = [1.0, 2.5, 0.3, 1.9, 3.1, 0.8];
        let estimate = between_groups(&values, &[0.2; 6]).unwrap();
        let mean = values.iter().sum::<f64>() / 6.0;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 5.0;
        assert!((estimate.sd - (variance - 0.2).sqrt()).abs() < 1e-6, "{estimate:?}");
        assert!((estimate.mean - mean).abs() < 1e-9);
        assert!((estimate.mean_standard_error - (variance / 6.0).sqrt()).abs() < 1e-6);
        // groups that differ by less than their errors
        let alike = between_groups(&values, &[9.0; 6]).unwrap();
        assert!(alike.sd == 0.0 && alike.ci95[0] == 0.0 && alike.ci95[1] > 0.0, "{alike:?}");
        assert_eq!(between_groups(&values[..1], &[0.2]), None);
        assert_eq!(between_groups(&values, &[0.0; 6]), None);
    }

    #[test]
    fn the_interval_covers() {
        // eight groups with errors half as large as what parts them
        let (mut covered, mut below) = (0, 0);
        for seed in 0..2000 {
            let mut draws = Draws::new(seed, 0, Stream::Vehicle);
            let values: Vec<f64> = (0..8).map(|_| draws.normal() + 0.5 * draws.normal()).collect();
            let [low, high] = between_groups(&values, &[0.25; 8]).unwrap().ci95;
            covered += usize::from(low <= 1.0 && 1.0 <= high);
            below += usize::from(high < 1.0);
        }
        // 95 % of 2000 with four binomial errors
        assert!((1861..=1939).contains(&covered), "{covered}");
        assert!((10..=90).contains(&below), "{below}");
    }
}

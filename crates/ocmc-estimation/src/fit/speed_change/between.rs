//! Drivers and their changes, apart: y = μ + b_driver + e, b ~ N(0, τ²), e ~ N(0, σ²), of the
//! logarithms of accelerations.
//!
//! A study draws an acceleration once a driver, so its law wants exp μ and τ; σ, what the changes
//! of one driver differ by, has no place in it. By REML; with the threshold c in the likelihood by
//! maximum likelihood: given b, a driver's changes have the normal density over σ P(Z at least (c −
//! μ − b)/σ), and b is integrated out around its mode; τ² is taken times G/(G − 1) for the mean
//! that was fitted, as without a cut.

use crate::fit::mixed_model::GroupedRows;
use crate::fit::nelder_mead::minimise;
use crate::fit::p_value::{ln_normal_tail, normal_hazard, t_of_interval};
use serde::Serialize;

/// Level of all intervals.
const LEVEL: f64 = 0.95;
/// Steps of Newton's method for a driver's most probable effect.
const MOST_STEPS: usize = 30;
/// The integral over an effect reaches so many standard deviations to either side, in steps of a
/// half: the trapezoidal rule of a bell is good to 1e-9.
const REACH: i32 = 12;

/// The typical driver, how drivers differ, and how the changes of one driver differ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BetweenDrivers {
    /// Drivers.
    pub drivers: usize,
    /// Median of the typical driver, negative for slowing down, in m/s².
    pub median_mps2: f64,
    /// Its 95 % interval for the drivers that these stand for, in m/s²: t with one degree of
    /// freedom less than drivers.
    pub median_ci95: Option<[f64; 2]>,
    /// SD of the logarithm between drivers; 0 where they differ by no more than their changes do.
    pub driver_log_sd: f64,
    /// Its 95 % interval by the profile likelihood.
    pub driver_log_sd_ci95: Option<[f64; 2]>,
    /// SD of the logarithm between the changes of one driver.
    pub change_log_sd: f64,
    /// Whether drivers differ by no more than their changes do.
    pub singular: bool,
}

/// Drivers with the logarithms of their changes, in the order of their names.
fn groups(logs: &[(&str, f64)]) -> Vec<(f64, f64, f64)> {
    let mut sorted: Vec<&(&str, f64)> = logs.iter().filter(|row| !row.0.is_empty()).collect();
    sorted.sort_by(|a, b| a.0.cmp(b.0));
    let of_driver = |rows: &[&(&str, f64)]| {
        let n = rows.len() as f64;
        let mean = rows.iter().map(|row| row.1).sum::<f64>() / n;
        (n, mean, rows.iter().map(|row| (row.1 - mean) * (row.1 - mean)).sum())
    };
    sorted.chunk_by(|a, b| a.0 == b.0).map(of_driver).collect()
}

/// By REML; none with fewer than two named drivers, or where none of them has two changes.
pub(super) fn between_drivers(sign: f64, logs: &[(&str, f64)]) -> Option<BetweenDrivers> {
    let mut drivers: Vec<&str> =
        logs.iter().map(|row| row.0).filter(|name| !name.is_empty()).collect();
    let named = drivers.len();
    drivers.sort_unstable();
    drivers.dedup();
    if drivers.len() < 2 || drivers.len() == named {
        return None;
    }
    let grouped: Vec<(usize, f64)> = logs
        .iter()
        .filter_map(|(name, log)| Some((drivers.binary_search(name).ok()?, *log)))
        .collect();
    let rows = GroupedRows::reduce(grouped.len(), 1, drivers.len(), |k, x| {
        x[0] = 1.0;
        grouped[k]
    });
    let fit = rows.random_intercept()?;
    let reach =
        t_of_interval(LEVEL, drivers.len() as f64 - 1.0) * libm::sqrt(fit.covariance[(0, 0)]);
    let mean = fit.coefficients[0];
    Some(BetweenDrivers {
        drivers: drivers.len(),
        median_mps2: sign * libm::exp(mean),
        median_ci95: Some(ordered([mean - reach, mean + reach].map(|y| sign * libm::exp(y)))),
        driver_log_sd: if fit.singular { 0.0 } else { libm::sqrt(fit.group_covariance[(0, 0)]) },
        driver_log_sd_ci95: rows.intercept_sd_interval(&fit),
        change_log_sd: fit.residual_sd,
        singular: fit.singular,
    })
}

/// An interval, the smaller end first.
pub(super) fn ordered([a, b]: [f64; 2]) -> [f64; 2] {
    [a.min(b), a.max(b)]
}

/// With the threshold in the likelihood, from what REML found without it; none where the changes do
/// not determine it.
pub(super) fn untruncated(
    sign: f64,
    log_threshold: f64,
    logs: &[(&str, f64)],
    plain: &BetweenDrivers,
) -> Option<BetweenDrivers> {
    let groups = groups(logs);
    let minus_log_likelihood = |theta: &[f64; 3]| {
        let (mu, sigma, tau) = (theta[0], libm::exp(theta[1]), theta[2].abs());
        -groups.iter().map(|group| marginal(*group, mu, sigma, tau, log_threshold)).sum::<f64>()
    };
    let start = [
        libm::log(plain.median_mps2.abs()),
        libm::log(plain.change_log_sd),
        plain.driver_log_sd.max(0.3 * plain.change_log_sd),
    ];
    let (theta, value) = minimise(minus_log_likelihood, start, 0.3 * plain.change_log_sd);
    let g = groups.len() as f64;
    let driver_log_sd = theta[2].abs() * libm::sqrt(g / (g - 1.0));
    let change_log_sd = libm::exp(theta[1]);
    let total = libm::hypot(driver_log_sd, change_log_sd);
    // where most of the law lies in the cut, its size is a guess
    let beyond = libm::exp(ln_normal_tail((log_threshold - theta[0]) / total));
    (value.is_finite() && beyond > 0.1).then(|| BetweenDrivers {
        drivers: groups.len(),
        median_mps2: sign * libm::exp(theta[0]),
        median_ci95: None,
        driver_log_sd,
        driver_log_sd_ci95: None,
        change_log_sd,
        singular: driver_log_sd < 1e-4 * change_log_sd,
    })
}

/// Logarithm of the likelihood of a driver's changes (number, mean, squares about it), the effect b
/// = τ u integrated out.
fn marginal((n, mean, squares): (f64, f64, f64), mu: f64, sigma: f64, tau: f64, cut: f64) -> f64 {
    let ln_density = |u: f64| {
        let level = mu + tau * u;
        let off = mean - level;
        let beyond = if cut.is_finite() { ln_normal_tail((cut - level) / sigma) } else { 0.0 };
        -0.5 * (squares + n * off * off) / (sigma * sigma)
            - n * (libm::log(sigma) + beyond)
            - 0.5 * u * u
    };
    // Newton's method: the likelihood of a normal law that is cut off is concave in its mean
    let (mut u, mut bend) = (0.0, 1.0);
    for _ in 0..MOST_STEPS {
        let level = mu + tau * u;
        let z = (cut - level) / sigma;
        let hazard = if cut.is_finite() { normal_hazard(z) } else { 0.0 };
        let slope = n * tau / sigma * ((mean - level) / sigma - hazard) - u;
        let kept =
            if cut.is_finite() { (1.0 - hazard * (hazard - z)).clamp(0.0, 1.0) } else { 1.0 };
        bend = 1.0 + n * tau * tau / (sigma * sigma) * kept;
        let step = slope / bend;
        u += step.clamp(-3.0, 3.0);
        if step.abs() < 1e-10 {
            break;
        }
    }
    let (width, top) = (1.0 / libm::sqrt(bend), ln_density(u));
    let sum: f64 =
        (-REACH..=REACH).map(|k| libm::exp(ln_density(u + 0.5 * f64::from(k) * width) - top)).sum();
    top + libm::log(0.5 * width * sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    fn drawn(seed: u64, drivers: usize, cut: f64) -> Vec<(String, f64)> {
        let mut draws = Draws::new(seed, 0, Stream::SpeedChange);
        let mut rows = Vec::new();
        for driver in 0..drivers {
            let level = -0.5 + 0.2 * draws.normal();
            for _ in 0..10 {
                let y = level + 0.3 * draws.normal();
                if y > cut {
                    rows.push((format!("driver {driver}"), y));
                }
            }
        }
        rows
    }

    fn lent(rows: &[(String, f64)]) -> Vec<(&str, f64)> {
        rows.iter().map(|(name, y)| (name.as_str(), *y)).collect()
    }

    #[test]
    fn drivers_and_changes_are_told_apart_with_and_without_the_cut() {
        // 400 drivers: the SD between them comes back within 4 SD/√(2·400), and without regard to
        // the cut it does not
        let cut = -0.6;
        let whole = drawn(1, 400, f64::NEG_INFINITY);
        let plain = between_drivers(-1.0, &lent(&whole)).unwrap();
        assert!((plain.driver_log_sd - 0.2).abs() < 0.028, "{plain:?}");
        assert!((plain.change_log_sd - 0.3).abs() < 0.015, "{plain:?}");
        assert!((plain.median_mps2 + (-0.5f64).exp()).abs() < 0.03, "{plain:?}");
        let rows = drawn(1, 400, cut);
        let plain = between_drivers(-1.0, &lent(&rows)).unwrap();
        assert!(plain.driver_log_sd < 0.15 && plain.change_log_sd < 0.25, "{plain:?}");
        let whole = untruncated(-1.0, cut, &lent(&rows), &plain).unwrap();
        assert!((whole.driver_log_sd - 0.2).abs() < 0.05, "{whole:?}");
        assert!((whole.change_log_sd - 0.3).abs() < 0.03, "{whole:?}");
        // two fifths of the changes are cut off
        let off = |fit: &BetweenDrivers| (fit.median_mps2 / -(-0.5f64).exp()).ln().abs();
        assert!(off(&whole) < 0.1 && off(&whole) < 0.5 * off(&plain), "{whole:?} {plain:?}");
    }

    #[test]
    fn without_a_cut_the_likelihood_is_the_closed_form() {
        // of three values with variance σ² each and τ² together
        let (n, mean, squares, mu, sigma, tau) = (3.0, 0.4, 0.5, 0.1, 0.7, 0.5);
        let ln_likelihood = marginal((n, mean, squares), mu, sigma, tau, f64::NEG_INFINITY);
        let between = sigma * sigma / n + tau * tau;
        let wanted = -0.5 * squares / (sigma * sigma)
            - (n - 1.0) * f64::ln(sigma)
            - 0.5 * (mean - mu) * (mean - mu) / between
            - 0.5 * f64::ln(n * between);
        // up to (2π)^(1/2), which the integral has
        let constant = 0.5 * f64::ln(2.0 * std::f64::consts::PI);
        assert!((ln_likelihood - wanted - constant).abs() < 1e-8, "{ln_likelihood} {wanted}");
    }

    #[test]
    fn drivers_without_repetitions_or_names_tell_nothing() {
        assert_eq!(between_drivers(1.0, &[("a", 0.1), ("b", 0.2)]), None);
        assert_eq!(between_drivers(1.0, &[("a", 0.1), ("a", 0.2)]), None);
        assert_eq!(between_drivers(1.0, &[("", 0.1), ("", 0.2), ("a", 0.3), ("a", 0.4)]), None);
    }
}

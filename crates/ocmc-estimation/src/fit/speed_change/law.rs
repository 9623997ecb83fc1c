//! The law of one kind of speed change: log-normal, with and without the threshold in its
//! likelihood.

use super::LEVEL;
use super::between::{self, BetweenDrivers, between_drivers, ordered};
use crate::fit::anderson_darling::normal;
use crate::fit::nelder_mead::minimise;
use crate::fit::p_value::{ln_normal_tail, sd_interval, t_of_interval};
use crate::moments::Moments;
use serde::Serialize;
use std::collections::BTreeMap;

/// The law of one kind of change.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpeedChangeLaw {
    /// Kind of change; `all accelerations` and `all decelerations` for the pooled ones.
    pub category: String,
    /// Changes that count.
    pub n: usize,
    /// Changes within the threshold, which do not.
    pub within_threshold: usize,
    /// Median, negative for slowing down, in m/s².
    pub median_mps2: f64,
    /// Its 95 % interval, in m/s², which knows that the changes of a driver are alike where drivers
    /// have repetitions; none for a single change.
    pub median_ci95: Option<[f64; 2]>,
    /// Standard deviation of the logarithm; none for a single change.
    pub log_sd: Option<f64>,
    /// Its 95 % interval.
    pub log_sd_ci95: Option<[f64; 2]>,
    /// Anderson and Darling's A² of a log-normal law.
    pub anderson_darling: Option<f64>,
    /// p of a log-normal law.
    pub anderson_darling_p: Option<f64>,
    /// SD of the logarithm between drivers, by REML; none where drivers have no repetitions.
    pub driver_log_sd: Option<f64>,
    /// Drivers and their changes apart, by REML; none where drivers have no repetitions.
    pub between_drivers: Option<BetweenDrivers>,
    /// The law with the threshold in its likelihood; none where the changes do not determine it.
    pub untruncated: Option<UntruncatedLaw>,
}

/// The law before the threshold cut it off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct UntruncatedLaw {
    /// Median, negative for slowing down, in m/s².
    pub median_mps2: f64,
    /// Standard deviation of the logarithm.
    pub log_sd: f64,
    /// Share of the law beyond the threshold.
    pub share_beyond_threshold: f64,
    /// Drivers and their changes apart; none where drivers have no repetitions.
    pub between_drivers: Option<BetweenDrivers>,
}

pub(super) fn fit_law(
    name: &str,
    sign: f64,
    threshold: f64,
    within: usize,
    logs: &[(&str, f64)],
) -> SpeedChangeLaw {
    let values: Vec<f64> = logs.iter().map(|row| row.1).collect();
    let moments = Moments::of(&values);
    let (n, mean) = (moments.n, moments.mean);
    let log_sd = (values.len() > 1).then(|| moments.sd());
    let tested = normal(&values);
    let between = between_drivers(sign, logs);
    let ci95 = log_sd.map(|sd| {
        let (error, df) = match &between {
            Some(between) => (clustered_error(logs, between), between.drivers as f64 - 1.0),
            None => (sd / libm::sqrt(n), n - 1.0),
        };
        let reach = t_of_interval(LEVEL, df) * error;
        ordered([mean - reach, mean + reach].map(|y| sign * libm::exp(y)))
    });
    SpeedChangeLaw {
        category: name.to_owned(),
        n: values.len(),
        within_threshold: within,
        median_mps2: sign * libm::exp(mean),
        median_ci95: ci95,
        log_sd,
        log_sd_ci95: log_sd.and_then(|sd| sd_interval(sd, n - 1.0, LEVEL)),
        anderson_darling: tested.map(|tested| tested.0),
        anderson_darling_p: tested.map(|tested| tested.1),
        driver_log_sd: between.map(|between| between.driver_log_sd),
        between_drivers: between,
        untruncated: log_sd
            .filter(|sd| *sd > 0.0)
            .and_then(|sd| untruncated(sign, threshold, &values, mean, sd))
            .map(|law| {
                let cut = libm::log(threshold);
                let apart = between.and_then(|plain| between::untruncated(sign, cut, logs, &plain));
                UntruncatedLaw { between_drivers: apart, ..law }
            }),
    }
}

/// Standard error of the mean of all logarithms, drivers weighted by their changes. Changes of
/// unnamed drivers count as drivers of their own.
fn clustered_error(logs: &[(&str, f64)], between: &BetweenDrivers) -> f64 {
    let mut counts: BTreeMap<&str, f64> = BTreeMap::new();
    let mut squares = 0.0;
    for (driver, _) in logs {
        if driver.is_empty() {
            squares += 1.0;
        } else {
            *counts.entry(driver).or_insert(0.0) += 1.0;
        }
    }
    squares += counts.values().map(|count| count * count).sum::<f64>();
    let (n, tau, sigma) = (logs.len() as f64, between.driver_log_sd, between.change_log_sd);
    libm::sqrt(tau * tau * squares / (n * n) + sigma * sigma / n)
}

/// Maximum likelihood with the cut: density φ((y − μ)/σ) / (σ P(Z > (ln threshold − μ)/σ)).
fn untruncated(
    sign: f64,
    threshold: f64,
    values: &[f64],
    mean: f64,
    sd: f64,
) -> Option<UntruncatedLaw> {
    let log_threshold = libm::log(threshold);
    // ln of the share of the law beyond the threshold
    let ln_beyond = |mu: f64, sigma: f64| {
        if threshold > 0.0 { ln_normal_tail((log_threshold - mu) / sigma) } else { 0.0 }
    };
    let minus_log_likelihood = |theta: &[f64; 2]| {
        let (mu, sigma) = (theta[0], libm::exp(theta[1]));
        let off = values.iter().map(|y| (y - mu) / sigma);
        let squares: f64 = off.map(|off| off * off).sum();
        0.5 * squares + values.len() as f64 * (libm::log(sigma) + ln_beyond(mu, sigma))
    };
    let (theta, _) = minimise(minus_log_likelihood, [mean, libm::log(sd)], 0.5 * sd);
    let (mu, log_sd) = (theta[0], libm::exp(theta[1]));
    let beyond = libm::exp(ln_beyond(mu, log_sd));
    // where most of the law lies in the cut, its size is a guess
    (beyond > 0.1 && log_sd.is_finite()).then(|| UntruncatedLaw {
        median_mps2: sign * libm::exp(mu),
        log_sd,
        share_beyond_threshold: beyond,
        between_drivers: None,
    })
}

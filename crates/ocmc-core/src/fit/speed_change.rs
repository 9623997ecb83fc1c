//! Accelerations and decelerations at changes of the speed limit: the paper's log-normal law.
//!
//! a = a₀ exp(e), e ~ N(0, σ²), with the sign apart. Of a log, the acceleration at a change of the limit is the mean over the
//! window with the largest change of speed in the direction of the new limit, close to the sign.
//!
//! Changes below a threshold count as none, because the vehicle already had the wanted speed (the paper: 0.2 m/s² up, 0.4 m/s² down).
//! This cuts the law off and moves the median away from zero: beside the paper's estimate stands the one that has the cut in
//! its likelihood.
//!
//! Source: Romano, Godio, Bruzelius, Johannesson, the paper in hand. The length of the window is not in the paper.

use super::anderson_darling::normal;
use super::mixed_model::GroupedRows;
use super::nelder_mead::minimise;
use super::p_value::{ln_normal_tail, sd_interval, t_of_interval};
use crate::distribution::{Law, Quantity};
use crate::driver::speed_change::SpeedChangeModel;
use serde::Serialize;
use std::collections::BTreeMap;
use thiserror::Error;

/// Level of all intervals.
const LEVEL: f64 = 0.95;

/// Smallest difference of two limits, in m/s.
const SMALLEST_CHANGE_MPS: f64 = 0.1;

/// Measured speed changes as columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpeedChangeTable {
    /// Who drove.
    pub driver: Vec<String>,
    /// Kind of change, such as `70-to-40`.
    pub category: Vec<String>,
    /// Acceleration, negative for slowing down, in m/s².
    pub acceleration_mps2: Vec<f64>,
}

/// A time series with speed limits, as columns of equal length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedLog<'a> {
    /// Time, rising, in s.
    pub time_s: &'a [f64],
    /// Speed, in m/s.
    pub speed_mps: &'a [f64],
    /// Speed limit, in m/s.
    pub limit_mps: &'a [f64],
}

/// How accelerations are taken from a log, and which count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedChangeOptions {
    /// Length of the window, in s.
    pub window_s: f64,
    /// How long before a sign the window may begin, in s.
    pub before_s: f64,
    /// How long behind a sign the window may end, in s.
    pub after_s: f64,
    /// Smallest acceleration that counts, in m/s².
    pub smallest_acceleration_mps2: f64,
    /// Smallest deceleration that counts, as a positive number, in m/s².
    pub smallest_deceleration_mps2: f64,
}

impl Default for SpeedChangeOptions {
    /// The thresholds are the paper's; the times are judgement: a heavy truck from 40 to 70 km/h takes half a minute.
    fn default() -> Self {
        Self {
            window_s: 3.0,
            before_s: 20.0,
            after_s: 30.0,
            smallest_acceleration_mps2: 0.2,
            smallest_deceleration_mps2: 0.4,
        }
    }
}

/// Why speed changes have no fit.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SpeedChangeError {
    /// An option out of its range.
    #[error("{option} is {value}; allowed is {allowed}")]
    Option {
        /// Name of the option.
        option: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Columns of different lengths.
    #[error("column {column} has {length} values, the others have {wanted}")]
    UnequalColumns {
        /// The column.
        column: &'static str,
        /// Its length.
        length: usize,
        /// The others' length.
        wanted: usize,
    },
    /// Times that do not rise.
    #[error(
        "time {time_s} s of row {row} does not lie behind the one before; sort the log, or split it up"
    )]
    Time {
        /// The row, from 1.
        row: usize,
        /// Its time, in s.
        time_s: f64,
    },
    /// No row counts.
    #[error(
        "no speed change is left of {rows}: {within} lie within the thresholds, {missing} have no value"
    )]
    Nothing {
        /// Changes that came in.
        rows: usize,
        /// Those within the thresholds.
        within: usize,
        /// Those without a value.
        missing: usize,
    },
}

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
    /// Its 95 % interval, in m/s²; none for a single change.
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
}

/// Everything that speed changes tell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpeedChangeFit {
    /// Changes that came in.
    pub n: usize,
    /// Rows left out, by reason.
    pub dropped: BTreeMap<&'static str, usize>,
    /// Each kind of change, in the order of their first rows.
    pub by_category: Vec<SpeedChangeLaw>,
    /// All accelerations.
    pub acceleration: Option<SpeedChangeLaw>,
    /// All decelerations.
    pub deceleration: Option<SpeedChangeLaw>,
}

/// The acceleration at each change of the limit of a log: its kind, such as `70-to-40` in km/h, and its value, in m/s².
///
/// Rows with a missing speed or limit are passed over, and so are rows with the time of the row before.
///
/// # Errors
/// [`SpeedChangeError`] where the columns do not fit together.
pub fn accelerations(
    log: &SpeedLog,
    options: &SpeedChangeOptions,
) -> Result<Vec<(String, f64)>, SpeedChangeError> {
    check(options)?;
    let wanted = log.time_s.len();
    for (column, length) in [("speed", log.speed_mps.len()), ("limit", log.limit_mps.len())] {
        if length != wanted {
            return Err(SpeedChangeError::UnequalColumns { column, length, wanted });
        }
    }
    let seen = |k: &usize| {
        [log.time_s[*k], log.speed_mps[*k], log.limit_mps[*k]].iter().all(|value| value.is_finite())
    };
    let mut rows: Vec<usize> = (0..wanted).filter(seen).collect();
    // a second row of one time tells nothing new
    rows.dedup_by_key(|row| log.time_s[*row]);
    for pair in rows.windows(2) {
        if !(log.time_s[pair[1]] > log.time_s[pair[0]]) {
            return Err(SpeedChangeError::Time { row: pair[1] + 1, time_s: log.time_s[pair[1]] });
        }
    }
    let changes: Vec<usize> = (1..rows.len())
        .filter(|&k| {
            (log.limit_mps[rows[k]] - log.limit_mps[rows[k - 1]]).abs() > SMALLEST_CHANGE_MPS
        })
        .collect();
    let time = |k: usize| log.time_s[rows[k]];
    let mut found = Vec::new();
    for (i, &k) in changes.iter().enumerate() {
        // not into what belongs to the sign before or behind
        let begin = (time(k) - options.before_s).max(if i > 0 {
            time(changes[i - 1])
        } else {
            f64::NEG_INFINITY
        });
        let end = (time(k) + options.after_s)
            .min(changes.get(i + 1).map_or(f64::INFINITY, |&next| time(next)));
        let (from, to) = (log.limit_mps[rows[k - 1]], log.limit_mps[rows[k]]);
        let near: Vec<(f64, f64)> = rows
            .iter()
            .map(|&row| (log.time_s[row], log.speed_mps[row]))
            .filter(|point| (begin..=end).contains(&point.0))
            .collect();
        if let Some(acceleration) = largest_window(&near, options.window_s, to > from) {
            found.push((format!("{:.0}-to-{:.0}", 3.6 * from, 3.6 * to), acceleration));
        }
    }
    Ok(found)
}

/// Mean acceleration over the window in which speed rises (or falls) most; none where the points are shorter.
fn largest_window(points: &[(f64, f64)], window_s: f64, rising: bool) -> Option<f64> {
    let mut best: Option<f64> = None;
    let mut behind = 0;
    for (k, &(time, speed)) in points.iter().enumerate() {
        let until = time + window_s;
        behind = behind.max(k);
        while behind < points.len() && points[behind].0 < until {
            behind += 1;
        }
        let Some(&(later, fast)) = points.get(behind) else { break };
        let (sooner, slow) = points[behind.max(1) - 1];
        let end = if later > until && behind > k {
            slow + (fast - slow) * (until - sooner) / (later - sooner)
        } else {
            fast
        };
        let acceleration = (end - speed) / window_s;
        let better =
            best.is_none_or(|best| if rising { acceleration > best } else { acceleration < best });
        if better {
            best = Some(acceleration);
        }
    }
    best
}

/// Fits each kind of change, and all of one direction.
///
/// # Errors
/// [`SpeedChangeError`] says what the changes lack.
pub fn fit(
    table: &SpeedChangeTable,
    options: &SpeedChangeOptions,
) -> Result<SpeedChangeFit, SpeedChangeError> {
    check(options)?;
    let n = table.acceleration_mps2.len();
    for (column, length) in [("driver", table.driver.len()), ("category", table.category.len())] {
        if length != n {
            return Err(SpeedChangeError::UnequalColumns { column, length, wanted: n });
        }
    }
    let counts =
        |a: f64| a > options.smallest_acceleration_mps2 || a < -options.smallest_deceleration_mps2;
    let missing = table.acceleration_mps2.iter().filter(|a| !a.is_finite()).count();
    let within = table.acceleration_mps2.iter().filter(|a| a.is_finite() && !counts(**a)).count();
    if missing + within == n {
        return Err(SpeedChangeError::Nothing { rows: n, within, missing });
    }
    let mut dropped = BTreeMap::new();
    for (reason, rows) in [("missing_value", missing), ("within_threshold", within)] {
        if rows > 0 {
            dropped.insert(reason, rows);
        }
    }
    let mut categories: Vec<&str> = Vec::new();
    for category in &table.category {
        if !categories.contains(&category.as_str()) {
            categories.push(category);
        }
    }
    let law = |name: &str, rising: bool, keep: &dyn Fn(usize) -> bool| {
        let sign = if rising { 1.0 } else { -1.0 };
        let threshold = if rising {
            options.smallest_acceleration_mps2
        } else {
            options.smallest_deceleration_mps2
        };
        let of = |k: &usize| keep(*k) && sign * table.acceleration_mps2[*k] > 0.0;
        let rows: Vec<usize> = (0..n).filter(of).collect();
        let used = |k: &&usize| sign * table.acceleration_mps2[**k] > threshold;
        let logs: Vec<(&str, f64)> = rows
            .iter()
            .filter(used)
            .map(|&k| (table.driver[k].as_str(), libm::log(sign * table.acceleration_mps2[k])))
            .collect();
        let within = rows.len() - logs.len();
        (!logs.is_empty()).then(|| fit_law(name, sign, threshold, within, &logs))
    };
    let by_category = categories
        .iter()
        .flat_map(|category| {
            let keep = |k: usize| table.category[k] == *category;
            [law(category, true, &keep), law(category, false, &keep)]
        })
        .flatten()
        .collect();
    Ok(SpeedChangeFit {
        n,
        dropped,
        by_category,
        acceleration: law("all accelerations", true, &|_| true),
        deceleration: law("all decelerations", false, &|_| true),
    })
}

fn check(options: &SpeedChangeOptions) -> Result<(), SpeedChangeError> {
    for (option, value, least, allowed) in [
        ("the window", options.window_s, f64::MIN_POSITIVE, "a number above 0"),
        ("the time before a sign", options.before_s, 0.0, "a number from 0 on"),
        ("the time behind a sign", options.after_s, 0.0, "a number from 0 on"),
        (
            "the smallest acceleration",
            options.smallest_acceleration_mps2,
            0.0,
            "a number from 0 on",
        ),
        (
            "the smallest deceleration",
            options.smallest_deceleration_mps2,
            0.0,
            "a number from 0 on",
        ),
    ] {
        if !(value >= least && value.is_finite()) {
            return Err(SpeedChangeError::Option { option, value, allowed });
        }
    }
    Ok(())
}

fn fit_law(
    name: &str,
    sign: f64,
    threshold: f64,
    within: usize,
    logs: &[(&str, f64)],
) -> SpeedChangeLaw {
    let values: Vec<f64> = logs.iter().map(|row| row.1).collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|y| (y - mean) * (y - mean)).sum();
    let log_sd = (values.len() > 1).then(|| libm::sqrt(squares / (n - 1.0)));
    let tested = normal(&values);
    let ci95 = log_sd.map(|sd| {
        let reach = t_of_interval(LEVEL, n - 1.0) * sd / libm::sqrt(n);
        let [a, b] = [mean - reach, mean + reach].map(|y| sign * libm::exp(y));
        [a.min(b), a.max(b)]
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
        driver_log_sd: driver_log_sd(logs),
        untruncated: log_sd
            .filter(|sd| *sd > 0.0)
            .and_then(|sd| untruncated(sign, threshold, &values, mean, sd)),
    }
}

/// SD between drivers who have repetitions.
fn driver_log_sd(logs: &[(&str, f64)]) -> Option<f64> {
    let mut drivers: Vec<&str> = logs.iter().map(|row| row.0).collect();
    drivers.sort_unstable();
    drivers.dedup();
    if drivers.len() < 2 || drivers.len() == logs.len() {
        return None;
    }
    let rows = GroupedRows::reduce(logs.len(), 1, drivers.len(), |k, x| {
        x[0] = 1.0;
        (drivers.binary_search(&logs[k].0).unwrap_or(0), logs[k].1)
    });
    rows.random_intercept().map(|fit| libm::sqrt(fit.group_covariance[(0, 0)]))
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
    let minus_log_likelihood = |theta: &[f64; 2]| {
        let (mu, sigma) = (theta[0], libm::exp(theta[1]));
        let squares: f64 = values.iter().map(|y| ((y - mu) / sigma).powi(2)).sum();
        let cut = if threshold > 0.0 { ln_normal_tail((log_threshold - mu) / sigma) } else { 0.0 };
        0.5 * squares + values.len() as f64 * (libm::log(sigma) + cut)
    };
    let (theta, _) = minimise(minus_log_likelihood, [mean, libm::log(sd)], 0.5 * sd);
    let (mu, log_sd) = (theta[0], libm::exp(theta[1]));
    let beyond = if threshold > 0.0 {
        libm::exp(ln_normal_tail((log_threshold - mu) / log_sd))
    } else {
        1.0
    };
    // where most of the law lies in the cut, its size is a guess
    (beyond > 0.1 && log_sd.is_finite()).then(|| UntruncatedLaw {
        median_mps2: sign * libm::exp(mu),
        log_sd,
        share_beyond_threshold: beyond,
    })
}

impl SpeedChangeFit {
    /// The laws as a study has them; what was not measured stays as it is in `model`. `untruncated` takes the laws with the
    /// thresholds in their likelihood, where they are determined.
    pub fn population(&self, model: &SpeedChangeModel, untruncated: bool) -> SpeedChangeModel {
        let law = |fitted: &Option<SpeedChangeLaw>, given: &Quantity| {
            let Some(fitted) = fitted else { return given.clone() };
            let (mut median, mut log_sd) = (fitted.median_mps2, fitted.log_sd);
            if let Some(law) = fitted.untruncated.filter(|_| untruncated) {
                (median, log_sd) = (law.median_mps2, Some(law.log_sd));
            }
            let median = median.abs();
            match log_sd.filter(|sd| *sd > 0.0) {
                Some(log_sd) => {
                    Quantity::Law(Law::LogNormal { median, log_sd, lower: None, upper: None })
                }
                None => Quantity::Number(median),
            }
        };
        SpeedChangeModel {
            deceleration_mps2: law(&self.deceleration, &model.deceleration_mps2),
            acceleration_mps2: law(&self.acceleration, &model.acceleration_mps2),
            ..model.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Draws, Stream};

    /// Changes of the paper's laws, drawn.
    fn table(seed: u64, n: usize) -> SpeedChangeTable {
        let mut draws = Draws::new(seed, 0, Stream::SpeedChange);
        let mut table = SpeedChangeTable::default();
        for (category, median, sd) in [
            ("70-to-40", -1.16, 0.28),
            ("40-to-70", 0.52, 0.18),
            ("70-to-60", -1.06, 0.16),
            ("60-to-70", 0.44, 0.18),
        ] {
            for k in 0..n {
                table.driver.push(format!("driver {k}"));
                table.category.push(category.to_owned());
                table.acceleration_mps2.push(median * libm::exp(sd * draws.normal()));
            }
        }
        table
    }

    #[test]
    fn laws_come_back() {
        for seed in 1..=3 {
            let fit = fit(&table(seed, 2000), &SpeedChangeOptions::default()).unwrap();
            assert_eq!(fit.by_category.len(), 4);
            for (law, (median, sd)) in fit.by_category.iter().zip([
                (-1.16, 0.28),
                (0.52, 0.18),
                (-1.06, 0.16),
                (0.44, 0.18),
            ]) {
                let n = law.n as f64;
                let log_ratio = f64::ln(law.median_mps2 / median);
                assert!(log_ratio.abs() < 4.0 * sd / n.sqrt(), "{law:?}");
                assert!((law.log_sd.unwrap() - sd).abs() < 4.0 * sd / (2.0 * n).sqrt(), "{law:?}");
                assert!(law.anderson_darling_p.unwrap() > 1e-4, "{law:?}");
            }
            assert_eq!(
                fit.acceleration.as_ref().unwrap().n,
                fit.by_category[1].n + fit.by_category[3].n
            );
        }
    }

    #[test]
    fn the_cut_is_undone() {
        // a third of the law lies within the threshold: the plain median is high, the other is not
        let mut draws = Draws::new(1, 0, Stream::SpeedChange);
        let values: Vec<f64> =
            (0..20_000).map(|_| 0.24 * libm::exp(0.4 * draws.normal())).collect();
        let table = SpeedChangeTable {
            driver: vec!["a".to_owned(); values.len()],
            category: vec!["60-to-70".to_owned(); values.len()],
            acceleration_mps2: values,
        };
        let fit = fit(&table, &SpeedChangeOptions::default()).unwrap();
        let law = fit.acceleration.unwrap();
        assert!(law.median_mps2 > 0.28 && fit.dropped["within_threshold"] > 6000);
        let whole = law.untruncated.unwrap();
        assert!((whole.median_mps2 - 0.24).abs() < 0.01, "{whole:?}");
        assert!((whole.log_sd - 0.4).abs() < 0.02, "{whole:?}");
        assert!((whole.share_beyond_threshold - 0.676).abs() < 0.03, "{whole:?}");
    }

    #[test]
    fn windows_of_a_log() {
        // 70 km/h, down to 40 at -0.8 m/s2 before the sign at 100 s, up to 70 at 0.5 m/s2 behind the sign at 200 s
        let (fast, slow) = (70.0 / 3.6, 40.0 / 3.6);
        let time_s: Vec<f64> = (0..3000).map(|k| 0.1 * f64::from(k)).collect();
        let speed = |t: f64| {
            if t < 200.0 {
                (fast - 0.8 * (t - 90.0).max(0.0)).max(slow)
            } else {
                (slow + 0.5 * (t - 200.0)).min(fast)
            }
        };
        let speed_mps: Vec<f64> = time_s.iter().map(|t| speed(*t)).collect();
        let limit_mps: Vec<f64> =
            time_s.iter().map(|t| if (100.0..200.0).contains(t) { slow } else { fast }).collect();
        let log = SpeedLog { time_s: &time_s, speed_mps: &speed_mps, limit_mps: &limit_mps };
        let found = accelerations(&log, &SpeedChangeOptions::default()).unwrap();
        assert_eq!(found.len(), 2);
        for ((category, value), (name, wanted)) in
            found.iter().zip([("70-to-40", -0.8), ("40-to-70", 0.5)])
        {
            assert_eq!(category, name);
            assert!((value - wanted).abs() < 1e-9, "{value}");
        }
        // rows at any rate, with gaps
        let keep: Vec<usize> = (0..3000).filter(|k| k % 7 != 3 && k % 4 != 1).collect();
        let take = |values: &[f64]| keep.iter().map(|&k| values[k]).collect::<Vec<f64>>();
        let (t, v, l) = (take(&time_s), take(&speed_mps), take(&limit_mps));
        let log = SpeedLog { time_s: &t, speed_mps: &v, limit_mps: &l };
        let thin = accelerations(&log, &SpeedChangeOptions::default()).unwrap();
        assert!(thin.iter().zip(&found).all(|(a, b)| (a.1 - b.1).abs() < 1e-9));
        let backwards =
            SpeedLog { time_s: &[0.0, 1.0, 0.5], speed_mps: &[1.0; 3], limit_mps: &[1.0; 3] };
        assert!(matches!(
            accelerations(&backwards, &SpeedChangeOptions::default()),
            Err(SpeedChangeError::Time { row: 3, .. })
        ));
    }
}

//! Accelerations and decelerations at changes of the speed limit: the paper's log-normal law.
//!
//! a = a₀ exp(e), e ~ N(0, σ²), with the sign apart. Of a log, the acceleration at a change of the
//! limit is the mean over the window with the largest change of speed in the direction of the new
//! limit, close to the sign.
//!
//! Changes below a threshold count as none, because the vehicle already had the wanted speed (the
//! paper: 0.2 m/s² up, 0.4 m/s² down). This cuts the law off and moves the median away from zero:
//! beside the paper's estimate stands the one that has the cut in its likelihood.
//!
//! Source: Romano, Godio, Bruzelius, Johannesson, the paper in hand. The length of the window is
//! not in the paper, but its table bounds it.

mod between;
mod law;
mod window;

pub use between::BetweenDrivers;
pub use law::{SpeedChangeLaw, UntruncatedLaw};
pub use window::{LoggedChanges, SpeedLog, accelerations};

use crate::fit::p_value::{NORMAL_975, t_of_interval};
use crate::log::signal::LogError;
use crate::option_check::{OptionError, above_0, check_options, from_0};
use law::fit_law;
use ocmc_core::distribution::{Law, Quantity};
use ocmc_core::driver::speed_change::{SAME_AT_EVERY_SPEED, SpeedChangeModel};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use thiserror::Error;

/// Level of the intervals.
const LEVEL: f64 = 0.95;
/// Keys of a law: the number itself, its median, its spread.
const DECELERATION: [&str; 3] =
    ["deceleration_mps2", "deceleration_mps2.median", "deceleration_mps2.log_sd"];
const ACCELERATION: [&str; 3] =
    ["acceleration_mps2", "acceleration_mps2.median", "acceleration_mps2.log_sd"];

/// Measured speed changes as columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpeedChangeTable {
    /// Driver of each change.
    pub driver: Vec<String>,
    /// Kind of change, such as `70-to-40`.
    pub category: Vec<String>,
    /// Acceleration, negative for slowing down, in m/s².
    pub acceleration_mps2: Vec<f64>,
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
    /// The thresholds are the paper's. So is the most that the window can be: 10 km/h at the
    /// paper's 1.06 m/s² take 2.6 s, and the hardest of eight drivers with its σ of 0.16 takes 2.1
    /// s. The times around the sign are judgement: a heavy truck from 40 to 70 km/h takes half a
    /// minute.
    fn default() -> Self {
        Self {
            window_s: 2.0,
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
    #[error(transparent)]
    Option(#[from] OptionError),
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
    /// A log that cannot be used.
    #[error(transparent)]
    Log(#[from] LogError),
    /// Nothing came in.
    #[error("there is no speed change: no limit changes where speeds were logged")]
    NoChanges,
    /// No row counts.
    #[error(
        "no speed change is left of {rows}: {within} lie within the thresholds, {missing} have no \
         value"
    )]
    Nothing {
        /// Changes that came in.
        rows: usize,
        /// Number within the thresholds.
        within: usize,
        /// Number without a value.
        missing: usize,
    },
}

/// Everything that speed changes determine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpeedChangeFit {
    /// Changes that came in.
    pub n: usize,
    /// Drivers with changes that count, where they are named.
    pub drivers: usize,
    /// Rows left out, by reason.
    pub dropped: BTreeMap<&'static str, usize>,
    /// Each kind of change, in the order of their first rows.
    pub by_category: Vec<SpeedChangeLaw>,
    /// All accelerations.
    pub acceleration: Option<SpeedChangeLaw>,
    /// All decelerations.
    pub deceleration: Option<SpeedChangeLaw>,
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
    if n == 0 {
        return Err(SpeedChangeError::NoChanges);
    }
    let counts =
        |a: f64| a > options.smallest_acceleration_mps2 || a < -options.smallest_deceleration_mps2;
    let missing = table.acceleration_mps2.iter().filter(|a| !a.is_finite()).count();
    let within = table.acceleration_mps2.iter().filter(|a| a.is_finite() && !counts(**a)).count();
    if missing + within == n {
        return Err(SpeedChangeError::Nothing { rows: n, within, missing });
    }
    let mut dropped = BTreeMap::from([("missing_value", missing), ("within_threshold", within)]);
    dropped.retain(|_, rows| *rows > 0);
    let mut categories: Vec<&str> = Vec::new();
    for category in &table.category {
        if !categories.contains(&category.as_str()) {
            categories.push(category);
        }
    }
    let law = |name: &str, rising: bool, keep: &dyn Fn(usize) -> bool| {
        let (sign, threshold) = if rising {
            (1.0, options.smallest_acceleration_mps2)
        } else {
            (-1.0, options.smallest_deceleration_mps2)
        };
        let size = |k: usize| (table.driver[k].as_str(), sign * table.acceleration_mps2[k]);
        let mut rows: Vec<(&str, f64)> = (0..n).filter(|k| keep(*k)).map(size).collect();
        rows.retain(|(_, size)| size.is_finite() && *size > 0.0);
        let beyond = rows.iter().filter(|(_, size)| *size > threshold);
        let logs: Vec<_> = beyond.map(|(driver, size)| (*driver, libm::log(*size))).collect();
        let within = rows.len() - logs.len();
        (!logs.is_empty()).then(|| fit_law(name, sign, threshold, within, &logs))
    };
    let of_category = |category: &&str| {
        let keep = |k: usize| table.category[k] == *category;
        [law(category, true, &keep), law(category, false, &keep)]
    };
    let by_category = categories.iter().flat_map(of_category).flatten().collect();
    let named = |k: &usize| counts(table.acceleration_mps2[*k]) && !table.driver[*k].is_empty();
    let drivers: BTreeSet<&str> = (0..n).filter(named).map(|k| table.driver[k].as_str()).collect();
    Ok(SpeedChangeFit {
        n,
        drivers: drivers.len(),
        dropped,
        by_category,
        acceleration: law("all accelerations", true, &|_| true),
        deceleration: law("all decelerations", false, &|_| true),
    })
}

fn check(options: &SpeedChangeOptions) -> Result<(), SpeedChangeError> {
    Ok(check_options([
        above_0("the window", options.window_s),
        from_0("the time before a sign", options.before_s),
        from_0("the time behind a sign", options.after_s),
        from_0("the smallest acceleration", options.smallest_acceleration_mps2),
        from_0("the smallest deceleration", options.smallest_deceleration_mps2),
    ])?)
}

impl SpeedChangeFit {
    /// The laws as a study has them, which draws each of them once a driver: the median of the
    /// typical driver and the SD between drivers. `untruncated` takes the laws with the thresholds
    /// in their likelihood, where they are determined. What was not measured stays as it is in
    /// `model`, and so does the spread where nothing shows how drivers differ.
    pub fn population(&self, model: &SpeedChangeModel, untruncated: bool) -> SpeedChangeModel {
        let law = |fitted: &Option<SpeedChangeLaw>, given: &Quantity| {
            let Some(fitted) = fitted else { return given.clone() };
            let whole = fitted.untruncated.filter(|_| untruncated);
            let between = whole.map_or(fitted.between_drivers, |law| law.between_drivers);
            let plain = whole.map_or(fitted.median_mps2, |law| law.median_mps2);
            let median = between.map_or(plain, |between| between.median_mps2).abs();
            let log_sd = match (between, given) {
                (Some(between), _) => Some(between.driver_log_sd),
                (None, Quantity::Law(Law::LogNormal { log_sd, .. })) => Some(*log_sd),
                (None, _) => None,
            };
            let law = |log_sd| Law::LogNormal { median, log_sd, lower: None, upper: None };
            let log_sd = log_sd.filter(|sd| *sd > 0.0);
            log_sd.map_or(Quantity::Number(median), |log_sd| Quantity::Law(law(log_sd)))
        };
        SpeedChangeModel {
            deceleration_mps2: law(&self.deceleration, &model.deceleration_mps2),
            acceleration_mps2: law(&self.acceleration, &model.acceleration_mps2),
            // what was measured at speed holds there: it is no acceleration from rest
            acceleration_power_factor: match &self.acceleration {
                Some(_) => model.acceleration_power_factor.map(|_| SAME_AT_EVERY_SPEED),
                None => model.acceleration_power_factor,
            },
            ..model.clone()
        }
    }

    /// Standard errors of the laws of a population, each with its key and the number: half of a 95
    /// % interval over its quantile, of the logarithm where it is a median. The interval of a law
    /// with the threshold in its likelihood is not known where drivers have no repetitions.
    pub fn errors_of(
        &self,
        population: &SpeedChangeModel,
        untruncated: bool,
    ) -> Vec<(&'static str, f64, f64)> {
        let half = |[low, high]: [f64; 2]| (high - low) / 2.0;
        let log_half = |ci95: [f64; 2]| half(ci95.map(|a| libm::log(libm::fabs(a)))).abs();
        let mut errors = Vec::new();
        for (fitted, quantity, keys) in [
            (&self.deceleration, &population.deceleration_mps2, DECELERATION),
            (&self.acceleration, &population.acceleration_mps2, ACCELERATION),
        ] {
            let Some(fitted) = fitted else { continue };
            let whole = fitted.untruncated.filter(|_| untruncated);
            let between = whole.map_or(fitted.between_drivers, |law| law.between_drivers);
            let (ci95, df) = match between {
                Some(between) => (between.median_ci95, between.drivers as f64 - 1.0),
                None if whole.is_some() => continue,
                None => (fitted.median_ci95, fitted.n as f64 - 1.0),
            };
            let log_error = ci95.map(|ci95| log_half(ci95) / t_of_interval(LEVEL, df));
            let [itself, of_median, of_spread] = keys;
            match *quantity {
                Quantity::Number(median) => {
                    errors.extend(log_error.map(|error| (itself, median, error * median)));
                }
                Quantity::Law(Law::LogNormal { median, log_sd, .. }) => {
                    errors.extend(log_error.map(|error| (of_median, median, error * median)));
                    let spread = between.and_then(|between| between.driver_log_sd_ci95);
                    let spread = spread.map(|ci95| half(ci95) / NORMAL_975);
                    errors.extend(spread.map(|error| (of_spread, log_sd, error)));
                }
                _ => {}
            }
        }
        errors.retain(|(.., error)| error.is_finite());
        errors
    }

    /// Facts that have to be known of the laws that a study gets.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        let laws = [("acceleration", &self.acceleration), ("deceleration", &self.deceleration)];
        for (name, law) in &laws {
            match law {
                None => warnings
                    .push(format!("no {name} was measured: the study keeps the one of its base")),
                Some(law) if law.between_drivers.is_some_and(|between| between.singular) => {
                    warnings.push(format!(
                        "the REML fit of the {name}s is singular: drivers differ by no more than \
                         their changes do, the study gets one number"
                    ));
                }
                Some(_) => {}
            }
        }
        let blind = |law: &&Option<SpeedChangeLaw>| {
            law.as_ref().is_some_and(|law| law.between_drivers.is_none())
        };
        let kept = "the study keeps the spread of its base";
        if self.drivers == 1 {
            warnings.push(format!(
                "there is one driver only: nothing is known about how drivers differ, {kept}"
            ));
        } else if self.drivers == 0 {
            warnings.push(format!(
                "no driver is named: drivers and their changes cannot be told apart, {kept}"
            ));
        } else {
            for (name, _) in laws.iter().filter(|(_, law)| blind(law)) {
                warnings.push(format!(
                    "no driver has two {name}s, or only one has any: drivers and their changes \
                     cannot be told apart, {kept}"
                ));
            }
        }
        warnings
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

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
            let fit = fit(&table(seed, 1000), &SpeedChangeOptions::default()).unwrap();
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
    fn a_study_takes_what_was_measured_at_speed_at_every_speed() {
        let fit = fit(&table(1, 200), &SpeedChangeOptions::default()).unwrap();
        let law = serde_json::json!({
            "deceleration_mps2": 0.85, "acceleration_mps2": 0.8, "acceleration_power_factor": 4.0,
            "rise": "ramp", "launch_speed_mps": 2.0, "peak_acceleration_ratio": 1.5
        });
        let base: SpeedChangeModel = serde_json::from_value(law).unwrap();
        let median = |model: &SpeedChangeModel| model.acceleration_mps2.centre();
        let typical = |model: &SpeedChangeModel| {
            let streams = ocmc_core::random::Streams::new(1, 0);
            model.sample(&streams, false).acceleration(350e3, 40e3)
        };
        let fitted = fit.population(&base, false);
        // at 20 m/s as from rest, where the base has less
        for speed_mps in [0.0, 20.0] {
            let at = typical(&fitted).at_mps2(speed_mps);
            assert!((at / median(&fitted) - 1.0).abs() < 1e-3, "{speed_mps}: {at}");
        }
        assert!(typical(&base).at_mps2(20.0) < 0.7 * median(&base));
        // decelerations alone leave the law of accelerations as it is
        let downwards = SpeedChangeFit { acceleration: None, ..fit };
        assert_eq!(downwards.population(&base, false).acceleration_power_factor, Some(4.0));
    }

    #[test]
    fn the_papers_table_bounds_the_window() {
        // from 70 to 60 km/h in one go: its median of 1.06 m/s² and the hardest of eight drivers,
        // 1.42 σ above it, with σ = 0.16
        let longest_s = |mps2: f64| 10.0 / 3.6 / mps2;
        let window_s = SpeedChangeOptions::default().window_s;
        assert!(longest_s(1.06) < 3.0 && window_s < longest_s(1.06 * libm::exp(1.42 * 0.16)));
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
    fn an_infinite_acceleration_is_missing_and_not_used() {
        let clean = table(1, 50);
        let mut odd = clean.clone();
        for infinite in [f64::INFINITY, f64::NEG_INFINITY] {
            odd.driver.push("driver 0".to_owned());
            odd.category.push("40-to-70".to_owned());
            odd.acceleration_mps2.push(infinite);
        }
        let options = SpeedChangeOptions::default();
        let (clean, odd) = (fit(&clean, &options).unwrap(), fit(&odd, &options).unwrap());
        assert_eq!((odd.acceleration, odd.deceleration), (clean.acceleration, clean.deceleration));
        assert_eq!(odd.dropped["missing_value"], 2);
    }
}

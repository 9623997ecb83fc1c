//! The population of drivers behind many fits: log-normal gains with correlations, as a study has
//! them.

use super::identify::EventFit;
use crate::moments::{Moments, correlation};
use serde::Serialize;
use std::collections::BTreeSet;

/// Fewest drivers of a population.
const FEWEST_DRIVERS: usize = 3;

/// Medians, spreads and correlations of PID gains; of the logarithms, between drivers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Population {
    /// Drivers with an identified K_P and K_I.
    pub drivers: usize,
    /// Fits that went in.
    pub fits: usize,
    /// Fits that were left out because K_P or K_I is not identified.
    pub left_out: usize,
    /// Median of K_P, in s/m.
    pub proportional_median: f64,
    /// Standard deviation of ln K_P.
    pub proportional_log_sd: f64,
    /// Median of T_i = K_P / K_I, in s.
    pub integral_time_median_s: f64,
    /// Standard deviation of ln T_i.
    pub integral_time_log_sd: f64,
    /// Drivers with an identified K_D.
    pub derivative_drivers: usize,
    /// Median of K_D, in s²/m; none where too few drivers have one.
    pub derivative_median: Option<f64>,
    /// Standard deviation of ln K_D.
    pub derivative_log_sd: Option<f64>,
    /// Correlations of (ln K_P, ln T_i), (ln K_P, ln K_D), (ln T_i, ln K_D); 0 where not known.
    pub correlation: [f64; 3],
    /// Standard deviation of ln K_P between the events of a driver.
    pub proportional_within_log_sd: f64,
}

impl Population {
    /// The population of PID fits; none with fewer than three drivers whose gains are identified.
    ///
    /// A driver counts with the mean logarithm over his events.
    pub fn of(fits: &[EventFit]) -> Option<Self> {
        let identifiable = |fit: &EventFit, name: &str| !fit.not_identifiable.contains(&name);
        let usable = |fit: &&EventFit| {
            fit.ki.is_some() && identifiable(fit, "kp") && identifiable(fit, "ki")
        };
        let names: BTreeSet<&str> = fits.iter().map(|fit| fit.driver.as_str()).collect();
        // of each driver, in logarithms: K_P, T_i and, where it is identified, K_D
        let mut gains: Vec<[f64; 2]> = Vec::new();
        let mut all: Vec<[f64; 3]> = Vec::new();
        let mut squares = 0.0;
        let mut count = 0;
        for name in names {
            let mine: Vec<&EventFit> =
                fits.iter().filter(usable).filter(|fit| fit.driver == name).collect();
            if mine.is_empty() {
                continue;
            }
            count += mine.len();
            let moments = |value: &dyn Fn(&EventFit) -> f64| -> Moments {
                Moments::of(&mine.iter().map(|fit| libm::log(value(fit))).collect::<Vec<f64>>())
            };
            let proportional = moments(&|fit| fit.kp);
            let time = moments(&|fit| fit.kp / fit.ki.unwrap_or(f64::NAN)).mean;
            squares += proportional.squares;
            gains.push([proportional.mean, time]);
            let determined = mine.iter().filter(|fit| identifiable(fit, "kd"));
            // noise may put one below 0
            let derivative = determined.filter_map(|fit| fit.kd.filter(|kd| *kd > 0.0));
            let derivative: Vec<f64> = derivative.map(libm::log).collect();
            if !derivative.is_empty() {
                all.push([proportional.mean, time, Moments::of(&derivative).mean]);
            }
        }
        let drivers = gains.len();
        if drivers < FEWEST_DRIVERS {
            return None;
        }
        let columns = [0, 1].map(|k| gains.iter().map(|row| row[k]).collect::<Vec<f64>>());
        let three = [0, 1, 2].map(|k| all.iter().map(|row| row[k]).collect::<Vec<f64>>());
        let enough = all.len() >= FEWEST_DRIVERS;
        let with_derivative = |k: usize| if enough { paired(&three[k], &three[2]) } else { 0.0 };
        let [proportional, time] = columns.each_ref().map(|column| Moments::of(column));
        let derivative = enough.then(|| Moments::of(&three[2]));
        let within = squares / count.saturating_sub(drivers) as f64;
        Some(Self {
            drivers,
            fits: count,
            left_out: fits.len() - count,
            proportional_median: libm::exp(proportional.mean),
            proportional_log_sd: proportional.sd(),
            integral_time_median_s: libm::exp(time.mean),
            integral_time_log_sd: time.sd(),
            derivative_drivers: all.len(),
            derivative_median: derivative.map(|moments| libm::exp(moments.mean)),
            derivative_log_sd: derivative.map(|moments| moments.sd()),
            correlation: [paired(&columns[0], &columns[1]), with_derivative(0), with_derivative(1)],
            proportional_within_log_sd: if count > drivers { within.sqrt() } else { 0.0 },
        })
    }
}

/// Correlation of paired columns, 0 where one does not vary.
fn paired(a: &[f64], b: &[f64]) -> f64 {
    let (mean_a, mean_b) = (Moments::of(a).mean, Moments::of(b).mean);
    let pairs = a.iter().zip(b).map(|(a, b)| (a - mean_a, b - mean_b));
    correlation(pairs).map_or(0.0, |(r, _)| r.clamp(-0.99, 0.99))
}

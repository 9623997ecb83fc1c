//! The population of drivers behind many fits: log-normal gains with correlations, as a study has
//! them.

use super::identify::EventFit;
use serde::Serialize;

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
        let mut names: Vec<&str> = fits.iter().map(|fit| fit.driver.as_str()).collect();
        names.sort_unstable();
        names.dedup();
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
            let of = |value: &dyn Fn(&EventFit) -> f64| -> Vec<f64> {
                mine.iter().map(|fit| libm::log(value(fit))).collect()
            };
            let proportional = of(&|fit| fit.kp);
            let time = of(&|fit| fit.kp / fit.ki.unwrap_or(f64::NAN));
            let average = mean(&proportional);
            squares += proportional.iter().map(|p| (p - average) * (p - average)).sum::<f64>();
            gains.push([average, mean(&time)]);
            let derivative: Vec<f64> = mine
                .iter()
                .filter(|fit| identifiable(fit, "kd"))
                .filter_map(|fit| fit.kd.map(libm::log))
                .collect();
            if !derivative.is_empty() {
                all.push([average, mean(&time), mean(&derivative)]);
            }
        }
        let drivers = gains.len();
        if drivers < FEWEST_DRIVERS {
            return None;
        }
        let column = |k: usize| gains.iter().map(|row| row[k]).collect::<Vec<f64>>();
        let three = |k: usize| all.iter().map(|row| row[k]).collect::<Vec<f64>>();
        let enough = all.len() >= FEWEST_DRIVERS;
        let derivative = three(2);
        Some(Self {
            drivers,
            fits: count,
            left_out: fits.len() - count,
            proportional_median: libm::exp(mean(&column(0))),
            proportional_log_sd: sd(&column(0)),
            integral_time_median_s: libm::exp(mean(&column(1))),
            integral_time_log_sd: sd(&column(1)),
            derivative_drivers: all.len(),
            derivative_median: enough.then(|| libm::exp(mean(&derivative))),
            derivative_log_sd: enough.then(|| sd(&derivative)),
            correlation: [
                correlation(&column(0), &column(1)),
                if enough { correlation(&three(0), &derivative) } else { 0.0 },
                if enough { correlation(&three(1), &derivative) } else { 0.0 },
            ],
            proportional_within_log_sd: if count > drivers {
                (squares / (count - drivers) as f64).sqrt()
            } else {
                0.0
            },
        })
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn sd(values: &[f64]) -> f64 {
    let average = mean(values);
    let squares: f64 = values.iter().map(|value| (value - average) * (value - average)).sum();
    (squares / (values.len() as f64 - 1.0)).sqrt()
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let (mean_a, mean_b) = (mean(a), mean(b));
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        ab += (a - mean_a) * (b - mean_b);
        aa += (a - mean_a) * (a - mean_a);
        bb += (b - mean_b) * (b - mean_b);
    }
    if aa > 0.0 && bb > 0.0 { (ab / (aa * bb).sqrt()).clamp(-0.99, 0.99) } else { 0.0 }
}

//! Intervals of what is written into studies cover what the data were drawn from: a small part of
//! `examples/coverage.rs`, whose table is in the guide. And fits of many drivers.

use crate::common::field_truck_model;
use ocmc_core::random::{Draws, Stream, Streams};
use ocmc_estimation::fit::curve_speed::{CurveSpeedOptions, CurveTable, fit};
use ocmc_estimation::fit::p_value::t_of_interval;
use ocmc_estimation::fit::speed_change::{self, SpeedChangeOptions, SpeedChangeTable};
use ocmc_estimation::fit::weather::{self, HourlyRecord};

const EXPONENT: f64 = 0.46;
const DRIVER_SD: f64 = 0.056;
const RESIDUAL: f64 = 0.177;

/// Curves under a limit of 19 m/s; those who reach it keep to it.
fn curves(seed: u64, drivers: usize, each: usize) -> CurveTable {
    let mut draws = Draws::new(seed, 0, Stream::Curve);
    let mut table = CurveTable { limit_mps: Some(Vec::new()), ..CurveTable::default() };
    for driver in 0..drivers {
        let level = DRIVER_SD * draws.normal();
        for _ in 0..each {
            let radius_m = (150.0 * (0.7 * draws.normal()).exp()).clamp(21.0, 499.0);
            let log = EXPONENT * (radius_m / 250.0).ln() + level + RESIDUAL * draws.normal();
            table.driver.push(format!("driver {driver}"));
            table.radius_m.push(radius_m);
            table.speed_mps.push((15.14 * log.exp()).min(19.0));
            table.limit_mps.as_mut().unwrap().push(19.0);
        }
    }
    table
}

/// Fails where so many intervals of 95 % lie off it by more than four binomial errors.
#[track_caller]
pub(super) fn assert_covers(what: &str, covered: usize, n: usize) {
    let share = covered as f64 / n as f64;
    let error = (0.95 * 0.05 / n as f64).sqrt();
    assert!((share - 0.95).abs() < 4.0 * error, "{what}: {covered} of {n}");
}

#[test]
fn drivers_of_five_curves_under_a_limit() {
    let mut covered = [0; 4];
    let n = 200;
    for seed in 0..n {
        let tobit = fit(&curves(seed, 40, 5), &CurveSpeedOptions::default()).unwrap();
        let tobit = tobit.tobit.unwrap();
        let within = |[low, high]: [f64; 2], truth: f64| usize::from(low <= truth && truth <= high);
        covered[0] += within(tobit.exponent_clustered_ci95.unwrap(), EXPONENT);
        let reach =
            t_of_interval(0.95, 39.0) * tobit.reference_speed_log_clustered_standard_error.unwrap();
        let log = (tobit.reference_speed_mps / 15.14).ln();
        covered[1] += within([log - reach, log + reach], 0.0);
        covered[2] += within(tobit.driver_sd_corrected_ci95.unwrap(), DRIVER_SD);
        covered[3] += within(tobit.residual_sd_ci95.unwrap(), RESIDUAL);
    }
    let names = ["exponent", "reference speed", "driver_sd", "residual_sd"];
    for (what, covered) in names.into_iter().zip(covered) {
        assert_covers(what, covered, n as usize);
    }
}

#[test]
fn speed_changes_of_drivers() {
    let (mut median, mut spread, n) = (0, 0, 200);
    for seed in 0..n {
        let mut draws = Draws::new(seed, 0, Stream::SpeedChange);
        let mut table = SpeedChangeTable::default();
        for driver in 0..12 {
            let level = 0.2 * draws.normal();
            for _ in 0..3 + driver % 5 {
                table.driver.push(format!("driver {driver}"));
                table.category.push("40-to-70".to_owned());
                table.acceleration_mps2.push(-1.2 * (level + 0.25 * draws.normal()).exp());
            }
        }
        let fit = speed_change::fit(&table, &SpeedChangeOptions::default()).unwrap();
        let law = fit.deceleration.unwrap().between_drivers.unwrap();
        let [low, high] = law.median_ci95.unwrap();
        median += usize::from(low <= -1.2 && -1.2 <= high);
        let [low, high] = law.driver_log_sd_ci95.unwrap();
        spread += usize::from(low <= 0.2 && 0.2 <= high);
    }
    assert_covers("median", median, n as usize);
    assert_covers("SD between drivers", spread, n as usize);
}

#[test]
fn a_humidity_knows_the_errors_of_the_temperature() {
    let truth = field_truck_model().weather;
    let (mut covered, n) = (0, 40);
    for seed in 1..=n {
        let hours = 2 * 365 * 24;
        let series = truth.sample(0.0, 0.0, 3600.0 * f64::from(hours), &Streams::new(seed, 0));
        let record = |hour| {
            let time_s = 3600.0 * f64::from(hour);
            let day_of_year = time_s / 86_400.0;
            HourlyRecord { time_s, day_of_year, weather: series.at(time_s) }
        };
        let records: Vec<HourlyRecord> = (0..hours).map(record).collect();
        let fit = weather::fit(&records, &truth).unwrap();
        assert!(fit.parameters.iter().all(|parameter| parameter.standard_error.is_some()));
        for (key, truth) in [
            ("humidity.mean_logit", truth.humidity.mean_logit),
            ("humidity.annual_amplitude", truth.humidity.annual_amplitude),
            ("humidity.daily_amplitude", truth.humidity.daily_amplitude),
        ] {
            let found = fit.parameters.iter().find(|parameter| parameter.key == key).unwrap();
            let off = (found.value - truth).abs();
            covered += usize::from(off <= 1.96 * found.standard_error.unwrap());
        }
    }
    assert_covers("humidity", covered, 3 * n as usize);
}

#[test]
fn five_thousand_drivers_with_a_hundred_thousand_curves() {
    let table = curves(1, 5000, 20);
    let fit = fit(&table, &CurveSpeedOptions::default()).unwrap();
    assert_eq!((fit.n, fit.drivers), (100_000, 5000));
    let (tobit, reml) = (fit.tobit.unwrap(), fit.random_intercept.unwrap());
    let error = tobit.exponent_clustered_standard_error.unwrap();
    assert!((tobit.exponent - EXPONENT).abs() < 4.0 * error && error < 0.002, "{tobit:?}");
    assert!((tobit.residual_sd - RESIDUAL).abs() < 0.002, "{}", tobit.residual_sd);
    // SD/√(2 · 5000), and the errors of the levels
    let sd = tobit.driver_sd_corrected.unwrap();
    assert!((sd - DRIVER_SD).abs() < 0.004, "{sd}");
    let [low, high] = reml.driver_sd_ci95.unwrap();
    assert!(low < reml.driver_sd && reml.driver_sd < high && high - low < 0.006, "{low} {high}");
    assert_eq!(fit.driver_effects.len(), 5000);
}

//! From a study to logs and back: 25 trucks are driven, their traces taken as logs, the curves
//! found in them, and the driver population fitted to these. It has to be the one that drove.

use crate::common::{column, study};
use ocmc_core::driver::curve_speed::CurveSpeedModel;
use ocmc_core::kernel::drive::trace::{Trace, motions};
use ocmc_core::study::Study;
use ocmc_estimation::fit::curve_speed::{
    CurveSpeedEstimate, CurveSpeedFit, CurveSpeedOptions, CurveTable, fit,
};
use ocmc_estimation::log::TripLog;
use ocmc_estimation::log::curve::{CurveOptions, detect_curves};
use ocmc_io::study::{FittedPart, fitted_study, load_text};
use std::ops::Range;

const TRUCKS: u64 = 25;

/// Rural roads with so many bends a km, each long enough that a truck is steady in its middle where
/// it has reached its speed; nothing else slows it. The drivers are those of field-truck.
fn roads(bends_per_km: f64, length_km: f64) -> String {
    ROADS
        .replace("BENDS_PER_M", &format!("{:?}", 1e-3 * bends_per_km))
        .replace("LENGTH_M", &format!("{:?}", 1e3 * length_km))
}

const ROADS: &str = r#"
[study]
name = "loop"
base = "field-truck-printed"
drop = ["road.types.urban", "road.types.motorway", "road.types.rural.next", "traffic.types.urban", "traffic.types.motorway"]
[mission]
length_m = LENGTH_M
payload_kg = 0.0
[driver.look_ahead]
eco_roll = false
predictive_cruise = false
# who brakes and accelerates gently drives what he wants in nearly all of a bend
[driver.speed_change]
deceleration_mps2 = { distribution = "log_normal", median = 0.6, log_sd = 0.25 }
acceleration_mps2 = { distribution = "log_normal", median = 0.5, log_sd = 0.25 }
acceleration_power_factor = 10.0
peak_acceleration_ratio = 1.05
[road.types.rural]
next = {}
[road.types.rural.curves]
per_m = BENDS_PER_M
maximum_per_m = BENDS_PER_M
sign_exponent = 0.0
median_radius_m = 150.0
radius_log_sd = 0.9
median_length_m = 400.0
length_log_sd = 0.3
maximum_heading_rad = 6.2
[simulation]
step_s = 0.2    # s: a log of at least 5 Hz
without = ["slope", "stop_signs", "give_ways", "traffic_lights", "speed_bumps", "weather", "traffic", "vehicle_spread"]
"#;

/// Curves that are found in the motion of one truck.
fn curves(motion: &Trace, truck: u64) -> CurveTable {
    let column = |name: &str| column(motion, name).into();
    let log = TripLog {
        time_s: column("time_s"),
        speed_mps: column("speed_mps"),
        yaw_rate_radps: column("yaw_rate_radps"),
        limit_mps: Some(column("limit_mps")),
        ..TripLog::default()
    };
    let found = detect_curves(&log, &CurveOptions::default()).unwrap().curves;
    CurveTable {
        driver: vec![format!("truck {truck}"); found.len()],
        radius_m: found.iter().map(|curve| curve.radius_m).collect(),
        speed_mps: found.iter().map(|curve| curve.speed_mps).collect(),
        left: Some(found.iter().map(|curve| curve.left).collect()),
        route_m: None,
        limit_mps: Some(found.iter().map(|curve| curve.limit_mps.unwrap_or(f64::NAN)).collect()),
        acceleration_mps2: Some(found.iter().map(|curve| curve.acceleration_mps2).collect()),
        around: Some(found.iter().map(|curve| curve.around).collect()),
    }
}

/// All trucks, on two threads.
fn measured(study: &Study, seed: u64) -> CurveTable {
    let halves = std::thread::scope(|scope| {
        let half = |trucks: Range<u64>| {
            scope.spawn(move || {
                let drives = motions(study, trucks.clone().map(|truck| study.sample(seed, truck)));
                let curves = trucks.zip(&drives).map(|(truck, drive)| curves(drive, truck));
                curves.collect::<Vec<_>>()
            })
        };
        let (first, second) = (half(0..TRUCKS / 2), half(TRUCKS / 2..TRUCKS));
        [first.join().unwrap(), second.join().unwrap()]
    });
    let mut all = CurveTable {
        left: Some(Vec::new()),
        limit_mps: Some(Vec::new()),
        acceleration_mps2: Some(Vec::new()),
        around: Some(Vec::new()),
        ..CurveTable::default()
    };
    for table in halves.into_iter().flatten() {
        all.driver.extend(table.driver);
        all.radius_m.extend(table.radius_m);
        all.speed_mps.extend(table.speed_mps);
        all.left.as_mut().unwrap().extend(table.left.unwrap());
        all.limit_mps.as_mut().unwrap().extend(table.limit_mps.unwrap());
        all.acceleration_mps2.as_mut().unwrap().extend(table.acceleration_mps2.unwrap());
        all.around.as_mut().unwrap().extend(table.around.unwrap());
    }
    all
}

/// Fails where a censored regression is not of those that drove, within three standard errors, the
/// curves of a truck as one observation.
#[track_caller]
fn assert_population(tobit: &CurveSpeedEstimate, truth: &CurveSpeedModel) {
    let error = tobit.exponent_clustered_standard_error.unwrap();
    assert!(error < 0.01, "{error}");
    assert!((tobit.exponent - truth.exponent).abs() < 3.0 * error, "{} {error}", tobit.exponent);
    let error = tobit.reference_speed_log_clustered_standard_error.unwrap();
    let log_ratio = (tobit.reference_speed_mps / truth.reference_speed_mps).ln();
    assert!(error < 0.02 && log_ratio.abs() < 3.0 * error, "{log_ratio} {error}");
    // an SD of 25 trucks has the error SD/√(2 · 24)
    let sd = tobit.driver_sd_corrected.unwrap();
    assert!((sd - truth.driver_sd).abs() < 3.0 * truth.driver_sd / 48.0f64.sqrt(), "{sd}");
    let error = truth.residual_sd / (2.0 * tobit.n as f64).sqrt();
    assert!((tobit.residual_sd - truth.residual_sd).abs() < 3.0 * error, "{}", tobit.residual_sd);
}

#[test]
fn the_population_that_drove_comes_back() {
    let loaded = load_text("roads", &roads(0.2, 450.0), &[] as &[&str]).unwrap();
    let table = measured(&loaded.study, 1);
    let CurveSpeedFit { tobit, estimated, .. } =
        fit(&table, &CurveSpeedOptions::default()).unwrap();
    let (tobit, truth) = (tobit.unwrap(), &loaded.model.driver.curve_speed);
    assert!(tobit.n > 1500, "{}", tobit.n);
    assert_population(&tobit, truth);
    // without regard to the limits it would not be this population
    let error = estimated.exponent_clustered_standard_error.unwrap();
    assert!(truth.exponent - estimated.exponent > 3.0 * error, "{} {error}", estimated.exponent);
}

/// Where bends are close, trucks still accelerate for their drivers' wish in many of them: half a
/// bend a km costs 0.02 of the exponent. Curves that lie alone, with those in whose middle the
/// truck still gains speed as "at least that fast", have the drivers' law.
#[test]
fn curves_that_were_free_have_the_law_where_bends_are_close() {
    const SEEDS: u64 = 3;
    let loaded = load_text("roads", &roads(0.5, 300.0), &[] as &[&str]).unwrap();
    let truth = &loaded.model.driver.curve_speed;
    let isolated = CurveSpeedOptions { isolated_m: Some(150.0), ..CurveSpeedOptions::default() };
    let (mut off_all, mut off_free, mut variances) = (0.0, 0.0, [0.0; 2]);
    for seed in 1..=SEEDS {
        let table = measured(&loaded.study, seed);
        let blind = CurveTable { acceleration_mps2: None, around: None, ..table.clone() };
        let all = fit(&blind, &CurveSpeedOptions::default()).unwrap().tobit.unwrap();
        let free = fit(&table, &isolated).unwrap();
        assert!(free.dropped["near_another_curve"] > 500, "{:?}", free.dropped);
        let free = free.tobit.unwrap();
        println!(
            "all {:.4} ± {:.4}, free {:.4} ± {:.4}, v0 {:.2} and {:.2} km/h",
            all.exponent,
            all.exponent_clustered_standard_error.unwrap(),
            free.exponent,
            free.exponent_clustered_standard_error.unwrap(),
            3.6 * all.reference_speed_mps,
            3.6 * free.reference_speed_mps
        );
        off_all += all.exponent - truth.exponent;
        off_free += free.exponent - truth.exponent;
        for (sum, fit) in variances.iter_mut().zip([&all, &free]) {
            *sum += fit.exponent_clustered_standard_error.unwrap().powi(2);
        }
        assert_population(&free, truth);
    }
    let [error_all, error_free] = variances.map(f64::sqrt);
    assert!(off_all < -6.0 * error_all, "{off_all} {error_all}");
    assert!(off_free.abs() < 3.0 * error_free, "{off_free} {error_free}");
    assert!(off_free.abs() < 0.5 * off_all.abs(), "{off_free} {off_all}");
}

#[test]
fn a_fit_of_its_own_study_is_a_study_that_drives() {
    let base = study("field-truck", &[]);
    let own = &base.model().driver.curve_speed;
    let part = FittedPart::new(base.model(), &["driver", "curve_speed"], own);
    let (_, model) = fitted_study("field-truck", "again", ("fit", "a run"), &part.json()).unwrap();
    // written with eight digits
    let (a, b) = (&model.driver.curve_speed, &base.model().driver.curve_speed);
    assert!((a.reference_speed_mps / b.reference_speed_mps - 1.0).abs() < 1e-7);
    assert!(a.exponent == b.exponent && a.form == b.form);
}

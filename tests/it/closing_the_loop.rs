//! From a study to logs and back: 25 trucks are driven, their traces taken as logs, the curves
//! found in them, and the driver population fitted to these. It has to be the one that drove.

use crate::common::study;
use ocmc_core::kernel::trace::trace;
use ocmc_core::study::Study;
use ocmc_estimation::fit::curve_speed::{CurveSpeedFit, CurveSpeedOptions, CurveTable, fit};
use ocmc_estimation::log::TripLog;
use ocmc_estimation::log::curve::{CurveOptions, detect_curves};
use ocmc_io::study::{FittedPart, fitted_study, load_text};

const TRUCKS: u64 = 25;
const SEED: u64 = 1;

/// Rural roads with bends far enough apart that a truck is back at its speed before the next one,
/// and long enough that it is steady in their middle; nothing else slows it. The drivers are those
/// of field-truck.
const ROADS: &str = r#"
[study]
name = "loop"
base = "field-truck"
drop = ["road.types.urban", "road.types.motorway", "road.types.rural.next", "traffic.types.urban", "traffic.types.motorway"]
[mission]
length_m = 450.0e3
payload_kg = 0.0
[road.types.rural]
next = {}
[road.types.rural.curves]
per_m = 0.2e-3
maximum_per_m = 0.2e-3
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

/// Curves that are found in the trace of one truck.
fn curves(study: &Study, truck: u64) -> CurveTable {
    let trace = trace(study, SEED, truck);
    let column = |name: &str| {
        trace.columns.iter().find(|column| column.name == name).unwrap().values.as_slice().into()
    };
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
    }
}

/// All trucks, on two threads.
fn measured(study: &Study) -> CurveTable {
    let halves = std::thread::scope(|scope| {
        let half = |parity: u64| {
            scope.spawn(move || {
                (0..TRUCKS)
                    .filter(|k| k % 2 == parity)
                    .map(|k| curves(study, k))
                    .collect::<Vec<_>>()
            })
        };
        let (even, odd) = (half(0), half(1));
        [even.join().unwrap(), odd.join().unwrap()]
    });
    let mut all =
        CurveTable { left: Some(Vec::new()), limit_mps: Some(Vec::new()), ..CurveTable::default() };
    for table in halves.into_iter().flatten() {
        all.driver.extend(table.driver);
        all.radius_m.extend(table.radius_m);
        all.speed_mps.extend(table.speed_mps);
        all.left.as_mut().unwrap().extend(table.left.unwrap());
        all.limit_mps.as_mut().unwrap().extend(table.limit_mps.unwrap());
    }
    all
}

#[test]
fn the_population_that_drove_comes_back() {
    let loaded = load_text("roads", ROADS, &[] as &[&str]).unwrap();
    let table = measured(&loaded.study);
    let CurveSpeedFit { tobit, estimated, .. } =
        fit(&table, &CurveSpeedOptions::default()).unwrap();
    let (tobit, truth) = (tobit.unwrap(), &loaded.model.driver.curve_speed);
    assert!(tobit.n > 1500, "{}", tobit.n);
    // within three standard errors clustered by truck
    let error = tobit.exponent_clustered_standard_error.unwrap();
    assert!(error < 0.01, "{error}");
    assert!((tobit.exponent - truth.exponent).abs() < 3.0 * error, "{} {error}", tobit.exponent);
    let error = tobit.reference_speed_log_clustered_standard_error.unwrap();
    let log_ratio = (tobit.reference_speed_mps / truth.reference_speed_mps).ln();
    assert!(error < 0.02 && log_ratio.abs() < 3.0 * error, "{log_ratio} {error}");
    // an SD of 25 trucks has the error SD/√(2 · 24)
    let sd = tobit.driver_sd.unwrap();
    assert!((sd - truth.driver_sd).abs() < 3.0 * truth.driver_sd / 48.0f64.sqrt(), "{sd}");
    let error = truth.residual_sd / (2.0 * tobit.n as f64).sqrt();
    assert!((tobit.residual_sd - truth.residual_sd).abs() < 3.0 * error, "{}", tobit.residual_sd);
    // without regard to the limits it would not be this population
    let error = estimated.exponent_clustered_standard_error.unwrap();
    assert!(truth.exponent - estimated.exponent > 3.0 * error, "{} {error}", estimated.exponent);
}

#[test]
fn a_fit_of_its_own_study_is_a_study_that_drives() {
    let base = study("field-truck", &[]);
    let own = &base.model().driver.curve_speed;
    let part = FittedPart::new(base.model(), &["driver", "curve_speed"], own);
    let (_, model) = fitted_study("field-truck", "again", "a note", &part.json()).unwrap();
    // written with eight digits
    let (a, b) = (&model.driver.curve_speed, &base.model().driver.curve_speed);
    assert!((a.reference_speed_mps / b.reference_speed_mps - 1.0).abs() < 1e-7);
    assert!(a.exponent == b.exponent && a.form == b.form);
}

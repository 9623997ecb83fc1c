//! The law behind a table of curves: what was put into a study comes back from the curves that its
//! drivers left, through signs, stops, traffic and neighbouring bends.

use crate::common::study;
use ocmc_estimation::calibration::curve_speed::{
    CalibrationOptions, MeasuredCurves, NAMES, Trips, calibrate, simulated_curves,
};
use std::ops::ControlFlow;

/// Half the default's length: bends are as near to stops and to each other.
const ROAD: &str = "mission.length_m=50000";
/// Nothing but signs and neighbouring bends, so that few trips tell enough.
const QUIET: &str = "simulation.without=[\"traffic\",\"stop_signs\",\"give_ways\",\
                     \"traffic_lights\",\"speed_bumps\"]";

#[test]
fn the_law_that_drove_comes_back_from_the_curves_it_left() {
    let truth = [18.0, 0.5, 0.15, 0.2];
    let set =
        NAMES.iter().zip(truth).map(|(name, value)| format!("driver.curve_speed.{name}={value}"));
    let sets: Vec<String> = [ROAD, QUIET].iter().map(|set| (*set).to_owned()).chain(set).collect();
    let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
    let options = CalibrationOptions {
        trips: Trips { seed: 5, drivers: 50, per_driver: 1, threads: 0 },
        ..CalibrationOptions::default()
    };
    // other roads and other drivers than those of the search
    let driven = Trips { seed: 11, ..options.trips };
    let curves = simulated_curves(&study("field-truck", &sets), &driven, &options.detection);
    let measured = MeasuredCurves::of_curves(&curves, &options.fit).unwrap();
    // the fit alone takes what signs and stops did for the drivers' wish
    let seen = measured.numbers;
    assert!(seen.reference_speed_mps < 0.93 * truth[0] && seen.driver_sd < truth[2], "{seen:?}");

    let base = study("field-truck", &[ROAD, QUIET]);
    let mut go_on = |_| ControlFlow::Continue(());
    let found = calibrate(&measured, &base, &options, &mut go_on).unwrap();
    assert!(found.solved && found.at_bound.is_empty(), "{found:#?}");
    let law = found.law;
    let log_ratio = (law.reference_speed_mps / truth[0]).ln();
    let away =
        [log_ratio, law.exponent - truth[1], law.driver_sd - truth[2], law.residual_sd - truth[3]];
    for ((name, away), error) in NAMES.iter().zip(away).zip(found.standard_errors) {
        assert!(away.abs() < 3.0 * error, "{name}: {away} ± {error}");
    }
    // the errors are not so large that anything would come back
    let [speed, exponent, driver, residual] = found.standard_errors;
    assert!(speed < 0.1 && exponent < 0.06 && driver < 0.05 && residual < 0.08, "{found:?}");
}

#[test]
fn a_table_that_no_law_gives_back_is_told_with_what_makes_the_rest() {
    let base = study("field-truck", &[ROAD]);
    let options = CalibrationOptions {
        trips: Trips { seed: 5, drivers: 30, per_driver: 1, threads: 0 },
        ..CalibrationOptions::default()
    };
    let mut numbers = MeasuredCurves::of_law(&base.model().driver.curve_speed).unwrap().numbers;
    numbers.residual_sd = 0.1;
    let measured = MeasuredCurves::stated(numbers, [0.01; 4]);
    let found = calibrate(&measured, &base, &options, &mut |_| ControlFlow::Continue(())).unwrap();
    assert!(found.at_bound.contains(&"residual_sd"), "{found:?}");
    assert!(
        (found.law.residual_sd - options.least_residual_sd).abs() < 1e-12
            && found.simulated.residual_sd > 0.1,
        "{found:?}"
    );
    let without = |k: usize| found.surroundings[k].numbers.residual_sd;
    // what stops trucks makes the most of it
    assert!(without(1) < without(0) && without(2) < without(0), "{:?}", found.surroundings);

    let mut ends = |_| ControlFlow::Break(());
    assert!(calibrate(&measured, &base, &options, &mut ends).is_err());
    let table = study("field-truck-table", &[]);
    assert!(MeasuredCurves::of_law(&table.model().driver.curve_speed).is_err());
}

//! Invented laws of curve speeds, driven, measured as the field's trucks were, and looked for with
//! `ocmc calibrate curve-speed`: the table of docs/src/how-to/calibrate.md.
//! `cargo run --release --example calibration_study [KEY=VALUE]...`
//!
//! drivers=60  drivers of the measured table and of each simulated one
//! trips=1     trips of each
//! seed=1      seed of the search; the measured table is driven with seed + 100
//! truths=1,2  which of the five
//! search=true false looks for no law: how far the measured table is from the one that the true law
//! leaves on the roads of the search, in standard errors of both. Of a number that ends at a bound
//! that is what can be said
#![allow(clippy::print_stdout, reason = "its output is the guide's text")]

use ocmc_core::study::Study;
use ocmc_estimation::calibration::curve_speed::{
    COUNT, CalibrationOptions, CurveSpeedNumbers, MeasuredCurves, NAMES, Trips, calibrate,
    simulated_curves,
};
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// A study, how long its trips are here in m, and v₀ in m/s, δ, SD between drivers and residual SD
/// of the law that drives it. Invented; two above and three below the default's 18.8 m/s.
const TRUTHS: [(&str, f64, [f64; COUNT]); 5] = [
    ("urban-delivery", 40e3, [16.0, 0.50, 0.06, 0.12]),
    ("urban-delivery", 40e3, [20.0, 0.42, 0.12, 0.20]),
    ("urban-delivery", 40e3, [18.0, 0.58, 0.09, 0.30]),
    ("long-haul", 100e3, [17.0, 0.46, 0.05, 0.10]),
    ("long-haul", 100e3, [21.0, 0.54, 0.10, 0.20]),
];
/// Longest step of a log that is measured, in s.
const STEP: &str = "simulation.step_s=0.2";
/// By how much the seed of the measured trips is higher.
const OTHER_ROADS: u64 = 100;
/// A number comes back where it is at most so many standard errors off.
const ERRORS: f64 = 3.0;

fn study(name: &str, length_m: f64, law: &[String]) -> Study {
    let length = format!("mission.length_m={length_m}");
    let sets: Vec<&str> =
        [length.as_str(), STEP].into_iter().chain(law.iter().map(String::as_str)).collect();
    ocmc_io::study::load(name, &sets).unwrap_or_else(|fault| panic!("{fault}")).study
}

fn main() {
    let pair = |text: String| {
        let (key, value) = text.split_once('=').expect("arguments are KEY=VALUE");
        (key.to_owned(), value.to_owned())
    };
    let arguments: BTreeMap<String, String> = std::env::args().skip(1).map(pair).collect();
    let get = |key: &str, standard: &str| -> u64 {
        let text = arguments.get(key).map_or(standard, String::as_str);
        text.parse().expect("a whole number")
    };
    let seed = get("seed", "1");
    let truths = arguments.get("truths").map_or("1,2,3,4,5", String::as_str);
    let options = CalibrationOptions {
        trips: Trips {
            seed,
            drivers: get("drivers", "60"),
            per_driver: get("trips", "1"),
            threads: 0,
        },
        // nothing of the truths is known to the search
        least_residual_sd: 0.0,
        ..CalibrationOptions::default()
    };
    let searches = arguments.get("search").is_none_or(|word| word == "true");
    if searches {
        println!("| study | number | law that drove | its table | law found | off, in SE |");
        println!("|---|---|---|---|---|---|");
    } else {
        println!("| study | number | its table | on the roads of the search | off, in SE |");
        println!("|---|---|---|---|---|");
    }
    let mut far = 0;
    for place in truths.split(',') {
        let place: usize = place.parse().expect("truths are numbered");
        let (name, length_m, truth) = TRUTHS[place - 1];
        let mut law: Vec<String> = NAMES
            .iter()
            .zip(truth)
            .map(|(name, value)| format!("driver.curve_speed.{name}={value}"))
            .collect();
        law.push("driver.curve_speed.parameter_uncertainty=false".to_owned());
        let driven = Trips { seed: seed + OTHER_ROADS, ..options.trips };
        let curves = simulated_curves(&study(name, length_m, &law), &driven, &options.detection);
        let measured =
            MeasuredCurves::of_curves(&curves, &options.fit).expect("its curves have a fit");
        let of = |numbers: CurveSpeedNumbers| {
            let [speed_mps, exponent] = [numbers.reference_speed_mps, numbers.exponent];
            [speed_mps, exponent, numbers.driver_sd, numbers.residual_sd]
        };
        if !searches {
            let there =
                simulated_curves(&study(name, length_m, &law), &options.trips, &options.detection);
            let there =
                MeasuredCurves::of_curves(&there, &options.fit).expect("its curves have a fit");
            for (k, number) in NAMES.iter().enumerate() {
                let [a, b] = [of(measured.numbers)[k], of(there.numbers)[k]];
                let away = if k == 0 { (a / b).ln() } else { a - b };
                let error = measured.standard_errors[k].hypot(there.standard_errors[k]);
                println!("| {name} | `{number}` | {a:.3} | {b:.3} | {:+.1} |", away / error);
            }
            continue;
        }
        let base = study(name, length_m, &[]);
        let mut go_on = |_| ControlFlow::Continue(());
        let found = calibrate(&measured, &base, &options, &mut go_on).expect("there is a law");
        let (table, values) = (of(measured.numbers), of(found.law));
        for (k, number) in NAMES.iter().enumerate() {
            let error = found.standard_errors[k];
            // that of the speed is of its logarithm
            let (away, error_shown) = if k == 0 {
                ((values[k] / truth[k]).ln(), error * values[k])
            } else {
                (values[k] - truth[k], error)
            };
            let off = away / error;
            let at_bound = found.at_bound.contains(number);
            far += usize::from(!at_bound && !(off.abs() <= ERRORS));
            let off = if at_bound { "at its bound".to_owned() } else { format!("{off:+.1}") };
            let digits = if k == 0 { 1 } else { 3 };
            println!(
                "| {name} | `{number}` | {:.digits$} | {:.digits$} | {:.digits$} ± {:.digits$} \
                 | {off} |",
                truth[k], table[k], values[k], error_shown,
            );
        }
        println!(
            "<!-- truth {place}: {} curves, {} drives of the study, solved: {} -->",
            found.curves, found.evaluations, found.solved
        );
    }
    if searches {
        println!("farther than {ERRORS} SE and at no bound: {far}");
    }
}

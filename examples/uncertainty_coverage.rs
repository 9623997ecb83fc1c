//! How good the interval with uncertain numbers is: its half width for ten seeds beside that of the
//! delta method on long paired drives, and how often it covers the mean of the true study where the
//! study that is driven has numbers that were estimated with errors.
//!
//! ```text
//! cargo run --release --example uncertainty_coverage [CYCLES] [STUDIES]
//! ```
//!
//! The truth is `field-truck` on short roads; each synthetic study has draws of four of its numbers
//! from their errors, two of them correlated.

#![allow(clippy::print_stdout, reason = "its output is the guide's text")]

use ocmc_core::random::{Draws, Stream};
use ocmc_core::record::Record;
use ocmc_core::study::Study;
use ocmc_fleet::comparison::compare;
use ocmc_fleet::dependence::Dependence;
use ocmc_fleet::run::{RunPlan, records};
use ocmc_fleet::summary::{Summary, SummaryBuilder};
use std::convert::Infallible;
use std::ops::ControlFlow;

const LAW: &str = "driver.curve_speed.parameter_uncertainty=true";
const ROAD: &str = "mission.length_m=10000";

fn study(sets: &[String]) -> Study {
    ocmc_io::study::load("field-truck", sets).unwrap_or_else(|error| panic!("{error}")).study
}

fn all(study: &Study, plan: &RunPlan) -> ControlFlow<Infallible, Vec<Record>> {
    records(study, plan, |_| ControlFlow::Continue(()))
}

fn summary(study: &Study, plan: &RunPlan) -> Summary {
    let mut fleet = SummaryBuilder::new(Dependence::of(study.model(), plan.seed));
    let ControlFlow::Continue(driven) = all(study, plan);
    fleet.add(&driven);
    let mut summary = fleet.finish();
    let ControlFlow::Continue(()) = summary.add_uncertainty(study, plan, all);
    summary
}

fn half_width([low, high]: [f64; 2]) -> f64 {
    (high - low) / 2.0
}

/// The delta method by comparisons of as many cycles as asked for.
fn delta(cycles: u64) -> f64 {
    let base = study(&[]);
    let law = &base.model().driver.curve_speed;
    let numbers = [
        ("exponent", law.exponent, law.exponent_standard_error),
        (
            "reference_speed_mps",
            law.reference_speed_mps,
            law.reference_speed_mps * law.reference_speed_log_standard_error,
        ),
    ];
    let squares = numbers.map(|(key, value, error)| {
        let side = |value: f64| study(&[format!("driver.curve_speed.{key}={value}")]);
        let (low, high) = (side(value - error), side(value + error));
        let plan = RunPlan::new(977, 0, cycles, None, None);
        let studies = [&low, &high];
        let go_on = |_| ControlFlow::<Infallible>::Continue(());
        let ControlFlow::Continue(found) = compare(&studies, &plan, None, go_on);
        let effect = found.comparisons[0].difference.unwrap_or(f64::NAN) / 2.0;
        println!("  {key}: one standard error does {effect:+.4} L/100 km");
        effect * effect
    });
    squares.iter().sum::<f64>().sqrt()
}

fn seeds(cycles: u64) {
    let sd = delta(cycles);
    println!("delta method, {cycles} cycles of seed 977: sigma {sd:.4} L/100 km");
    let study = study(&[LAW.to_owned()]);
    for seed in 1..=10 {
        let summary = summary(&study, &RunPlan::new(seed, 0, cycles, None, None));
        let sampling = summary.consumption().and_then(|own| own.ci95).map_or(f64::NAN, half_width);
        let whole = (1.959964 * sd).hypot(sampling);
        let found = summary.parameter_uncertainty.expect("the law is uncertain");
        let half = half_width(found.ci95);
        println!(
            "seed {seed}: ± {half:.4}, by the delta method ± {whole:.4}: {:+.1} %; sigma {:.4}",
            100.0 * (half / whole - 1.0),
            found.sd
        );
    }
}

fn coverage(studies: u64) {
    let truth = study(&[ROAD.to_owned()]);
    let law = &truth.model().driver.curve_speed;
    let true_mean = {
        let plan = RunPlan::new(4242, 0, 60_000, None, None);
        summary(&truth, &plan).consumption().and_then(|own| own.mean).unwrap_or(f64::NAN)
    };
    let mass_kg = truth.model().vehicle.curb_mass_kg;
    let (mut covered, mut sampling) = (0, 0);
    for k in 0..studies {
        let mut draws = Draws::new(k, 0, Stream::CurveResidual);
        let (a, b) = (draws.normal(), draws.normal());
        // errors of speed and exponent go together by 0.6
        let speed_mps = law.reference_speed_mps + 0.7 * a;
        let exponent = law.exponent + 0.02 * (0.6 * a + 0.8 * b);
        let driver_sd = law.driver_sd + 0.01 * draws.normal();
        let mass = mass_kg + 300.0 * draws.normal();
        let sets = [
            ROAD.to_owned(),
            format!("driver.curve_speed.reference_speed_mps={speed_mps}"),
            format!("driver.curve_speed.exponent={exponent}"),
            format!("driver.curve_speed.driver_sd={driver_sd}"),
            format!("vehicle.curb_mass_kg={mass}"),
            "uncertainty.law.keys=[\"driver.curve_speed.reference_speed_mps\", \
             \"driver.curve_speed.exponent\"]"
                .to_owned(),
            "uncertainty.law.standard_errors=[0.7, 0.02]".to_owned(),
            "uncertainty.law.correlation=[[1.0, 0.6], [0.6, 1.0]]".to_owned(),
            "uncertainty.more.keys=[\"driver.curve_speed.driver_sd\", \"vehicle.curb_mass_kg\"]"
                .to_owned(),
            "uncertainty.more.standard_errors=[0.01, 300.0]".to_owned(),
        ];
        let summary = summary(&study(&sets), &RunPlan::new(k, 0, 1000, None, None));
        let holds = |ci95: [f64; 2]| u64::from((ci95[0]..=ci95[1]).contains(&true_mean));
        sampling += summary.consumption().and_then(|own| own.ci95).map_or(0, holds);
        covered += summary.parameter_uncertainty.map_or(0, |found| holds(found.ci95));
    }
    println!(
        "{covered} of {studies} intervals cover the true mean {true_mean:.3}; {sampling} of \
         sampling alone"
    );
}

fn main() {
    let number = |k: usize| std::env::args().nth(k).and_then(|text| text.parse().ok());
    seeds(number(1).unwrap_or(10_000));
    coverage(number(2).unwrap_or(200));
}

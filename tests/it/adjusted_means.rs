//! Adjusted means: what trips are expected to have is what they have, and the means are nearer to
//! the truth than plain ones, with intervals that hold it.

use ocmc_fleet::comparison::compare;
use ocmc_fleet::run::{RunPlan, records};
use ocmc_fleet::summary::{Summary, SummaryBuilder};
use ocmc_io::study::builtin::STUDIES;
use ocmc_io::study::load;
use std::ops::ControlFlow;
use std::sync::Arc;

const DRAWS: u64 = 20_000;

#[test]
fn every_number_of_an_outline_has_the_expectation_that_is_taken_for_it() {
    for built_in in STUDIES {
        let study = load(built_in.name, &[] as &[&str]).expect("built in").study;
        let expectation = study.outline_expectation();
        let mut known: Vec<Vec<f64>> =
            (0..512).flat_map(|b| study.outlines_of_second_sample(1, b, 0)).collect();
        for outline in &mut known {
            expectation.put_into(outline);
        }
        let drawn: Vec<Vec<f64>> = (0..DRAWS).map(|id| study.outline(2, id)).collect();
        for (k, name) in study.outline_names().iter().enumerate() {
            let expected = known.iter().map(|o| o[k]).sum::<f64>() / known.len() as f64;
            let own: Vec<f64> = drawn.iter().map(|outline| outline[k]).collect();
            let n = own.len() as f64;
            let mean = own.iter().sum::<f64>() / n;
            let squares = own.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>();
            // the expectation has an error, too: that of as many draws as there are, at most
            let draws = 1.0 / n + 1.0 / known.len() as f64;
            let error = (squares / (n - 1.0) * draws).sqrt() + 1e-9 * expected.abs();
            let what = format!("{} {name}: {mean} {expected} {error}", built_in.name);
            assert!((mean - expected).abs() <= 4.0 * error, "{what}");
        }
    }
}

/// The adjusted mean, its interval, the plain mean.
type Found = (f64, [f64; 2], f64);

fn summary(study: &Arc<ocmc_core::study::Study>, seed: u64, cycles: u64) -> Summary {
    let plan = RunPlan::new(seed, 0, cycles, None, None);
    let ControlFlow::Continue(driven) = records(study, &plan, |_| ControlFlow::<()>::Continue(()))
    else {
        unreachable!("nobody breaks")
    };
    let mut fleet = SummaryBuilder::of(study, seed);
    // in pieces, as a run hands them over
    for piece in driven.chunks(37) {
        fleet.add(piece);
    }
    fleet.finish()
}

#[test]
fn adjusted_means_are_nearer_to_the_truth_and_their_intervals_hold_it() {
    const RUNS: u64 = 24;
    let sets = ["mission.length_m=5000"];
    let study = Arc::new(load("field-truck", &sets).expect("a study").study);
    let runs: Vec<Found> = (1..=RUNS)
        .map(|seed| {
            let found = summary(&study, seed, 250);
            let own = found.consumption().expect("fuel");
            let adjusted = own.adjusted.as_ref().expect("enough cycles");
            (adjusted.mean, adjusted.ci95, own.mean.expect("a mean"))
        })
        .collect();
    let n = RUNS as f64;
    let truth = runs.iter().map(|run| run.0).sum::<f64>() / n;
    let spread = |value: &dyn Fn(&Found) -> f64| {
        let mean = runs.iter().map(value).sum::<f64>() / n;
        let squares = runs.iter().map(|run| (value(run) - mean) * (value(run) - mean));
        (mean, (squares.sum::<f64>() / (n - 1.0)).sqrt())
    };
    let ((_, adjusted), (plain_mean, plain)) = (spread(&|run| run.0), spread(&|run| run.2));
    assert!(adjusted < 0.75 * plain, "{adjusted} {plain}");
    assert!((plain_mean - truth).abs() < 4.0 * plain / n.sqrt(), "{plain_mean} {truth}");
    let covered = runs.iter().filter(|(_, [low, high], _)| *low <= truth && truth <= *high).count();
    // of 24 intervals that hold 95 of 100 times fewer than 19 do in 1 of 400 cases
    assert!(covered >= 19, "{covered}");
}

#[test]
fn few_trips_and_trucks_have_plain_means_alone() {
    let study = Arc::new(load("field-truck", &["mission.length_m=2000"]).expect("a study").study);
    let few = summary(&study, 1, 4);
    assert!(few.consumption().expect("fuel").adjusted.is_none());
    let sets = ["mission.length_m=2000", "fleet.trips_per_truck=5"];
    let trucks = Arc::new(load("field-truck", &sets).expect("a study").study);
    // four trucks: not one term
    assert!(summary(&trucks, 1, 20).consumption().expect("fuel").adjusted.is_none());
    assert!(summary(&trucks, 1, 200).consumption().expect("fuel").adjusted.is_some());
}

/// The plain difference, the adjusted one, its interval.
type Differences = (f64, f64, [f64; 2]);

#[test]
fn adjusted_differences_are_nearer_to_the_truth_and_their_intervals_hold_it() {
    const RUNS: u64 = 40;
    let own = load("field-truck", &["mission.length_m=10000"]).expect("a study");
    let law = "vehicle.drag_area_m2={distribution=\"log_normal\",median=4.41,log_sd=0.05}";
    let slippery = own.set(&[law]).expect("a study");
    let studies = [&own.study, &slippery.study];
    let runs: Vec<Differences> = (1..=RUNS)
        .map(|seed| {
            let plan = RunPlan::new(seed, 0, 250, None, None);
            let go_on = |_| ControlFlow::<()>::Continue(());
            let ControlFlow::Continue(mut found) = compare(&studies, &plan, None, go_on) else {
                unreachable!("nobody breaks")
            };
            let found = found.comparisons.remove(0);
            let adjusted = found.adjusted.expect("enough pairs");
            (found.difference.expect("pairs"), adjusted.difference, adjusted.ci95)
        })
        .collect();
    let n = RUNS as f64;
    let moments = |value: &dyn Fn(&Differences) -> f64| {
        let mean = runs.iter().map(value).sum::<f64>() / n;
        let squares = runs.iter().map(|run| (value(run) - mean) * (value(run) - mean));
        (mean, squares.sum::<f64>() / (n - 1.0))
    };
    let ((plain_mean, plain), (truth, adjusted)) = (moments(&|run| run.0), moments(&|run| run.1));
    // some 2: at 1.3 times the noise of a quotient of variances of 40 runs each
    assert!(plain > 1.3 * adjusted, "{plain} {adjusted}");
    assert!((plain_mean - truth).abs() < 4.0 * (plain / n).sqrt(), "{plain_mean} {truth}");
    let held = runs.iter().filter(|(.., [low, high])| *low <= truth && truth <= *high).count();
    // of 40 intervals that hold 95 of 100 times fewer than 33 do in 1 of 700 cases
    assert!(held >= 33, "{held}");
}

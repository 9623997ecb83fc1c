//! The shares of the variance of a real study, estimated in two ways that have nothing in common but the cycles.

mod common;

use ocmc_core::fleet::quantity::{Quantity, quantity};
use ocmc_core::fleet::random_effects::two_way;
use ocmc_core::fleet::run::{RunPlan, records};
use ocmc_core::fleet::sensitivity::{FactorGroup, factor_groups, sensitivity};
use ocmc_core::random::{Exchange, StreamSet};
use ocmc_core::study::Study;
use std::convert::Infallible;
use std::ops::ControlFlow;

const COLUMN: &str = "consumption_l_per_100km";

fn done<T>(answer: ControlFlow<Infallible, T>) -> T {
    match answer {
        ControlFlow::Continue(answer) => answer,
        ControlFlow::Break(never) => match never {},
    }
}

fn values(study: &Study, plan: &RunPlan, quantity: &Quantity) -> Vec<f64> {
    let records = done(records(study, plan, |_| ControlFlow::Continue(())));
    records.iter().map(|record| quantity.of_cycle(record).expect("every cycle completes")).collect()
}

fn mean_and_variance(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0))
}

/// Nested loops: for each of `outer` draws of these streams, `inner` draws of all others. Returns the variance of the
/// inner means, freed of the inner noise, with its standard error, and the mean of the inner variances with its own.
fn nested(study: &Study, streams: StreamSet, outer: u64, inner: u64) -> [(f64, f64); 2] {
    let quantity = quantity(COLUMN).expect("known");
    let (mut means, mut variances) = (Vec::new(), Vec::new());
    for k in 0..outer {
        // ids that no other loop of this test uses
        let plan = RunPlan {
            exchange: Exchange { streams, cycle_id: Some(1_000_000 + k) },
            ..RunPlan::new(1, 2_000_000 + k * inner, inner, Some(2), None)
        };
        let (mean, variance) = mean_and_variance(&values(study, &plan, quantity));
        means.push(mean);
        variances.push(variance);
    }
    let n = outer as f64;
    let (within, spread) = mean_and_variance(&variances);
    let (centre, between) = mean_and_variance(&means);
    let fourth = means.iter().map(|m| (m - centre).powi(4)).sum::<f64>() / n;
    let first = between - within / inner as f64;
    let first_error = ((fourth - between * between).max(0.0) / n).sqrt();
    [(first, first_error), (within, (spread / n).sqrt())]
}

#[test]
fn pick_and_freeze_agrees_with_nested_loops_on_a_10_km_study() {
    let study = common::study("field-truck", &["mission.length_m=10000"]);
    let wanted = ["road", "mission", "driver"];
    let groups: Vec<FactorGroup> =
        factor_groups().into_iter().filter(|group| wanted.contains(&group.name)).collect();
    let plan = RunPlan::new(1, 0, 1000, Some(2), None);
    let quantity = quantity(COLUMN);
    let found = sensitivity(&study, &plan, &groups, quantity, |_| ControlFlow::Continue(()));
    let found = done(found).expect("enough rows");
    for (group, share) in groups.iter().zip(&found.factors) {
        let [(between, between_error), _] = nested(&study, group.streams, 100, 15);
        let [_, (within, within_error)] = nested(&study, group.streams.complement(), 300, 4);
        let v = found.variance;
        for (name, brute, error, estimate, [low, high]) in [
            ("alone", between / v, between_error / v, share.first, share.first_ci95),
            ("total", within / v, within_error / v, share.total, share.total_ci95),
        ] {
            let own_error = (high - low) / 3.92;
            let inside = low <= brute && brute <= high && (brute - estimate).abs() < 1.96 * error;
            eprintln!(
                "{:8} {name}: {estimate:.3} ({low:.3} to {high:.3}), nested {brute:.3} ± {:.3}{}",
                group.name,
                1.96 * error,
                if inside { ", within both intervals" } else { "" }
            );
            let joint = own_error.hypot(error);
            assert!((estimate - brute).abs() < 4.0 * joint, "{} {name}", group.name);
            assert!(joint < 0.1, "{} {name}: a test that sees something, {joint}", group.name);
        }
    }
}

#[test]
fn two_ways_of_asking_for_the_driver_agree() {
    let study = common::study("field-truck", &["mission.length_m=10000"]);
    let plan = RunPlan::new(1, 0, 100, Some(2), None);
    let shares = done(two_way(&study, &plan, 30, quantity(COLUMN), |_| ControlFlow::Continue(())));
    let shares = shares.expect("enough cycles");
    let driver: Vec<FactorGroup> =
        factor_groups().into_iter().filter(|group| group.name == "driver").collect();
    let plan = RunPlan::new(1, 0, 1500, Some(2), None);
    let found =
        sensitivity(&study, &plan, &driver, quantity(COLUMN), |_| ControlFlow::Continue(()));
    let share = done(found).expect("enough rows").factors.remove(0);
    eprintln!("{shares:?}, {share:?}");
    // the driver alone is the first-order share; with what both do together it is the total one. The crossed design has
    // 30 drivers, so a standard error of about a quarter of the driver's share, and 100 cycles, a tenth of the rest's
    let [low, high] = share.first_ci95;
    let error = ((high - low) / 3.92).hypot(0.25 * shares.driver.abs() + 0.01);
    assert!((shares.driver - share.first).abs() < 4.0 * error);
    let [low, high] = share.total_ci95;
    let error = ((high - low) / 3.92).hypot(0.2 * (shares.driver + shares.both));
    assert!((shares.driver + shares.both - share.total).abs() < 4.0 * error);
}

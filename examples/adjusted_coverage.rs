//! How often the intervals of adjusted means and quantiles cover the truth, how far they are from
//! it, and by how much they are narrower than those of plain ones.
//!
//!     cargo run --release --example adjusted_coverage -- STUDY [RUNS] [CYCLES ...] [key=value ...]
//!     [against:key=value]
//!
//! With `against:` it is the difference to the study with this setting that is asked about.
//!
//! Each run has a seed of its own, 1001 and on, and is read at each number of cycles. The truth is
//! the mean over all runs at the largest number: adjusted means, P95 and their plain neighbours are
//! held against it.

#![allow(clippy::print_stdout, reason = "the table is what it is for")]

use ocmc_api::study;
use ocmc_core::study::Study;
use ocmc_fleet::comparison::compare;
use ocmc_fleet::run::{RunPlan, records};
use ocmc_fleet::statistic::Statistic;
use ocmc_fleet::summary::SummaryBuilder;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Estimate and interval, adjusted and plain, of the mean and of P95.
type Found = [Option<(f64, [f64; 2])>; 4];

const NAMES: [&str; 4] = ["mean adjusted", "mean plain", "P95 adjusted", "P95 plain"];

fn found(own: &Statistic) -> Found {
    let adjusted = own.adjusted.as_ref();
    let p95 = adjusted.and_then(|adjusted| adjusted.quantiles.get("p95"));
    [
        adjusted.map(|adjusted| (adjusted.mean, adjusted.ci95)),
        own.mean.zip(own.ci95),
        p95.map(|p95| (p95.value, p95.ci95)),
        own.quantiles[4].value.zip(own.quantiles[4].ci95),
    ]
}

/// Difference and interval, adjusted and plain, and nothing of P95.
fn difference(studies: &[&Study], plan: &RunPlan) -> Option<Found> {
    let go_on = |_| ControlFlow::<()>::Continue(());
    let ControlFlow::Continue(mut found) = compare(studies, plan, None, go_on) else {
        return None;
    };
    let found = found.comparisons.remove(0);
    let adjusted = found.adjusted.map(|adjusted| (adjusted.difference, adjusted.ci95));
    Some([adjusted, found.difference.zip(found.ci95), None, None])
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (against, arguments): (Vec<String>, Vec<String>) =
        arguments.into_iter().partition(|argument| argument.starts_with("against:"));
    let (sets, others): (Vec<String>, Vec<String>) =
        arguments.into_iter().partition(|argument| argument.contains('='));
    let name = others.first().map_or("field-truck", String::as_str);
    let number = |text: &String| text.parse::<u64>().expect("a number");
    let runs = others.get(1).map_or(400, number);
    let mut sizes: Vec<u64> = others.iter().skip(2).map(number).collect();
    if sizes.is_empty() {
        sizes = vec![200, 400, 800, 1600];
    }
    let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
    let loaded = study::load(name, &sets).expect("a study");
    let other =
        against.first().map(|set| loaded.set(&[&set["against:".len()..]]).expect("a study").study);
    let study = Arc::new(loaded.study);
    let most = *sizes.iter().max().expect("a size");
    let mut all: Vec<Vec<Found>> = vec![Vec::new(); sizes.len()];
    for seed in 1001..=1000 + runs {
        if let Some(other) = &other {
            for (size, all) in sizes.iter().zip(&mut all) {
                let plan = RunPlan::new(seed, 0, *size, None, None);
                all.extend(difference(&[&study, other], &plan));
            }
            continue;
        }
        let plan = RunPlan::new(seed, 0, most, None, None);
        let driven = records(&study, &plan, |_| ControlFlow::<()>::Continue(()));
        let ControlFlow::Continue(driven) = driven else { return };
        for (size, all) in sizes.iter().zip(&mut all) {
            let mut fleet = SummaryBuilder::of(&study, seed);
            fleet.add(&driven[..*size as usize]);
            all.extend(fleet.finish().consumption().map(found));
        }
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let last = all.last().expect("a size");
    let of = |k: usize| -> Vec<f64> {
        let known = last.iter().filter_map(|found| found[k].or(found[k | 1]));
        known.map(|(value, _)| value).collect()
    };
    let truths = [mean(&of(0)), mean(&of(2))];
    println!("{name}: mean {:.4}, P95 {:.4}; {runs} runs", truths[0], truths[1]);
    println!("cycles                  runs  covered %   bias/SE   half width   variance ratio");
    for (size, all) in sizes.iter().zip(&all) {
        let mut widths = [f64::NAN; 4];
        for k in 0..4 {
            let truth = truths[k / 2];
            let known: Vec<(f64, [f64; 2])> = all.iter().filter_map(|found| found[k]).collect();
            if known.is_empty() {
                continue;
            }
            let n = known.len() as f64;
            let covered = known.iter().filter(|(_, [l, h])| *l <= truth && truth <= *h).count();
            let values: Vec<f64> = known.iter().map(|(value, _)| *value).collect();
            let centre = mean(&values);
            let squares: f64 = values.iter().map(|v| (v - centre) * (v - centre)).sum();
            let sd = (squares / (n - 1.0)).sqrt();
            widths[k] = mean(&known.iter().map(|(_, [l, h])| (h - l) / 2.0).collect::<Vec<_>>());
            let ratio = if k % 2 == 0 { f64::NAN } else { (widths[k] / widths[k - 1]).powi(2) };
            println!(
                "{size:>6} {:<14} {:>7} {:>10.1} {:>9.3} {:>12.4} {ratio:>12.1}",
                NAMES[k],
                known.len(),
                100.0 * covered as f64 / n,
                (centre - truth) / sd,
                widths[k],
            );
        }
    }
}

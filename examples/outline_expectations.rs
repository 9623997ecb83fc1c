//! How far the expectations that means are adjusted by are from a million draws, and what they
//! cost.
//!
//!     cargo run --release --example outline_expectations -- [DRAWS]
//!
//! A row a study: the time of its 8192 outlines, and the numbers that lie farthest from the mean of
//! the draws, in standard errors; those in closed form (payload, shares of road types) apart.

#![allow(clippy::print_stdout, reason = "the table is what it is for")]

use ocmc_api::study;
use std::time::Instant;

fn main() {
    let draws: u64 = std::env::args().nth(1).map_or(1_000_000, |n| n.parse().expect("a number"));
    println!("{:<22}{:>9}  closed forms, others: standard errors", "study", "8192, s");
    for built_in in study::list() {
        let study = study::load(built_in.name, &[] as &[&str]).expect("built in").study;
        let clock = Instant::now();
        let expectation = study.outline_expectation();
        let drawn: Vec<Vec<f64>> =
            (0..512).flat_map(|b| study.outlines_of_second_sample(1, b, 0)).collect();
        let took = clock.elapsed().as_secs_f64();
        let mut known = drawn.clone();
        for outline in &mut known {
            expectation.put_into(outline);
        }
        let names = study.outline_names();
        let mut sums = vec![(0.0, 0.0); names.len()];
        for id in 0..draws {
            for (sum, x) in sums.iter_mut().zip(study.outline(2, id)) {
                *sum = (sum.0 + x, sum.1 + x * x);
            }
        }
        let n = draws as f64;
        let mut worst = [(0.0, ""), (0.0, "")];
        for (k, name) in names.iter().enumerate() {
            let (mean, square) = (sums[k].0 / n, sums[k].1 / n);
            let variance = (square - mean * mean).max(0.0);
            let expected = known.iter().map(|o| o[k]).sum::<f64>() / known.len() as f64;
            let is_closed = known.iter().all(|o| o[k] == known[0][k]) && variance > 0.0;
            // batches spread evenly, so that this is the most of their error
            let of_sample = if is_closed { 0.0 } else { 1.0 / known.len() as f64 };
            let error = (variance * (1.0 / n + of_sample)).sqrt() + 1e-9 * expected.abs();
            let apart = if error > 0.0 { (mean - expected).abs() / error } else { 0.0 };
            let worst = &mut worst[usize::from(!is_closed)];
            if apart > worst.0 {
                *worst = (apart, name);
            }
        }
        let [closed, others] = worst.map(|(apart, name)| format!("{apart:.1} {name}"));
        println!("{:<22}{took:>9.3}  {closed}, {others}", built_in.name);
    }
}

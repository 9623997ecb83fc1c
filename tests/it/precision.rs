//! Runs that end at a precision, over and over: how often their intervals cover what they are
//! about. The cycles are those of the real engine, driven once; each run draws its own from them,
//! with replacement, so that the truth is known without an error.

use ocmc_core::random::{Draws, Stream};
use ocmc_core::record::Record;
use ocmc_fleet::dependence::Dependence;
use ocmc_fleet::precision::{InterimChecks, Precision};
use ocmc_fleet::run::{RunPlan, records};
use ocmc_fleet::summary::{Summary, SummaryBuilder};
use std::convert::Infallible;
use std::ops::ControlFlow;

const RUNS: u64 = 1000;

/// Cycles to draw from: whole batches.
const POOL: u64 = 96_000;

/// The consumption of a fleet, or a quantile of it, with its interval.
fn answer(summary: &Summary, of: &str) -> (f64, [f64; 2]) {
    let litres = summary.consumption().expect("a diesel truck");
    let quantile = litres.quantiles.iter().find(|quantile| quantile.name == of);
    let (value, ci95) =
        quantile.map_or((litres.mean, litres.ci95), |quantile| (quantile.value, quantile.ci95));
    (value.expect("a value"), ci95.expect("an interval"))
}

fn assert_covers(sets: &[&str], names: &[&str]) {
    let study = crate::common::study("field-truck", &[&["mission.length_m=1000"], sets].concat());
    let dependence = Dependence::of(study.model(), 1);
    let plan = RunPlan::new(1, 0, POOL, Some(2), None);
    let driven: ControlFlow<Infallible, Vec<Record>> =
        records(&study, &plan, |_| ControlFlow::Continue(()));
    let ControlFlow::Continue(pool) = driven;
    let mut all = SummaryBuilder::new(dependence);
    all.add(&pool);
    let all = all.finish();
    let batches: Vec<&[Record]> = pool.chunks(dependence.batch as usize).collect();
    for of in names {
        let (truth, [low, high]) = answer(&all, of);
        // three quarters of the half-width of 1000 cycles: after about 1800 of them
        let of_thousand = (high - low) / 2.0 / truth * (POOL as f64 / 1000.0).sqrt();
        let precision = Precision { of: (*of).to_owned(), wanted: 0.75 * of_thousand };
        let (mut covered, mut cycles) = (0, 0);
        for run in 0..RUNS {
            let mut draws = Draws::new(1, run, Stream::Bootstrap);
            let mut fleet = SummaryBuilder::new(dependence);
            let mut checks = InterimChecks::new(Some(&precision), 0, 1);
            loop {
                let batch = batches[(draws.uniform() * batches.len() as f64) as usize];
                let ids = fleet.cycles()..;
                let drawn: Vec<Record> = ids
                    .zip(batch)
                    .map(|(cycle_id, record)| Record { cycle_id, ..record.clone() })
                    .collect();
                let taken: ControlFlow<Option<()>> =
                    checks.take(&mut fleet, &drawn, |_, _| ControlFlow::Continue(()));
                if taken.is_break() {
                    break;
                }
            }
            cycles += fleet.cycles();
            let (_, [low, high]) = answer(&fleet.finish(), of);
            covered += u64::from(low <= truth && truth <= high);
        }
        let (share, cycles) = (covered as f64 / RUNS as f64, cycles as f64 / RUNS as f64);
        eprintln!("{of}, {sets:?}: {share} cover {truth:.3}, {cycles} cycles on average");
        // 95 % of 1000 runs, two standard errors to either side
        assert!((0.936..=0.964).contains(&share), "{of} {sets:?}: {share}");
        assert!(cycles > 1250.0, "{of} {sets:?}: several checks, {cycles}");
    }
}

#[test]
fn intervals_of_independent_cycles() {
    assert_covers(&[], &["mean", "p50", "p95"]);
}

#[test]
fn intervals_of_cycles_that_spread_evenly() {
    assert_covers(&["simulation.sampling=sobol"], &["mean"]);
}

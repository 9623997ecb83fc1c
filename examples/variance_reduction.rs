//! Measures what `simulation.sampling = "sobol"` gains: prints the table of
//! docs/src/how-to/spread-evenly.md. `cargo run --release --example variance_reduction [CYCLES]`,
//! on a machine that has nothing else to do.
#![allow(clippy::print_stdout, reason = "its output is the guide's text")]

use ocmc_core::study::Study;
use ocmc_fleet::dependence::Dependence;
use ocmc_fleet::quantity::LITRES;
use ocmc_fleet::run::{RunPlan, run};
use ocmc_fleet::statistic::Statistic;
use ocmc_fleet::summary::SummaryBuilder;
use std::ops::ControlFlow;
use std::time::Instant;

const THREADS: usize = 2;

/// Parts of a run that are timed one by one, in turns with the other kind.
const ROUNDS: u64 = 5;

/// A run that is under way.
struct Fleet {
    study: Study,
    summed: SummaryBuilder,
    fastest_s: f64,
}

impl Fleet {
    fn new(name: &str, sets: &[&str]) -> Self {
        let study = ocmc_io::study::load(name, sets).expect("built-in studies load").study;
        let summed = SummaryBuilder::new(Dependence::of(study.model(), 1));
        Self { study, summed, fastest_s: f64::INFINITY }
    }

    fn drive(&mut self, first_cycle: u64, cycles: u64) {
        let plan = RunPlan::new(1, first_cycle, cycles, Some(THREADS), None);
        let clock = Instant::now();
        let end: ControlFlow<()> = run(&self.study, &plan, |records| {
            self.summed.add(&records);
            ControlFlow::Continue(())
        });
        assert!(end.is_continue());
        self.fastest_s = self.fastest_s.min(clock.elapsed().as_secs_f64());
    }

    fn litres(self) -> Statistic {
        self.summed.finish().statistic(LITRES).expect("a diesel truck").clone()
    }
}

fn half_width(ci95: Option<[f64; 2]>) -> f64 {
    ci95.map_or(f64::NAN, |[low, high]| (high - low) / 2.0)
}

fn main() {
    let cycles = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(20_000);
    println!("{cycles} cycles each, seed 1, {THREADS} threads.\n");
    println!(
        "| study | mean ± 95 %, independent | mean ± 95 %, sobol | variance of the mean, \
         independent over sobol | ms a cycle, independent, sobol | the same over the time | P95 ±, \
         independent, sobol |"
    );
    println!("|---|---|---|---|---|---|---|");
    let part = cycles / ROUNDS;
    for (name, sets) in [
        ("field-truck", &[][..]),
        ("field-truck", &["mission.length_m=10000"]),
        ("field-truck-loaded", &[]),
        ("simulator-truck", &[]),
        ("long-haul", &[]),
        ("regional", &[]),
        ("urban-delivery", &[]),
    ] {
        let mut own = Fleet::new(name, sets);
        let mut even = Fleet::new(name, &[sets, &["simulation.sampling=sobol"]].concat());
        for round in 0..ROUNDS {
            own.drive(round * part, part);
            even.drive(round * part, part);
        }
        let [own_ms, even_ms] = [&own, &even].map(|run| 1000.0 * run.fastest_s / part as f64);
        let (own, even) = (own.litres(), even.litres());
        let (own_half, even_half) = (half_width(own.ci95), half_width(even.ci95));
        let variance = (own_half / even_half).powi(2);
        let gain = variance * own_ms / even_ms;
        let p95 = |statistic: &Statistic| half_width(statistic.quantiles[4].ci95);
        let label = sets.first().map_or(String::new(), |set| format!(" with `{set}`"));
        println!(
            "| `{name}`{label} | {:.3} ± {own_half:.4} | {:.3} ± {even_half:.4} | {variance:.2} | \
             {own_ms:.3}, {even_ms:.3} | {gain:.2} | {:.3}, {:.3} |",
            own.mean.unwrap_or(f64::NAN),
            even.mean.unwrap_or(f64::NAN),
            p95(&own),
            p95(&even)
        );
    }
}

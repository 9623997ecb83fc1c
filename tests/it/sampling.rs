//! Cycles that spread evenly over batches: the same bytes whatever the threads and parts, and
//! honest intervals.

use crate::program::{SHORT, ocmc, run_into};
use ocmc_core::study::Study;
use ocmc_fleet::dependence::Dependence;
use ocmc_fleet::quantity::LITRES;
use ocmc_fleet::run::{RunPlan, run};
use ocmc_fleet::statistic::Statistic;
use ocmc_fleet::summary::SummaryBuilder;
use std::fs;
use std::ops::ControlFlow;
use std::path::Path;

const SOBOL: &str = "simulation.sampling=sobol";

fn bytes(directory: &Path) -> (Vec<u8>, Vec<u8>) {
    let read = |file: &str| fs::read(directory.join(file)).expect("written");
    (read("records.parquet"), read("manifest.json"))
}

#[test]
fn records_do_not_depend_on_threads_or_chunks_and_parts_are_parts() {
    let parent = tempfile::tempdir().expect("a directory");
    let run = |name: &str, options: &[&str]| {
        let out = parent.path().join(name);
        run_into(&out, &[&["--set", SOBOL], options].concat());
        out
    };
    let whole = run("whole", &["--cycles", "200", "--threads", "1"]);
    for (name, options) in [("two", ["--threads", "2"]), ("chunk", ["--chunk", "7"])] {
        let other = run(name, &[&["--cycles", "200"], &options[..]].concat());
        assert!(bytes(&other) == bytes(&whole), "{name}");
    }
    // cut within a batch
    let first = run("first", &["--cycles", "105"]);
    let second = run("second", &["--first-cycle", "105", "--cycles", "95"]);
    let rows = |directory: &Path| crate::program::records(&directory.join("records.parquet"));
    assert!(rows(&whole)[105..] == rows(&second)[..]);
    let merged = parent.path().join("merged");
    ocmc(&["merge", "--quiet", "--out"]).arg(&merged).args([&second, &first]).assert().success();
    assert!(bytes(&merged) == bytes(&whole));
    let summary = |directory: &Path| -> serde_json::Value {
        let text = fs::read_to_string(directory.join("summary.json")).expect("written");
        serde_json::from_str(&text).expect("JSON")
    };
    assert_eq!(summary(&merged)["statistics"], summary(&whole)["statistics"]);

    let plain = parent.path().join("plain");
    run_into(&plain, &["--cycles", "200"]);
    assert!(rows(&plain) != rows(&whole), "it does something");
    // one cycle alone is that of the run
    let trace = ocmc(&["trace", "--cycle-id", "150", "--set", SHORT, "--set", SOBOL]).output();
    let trace = String::from_utf8(trace.expect("it starts").stdout).expect("UTF-8");
    let last = trace.lines().last().expect("rows");
    let duration_s: f64 = last.split(',').next().and_then(|time| time.parse().ok()).expect("time");
    assert!((duration_s - rows(&whole)[150].duration_s).abs() < 1e-6, "{last}");
}

/// Statistic of the consumption in a run of these cycles.
fn statistic(study: &Study, first_cycle: u64, cycles: u64) -> Statistic {
    let mut fleet = SummaryBuilder::new(Dependence::of(study.model(), 1));
    let plan = RunPlan::new(1, first_cycle, cycles, Some(2), None);
    let end: ControlFlow<()> = run(study, &plan, |records| {
        fleet.add(&records);
        ControlFlow::Continue(())
    });
    assert!(end.is_continue());
    fleet.finish().statistic(LITRES).expect("a diesel truck").clone()
}

fn half_width(statistic: &Statistic) -> f64 {
    let [low, high] = statistic.ci95.expect("an interval");
    (high - low) / 2.0
}

#[test]
fn the_means_of_repeated_runs_are_spread_as_their_intervals_say() {
    const RUNS: u64 = 200;
    const CYCLES: u64 = 320;
    let study = crate::common::study("field-truck", &["mission.length_m=1000", SOBOL]);
    let runs: Vec<Statistic> = (0..RUNS).map(|k| statistic(&study, k * CYCLES, CYCLES)).collect();
    let means: Vec<f64> = runs.iter().map(|run| run.mean.expect("a mean")).collect();
    let spread = crate::common::sd(&means);
    // 20 batches: Student's 2.093 standard errors
    let squares = runs.iter().map(|run| (half_width(run) / 2.093).powi(2)).sum::<f64>();
    let estimated = (squares / RUNS as f64).sqrt();
    // an SD of 200 means is known to 1/√400; that of the estimated one's square from 19 degrees of
    // freedom a run adds little
    assert!(
        (spread / estimated - 1.0).abs() < 4.0 / (2.0 * RUNS as f64).sqrt(),
        "{spread} {estimated}"
    );

    let plain = crate::common::study("field-truck", &["mission.length_m=1000"]);
    let cycles = RUNS * CYCLES;
    let (even, own) = (statistic(&study, 0, cycles), statistic(&plain, 0, cycles));
    let gain = (half_width(&own) / half_width(&even)).powi(2);
    eprintln!("variance of the mean, independent over sobol: {gain:.2}");
    assert!(gain > 1.2, "{gain}");
    // both are about the same fleet
    let difference = even.mean.expect("a mean") - own.mean.expect("a mean");
    let error = half_width(&even).hypot(half_width(&own)) / 1.96;
    assert!(difference.abs() < 4.0 * error, "{difference} {error}");
    for (a, b) in even.quantiles.iter().zip(&own.quantiles) {
        let half = |q: Option<[f64; 2]>| q.map_or(f64::NAN, |[low, high]| (high - low) / 2.0);
        let error = half(a.ci95).hypot(half(b.ci95)) / 1.96;
        let difference = a.value.expect("a value") - b.value.expect("a value");
        assert!(difference.abs() < 4.0 * error, "{}: {difference} {error}", a.name);
    }
}

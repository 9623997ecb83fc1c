//! The stages of a run, one by one and together. See `benches/README.md` for what is timed.
#![allow(missing_docs, reason = "criterion's macros make undocumented items")]

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use ocmc_core::kernel::drive::cpu::CpuLevel;
use ocmc_core::kernel::drive::scheduler::{drive, drive_tasks};
use ocmc_core::kernel::drive::trace::trace;
use ocmc_core::kernel::step::road_row::RoadRows;
use ocmc_core::kernel::trip::lane_task::LaneTask;
use ocmc_core::record::Record;
use ocmc_core::study::Study;
use ocmc_core::tactical::{SpeedProfile, plan};
use ocmc_fleet::summary::SummaryBuilder;
use std::collections::VecDeque;
use std::hint::black_box;
use std::time::Duration;

/// Cycles that are planned before the kernel is measured.
const CYCLES: u64 = 64;
/// How often they are driven in one measurement, more or less: it is the lanes that are measured,
/// not how they run empty at the end, and roads that are in the cache, as in a run, where they have
/// just been written.
const ROUNDS: u64 = 16;
/// Settings with which the kernel is measured, and their name in the bench: the default's long
/// steps, and the short ones that its goal of 50 million lane-steps a second was set for.
const STEPS: [(&str, &[&str]); 2] = [("", &[]), (", steps to 0.2 s", &["simulation.step_s=0.2"])];
/// Cycles of a run.
const RUN_CYCLES: u64 = 1024;

fn default_study(settings: &[&str]) -> Study {
    ocmc_io::study::load("field-truck", settings).expect("the default study loads").study
}

fn stages(criterion: &mut Criterion) {
    let study = default_study(&[]);
    let mut group = criterion.benchmark_group("stage");
    group.measurement_time(Duration::from_secs(5)).sample_size(20);

    group.throughput(Throughput::Elements(1));
    let mut id = 0;
    let mut scenario = study.sample(1, 0);
    group.bench_function("sample one cycle", |b| {
        b.iter(|| {
            id += 1;
            study.resample(1, id, &mut scenario);
            black_box(&scenario);
        });
    });
    let (mut profile, mut rows) = (SpeedProfile::default(), RoadRows::default());
    group.bench_function("plan one cycle", |b| {
        b.iter(|| {
            plan(&study, &scenario, &mut profile);
            rows.fill(&study, &scenario, &profile);
            black_box(&rows);
        });
    });

    for (name, settings) in STEPS {
        let study = default_study(settings);
        // a trace has one row a step, and one a stop
        let steps: Vec<usize> =
            (0..CYCLES).map(|id| trace(&study, 1, id).columns[0].values.len()).collect();
        let tasks = || (0..CYCLES).map(|id| LaneTask::new(&study, study.sample(1, id))).collect();
        for level in CpuLevel::ALL.into_iter().filter(|level| level.is_available()) {
            let records = drive_in_rounds(&study, tasks(), level);
            let driven: usize = records.iter().map(|record| steps[record.cycle_id as usize]).sum();
            group.throughput(Throughput::Elements(driven as u64));
            group.bench_function(format!("lane-steps {}{name}", level.name()), |b| {
                b.iter_batched(
                    tasks,
                    |tasks| black_box(drive_in_rounds(&study, tasks, level)),
                    BatchSize::PerIteration,
                );
            });
        }
    }
    group.finish();
}

/// Drives the tasks again and again, as lanes become free.
fn drive_in_rounds(study: &Study, tasks: VecDeque<LaneTask>, level: CpuLevel) -> Vec<Record> {
    let (mut tasks, mut left) = (tasks, ROUNDS * CYCLES);
    let mut next = |used| {
        tasks.extend(used);
        left = left.checked_sub(1)?;
        tasks.pop_front()
    };
    drive_tasks(study, &mut next, level)
}

fn whole(criterion: &mut Criterion) {
    let study = default_study(&[]);
    let mut group = criterion.benchmark_group("whole");
    group.measurement_time(Duration::from_secs(8)).sample_size(10);
    let records = drive(&study, 1, 0..RUN_CYCLES, CpuLevel::best());
    // nanoseconds per simulated second are the inverse of this throughput
    let simulated_s: f64 = records.iter().map(|r| r.simulated_s).sum();
    group.throughput(Throughput::Elements(simulated_s as u64));
    group.bench_function("simulated seconds, sampling and planning included", |b| {
        b.iter(|| black_box(drive(&study, 1, 0..RUN_CYCLES, CpuLevel::best())));
    });
    group.throughput(Throughput::Elements(RUN_CYCLES));
    group.bench_function("statistics of the records", |b| {
        b.iter(|| {
            let mut builder = SummaryBuilder::default();
            builder.add(&records);
            black_box(builder.finish())
        });
    });
    group.finish();
}

criterion_group!(benches, stages, whole);
criterion_main!(benches);

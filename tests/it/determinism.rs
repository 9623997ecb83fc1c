//! The same study, seed and range give the same bytes, on any number of threads, chunks and every
//! CPU.

use crate::program::run_into;
use ocmc_core::kernel::drive::cpu::CpuLevel;
use ocmc_core::kernel::drive::scheduler::drive_tasks;
use ocmc_core::kernel::drive::trace::{Trace, motions, trace};
use ocmc_core::kernel::trip::lane_task::LaneTask;
use ocmc_core::record::Outcome;
use std::fs;
use std::path::Path;

const CYCLES: &str = "300";

/// Bytes of records and manifest of a run with these options, too.
fn bytes(parent: &Path, name: &str, options: &[&str]) -> (Vec<u8>, Vec<u8>) {
    let directory = parent.join(name);
    run_into(&directory, &[&["--cycles", CYCLES], options].concat());
    let read = |file: &str| fs::read(directory.join(file)).expect("written");
    (read("records.parquet"), read("manifest.json"))
}

#[test]
fn records_and_manifest_do_not_depend_on_threads_chunks_or_cpu() {
    let parent = tempfile::tempdir().expect("a directory");
    let expected = bytes(parent.path(), "reference", &["--threads", "1"]);
    let rows = crate::program::records(&parent.path().join("reference/records.parquet"));
    assert_eq!(rows.len(), 300);
    assert!(rows.iter().all(|row| row.distance_m > 0.0), "every cycle has gone some way");
    for threads in ["2", "8"] {
        assert!(
            bytes(parent.path(), threads, &["--threads", threads]) == expected,
            "{threads} threads"
        );
    }
    for chunk in ["1", "7", "100", "300", "65536"] {
        let name = format!("chunk {chunk}");
        assert!(bytes(parent.path(), &name, &["--chunk", chunk]) == expected, "{name}");
    }
    let mut compared = Vec::new();
    for level in CpuLevel::ALL.into_iter().filter(|level| level.is_available()) {
        let name = level.name();
        assert!(bytes(parent.path(), name, &["--cpu-level", name]) == expected, "{name}");
        compared.push(name);
    }
    eprintln!("CPU levels compared: {}", compared.join(", "));
}

#[test]
fn a_part_of_a_run_is_the_run_of_that_part() {
    let parent = tempfile::tempdir().expect("a directory");
    let (whole, part) = (parent.path().join("whole"), parent.path().join("part"));
    run_into(&whole, &["--format", "csv", "--cycles", "1000"]);
    run_into(&part, &["--format", "csv", "--first-cycle", "100", "--cycles", "100"]);
    let text =
        |directory: &Path| fs::read_to_string(directory.join("records.csv")).expect("written");
    let (whole, part) = (text(&whole), text(&part));
    let rows = |text: &str| text.lines().skip(1).map(str::to_owned).collect::<Vec<_>>();
    let (whole, part) = (rows(&whole), rows(&part));
    assert_eq!((whole.len(), part.len()), (1000, 100));
    assert!(whole[100..200] == part[..]);
    assert!(part[0].starts_with("100,"), "{}", part[0]);
}

#[test]
fn another_seed_is_another_run() {
    let parent = tempfile::tempdir().expect("a directory");
    let one = bytes(parent.path(), "one", &["--seed", "1"]);
    let two = bytes(parent.path(), "two", &["--seed", "2"]);
    assert!(one.0 != two.0);
}

#[test]
fn a_road_that_was_driven_is_driven_again_alike() {
    // served lines are taken off the road while it is driven; stops lie close together in towns
    let study = ocmc_io::study::load("urban-delivery", &["mission.length_m=20000.0"])
        .expect("a built-in study")
        .study;
    let mut tasks: Vec<LaneTask> =
        (0..20).map(|id| LaneTask::new(&study, study.sample(1, id))).collect();
    let mut runs = Vec::new();
    for _ in 0..2 {
        let mut used = Vec::new();
        runs.push(drive_tasks(
            &study,
            &mut |back| {
                used.extend(back);
                tasks.pop()
            },
            CpuLevel::best(),
        ));
        tasks = used;
    }
    assert!(runs[0].iter().all(|record| record.n_stops > 5));
    assert_eq!(runs[0], runs[1]);
}

/// Motions are driven side by side, and more of them than there are lanes; a trace is driven alone.
#[test]
fn motions_are_those_of_traces() {
    // short trips of different lengths, and trucks that a battery leaves on the road
    let empty =
        ["vehicle.powertrain.battery_electric.battery.capacity_j=1.2e8", "mission.length_m=20000"];
    let short = ["mission.length_m=5000"];
    for (name, rate, sets) in [
        ("field-truck", "fuel_rate_kgps", &short[..]),
        ("battery-truck", "battery_power_w", &empty),
    ] {
        let study = crate::common::study(name, sets);
        let ids = [3, 4, 7, 20, 21, 22, 30, 31, 40, 41, 42];
        let together = motions(&study, ids.map(|id| study.sample(1, id)));
        assert_eq!(together.len(), ids.len());
        let stands = |motion: &Trace| motion.record.outcome == Outcome::Depleted;
        assert_eq!(together.iter().any(stands), name == "battery-truck");
        for (id, motion) in ids.into_iter().zip(together) {
            let alone = trace(&study, 1, id);
            let named = motion.columns.iter().map(|column| {
                let of_trace = alone.columns.iter().find(|other| other.name == column.name);
                (column, of_trace.expect("a column of the trace"))
            });
            assert!(named.clone().all(|(motion, trace)| motion == trace), "{name} {id}");
            let names: Vec<&str> = named.map(|(column, _)| column.name).collect();
            let motion_has = ["time_s", "step_s", "position_m", "speed_mps", rate];
            assert_eq!(names, [&motion_has[..], &["yaw_rate_radps", "limit_mps"]].concat());
            assert_eq!(motion.record, alone.record);
        }
    }
}

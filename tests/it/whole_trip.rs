//! The whole trips of cycles that a battery cut short are driven together, and none waits for long.

use ocmc_core::kernel::drive::cpu::CpuLevel;
use ocmc_core::kernel::drive::scheduler::Driving;
use ocmc_core::kernel::trip::lane_task::LaneTask;
use ocmc_core::record::{Outcome, Record};
use ocmc_fleet::run::replay;
use std::cell::Cell;
use std::sync::atomic::AtomicBool;

/// Records of trips of 2 km in the order of their delivery, and how many had arrived then; those
/// that `is_short` names depart with a battery that is as good as empty.
fn delivered(trips: u64, is_short: impl Fn(u64) -> bool) -> Vec<(Record, u64)> {
    let study = crate::common::study("battery-truck", &["mission.length_m=2000"]);
    let (mut ids, arrived, mut delivered) = (0..trips, Cell::new(0), Vec::new());
    let mut next = |_| {
        let mut scenario = study.sample(1, ids.next()?);
        if is_short(scenario.cycle_id) {
            scenario.vehicle.initial_charge = Some(0.1001);
        }
        Some(LaneTask::new(&study, scenario))
    };
    let (level, stop) = (CpuLevel::best(), &AtomicBool::new(false));
    Driving { study: &study, level, stop, whole_trips: true }.each_arriving(
        &mut next,
        &mut |_| arrived.set(arrived.get() + 1),
        &mut |record| delivered.push((record, arrived.get())),
    );
    delivered
}

#[test]
fn each_trip_is_delivered_once_and_whole() {
    let delivered = delivered(150, |id| id % 3 > 0);
    let mut ids: Vec<u64> = delivered.iter().map(|(record, _)| record.cycle_id).collect();
    ids.sort_unstable();
    assert!(ids.into_iter().eq(0..150));
    for (record, _) in &delivered {
        let is_short = record.cycle_id % 3 > 0;
        let outcome = if is_short { Outcome::Depleted } else { Outcome::Completed };
        assert_eq!(record.outcome, outcome);
        let whole_m = record.whole_trip_m.expect("it was driven");
        assert!((whole_m > record.distance_m) == is_short && whole_m > 1900.0, "{record:?}");
    }
    // 64 of 100 are driven together, and the others at the end
    let short = delivered.iter().filter(|(record, _)| record.outcome == Outcome::Depleted);
    let arrived: Vec<u64> = short.map(|(_, arrived)| *arrived).collect();
    assert_eq!(arrived.iter().filter(|n| **n < 150).count(), 64);
    assert!(arrived[..64].iter().all(|n| *n == arrived[0]), "{arrived:?}");
}

#[test]
fn a_trip_that_is_asked_for_twice_is_told_twice() {
    let sets =
        ["mission.length_m=20000", "vehicle.powertrain.battery_electric.battery.capacity_j=1.2e8"];
    let study = crate::common::study("battery-truck", &sets);
    let once = replay(&study, 1, &[3, 4, 7, 20, 21]);
    let short = once.iter().find(|record| record.outcome == Outcome::Depleted).expect("one is");
    assert!(short.whole_trip_m.is_some());
    assert_eq!(replay(&study, 1, &[short.cycle_id; 2]), [short.clone(), short.clone()]);
}

#[test]
fn one_trip_does_not_wait_for_others_that_are_cut_short() {
    let delivered = delivered(1500, |id| id == 0);
    let place = delivered.iter().position(|(record, _)| record.cycle_id == 0).unwrap();
    assert_eq!(delivered[place].0.outcome, Outcome::Depleted);
    assert!(delivered[place].0.whole_trip_m.is_some());
    // those before it, of which 1024 arrived while it waited
    assert!((1024..1024 + 32).contains(&place), "{place}");
}

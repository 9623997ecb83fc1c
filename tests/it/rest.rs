//! Rests on driven trips: the limit is never passed, a rest is taken at the last stop before it,
//! and without the table nothing is different.

use crate::common::{GivenRoad, balance, column, run, typical};
use ocmc_core::kernel::drive::cpu::CpuLevel;
use ocmc_core::kernel::drive::scheduler::{drive, drive_scenario};
use ocmc_core::kernel::drive::trace::{trace, trace_scenario};
use ocmc_core::operating_cycle::road::point_event::{EventKind, PointEvent};
use ocmc_core::record::{Outcome, Record};
use ocmc_core::study::{Scenario, Study};
use ocmc_io::study::load_text;

const EU: &str = "rest.law=\"eu_561\"";
const US: &str = "rest.law=\"us_395_3\"";

fn with(base: &str, sets: &[&str]) -> Study {
    let text = format!("[study]\nname = \"r\"\ndescription = \"d\"\nbase = \"{base}\"\n");
    load_text("r.toml", &text, sets).unwrap().study
}

/// A level road at 80 km/h with stops of the mission.
fn scenario(study: &Study, length_m: f64, stops: &[(f64, f64)]) -> Scenario {
    let mut scenario = GivenRoad::flat(length_m, 80.0 / 3.6).scenario(study);
    scenario.cycle.road.events.extend(stops.iter().map(|&(position_m, standstill_s)| {
        let kind = EventKind::MissionStop { standstill_s };
        PointEvent { position_m, kind, turns: false }
    }));
    scenario
}

/// Stands of at least a quarter of an hour: where, after which time since the last, how long.
fn stands(study: &Study, scenario: Scenario) -> (Vec<[f64; 3]>, Record) {
    let trace = trace_scenario(study, scenario);
    let names = ["step_s", "position_m", "distance_added_m"];
    let [step, position, moved] = names.map(|name| column(&trace, name));
    let (mut stands, mut driven_s) = (Vec::new(), 0.0);
    for k in 0..step.len() {
        if moved[k] == 0.0 && step[k] >= 900.0 {
            stands.push([position[k], driven_s, step[k]]);
            driven_s = 0.0;
        } else {
            driven_s += step[k];
        }
    }
    stands.push([*position.last().unwrap(), driven_s, 0.0]);
    (stands, trace.record)
}

#[test]
fn on_a_road_without_stops_the_driver_rests_on_the_spot_just_before_the_limit() {
    let study = typical(&[EU]);
    let (stands, record) = stands(&study, scenario(&study, 900e3, &[]));
    // 11.3 h: two breaks, and the daily rest after ten hours
    let lengths: Vec<f64> = stands.iter().map(|stand| stand[2]).collect();
    assert_eq!(lengths.len(), 4, "{stands:?}");
    for (length_s, said_s) in lengths.iter().zip([2700.0, 2700.0, 39_600.0, 0.0]) {
        assert!((length_s - said_s).abs() < 1e-6, "{stands:?}");
    }
    let day_s = 36_000.0 - stands[0][1] - stands[1][1];
    for (stand, limit_s) in stands.iter().zip([16_200.0, 16_200.0, day_s]) {
        assert!(stand[1] <= limit_s && stand[1] > limit_s - 180.0, "{stands:?}");
    }
    assert_eq!((record.outcome, record.n_rests), (Outcome::Completed, Some(3)));
    assert!((record.rest_s.unwrap() - 45_000.0).abs() < 1e-6);
    assert!((record.standstill_s - 45_000.0).abs() < 1e-6);
    assert!(balance(&record).abs() < 1e-9);
}

#[test]
fn a_rest_is_taken_at_the_last_stop_before_the_limit_and_its_own_dwell_counts() {
    let study = typical(&[EU]);
    let stops = [(100e3, 600.0), (250e3, 600.0), (300e3, 1200.0), (400e3, 600.0)];
    let (stands_at, record) = stands(&study, scenario(&study, 500e3, &stops));
    assert!((stands_at[0][0] - 300e3).abs() < 2.0 && stands_at[0][2] == 2700.0, "{stands_at:?}");
    assert_eq!((record.n_rests, record.rest_s), (Some(1), Some(1500.0)));
    // after 15 min on the way, 30 are enough; a stop of 45 min needs nothing from the law
    let (split, record) =
        stands(&study, scenario(&study, 500e3, &[(100e3, 900.0), (300e3, 600.0)]));
    assert_eq!((split[1][2], record.rest_s), (1800.0, Some(1200.0)), "{split:?}");
    let (_, record) = stands(&study, scenario(&study, 500e3, &[(250e3, 2700.0)]));
    assert_eq!((record.n_rests, record.rest_s), (Some(0), Some(0.0)));
}

#[test]
fn other_laws_other_crews_and_what_was_driven_before() {
    let rests = |sets: &[&str], length_m: f64| {
        let study = typical(sets);
        stands(&study, scenario(&study, length_m, &[])).0
    };
    let us = rests(&[US], 1000e3);
    assert!(us.len() == 3 && us[0][2] == 1800.0 && us[1][2] == 36_000.0, "{us:?}");
    assert!(us[0][1] <= 28_800.0 && us[0][1] + us[1][1] <= 39_600.0, "{us:?}");
    assert_eq!(rests(&[EU, "rest.drivers=2"], 1000e3).len(), 1);
    let before = rests(&[EU, "rest.driven_before_s=7200"], 300e3);
    assert!(before[0][1] <= 9000.0 && before[0][1] > 8800.0, "{before:?}");
    // who has no time left has rested before
    assert_eq!(rests(&[EU, "rest.driven_before_s=16200"], 300e3).len(), 1);
}

#[test]
fn on_sampled_trips_nobody_drives_longer_than_the_law_allows() {
    let long = ["mission.length_m=700000", "mission.stops.spacing_m=120000"];
    for (base, n) in [("long-haul", 12), ("battery-truck", 6), ("urban-delivery", 4)] {
        let more = [
            "mission.stops.dwell_s={distribution=\"uniform\", lower=900, upper=2000}",
            "vehicle.powertrain.battery_electric.battery.capacity_j=7.2e9",
            EU,
        ];
        let more: Vec<&str> = more
            .into_iter()
            .filter(|set| base == "battery-truck" || !set.contains("elec"))
            .collect();
        let study = with(base, &[&long[..], &more].concat());
        let plain = drive(&study, 5, 0..n, CpuLevel::best());
        for id in 0..n {
            let trace = trace(&study, 5, id);
            assert_eq!(trace.record, plain[id as usize], "{base} {id}");
            let (step, moved) = (column(&trace, "step_s"), column(&trace, "distance_added_m"));
            let (mut driven_s, mut part, mut most_s) = (0.0, false, 0.0f64);
            for (step_s, moved_m) in step.iter().zip(moved) {
                // a short standstill, at a light, is a part of the driving
                if *moved_m != 0.0 || *step_s < 900.0 - 1e-6 {
                    driven_s += step_s;
                    most_s = most_s.max(driven_s);
                } else if *step_s >= if part { 1800.0 } else { 2700.0 } - 1e-6 {
                    (driven_s, part) = (0.0, false);
                } else {
                    part = true;
                }
            }
            assert!(most_s <= 16_200.0, "{base} {id}: {most_s}");
            let record = &plain[id as usize];
            if record.outcome == Outcome::Completed {
                assert!(record.n_rests.unwrap() >= 1, "{base} {id}: {record:?}");
            }
        }
    }
}

#[test]
fn a_law_that_is_never_reached_changes_nothing_but_its_columns() {
    let (plain, law) = (run(&with("field-truck", &[]), 40), run(&with("field-truck", &[EU]), 40));
    for (plain, law) in plain.into_iter().zip(law) {
        assert_eq!((plain.rest_s, plain.n_rests), (None, None));
        if law.n_rests == Some(0) {
            assert_eq!(Record { rest_s: None, n_rests: None, ..law }, plain);
        }
    }
}

#[test]
fn the_same_records_whoever_drives_beside() {
    let study = with("long-haul", &["mission.length_m=600000", EU]);
    let together = drive(&study, 3, 0..20, CpuLevel::best());
    for record in together.iter().step_by(7) {
        let alone = drive_scenario(&study, study.sample(3, record.cycle_id));
        assert_eq!(&alone, record);
    }
    assert!(together.iter().all(|record| record.n_rests.unwrap() >= 1));
}

#[test]
fn wrong_rests_are_refused_by_name() {
    let refused = |sets: &[&str]| {
        let text = "[study]\nname = \"r\"\ndescription = \"d\"\nbase = \"field-truck\"\n";
        load_text("r.toml", text, sets).unwrap_err().to_string()
    };
    let error = refused(&[EU, "rest.driven_before_s=20000"]);
    assert!(error.contains("rest.driven_before_s") && error.contains("16200"), "{error}");
    assert!(refused(&[EU, "rest.drivers=3"]).contains("rest.drivers"));
    assert!(refused(&["rest.law=\"eu\""]).contains("eu_561"));
    assert!(refused(&[EU, "rest.break_s=3"]).contains("break_s"));
}

//! Trips of a truck that chain: it departs with what its depot has charged, its driver's clock goes
//! on, and who comes back late departs late.

use crate::common::column;
use crate::program::{ocmc, records};
use ocmc_core::charging::ChargingPlace;
use ocmc_core::energy::Carrier;
use ocmc_core::kernel::drive::trace::trace;
use ocmc_core::record::{Outcome, Record};
use ocmc_core::study::Study;
use ocmc_fleet::run::{RunPlan, records as drive, replay};
use ocmc_io::study::load_text;
use std::convert::Infallible;
use std::fs;
use std::ops::ControlFlow;

/// Two rounds of 120 km a day, with a depot that is too weak to fill the battery between them.
const TEXT: &str = r#"
[study]
name = "chain"
description = "d"
base = "battery-truck"

[mission]
length_m = 120e3
departure_s_of_day = 25200.0

[fleet]
trips_per_truck = 10
[fleet.calendar]
operating_days_per_week = 5
trips_per_day = 2
departure_interval_s = 14400.0
chain = true

[charging]
reserve = 0.12
efficiency = 0.94
connection_s = 120.0
depot = { power_w = 60e3, parked_s = 36e3 }
"#;
const ALONE: &str = "fleet.calendar.chain=false";
const DAY_S: f64 = 86_400.0;

fn study(sets: &[&str]) -> Study {
    load_text("c.toml", TEXT, sets).unwrap().study
}

fn driven(study: &Study, trucks: u64, threads: usize) -> Vec<Record> {
    let trips = study.nesting().trips_per_truck;
    let plan = RunPlan::new(1, 0, trucks * trips, Some(threads), None);
    let ControlFlow::Continue(records) =
        drive(study, &plan, |_| ControlFlow::<Infallible>::Continue(()));
    records
}

/// The charge that a trip leaves for the next one.
fn left(record: &Record) -> f64 {
    let last = record.charging_events.as_ref().unwrap().last();
    let in_depot = last.filter(|event| event.place == ChargingPlace::Depot);
    in_depot.map_or(record.final_charge.unwrap(), |event| event.end_charge)
}

#[test]
fn a_truck_departs_with_what_its_depot_has_charged() {
    let study = study(&[]);
    let records = driven(&study, 4, 2);
    let full = 0.88;
    let mut short = 0;
    for truck in records.chunks(10) {
        assert_eq!(truck[0].departure_charge, Some(full));
        for pair in truck.windows(2) {
            assert_eq!(pair[1].departure_charge, Some(left(&pair[0])), "{pair:?}");
            short += u64::from(left(&pair[0]) < full - 1e-6);
        }
        for (trip, record) in truck.iter().enumerate() {
            // of every second trip four hours less the time of the round are left, at 60 kW
            let parked_s = match trip % 2 {
                0 => 14_400.0 - record.duration_s,
                _ => 20.0 * 3600.0 - record.duration_s,
            };
            let event = record.charging_events.as_ref().unwrap().last().unwrap();
            assert!(event.charging_s <= parked_s - 120.0 + 1e-6, "{trip} {record:?}");
            if event.end_charge < full - 1e-6 {
                assert!((event.charging_s - (parked_s - 120.0)).abs() < 1e-3, "{trip} {record:?}");
            }
        }
    }
    assert!(short >= 8, "{short} trips departed with less than a full battery");
    // by themselves all depart with a full one, on the same roads
    let alone = driven(&self::study(&[ALONE]), 4, 2);
    assert!(alone.iter().all(|record| record.departure_charge == Some(full)));
    assert!(records.iter().zip(&alone).all(|(a, b)| a.distance_m == b.distance_m || short > 0));
    assert_eq!(records[0].amount(Carrier::Electricity), alone[0].amount(Carrier::Electricity));
}

#[test]
fn who_comes_back_late_departs_late() {
    let hurried = study(&["fleet.calendar.departure_interval_s=3600"]);
    let records = driven(&hurried, 2, 1);
    for truck in records.chunks(10) {
        for day in truck.chunks(2) {
            let back_s = day[0].departure_s_of_year + day[0].duration_s;
            assert!(day[0].duration_s > 3600.0);
            assert!((day[1].departure_s_of_year - back_s).abs() < 1e-6, "{day:?}");
            assert!(day[0].charging_events.as_ref().unwrap().is_empty());
            assert_eq!(day[1].departure_charge, day[0].final_charge);
        }
        // the next day it is on time
        assert!(truck.chunks(2).enumerate().all(|(k, day)| {
            (day[0].departure_s_of_year - (k as f64 * DAY_S + 25_200.0)).abs() < 1e-6
        }));
    }
}

#[test]
fn who_has_not_arrived_in_time_is_not_charged_in_the_depot() {
    let short = study(&["mission.length_m=85e3", "simulation.longest_duration_s=3600"]);
    let records = driven(&short, 1, 1);
    let late: Vec<_> = records.iter().filter(|r| r.outcome == Outcome::TimedOut).collect();
    assert!(!late.is_empty());
    for record in late {
        let charged = (record.charged_energy_depot_j, record.depot_charging_s);
        assert_eq!(charged, (Some(0.0), Some(0.0)), "{record:?}");
    }
}

#[test]
fn the_clock_of_the_driver_goes_on() {
    let rests = |sets: &[&str]| {
        let law = [
            "rest.law=\"eu_561\"",
            "fleet.calendar.departure_interval_s=9000",
            "mission.length_m=200e3",
            "vehicle.powertrain.battery_electric.battery.capacity_j=4e9",
        ];
        let study = study(&[&law[..], sets].concat());
        driven(&study, 3, 2)
    };
    // two rounds of some three hours with less than 45 minutes between them
    let (chained, alone) = (rests(&[]), rests(&[ALONE]));
    let count = |records: &[Record]| records.iter().map(|r| r.n_rests.unwrap()).sum::<u32>();
    let driven_s = |day: &[Record]| day.iter().map(|r| r.moving_s).sum::<f64>();
    assert_eq!(count(&alone), 0);
    let long = chained.chunks(2).filter(|day| {
        let between_s = day[1].departure_s_of_year - day[0].departure_s_of_year - day[0].duration_s;
        between_s < 2700.0 && driven_s(day) > 16_200.0
    });
    let long: Vec<&[Record]> = long.collect();
    assert!(!long.is_empty(), "no day with more than 4.5 h of driving");
    assert!(long.iter().all(|day| count(day) > 0));
    // after a night everybody is rested
    assert!(chained.chunks(2).all(|day| day[0].n_rests == Some(0)));
}

#[test]
fn records_are_the_same_however_they_are_driven() {
    let study = study(&["rest.law=\"eu_561\""]);
    let one = driven(&study, 5, 1);
    assert!(one == driven(&study, 5, 2) && one == driven(&study, 5, 5));
    // more trucks change none that were there
    assert!(one[..] == driven(&study, 9, 2)[..one.len()]);
    assert!(replay(&study, 1, &[3, 17]) == [one[3].clone(), one[17].clone()]);
    // a part that begins within a truck
    let plan = RunPlan::new(1, 13, 20, Some(2), None);
    let ControlFlow::Continue(part) =
        drive(&study, &plan, |_| ControlFlow::<Infallible>::Continue(()));
    assert!(part[..] == one[13..33]);
    let traced = trace(&study, 1, 17);
    assert!(traced.record == one[17]);
    let first = column(&traced, "state_of_charge")[0];
    assert!((first - one[17].departure_charge.unwrap()).abs() < 1e-4, "{first}");
}

#[test]
fn runs_are_merged_and_their_study_says_what_chains() {
    let parent = tempfile::tempdir().unwrap();
    let file = parent.path().join("chain.toml");
    fs::write(&file, TEXT).unwrap();
    let run = |name: &str, extra: &[&str]| {
        let out = parent.path().join(name);
        let mut command = ocmc(&["--quiet", "--study"]);
        command.arg(&file).arg("--out").arg(&out).args(extra).assert().success();
        out
    };
    let whole = run("whole", &["--trucks", "3"]);
    let parts =
        [run("a", &["--cycles", "10"]), run("b", &["--first-cycle", "10", "--cycles", "20"])];
    let merged = parent.path().join("merged");
    ocmc(&["merge", "--quiet", "--out"]).arg(&merged).args(parts).assert().success();
    for name in ["records.parquet", "loads.parquet", "chargings.parquet", "manifest.json"] {
        let read = |folder: &std::path::Path| fs::read(folder.join(name)).unwrap();
        assert!(read(&whole) == read(&merged), "{name}");
    }
    assert_eq!(records(&whole.join("records.parquet")).len(), 30);
    let manifest = fs::read_to_string(whole.join("manifest.json")).unwrap();
    assert!(manifest.contains("chain = true"), "{manifest}");
}

#[test]
fn battery_trucks_need_a_depot_to_chain() {
    let without = TEXT.replace("depot = { power_w = 60e3, parked_s = 36e3 }\n", "");
    let error = load_text("c.toml", &without, &[] as &[&str]).unwrap_err().to_string();
    assert!(error.contains("calendar.chain") && error.contains("charging.depot"), "{error}");
}

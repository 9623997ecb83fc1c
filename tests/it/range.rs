//! How far battery trucks come, as a user of the command meets it, and whether trips that arrive
//! tell the same as trips that are driven until empty.

use crate::program::ocmc;
use ocmc_core::record::{Outcome, Record};
use ocmc_fleet::dependence::Dependence;
use ocmc_fleet::range::{ArrivingRange, RangeTrip, drive, summarise};
use ocmc_fleet::run::RunPlan;
use ocmc_io::study::load;
use serde_json::Value;
use std::convert::Infallible;
use std::ops::ControlFlow;

/// 100 kWh: some 55 km.
const SMALL: &str = "vehicle.powertrain.battery_electric.battery.capacity_j=3.6e8";

fn text(arguments: &[&str]) -> String {
    let output = ocmc(arguments).assert().success().get_output().clone();
    String::from_utf8(output.stdout).expect("UTF-8")
}

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&text(&[arguments, &["--json"]].concat())).expect("JSON")
}

fn trips(seed: u64) -> (Dependence, Vec<Record>) {
    let study = load("battery-truck", &[SMALL, "mission.length_m=120000"]).expect("a study");
    let plan = RunPlan::new(seed, 0, 4000, None, None);
    let ControlFlow::Continue(records) =
        drive(&study.study, &plan, |_| ControlFlow::<Infallible>::Continue(()));
    (Dependence::of(&study.model, seed), records)
}

fn arriving(dependence: Dependence, records: &[Record]) -> Vec<ArrivingRange> {
    let trips: Vec<RangeTrip> = records.iter().filter_map(RangeTrip::of).collect();
    summarise(&trips, dependence).expect("trips").all.arriving
}

#[test]
fn trips_that_arrive_tell_the_range_that_driving_until_empty_shows() {
    let (dependence, mut records) = trips(3);
    // every trip is given a length of its own, 20 to 90 km, that has nothing to do with its road
    for (k, record) in (0_u32..).zip(&mut records) {
        let length_m = 20e3 + 70e3 * (f64::from(k) * 0.618_033_988_75).fract();
        if length_m < record.distance_m {
            record.distance_m = length_m;
            record.outcome = Outcome::Completed;
        }
    }
    let arrived = records.iter().filter(|r| r.outcome == Outcome::Completed).count();
    assert!((1500..2500).contains(&arrived), "{arrived} of 4000 arrive");
    let (_, others) = trips(4);
    let pairs = arriving(dependence, &records).into_iter().zip(arriving(dependence, &others));
    for (censored, uncensored) in pairs {
        let (range_m, truth_m) = (censored.range_m.unwrap(), uncensored.range_m.unwrap());
        assert!((range_m / truth_m - 1.0).abs() < 0.02, "{censored:?} {uncensored:?}");
    }
}

#[test]
fn the_records_of_a_run_tell_their_range() {
    let parent = tempfile::tempdir().expect("a directory");
    let directory = parent.path().join("run").to_str().expect("UTF-8").to_owned();
    let set = ["--set", SMALL, "--set", "mission.length_m=50000", "--cycles", "200", "--quiet"];
    let run = json(&[&["--study", "battery-truck", "--out", &directory], &set[..]].concat());
    let answer = json(&["range", &directory]);
    assert_eq!(
        (&answer["trips"], &answer["depleted"]),
        (&200.into(), &run["outcomes"]["depleted"])
    );
    let text = text(&["range", &directory]);
    assert!(text.starts_with("run ") && text.lines().all(|l| l.chars().count() <= 80), "{text}");
    ocmc(&["range", &directory, "--cycles", "10"]).assert().failure();
}

#[test]
fn trips_that_are_too_short_are_told_with_what_shows_the_range() {
    let parent = tempfile::tempdir().expect("a directory");
    let directory = parent.path().join("run").to_str().expect("UTF-8").to_owned();
    let set = ["--set", "mission.length_m=20000", "--cycles", "40", "--quiet"];
    json(&[&["--study", "battery-truck", "--out", &directory], &set[..]].concat());
    let of_run = json(&["range", &directory]);
    let lowest = of_run["lowest_charge"].as_f64().expect("trips arrive");
    let told = of_run["too_short"].as_str().expect("a sentence");
    let begins =
        format!("All trips that arrive end with at least {:.0} %", (lowest * 100.0).floor());
    assert!(lowest > 0.5 && told.starts_with(&begins), "{lowest} {told}");
    assert!(told.contains("`ocmc range --study NAME|FILE`"), "{told}");
    let text = text(&["range", &directory]);
    assert!(text.contains(&begins) && text.lines().all(|l| l.chars().count() <= 80), "{text}");
    // its own trips are as long as it takes, and no longer than a study allows
    let long = ["range", "--cycles", "20", "--quiet", "--set", SMALL];
    assert!(json(&long).get("too_short").is_none());
    let sets = ["--set", "simulation.longest_duration_s=1200", "--set", "mission.length_m=9000"];
    let short = [&long[..], &sets].concat();
    let told = json(&short)["too_short"].as_str().expect("a sentence").to_owned();
    assert!(told.contains("longer `simulation.longest_duration_s`"), "{told}");
}

#[test]
fn the_answer_fits_and_does_not_depend_on_threads() {
    let arguments = ["range", "--cycles", "50", "--seed", "9", "--quiet", "--set", SMALL];
    let one = json(&[&arguments[..], &["--threads", "1"]].concat());
    let two = json(&[&arguments[..], &["--threads", "2"]].concat());
    assert_eq!(one, two);
    assert_eq!((&one["trips"], &one["depleted"]), (&50.into(), &50.into()));
    let points = one["curve"].as_array().expect("points");
    assert_eq!(points[0]["share"], 1.0);
    assert!(points.len() > 10 && points.last().expect("points")["share"] == 0.0);
    let text = text(&arguments);
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    assert!(!text.contains("NaN") && text.contains("winter"), "{text}");
}

#[test]
fn charging_on_the_way_is_left_out_and_trucks_without_a_battery_are_refused() {
    let charging = "charging={ reserve = 0.0, efficiency = 0.94, stop = { power_w = 3e5, \
                    begin_below = 0.9, end_at = 0.9, shortest_s = 60.0 } }";
    let stops = "mission.stops={ spacing_m = 5000.0, dwell_s = 900.0 }";
    let arguments = ["range", "--cycles", "30", "--quiet", "--set", SMALL, "--set", stops];
    let answer = json(&[&arguments[..], &["--set", charging]].concat());
    // charged at each stop, they would go on for ever
    assert_eq!((&answer["trips"], &answer["depleted"]), (&30.into(), &30.into()));
    let diesel = ocmc(&["range", "--study", "field-truck"]).assert().failure();
    let diesel = String::from_utf8(diesel.get_output().stderr.clone()).expect("UTF-8");
    assert!(diesel.contains("field-truck has no battery"), "{diesel}");
    assert!(diesel.contains("battery-truck"), "{diesel}");
}

//! Load curves and the table of chargings: nothing is lost between the meters of the records and
//! the curves, and files are the same bytes however a run was driven.

use crate::common::run;
use crate::program::{ocmc, records, run_into};
use ocmc_core::charging::ChargingPlace;
use ocmc_core::record::Record;
use ocmc_fleet::dependence::Dependence;
use ocmc_fleet::load::LoadBuilder;
use ocmc_io::study::load_text;
use std::fs;
use std::path::Path;

const TEXT: &str = r#"
[study]
name = "loads"
description = "d"
base = "battery-truck"

[mission]
length_m = 350e3
stops = { spacing_m = 60e3, dwell_s = 1800.0 }

[vehicle.powertrain.battery_electric.battery]
capacity_j = 1.2e9

[fleet]
trips_per_truck = 5
[fleet.calendar]
operating_days_per_week = 5
trips_per_day = 1

[charging]
reserve = 0.15
forecast = { consumption_j_per_m = 4500.0, margin = 0.1 }
efficiency = 0.94
connection_s = 120.0
depot = { power_w = 150e3, parked_s = 36e3 }
public = { spacing_m = 40e3, power_w = 350e3, wait_s = 300.0, end_at = 0.8 }
stop = { power_w = 150e3, begin_below = 0.6, end_at = 0.85, shortest_s = 900.0 }
"#;

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * b.abs().max(1.0)
}

fn metered_j(record: &Record, place: ChargingPlace) -> f64 {
    match place {
        ChargingPlace::Depot => record.grid_energy_depot_j,
        ChargingPlace::Public => record.grid_energy_public_j,
        ChargingPlace::Stop => record.grid_energy_stop_j,
    }
    .unwrap()
}

#[test]
fn the_energy_below_the_curves_is_what_meters_counted() {
    let loaded = load_text("l.toml", TEXT, &[] as &[&str]).unwrap();
    let records = run(&loaded.study, 40);
    let dependence = Dependence::of(&loaded.model, 1);
    let mut builder = LoadBuilder::default();
    for record in &records {
        let events = record.charging_events.as_ref().unwrap();
        for place in ChargingPlace::ALL {
            let own = events.iter().filter(|event| event.place == place);
            let energy_j: f64 = own.map(|event| event.grid_energy_j).sum();
            assert!(close(energy_j, metered_j(record, place)), "{record:?}");
        }
        let on_the_way = events.iter().filter(|event| event.place != ChargingPlace::Depot);
        let (mut stops, mut charging_s) = (0, 0.0);
        for event in on_the_way {
            stops += 1;
            charging_s += event.charging_s;
            assert!(event.arrival_s < event.begin_s && event.begin_s < record.duration_s);
            assert!(event.begin_charge < 0.9 && event.position_m < record.distance_m);
        }
        assert_eq!(record.n_charging_stops, Some(stops));
        assert!(close(charging_s, record.charging_s.unwrap()));
        for event in events {
            let quarters_j: f64 = event.quarter_hours_j.iter().sum();
            assert!(close(quarters_j, event.grid_energy_j), "{event:?}");
            let most_j = 900.0 * event.peak_power_w * (1.0 + 1e-9);
            assert!(event.quarter_hours_j.iter().all(|j| *j >= 0.0 && *j <= most_j), "{event:?}");
            let charger_w = if event.place == ChargingPlace::Public { 350e3 } else { 150e3 };
            assert!(event.peak_power_w <= charger_w * (1.0 + 1e-9), "{event:?}");
        }
        builder.add(record, &dependence);
    }
    let curves = builder.finish(&dependence).unwrap();
    // five trips from a Monday on: one week
    assert!(curves.rows.iter().all(|row| row.days == 7));
    for place in ChargingPlace::ALL {
        let rows = curves.rows.iter().filter(|row| row.place == place);
        let below_j: f64 = rows.map(|row| row.mean_power_w * 900.0 * 7.0).sum();
        let said_j: f64 = records.iter().map(|record| metered_j(record, place)).sum();
        assert!(said_j > 0.0 && close(below_j, said_j), "{place:?} {below_j} {said_j}");
        let of = curves.places.iter().find(|of| of.place == place).unwrap();
        assert!(close(of.energy_per_day_j * 7.0, said_j));
        assert!(of.highest_power_w >= of.p95_power_w);
    }
}

/// A run of the study in a directory.
fn driven(study: &Path, out: &Path, extra: &[&str]) {
    let study = study.to_str().unwrap();
    let out = out.to_str().unwrap();
    ocmc(&["--study", study, "--quiet", "--out", out]).args(extra).assert().success();
}

/// The sum of a column of a file of comma-separated values.
fn sum(path: &Path, column: &str) -> f64 {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let place = reader.headers().unwrap().iter().position(|name| name == column).unwrap();
    reader.records().map(|row| row.unwrap()[place].parse::<f64>().unwrap()).sum()
}

#[test]
fn the_tables_are_the_same_bytes_however_a_run_was_driven() {
    let parent = tempfile::tempdir().unwrap();
    let (folder, study) = (parent.path(), parent.path().join("loads.toml"));
    fs::write(&study, TEXT).unwrap();
    let at = |name: &str| folder.join(name);
    driven(&study, &at("one"), &["--trucks", "6", "--threads", "1"]);
    driven(&study, &at("two"), &["--trucks", "6", "--threads", "2"]);
    driven(&study, &at("a"), &["--first-cycle", "0", "--cycles", "10"]);
    driven(&study, &at("b"), &["--first-cycle", "10", "--cycles", "20"]);
    let merged = at("merged");
    let mut merge = ocmc(&["merge", "--quiet", "--out"]);
    merge.arg(&merged).args([at("b"), at("a")]).assert().success();
    for file in ["records.parquet", "chargings.parquet", "loads.parquet"] {
        let read = |name: &str| fs::read(at(name).join(file)).unwrap();
        assert!(read("one") == read("two") && read("one") == read("merged"), "{file}");
    }
    ocmc(&["verify"]).arg(at("one")).assert().success();
    let sums = fs::read_to_string(at("one").join("checksums.sha256")).unwrap();
    assert!(sums.contains("  loads.parquet") && sums.contains("  chargings.parquet"), "{sums}");
}

#[test]
fn csv_keeps_what_was_charged() {
    let parent = tempfile::tempdir().unwrap();
    let (folder, study) = (parent.path(), parent.path().join("loads.toml"));
    fs::write(&study, TEXT).unwrap();
    driven(&study, &folder.join("p"), &["--trucks", "1"]);
    driven(&study, &folder.join("c"), &["--trucks", "1", "--format", "csv"]);
    let [parquet, csv] = ["p/records.parquet", "c/records.csv"].map(|at| records(&folder.join(at)));
    assert!(parquet == csv && parquet[0].charging_events.is_some());
    let text = fs::read_to_string(folder.join("c/loads.csv")).unwrap();
    assert!(text.starts_with("place,quarter_hour,mean_power_w,p50_power_w,p95_power_w,"), "{text}");
    assert_eq!(text.lines().count(), 1 + 3 * 96);
    let text = fs::read_to_string(folder.join("c/chargings.csv")).unwrap();
    let events: usize = csv.iter().flat_map(|r| &r.charging_events).map(Vec::len).sum();
    assert_eq!(text.lines().count(), 1 + events);
    let said_j: f64 =
        ChargingPlace::ALL.iter().flat_map(|p| csv.iter().map(|r| metered_j(r, *p))).sum();
    assert!(close(sum(&folder.join("c/chargings.csv"), "grid_energy_j"), said_j));
    let mean_w = sum(&folder.join("c/loads.csv"), "mean_power_w");
    assert!(close(mean_w * 900.0 * 7.0, said_j), "{mean_w} {said_j}");
}

#[test]
fn the_answer_says_what_chargers_draw_together() {
    let parent = tempfile::tempdir().unwrap();
    let study = parent.path().join("loads.toml");
    fs::write(&study, TEXT).unwrap();
    let said = ocmc(&["--trucks", "2", "--study"]).arg(&study).output().unwrap();
    let text = String::from_utf8(said.stdout).unwrap();
    assert!(text.contains("The fleet's chargers draw together"), "{text}");
    assert!(text.contains("\n  depots             below "), "{text}");
    let own = text.split("Charging stops").nth(1).unwrap().split("trucks:").next().unwrap();
    assert!(own.lines().all(|line| line.chars().count() <= 80), "{own}");
    assert!(text.contains("\nTrucks of which all trips arrive: "), "{text}");
    // a diesel truck has none of it
    let said = ocmc(&["--cycles", "3", "--set", "mission.length_m=2000"]).output().unwrap();
    assert!(!String::from_utf8(said.stdout).unwrap().contains("draw together"));
}

#[test]
fn the_report_shows_range_charge_and_load() {
    let parent = tempfile::tempdir().unwrap();
    let (study, out) = (parent.path().join("loads.toml"), parent.path().join("run"));
    // without a calendar: trips of all seasons; some do not arrive
    let text = TEXT.split("[fleet]").next().unwrap().to_owned()
        + "[charging]"
        + TEXT.split("[charging]").nth(1).unwrap();
    fs::write(&study, text.replace("spacing_m = 40e3", "spacing_m = 170e3")).unwrap();
    driven(&study, &out, &["--cycles", "160"]);
    ocmc(&["report"]).arg(&out).assert().success();
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    for part in [
        "<h2>Charging and range</h2>",
        "Share of the trucks that are not empty yet",
        "State of charge over the distance",
        "Power that depots draw from the grid",
        "Power that public chargers draw from the grid",
        "over the days of one year that holds all trips (365 days)",
        "<h2>From summer to winter</h2>",
        "all others",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(!page.contains("NaN") && !page.contains(">inf"));
    assert_eq!(page.matches("<svg").count(), page.matches("</svg>").count());
    // a diesel truck's has none of it
    let diesel = parent.path().join("diesel");
    run_into(&diesel, &["--cycles", "60"]);
    ocmc(&["report"]).arg(&diesel).assert().success();
    let page = fs::read_to_string(diesel.join("report.html")).unwrap();
    assert!(!page.contains("Charging and range") && !page.contains("From summer to winter"));
}

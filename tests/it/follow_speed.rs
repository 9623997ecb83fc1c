//! Output of `ocmc drive` on routes and on speeds that are followed: how to see more, what
//! saturated.

use crate::program::{ocmc, records};
use ocmc_core::energy::Carrier;
use ocmc_core::record::{COLUMNS, Cell, Outcome, Record};
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// A route of 3 km.
fn route(folder: &Path) -> String {
    let file = folder.join("my route.csv");
    let mut text = "position_m,speed_limit_kmh,grade\n".to_owned();
    for k in 0..=60 {
        writeln!(text, "{},60,0.01", 50 * k).unwrap();
    }
    fs::write(&file, text).unwrap();
    file.display().to_string()
}

/// A minute at a speed on a slope, after rest.
fn drive_cycle(folder: &Path, name: &str, speed_mps: f64, slope: f64) -> String {
    let file = folder.join(name);
    let mut text = "time_s,speed_mps,slope\n0,0,0\n".to_owned();
    for k in 1..=60 {
        writeln!(text, "{k},{},{slope}", speed_mps * f64::from(k.min(30)) / 30.0).unwrap();
    }
    fs::write(&file, text).unwrap();
    file.display().to_string()
}

/// The arguments of the command between the first pair of backticks, as a shell would part them.
fn hinted(message: &str) -> Vec<String> {
    let command = message.split('`').find(|part| part.starts_with("ocmc trace")).unwrap();
    let mut parts = Vec::new();
    for (k, part) in command.split('\'').enumerate() {
        if k % 2 == 1 {
            parts.push(part.to_owned());
        } else {
            parts.extend(part.split_whitespace().map(str::to_owned));
        }
    }
    parts.into_iter().skip(1).map(|part| part.replace("ID", "3")).collect()
}

#[test]
fn the_hint_behind_a_route_traces_a_cycle_on_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = route(folder.path());
    let out = folder.path().join("run");
    let run = ["drive", &file, "--cycles", "4", "--format", "csv", "--out", out.to_str().unwrap()];
    let message = ocmc(&run).assert().success();
    let message = String::from_utf8(message.get_output().stderr.clone()).unwrap();
    assert!(message.contains("records.csv"), "{message}");
    assert!(message.contains(&format!("`ocmc report {}`", out.display())), "{message}");
    let trace = folder.path().join("trace.csv");
    let mut arguments = hinted(&message);
    arguments.extend(["--out".to_owned(), trace.display().to_string()]);
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    ocmc(&arguments).assert().success();
    let last = fs::read_to_string(&trace).unwrap().lines().last().unwrap().to_owned();
    let record = fs::read_to_string(out.join("records.csv")).unwrap();
    let row: Vec<&str> = record.lines().nth(4).unwrap().split(',').collect();
    let position = |cell: &str| cell.parse::<f64>().unwrap();
    assert!((position(last.split(',').nth(2).unwrap()) - position(row[2])).abs() < 1e-6);
    assert!((2990.0..3001.0).contains(&position(row[2])), "{}", row[2]);
}

#[test]
fn a_speed_that_the_truck_cannot_hold_is_counted_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let answer = |file: &str, more: &[&str]| {
        let message = ocmc(&["drive", file, "--follow-speed", "exact", "--cycles", "5", "--quiet"])
            .args(more)
            .assert()
            .success();
        String::from_utf8(message.get_output().stdout.clone()).unwrap()
    };
    let steep = drive_cycle(folder.path(), "steep.csv", 20.0, 0.10);
    let text = answer(&steep, &[]);
    assert!(text.contains("Saturated in 5 of 5 cycles"), "{text}");
    let json: serde_json::Value = serde_json::from_str(&answer(&steep, &["--json"])).unwrap();
    let saturation = &json["saturation"];
    assert_eq!(saturation["cycles"], 5);
    assert!(saturation["limited_s"].as_f64().unwrap() > 5.0 * 30.0, "{saturation}");
    assert!(saturation["missing_energy_j"].as_f64().unwrap() > 0.0, "{saturation}");
    let easy = drive_cycle(folder.path(), "easy.csv", 5.0, 0.0);
    assert!(!answer(&easy, &[]).contains("Saturated"));
    let json: serde_json::Value = serde_json::from_str(&answer(&easy, &["--json"])).unwrap();
    assert_eq!(json["saturation"]["limited_s"], 0.0);
}

#[test]
fn where_nobody_drives_the_records_have_no_driver_and_no_road() {
    let folder = tempfile::tempdir().unwrap();
    let file = drive_cycle(folder.path(), "cycle.csv", 10.0, 0.0);
    let driven = |how: &str, format: &str| {
        let out = folder.path().join(format!("{how}-{format}"));
        let follow = ["--follow-speed", how, "--cycles", "3", "--format", format, "--quiet"];
        ocmc(&["drive", &file]).args(follow).arg("--out").arg(&out).assert().success();
        records(&out.join(format!("records.{format}")))
    };
    let road = ["urban_share", "rural_share", "motorway_share", "mean_limit_mps", "n_curves"];
    for format in ["parquet", "csv"] {
        for record in driven("exact", format) {
            let of_it = |name: &'static str| name.starts_with("driver_") || road.contains(&name);
            for column in COLUMNS.iter().filter(|column| of_it(column.name)) {
                let cell = column.get(&record);
                let none = matches!(cell, Cell::Number(None) | Cell::Integer(None));
                assert!(none, "{format} {}: {cell:?}", column.name);
            }
        }
        for record in driven("driver", format) {
            assert!(record.driver_kp > Some(0.0) && record.driver_effect.is_some());
            assert!(record.mean_limit_mps > Some(0.0) && record.n_curves == Some(0));
            assert!(record.driver_gain_redraws.is_some());
        }
    }
}

#[test]
fn a_driver_rests_at_both_ends_of_the_cycle() {
    let folder = tempfile::tempdir().unwrap();
    let driven = |name: &str, table: &str| -> Vec<Record> {
        let (file, out) = (folder.path().join(format!("{name}.csv")), folder.path().join(name));
        fs::write(&file, format!("time_s,speed_mps\n{table}")).unwrap();
        // the weather would go on during a rest
        let calm = "simulation.without=[\"weather\"]";
        let follow = ["--follow-speed", "driver", "--cycles", "20", "--quiet", "--set", calm];
        ocmc(&["drive"]).arg(&file).args(follow).arg("--out").arg(&out).assert().success();
        records(&out.join("records.parquet"))
    };
    let moves = driven("moves", "60,0\n90,15\n1090,15\n1110,0\n");
    let rests = driven("rests", "0,0\n60,0\n90,15\n1090,15\n1110,0\n1235,0\n1360,0\n");
    for (record, other) in rests.iter().zip(&moves) {
        assert_eq!((record.outcome, other.outcome), (Outcome::Completed, Outcome::Completed));
        assert_eq!((record.standstill_s, record.n_stops), (310.0, 2));
        assert_eq!((other.standstill_s, other.n_stops), (0.0, 0));
        assert!((record.distance_m - other.distance_m).abs() < 1.0, "{}", record.distance_m);
        assert!(
            record.amount(Carrier::LiquidFuel) > other.amount(Carrier::LiquidFuel),
            "an engine that idles"
        );
    }
    let work = |all: &[Record]| all.iter().map(|record| record.wheel_energy_j).sum::<f64>();
    let more = work(&rests) / work(&moves) - 1.0;
    assert!(more.abs() < 1e-3, "{more}");
}

#[test]
fn a_followed_speed_names_no_trace() {
    let folder = tempfile::tempdir().unwrap();
    let file = drive_cycle(folder.path(), "cycle.csv", 10.0, 0.0);
    let out = folder.path().join("run").display().to_string();
    let run = ["drive", &file, "--follow-speed", "exact", "--cycles", "5", "--out", &out];
    let message = ocmc(&run).assert().success();
    let message = String::from_utf8(message.get_output().stderr.clone()).unwrap();
    assert!(!message.contains("ocmc trace") && message.contains("records.parquet"), "{message}");
}

#[test]
fn a_drive_cycle_keeps_nothing() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("cycle.csv");
    fs::write(&file, "time_s,speed_mps\n0,0\n10,10\n60,10\n70,0\n").expect("a file");
    let file = file.to_str().expect("UTF-8");
    for how in ["exact", "driver"] {
        let output =
            ocmc(&["drive", file, "--follow-speed", how, "--keep", "weather", "--cycles", "1"])
                .output();
        let output = output.expect("the program starts");
        let message = String::from_utf8(output.stderr).expect("UTF-8");
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(
            message.contains("--keep: `") && message.contains("has no weather, traffic or mission"),
            "{message}"
        );
    }
}

#[test]
fn a_cycle_that_never_moves_has_no_consumption() {
    let directory = tempfile::tempdir().expect("a directory");
    let (file, out) = (directory.path().join("rest.csv"), directory.path().join("run"));
    fs::write(&file, "time_s,speed_mps\n0,0\n60,0\n120,0\n").expect("a file");
    let (file, to) = (file.to_str().expect("UTF-8"), out.to_str().expect("UTF-8"));
    ocmc(&["drive", file, "--follow-speed", "exact", "--cycles", "2", "--quiet", "--out", to])
        .assert()
        .success();
    for record in records(&out.join("records.parquet")) {
        assert_eq!((record.distance_m, record.standstill_s), (0.0, 120.0));
        assert_eq!((record.consumption(Carrier::LiquidFuel), record.co2_g_per_km), (None, None));
        assert!(record.amount(Carrier::LiquidFuel).expect("an engine that idles") > 0.0);
    }
}

#[test]
fn a_plan_with_a_rest_of_days_is_followed() {
    let directory = tempfile::tempdir().expect("a directory");
    let (file, out) = (directory.path().join("road.csv"), directory.path().join("run"));
    // two stops at one place, which add up to four days: longer than what a file of a drive cycle
    // may say
    let road = "track,rule,position_m,value\nspeed_limit_mps,constant,0,20\n\
                mission_stop_s,event,500,172800\nmission_stop_s,event,500.2,172800\n\
                grade,constant,0,0\ngrade,constant,1000,0\n";
    fs::write(&file, road).expect("a file");
    let (file, to) = (file.to_str().expect("UTF-8"), out.to_str().expect("UTF-8"));
    ocmc(&["drive", file, "--follow-speed", "exact", "--cycles", "2", "--quiet", "--out", to])
        .assert()
        .success();
    for record in records(&out.join("records.parquet")) {
        assert_eq!((record.outcome, record.standstill_s), (Outcome::Completed, 345_600.0));
    }
}

#[test]
fn what_is_beyond_a_map_for_a_moment_is_no_saturation() {
    let folder = tempfile::tempdir().unwrap();
    // half a minute from rest: the motor starts below the first point of its map
    let file = drive_cycle(folder.path(), "gentle.csv", 8.0, 0.0);
    for study in ["field-truck", "battery-truck"] {
        let run = ["drive", &file, "--follow-speed", "exact", "--cycles", "3", "--study", study];
        let message = ocmc(&run).args(["--json", "--quiet"]).assert().success();
        let json: serde_json::Value = serde_json::from_slice(&message.get_output().stdout).unwrap();
        assert!(json["saturation"]["limited_s"].as_f64().unwrap() == 0.0, "{json}");
        let message = ocmc(&run).arg("--quiet").assert().success();
        let text = String::from_utf8(message.get_output().stdout.clone()).unwrap();
        assert!(!text.contains("Saturated"), "{study}: {text}");
    }
}

#[test]
fn a_mission_without_its_departure_is_told() {
    let folder = tempfile::tempdir().unwrap();
    for (ending, message) in [("csv", true), ("json", false)] {
        let file = folder.path().join(format!("road.{ending}")).display().to_string();
        let short = ["cycle", "--cycle-id", "3", "--set", "mission.length_m=3000", "--out", &file];
        ocmc(&short).assert().success();
        let run = ["drive", &file, "--cycles", "2", "--quiet"];
        for (keep, message) in [(&["--keep", "mission"][..], message), (&[], false)] {
            let driven = ocmc(&run).args(keep).assert().success();
            let text = String::from_utf8(driven.get_output().stderr.clone()).unwrap();
            assert_eq!(text.contains("holds no departure"), message, "{ending}: {text}");
        }
    }
}

#[test]
fn a_run_on_routes_is_called_by_them() {
    let folder = tempfile::tempdir().unwrap();
    let file = route(folder.path());
    let out = folder.path().join("run");
    let name = |files: &[&str]| {
        let more = ["--cycles", "2", "--quiet", "--json"];
        let message = ocmc(&["drive"]).args(files).args(more).assert().success();
        let message: serde_json::Value =
            serde_json::from_slice(&message.get_output().stdout).unwrap();
        message["study"].as_str().unwrap().to_owned()
    };
    assert_eq!(name(&[&file]), format!("field-truck on {file}"));
    assert_eq!(name(&[&file, &file]), format!("field-truck on {file}, {file}"));
    assert_eq!(name(&[&file, &file, &file]), format!("field-truck on {file} and 2 more"));
    let arguments = ["drive", &file, "--cycles", "2", "--out", out.to_str().unwrap()];
    let message = ocmc(&arguments).assert().success();
    let message = String::from_utf8(message.get_output().stdout.clone()).unwrap();
    assert!(message.contains(&format!("study      field-truck on {file}\n")), "{message}");
    ocmc(&["report"]).arg(&out).assert().success();
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains(&format!("<td>routes</td><td class=\"words\">{file}</td>")), "{page}");
    assert!(page.contains(&format!("<h1>field-truck on {file}</h1>")), "{page}");
    assert!(!page.contains("length of a mission"), "{page}");
}

#[test]
fn a_speed_over_time_is_no_route_and_says_how_it_is_driven() {
    let folder = tempfile::tempdir().unwrap();
    let file = drive_cycle(folder.path(), "dc.csv", 10.0, 0.0);
    let vecto = folder.path().join("dc.vdri");
    fs::write(&vecto, "<t>,<v>,<grad>\n0,0,0\n30,36,0\n60,36,1\n").unwrap();
    let vecto = vecto.display().to_string();
    for file in [&file, &vecto] {
        let message = ocmc(&["drive", file, "--cycles", "2"]).assert().code(1);
        let message = String::from_utf8(message.get_output().stderr.clone()).unwrap();
        assert!(message.contains("is a speed over time"), "{message}");
        let help = "help: a speed over time is driven with --follow-speed exact or --follow-speed";
        assert!(message.contains(help), "{message}");
        for follow in ["exact", "driver"] {
            ocmc(&["drive", file, "--cycles", "2", "--follow-speed", follow]).assert().success();
        }
    }
}

#[test]
fn followed_speeds_stay_where_they_are_for_drivers_who_react_late() {
    let folder = tempfile::tempdir().expect("a directory");
    let file = folder.path().join("cycle.csv");
    let mut text = "time_s,speed_mps\n".to_owned();
    for k in 0..=200 {
        let speed = (0.5 * f64::from(k)).min(20.0).min(0.5 * f64::from(200 - k));
        std::fmt::Write::write_fmt(&mut text, format_args!("{k},{speed}\n")).expect("a string");
    }
    std::fs::write(&file, text).expect("space");
    let file = file.to_str().expect("UTF-8");
    let records = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let path = out.to_str().expect("UTF-8");
        let arguments = ["drive", file, "--follow-speed", "driver", "--cycles", "3", "--quiet"];
        crate::program::ocmc(&[&arguments[..], &["--out", path], more].concat()).assert().success();
        std::fs::read(out.join("records.parquet")).expect("written")
    };
    let late = ["--set", "driver.speed_limit.sign_offset_m=300.0"];
    assert!(records("plain", &[]) == records("late", &late));
}

//! `ocmc road` and `ocmc validate`: traces of the program itself are draws of the population that
//! is laid under them; roads from logs are those that were driven; what is circular is said;
//! hostile logs end in a message.

use crate::others_data::shared;
use crate::program::ocmc;
use ocmc_core::kernel::drive::trace::{Trace, motions, trace};
use ocmc_core::study::Study;
use ocmc_io::given_cycle::RouteOptions;
use ocmc_io::operating_cycle::RealisedCycle;
use ocmc_io::study::{self, LoadedStudy};
use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// Settings for a log of the program's own. Steps are so short that it is sampled as a logger does.
const SETS: [&str; 2] = ["mission.length_m=5000", "simulation.step_s=0.5"];
const SET_ARGUMENTS: [&str; 4] =
    ["--set", "mission.length_m=5000", "--set", "simulation.step_s=0.5"];
const COLUMNS: [&str; 7] =
    ["time_s", "position_m", "speed_mps", "fuel_rate_kgps", "yaw_rate_radps", "limit_mps", "grade"];

fn loaded() -> LoadedStudy {
    study::load("field-truck", &SETS).unwrap()
}

/// The rows of a trace, each behind a label.
fn append(text: &mut String, label: &str, trace: &Trace, columns: &[&str]) {
    let columns: Vec<&[f64]> = columns
        .iter()
        .map(|name| trace.columns.iter().find(|c| c.name == *name).unwrap().values.as_slice())
        .collect();
    for row in 0..columns[0].len() {
        text.push_str(label);
        for column in &columns {
            write!(text, ",{}", column[row]).unwrap();
        }
        text.push('\n');
    }
}

/// A file with the traces of many drives.
fn logs(path: &Path, study: &Study, seed: u64, drives: u64, columns: &[&str]) -> String {
    let mut text = format!("drive,{}\n", columns.join(","));
    let traces = if columns.contains(&"grade") {
        (0..drives).map(|id| trace(study, seed, id)).collect()
    } else {
        motions(study, (0..drives).map(|id| study.sample(seed, id)))
    };
    for (id, trace) in traces.iter().enumerate() {
        append(&mut text, &format!("d{id}"), trace, columns);
    }
    fs::write(path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

/// One road of the study as a file, and the study on it.
fn road(folder: &Path, cycle_id: u64) -> (PathBuf, LoadedStudy) {
    let loaded = loaded();
    let path = folder.join(format!("road-{cycle_id}.json"));
    let cycle = RealisedCycle::new(&loaded, 77, cycle_id);
    fs::write(&path, serde_json::to_string(&cycle).unwrap()).unwrap();
    let on_road =
        loaded.on_routes(std::slice::from_ref(&path), &[], RouteOptions::default()).unwrap();
    (path, on_road)
}

/// Answer of the command as JSON, and its messages.
fn answer(arguments: &[&str]) -> (Value, String) {
    let output = ocmc(arguments).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{message}");
    (serde_json::from_slice(&output.stdout).unwrap(), message)
}

fn pooled<'a>(answer: &'a Value, quantity: &str) -> &'a Value {
    let all = answer["pooled"].as_array().unwrap();
    all.iter().find(|pooled| pooled["quantity"] == quantity).unwrap()
}

/// The drivers of logs are those of the study: ranks are uniform, and bands cover what they say.
/// The seed was fixed before; the trips have another. Seeds 2 and 3 hold, too (2026-11-23).
#[test]
fn traces_of_the_program_have_uniform_ranks_and_are_covered() {
    let folder = tempfile::tempdir().unwrap();
    let (seed, trips_seed) = ("1", "101");
    let number = seed.parse().unwrap();
    let (road, on_road) = road(folder.path(), number);
    let file = folder.path().join("logs.csv");
    let logs = logs(&file, &on_road.study, number, 1000, &COLUMNS[..4]);
    let road = road.to_str().unwrap();
    let asked = ["validate", &logs, "--road", road, "--seed", trips_seed, "--json", "--quiet"];
    let (found, message) =
        answer(&[&asked[..], &["--study", "field-truck"], &SET_ARGUMENTS].concat());
    assert_eq!(message, "");
    assert_eq!(found["drives"].as_array().unwrap().len(), 1000);
    assert_eq!((&found["trips"], &found["circular"]), (&2000.into(), &Value::Array(vec![])));
    let speed = pooled(&found, "speed");
    println!("seed {seed}: speed in half {}, in 90 % {}", speed["coverage50"], speed["coverage90"]);
    for quantity in ["duration", "moving", "standstill", "stops", "speed_at_a_place", "energy"] {
        let once = pooled(&found, quantity);
        let p = once["uniform"]["p"].as_f64().unwrap();
        println!("  {quantity}: p {p:.3}, {} {}", once["coverage50"], once["coverage90"]);
        assert!(p > 0.01, "seed {seed}, {quantity}: {p}");
    }
    for quantity in ["speed", "duration", "energy"] {
        let near = |key: &str, wanted: f64, within: f64| {
            let share = pooled(&found, quantity)[key].as_f64().unwrap();
            // 530 of 1000 are within three points of a half
            assert!((share - wanted).abs() < within + 1e-9, "seed {seed}, {quantity}: {share}");
        };
        near("coverage50", 0.5, 0.03);
        near("coverage90", 0.9, 0.02);
    }
}

/// Other drivers than those of the study are found out: the same logs under a study whose drivers
/// stay 15 % below all limits.
#[test]
fn drivers_of_another_population_are_found_out() {
    let folder = tempfile::tempdir().unwrap();
    let (road, on_road) = road(folder.path(), 1);
    let logs = logs(&folder.path().join("logs.csv"), &on_road.study, 1, 100, &COLUMNS[..4]);
    let other = ["--set", "driver.speed_limit.compliance=0.85", "--seed", "5"];
    let asked = ["validate", &logs, "--road", road.to_str().unwrap(), "--json", "--quiet"];
    let (found, _) = answer(&[&asked[..], &SET_ARGUMENTS, &other].concat());
    let time = pooled(&found, "duration");
    assert!(time["uniform"]["p"].as_f64().unwrap() < 1e-6, "{time}");
    assert!(time["coverage50"].as_f64().unwrap() < 0.4, "{time}");
    assert!(pooled(&found, "speed")["mean_error"].as_f64().unwrap() < -0.5);
}

/// A log with limits gives the road that was driven on back.
#[test]
fn the_road_of_a_log_is_the_one_that_was_driven() {
    let folder = tempfile::tempdir().unwrap();
    let sets = ["mission.length_m=20000", "simulation.step_s=0.2"];
    let loaded = study::load("field-truck", &sets).unwrap();
    let logs = logs(&folder.path().join("log.csv"), &loaded.study, 3, 1, &COLUMNS);
    let out = folder.path().join("road.csv");
    ocmc(&["road", &logs, "--out", out.to_str().unwrap(), "--quiet"]).assert().success();
    let made = ocmc_io::given_cycle::read(&out, &[]).unwrap();
    let true_road = loaded.study.sample(3, 0).cycle.road;
    assert!((made.length_m / true_road.length_m - 1.0).abs() < 1e-3, "{}", made.length_m);
    assert_eq!(made.limit_source.as_deref(), Some("column"));
    assert!(made.source_log.as_deref().is_some_and(|name| name.starts_with("log-")));
    // altitudes where both know them
    let mut altitude_m = 0.0;
    let mut worst_m = 0.0f64;
    for (k, slope) in true_road.slopes.iter().enumerate() {
        let at_m = k as f64 * true_road.slope_step_m;
        worst_m = worst_m.max((made.altitude_m(at_m) - altitude_m).abs());
        altitude_m += slope * true_road.slope_step_m;
    }
    assert!(worst_m < 3.0, "{worst_m} m");
    // stops where they were, within what a truck stands before a line
    let stops = |events: &[ocmc_core::operating_cycle::road::point_event::PointEvent]| {
        let stop = events.iter().filter(|e| e.kind.standstill_s().is_some_and(|s| s > 2.0));
        stop.map(|e| e.position_m).collect::<Vec<f64>>()
    };
    let (found, wanted) = (stops(&made.events), stops(&true_road.events));
    let near = |at_m: &f64, all: &[f64]| all.iter().any(|other| (other - at_m).abs() < 5.0);
    let missed = wanted.iter().filter(|at_m| !near(at_m, &found)).count();
    assert!(missed * 5 <= wanted.len(), "{found:?} of {wanted:?}");
    // and it is driven
    let arguments = ["drive", out.to_str().unwrap(), "--cycles", "20", "--json", "--quiet"];
    let (driven, _) = answer(&arguments);
    assert_eq!(driven["outcomes"]["completed"], 20);
}

/// Limits that follow from the speed of the validated log are circular, also by way of a file;
/// those of another log are not.
#[test]
fn what_comes_from_the_validated_log_is_circular() {
    let folder = tempfile::tempdir().unwrap();
    let (_, on_road) = road(folder.path(), 2);
    let plain = ["time_s", "position_m", "speed_mps", "grade"];
    let own = logs(&folder.path().join("a.csv"), &on_road.study, 1, 1, &plain);
    let other = logs(&folder.path().join("b.csv"), &on_road.study, 2, 1, &plain);
    let made = folder.path().join("road.csv");
    let made = made.to_str().unwrap();
    ocmc(&["road", &own, "--out", made, "--quiet"]).assert().success();
    let asked = |log: &str, more: &[&str]| {
        let all = [&["validate", log, "--trips", "60", "--json"][..], &SET_ARGUMENTS, more];
        let (found, message) = answer(&all.concat());
        (found["circular"].clone(), message)
    };
    let (itself, message) = asked(&own, &[]);
    assert!(itself.to_string().contains("limits"), "{itself}");
    assert!(message.contains("circular: the limits") && message.contains("no validation"));
    assert!(message.contains("60 trips: bands and ranks want 2000"), "{message}");
    assert!(asked(&own, &["--road", made]).0.to_string().contains("limits"));
    assert_eq!(asked(&other, &["--road", made]).0, Value::Array(vec![]));
    // a limit that is given is no circle
    let (given, message) = asked(&own, &["--limit", "25", "--no-stops"]);
    assert_eq!(given, Value::Array(vec![]), "{message}");
}

/// The files of an answer: they are there, none holds a number that is none, and a directory that
/// holds something is left alone.
#[test]
fn an_answer_is_written_to_an_empty_directory() {
    let folder = tempfile::tempdir().unwrap();
    let (_, on_road) = road(folder.path(), 3);
    let own = logs(&folder.path().join("a.csv"), &on_road.study, 1, 2, &COLUMNS);
    let out = folder.path().join("out");
    let arguments = ["validate", &own, "--trips", "50", "--quiet", "--out", out.to_str().unwrap()];
    ocmc(&[&arguments[..], &SET_ARGUMENTS].concat()).assert().success();
    for name in ["validation.json", "scores.csv", "drives.csv", "speed.csv", "report.html"] {
        let text = fs::read_to_string(out.join(name)).unwrap();
        assert!(text.len() > 100, "{name}");
        assert!(!text.contains("NaN") && !text.contains("inf,"), "{name}");
    }
    let picture = fs::read_to_string(out.join("speed-1.svg")).unwrap();
    assert!(picture.starts_with("<svg xmlns=") && picture.trim_end().ends_with("</svg>"));
    let again = ocmc(&[&arguments[..], &SET_ARGUMENTS].concat()).output().unwrap();
    let message = String::from_utf8(again.stderr).unwrap();
    assert!(again.status.code() == Some(1) && message.contains("is not empty"), "{message}");
}

/// Whatever a log holds: an answer without NaN, or a message; never a panic.
#[test]
fn hostile_logs_end_in_an_answer_or_a_message() {
    let folder = tempfile::tempdir().unwrap();
    let head =
        "time_s,speed_mps,altitude_m,latitude_deg,longitude_deg,limit_mps,fuel_kgps,position_m\n";
    let rows = |row: &dyn Fn(usize) -> String| {
        format!("{head}{}", (0..600).map(row).collect::<Vec<_>>().join("\n"))
    };
    let cases: Vec<(&str, String)> = vec![
        ("empty", String::new()),
        ("header", head.to_owned()),
        ("nan", rows(&|k| format!("{k},NaN,NaN,NaN,NaN,NaN,NaN,NaN"))),
        ("at-rest", rows(&|k| format!("{k},0,100,52,9,13,0.001,5"))),
        (
            "cliff",
            rows(&|k| format!("{k},10,{},52,9,13,0.001,", if k % 2 == 0 { 0 } else { 8000 })),
        ),
        ("altitude", rows(&|k| format!("{k},10,1e9,52,9,13,0.001,{}", 10 * k))),
        ("poles", rows(&|k| format!("{k},10,0,{},{},13,0.001,", 90 - k % 181, (k * 37) % 720))),
        (
            "limits",
            rows(&|k| format!("{k},10,0,52,9,{},0.001,", if k % 3 == 0 { -5 } else { 900 })),
        ),
        ("fuel", rows(&|k| format!("{k},10,0,52,9,13,{},", if k == 50 { "x" } else { "1e300" }))),
        ("jumps", rows(&|k| format!("{},10,0,52,9,13,0.001,{}", k + 100 * (k / 7), k * k))),
        ("back", rows(&|k| format!("{},10,0,52,9,13,0.001,", 600 - k))),
        ("fast", rows(&|k| format!("{k},1e7,0,52,9,13,0.001,"))),
        ("positions", rows(&|k| format!("{k},10,0,52,9,13,0.001,{}", -1e6 + 1e4 * k as f64))),
        ("crawl", rows(&|k| format!("{k},0.5,0,52,9,13,0.001,"))),
        (
            "stop-and-go",
            rows(&|k| format!("{k},{},0,52,9,13,0.001,", if k % 4 < 2 { 0 } else { 9 })),
        ),
        ("vmod", "time [s],dist [m]\n1,2\n".to_owned()),
    ];
    for (name, text) in cases {
        let ending = if name == "vmod" { "vmod" } else { "csv" };
        let path = folder.path().join(format!("{name}.{ending}"));
        fs::write(&path, text).unwrap();
        let path = path.to_str().unwrap();
        let made = folder.path().join(format!("{name}-road.csv"));
        let made = made.to_str().unwrap();
        for arguments in [
            vec!["road", path, "--out", made],
            vec!["validate", path, "--trips", "10", "--json"],
            vec!["validate", path, "--trips", "10", "--study", "passenger-car", "--no-stops"],
        ] {
            let output = ocmc(&arguments).output().unwrap();
            let (answer, message) = (
                String::from_utf8(output.stdout).unwrap(),
                String::from_utf8(output.stderr).unwrap(),
            );
            assert!(matches!(output.status.code(), Some(0 | 1)), "{arguments:?}: {message}");
            assert!(!message.contains("panicked"), "{arguments:?}: {message}");
            assert!(!answer.contains("NaN") && !answer.contains("inf"), "{arguments:?}: {answer}");
            if output.status.code() == Some(1) {
                assert!(
                    message.starts_with("error: ") || message.contains("\nerror: "),
                    "{message}"
                );
            }
        }
    }
}

/// The shared logs of cars are validated as they are: every drive that is long enough gets scores.
#[test]
fn logs_of_cars_get_their_scores() {
    let Some(log) = shared("logs/driveplotr_nds_28drives.csv.gz") else { return };
    let maps = [
        "time_s=time_utc",
        "yaw_rate_degps=gyro_z",
        "altitude_m=gps_elevation",
        "latitude_deg=gps_lat",
        "longitude_deg=gps_long",
        "course_deg=gps_heading",
    ];
    let mut arguments = vec!["validate", log.to_str().unwrap(), "--study", "passenger-car"];
    for map in maps {
        arguments.extend(["--map", map]);
    }
    arguments.extend(["--trips", "60", "--json", "--quiet"]);
    let (found, message) = answer(&arguments);
    assert!(message.contains("circular"), "{message}");
    assert!(found["drives"].as_array().unwrap().len() > 25);
    let speed = pooled(&found, "speed");
    assert!(speed["n"].as_u64().unwrap() > 20_000);
    assert!(speed["rmse"].as_f64().unwrap() < 5.0, "{speed}");
    let mut quantities = found["pooled"].as_array().unwrap().iter().map(|p| &p["quantity"]);
    assert!(quantities.all(|name| name != "energy"), "cars without a column of fuel");
}

/// VECTO's own drive over its mission, among drivers: its fuel and its time are compared, and
/// nothing of its road is its own.
#[test]
fn a_drive_of_vecto_is_laid_over_drivers() {
    let folder = "vecto/results/declaration_40t";
    let name = "40t_Long_Haul_Truck_Regional_Delivery_Reference_Loading.vmod.gz";
    let Some(series) = shared(&format!("{folder}/{name}")) else { return };
    let Some(mission) = shared("vecto/cycles/RegionalDelivery.vdri") else { return };
    let arguments = [
        "validate",
        series.to_str().unwrap(),
        "--road",
        mission.to_str().unwrap(),
        "--study",
        "field-truck",
        "--trips",
        "40",
        "--json",
        "--quiet",
    ];
    let (found, _) = answer(&arguments);
    assert_eq!(found["circular"], Value::Array(vec![]));
    let values = &found["drives"][0]["values"];
    let fuel = &values["energy"];
    // Terms of ocmc vecto: 7.8 kg on 25.8 km; here from the first to the last place
    let (measured, simulated) = (fuel["measured"].as_f64(), fuel["simulated"].as_f64());
    assert!(measured.is_some_and(|kg| (6.0..9.5).contains(&kg)), "{fuel}");
    assert!(simulated.is_some_and(|kg| (6.0..12.0).contains(&kg)), "{fuel}");
    assert!(values["stops"]["measured"].as_f64().unwrap() > 3.0, "{values}");
}

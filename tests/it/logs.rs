//! The command on measured logs: what it finds, what it says about bad ones, and what comes out of
//! the logs of others.

use crate::others_data::shared;
use crate::program::ocmc;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Output of a failing command to standard error.
fn failure(arguments: &[&str]) -> String {
    let output = ocmc(arguments).output().expect("the program starts");
    let message = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {message}");
    assert!(output.stdout.is_empty() && !message.contains("panicked"), "{message}");
    message
}

/// Answer of a command, and its messages.
fn answer(arguments: &[&str]) -> (String, String) {
    let output = ocmc(arguments).assert().success().get_output().clone();
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (text(output.stdout), text(output.stderr))
}

/// Ten seconds of standstill, then a left curve of 100 m in the middle of a straight road at 10
/// m/s.
fn log(rate_hz: f64) -> String {
    let mut text = "t_ms,v_kmh,gyro_right_degps\n".to_owned();
    for k in 0..(110.0 * rate_hz) as usize {
        let time_s = k as f64 / rate_hz;
        let speed = if time_s < 10.0 { 0.0 } else { 36.0 };
        let yaw = if (50.0..60.0).contains(&time_s) { -(0.1f64).to_degrees() } else { 0.0 };
        writeln!(text, "{},{speed},{yaw}", time_s * 1000.0).expect("memory");
    }
    text
}

const MAPS: [&str; 6] = [
    "--map",
    "time_ms=t_ms",
    "--map",
    "speed_kmh=v_kmh",
    "--map",
    "yaw_rate_degps=-gyro_right_degps",
];

fn written(directory: &Path, name: &str, text: &str) -> String {
    let path = directory.join(name);
    fs::write(&path, text).expect("a temporary file");
    path.to_str().expect("UTF-8").to_owned()
}

#[test]
fn a_curve_is_found_at_every_rate() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    for rate_hz in [1.0, 10.0, 100.0] {
        let path = written(directory.path(), "truck-7.csv", &log(rate_hz));
        let (csv, message) = answer(&[&["curves", &path][..], &MAPS].concat());
        let mut reader = csv::Reader::from_reader(csv.as_bytes());
        let names = reader.headers().expect("a header").clone();
        let rows: Vec<csv::StringRecord> =
            reader.records().map(|row| row.expect("a row")).collect();
        assert_eq!(rows.len(), 1, "{csv}");
        let cell = |name: &str| {
            &rows[0][names.iter().position(|column| column == name).expect("a known column")]
        };
        let number = |name: &str| cell(name).parse::<f64>().expect("a number");
        assert_eq!((cell("driver"), cell("direction")), ("truck-7", "left"));
        assert!(
            (number("radius_m") - 100.0).abs() < 1e-6 && (number("speed_mps") - 10.0).abs() < 1e-6
        );
        assert!(
            (number("length_m") - 100.0).abs() <= 20.0 && (number("turn_rad") - 1.0).abs() < 0.15
        );
        assert!(
            (number("start_m") - 405.0).abs() <= 20.0 && (number("route_m") - 1000.0).abs() < 20.0
        );
        assert!(message.contains("1 curve on"), "{message}");
    }
}

#[test]
fn the_course_does_for_a_gyro() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    // the same drive with a compass course, which a receiver updates once a second and loses at
    // rest
    let mut text = "time_s,speed_kmh,course_deg\n".to_owned();
    for k in 0..1100 {
        let time_s = f64::from(k) / 10.0;
        let speed = if time_s < 10.0 { 0.0 } else { 36.0 };
        let turned = (0.1 * (time_s.floor() - 50.0).clamp(0.0, 10.0)).to_degrees();
        let course =
            if speed > 0.0 { (10.0 - turned).rem_euclid(360.0).to_string() } else { String::new() };
        writeln!(text, "{time_s},{speed},{course}").expect("memory");
    }
    let path = written(directory.path(), "truck-8.csv", &text);
    let (csv, message) = answer(&["curves", &path]);
    let rows: Vec<csv::StringRecord> =
        csv::Reader::from_reader(csv.as_bytes()).records().map(|row| row.expect("a row")).collect();
    assert_eq!(rows.len(), 1, "{csv}");
    assert_eq!(&rows[0][2], "left");
    let radius_m: f64 = rows[0][3].parse().expect("a number");
    assert!((radius_m - 100.0).abs() < 1.0, "{csv}");
    assert!(
        message.contains("turning by its course") && message.contains("1,100 of 1,100 rows used"),
        "{message}"
    );
}

#[test]
fn detectors_and_radii_can_be_chosen_and_json_has_the_counts() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let path = written(directory.path(), "a.csv", &log(10.0));
    let out = directory.path().join("curves.json");
    for options in [["--detector", "threshold"], ["--detector", "trained"], ["--radius", "mean"]] {
        let out = out.to_str().expect("UTF-8");
        answer(&[&["curves", &path, "--out", out, "--quiet"][..], &MAPS, &options].concat());
        let json: serde_json::Value =
            serde_json::from_slice(&fs::read(out).expect("written")).expect("JSON");
        let drive = &json["drives"][0];
        assert_eq!(drive["curves"].as_array().map(Vec::len), Some(1), "{options:?}");
        assert_eq!(drive["counts"]["used"], 1100);
    }
}

#[test]
fn bad_logs_say_what_is_wrong_and_where() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let good = log(10.0);
    let short: String = good.lines().take(4).flat_map(|line| [line, "\n"]).collect();
    let mut lines: Vec<&str> = good.lines().collect();
    lines.swap(100, 200);
    let backwards = lines.join("\n");
    let texts = good.replace(",36,", ",fast,").replace(",0,", ",,");
    for (name, text, expected) in [
        ("empty.csv", "", &["is empty"][..]),
        ("header.csv", "t_ms,v_kmh,gyro_right_degps\n", &["no rows"]),
        ("short.csv", &short, &["3 of 3 rows", "at least 10"]),
        ("backwards.csv", &backwards, &["backwards 2 times", "after row 100"]),
        ("texts.csv", &texts, &["`v_kmh`", "no number in any of its 1100 rows", "`fast`"]),
        (
            "missing.csv",
            &good.replace("gyro_right_degps", "gyro"),
            &["gyro_right_degps", "did you mean `gyro`"],
        ),
    ] {
        let path = written(directory.path(), name, text);
        let message = failure(&[&["curves", &path][..], &MAPS].concat());
        assert!(expected.iter().all(|part| message.contains(part)), "{name}: {message}");
        assert!(message.contains(name), "{message}");
    }
    let path = written(directory.path(), "plain.csv", &good);
    let message = failure(&["curves", &path]);
    assert!(
        message.contains("no column for the time") && message.contains("--map time_s="),
        "{message}"
    );
    let message = failure(&["curves", &path, "--map", "speed_knots=v_kmh"]);
    assert!(message.contains("speed_kn"), "{message}");
    let message = failure(&["curves", "absent.csv"]);
    assert!(message.contains("cannot read `absent.csv`"), "{message}");
    // seconds taken for milliseconds
    let message = failure(&[
        "curves",
        &path,
        "--map",
        "time_s=t_ms",
        "--map",
        "speed_kmh=v_kmh",
        "--map",
        "yaw_rate_degps=gyro_right_degps",
    ]);
    assert!(message.contains("is the unit of time right?"), "{message}");
}

#[test]
fn what_is_not_used_is_counted() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let mut lines: Vec<String> = log(10.0).lines().map(str::to_owned).collect();
    for line in &mut lines[300..340] {
        *line = line.replace(",0", ",NaN"); // 4 s without yaw rate
    }
    lines[400] = "what".to_owned();
    lines[600].push('x'); // not a number
    let path = written(directory.path(), "a.csv", &lines.join("\n"));
    let (_, message) = answer(&[&["curves", &path][..], &MAPS].concat());
    for part in [
        "1 of 1,100 rows",
        "have too few or too many cells",
        "first `what` in line 401",
        "rows without yaw rate: 41",
        "1,058 of 1,100 rows used",
        "gaps in time: 1",
    ] {
        assert!(message.contains(part), "{part}: {message}");
    }
}

#[test]
fn the_logs_of_others_give_curves() {
    let Some(logs) = shared("logs") else { return };
    let path = |name: &str| logs.join(name).to_str().expect("UTF-8").to_owned();
    let (csv, message) = answer(&[
        "curves",
        &path("driveplotr_nds_28drives.csv.gz"),
        "--map=time_s=time_utc",
        "--map=yaw_rate_degps=gyro_z",
        "--map=course_deg=gps_heading",
    ]);
    // 28 drives of a car in towns, sampled with 1 Hz: some 200 to 300 curves, mostly junction turns
    let curves = csv.lines().count() - 1;
    assert!((150..400).contains(&curves), "{curves}");
    assert!(
        message.contains("of 28 drives") && message.contains("23,186 of 23,187 rows used"),
        "{message}"
    );
    let (csv, message) = answer(&[
        "curves",
        &path("udacity_ch2_part1.csv.gz"),
        &path("udacity_ch2_part4.csv.gz"),
        "--map=time_ns=t_unix_ns",
        "--steering-ratio=14.8",
        "--wheelbase-m=2.85",
    ]);
    assert!((10..60).contains(&(csv.lines().count() - 1)), "{message}");
}

#[test]
fn a_trace_is_a_log() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let path = directory.path().join("trace.csv");
    let path = path.to_str().expect("UTF-8");
    let setting = ["--set", "mission.length_m=40000", "--cycle-id", "3"];
    answer(&[&["trace", "--out", path][..], &setting].concat());
    let (csv, message) = answer(&["curves", path, "--split", "1.3"]);
    // its steps are of unequal length: only standstills part it
    let way_km: f64 = message
        .split("curves on ")
        .nth(1)
        .and_then(|rest| rest.split(' ').next())
        .expect("a way")
        .parse()
        .expect("km");
    assert!(way_km > 39.5, "{message}");
    let (cycle, _) = answer(&[&["cycle"][..], &setting].concat());
    // curvature of the road, where it changes
    let road: Vec<(f64, f64)> = cycle
        .lines()
        .filter_map(|line| line.strip_prefix("curvature_per_m,constant,"))
        .map(|line| line.split_once(',').expect("two numbers"))
        .map(|(at, value)| (at.parse().expect("m"), value.parse().expect("1/m")))
        .collect();
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let mut near = 0;
    let mut found = 0;
    for row in reader.records() {
        let row = row.expect("a row");
        let number = |k: usize| row[k].parse::<f64>().expect("a number");
        let middle_m = f64::midpoint(number(8), number(9));
        let at = road.partition_point(|(start_m, _)| *start_m <= middle_m);
        let curvature = road[at - 1].1;
        let drawn = if &row[2] == "left" { 1.0 } else { -1.0 } / number(3);
        found += 1;
        near += usize::from((drawn / curvature - 1.0).abs() < 0.05);
        assert!(number(5) > 5.0, "a limit");
    }
    assert!(found >= 10 && near as f64 >= 0.8 * found as f64, "{near} of {found}");
}

#[test]
fn gains_of_a_trace_are_identified() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let path = directory.path().join("driver-0.csv");
    let path = path.to_str().expect("UTF-8");
    answer(&["trace", "--study", "simulator-slopes", "--cycle-id", "0", "--out", path]);
    let quick = ["--speed-term", "none", "--no-intervals", "--starts", "2"];
    let (json, message) = answer(
        &[&["identify", path, "--study", "simulator-slopes", "--json"][..], &quick].concat(),
    );
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let fits = json["fits"].as_array().expect("a list");
    let events: Vec<&str> = fits.iter().filter_map(|fit| fit["event"].as_str()).collect();
    assert_eq!(events, ["+1.5 %", "-1.5 %", "+3.5 %", "-3.5 %", "+5.5 %", "-5.5 %"]);
    assert_eq!(fits[0]["driver"], "driver-0");
    // one driver: the events without a fully pressed pedal agree about him
    let gain = |k: usize| fits[k]["kp"].as_f64().expect("a number");
    assert!((gain(1) / gain(0) - 1.0).abs() < 0.01, "{} {}", gain(0), gain(1));
    assert!(json["population"].is_null());
    // a trace ends with a row of no duration, and has steps of microseconds
    assert!(!message.contains("row before"), "{message}");
    for arguments in [&["curves", path][..], &["fit", "operating-cycle", path]] {
        let (_, message) = answer(arguments);
        assert!(!message.contains("row before"), "{message}");
    }
    for how in ["exact", "driver"] {
        let study = ["--study", "simulator-slopes", "--cycles", "1"];
        let follow = ["drive", path, "--follow-speed", how];
        let (_, message) = answer(&[&follow[..], &study].concat());
        assert!(!message.contains("warning"), "{message}");
    }
    // a log of speed alone
    let plain = written(directory.path(), "plain.csv", "time_s,speed_mps,grade\n0,20,0.0\n");
    let message = failure(&["identify", &plain]);
    assert!(message.contains("no column for the accelerator pedal"), "{message}");
    let flat: String =
        (0..400).fold("time_s,speed_mps,grade,accelerator,brake\n".to_owned(), |mut text, k| {
            writeln!(text, "{},20,0.0,0.3,0", f64::from(k) * 0.1).expect("memory");
            text
        });
    let flat = written(directory.path(), "flat.csv", &flat);
    let message = failure(&["identify", &flat]);
    assert!(message.contains("no event"), "{message}");
}

#[test]
fn events_without_a_fit_are_counted_and_quiet_is_quiet() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    // twelve events of 2 s, and one that can be identified
    let mut text = "time_s,speed_mps,grade,accelerator,brake,event\n".to_owned();
    for k in 0..240 + 400 {
        let event = if k < 240 { k / 20 } else { 99 };
        let grade = if k < 340 { 0.0 } else { 0.02 };
        writeln!(text, "{},20,{grade},0.3,0,{event}", f64::from(k) * 0.1).expect("memory");
    }
    let path = written(directory.path(), "events.csv", &text);
    let arguments = ["identify", &path, "--no-intervals", "--starts", "1"];
    let (_, message) = answer(&arguments);
    assert!(
        message.contains("12 events or drives are left out: 12 for less than 30 rows or 10 s"),
        "{message}"
    );
    // pedals that do not answer a slope are explained by no driver
    assert!(message.contains("1 of 1 fits do not explain their pedals"), "{message}");
    assert_eq!(message.matches("warning").count(), 2, "{message}");
    let (json, message) = answer(&[&arguments[..], &["--quiet", "--json"]].concat());
    assert_eq!(message, "");
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(json["left_out"].as_array().map(Vec::len), Some(12));
    // the paper's readings bias the gains: they have to be asked for
    assert_eq!(json["options"]["speed_term"], "none");
    // without the event that can be, the first reason and the account are the error
    let short: String = text.lines().take(241).fold(String::new(), |all, line| all + line + "\n");
    let message = failure(&["identify", &written(directory.path(), "short.csv", &short)]);
    assert!(
        message.contains("20 rows over 1.9 s") && message.contains("12 for less than"),
        "{message}"
    );
}

#[test]
fn decimal_commas_and_dates_get_a_hint() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    // one kind of decimals in a table: the first one
    let commas = "time_s;speed_mps;yaw_rate_radps\n0.1;10,5;0,1\n0.2;10,5;0,1\n";
    let message = failure(&["curves", &written(directory.path(), "commas.csv", commas)]);
    assert!(message.contains("line 2 has `10,5`; numbers take a decimal point"), "{message}");
    let dates = "time_s,speed_mps,yaw_rate_radps\n2024-03-01T12:00:00Z,10,0\n";
    let message = failure(&["curves", &written(directory.path(), "dates.csv", dates)]);
    assert!(message.contains("`2024-03-01T12:00:00Z`; times are numbers, seconds"), "{message}");
}

#[test]
fn a_log_in_another_encoding_is_named_so() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let path = directory.path().join("latin.csv");
    let mut bytes = b"time_s,speed_mps,yaw_rate_radps,place\n0,10,0,home\n1,10,0,K".to_vec();
    bytes.push(0xf6);
    bytes.extend(b"ln\n");
    fs::write(&path, bytes).expect("a temporary file");
    let message = failure(&["curves", path.to_str().expect("UTF-8")]);
    assert!(
        message.contains("line 3: the text is not UTF-8") && message.contains("save"),
        "{message}"
    );
}

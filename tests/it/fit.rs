//! `ocmc fit` as a user meets it: answers, studies that run, and failures that say what to do.

use crate::program::ocmc;
use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// The curves of the guide.
fn simulator_curves() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/data/simulator_curves.csv")
}

fn run(arguments: &[&str]) -> (i32, String, String) {
    let output = ocmc(arguments).output().expect("the program starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().unwrap_or(-1), text(output.stdout), text(output.stderr))
}

fn answer(arguments: &[&str]) -> String {
    let (status, stdout, stderr) = run(arguments);
    assert_eq!(status, 0, "{arguments:?}: {stderr}");
    stdout
}

/// Message on a table that has no fit.
fn refusal(table: &str, options: &[&str]) -> String {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("curves.csv");
    fs::write(&file, table).expect("a file");
    let path = file.to_str().expect("UTF-8");
    let (status, stdout, stderr) = run(&[&["fit", "curve-speed", path], options].concat());
    assert_eq!(status, 1, "{stderr}");
    assert!(stdout.is_empty() && !stderr.contains("panicked"), "{stderr}");
    stderr
}

#[test]
fn the_curves_of_the_guide() {
    let file = simulator_curves();
    let path = file.to_str().expect("UTF-8");
    let text = answer(&["fit", "curve-speed", path]);
    for part in
        ["48 of 48 curves, 8 drivers", "2.05e-11", "0.231 (0.182 ; 0.280)", "[driver.curve_speed]"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    let json: Value =
        serde_json::from_str(&answer(&["fit", "curve-speed", path, "--json"])).expect("JSON");
    assert_eq!(json["n"], 48);
    assert_eq!(json["anova"][3]["df"], 38);
    assert!(json["anova"][3]["p"].is_null());
    assert_eq!(json["by_driver"].as_array().map(Vec::len), Some(8));
    assert!(json["estimated"]["direction_effect"].is_null());
    assert!(
        (json["study"]["driver"]["curve_speed"]["exponent"].as_f64().expect("a number") - 0.231)
            .abs()
            < 1e-3
    );
}

#[test]
fn the_spread_between_drivers_is_that_of_reml_and_of_one_driver_that_of_the_base() {
    let file = simulator_curves();
    let fitted = |path: &str, options: &[&str]| -> Value {
        let answer = answer(&[&["fit", "curve-speed", path, "--json"], options].concat());
        serde_json::from_str(&answer).expect("JSON")
    };
    let written = |json: &Value| {
        json["study"]["driver"]["curve_speed"]["driver_sd"].as_f64().expect("a number")
    };
    let all = fitted(file.to_str().expect("UTF-8"), &[]);
    let reml = all["random_intercept"]["driver_sd"].as_f64().expect("a number");
    assert!((written(&all) / reml - 1.0).abs() < 1e-6, "{} {reml}", written(&all));
    let sample = all["estimated"]["driver_sd"].as_f64().expect("a number");
    assert!((reml / sample - 1.0).abs() > 1e-3, "{reml} {sample}");
    // one driver says nothing about how drivers differ
    let table = fs::read_to_string(file).expect("curves");
    let rows =
        table.lines().filter(|row| row.starts_with("driver 1,") || row.starts_with("driver,"));
    let directory = tempfile::tempdir().expect("a directory");
    let one = directory.path().join("one.csv");
    fs::write(&one, rows.collect::<Vec<_>>().join("\n")).expect("space");
    let base = directory.path().join("base.toml");
    let text = "study.base = \"field-truck\"\nstudy.name = \"base\"\n\
                driver.curve_speed.driver_sd = 0.123\n";
    fs::write(&base, text).expect("space");
    let base = base.to_str().expect("UTF-8");
    let one = fitted(one.to_str().expect("UTF-8"), &["--base", base]);
    assert_eq!((&one["drivers"], written(&one)), (&Value::from(1), 0.123));
    assert!(one["warnings"][0].as_str().is_some_and(|text| text.contains("that of the base")));
}

#[test]
fn a_fitted_study_runs() {
    let directory = tempfile::tempdir().expect("a directory");
    let study = directory.path().join("mine.toml");
    let (out, curves) = (study.to_str().expect("UTF-8"), simulator_curves());
    let arguments = ["fit", "curve-speed", curves.to_str().expect("UTF-8"), "--study-out", out];
    answer(&arguments);
    let run_of_study =
        ["--study", out, "--cycles", "2", "--set", "mission.length_m=5000", "--json"];
    let json: Value = serde_json::from_str(&answer(&run_of_study)).expect("JSON");
    assert_eq!(json["outcomes"]["completed"], 2);
    // a study is never replaced
    let (status, _, stderr) = run(&arguments);
    assert!(status == 1 && stderr.contains("exists already"), "{stderr}");
}

#[test]
fn rows_that_are_left_out_are_counted() {
    let mut table = fs::read_to_string(simulator_curves()).expect("curves");
    table.push_str(
        "driver 1,19,left,5\ndriver 1,501,left,5\ndriver 1,,left,5\n\
         driver 1,100,left,0\ndriver 1,120,left,nan\n",
    );
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("curves.csv");
    fs::write(&file, table).expect("a file");
    let path = file.to_str().expect("UTF-8");
    let json: Value =
        serde_json::from_str(&answer(&["fit", "curve-speed", path, "--json"])).expect("JSON");
    assert_eq!(json["n"], 48);
    for (reason, rows) in [
        ("radius_too_small", 1),
        ("radius_too_large", 1),
        ("missing_value", 2),
        ("speed_not_positive", 1),
    ] {
        assert_eq!(json["dropped"][reason], rows, "{json:#}");
    }
}

#[test]
fn free_curves_and_rows_without_a_direction() {
    let mut table = "driver,radius_m,direction,speed_mps,gap_before_m,gap_after_m,\
         slowest_near_mps,stop_near_m\n"
        .to_owned();
    for k in 0..16 {
        let (driver, side) = (k % 2, ["left", "right"][k / 2 % 2]);
        let (radius, speed) = (60 + 20 * k, 8.0 + 0.6 * k as f64 + 0.3 * (k % 3) as f64);
        let _ = writeln!(table, "d{driver},{radius},{side},{speed},200,300,{speed},");
    }
    table.push_str("d0,100,left,10,149,300,10,\n"); // close to the curve before
    table.push_str("d0,100,left,10,200,100,10,900\n"); // and to the next one
    table.push_str("d1,100,left,10,200,300,10,20\n"); // close to a standstill
    table.push_str("d1,100,left,10,200,300,5,900\n"); // something slowed it nearby
    table.push_str("d1,100,left,10,,300,10,900\n"); // nothing says how far the curve before is
    table.push_str("d1,100,,10,200,300,10,900\n"); // no direction
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("curves.csv");
    fs::write(&file, table).expect("a file");
    let path = file.to_str().expect("UTF-8");
    let fitted = |options: &[&str]| -> Value {
        let text = answer(&[&["fit", "curve-speed", path, "--json"], options].concat());
        serde_json::from_str(&text).expect("JSON")
    };
    let all = fitted(&[]);
    assert_eq!((&all["n"], &all["dropped"]["missing_value"]), (&21.into(), &1.into()));
    let free = fitted(&["--isolated", "150"]);
    assert_eq!(free["n"], 16);
    for (reason, rows) in [
        ("near_another_curve", 2),
        ("near_a_standstill", 1),
        ("slower_nearby", 1),
        ("missing_value", 2),
    ] {
        assert_eq!(free["dropped"][reason], rows, "{:#}", free["dropped"]);
    }
    let plain = refusal("driver,radius_m,speed_mps\na,100,9\n", &["--isolated", "150"]);
    assert!(plain.contains("gap_before_m and gap_after_m"), "{plain}");
}

#[test]
fn tables_without_a_fit_are_refused_in_words() {
    let rows =
        |rows: &[&str]| format!("driver,radius_m,direction,speed_mps\n{}\n", rows.join("\n"));
    let one_radius: Vec<String> =
        (0..9).map(|k| format!("d{},100,left,{}", k % 3, 10 + k)).collect();
    let own_radius: Vec<String> =
        (0..9).map(|k| format!("d{},{},left,{}", k % 3, 100 + k % 3, 10 + k)).collect();
    let text =
        |rows: &[String]| format!("driver,radius_m,direction,speed_mps\n{}\n", rows.join("\n"));
    for (table, part) in [
        (String::new(), "is empty"),
        (rows(&[]), "no rows"),
        (rows(&["a,5,left,3"]), "1 radius_too_small"),
        (
            "driver,radius_m,speed\na,100,5\n".to_owned(),
            "no column for the speed (`speed` has no known unit)",
        ),
        (rows(&["a,100,up,5"]), "allowed is `left` or `right`"),
        (
            rows(&["a,100,left,5", "a,200,right,6", "b,300,left,8"]),
            "3 curves of 2 drivers are too few; allowed are 5",
        ),
        (text(&one_radius), "the same radius"),
        (text(&own_radius), "cannot be separated"),
        (rows(&["a,100,left,x"]), "line 2, column `speed_mps`: `x`"),
    ] {
        let printed = refusal(&table, &[]);
        assert!(printed.contains(part), "{part}: {printed}");
    }
    let printed = refusal(&rows(&["a,100,left,5"]), &["--limit-share", "2"]);
    assert!(printed.contains("share of the limit is 2; allowed"), "{printed}");
    let missing = run(&["fit", "curve-speed", "there-is-no-such.csv"]);
    assert!(missing.0 == 1 && missing.2.contains("there-is-no-such.csv"), "{}", missing.2);
}

#[test]
fn one_driver_and_one_direction_are_warned_about() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("curves.csv");
    let rows: Vec<String> =
        (1..9).map(|k| format!("a,{},left,{}", 50 * k, 8 + k * k % 7)).collect();
    fs::write(&file, format!("truck,radius_m,direction,speed_mps\n{}\n", rows.join("\n")))
        .expect("a file");
    let (status, stdout, stderr) = run(&["fit", "curve-speed", file.to_str().expect("UTF-8")]);
    assert_eq!(status, 0, "{stderr}");
    assert!(stderr.contains("one driver only") && stderr.contains("same way"), "{stderr}");
    assert!(stdout.contains("8 of 8 curves, 1 driver,"), "{stdout}");
}

#[test]
fn speed_changes_from_a_table_and_from_a_log() {
    let directory = tempfile::tempdir().expect("a directory");
    let (table, log) = (directory.path().join("table.csv"), directory.path().join("log.csv"));
    let rows: Vec<String> =
        (1..=12).map(|k| format!("d{k},70-to-40,{}", -0.9 - 0.05 * f64::from(k))).collect();
    fs::write(
        &table,
        format!("driver,category,acceleration_mps2\n{}\nd1,60-to-70,0.1\n", rows.join("\n")),
    )
    .expect("a file");
    let path = table.to_str().expect("UTF-8");
    let (status, stdout, stderr) = run(&["fit", "speed-change", path]);
    assert_eq!(status, 0, "{stderr}");
    assert!(
        stdout.contains("70-to-40")
            && stdout.contains("left out: 1 speed change, within threshold"),
        "{stdout}"
    );
    assert!(stderr.contains("no acceleration was measured"), "{stderr}");
    // 72 km/h, then down to 36 km/h at 0.8 m/s², in km/h and ten rows a second
    let row = |k: i32| {
        let t = f64::from(k) / 10.0;
        let (v, limit) = (20.0 - 0.8 * (t - 30.0).clamp(0.0, 12.5), if t < 40.0 { 72 } else { 36 });
        format!("{t},{},{limit}", 3.6 * v)
    };
    let rows: Vec<String> = (0..600).map(row).collect();
    fs::write(&log, format!("time_s,speed_kmh,limit_kmh\n{}\n", rows.join("\n"))).expect("a file");
    let arguments = ["fit", "speed-change", log.to_str().expect("UTF-8"), "--json"];
    let json: Value = serde_json::from_str(&answer(&arguments)).expect("JSON");
    assert_eq!(json["by_category"][0]["category"], "72-to-36");
    assert!(
        (json["deceleration"]["median_mps2"].as_f64().expect("a number") + 0.8).abs() < 1e-6,
        "{json:#}"
    );
    // a trace is a log, though it has accelerations, too
    let trace = directory.path().join("trace.csv");
    let trace = trace.to_str().expect("UTF-8");
    answer(&["trace", "--cycle-id", "1", "--out", trace]);
    let of_trace: Value =
        serde_json::from_str(&answer(&["fit", "speed-change", trace, "--json"])).expect("JSON");
    let changes = of_trace["n"].as_u64().expect("a number");
    assert!((5..500).contains(&changes), "{changes}");
    // one driver shows no spread between drivers: the study keeps that of its base
    let law = &json["study"]["driver"]["speed_change"]["deceleration_mps2"];
    assert!((law["median"].as_f64().expect("a number") - 0.8).abs() < 1e-5, "{law}");
    assert_eq!(law["log_sd"], 0.25);
}

#[test]
fn operating_cycles_of_a_study_give_a_study() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = |name: &str| directory.path().join(name).to_str().expect("UTF-8").to_owned();
    let mut arguments = vec!["fit".to_owned(), "operating-cycle".to_owned()];
    for id in ["0", "1", "2", "3"] {
        let file = path(&format!("road-{id}.{}", if id == "3" { "csv" } else { "json" }));
        answer(&["cycle", "--cycle-id", id, "--out", &file]);
        arguments.push(file);
    }
    let out = path("mine.toml");
    arguments.extend(["--study-out".to_owned(), out.clone()]);
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let text = answer(&arguments);
    for part in [
        "4 operating cycles, 400.0 km",
        "hilliness",
        "curves.median_radius_m",
        "[road.types.rural.curves]",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let of_study = ["--study", &out, "--cycles", "2", "--set", "mission.length_m=5000", "--json"];
    let json: Value = serde_json::from_str(&answer(&of_study)).expect("JSON");
    assert_eq!(json["outcomes"]["completed"], 2);
}

#[test]
fn logs_of_trucks_give_a_study() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = |name: &str| directory.path().join(name).to_str().expect("UTF-8").to_owned();
    let mut arguments = vec!["fit".to_owned(), "operating-cycle".to_owned()];
    for id in ["0", "1"] {
        let file = path(&format!("log-{id}.csv"));
        answer(&["trace", "--cycle-id", id, "--set", "mission.length_m=30000", "--out", &file]);
        arguments.push(file);
    }
    let out = path("mine.toml");
    arguments.extend(["--study-out".to_owned(), out.clone()]);
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let (status, text, notes) = run(&arguments);
    assert_eq!(status, 0, "{notes}");
    for part in ["2 operating cycles, 60.0 km", "hilliness", "standstills, per m", "[road.types."] {
        assert!(text.contains(part), "{part}: {text}");
    }
    for part in [
        "no column road_type: urban up to a limit of 55 km/h",
        "a standstill alone does not tell a sign from a queue",
        "mission: nothing tells payload_kg",
    ] {
        assert!(notes.contains(part), "{part}: {notes}");
    }
    let of_study = ["--study", &out, "--cycles", "2", "--set", "mission.length_m=5000", "--json"];
    let json: Value = serde_json::from_str(&answer(&of_study)).expect("JSON");
    assert_eq!(json["outcomes"]["completed"], 2);
}

/// Ten minutes at 20 m/s, with whatever columns are added.
fn plain_log(header: &str, cell: impl Fn(usize) -> String) -> String {
    let mut text = format!("time_s,speed_mps{header}\n");
    for k in 0..600 {
        let _ = writeln!(text, "{k},20{}", cell(k));
    }
    text
}

#[test]
fn what_is_wrong_with_logs_of_roads_is_said() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("log.csv");
    let path = file.to_str().expect("UTF-8");
    let printed = |text: &str, options: &[&str]| {
        fs::write(&file, text).expect("a file");
        let (status, _, notes) = run(&[&["fit", "operating-cycle", path], options].concat());
        assert!(!notes.contains("panicked"), "{notes}");
        (status, notes)
    };
    let bare = plain_log("", |_| String::new());
    for (text, options, words) in [
        (bare.clone(), &[][..], "no road type is known"),
        (
            bare.clone(),
            &["--road-type", "gravel"][..],
            "the road type `gravel` is not in the base study",
        ),
        (
            bare.clone(),
            &["--map", "speed_knots=speed_mps"][..],
            "no known unit: allowed are speed_mps",
        ),
        (bare.clone(), &["--map", "altitude_m=hoehe"][..], "no column `hoehe`"),
        (
            bare.clone(),
            &["--road-type", "rural", "--radius-range", "500", "20"][..],
            "the largest radius",
        ),
        (
            bare.replace("300,20", "30,20"),
            &["--road-type", "rural"][..],
            "time runs backwards once, first after row 300",
        ),
        (
            "time_s,speed_mps\n0,20\n1,20\n2,20\n".to_owned(),
            &["--road-type", "rural"][..],
            "at least 10 are needed",
        ),
        ("time_s,speed_mps\n".to_owned(), &["--road-type", "rural"][..], "no rows"),
        (String::new(), &["--map", "speed_mps=v"][..], "is empty"),
        (
            bare.replace(",20", ",fast"),
            &["--road-type", "rural"][..],
            "no number in any of its 600 rows",
        ),
    ] {
        let (status, notes) = printed(&text, options);
        assert!(status == 1 && notes.contains(words), "{words}: {status}, {notes}");
    }
    // what is missing here and there is counted
    let limits = plain_log(",limit_kmh,altitude_m,map_object", |k| {
        let limit = if k < 300 { "70" } else { "255" };
        let altitude = if k % 3 == 0 { "" } else { "12" };
        let object = if k == 100 { "bridge" } else { "" };
        format!(",{limit},{altitude},{object}")
    });
    let (status, notes) = printed(&limits, &[]);
    assert_eq!(status, 0, "{notes}");
    for words in [
        "300 rows without a possible speed limit",
        "200 rows without slope or altitude",
        "1 object of the map, none of stop_sign",
        "the way is the integral of the speed",
        "nothing tells how the vehicle turned",
    ] {
        assert!(notes.contains(words), "{words}: {notes}");
    }
    // a hole of a minute is no road
    let kept = limits.lines().enumerate().filter(|(k, _)| !(200..260).contains(k));
    let hole = kept.map(|(_, line)| line).collect::<Vec<&str>>().join("\n");
    let (status, notes) = printed(&hole, &[]);
    assert!(status == 0 && notes.contains("1 cut at more than 10 s"), "{notes}");
}

#[test]
fn a_road_without_an_object_of_the_map_counts_where_others_have_some() {
    let directory = tempfile::tempdir().expect("a directory");
    let log = |name: &str, object: &str| {
        let path = directory.path().join(name);
        let text = plain_log(",limit_kmh,map_object", |k| {
            format!(",70,{}", if k % 100 == 50 { object } else { "" })
        });
        fs::write(&path, text).expect("a file");
        path.to_str().expect("UTF-8").to_owned()
    };
    let (lights, none) = (log("a.csv", "traffic_light"), log("b.csv", ""));
    let per_m = |files: &[&str]| -> Option<f64> {
        let (status, text, notes) = run(&[&["fit", "operating-cycle"], files].concat());
        assert_eq!(status, 0, "{notes}");
        let unknown = notes.contains("no objects of a map are known");
        let line = text.lines().find(|line| line.starts_with("traffic_lights.per_m"));
        assert_eq!(unknown, line.is_none(), "{notes}");
        line.map(|line| line.split_whitespace().nth(1).expect("a number").parse().expect("one"))
    };
    let one = per_m(&[&lights]).expect("lights");
    let two = per_m(&[&lights, &none]).expect("lights");
    assert!((two / one - 0.5).abs() < 0.01, "{one} {two}");
    // where no road has one, nobody knows whether the map was looked at
    assert_eq!(per_m(&[&none]), None);
}

/// Two years of hours with every variable, from plain functions of the clock.
fn two_years_of_hours() -> String {
    let mut table =
        "time_s,temperature_c,pressure_hpa,relative_humidity_percent,precipitation_mm_per_h,\
                     wind_speed_mps,wind_direction_deg\n"
            .to_owned();
    for hour in 0..2 * 365 * 24 {
        let h = f64::from(hour);
        let wave = |period: f64| (std::f64::consts::TAU * h / period).sin();
        // 1 on 20 January, and at 3 o'clock
        let cold = |period: f64, at: f64| (std::f64::consts::TAU * (h - at) / period).cos();
        let rain = if hour % 12 < 3 { 0.5 + 0.4 * wave(77.0) } else { 0.0 };
        let _ = writeln!(
            table,
            "{},{:.3},{:.3},{:.3},{rain:.4},{:.3},{:.3}",
            3600 * hour,
            12.25 - 9.0 * cold(8760.0, 480.0) - 2.0 * cold(24.0, 3.0) + 3.0 * wave(131.0),
            1010.0 + 10.0 * wave(173.0),
            75.0 + 15.0 * wave(59.0),
            4.0 + 3.0 * wave(91.0),
            200.0 + 50.0 * wave(213.0)
        );
    }
    table
}

#[test]
fn weather_of_hours_makes_a_study_that_runs() {
    let directory = tempfile::tempdir().expect("a directory");
    let (file, study) = (directory.path().join("hours.csv"), directory.path().join("my.toml"));
    fs::write(&file, two_years_of_hours()).expect("a file");
    let (path, study) = (file.to_str().expect("UTF-8"), study.to_str().expect("UTF-8"));
    let (status, text, notes) = run(&["fit", "weather", path, "--study-out", study]);
    assert_eq!(status, 0, "{notes}");
    for part in ["17520 hours over 2.0 years", "temperature.mean_k", "285.4", "[weather.wind]"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(notes.contains("span 2.0 years"), "{notes}");
    let json: Value =
        serde_json::from_str(&answer(&["fit", "weather", path, "--json"])).expect("JSON");
    // three hours in twelve are wet: two of three wet hours are followed by one, one of nine dry
    // ones
    let rain = &json["study"]["weather"]["precipitation"];
    let share = |key: &str| rain[key].as_f64().expect("a number");
    assert!((share("wet_after_wet") - 2.0 / 3.0).abs() < 1e-3);
    assert!((share("wet_after_dry") - 1.0 / 9.0).abs() < 1e-3);
    let summary = answer(&["--study", study, "--cycles", "2", "--quiet"]);
    assert!(summary.contains("cycles"), "{summary}");

    fs::write(&file, "time_s,temperature_c\n0,5\n").expect("a file");
    let (status, _, message) = run(&["fit", "weather", path]);
    assert_eq!(status, 1);
    assert!(message.contains("temperature: 1 values, at least 48"), "{message}");
}

#[test]
fn traffic_of_detectors_makes_a_study_that_runs() {
    let directory = tempfile::tempdir().expect("a directory");
    let (file, study) = (directory.path().join("traffic.csv"), directory.path().join("my.toml"));
    // ten days: a tenth of the jam density, and a quarter around 7:30
    let mut table = "time_s,road_type,density_share\n".to_owned();
    for step in 0..10 * 96 {
        let hour = f64::from(step % 96) / 4.0;
        let ripple = if step % 2 == 0 { 1.05 } else { 1.0 / 1.05 };
        let peak = (-0.5 * (hour - 7.5) * (hour - 7.5)).exp()
            + (-0.5 * ((hour - 16.5) / 1.2) * ((hour - 16.5) / 1.2)).exp();
        let odds = 0.1 + 0.15 * peak.min(1.0);
        let odds = odds / (1.0 - odds) * ripple;
        let _ = writeln!(table, "{},rural,{}", 900 * step, odds / (1.0 + odds));
    }
    fs::write(&file, table).expect("a file");
    let (path, study) = (file.to_str().expect("UTF-8"), study.to_str().expect("UTF-8"));
    let (status, text, notes) = run(&["fit", "traffic", path, "--study-out", study]);
    assert_eq!(status, 0, "{notes}");
    for part in ["960 densities", "types.rural.peak_share", "[traffic.types.rural]"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    // a ripple that turns over from row to row has no correlation that a step could have
    assert!(notes.contains("the correlation stays"), "{notes}");
    let json: Value =
        serde_json::from_str(&answer(&["fit", "traffic", path, "--json"])).expect("JSON");
    let rural = &json["study"]["traffic"]["types"]["rural"];
    assert!((rural["off_peak_share"].as_f64().expect("a number") - 0.1).abs() < 1e-3);
    assert!((rural["peak_share"].as_f64().expect("a number") - 0.25).abs() < 1e-3);
    assert!(answer(&["--study", study, "--cycles", "2", "--quiet"]).contains("cycles"));
}

/// A log of 10 Hz at 20 m/s on hills of 3 %, with a curve of 100 m every 600 m; then as long once
/// more without slope, yaw rate and limit, `gap_s` later.
fn half_told_log(gap_s: Option<f64>) -> String {
    let mut text = "time_s,speed_mps,yaw_rate_radps,limit_kmh,road_type,grade\n".to_owned();
    for k in 0..9000 {
        let time_s = f64::from(k) / 10.0;
        let yaw = if time_s % 30.0 >= 25.0 { 0.2 } else { 0.0 };
        let limit = if time_s < 450.0 { 70 } else { 50 };
        let grade = 0.03 * (20.0 * time_s / 1000.0 * std::f64::consts::PI).cos();
        let _ = writeln!(text, "{time_s},20,{yaw},{limit},rural,{grade}");
    }
    for k in 0..gap_s.map_or(0, |_| 9000) {
        let time_s = 900.0 + gap_s.unwrap_or_default() + f64::from(k) / 10.0;
        let _ = writeln!(text, "{time_s},20,,,rural,");
    }
    text
}

#[test]
fn what_half_of_a_log_does_not_tell_is_not_taken_for_nothing() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("log.csv");
    let fitted = |text: &str| -> (Value, String) {
        fs::write(&file, text).expect("a file");
        let file = file.to_str().expect("UTF-8");
        let (status, answer, notes) = run(&["fit", "operating-cycle", file, "--json"]);
        assert_eq!(status, 0, "{notes}");
        (serde_json::from_str(&answer).expect("JSON"), notes)
    };
    let value = |json: &Value, key: &str| -> f64 {
        let parameters = json["types"][0]["parameters"].as_array().expect("a list").clone();
        let of = parameters.iter().find(|parameter| parameter["key"] == key);
        of.unwrap_or_else(|| panic!("{key}: {json}"))["value"].as_f64().expect("a number")
    };
    let keys = ["topography.slope_sd", "topography.hill_length_m", "curves.per_m"];
    let (whole, _) = fitted(&half_told_log(None));
    // another road, and the same one
    for (gap_s, allowed) in [(60.0, 1e-9), (0.1, 0.01)] {
        let (half, notes) = fitted(&half_told_log(Some(gap_s)));
        for key in keys {
            let (found, wanted) = (value(&half, key), value(&whole, key));
            assert!((found / wanted - 1.0).abs() <= allowed, "{gap_s} s, {key}: {found} {wanted}");
        }
        let view = |json: &Value, key: &str| json["birds_eye"][key].as_f64().expect("a number");
        let (found, wanted) = (view(&half, "curves_per_km"), view(&whole, "curves_per_km"));
        assert!((found / wanted - 1.0).abs() < 0.01, "{found} {wanted}");
        for part in [
            "rows without slope or altitude: it goes on evenly over up to 200 m",
            "9,000 rows without yaw rate",
            "9,000 rows without a possible speed limit",
        ] {
            assert!(notes.contains(part), "{part}: {notes}");
        }
        if gap_s > 1.0 {
            for face in ["speed_signs.share of 50", "speed_signs.share of 70"] {
                assert!((value(&half, face) - value(&whole, face)).abs() < 1e-9, "{face}");
            }
        }
    }
}

#[test]
fn a_road_without_a_limit_has_no_sign_and_no_type() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("log.csv");
    // two roads of 4 km, a minute apart
    let printed = |header: &str, cells: [&str; 2]| {
        let mut text = format!("time_s,speed_mps{header}\n");
        for k in 0..400 {
            let (at, part) = if k < 200 { (k, 0) } else { (k + 60, 1) };
            let _ = writeln!(text, "{at},20{}", cells[part]);
        }
        fs::write(&file, text).expect("a file");
        let (status, answer, notes) =
            run(&["fit", "operating-cycle", file.to_str().expect("UTF-8")]);
        assert_eq!(status, 0, "{notes}");
        assert!(!answer.contains("share of 0 "), "{answer}");
        (answer, notes)
    };
    let (answer, notes) = printed(",limit_kmh", [",70", ","]);
    assert!(answer.starts_with("1 operating cycle,") && !answer.contains("motorway,"), "{answer}");
    assert!(notes.contains("1 road with neither road type nor speed limit"), "{notes}");
    let (answer, notes) = printed(",limit_kmh,road_type", [",70,rural", ",,urban"]);
    assert!(
        answer.contains("urban, ") && answer.contains("hilliness        not known"),
        "{answer}"
    );
    assert!(notes.contains("urban: no speed limit is known on any of its roads"), "{notes}");
    let (answer, notes) = printed(",limit_kmh,road_type", [",50,rural", ",50,"]);
    assert!(answer.contains("urban, "), "{answer}");
    assert!(notes.contains("1 road without a word in road_type"), "{notes}");
}

/// The answer of a fit of a table, and of the same table between semicolons and tabulators.
fn told_alike(command: &str, table: &str) {
    let directory = tempfile::tempdir().expect("a directory");
    let written = |name: &str, bytes: &[u8]| {
        let path = directory.path().join(name);
        fs::write(&path, bytes).expect("a file");
        let text = answer(&["fit", command, path.to_str().expect("UTF-8"), "--json"]);
        // the file has another name
        let mut answer: Value = serde_json::from_str(&text).expect("JSON");
        answer.as_object_mut().expect("a table").remove("inputs");
        answer
    };
    let plain = written("plain.csv", table.as_bytes());
    assert_eq!(written("semicolons.csv", table.replace(',', ";").as_bytes()), plain, "{command}");
    assert_eq!(written("tabs.csv", table.replace(',', "\t").as_bytes()), plain, "{command}");
}

#[test]
fn tables_of_every_separator_are_read() {
    told_alike("curve-speed", &fs::read_to_string(simulator_curves()).expect("a file"));
    let changes = (1..=12).map(|k| format!("d{k},70-to-40,{}\n", -0.9 - 0.05 * f64::from(k)));
    let changes: String = changes.collect();
    told_alike("speed-change", &format!("driver,category,acceleration_mps2\n{changes}"));
    told_alike("weather", &two_years_of_hours());
}

#[test]
fn a_fitted_study_names_all_its_sources() {
    let directory = tempfile::tempdir().expect("a directory");
    let files: Vec<String> = (0..6)
        .map(|k| {
            let path = directory.path().join(format!("{k}.csv"));
            let rows = (1..=12).map(|row| format!("d{row},{}\n", -0.9 - 0.05 * f64::from(row)));
            let rows: String = rows.collect();
            fs::write(&path, format!("driver,acceleration_mps2\n{rows}")).expect("a file");
            path.to_str().expect("UTF-8").to_owned()
        })
        .collect();
    let out = directory.path().join("mine.toml");
    let out = out.to_str().expect("UTF-8");
    let files: Vec<&str> = files.iter().map(String::as_str).collect();
    answer(&[&["fit", "speed-change", "--study-out", out][..], &files].concat());
    let study = fs::read_to_string(out).expect("a study");
    assert!(study.contains(files[0]) && study.contains(files[3]), "{study}");
    assert!(!study.contains(files[4]) && study.contains(" and 2 more."), "{study}");
}

//! The command as a user meets it: answers, exit statuses, and failures that say what to do.

use crate::program::{SHORT, ocmc};
use serde_json::Value;
use std::fs;

/// Output of a failing command to standard error, after checks of the properties of every failure.
fn failure(arguments: &[&str], status: i32) -> String {
    let output = ocmc(arguments).output().expect("the program starts");
    let message = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {message}");
    assert!(output.stdout.is_empty(), "{arguments:?} has no answer");
    assert!(!message.contains("panicked") && !message.contains("RUST_BACKTRACE"), "{message}");
    assert!(message.contains("error"), "{message}");
    message
}

/// Answer of a command.
fn answer(arguments: &[&str]) -> String {
    let output = ocmc(arguments).assert().success().get_output().clone();
    String::from_utf8(output.stdout).expect("UTF-8")
}

#[test]
fn help_and_version() {
    for arguments in
        [&["--help"][..], &["-h"], &["--version"], &["study", "--help"], &["trace", "--help"]]
    {
        let text = answer(arguments);
        assert!(text.contains("ocmc"), "{text}");
    }
    for option in ["--study", "--set", "--cycles", "--first-cycle", "--seed", "--threads", "--out"]
    {
        assert!(answer(&["--help"]).contains(option), "{option}");
    }
}

#[test]
fn wrong_usage_says_what_is_allowed() {
    for (arguments, part) in [
        (&["--cycles", "0"][..], "from 1 to"),
        (&["--cycles", "-1"], "from 1 to"),
        (&["--cycles", "1.5"], "from 1 to"),
        (&["--cycles", "99999999999999999999"], "from 1 to"),
        (&["--threads", "0"], "from 1 to 1024"),
        (&["--threads", "100000"], "from 1 to 1024"),
        (&["--seed", "x"], "from 0 to"),
        (&["--format", "xml", "--out", "x"], "parquet"),
        (&["--format", "csv"], "--out"),
        (&["--cycle", "5"], "--cycles"),
        (&["--cycles", "288230376151711744"], "from 1 to 288230376151711743"),
        (&["--first-cycle", "18446744073709551615"], "from 0 to 288230376151711742"),
        (&["--first-cycle", "288230376151711742", "--cycles", "2"], "largest cycle id"),
        (&["--cpu-level", "abacus"], "baseline"),
        (&["stduy"], "study"),
        (&["trace"], "--cycle-id"),
        (&["trace", "--cycle-id", "18446744073709551615"], "from 0 to"),
        (&["trace", "--cycle-id", "1", "--out", "x.xlsx"], ".csv"),
        (&["trace", "--cycle-id", "1", "--out", "x.xlsx"], "Usage: ocmc trace"),
        (&["study", "show", "field-truck", "--set", "nonsense=4"], "add --resolved"),
        (&["study", "show", "field-truck", "--set", "nonsense=4"], "Usage: ocmc study show"),
        (&["completions", "dos"], "bash"),
    ] {
        let message = failure(arguments, 2);
        assert!(message.contains(part), "{arguments:?}: {message}");
    }
}

#[test]
fn the_last_cycle_id_can_be_run() {
    let arguments =
        ["--first-cycle", "288230376151711742", "--cycles", "1", "--set", SHORT, "--json"];
    let summary: Value = serde_json::from_str(&answer(&arguments)).expect("JSON");
    assert_eq!(summary["first_cycle"], ocmc_core::random::LAST_CYCLE_ID - 1);
    assert_eq!(summary["cycles"], 1);
}

#[test]
fn wrong_studies_are_explained() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("mine.toml");
    let path = file.to_str().expect("UTF-8");
    fs::write(&file, "[study]\nbase = \"field-truck\"\n\n[mission]\nlenght_m = 5\n")
        .expect("space");
    for arguments in [&["--study", path, "--cycles", "1"][..], &["study", "check", path]] {
        let message = failure(arguments, 1);
        for part in ["mine.toml", "5", "lenght_m", "length_m"] {
            assert!(message.contains(part), "{part}: {message}");
        }
    }
    for (arguments, part) in [
        (&["--study", "field-truk"][..], "field-truck"),
        (&["--study", "/no/such/file.toml"], "/no/such/file.toml"),
        (&["--set", "driver.curve_speed.exponent=x"], "driver.curve_speed.exponent"),
        (&["--set", "mission.length_m=-1"], "mission.length_m"),
        (&["--set", "nonsense"], "nonsense"),
        (&["study", "show", "nowhere"], "nowhere"),
    ] {
        let message = failure(arguments, 1);
        assert!(message.contains(part), "{arguments:?}: {message}");
    }
}

#[test]
fn a_run_prints_its_answer_and_nothing_else_to_standard_output() {
    let output = ocmc(&["--cycles", "400", "--set", SHORT]).output().expect("the program starts");
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    for part in [
        "field-truck",
        "seed",
        "400",
        "km",
        "L/100 km",
        "traction kWh/km",
        "speed",
        "stops per km",
        "P99",
        "█",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(!text.contains('\u{1b}'), "no colours without a terminal");
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    let message = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(message.contains("--out"), "{message}");
    let quiet = ocmc(&["--cycles", "4", "--set", SHORT, "--quiet"]).output().expect("it starts");
    assert!(quiet.stderr.is_empty() && !quiet.stdout.is_empty());
}

#[test]
fn the_columns_of_a_wide_row_are_apart() {
    // litres per tonne-kilometre spread wide where payloads are small
    let text = answer(&["--study", "urban-delivery", "--cycles", "60", "--quiet"]);
    let is_row = |line: &&str| line.contains(" ± ") && !line.contains("adjusted");
    let rows: Vec<&str> = text.lines().filter(is_row).skip(1).collect();
    assert!(rows.iter().any(|row| row.starts_with("L/100 tkm")), "{text}");
    for row in rows {
        let (_, numbers) = row.split_once(" ± ").expect("a mean");
        let numbers: Vec<f64> =
            numbers.split_whitespace().map(|number| number.parse().expect("a number")).collect();
        assert_eq!(numbers.len(), 8, "interval, SD and six quantiles: {row}");
    }
}

#[test]
fn json_has_every_key() {
    let text = answer(&["--cycles", "400", "--set", SHORT, "--json"]);
    let summary: Value = serde_json::from_str(&text).expect("JSON");
    for key in [
        "study",
        "study_hash",
        "seed",
        "first_cycle",
        "cycles",
        "outcomes",
        "distance_m",
        "simulated_s",
        "wall_s",
        "threads",
        "statistics",
    ] {
        assert!(!summary[key].is_null(), "{key}");
    }
    assert_eq!(summary["outcomes"]["completed"], 400);
    let litres = &summary["statistics"]["consumption_l_per_100km"];
    for key in ["mean", "sd", "p5", "p25", "p50", "p75", "p95", "p99"] {
        assert!(litres[key].as_f64().is_some_and(|value| value > 0.0), "{key}");
    }
    for key in ["ci95", "p5_ci95", "p50_ci95", "p99_ci95"] {
        assert_eq!(litres[key].as_array().map(Vec::len), Some(2), "{key}");
    }
    let battery = &summary["statistics"]["consumption_kwh_per_km"];
    assert!(battery["mean"].is_null() && battery["p50"].is_null(), "{battery}");
}

#[test]
fn one_cycle_is_enough() {
    let text = answer(&["--cycles", "1", "--set", SHORT]);
    assert!(text.contains("L/100 km"), "{text}");
    let summary: Value =
        serde_json::from_str(&answer(&["--cycles", "1", "--set", SHORT, "--json"])).expect("JSON");
    assert!(summary["statistics"]["duration_s"]["ci95"].is_null());
}

#[test]
fn an_existing_run_is_not_overwritten() {
    let parent = tempfile::tempdir().expect("a directory");
    let out = parent.path().join("run");
    let path = out.to_str().expect("UTF-8");
    let arguments = ["--cycles", "3", "--set", SHORT, "--out", path];
    ocmc(&arguments).assert().success();
    let before = fs::read(out.join("records.parquet")).expect("written");
    let message = failure(&arguments, 1);
    for part in [path, "already holds a run", "3 of 3 cycles", "help"] {
        assert!(message.contains(part), "{part}: {message}");
    }
    assert_eq!(before, fs::read(out.join("records.parquet")).expect("still there"));
}

#[test]
fn places_that_cannot_be_written_are_named() {
    let parent = tempfile::tempdir().expect("a directory");
    let file = parent.path().join("plain");
    fs::write(&file, "mine").expect("space");
    let path = file.to_str().expect("UTF-8");
    let run = |out: &str| failure(&["--cycles", "2", "--set", SHORT, "--out", out], 1);
    assert!(run(path).contains("not a directory"));
    assert!(run(&format!("{path}/below")).contains(path));
    assert_eq!(fs::read(&file).expect("still there"), b"mine");
    let message = failure(
        &["trace", "--cycle-id", "0", "--set", SHORT, "--out", &format!("{path}/t.csv")],
        1,
    );
    assert!(message.contains(path), "{message}");
    let message = failure(&["study", "init", path], 1);
    assert!(message.contains("exists already"), "{message}");
    let message = failure(&["man", "--out", path], 1);
    assert!(message.contains(path), "{message}");
}

#[test]
#[cfg(unix)]
fn a_read_only_directory_is_named() {
    use std::os::unix::fs::PermissionsExt;
    let parent = tempfile::tempdir().expect("a directory");
    let closed = parent.path().join("closed");
    fs::create_dir(&closed).expect("space");
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o555)).expect("it is ours");
    if fs::write(closed.join("probe"), "").is_ok() {
        eprintln!("not tested: this user may write everywhere");
        return;
    }
    for out in [closed.clone(), closed.join("below")] {
        let out = out.to_str().expect("UTF-8");
        let message = failure(&["--cycles", "2", "--set", SHORT, "--out", out], 1);
        assert!(message.contains("closed") && message.contains("ermission"), "{message}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_directory_that_the_system_refuses_is_named() {
    let message = failure(&["--cycles", "2", "--set", SHORT, "--out", "/proc/ocmc-run"], 1);
    assert!(message.contains("/proc/ocmc-run"), "{message}");
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_told() {
    use std::process::{Command, Stdio};
    let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("Linux has it");
    let run = Command::new(env!("CARGO_BIN_EXE_ocmc"))
        .args(["--cycles", "2", "--set", SHORT])
        .stdout(full)
        .stderr(Stdio::piped())
        .output()
        .expect("the program starts");
    let message = String::from_utf8(run.stderr).expect("UTF-8");
    assert_eq!(run.status.code(), Some(1), "{message}");
    assert!(message.contains("standard output") && message.contains("No space left"), "{message}");
    let message = failure(&["trace", "--cycle-id", "0", "--set", SHORT, "--out", "/dev/full"], 2);
    assert!(message.contains(".csv"), "{message}");
}

#[test]
fn a_closed_pipe_is_success() {
    use std::process::{Command, Stdio};
    let trace = ["trace", "--cycle-id", "0", "--set", SHORT];
    for arguments in
        [&["--cycles", "2", "--set", SHORT][..], &trace, &["study", "schema"], &["--help"]]
    {
        let mut run = Command::new(env!("CARGO_BIN_EXE_ocmc"))
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        drop(run.stdout.take());
        let output = run.wait_with_output().expect("it ends");
        let message = String::from_utf8(output.stderr).expect("UTF-8");
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {message}");
        assert!(!message.contains("panicked"), "{message}");
    }
}

#[test]
fn studies_are_listed_shown_written_and_checked() {
    let list = answer(&["study", "list"]);
    assert!(list.lines().next().is_some_and(|line| line.starts_with("field-truck ")), "{list}");
    assert!(answer(&["study", "show", "long-haul"]).contains("[study]"));
    let resolved =
        answer(&["study", "show", "--resolved", "long-haul", "--set", "mission.length_m=7000"]);
    assert!(resolved.contains("7000"), "{resolved}");
    let line = resolved.lines().find(|line| line.starts_with("curb_mass_kg")).expect("a key");
    assert!(line.contains("# ") && line.ends_with("| 500 to 100000"), "{line}");
    let vehicles = answer(&["study", "vehicles"]);
    assert!(vehicles.lines().any(|line| line.starts_with("rigid-12t ")), "{vehicles}");
    let schema: Value = serde_json::from_str(&answer(&["study", "schema"])).expect("JSON");
    assert!(schema["properties"]["road"].is_object());

    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("mine.toml");
    let path = file.to_str().expect("UTF-8");
    ocmc(&["study", "init", path]).assert().success();
    assert_eq!(answer(&["study", "show", path]), fs::read_to_string(&file).expect("written"));
    assert!(answer(&["study", "check", path]).contains("valid"));
    assert!(answer(&["--study", path, "--cycles", "1", "--set", SHORT]).contains("mine.toml"));
}

#[test]
fn a_trace_ends_where_its_record_does() {
    let directory = tempfile::tempdir().expect("a directory");
    let out = directory.path().join("run");
    crate::program::run_into(&out, &["--cycles", "4", "--seed", "3"]);
    let records = crate::program::records(&out.join("records.parquet"));
    let record = &records[3];
    let trace = |extra: &[&str]| {
        let arguments = ["trace", "--set", SHORT, "--seed", "3", "--cycle-id", "3"];
        answer(&[&arguments, extra].concat())
    };
    let csv = trace(&[]);
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let headers = reader.headers().expect("a header").clone();
    let place = |name: &str| headers.iter().position(|header| header == name).expect("a column");
    let (time, distance) = (place("time_s"), place("distance_added_m"));
    let rows: Vec<csv::StringRecord> = reader.records().map(|row| row.expect("a row")).collect();
    let number = |row: &csv::StringRecord, k: usize| row[k].parse::<f64>().expect("a number");
    let driven: f64 = rows.iter().map(|row| number(row, distance)).sum();
    assert_eq!(driven.to_bits(), record.distance_m.to_bits(), "{driven} {}", record.distance_m);
    let end = number(rows.last().expect("rows"), time);
    assert!((end / record.duration_s - 1.0).abs() < 1e-9, "{end} {}", record.duration_s);

    let file = directory.path().join("trace.json");
    trace(&["--out", file.to_str().expect("UTF-8")]);
    let json: Value =
        serde_json::from_str(&fs::read_to_string(&file).expect("written")).expect("JSON");
    assert_eq!(json["time_s"].as_array().map(Vec::len), Some(rows.len()));
}

#[test]
fn completions_and_manual_pages() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        assert!(answer(&["completions", shell]).contains("ocmc"), "{shell}");
    }
    let directory = tempfile::tempdir().expect("a directory");
    let pages = directory.path().join("man");
    ocmc(&["man", "--out", pages.to_str().expect("UTF-8")]).assert().success();
    let page = fs::read_to_string(pages.join("ocmc.1")).expect("written");
    assert!(page.contains("cycles"), "{page}");
    assert!(pages.join("ocmc-trace.1").exists());
    let page = fs::read_to_string(pages.join("ocmc-compare.1")).expect("written");
    let synopsis = page.split(".SH").find(|part| part.starts_with(" SYNOPSIS")).expect("one");
    for named in ["KEY=VALUE", "NAME|FILE", "<N>"] {
        assert!(synopsis.contains(named), "{named}: {synopsis}");
    }
}

#[test]
fn cycles_that_could_not_be_driven_are_counted_by_reason() {
    let arguments = |longest: &str, cycles: &str| {
        let longest = format!("simulation.longest_duration_s={longest}");
        answer(&["--cycles", cycles, "--set", SHORT, "--set", &longest])
    };
    let text = arguments("400", "100");
    for part in ["Not completed: ", "timed_out", "in no mean", "Worst case", "L/100 km"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let text = arguments("203", "20");
    assert!(text.contains("Not completed: 20 of 20 cycles (100.00 %): 20 timed_out"), "{text}");
    assert!(!text.contains("NaN") && !text.contains("Worst case"), "{text}");
}

#[test]
fn tables_go_to_standard_output_as_json_too() {
    let folder = tempfile::tempdir().expect("a directory");
    let file = folder.path().join("cycle.json").display().to_string();
    for command in ["cycle", "trace"] {
        let of = ["--cycle-id", "3", "--set", SHORT];
        ocmc(&[&[command][..], &of, &["--out", &file]].concat()).assert().success();
        let printed = ocmc(&[&[command, "--json", "--quiet"][..], &of].concat()).assert().success();
        assert_eq!(printed.get_output().stdout, fs::read(&file).expect("written"), "{command}");
    }
    ocmc(&["cycle", "--cycle-id", "3", "--json", "--out", &file]).assert().code(2);
    for arguments in [&["study", "list"][..], &["study", "check", "field-truck"]] {
        let printed = ocmc(&[arguments, &["--json", "--quiet"]].concat()).assert().success();
        let all: Value = serde_json::from_slice(&printed.get_output().stdout).expect("JSON");
        assert_eq!(all[0]["name"], "field-truck");
    }
}

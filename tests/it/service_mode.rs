//! A program that runs studies of strangers: `--no-files` opens nothing, nothing waits for a pipe,
//! and what a file says is not obeyed by a terminal or a spreadsheet.
#![cfg(unix)]

use crate::program::{SHORT, ocmc, run_into};
use ocmc_io::given_cycle;
use ocmc_io::study::{load, resolved_toml};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// Files that strangers would like to read, or to have read without end.
const FILES: [&str; 10] = [
    "/etc/passwd",
    "/etc/no-such-file",
    "../../../../../../etc/hostname",
    "/proc/self/environ",
    "/dev/zero",
    "/dev/stdin",
    "-",
    "~/.ssh/id_rsa",
    "a.csv",
    "/dev/fd/0",
];

/// Studies that name a file, each under a key that may name one.
fn hostile(file: &str) -> Vec<String> {
    let file = format!("{file:?}");
    let table = |table: &str, key: &str, value: &str| {
        format!("study.base = \"field-truck\"\n[{table}]\n{key} = {value}\n")
    };
    let keys = ["direct", "indirect", "axle", "retarder"].map(|name| format!("{name}_loss_file"));
    let columns = format!("{{ file = {file}, columns = {{ torque_nm = \"a\" }} }}");
    let mut studies: Vec<String> =
        keys.iter()
            .map(|key| table("vehicle.powertrain.combustion.gearbox", key, &file))
            .chain(
                [&file, &columns]
                    .map(|value| table("vehicle.powertrain.combustion.engine", "map_file", value)),
            )
            .chain([&file, &columns].map(|value| {
                table("vehicle.powertrain.combustion.engine", "full_load_file", value)
            }))
            .collect();
    studies.push(format!("study.base = {file}\n"));
    studies.push(format!("vehicle.base = {file}\nstudy.base = \"field-truck\"\n"));
    studies.push(format!("study.base = {file}\nvehicle.base = {file}\nroad.types = {{}}\n"));
    for weight in [1, 2] {
        let route = format!("[{{ file = {file}, weight = {weight} }}]");
        studies.push(table("mission", "routes", &route));
    }
    for (keep, columns) in [("weather", ""), ("traffic", ""), ("mission", ", columns = {}")] {
        let route = format!("[{{ file = {file}, weight = 1, keep = [\"{keep}\"]{columns} }}]");
        studies.push(table("mission", "routes", &route));
    }
    let mixed = "[{ file = \"built-in/simulator-slopes.csv\", weight = 1 }, ";
    studies.push(table("mission", "routes", &format!("{mixed}{{ file = {file}, weight = 1 }}]")));
    studies.push(table(
        "mission",
        "routes",
        &format!("[{{ file = {file}, weight = 1, sha256 = \"00\" }}]"),
    ));
    studies.push(format!("study.base = \"field-truck\"\nvehicle = {{ base = {file} }}\n"));
    studies.push(format!("study = {{ base = {file}, drop = [\"road\"] }}\n"));
    studies
}

/// The files that a command touches in any way, with a study on its standard input.
fn touched(arguments: &[&str], study: &Path, log: &Path) -> (BTreeSet<String>, String) {
    let output = Command::new("strace")
        .args(["-f", "-qq", "-e", "trace=%file", "-e", "signal=none", "-o"])
        .arg(log)
        .arg(env!("CARGO_BIN_EXE_ocmc"))
        .args(arguments)
        .stdin(fs::File::open(study).expect("written"))
        .output()
        .expect("strace starts");
    let log = fs::read_to_string(log).expect("written");
    let calls = log.lines().filter(|line| !line.contains("execve("));
    let names = calls.filter_map(|line| Some(line.split('"').nth(1)?.to_owned()));
    (names.collect(), String::from_utf8(output.stderr).expect("UTF-8"))
}

#[test]
#[cfg(target_os = "linux")]
fn hostile_studies_open_nothing_that_a_built_in_study_does_not_open() {
    let runs = Command::new("strace").args(["-o", "/dev/null", "true"]).output();
    if !runs.is_ok_and(|output| output.status.success()) {
        crate::others_data::skipped("no strace, or it may not trace");
        return;
    }
    let folder = tempfile::tempdir().expect("a directory");
    let (study, log) = (folder.path().join("study"), folder.path().join("log"));
    let commands: [&[&str]; 2] = [
        &["study", "check", "-", "--no-files"],
        &["--study", "-", "--no-files", "--cycles", "1", "--threads", "1", "--quiet"],
    ];
    let harmless = format!("study.base = \"field-truck\"\n{SHORT}\n");
    let allowed = commands.map(|command| {
        fs::write(&study, &harmless).expect("space");
        let (names, said) = touched(command, &study, &log);
        assert_eq!(said, "");
        names
    });
    let studies: Vec<String> = FILES.iter().flat_map(|file| hostile(file)).collect();
    assert_eq!(studies.len(), 200);
    for (k, text) in studies.iter().enumerate() {
        let which = usize::from(k % 7 == 0);
        fs::write(&study, text).expect("space");
        let (names, said) = touched(commands[which], &study, &log);
        let more: Vec<&String> = names.difference(&allowed[which]).collect();
        assert!(more.is_empty(), "{text}: {more:?}");
        assert!(said.contains("no file may be read here"), "{text}: {said}");
    }
}

#[test]
fn nobody_learns_whether_a_file_is_there() {
    let said = |file: &str| {
        let study = format!("study.base = \"{file}\"\n");
        let output = ocmc(&["study", "check", "-", "--no-files"]).write_stdin(study).output();
        let output = output.expect("it starts");
        assert_eq!(output.status.code(), Some(1));
        String::from_utf8(output.stderr).expect("UTF-8").replace(file, "X")
    };
    assert_eq!(said("/etc/passwd"), said("/etc/passwx"));
    assert!(said("/etc/passwd").contains("there are: `field-truck`"));
    // on the command line, too
    for arguments in [
        &["study", "check", "/etc/passwd", "--no-files"][..],
        &["study", "show", "/etc/passwd", "--no-files"],
        &["--study", "/etc/passwd", "--no-files"],
        &["--set", "vehicle.base=\"/etc/passwd\"", "--no-files"],
        &["compare", "field-truck", "/etc/passwd", "--no-files"],
        &["sensitivity", "--study", "/etc/passwd", "--no-files"],
        &["trace", "--cycle-id", "0", "--study", "/etc/passwd", "--no-files"],
    ] {
        let output = ocmc(arguments).output().expect("it starts");
        let said = String::from_utf8(output.stderr).expect("UTF-8");
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {said}");
        assert!(said.contains("no file may be read here"), "{arguments:?}: {said}");
        assert!(!said.contains("root:"), "{said}");
    }
    ocmc(&["drive", "a.csv", "--no-files"]).assert().code(2);
    for job in ["a.vecto", "/etc/passwd.vecto"] {
        let output = ocmc(&["vecto", job, "--no-files"]).output().expect("it starts");
        assert_eq!(output.status.code(), Some(1));
        let said = String::from_utf8(output.stderr).expect("UTF-8");
        assert!(said.contains("is a job, which names files"), "{said}");
    }
}

#[test]
fn a_base_that_is_no_study_is_not_quoted() {
    let folder = tempfile::tempdir().expect("a directory");
    let (study, secret) = (folder.path().join("a.toml"), folder.path().join("secret"));
    fs::write(&secret, "first line\nroot:x:0:0:hidden\n").expect("space");
    fs::write(&study, format!("study.base = {:?}\n", secret.to_str().expect("UTF-8")))
        .expect("space");
    let output = ocmc(&["study", "check"]).arg(&study).output().expect("it starts");
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(said.contains("secret:1:7: not valid TOML"), "{said}");
    assert!(!said.contains("first line") && !said.contains("hidden"), "{said}");
    // what the user names himself is shown
    let output = ocmc(&["study", "check"]).arg(&secret).output().expect("it starts");
    assert!(String::from_utf8_lossy(&output.stderr).contains("first line"));
}

/// Letters that a terminal obeys.
fn is_obeyed(text: &str) -> bool {
    text.chars().any(|letter| letter.is_control() && letter != '\n' && letter != '\t')
}

#[test]
fn what_a_terminal_would_obey_is_refused_in_names_and_spelled_out_elsewhere() {
    let folder = tempfile::tempdir().expect("a directory");
    let study = folder.path().join("a\u{1b}[31m\n.toml");
    for (text, key) in [
        ("study.base = \"field-truck\"\nstudy.name = \"\\u001b[2J\"\n", "study.name"),
        ("study.base = \"field-truck\"\nstudy.name = \"a\\nb\"\n", "study.name"),
        ("study.base = \"field-truck\"\nstudy.name = \"\\u202egro\"\n", "study.name"),
        ("study.base = \"field-truck\"\nstudy.description = \"\\u0007\"\n", "study.description"),
        ("study.base = \"field-truck\"\n[road.types.\"\\u001b[2J\"]\n", "hidden letters"),
        ("study.base = \"field-truck\"\n[road]\n\"\\u009b2J\" = 1\n", "hidden letters"),
    ] {
        fs::write(&study, text).expect("space");
        let output = ocmc(&["study", "check"]).arg(&study).output().expect("it starts");
        let said = String::from_utf8(output.stderr).expect("UTF-8");
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains(key) && said.contains("letters that are shown"), "{said}");
        assert!(!is_obeyed(&said), "{said:?}");
    }
    // cells, columns, and a study as it is written
    let table = folder.path().join("\u{1b}]0;x\u{7}.csv");
    fs::write(&table, "road_type,hour,\u{1b}[2J\n\u{1b}[31m,\u{1b}[2J,\u{9b}2J\n").expect("space");
    for command in ["traffic", "weather", "curve-speed", "speed-change"] {
        let output = ocmc(&["fit", command]).arg(&table).output().expect("it starts");
        let said = String::from_utf8(output.stderr).expect("UTF-8");
        assert!(!output.status.success() && !is_obeyed(&said), "{said:?}");
    }
    fs::write(&study, "# \u{1b}[2J\n").expect("space");
    let output = ocmc(&["study", "show"]).arg(&study).output().expect("it starts");
    assert_eq!(String::from_utf8_lossy(&output.stdout), "# \\u001b[2J\n");
}

#[test]
fn nothing_waits_for_a_pipe_or_reads_a_device() {
    let folder = tempfile::tempdir().expect("a directory");
    let (pipe, run) = (folder.path().join("pipe.csv"), folder.path().join("run"));
    assert!(Command::new("mkfifo").arg(&pipe).status().expect("it starts").success());
    run_into(&run, &["--cycles", "3", "--format", "csv"]);
    for file in ["manifest.json", "records.csv", "summary.json", "checksums.sha256"] {
        let there = run.join(file);
        let kept = fs::read(&there).expect("written");
        fs::remove_file(&there).expect("ours");
        assert!(Command::new("mkfifo").arg(&there).status().expect("it starts").success());
        for command in [&["report"][..], &["verify"], &["--resume", "--out"]] {
            refused_at_once(command, &run);
        }
        fs::remove_file(&there).expect("ours");
        fs::write(&there, kept).expect("space");
    }
    let study = folder.path().join("a.toml");
    fs::write(&study, "study.base = \"pipe.csv\"\n").expect("space");
    refused_at_once(&["study", "check"], &study);
    for path in [&pipe, Path::new("/dev/zero")] {
        for command in [
            &["study", "check"][..],
            &["drive"],
            &["drive", "--follow-speed", "exact"],
            &["curves"],
            &["identify"],
            &["fit", "curve-speed"],
            &["fit", "speed-change"],
            &["fit", "operating-cycle"],
            &["fit", "weather"],
            &["fit", "traffic"],
        ] {
            refused_at_once(command, path);
        }
    }
}

fn refused_at_once(command: &[&str], path: &Path) {
    let begun = Instant::now();
    let output = ocmc(command).arg(path).timeout(Duration::from_secs(20)).output();
    let output = output.expect("it starts");
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    let said = said + &String::from_utf8_lossy(&output.stdout);
    let took = begun.elapsed();
    assert_eq!(output.status.code(), Some(1), "{command:?} {} {took:?}: {said}", path.display());
    assert!(said.contains("a pipe, a socket or a device"), "{said}");
}

#[test]
fn words_that_a_spreadsheet_would_evaluate_are_marked_and_read_back() {
    let folder = tempfile::tempdir().expect("a directory");
    let (study, cycle) = (folder.path().join("a.toml"), folder.path().join("cycle.csv"));
    let text = resolved_toml(&load("field-truck", &[SHORT]).expect("built in").model);
    let name = "\"=1+1, @a\"";
    let text = text.replace(".types.urban", &format!(".types.{name}"));
    fs::write(&study, text.replace("\nurban = ", &format!("\n{name} = "))).expect("space");
    let draw = |id: usize| {
        let id = id.to_string();
        let mut command = ocmc(&["cycle", "--cycle-id", &id, "--study"]);
        command.arg(&study).arg("--out").arg(&cycle).assert().success();
        fs::read_to_string(&cycle).expect("written")
    };
    let has_name = |written: &String| written.contains(",\"'=1+1, @a\"\n");
    let written = (0..40).map(draw).find(has_name).expect("a road of that type");
    let formula = |line: &str| {
        let cell = line.splitn(4, ',').nth(3).unwrap_or_default().trim_start_matches('"');
        cell.starts_with(['=', '+', '@']) || (cell.starts_with('-') && cell.parse::<f64>().is_err())
    };
    assert!(!written.lines().any(formula), "{written}");
    let read = given_cycle::read(&cycle, &[]).expect("an operating cycle");
    assert!(format!("{read:?}").contains("\"=1+1, @a\""));
    ocmc(&["drive", "--cycles", "2", "--study"]).arg(&study).arg(&cycle).assert().success();
}

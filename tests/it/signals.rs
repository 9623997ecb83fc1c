//! Endings of a run, and the worth of its directory then: the table of the guide
//! (`docs/src/how-to/ended-runs.md`).
#![cfg(target_os = "linux")]

use std::fs;
use std::hash::{BuildHasher, Hasher};
use std::io;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A run that lasts seconds, with chunks that do not: one command for every start.
const RUN: [&str; 13] = [
    "--set",
    "mission.length_m=200",
    "--cycles",
    "6_000",
    "--threads",
    "1",
    "--seed",
    "7",
    "--chunk",
    "64",
    "--quiet",
    "--resume",
    "--out",
];

/// Signals as a terminal's shell leaves them: the tests themselves may run under `nohup`.
const BY_DEFAULT: [&str; 2] = ["env", "--default-signal=HUP,INT,TERM"];

/// Begins the run, or what is left of it, behind other programs: `nohup`, `setsid`, `timeout`.
fn begin(before: &[&str], out: &Path) -> Child {
    let program = [&BY_DEFAULT[..], before, &[env!("CARGO_BIN_EXE_ocmc")]].concat();
    Command::new(program[0])
        .args(&program[1..])
        .args(RUN)
        .arg(out)
        .current_dir(out.parent().expect("a directory"))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts")
}

fn send(signal: &str, run: &Child) {
    let sent = Command::new("kill").args([&format!("-{signal}"), &run.id().to_string()]).status();
    assert!(sent.expect("kill starts").success());
}

/// Waits until the run has kept something.
fn until_begun(out: &Path) {
    let begun = Instant::now();
    while !out.join("chunks/00000000.parquet").exists() && !out.join("summary.json").exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "no chunk");
        sleep(Duration::from_millis(2));
    }
}

/// The status that a shell shows.
fn status(status: ExitStatus) -> i32 {
    status.code().or(status.signal().map(|signal| 128 + signal)).expect("it has ended")
}

/// Finishes the run by the same command, and compares it with one that was never ended.
fn finish(out: &Path, whole: &Path) {
    assert!(begin(&[], out).wait().expect("it ends").success());
    for file in ["records.parquet", "manifest.json"] {
        let read = |run: &Path| fs::read(run.join(file)).expect("written");
        assert!(read(whole) == read(out), "{file} of {}", out.display());
    }
    let name = |entry: io::Result<fs::DirEntry>| entry.expect("there").file_name();
    let mut files: Vec<_> = fs::read_dir(out).expect("there").map(name).collect();
    files.sort();
    let written = ["checksums.sha256", "manifest.json", "records.parquet", "summary.json"];
    assert_eq!(files, written, "no remnants");
}

#[test]
fn what_ends_a_run_and_what_does_not() {
    let folder = tempfile::tempdir().expect("a directory");
    let whole = folder.path().join("whole");
    assert!(begin(&[], &whole).wait().expect("it ends").success());
    // what stands before the command, signals, and the status of the run
    let table: [(&[&str], &[&str], i32); 13] = [
        (&[], &["INT"], 130),
        (&[], &["TERM"], 143),
        (&[], &["HUP"], 129),
        (&[], &["INT", "INT"], 130),
        (&[], &["TERM", "TERM"], 143),
        (&[], &["TERM", "KILL"], 137),
        (&[], &["KILL"], 137),
        (&["nohup"], &["HUP"], 0),
        (&["nohup"], &["HUP", "TERM"], 143),
        (&["setsid"], &["TERM"], 143),
        (&["sh", "-c", "trap '' INT; exec \"$@\"", "sh"], &["INT"], 0),
        (&["timeout", "0.1"], &[], 124),
        (&["timeout", "--preserve-status", "-s", "INT", "0.1"], &[], 130),
    ];
    for (k, (before, signals, wanted)) in table.into_iter().enumerate() {
        let out = folder.path().join(format!("{k}"));
        let mut run = begin(before, &out);
        if !signals.is_empty() {
            until_begun(&out);
        }
        for signal in signals {
            send(signal, &run);
        }
        let found = status(run.wait().expect("it ends"));
        // a run that is asked to stop may be ended by force before it has stopped, or after
        let late = signals.last() == Some(&"KILL") && signals.len() > 1 && found == 143;
        assert!(found == wanted || late, "{before:?} {signals:?}: {found}, not {wanted}");
        println!("{before:?} {signals:?}: {found}");
        finish(&out, &whole);
    }
}

#[test]
fn questions_are_ended_with_the_status_of_the_signal() {
    // each of them works on for many seconds
    let questions: [&[&str]; 4] = [
        &["bound", "--cycles", "4"],
        &["simulator-study", "--repetitions", "1000"],
        &["calibrate", "curve-speed", "field-truck-printed", "--drivers", "2000"],
        &["sensitivity", "--cycles", "1_000_000"],
    ];
    for question in questions {
        for (signal, wanted) in [("INT", 130), ("TERM", 143)] {
            let program = [&BY_DEFAULT[..], &[env!("CARGO_BIN_EXE_ocmc")], question].concat();
            let (quiet, piped) = (Stdio::null, Stdio::piped());
            let mut run = Command::new(program[0])
                .args(&program[1..])
                .stdin(quiet())
                .stdout(quiet())
                .stderr(piped)
                .spawn()
                .expect("it starts");
            sleep(Duration::from_millis(300));
            assert!(run.try_wait().expect("ours").is_none(), "{question:?} is under way");
            send(signal, &run);
            let sent = Instant::now();
            assert_eq!(status(run.wait().expect("it ends")), wanted, "{question:?}");
            // a second is promised: a busy machine may be late, work of many seconds is not over
            assert!(sent.elapsed() < Duration::from_secs(5), "{question:?}: {:?}", sent.elapsed());
        }
    }
}

#[test]
fn a_second_signal_after_half_a_second_ends_the_program() {
    let folder = tempfile::tempdir().expect("a directory");
    let out = folder.path().join("a");
    let mut run = begin(&[], &out);
    until_begun(&out);
    send("TERM", &run);
    sleep(Duration::from_millis(600));
    if run.try_wait().expect("ours").is_none() {
        send("INT", &run);
    }
    assert!([143, 130].contains(&status(run.wait().expect("it ends"))));
}

/// Kills a run at random moments, again and again; `OCMC_KILLS=100` kills so often.
#[test]
fn a_run_that_is_killed_at_any_moment_goes_on_by_the_same_command() {
    let kills = std::env::var("OCMC_KILLS").map_or(12, |kills| kills.parse().expect("a number"));
    let folder = tempfile::tempdir().expect("a directory");
    let whole = folder.path().join("whole");
    let begun = Instant::now();
    assert!(begin(&[], &whole).wait().expect("it ends").success());
    let most_ms = begun.elapsed().as_millis() as u64;
    let (mut killed, mut runs) = (0, 0);
    while killed < kills {
        let out = folder.path().join(format!("{runs}"));
        // a run is killed up to five times before it may end
        for _ in 0..5.min(kills - killed) {
            let mut run = begin(&[], &out);
            let random = std::hash::RandomState::new().build_hasher().finish();
            sleep(Duration::from_millis(random % most_ms));
            let ended = run.try_wait().expect("ours").is_some();
            if ended {
                break;
            }
            run.kill().expect("ours");
            run.wait().expect("it ends");
            killed += 1;
        }
        finish(&out, &whole);
        fs::remove_dir_all(&out).expect("ours");
        runs += 1;
    }
    println!("{killed} kills of {runs} runs, each became the whole run");
}

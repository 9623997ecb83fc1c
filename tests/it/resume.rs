//! Runs that survive: whatever ends a run, `--resume` makes of it the bytes of a run that was never
//! ended.

use crate::program::{change_manifest, ocmc, records, seal};
use serde_json::Value;
use std::collections::hash_map::RandomState;
use std::fmt::Write as _;
use std::fs;
use std::hash::{BuildHasher, Hasher};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// The shortest cycles that a study may have.
const TINY: &str = "mission.length_m=200";

/// Begins a run of tiny cycles into a directory.
fn begin(out: &Path, arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_ocmc"))
        .args(arguments)
        .args(["--set", TINY, "--quiet", "--out"])
        .arg(out)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts")
}

/// Begins to resume a run.
fn begin_again(out: &Path) -> Child {
    Command::new(env!("CARGO_BIN_EXE_ocmc"))
        .args(["--resume", "--quiet", "--out"])
        .arg(out)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts")
}

/// Message of a failing `--resume`.
fn refused(out: &Path) -> String {
    let output = begin_again(out).wait_with_output().expect("it ends");
    let message = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(!message.contains("panicked"), "{message}");
    message
}

fn whole(out: &Path, arguments: &[&str]) {
    assert!(begin(out, arguments).wait().expect("it ends").success());
}

fn resume(out: &Path) {
    let output = begin_again(out).wait_with_output().expect("it ends");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).expect("written")).expect("JSON")
}

fn manifest(out: &Path) -> Value {
    json(&out.join("manifest.json"))
}

/// Presses Ctrl-C, and returns what the program tells and how long it takes to end.
#[cfg(unix)]
fn interrupt(run: Child) -> (String, Duration) {
    let asked = std::time::Instant::now();
    let kill = Command::new("kill").args(["-INT", &run.id().to_string()]).status();
    assert!(kill.expect("kill starts").success());
    let output = run.wait_with_output().expect("it ends");
    let message = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(130), "{message}");
    assert!(message.contains("interrupted") && message.contains("--resume"), "{message}");
    (message, asked.elapsed())
}

fn assert_same(expected: &Path, out: &Path, records: &str) {
    for file in [records, "manifest.json"] {
        let read = |directory: &Path| fs::read(directory.join(file)).expect("written");
        assert!(read(expected) == read(out), "{file} of {}", out.display());
    }
    assert_eq!(fs::read_dir(out).expect("there").count(), 4, "no remnants");
}

/// Another moment in each run of the tests, up to that many milliseconds.
fn random_moment(most_ms: u64) -> Duration {
    Duration::from_millis(RandomState::new().build_hasher().finish() % most_ms)
}

/// Ends the run by force at random moments, over and over, until it is complete or has been ended
/// so often.
fn kill_until_complete(out: &Path, arguments: &[&str], times: usize, most_ms: u64) {
    let mut run = begin(out, arguments);
    for _ in 0..times {
        let moment = random_moment(most_ms);
        std::thread::sleep(moment);
        run.kill().expect("it is ours");
        run.wait().expect("it ends");
        let done = match fs::exists(out.join("manifest.json")) {
            Ok(true) => manifest(out)["completed"].to_string(),
            _ => "no manifest".to_owned(),
        };
        eprintln!("killed after {moment:?}: {done}");
        if done == "no manifest" {
            // ended before it began: there is nothing to resume, and nothing in the way
            run = begin(out, arguments);
        } else {
            run = begin_again(out);
        }
    }
    let output = run.wait_with_output().expect("it ends");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_run_that_is_killed_at_random_moments_becomes_the_whole_run() {
    let parent = tempfile::tempdir().expect("a directory");
    for (format, file) in [("parquet", "records.parquet"), ("csv", "records.csv")] {
        let arguments = ["--cycles", "8000", "--first-cycle", "7", "--format", format];
        let expected = parent.path().join(format!("{format}-whole"));
        whole(&expected, &arguments);
        let out = parent.path().join(format!("{format}-killed"));
        kill_until_complete(&out, &arguments, 4, 1000);
        assert_same(&expected, &out, file);
    }
}

#[test]
fn so_does_one_that_ends_at_a_precision() {
    let parent = tempfile::tempdir().expect("a directory");
    let (expected, out) = (parent.path().join("whole"), parent.path().join("killed"));
    let arguments = ["--precision", "0.3%"];
    whole(&expected, &arguments);
    assert!(manifest(&expected)["cycles"].as_u64() > Some(1000), "several looks");
    kill_until_complete(&out, &arguments, 5, 1000);
    assert_same(&expected, &out, "records.parquet");
    // what the precision is, too, be the program ended after the last chunk or before
    let precision = |directory: &Path| json(&directory.join("summary.json"))["precision"].clone();
    assert!(precision(&out).is_object() && precision(&out) == precision(&expected));
}

/// A drive cycle of an hour, and a route of 2 km.
fn given_files(folder: &Path) -> [String; 2] {
    let mut cycle = "time_s,speed_mps,slope\n0,0,0\n".to_owned();
    for k in 1..3600_u32 {
        let speed = 0.1 * f64::from((k % 300).min(150));
        let slope = 0.01 * f64::from(k / 100 % 3) - 0.01;
        writeln!(cycle, "{k},{speed},{slope}").expect("a string takes any text");
    }
    let mut route = "position_m,speed_limit_kmh,grade\n".to_owned();
    for k in 0..=40 {
        writeln!(route, "{},60,0.01", 50 * k).expect("a string takes any text");
    }
    [("cycle.csv", cycle), ("route.csv", route)].map(|(name, text)| {
        let path = folder.join(name);
        fs::write(&path, text).expect("space");
        path.display().to_string()
    })
}

#[test]
fn so_does_one_that_follows_a_speed() {
    let parent = tempfile::tempdir().expect("a directory");
    let [cycle, route] = given_files(parent.path());
    for (name, file, how, cycles) in [
        ("cycle", &cycle, "exact", "1300"),
        ("driven", &cycle, "driver", "1100"),
        ("planned", &route, "exact", "4000"),
    ] {
        let arguments = ["drive", file, "--follow-speed", how, "--cycles", cycles];
        let (expected, out) =
            (parent.path().join(name), parent.path().join(format!("{name}-killed")));
        whole(&expected, &arguments);
        kill_until_complete(&out, &arguments, 4, 400);
        assert_same(&expected, &out, "records.parquet");
    }
}

#[test]
fn the_manifest_of_a_followed_cycle_is_all_that_it_takes() {
    let parent = tempfile::tempdir().expect("a directory");
    let [cycle, _] = given_files(parent.path());
    for how in ["exact", "driver"] {
        let expected = parent.path().join(how);
        let arguments = ["drive", &cycle, "--follow-speed", how, "--cycles", "20", "--seed", "5"];
        whole(&expected, &arguments);
        // its parts written out again, elsewhere
        let elsewhere = tempfile::tempdir().expect("a directory");
        let held = manifest(&expected);
        let study = elsewhere.path().join("study.toml");
        fs::write(&study, held["resolved_study"].as_str().expect("a text")).expect("space");
        let copy = elsewhere.path().join("cycle.csv");
        fs::write(&copy, held["followed"]["cycle"].as_str().expect("a text")).expect("space");
        let out = elsewhere.path().join("run");
        let (study, copy) = (study.display().to_string(), copy.display().to_string());
        let message =
            ocmc(&["drive", &copy, "--follow-speed", how, "--cycles", "20", "--seed", "5"])
                .args(["--study", &study, "--quiet", "--out"])
                .arg(&out)
                .output();
        assert!(message.expect("it starts").status.success());
        let bytes = |folder: &Path| fs::read(folder.join("records.parquet")).expect("written");
        assert!(bytes(&expected) == bytes(&out), "{how}");
    }
}

#[test]
fn files_behind_resume_have_to_be_those_of_the_run() {
    let parent = tempfile::tempdir().expect("a directory");
    let [cycle, route] = given_files(parent.path());
    let other = parent.path().join("other.csv").display().to_string();
    fs::write(&other, "time_s,speed_mps\n0,0\n9,10\n20,10\n").expect("space");
    let begun = |arguments: &[&str], name: &str| {
        let out = parent.path().join(name);
        let mut run = begin(&out, &[arguments, &["--cycles", "10000000"]].concat());
        while !out.join("chunks").join("00000000.parquet").exists() {
            std::thread::sleep(Duration::from_millis(20));
        }
        run.kill().expect("it is ours");
        run.wait().expect("it ends");
        out
    };
    let again = |arguments: &[&str], out: &Path| {
        let output = ocmc(arguments).args(["--resume", "--quiet", "--out"]).arg(out).output();
        let output = output.expect("it starts");
        (output.status.code(), String::from_utf8(output.stderr).expect("UTF-8"))
    };
    let followed = ["drive", &cycle, "--follow-speed", "exact"];
    let (follows, drives) = (begun(&followed, "a"), begun(&["drive", &route], "b"));
    for (arguments, out) in [
        (&["drive", &other, "--follow-speed", "exact"][..], &follows),
        (&["drive", &cycle, "--follow-speed", "driver"], &follows),
        (&["drive", &route], &follows),
        (&["drive", &cycle, "--follow-speed", "exact"], &drives),
        (&["drive", &route, &route], &drives),
        (&["drive", &route, "--keep", "weather"], &drives),
    ] {
        let (code, message) = again(arguments, out);
        assert_eq!(code, Some(2), "{arguments:?}: {message}");
        assert!(message.contains("other files") && message.contains("--resume"), "{message}");
    }
    // a run so long is not finished here: its manifest says that it was to be shorter
    for (arguments, out) in [(&followed[..], &follows), (&["drive", &route], &drives)] {
        let completed = manifest(out)["completed"].as_u64().expect("a number") + 100;
        change_manifest(out, "\"cycles\": 10000000", &format!("\"cycles\": {completed}"));
        let (code, message) = again(arguments, out);
        assert_eq!(code, Some(0), "{arguments:?}: {message}");
        assert_eq!(manifest(out)["completed"], completed);
    }
}

#[test]
#[cfg(unix)]
fn ctrl_c_stops_within_a_second_and_the_rest_is_resumed() {
    let parent = tempfile::tempdir().expect("a directory");
    let out = parent.path().join("run");
    // a chunk of such cycles takes half a minute of a core: a stop cannot wait for one, however
    // many cores there are
    let run = Command::new(env!("CARGO_BIN_EXE_ocmc"))
        .args(["--set", "mission.length_m=4000000", "--cycles", "1000000", "--out"])
        .arg(&out)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    std::thread::sleep(Duration::from_millis(1500));
    let (_, took) = interrupt(run);
    eprintln!("stopped after {took:?}");
    // generous, as tests run beside one another; the interface says one second
    assert!(took < Duration::from_secs(2), "{took:?}");
    assert_eq!(manifest(&out)["status"], "interrupted");
}

#[test]
#[cfg(target_os = "linux")]
fn a_signal_that_was_ignored_at_the_start_stays_ignored() {
    let parent = tempfile::tempdir().expect("a directory");
    // as `nohup` does for the hang-up, and scripts do for Ctrl-C to jobs in the background
    for (name, signal) in [("nohup", "HUP"), ("background", "INT")] {
        let out = parent.path().join(name);
        let run = Command::new("sh")
            .args(["-c", &format!("trap '' {signal}; exec \"$@\""), "sh"])
            .arg(env!("CARGO_BIN_EXE_ocmc"))
            .args(["--set", TINY, "--cycles", "12000", "--threads", "1", "--quiet", "--out"])
            .arg(&out)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        while !out.join("manifest.json").exists() {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_millis(100));
        let mut kill = Command::new("kill");
        kill.args([&format!("-{signal}"), &run.id().to_string()]);
        assert!(kill.status().expect("kill starts").success());
        let output = run.wait_with_output().expect("it ends");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{signal}: {:?} {errors}", output.status);
        assert_eq!(manifest(&out)["status"], "complete", "{signal}");
    }
}

#[test]
#[cfg(unix)]
fn an_interrupted_run_can_be_read_and_resumed() {
    let parent = tempfile::tempdir().expect("a directory");
    let (expected, out) = (parent.path().join("whole"), parent.path().join("run"));
    let arguments = ["--cycles", "30000"];
    whole(&expected, &arguments);
    // on one thread, no machine is done in the moment after the first look
    let run = begin(&out, &[&arguments[..], &["--threads", "1"]].concat());
    while !out.join("manifest.json").exists() {
        std::thread::sleep(Duration::from_millis(1));
    }
    std::thread::sleep(Duration::from_millis(150));
    interrupt(run);
    let rows = records(&out.join("records.parquet"));
    assert_eq!(manifest(&out)["completed"], rows.len());
    assert_eq!(json(&out.join("summary.json"))["cycles"], rows.len());
    assert!(rows.len() < 30_000 && rows.iter().zip(0..).all(|(row, id)| row.cycle_id == id));
    resume(&out);
    assert_same(&expected, &out, "records.parquet");
    // once more: nothing to do, and the answer once more
    let output = ocmc(&["--resume", "--json", "--out"]).arg(&out).output().expect("it starts");
    let answer: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(answer["cycles"], 30_000);
}

/// A run whose program is gone, with at least two chunks.
fn dead_run(out: &Path, format: &str) {
    let mut run = begin(out, &["--cycles", "100000000", "--format", format]);
    let second = out.join("chunks").join(format!("00000001.{format}"));
    while !second.exists() || manifest(out)["completed"].as_u64() < Some(2048) {
        std::thread::sleep(Duration::from_millis(20));
    }
    run.kill().expect("it is ours");
    run.wait().expect("it ends");
}

#[test]
fn a_damaged_or_foreign_chunk_is_named() {
    let parent = tempfile::tempdir().expect("a directory");
    for format in ["parquet", "csv"] {
        let out = parent.path().join(format);
        dead_run(&out, format);
        let refused = || {
            seal(&out);
            refused(&out)
        };
        let chunk = out.join("chunks").join(format!("00000001.{format}"));
        let good = fs::read(&chunk).expect("written");

        fs::write(&chunk, &good[..good.len() / 2]).expect("space");
        assert!(refused().contains("00000001"), "cut in the middle");
        // the last number loses its last digits: still a number
        fs::write(&chunk, &good[..good.len() - 5]).expect("space");
        assert!(refused().contains("00000001"), "cut at the end");
        fs::remove_file(&chunk).expect("there");
        assert!(refused().contains("00000001"), "missing");

        // the same cycles of another study
        let other = parent.path().join(format!("{format}-other"));
        let arguments = ["--cycles", "1024", "--first-cycle", "1024", "--seed", "2", "--format"];
        whole(&other, &[&arguments[..], &[format]].concat());
        fs::copy(other.join(format!("records.{format}")), &chunk).expect("space");
        let message = refused();
        assert!(message.contains("00000001") && message.contains("study and seed"), "{message}");
        // other cycles of this one
        fs::copy(out.join("chunks").join(format!("00000000.{format}")), &chunk).expect("space");
        let message = refused();
        assert!(message.contains("cycle 0 where cycle 1024 should be"), "{message}");
    }
}

#[test]
fn what_cannot_be_resumed_is_said() {
    let parent = tempfile::tempdir().expect("a directory");
    let out = parent.path().join("run");
    dead_run(&out, "parquet");
    change_manifest(&out, "length_m = 200.0", "length_m = 300.0");
    let message = refused(&out);
    assert!(message.contains("hash"), "{message}");
    assert_eq!(ocmc(&["--resume"]).output().expect("it starts").status.code(), Some(2));
}

#[test]
fn the_same_command_begins_and_finishes_a_run() {
    let parent = tempfile::tempdir().expect("a directory");
    let (expected, out) = (parent.path().join("whole"), parent.path().join("run"));
    let arguments = ["--cycles", "4000", "--seed", "7", "--first-cycle", "3", "--format", "csv"];
    whole(&expected, &arguments);
    let again = [&arguments[..], &["--resume"]].concat();
    for wait_ms in [0, 30, 100, 200] {
        let mut run = begin(&out, &again);
        std::thread::sleep(Duration::from_millis(wait_ms));
        run.kill().expect("it is ours");
        run.wait().expect("it ends");
    }
    whole(&out, &again);
    assert_same(&expected, &out, "records.csv");
    // once more: it is complete, and nothing is run
    whole(&out, &again);
}

/// A program that is killed between its manifest and its checksums leaves a run without either
/// chunk or sum.
#[test]
fn a_run_that_ends_before_its_checksums_are_there_is_resumed() {
    let parent = tempfile::tempdir().expect("a directory");
    let (expected, out) = (parent.path().join("whole"), parent.path().join("run"));
    // a second until the first chunk
    let arguments = ["--cycles", "1100", "--set", "mission.length_m=2e5", "--quiet", "--out"];
    let run = |out: &Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_ocmc"));
        command.args(arguments).arg(out).stdout(Stdio::null()).spawn().expect("the program starts")
    };
    assert!(run(&expected).wait().expect("it ends").success());
    let mut killed = run(&out);
    while !out.join("checksums.sha256").exists() {
        std::thread::sleep(Duration::from_millis(1));
    }
    killed.kill().expect("it is ours");
    killed.wait().expect("it ends");
    assert_eq!(manifest(&out)["completed"], 0);
    fs::remove_file(out.join("checksums.sha256")).expect("there");
    resume(&out);
    assert_same(&expected, &out, "records.parquet");
}

#[test]
fn what_is_typed_beside_resume_has_to_be_that_of_the_run() {
    let parent = tempfile::tempdir().expect("a directory");
    let out = parent.path().join("run");
    dead_run(&out, "parquet");
    for (typed, words) in [
        (["--seed", "2"], "--seed is 2, and 1 in the run"),
        (["--cycles", "1000"], "--cycles is 1000, and 100000000 in the run"),
        (["--first-cycle", "5"], "--first-cycle is 5, and 0 in the run"),
        (["--precision", "1%"], "--precision is another one"),
        (["--format", "csv"], "`records.csv`, and the run has `records.parquet`"),
        (["--set", "driver.curve_speed.exponent=0.3"], "`driver.curve_speed.exponent` is 0.3, and"),
        (["--study", "regional"], "`study.name` is \"regional\", and \"field-truck\" in the run"),
    ] {
        let output = ocmc(&["--resume", "--quiet", "--out"]).arg(&out).args(typed).output();
        let output = output.expect("it starts");
        let message = String::from_utf8(output.stderr).expect("UTF-8");
        assert_eq!(output.status.code(), Some(2), "{typed:?}: {message}");
        assert!(message.contains(words), "{typed:?}: {message}");
    }
    assert_eq!(ocmc(&["--resume"]).output().expect("it starts").status.code(), Some(2));
}

#[test]
fn two_programs_do_not_write_one_run() {
    let parent = tempfile::tempdir().expect("a directory");
    let out = parent.path().join("run");
    let mut run = begin(&out, &["--cycles", "100000000"]);
    while !out.join("chunks").join("00000000.parquet").exists() {
        std::thread::sleep(Duration::from_millis(20));
    }
    let message = refused(&out);
    run.kill().expect("it is ours");
    run.wait().expect("it ends");
    assert!(message.contains("another program"), "{message}");
}

#[test]
#[cfg(target_os = "linux")]
fn a_disk_that_takes_no_more_is_named_and_loses_nothing() {
    let parent = tempfile::tempdir().expect("a directory");
    let (expected, out) = (parent.path().join("whole"), parent.path().join("run"));
    whole(&expected, &["--cycles", "5000"]);
    // no file may be larger than 1000 kB: the chunks fit, the records do not
    let script = format!(
        "trap '' XFSZ; ulimit -f 1000; exec {} --quiet --set {TINY} --cycles 5000 --out {}",
        env!("CARGO_BIN_EXE_ocmc"),
        out.display()
    );
    let output = Command::new("bash").args(["-c", &script]).output().expect("bash starts");
    let message = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(1), "{message}");
    for part in ["records.parquet", "too large", "--resume"] {
        assert!(message.contains(part), "{part}: {message}");
    }
    assert_eq!(manifest(&out)["completed"], 5000);
    resume(&out);
    assert_same(&expected, &out, "records.parquet");
}

/// A disk of its own for a test, gone with it.
#[cfg(target_os = "linux")]
struct SmallDisk(tempfile::TempDir);

#[cfg(target_os = "linux")]
impl SmallDisk {
    /// None where this user may not mount one.
    fn mounted(kilobytes: u32) -> Option<Self> {
        let folder = tempfile::tempdir().expect("a directory");
        let mount = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &format!("size={kilobytes}k"), "ocmc-test"])
            .arg(folder.path())
            .stderr(Stdio::null())
            .status();
        mount.is_ok_and(|status| status.success()).then(|| Self(folder))
    }

    /// As if other files were removed from it.
    fn grow(&self, kilobytes: u32) {
        let mount = Command::new("mount")
            .args(["-o", &format!("remount,size={kilobytes}k")])
            .arg(self.0.path())
            .status();
        assert!(mount.expect("mount starts").success());
    }
}

#[cfg(target_os = "linux")]
impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0.path()).status();
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_named_and_after_space_was_made_the_run_goes_on() {
    let parent = tempfile::tempdir().expect("a directory");
    for format in ["parquet", "csv"] {
        let arguments = ["--cycles", "3000", "--format", format];
        let (expected, records) = (parent.path().join(format), format!("records.{format}"));
        whole(&expected, &arguments);
        let bytes = fs::metadata(expected.join(&records)).expect("written").len();
        // full before the manifest, among the chunks, and when the chunks are put together
        for share in [0.0, 0.5, 1.6] {
            let kilobytes = 4 + (share * bytes as f64 / 1024.0) as u32;
            let Some(disk) = SmallDisk::mounted(kilobytes) else {
                eprintln!("not tested: only root may mount a small disk");
                return;
            };
            let out = disk.0.path().join("run");
            let output = begin(&out, &arguments).wait_with_output().expect("it ends");
            let message = String::from_utf8(output.stderr).expect("UTF-8");
            assert_eq!(output.status.code(), Some(1), "{message}");
            assert_eq!(message.matches("error:").count(), 1, "one error: {message}");
            assert!(
                message.contains("No space left on device") && !message.contains("panicked"),
                "{message}"
            );
            assert_eq!(message.contains("--resume"), share > 0.0, "{message}");
            disk.grow(16 * kilobytes + 16_384);
            if share > 0.0 {
                eprintln!("{format}, {kilobytes} kB: {}", manifest(&out)["completed"]);
                assert_eq!(manifest(&out)["completed"] == 3000, share > 1.0);
                resume(&out);
            } else {
                whole(&out, &arguments);
            }
            assert_same(&expected, &out, &records);
        }
    }
}

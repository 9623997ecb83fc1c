//! Faults that few meet: numbers at the edge of what is allowed, names that are no text, a disk
//! that is full.

use crate::program::{SHORT, ocmc};
use serde_json::Value;
use std::fs;
use std::path::Path;

fn json(arguments: &[&str]) -> Value {
    let output = ocmc(arguments).args(["--json", "--quiet"]).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn a_payload_of_nothing_makes_no_infinite_litres() {
    let payload = |kg: &str| {
        let set = format!("mission.payload_kg={kg}");
        let answer = json(&["--set", SHORT, "--set", &set, "--cycles", "5"]);
        answer["statistics"]["consumption_l_per_100tkm"]["p50"].clone()
    };
    assert_eq!(payload("1e-308"), Value::Null);
    assert_eq!(payload("0.999"), Value::Null);
    assert!(payload("1").as_f64().expect("a number") > 1000.0);
}

#[test]
fn a_mission_that_no_driver_ends_in_time_is_refused() {
    let check = |sets: &[&str]| {
        let sets = sets.iter().flat_map(|set| ["--set", set]);
        let output = ocmc(&["study", "check", "field-truck"]).args(sets).output();
        let output = output.expect("it starts");
        (output.status.success(), String::from_utf8(output.stderr).expect("UTF-8"))
    };
    let (done, said) = check(&["mission.length_m=5e6"]);
    assert!(!done && said.contains("`mission.length_m` is 5000000"), "{said}");
    assert!(said.contains("simulation.longest_duration_s"), "{said}");
    for sets in [
        &["mission.length_m=4.2e6"][..],
        &["mission.length_m=5e6", "simulation.longest_duration_s=250000"],
    ] {
        assert!(check(sets).0, "{sets:?}");
    }
}

#[test]
fn few_cycles_are_said_beside_their_intervals() {
    let text = |cycles: &str| {
        let output = ocmc(&["--set", SHORT, "--quiet", "--cycles", cycles]).output();
        String::from_utf8(output.expect("it starts").stdout).expect("UTF-8")
    };
    assert!(text("49").contains("skewed quantities cover about 85 %"));
    assert!(!text("50").contains("85 %"));
    assert!(json(&["--set", SHORT, "--cycles", "49"])["note"].is_string());
    assert_eq!(json(&["--set", SHORT, "--cycles", "50"])["note"], Value::Null);
    let folder = tempfile::tempdir().expect("a directory");
    let run = folder.path().join("a");
    ocmc(&["--set", SHORT, "--quiet", "--cycles", "9", "--out"]).arg(&run).assert().success();
    ocmc(&["report"]).arg(&run).assert().success();
    let page = fs::read_to_string(run.join("report.html")).expect("written");
    assert!(page.contains("cover about 85 %"));
}

#[test]
#[cfg(unix)]
fn a_path_that_is_no_text_is_taken_and_printed_as_a_shell_takes_it() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    use std::process::Command;
    let folder = tempfile::tempdir().expect("a directory");
    let name = OsStr::from_bytes(b"a\xff b.toml");
    let output = ocmc(&["study", "init"]).arg(name).current_dir(&folder).output();
    let said = String::from_utf8(output.expect("it starts").stderr).expect("UTF-8");
    assert!(folder.path().join(name).exists(), "{said}");
    assert!(said.contains(r"ocmc study check $'a\xff b.toml'"), "{said}");
    let script = said.split("then: ").nth(1).expect("commands").split(';').next().expect("one");
    let script = script.replace("ocmc", env!("CARGO_BIN_EXE_ocmc"));
    match Command::new("bash").args(["-c", &script]).current_dir(&folder).output() {
        Ok(output) => {
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{script}: {said}");
        }
        Err(error) => crate::others_data::skipped(&format!("no bash ({error})")),
    }
    let lost = OsStr::from_bytes(b"lost\xff.toml");
    let output = ocmc(&["study", "check"]).arg(lost).output().expect("it starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("lost\u{fffd}.toml"), "{said}");
}

/// The command in a shell that lets no file grow beyond so many kibibytes, as a full disk does.
#[cfg(unix)]
fn limited(kibibytes: u64, arguments: &[&str], out: &Path) -> (bool, String) {
    let script = format!("trap '' XFSZ; ulimit -f {kibibytes}; exec \"$@\"");
    let output = std::process::Command::new("bash")
        .args(["-c", &script, "bash", env!("CARGO_BIN_EXE_ocmc")])
        .args(arguments)
        .arg("--out")
        .arg(out)
        .output()
        .expect("bash starts");
    (output.status.success(), String::from_utf8(output.stderr).expect("UTF-8"))
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_leaves_the_file_that_was_there() {
    let folder = tempfile::tempdir().expect("a directory");
    let out = folder.path().join("trace.csv");
    let trace = &["trace", "--cycle-id", "0", "--set", SHORT];
    let (done, said) = limited(8, trace, &out);
    assert!(!done && said.contains("trace.csv"), "{said}");
    assert_eq!(fs::read_dir(&folder).expect("there").count(), 0, "nothing is left");
    fs::write(&out, "mine").expect("space");
    assert!(!limited(8, trace, &out).0);
    assert_eq!(fs::read(&out).expect("there"), b"mine");
    let link = folder.path().join("link.csv");
    std::os::unix::fs::symlink(&out, &link).expect("a link");
    assert!(limited(100_000, trace, &link).0);
    assert!(fs::read_to_string(&out).expect("there").starts_with("time_s"));
    assert!(fs::symlink_metadata(&link).expect("there").is_symlink());
    assert_eq!(fs::read_dir(&folder).expect("there").count(), 2, "nothing is left");
}

//! The workbook of a run, as the command writes it.

use crate::program::{ocmc, run_into};
use std::fs;
use std::path::Path;

fn failed(arguments: &[&str], path: &Path, code: i32) -> String {
    let output = ocmc(arguments).arg(path).output().expect("the program starts");
    assert_eq!(output.status.code(), Some(code));
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_workbook_lies_beside_a_complete_run_or_where_it_is_asked_for() {
    let parent = tempfile::tempdir().expect("a directory");
    let (run, plain) = (parent.path().join("run"), parent.path().join("plain"));
    run_into(&run, &["--cycles", "20", "--format", "xlsx"]);
    run_into(&plain, &["--cycles", "20"]);
    // records are those of every other run
    let [ours, theirs] =
        [&run, &plain].map(|run| fs::read(run.join("records.parquet")).expect("written"));
    assert!(ours == theirs && !plain.join("run.xlsx").exists());
    ocmc(&["report", "--xlsx", "--"]).arg(&plain).assert().success();
    let other = parent.path().join("other.xlsx");
    fs::write(&other, "an older one").expect("space");
    ocmc(&["report"]).arg(&plain).arg("--xlsx").arg(&other).assert().success();
    assert!(!plain.join("report.html").exists(), "one or the other");
    let files = [&run.join("run.xlsx"), &plain.join("run.xlsx"), &other];
    let [a, b, c] = files.map(|file| fs::read(file).expect("written"));
    assert!(a.starts_with(b"PK") && a == b && b == c);
    // the directory stays whole, and a workbook that is lost can be written again
    ocmc(&["verify"]).arg(&run).assert().success();
    fs::remove_file(run.join("run.xlsx")).expect("there");
    let again = ["--resume", "--format", "xlsx", "--quiet", "--out"];
    ocmc(&again).arg(&run).assert().success();
    assert!(fs::read(run.join("run.xlsx")).expect("written") == a);
}

#[test]
fn what_does_not_fit_into_a_workbook_is_not_driven() {
    let parent = tempfile::tempdir().expect("a directory");
    let run = parent.path().join("run");
    let arguments = ["--cycles", "2_000_000", "--format", "xlsx", "--out"];
    let error = failed(&arguments, &run, 2);
    assert!(error.contains("--format xlsx: a workbook holds at most 1048575 records"), "{error}");
    assert!(error.contains("has 2000000") && !run.exists(), "{error}");
    let error = failed(&["report", "nowhere", "--xlsx"], Path::new("a.ods"), 2);
    assert!(error.contains("has to end in `.xlsx`"), "{error}");
    let error = failed(&["report", "--xlsx", "a.xlsx"], Path::new("nowhere"), 1);
    assert!(error.contains("`nowhere` is no run directory"), "{error}");
}

#[cfg(unix)]
#[test]
fn a_workbook_is_not_written_through_a_link() {
    let parent = tempfile::tempdir().expect("a directory");
    let (run, other) = (parent.path().join("run"), parent.path().join("other"));
    run_into(&run, &["--cycles", "10"]);
    fs::write(&other, "theirs").expect("space");
    std::os::unix::fs::symlink(&other, run.join("run.xlsx")).expect("space");
    let error = failed(&["report", "--xlsx", "--"], &run, 1);
    assert!(error.contains("is a symbolic link") && error.contains("--xlsx FILE"), "{error}");
    assert_eq!(fs::read_to_string(&other).expect("there"), "theirs");
}

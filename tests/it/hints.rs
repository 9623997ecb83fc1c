//! Hints of the program on what to type: commands that a shell takes as they stand, and what to do
//! about a directory.

use crate::program::{SHORT, change_manifest, message, ocmc, run_into};
use std::fs;
use std::path::Path;

#[test]
fn paths_with_blanks_are_quoted_in_commands() {
    let folder = tempfile::tempdir().expect("a directory");
    let folder = folder.path();
    let run = ["--cycles", "2", "--set", SHORT, "--out", "a b/it's"];
    let hint = message(folder, &run, 0);
    assert!(hint.contains(r"`ocmc report 'a b/it'\''s'`"), "{hint}");
    let hint = message(folder, &["study", "init", "my study.toml"], 0);
    assert!(
        hint.contains("ocmc study check 'my study.toml'; ocmc --study 'my study.toml'"),
        "{hint}"
    );
    let hint = message(folder, &["study", "init", "mine.toml"], 0);
    assert!(hint.contains("ocmc study check mine.toml;"), "{hint}");
}

#[test]
fn a_path_that_holds_no_run_says_what_to_do() {
    let folder = tempfile::tempdir().expect("a directory");
    let folder = folder.path();
    fs::create_dir(folder.join("empty")).expect("space");
    fs::write(folder.join("file"), "").expect("space");
    for (path, why) in [
        ("nothing", "it holds no manifest.json"),
        ("empty", "it holds no manifest.json"),
        ("file", "it is a file"),
    ] {
        let expected = format!("`{path}` is no run directory ({why}); `ocmc --out DIR` makes one");
        for arguments in
            [&["report", path][..], &["verify", path], &["merge", path, "--out", "whole"]]
        {
            let message = message(folder, arguments, 1);
            assert!(message.contains(&expected), "{message}");
        }
    }
}

#[test]
fn a_manifest_stands_for_its_directory() {
    let folder = tempfile::tempdir().expect("a directory");
    let run = folder.path().join("run");
    run_into(&run, &["--cycles", "5"]);
    message(folder.path(), &["report", "run/manifest.json"], 0);
    assert!(run.join("report.html").exists());
    fs::remove_file(run.join("report.html")).expect("there");
    message(&run, &["report", "manifest.json"], 0);
    assert!(run.join("report.html").exists());
}

#[test]
fn a_run_that_was_ended_by_force_names_the_command_that_finishes_it() {
    let folder = tempfile::tempdir().expect("a directory");
    let run = folder.path().join("a b");
    run_into(&run, &["--cycles", "5"]);
    change_manifest(&run, r#""status": "complete""#, r#""status": "running""#);
    change_manifest(&run, r#""completed": 5"#, r#""completed": 0"#);
    let report = message(folder.path(), &["report", "a b"], 1);
    let finishes = "`ocmc --out 'a b' --resume` finishes it";
    assert!(report.contains("not ended (0 of 5 cycles, running)"), "{report}");
    assert!(report.contains(finishes), "{report}");
    let again = message(folder.path(), &["--out", "a b"], 1);
    assert!(again.contains(finishes), "{again}");
}

#[test]
fn a_study_typed_as_a_command_has_its_option_named() {
    let folder = tempfile::tempdir().expect("a directory");
    for (typed, command) in
        [("field-truck", "ocmc --study field-truck"), ("a b.toml", "ocmc --study 'a b.toml'")]
    {
        let message = message(folder.path(), &[typed], 2);
        assert!(message.contains(&format!("to run this study, type: {command}")), "{message}");
        assert!(!message.contains("similar"), "{message}");
    }
    let message = message(folder.path(), &["drvie"], 2);
    assert!(message.contains("'drive'") && !message.contains("this study"), "{message}");
}

#[test]
fn numbers_that_people_write_are_named_as_they_are_typed() {
    let folder = tempfile::tempdir().expect("a directory");
    for typed in ["1e4", "10k", "10,000"] {
        let message = message(folder.path(), &["--cycles", typed], 2);
        assert!(message.contains("; type 10000\n"), "{message}");
    }
    let point = "numbers take a decimal point: 2.5, not 2,5";
    let message = message(folder.path(), &["--set", "mission.length_m=2500,5"], 1);
    assert!(message.contains(point), "{message}");
}

#[test]
fn the_picture_of_the_readme_has_the_rows_of_the_command() {
    let output = ocmc(&["--cycles", "60"]).output().expect("the program starts");
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    let picture = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/images/run.svg");
    let picture = fs::read_to_string(picture).expect("the picture");
    let (_, table) = text.split_once("mean ± 95 %").expect("a table");
    let (table, _) = table.split_once("number of cycles").expect("a histogram");
    // names of rows, up to two blanks; a remark up to its number
    let rows = table.lines().skip(1).filter(|line| !line.is_empty());
    let names: Vec<&str> = rows
        .map(|row| row.split("  ").next().unwrap_or(row))
        .filter(|name| !name.contains('±'))
        .collect();
    assert!(names.len() > 6, "{text}");
    for name in names {
        let name = name.split(" counts ").next().unwrap_or(name).trim_end_matches(',');
        assert!(picture.contains(&format!(">{name}")), "{name}");
    }
}

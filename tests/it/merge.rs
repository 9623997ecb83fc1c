//! Parts of a run, from as many machines as there are, merged into the bytes of the single run.

use crate::program::{SHORT, change_manifest, ocmc, run_into, seal};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A part of the run of 300 short cycles from id 100 on.
fn part(parent: &Path, name: &str, first: &str, cycles: &str, extra: &[&str]) -> PathBuf {
    let out = parent.join(name);
    run_into(&out, &[&["--first-cycle", first, "--cycles", cycles], extra].concat());
    out
}

fn merge(parts: &[&Path], out: &Path) -> std::process::Output {
    let mut command = ocmc(&["merge", "--quiet", "--json", "--out"]);
    command.arg(out).args(parts).output().expect("the program starts")
}

fn refused(parts: &[&Path], out: &Path) -> String {
    let output = merge(parts, out);
    let message = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(!message.contains("panicked"), "{message}");
    message
}

#[test]
fn parts_become_the_bytes_of_the_single_run() {
    let parent = tempfile::tempdir().expect("a directory");
    let whole = part(parent.path(), "whole", "100", "300", &[]);
    // three machines at the same time
    let ranges = [("100", "120"), ("220", "1"), ("221", "179")];
    let machines: Vec<_> = ranges
        .iter()
        .enumerate()
        .map(|(k, (first, cycles))| {
            Command::new(env!("CARGO_BIN_EXE_ocmc"))
                .args(["--set", SHORT, "--first-cycle", first, "--cycles", cycles, "--out"])
                .arg(parent.path().join(format!("part-{k}")))
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .expect("the program starts")
        })
        .collect();
    for mut machine in machines {
        assert!(machine.wait().expect("it ends").success());
    }
    let paths: Vec<PathBuf> = (0..3).map(|k| parent.path().join(format!("part-{k}"))).collect();
    // in any order
    let out = parent.path().join("merged");
    let output = merge(&[&paths[2], &paths[0], &paths[1]], &out);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for file in ["records.parquet", "manifest.json"] {
        let read = |directory: &Path| fs::read(directory.join(file)).expect("written");
        assert!(read(&whole) == read(&out), "{file}");
    }
    let summary = |directory: &Path| -> Value {
        let text = fs::read_to_string(directory.join("summary.json")).expect("written");
        serde_json::from_str(&text).expect("JSON")
    };
    assert_eq!(summary(&whole)["statistics"], summary(&out)["statistics"]);
    let answer: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(answer, summary(&out));
    assert!(refused(&[&paths[0]], &out).contains("already holds a run"));
}

#[test]
fn parts_that_are_not_of_one_run_are_named() {
    let parent = tempfile::tempdir().expect("a directory");
    let parent = parent.path();
    let a = part(parent, "a", "0", "50", &[]);
    let out = parent.join("out");
    for (b, words) in [
        (part(parent, "gap", "60", "10", &[]), "10 cycles are missing between them, from id 50"),
        (part(parent, "overlap", "49", "10", &[]), "overlap from id 49"),
        (part(parent, "seed", "50", "10", &["--seed", "2"]), "seed"),
        (part(parent, "study", "50", "10", &["--set", "driver.curve_speed.exponent=0.5"]), "study"),
    ] {
        let message = refused(&[&a, &b], &out);
        let name = b.file_name().and_then(|name| name.to_str()).expect("UTF-8");
        assert!(message.contains(words) && message.contains(name), "{name}: {message}");
    }
    assert!(refused(&[&a, &a], &out).contains("overlap from id 0"), "one part twice");
    assert!(refused(&[&a, &parent.join("nowhere")], &out).contains("nowhere"));
    let b = part(parent, "b", "50", "10", &[]);
    let changed = |from: &str, to: &str| {
        change_manifest(&b, from, to);
        let message = refused(&[&a, &b], &out);
        change_manifest(&b, to, from);
        message
    };
    assert!(changed("complete", "running").contains("not ended"));
    let more = changed("\"completed\": 10", "\"completed\": 11");
    assert!(more.contains("11 of 10 cycles are completed"), "{more}");
    // the last part, interrupted: its records fit, and others of the run are missing
    change_manifest(&b, "\"cycles\": 10", "\"cycles\": 20");
    change_manifest(&b, "complete\"", "interrupted\"");
    let message = refused(&[&a, &b], &out);
    assert!(message.contains("interrupted after 10 of its 20 cycles"), "{message}");
    assert!(message.contains(&format!("ocmc --out {} --resume", b.display())), "{message}");
    assert!(!out.exists(), "nothing is written of parts that do not fit");
}

#[test]
fn a_part_that_was_cut_or_exchanged_is_named() {
    let parent = tempfile::tempdir().expect("a directory");
    let parent = parent.path();
    for format in ["parquet", "csv"] {
        let options = ["--format", format];
        let a = part(parent, &format!("a-{format}"), "0", "50", &options);
        let b = part(parent, &format!("b-{format}"), "50", "50", &options);
        let other = part(
            parent,
            &format!("other-{format}"),
            "50",
            "50",
            &[&options[..], &["--set", "driver.curve_speed.exponent=0.5"]].concat(),
        );
        let file = b.join(format!("records.{format}"));
        let good = fs::read(&file).expect("written");
        let name = format!("b-{format}");
        let mut k = 0;
        let mut message = || {
            k += 1;
            seal(&b);
            refused(&[&a, &b], &parent.join(format!("out-{format}-{k}")))
        };
        for bytes in [&good[..good.len() / 2], &good[..good.len() - 5]] {
            fs::write(&file, bytes).expect("space");
            let message = message();
            assert!(message.contains(&name), "{message}");
        }
        fs::copy(other.join(format!("records.{format}")), &file).expect("space");
        let message = message();
        assert!(message.contains(&name) && message.contains("study and seed"), "{message}");
    }
}

#[test]
fn a_merge_that_fails_leaves_nothing_behind() {
    let parent = tempfile::tempdir().expect("a directory");
    let parent = parent.path();
    let a = part(parent, "a", "0", "50", &[]);
    let b = part(parent, "b", "50", "10", &[]);
    let (records, aside) = (b.join("records.parquet"), parent.join("aside"));
    fs::rename(&records, &aside).expect("the same disk");
    // a folder that is new, below another new one, and one that was there
    let (new, old) = (parent.join("x").join("new"), parent.join("old"));
    fs::create_dir(&old).expect("space");
    for out in [&new, &old] {
        assert!(refused(&[&a, &b], out).contains("records.parquet"));
    }
    assert!(!parent.join("x").exists());
    assert_eq!(fs::read_dir(&old).expect("still there").count(), 0);
    fs::rename(&aside, &records).expect("the same disk");
    for out in [&new, &old] {
        let output = merge(&[&a, &b], out);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
#[cfg(unix)]
fn the_script_of_the_guide_works_with_plain_processes() {
    let guide = include_str!("../../docs/src/how-to/parts.md");
    let script = guide.split("```sh\n").find(|block| block.starts_with("#!/bin/bash"));
    let script = script.and_then(|block| block.split("```").next()).expect("the guide's script");
    assert!(script.contains("size=50000"));
    let parent = tempfile::tempdir().expect("a directory");
    let parent = parent.path();
    fs::write(parent.join("script"), script.replace("size=50000", "size=40")).expect("space");
    let study = "[study]\nbase = \"field-truck\"\n[mission]\nlength_m = 5000\n";
    fs::write(parent.join("my-fleet.toml"), study).expect("space");
    let programs = Path::new(env!("CARGO_BIN_EXE_ocmc")).parent().expect("a folder");
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap_or_default());
    let task = |number: &str| {
        Command::new("bash")
            .arg("script")
            .current_dir(parent)
            .envs([("SLURM_ARRAY_TASK_ID", number), ("SLURM_CPUS_PER_TASK", "1")])
            .env("SCRATCH", parent)
            .env("PATH", &path)
            .stdout(Stdio::null())
            .spawn()
            .expect("bash starts")
    };
    for mut task in ["0", "1", "2"].map(task) {
        assert!(task.wait().expect("it ends").success());
    }
    // a task that is put into the queue again goes on, and here finds that nothing is left to do
    assert!(task("2").wait().expect("it ends").success());
    let parts: Vec<PathBuf> =
        (0..3).map(|k| parent.join("fleet").join(format!("part-{k}"))).collect();
    let out = parent.join("merged");
    let output = merge(&[&parts[0], &parts[1], &parts[2]], &out);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let whole = parent.join("whole");
    let arguments =
        ["--study", "my-fleet.toml", "--seed", "7", "--cycles", "120", "--quiet", "--out"];
    ocmc(&arguments).arg(&whole).current_dir(parent).assert().success();
    let read = |directory: &Path| fs::read(directory.join("records.parquet")).expect("written");
    assert!(read(&whole) == read(&out));
}

//! Files of a run directory that change behind its back are named.

use crate::others_data::skipped;
use crate::program::{change_manifest, ocmc, run_into, seal};
use ocmc_fleet::run::RunPlan;
use ocmc_fleet::summary::SummaryBuilder;
use ocmc_io::given_drive::GivenDrive;
use ocmc_io::records::RecordFormat;
use ocmc_io::run_directory::{
    CHECKSUMS, CHUNK_ROWS, Manifest, RunDirectory, RunStatus, RunSummary, read, read_manifest,
    unfinished, verify,
};
use ocmc_io::study::{self, Files};
use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Numbers without a pattern: splitmix64.
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % end as u64) as usize
    }
}

/// The files of a run directory that hold something.
fn files(directory: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(directory).expect("a directory") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files.extend(self::files(&path));
        } else if fs::metadata(&path).expect("there").len() > 0 {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// Calls `is_noticed` for each of some single flipped bits and cut ends of the files.
fn damage(
    directory: &Path,
    [flips, cuts]: [usize; 2],
    seed: u64,
    is_noticed: impl Fn(&Path) -> bool,
) {
    let files = files(directory);
    let mut numbers = Numbers(seed);
    for k in 0..flips + cuts {
        // each file as often as any other
        let file = &files[k % files.len()];
        let good = fs::read(file).expect("there");
        let mut bad = good.clone();
        let what = if k < flips {
            let (byte, bit) = (numbers.below(bad.len()), numbers.below(8));
            bad[byte] ^= 1 << bit;
            format!("bit {bit} of byte {byte}")
        } else {
            bad.truncate(numbers.below(good.len()));
            format!("cut to {} of {} bytes", bad.len(), good.len())
        };
        fs::write(file, &bad).expect("space");
        assert!(is_noticed(file), "{}: {what}", file.display());
        fs::write(file, &good).expect("space");
    }
}

#[test]
fn a_flipped_bit_or_a_cut_end_of_a_finished_run_is_named() {
    let parent = tempfile::tempdir().expect("a directory");
    // with the tables of trucks, and of charging
    let fleet =
        ["--study", "electric-regional", "--trucks", "3", "--trips", "4", "--format", "csv"];
    for (name, arguments, seed) in [
        ("parquet", &["--cycles", "60"][..], 1),
        ("csv", &["--cycles", "60", "--format", "csv"], 2),
        ("fleet", &fleet, 3),
    ] {
        let out = parent.path().join(name);
        run_into(&out, arguments);
        assert!(
            name != "fleet"
                || out.join("trucks.csv").exists() && out.join("chargings.csv").exists()
        );
        ocmc(&["report"]).arg(&out).assert().success();
        assert!(verify(&out).expect("a run").is_whole());
        damage(&out, [250, 75], seed, |file| {
            let answer = verify(&out).expect("a run");
            let name = file.file_name().expect("a file").to_string_lossy();
            // the report, and the list itself, are not what is read back
            let is_read = !["report.html", "checksums.sha256"].contains(&&*name);
            let is_refused = read(&out).is_err();
            !answer.is_whole() && (is_refused || !is_read)
        });
        assert!(verify(&out).expect("a run").is_whole());
    }
}

/// A run that was ended by force, with two full chunks, of which the last may not be counted.
fn dead_run(out: &Path, format: RecordFormat) {
    drop(begun_run(out, format));
}

/// A run of three chunks that has two, and what those add up to.
fn begun_run(out: &Path, format: RecordFormat) -> (RunDirectory, RunSummary) {
    let loaded = study::load("field-truck", &["mission.length_m=1000"]).expect("a study");
    let given = GivenDrive::nothing();
    let plan = RunPlan::new(1, 0, 3 * CHUNK_ROWS as u64, None, None);
    let manifest = Manifest::new(&loaded, &plan, &given);
    let mut run = RunDirectory::create(out, format, manifest.clone()).expect("empty");
    let mut fleet = SummaryBuilder::new(manifest.dependence());
    let first = RunPlan::new(1, 0, 2 * CHUNK_ROWS as u64, None, None);
    let ended = given.run(&loaded.study, &first, |records| {
        fleet.add(&records);
        run.add(&records).expect("space");
        ControlFlow::<()>::Continue(())
    });
    assert!(ended.is_continue());
    (run, RunSummary::new(&manifest, fleet.finish(), 1.0, 1))
}

/// Answer of `ocmc verify` on a directory, all of whose files are whole.
fn said_of_whole(out: &Path) -> String {
    let output = ocmc(&["verify"]).arg(out).output().expect("it starts");
    let said = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(output.status.success(), "{said}");
    said
}

#[test]
fn a_chunk_that_is_not_counted_is_no_fault_and_an_unfinished_run_is_called_one() {
    let parent = tempfile::tempdir().expect("a directory");
    let (dead, complete) = (parent.path().join("dead"), parent.path().join("complete"));
    dead_run(&dead, RecordFormat::Csv);
    run_into(&complete, &["--cycles", "20", "--format", "csv"]);
    for (out, is_complete) in [(&dead, false), (&complete, true)] {
        let before = said_of_whole(out);
        // its line is written before its chunk is there, and taken out after that is gone
        let sums = out.join(CHECKSUMS);
        let lines = fs::read_to_string(&sums).expect("written");
        fs::write(&sums, format!("{lines}{:064}  chunks/00000002.csv\n", 0)).expect("ours");
        assert_eq!(said_of_whole(out), before);
        assert_eq!(before.contains("not complete"), !is_complete, "{before}");
    }
    let completed = read_manifest(&dead).expect("a run").completed;
    let missing = format!("\nnot complete: {completed} of 3072 cycles, running; `ocmc --out ");
    assert!(said_of_whole(&dead).contains(&missing), "{missing}");
}

#[test]
fn an_interrupted_run_that_cannot_be_taken_up_stays_whole() {
    let parent = tempfile::tempdir().expect("a directory");
    let out = parent.path().join("run");
    let (run, summary) = begun_run(&out, RecordFormat::Parquet);
    assert_eq!(run.finish(&summary).expect("space").status, RunStatus::Interrupted);
    let resumed = || {
        let found = unfinished(&out, &Files::here()).expect("whole").expect("unfinished");
        RunDirectory::resume(&found, |_| ())
    };
    let before = said_of_whole(&out);
    assert!(before.contains("not complete: 2048 of 3072 cycles, interrupted; "), "{before}");
    // where the manifest is to be written there is no place
    let taken = out.join("manifest.json.tmp");
    fs::create_dir(&taken).expect("space");
    assert!(resumed().is_err());
    assert_eq!(said_of_whole(&out), before);
    read(&out).expect("as before");
    fs::remove_dir(&taken).expect("ours");
    drop(resumed().expect("whole"));
    assert!(said_of_whole(&out).contains("2048 of 3072 cycles, running; "));
}

#[test]
fn a_flipped_bit_or_a_cut_end_of_an_unfinished_run_is_named() {
    let parent = tempfile::tempdir().expect("a directory");
    for (format, seed) in [(RecordFormat::Parquet, 3), (RecordFormat::Csv, 4)] {
        let out = parent.path().join(format.file_name());
        dead_run(&out, format);
        assert!(verify(&out).expect("a run").is_whole());
        damage(&out, [250, 75], seed, |_| {
            let resumed = unfinished(&out, &Files::here())
                .and_then(|found| RunDirectory::resume(&found.expect("unfinished"), |_| ()));
            resumed.is_err() && !verify(&out).expect("a run").is_whole()
        });
        let found = unfinished(&out, &Files::here()).expect("whole").expect("unfinished");
        RunDirectory::resume(&found, |_| ()).expect("whole");
    }
}

#[test]
fn the_checksums_are_those_of_sha256sum() {
    let parent = tempfile::tempdir().expect("a directory");
    let out = parent.path().join("run");
    run_into(&out, &["--cycles", "20"]);
    let checked = std::process::Command::new("sha256sum")
        .args(["--check", "--strict", "--quiet", "checksums.sha256"])
        .current_dir(&out)
        .output();
    match checked {
        Err(error) => skipped(&format!("no sha256sum here ({error})")),
        Ok(output) => assert!(output.status.success(), "{output:?}"),
    }
}

#[test]
fn verify_says_which_file_is_damaged_and_fails() {
    let parent = tempfile::tempdir().expect("a directory");
    let out = parent.path().join("run");
    run_into(&out, &["--cycles", "20", "--format", "csv"]);
    let said = |status: i32| {
        let output = ocmc(&["verify"]).arg(&out).output().expect("it starts");
        assert_eq!(output.status.code(), Some(status));
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    assert_eq!(said(0), "whole    manifest.json\nwhole    records.csv\nwhole    summary.json\n");
    let records = out.join("records.csv");
    let text = fs::read_to_string(&records).expect("written");
    fs::write(&records, text.replacen("0.", "1.", 1)).expect("space");
    let text = said(1);
    assert!(text.contains("damaged  records.csv") && text.contains("changed since"), "{text}");
    for command in ["report", "verify"] {
        ocmc(&[command]).arg(&out).assert().failure();
    }
    let output = ocmc(&["verify"]).arg(parent.path().join("nowhere")).output();
    assert!(String::from_utf8_lossy(&output.expect("it starts").stderr).contains("no run"));
}

#[test]
fn a_run_of_another_version_is_refused_by_its_name() {
    let parent = tempfile::tempdir().expect("a directory");
    let out = parent.path().join("run");
    run_into(&out, &["--cycles", "20"]);
    let version = format!("\"program_version\": \"{}\"", env!("CARGO_PKG_VERSION"));
    change_manifest(&out, &version, "\"program_version\": \"0.1.0\"");
    // with a key that this version does not know
    change_manifest(&out, "\"seed\":", "\"master\": 1,\n  \"seed\":");
    let whole = parent.path().join("whole");
    for arguments in [
        &["report"][..],
        &["--resume", "--out"],
        &["--resume", "--cycles", "20", "--out"],
        &["merge", "--out", whole.to_str().expect("UTF-8")],
    ] {
        let output = ocmc(arguments).arg(&out).output().expect("it starts");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains("was written by version 0.1.0"), "{arguments:?}: {said}");
        assert!(!output.status.success());
    }
    let output = ocmc(&["verify"]).arg(&out).output().expect("it starts");
    assert!(String::from_utf8_lossy(&output.stdout).contains("was written by version 0.1.0"));
    assert!(!output.status.success());
}

#[test]
fn a_number_that_is_none_is_named() {
    let parent = tempfile::tempdir().expect("a directory");
    let out = parent.path().join("run");
    run_into(&out, &["--cycles", "3", "--format", "csv"]);
    let records = out.join("records.csv");
    let text = fs::read_to_string(&records).expect("written");
    let row = text.lines().nth(1).expect("a row");
    for number in ["NaN", "inf", "-inf", "1e999"] {
        let cells: Vec<&str> = row.split(',').collect();
        let bad = [&cells[..2], &[number], &cells[3..]].concat().join(",");
        fs::write(&records, text.replace(row, &bad)).expect("space");
        seal(&out);
        let error = read(&out).expect_err("no number").to_string();
        assert!(error.contains("`distance_m` of cycle") && error.contains("finite"), "{error}");
    }
}

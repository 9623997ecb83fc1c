//! Contents of a run directory: records in both formats, the manifest, the summary.

use crate::program::{ocmc, records, run_into};
use ocmc_core::energy::Carrier;
use serde_json::Value;
use std::fs;
use std::path::Path;

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).expect("written")).expect("JSON")
}

#[test]
fn both_formats_hold_the_same_values() {
    let parent = tempfile::tempdir().expect("a directory");
    let (csv, parquet) = (parent.path().join("csv"), parent.path().join("parquet"));
    run_into(&csv, &["--cycles", "120", "--format", "csv"]);
    run_into(&parquet, &["--cycles", "120", "--format", "parquet"]);
    let from_csv = records(&csv.join("records.csv"));
    let from_parquet = records(&parquet.join("records.parquet"));
    assert_eq!(from_csv.len(), 120);
    assert!(from_csv == from_parquet);
    assert!(from_csv.iter().enumerate().all(|(k, record)| record.cycle_id == k as u64));
    assert!(
        from_csv
            .iter()
            .any(|record| record.amount(Carrier::LiquidFuel).is_some_and(|fuel| fuel > 0.0))
    );
    assert!(
        from_csv.iter().all(|record| record.amount(Carrier::Electricity).is_none()),
        "a diesel has no battery"
    );
}

#[test]
fn the_manifest_says_what_the_run_is_and_repeats_it() {
    let parent = tempfile::tempdir().expect("a directory");
    let first = parent.path().join("first");
    run_into(&first, &["--cycles", "40", "--seed", "18446744073709551615", "--first-cycle", "5"]);
    let manifest = json(&first.join("manifest.json"));
    for (key, value) in [
        ("format_version", Value::from(1)),
        ("program_version", env!("CARGO_PKG_VERSION").into()),
        ("status", "complete".into()),
        ("study", "field-truck".into()),
        ("seed", u64::MAX.into()),
        ("first_cycle", 5.into()),
        ("cycles", 40.into()),
        ("completed", 40.into()),
        ("records", "records.parquet".into()),
    ] {
        assert_eq!(manifest[key], value, "{key}");
    }
    let study = parent.path().join("again.toml");
    fs::write(&study, manifest["resolved_study"].as_str().expect("TOML")).expect("space");
    let again = parent.path().join("again");
    let (study, out) = (study.to_str().expect("UTF-8"), again.to_str().expect("UTF-8"));
    let arguments = ["--cycles", "40", "--seed", "18446744073709551615", "--first-cycle", "5"];
    ocmc(&["--study", study, "--out", out, "--quiet"]).args(arguments).assert().success();
    let records = |directory: &Path| fs::read(directory.join("records.parquet")).expect("written");
    assert!(records(&first) == records(&again));
    // which numbers are judged is said of the study file, and not of its numbers
    let stated = |directory: &Path| {
        let mut manifest = json(&directory.join("manifest.json"));
        let keys = manifest.as_object_mut().expect("a table");
        assert!(keys.remove("judged").is_some() && keys.remove("manifest_sha256").is_some());
        manifest
    };
    assert_eq!(stated(&first), stated(&again));
}

#[test]
fn the_summary_is_the_answer_in_json() {
    let parent = tempfile::tempdir().expect("a directory");
    let out = parent.path().join("run");
    let arguments = ["--cycles", "50", "--json", "--set", crate::program::SHORT, "--out"];
    let answer = ocmc(&arguments).arg(&out).assert().success().get_output().stdout.clone();
    assert_eq!(answer, fs::read(out.join("summary.json")).expect("written"));
    let summary = json(&out.join("summary.json"));
    assert_eq!(summary["study_hash"], json(&out.join("manifest.json"))["study_hash"]);
    // the fleet's mean is total fuel over total distance
    let rows = records(&out.join("records.parquet"));
    let litres = |r: &ocmc_core::record::Record| {
        r.consumption(Carrier::LiquidFuel).expect("a diesel") * r.distance_m
    };
    let mean =
        rows.iter().map(litres).sum::<f64>() / rows.iter().map(|r| r.distance_m).sum::<f64>();
    let printed =
        summary["statistics"]["consumption_l_per_100km"]["mean"].as_f64().expect("a number");
    assert!((printed / mean - 1.0).abs() < 1e-12, "{printed} {mean}");
}

//! Runs the command, and reads what it leaves behind.

use assert_cmd::Command;
use ocmc_core::record::Record;
use ocmc_io::run_directory::note_file;
use ocmc_io::sha256;
use std::fs;
use std::path::Path;

/// A setting that makes cycles short, so that tests are.
pub(crate) const SHORT: &str = "mission.length_m=5000";

/// The command, in its own directory so that nothing is written to ours.
pub(crate) fn ocmc(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ocmc"));
    command.args(arguments).current_dir(std::env::temp_dir()).env_remove("NO_COLOR");
    command
}

/// Message of the command beside its answer, in a folder of its own, with this exit status.
pub(crate) fn message(folder: &Path, arguments: &[&str], status: i32) -> String {
    let output = ocmc(arguments).current_dir(folder).output().expect("the program starts");
    let message = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {message}");
    message
}

/// Runs short cycles into a directory, and returns nothing but success.
pub(crate) fn run_into(directory: &Path, arguments: &[&str]) {
    let out = directory.to_str().expect("UTF-8");
    ocmc(&["--set", SHORT, "--quiet", "--out", out]).args(arguments).assert().success();
}

/// Changes a text in the manifest of a run directory.
pub(crate) fn change_manifest(directory: &Path, from: &str, to: &str) {
    let path = directory.join("manifest.json");
    let text = fs::read_to_string(&path).expect("written");
    assert!(text.contains(from), "{from}");
    fs::write(&path, text.replacen(from, to, 1)).expect("space");
    seal(directory);
}

/// Writes the checksums of a run directory anew, so that what a test changed in it is looked at in
/// every other way.
pub(crate) fn seal(directory: &Path) {
    let folders = [directory.to_owned(), directory.join("chunks")];
    let files = folders.iter().filter_map(|folder| fs::read_dir(folder).ok()).flatten();
    for file in files.map(|file| file.expect("an entry").path()).filter(|file| file.is_file()) {
        let name = file.strip_prefix(directory).expect("below it").to_str().expect("UTF-8");
        let is_table = matches!(name.rsplit('.').next(), Some("parquet" | "csv"));
        if is_table || name == "summary.json" {
            note_file(directory, name).expect("sums");
        }
    }
    let path = directory.join("manifest.json");
    let text = fs::read_to_string(&path).expect("written");
    let mut manifest: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let records = directory.join(manifest["records"].as_str().expect("a name"));
    if records.exists() {
        manifest["records_sha256"] = sha256::of_file(&records).expect("there").into();
    }
    manifest["manifest_sha256"] = "".into();
    let text = serde_json::to_string_pretty(&manifest).expect("JSON") + "\n";
    let sum = |sum: &str| format!("\"manifest_sha256\": \"{sum}\"");
    let own = sha256::of_bytes(text.as_bytes());
    fs::write(path, text.replacen(&sum(""), &sum(&own), 1)).expect("space");
    note_file(directory, "manifest.json").expect("sums");
}

/// The records of a file.
pub(crate) fn records(path: &Path) -> Vec<Record> {
    let mut records = Vec::new();
    ocmc_io::records::read(path, |group| records.extend(group.records)).expect("a file of records");
    records
}

//! Runs the command, and reads what it leaves behind.

use assert_cmd::Command;
use ocmc_core::record::Record;
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

/// Runs short cycles into a directory, and returns nothing but success.
pub(crate) fn run_into(directory: &Path, arguments: &[&str]) {
    let out = directory.to_str().expect("UTF-8");
    ocmc(&["--set", SHORT, "--quiet", "--out", out]).args(arguments).assert().success();
}

/// Makes of a run directory one as version 0.1.0 wrote it: without checksums, so that what a test
/// changes in it is looked at in every other way.
pub(crate) fn without_checksums(directory: &Path) {
    let _ = fs::remove_file(directory.join("checksums.sha256"));
    let path = directory.join("manifest.json");
    let text = fs::read_to_string(&path).expect("written");
    let mut manifest: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let keys = manifest.as_object_mut().expect("a table");
    keys.retain(|key, _| !key.ends_with("_sha256"));
    let mut text = serde_json::to_string_pretty(&manifest).expect("JSON");
    text.push('\n');
    fs::write(path, text).expect("space");
}

/// The records of a file.
pub(crate) fn records(path: &Path) -> Vec<Record> {
    let mut records = Vec::new();
    ocmc_io::records::read(path, |group| records.extend(group.records)).expect("a file of records");
    records
}

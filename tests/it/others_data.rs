//! Data of others that tests compare with, and the note of a test that found nothing to compare
//! with.
//!
//! Shared by the test executables of the workspace. See
//! `docs/decisions/2026-11-24-tests-that-compare-nothing.md`.

use std::fs::{File, create_dir_all};
use std::io::Write;
use std::path::{Path, PathBuf};

/// A file or folder of the data of others; none, with a note, where it is absent.
pub(crate) fn shared(name: &str) -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = if root.join("crates").is_dir() { root } else { root.ancestors().nth(2)? };
    let beside = || root.join("../shared/data");
    let folder = std::env::var_os("OCMC_DATA").map_or_else(beside, PathBuf::from);
    let path = folder.join(name);
    if !path.exists() {
        skipped(&format!("no {name} in OCMC_DATA or ../shared/data"));
        return None;
    }
    Some(path)
}

/// Notes that the calling test compared nothing, or not everything, and why. `scripts/check` reads
/// the notes out at its end: the test itself counts as passed.
pub(crate) fn skipped(reason: &str) {
    eprintln!("skipped: {reason}");
    let test = std::thread::current().name().unwrap_or("a thread of a test").to_owned();
    let note = format!("{} {test}\t{reason}\n", env!("CARGO_PKG_NAME"));
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    create_dir_all(folder).expect("a folder for the note");
    let file = File::options().create(true).append(true).open(folder.join("skipped-tests.txt"));
    file.and_then(|mut file| file.write_all(note.as_bytes())).expect("the note is written");
}

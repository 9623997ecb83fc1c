//! Says of each file of a run directory whether it is what was written.

use super::checksum::Checksums;
use super::chunks::{CHUNK_ROWS, is_chunk};
use super::read::{check_study, directory_of};
use super::{CHECKSUMS, CHUNKS, MANIFEST, Manifest, RunDirectoryError, RunStatus, read_manifest};
use crate::shell_word::resume_command;
use serde::Serialize;
use std::path::Path;

/// A run directory that was looked through.
#[derive(Clone, Debug, Serialize)]
pub struct Verified {
    /// How far its run has come; none where the manifest cannot be read, or where several runs have
    /// come differently far.
    pub status: Option<RunStatus>,
    /// Sentences on runs that are not complete: how far they are, and what finishes them.
    pub unfinished: Vec<String>,
    /// Its files, in the order of their names.
    pub files: Vec<CheckedFile>,
}

/// A file of a run directory.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CheckedFile {
    /// Its name in the directory.
    pub name: String,
    /// Fault of the file, in words.
    pub fault: Option<String>,
}

impl Verified {
    /// Whether every file is what was written.
    pub fn is_whole(&self) -> bool {
        self.files.iter().all(|file| file.fault.is_none())
    }
}

/// Checks every file that a run has written, of a run that has ended or of one that can be resumed.
///
/// # Errors
/// [`RunDirectoryError::NotARun`] where there is no run.
pub fn verify(directory: &Path) -> Result<Verified, RunDirectoryError> {
    let directory = directory_of(directory);
    let manifest = match read_manifest(directory) {
        Err(error @ RunDirectoryError::NotARun { .. }) => return Err(error),
        read => read,
    };
    let mut files: Vec<CheckedFile> = Vec::new();
    let sums = Checksums::read(directory);
    let names = match &sums {
        Ok(Some(sums)) => sums.names(),
        _ => Vec::new(),
    };
    let status = manifest.as_ref().ok().map(|manifest| manifest.status);
    let unfinished = manifest.as_ref().ok().and_then(|manifest| missing(directory, manifest));
    let expected = manifest.as_ref().map(files_of).unwrap_or_default();
    for name in &names {
        // that of a manifest which is under way is the one that it will have
        let is_ahead = *name == MANIFEST && status == Some(RunStatus::Running);
        // a chunk that the manifest does not count yet, or not any more
        let is_uncounted =
            is_chunk(name) && manifest.is_ok() && expected.iter().all(|file| file != name);
        if let (Ok(Some(sums)), false) = (&sums, is_ahead || is_uncounted) {
            files.push(noted(name, sums.check(name)));
        }
    }
    match &manifest {
        Ok(manifest) => {
            files.push(noted(MANIFEST, check_study(directory, manifest)));
            for name in expected.iter().filter(|name| !names.contains(&name.as_str())) {
                files.push(noted(name, Err(RunDirectoryError::without_sum(directory, name))));
            }
            if let Err(error) = sums {
                files.push(noted(CHECKSUMS, Err(error)));
            }
        }
        Err(_) => files.push(noted(MANIFEST, manifest.map(|_| ()))),
    }
    // of several faults of a file the first one
    files.sort_by(|a, b| (&a.name, a.fault.is_none()).cmp(&(&b.name, b.fault.is_none())));
    files.dedup_by(|later, first| later.name == first.name);
    Ok(Verified { status, unfinished: unfinished.into_iter().collect(), files })
}

/// Sentence on a run that is not complete: how far it is, and what finishes it.
fn missing(directory: &Path, manifest: &Manifest) -> Option<String> {
    let Manifest { status, completed, cycles, .. } = manifest;
    let (word, resume) = (status.name(), resume_command(directory));
    let text = format!("{completed} of {cycles} cycles, {word}; `{resume}` finishes it");
    (*status != RunStatus::Complete).then_some(text)
}

fn noted(name: &str, checked: Result<(), RunDirectoryError>) -> CheckedFile {
    CheckedFile { name: name.to_owned(), fault: checked.err().map(|error| error.to_string()) }
}

/// The files that a run in this state has.
fn files_of(manifest: &Manifest) -> Vec<String> {
    let chunks = manifest.completed.div_ceil(CHUNK_ROWS as u64);
    let ending = manifest.records.rsplit('.').next().unwrap_or_default();
    let chunks = (0..chunks).map(|k| format!("{CHUNKS}/{k:08}.{ending}"));
    let ended = [super::SUMMARY.to_owned(), manifest.records.clone()];
    match manifest.status {
        RunStatus::Running => chunks.collect(),
        RunStatus::Interrupted => chunks.chain(ended).collect(),
        RunStatus::Complete => ended.into(),
    }
}

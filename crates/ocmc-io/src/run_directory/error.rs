//! Errors of a run directory.

use super::fleet::runs_in;
use super::{CHECKSUMS, FORMAT_VERSION, MANIFEST, PROGRAM_VERSION};
use crate::file_error::FileError;
use crate::records::RecordsError;
use crate::shell_word::resume_command;
use crate::study::StudyFileError;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Most runs that are named of a folder that is none.
const MOST_NAMED: usize = 4;

/// Error of a run directory.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RunDirectoryError {
    /// There is a run already.
    #[error("`{}` already holds a run ({what})", path.display())]
    Exists {
        /// The directory.
        path: PathBuf,
        /// Name of the run, in words.
        what: String,
        /// Whether it can be resumed.
        unfinished: bool,
    },
    /// The path is a file.
    #[error("`{}` is a file, not a directory", .0.display())]
    NotADirectory(PathBuf),
    /// There is no run.
    #[error("`{}` is no run directory ({why}); `ocmc --out DIR` makes one", path.display())]
    NotARun {
        /// The path.
        path: PathBuf,
        /// Why not.
        why: String,
        /// Error of the system on its manifest.
        source: io::Error,
    },
    /// A run that is under way, or that was ended by force.
    #[error(
        "`{}` holds a run that was not ended ({completed} of {cycles} cycles, running); `{}` \
         finishes it",
        path.display(),
        resume_command(path)
    )]
    NotEnded {
        /// The directory.
        path: PathBuf,
        /// Cycles that are there.
        completed: u64,
        /// Cycles that were asked for.
        cycles: u64,
    },
    /// A run of another version of the program: which.
    #[error(
        "`{}` was written by version {} of the program; this is version {PROGRAM_VERSION} (layout \
         {FORMAT_VERSION}), and until 1.0 each version reads its own runs alone",
        .0.display(), .1
    )]
    OtherVersion(PathBuf, String),
    /// The directory or a file in it cannot be created, written or read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The manifest is not one, and why.
    #[error("`{}` is no manifest: {}", .0.display(), .1)]
    Manifest(PathBuf, serde_json::Error),
    /// The files of a directory do not fit together, and why.
    #[error("`{}` holds no run that can be read back: {}", .0.display(), .1)]
    NotWhole(PathBuf, String),
    /// A part of a run that was ended before its last cycle.
    #[error(
        "`{}` is not a whole part: it was interrupted after {completed} of its {cycles} cycles",
        path.display()
    )]
    NotFinished {
        /// The directory.
        path: PathBuf,
        /// Cycles that are there.
        completed: u64,
        /// Cycles that were asked for.
        cycles: u64,
        /// Command that finishes it.
        help: String,
    },
    /// A file does not hold the records that its manifest promises, and what is wrong.
    #[error("`{}` does not hold what its manifest says: {}", .0.display(), .1)]
    Damaged(PathBuf, String),
    /// A file that is not what was written.
    #[error(
        "`{}` was changed since it was written: it has another checksum than was noted then",
        .0.display()
    )]
    Changed(PathBuf),
    /// Another program writes to the directory at this moment.
    #[error("`{}` is being written by another program", .0.display())]
    Busy(PathBuf),
    /// Parts that are not those of one run: which, and why.
    #[error("these are not the parts of one run: {0}")]
    NotOneRun(String),
    /// The study that the manifest holds cannot be used, and why.
    #[error("the study in `{}` cannot be used: {}", .0.display(), .1)]
    Study(PathBuf, StudyFileError),
    /// The records cannot be written or read.
    #[error(transparent)]
    Records(#[from] RecordsError),
}

impl RunDirectoryError {
    /// Error of a file without a checksum; the file of checksums itself is missing.
    pub(super) fn without_sum(directory: &Path, name: &str) -> Self {
        let reason = match name {
            CHECKSUMS => "it is missing".to_owned(),
            _ => format!("`{CHECKSUMS}` has no checksum of it"),
        };
        Self::Damaged(directory.join(name), reason)
    }

    /// Error of a directory whose manifest cannot be read.
    pub(super) fn no_manifest(directory: &Path, source: io::Error) -> Self {
        let why = match source.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory if directory.is_file() => {
                "it is a file".to_owned()
            }
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => {
                let runs = runs_in(directory);
                let named = runs.iter().take(MOST_NAMED).map(|run| format!("`{}`", run.display()));
                let named = named.collect::<Vec<_>>().join(", ");
                match runs.len().saturating_sub(MOST_NAMED) {
                    _ if runs.is_empty() => format!("it holds no {MANIFEST}"),
                    0 => format!("it holds no {MANIFEST}, but runs: {named}"),
                    more => format!("it holds no {MANIFEST}, but runs: {named} and {more} more"),
                }
            }
            _ => return FileError::read(&directory.join(MANIFEST))(source).into(),
        };
        Self::NotARun { path: directory.to_owned(), why, source }
    }
}

//! Run directories: the records of one run, the manifest that says what they are, and the summary.
//!
//! The manifest is written first, replaced atomically after each group of rows, and says `complete` last: whatever
//! happens to the machine, a directory never claims more than it holds.

use crate::records::{self, RecordFormat, RecordWriter, RecordsError};
use crate::run_summary::RunSummary;
use crate::study::{resolved_toml, study_hash};
use ocmc_core::fleet::run::RunPlan;
use ocmc_core::fleet::summary::SummaryBuilder;
use ocmc_core::simulation::record::Record;
use ocmc_core::study::StudyModel;
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Version of the layout of a run directory.
pub const FORMAT_VERSION: u32 = 1;

/// Name of the manifest.
pub const MANIFEST: &str = "manifest.json";

/// Name of the summary.
pub const SUMMARY: &str = "summary.json";

/// What a run directory holds. A function of study, seed and range, like the records themselves.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the layout.
    pub format_version: u32,
    /// Version of the program that wrote it.
    pub program_version: String,
    /// How far the run has come.
    pub status: RunStatus,
    /// Name of the study.
    pub study: String,
    /// Hash of the resolved study.
    pub study_hash: String,
    /// Master seed.
    pub seed: u64,
    /// Id of the first cycle.
    pub first_cycle: u64,
    /// Number of cycles that were asked for.
    pub cycles: u64,
    /// Number of cycles, from the first one on, whose records are in the file.
    pub completed: u64,
    /// Name of the file of records.
    pub records: String,
    /// The resolved study, in TOML: a study file that repeats the run.
    pub resolved_study: String,
}

impl Manifest {
    /// What the run is, before its first cycle.
    pub fn new(study: &StudyModel, plan: &RunPlan) -> Self {
        Self {
            format_version: FORMAT_VERSION,
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            status: RunStatus::Running,
            study: study.study.name.clone(),
            study_hash: study_hash(study),
            seed: plan.seed,
            first_cycle: plan.first_cycle,
            cycles: plan.cycles,
            completed: 0,
            records: String::new(),
            resolved_study: resolved_toml(study),
        }
    }
}

/// How far a run has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RunStatus {
    /// Being written, or ended without a word: the file of records has no end.
    Running,
    /// Stopped on request: the file of records holds what was finished.
    Interrupted,
    /// Every cycle is there.
    Complete,
}

impl RunStatus {
    /// The word for it in a sentence.
    pub fn name(self) -> &'static str {
        match self {
            Self::Running => "running",
            Self::Interrupted => "interrupted",
            Self::Complete => "complete",
        }
    }
}

/// What can go wrong with a run directory.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RunDirectoryError {
    /// There is a run already.
    #[error("`{}` already holds a run ({what})", path.display())]
    Exists {
        /// The directory.
        path: PathBuf,
        /// Which run, in words.
        what: String,
    },
    /// The path is a file.
    #[error("`{}` is a file, not a directory", path.display())]
    NotADirectory {
        /// The path.
        path: PathBuf,
    },
    /// The directory cannot be created.
    #[error("cannot create the directory `{}`: {source}", path.display())]
    Create {
        /// The directory.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file in it cannot be written.
    #[error("cannot write `{}`: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file in it cannot be read.
    #[error("cannot read `{}`: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The manifest is not one.
    #[error("`{}` is no manifest: {source}", path.display())]
    Manifest {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
    /// The files do not fit together, or the run has no end.
    #[error("`{}` holds no run that can be read back: {reason}", path.display())]
    NotWhole {
        /// The directory.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// The records cannot be written or read.
    #[error(transparent)]
    Records(#[from] RecordsError),
}

/// A run directory that is being written.
#[derive(Debug)]
pub struct RunDirectory {
    path: PathBuf,
    manifest: Manifest,
    records: RecordWriter,
}

impl RunDirectory {
    /// Creates the directory, its manifest and an empty file of records. Status, number of completed cycles and name
    /// of the records in the manifest are set here.
    ///
    /// # Errors
    /// An existing run is left alone, whole or not.
    pub fn create(
        path: &Path,
        format: RecordFormat,
        manifest: Manifest,
    ) -> Result<Self, RunDirectoryError> {
        check_free(path)?;
        fs::create_dir_all(path)
            .map_err(|source| RunDirectoryError::Create { path: path.to_owned(), source })?;
        let manifest = Manifest {
            status: RunStatus::Running,
            completed: 0,
            records: format.file_name().to_owned(),
            ..manifest
        };
        write_manifest(path, &manifest)?;
        let records = RecordWriter::create(&path.join(format.file_name()), format)?;
        Ok(Self { path: path.to_owned(), manifest, records })
    }

    /// Takes the next records.
    pub fn add(&mut self, records: &[Record]) -> Result<(), RunDirectoryError> {
        if self.records.add(records)? {
            self.manifest.completed = self.records.written();
            write_manifest(&self.path, &self.manifest)?;
        }
        Ok(())
    }

    /// Completes the records, writes the summary, and then says in the manifest how far the run has come.
    pub fn finish(mut self, summary: &RunSummary) -> Result<Manifest, RunDirectoryError> {
        self.manifest.completed = self.records.finish()?;
        let all = self.manifest.completed == self.manifest.cycles;
        self.manifest.status = if all { RunStatus::Complete } else { RunStatus::Interrupted };
        replace(&self.path.join(SUMMARY), summary.to_json().as_bytes())?;
        write_manifest(&self.path, &self.manifest)?;
        Ok(self.manifest)
    }
}

/// Reads the manifest of a run directory.
pub fn read_manifest(directory: &Path) -> Result<Manifest, RunDirectoryError> {
    let path = directory.join(MANIFEST);
    let text = fs::read_to_string(&path)
        .map_err(|source| RunDirectoryError::Read { path: path.clone(), source })?;
    serde_json::from_str(&text).map_err(|source| RunDirectoryError::Manifest { path, source })
}

/// A run that was read back.
#[derive(Clone, Debug)]
pub struct StoredRun {
    /// What the run is.
    pub manifest: Manifest,
    /// Its records.
    pub records: Vec<Record>,
    /// What they add up to.
    pub summary: RunSummary,
}

/// What the summary of a run says that its records do not.
#[derive(Deserialize)]
struct Measured {
    wall_s: f64,
    threads: usize,
}

/// Reads a run back, whole or interrupted.
pub fn read(directory: &Path) -> Result<StoredRun, RunDirectoryError> {
    let not_whole =
        |reason: String| RunDirectoryError::NotWhole { path: directory.to_owned(), reason };
    let manifest = read_manifest(directory)?;
    if manifest.format_version != FORMAT_VERSION {
        let version = manifest.format_version;
        return Err(not_whole(format!(
            "format version {version}, this program reads {FORMAT_VERSION}"
        )));
    }
    if manifest.status == RunStatus::Running {
        return Err(not_whole("it was not ended".to_owned()));
    }
    let path = directory.join(SUMMARY);
    let text =
        fs::read_to_string(&path).map_err(|source| RunDirectoryError::Read { path, source })?;
    let Measured { wall_s, threads } =
        serde_json::from_str(&text).map_err(|error| not_whole(format!("`{SUMMARY}`: {error}")))?;
    let mut records = Vec::new();
    let mut fleet = SummaryBuilder::default();
    records::read(&directory.join(&manifest.records), |group| {
        fleet.add(&group);
        records.extend(group);
    })?;
    if records.len() as u64 != manifest.completed {
        let (rows, completed) = (records.len(), manifest.completed);
        return Err(not_whole(format!("{rows} records, but {completed} in `{MANIFEST}`")));
    }
    let summary = RunSummary::new(&manifest, fleet.finish(), wall_s, threads);
    Ok(StoredRun { manifest, records, summary })
}

/// Checks that a new run may be written to this path.
pub fn check_free(path: &Path) -> Result<(), RunDirectoryError> {
    let exists = |what: String| RunDirectoryError::Exists { path: path.to_owned(), what };
    match fs::metadata(path) {
        Ok(found) if !found.is_dir() => {
            return Err(RunDirectoryError::NotADirectory { path: path.to_owned() });
        }
        Ok(_) => (),
        // what is wrong with the path shows when the directory is created
        Err(_) => return Ok(()),
    }
    if path.join(MANIFEST).exists() {
        return Err(exists(match read_manifest(path) {
            Ok(found) => format!(
                "study `{}`, seed {}, {} of {} cycles, {}",
                found.study,
                found.seed,
                found.completed,
                found.cycles,
                found.status.name()
            ),
            Err(_) => format!("its `{MANIFEST}` cannot be read"),
        }));
    }
    let files = RecordFormat::ALL.map(RecordFormat::file_name).into_iter().chain([SUMMARY]);
    match files.into_iter().find(|file| path.join(file).exists()) {
        Some(file) => Err(exists(format!("`{file}` without a manifest"))),
        None => Ok(()),
    }
}

fn write_manifest(directory: &Path, manifest: &Manifest) -> Result<(), RunDirectoryError> {
    let mut text = serde_json::to_string_pretty(manifest).expect("numbers and words");
    text.push('\n');
    replace(&directory.join(MANIFEST), text.as_bytes())
}

/// Replaces a file in one go: whoever reads it sees the old text or the new one.
fn replace(path: &Path, text: &[u8]) -> Result<(), RunDirectoryError> {
    let mut name = path.as_os_str().to_owned();
    name.push(".tmp");
    let temporary = PathBuf::from(name);
    let write = || {
        let mut file = File::create(&temporary)?;
        file.write_all(text)?;
        file.sync_all()?;
        fs::rename(&temporary, path)
    };
    write().map_err(|source| {
        // a remnant would do no harm; what matters is the first error
        let _ = fs::remove_file(&temporary);
        RunDirectoryError::Write { path: path.to_owned(), source }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::records::{self, GROUP_ROWS, examples};
    use ocmc_core::fleet::summary::SummaryBuilder;

    fn manifest(cycles: u64) -> Manifest {
        Manifest {
            format_version: FORMAT_VERSION,
            program_version: "1.2.3".to_owned(),
            status: RunStatus::Complete,
            study: "s".to_owned(),
            study_hash: "00ff".to_owned(),
            seed: u64::MAX,
            first_cycle: 0,
            cycles,
            completed: 7,
            records: String::new(),
            resolved_study: "a = 1\n".to_owned(),
        }
    }

    fn summary(records: &[Record]) -> RunSummary {
        let mut builder = SummaryBuilder::default();
        builder.add(records);
        RunSummary {
            study: "s".to_owned(),
            study_hash: "00ff".to_owned(),
            seed: u64::MAX,
            first_cycle: 0,
            summary: builder.finish(),
            wall_s: 1.5,
            threads: 2,
        }
    }

    #[test]
    fn a_complete_run() {
        let directory = tempfile::tempdir().expect("a directory");
        for format in RecordFormat::ALL {
            let path = directory.path().join("new").join(format.name());
            let rows = examples::records(GROUP_ROWS as u64 + 10);
            let mut run =
                RunDirectory::create(&path, format, manifest(rows.len() as u64)).expect("free");
            let started = read_manifest(&path).expect("written first");
            assert_eq!((started.status, started.completed), (RunStatus::Running, 0));
            run.add(&rows[..GROUP_ROWS]).expect("space");
            assert_eq!(read_manifest(&path).expect("replaced").completed, GROUP_ROWS as u64);
            run.add(&rows[GROUP_ROWS..]).expect("space");
            let done = run.finish(&summary(&rows)).expect("space");
            assert_eq!((done.status, done.completed), (RunStatus::Complete, rows.len() as u64));
            assert_eq!(read_manifest(&path).expect("replaced"), done);
            assert_eq!(done.seed, u64::MAX);
            let mut back = Vec::new();
            records::read(&path.join(&done.records), |group| back.extend(group)).expect("complete");
            assert!(back == rows);
            let stored = read(&path).expect("complete");
            assert!(stored.records == rows && stored.manifest == done);
            assert_eq!(stored.summary.to_json(), summary(&rows).to_json());
            let text = fs::read_to_string(path.join(SUMMARY)).expect("written");
            let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
            assert_eq!(json["cycles"], rows.len());
            assert_eq!(fs::read_dir(&path).expect("there").count(), 3, "no remnants");
        }
    }

    #[test]
    fn an_interrupted_run_keeps_what_was_finished() {
        let directory = tempfile::tempdir().expect("a directory");
        let rows = examples::records(100);
        let mut run = RunDirectory::create(directory.path(), RecordFormat::Parquet, manifest(1000))
            .expect("empty");
        run.add(&rows).expect("space");
        let done = run.finish(&summary(&rows)).expect("space");
        assert_eq!((done.status, done.completed), (RunStatus::Interrupted, 100));
        assert_eq!(read(directory.path()).expect("ended").records.len(), 100);
    }

    #[test]
    fn what_is_not_whole_is_not_read_back() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path();
        let error = || read(path).expect_err("no whole run").to_string();
        assert!(error().contains(MANIFEST));
        let rows = examples::records(5);
        let mut run = RunDirectory::create(path, RecordFormat::Csv, manifest(5)).expect("empty");
        run.add(&rows).expect("space");
        assert!(error().contains("not ended"), "{}", error());
        run.finish(&summary(&rows)).expect("space");
        let mut done = read_manifest(path).expect("whole");
        done.completed = 4;
        write_manifest(path, &done).expect("space");
        assert!(error().contains("5 records, but 4"), "{}", error());
        done.format_version = FORMAT_VERSION + 1;
        write_manifest(path, &done).expect("space");
        assert!(error().contains("format version"), "{}", error());
        fs::write(path.join(MANIFEST), "{").expect("space");
        assert!(error().contains("no manifest"), "{}", error());
    }

    #[test]
    fn an_existing_run_is_left_alone() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path();
        RunDirectory::create(path, RecordFormat::Csv, manifest(5)).expect("empty");
        let error =
            RunDirectory::create(path, RecordFormat::Parquet, manifest(5)).expect_err("a run");
        assert!(error.to_string().contains("0 of 5 cycles, running"), "{error}");
        fs::remove_file(path.join(MANIFEST)).expect("there");
        let error =
            RunDirectory::create(path, RecordFormat::Parquet, manifest(5)).expect_err("a run");
        assert!(error.to_string().contains("records.csv"), "{error}");
    }

    #[test]
    fn paths_that_cannot_be_are_errors_with_their_names() {
        let directory = tempfile::tempdir().expect("a directory");
        let file = directory.path().join("plain");
        fs::write(&file, "").expect("space");
        for path in [file.clone(), file.join("below")] {
            let error =
                RunDirectory::create(&path, RecordFormat::Csv, manifest(1)).expect_err("a file");
            assert!(error.to_string().contains("plain"), "{error}");
        }
    }
}

//! Run directories: the records of one run, the manifest that says what they are, and the summary.
//!
//! The manifest is written first, replaced atomically after each chunk of rows, and says `complete`
//! last: whatever happens to the machine, a directory never claims more than it holds. A run that
//! was ended in any moment, power cut included, is resumed from its last chunk, and becomes the
//! same bytes as one that was never ended.

mod assembly;
mod checksum;
mod chunks;
mod durable;
mod error;
mod fleet;
mod merge;
mod read;
mod summary;
mod verify;

pub use checksum::{CHECKSUMS, note_file};
pub use chunks::{CHUNK_ROWS, CHUNKS};
pub use error::RunDirectoryError;
pub use fleet::{FLEET, check_free_of_groups, runs_in};
pub use merge::merge;
pub use read::{StoredRun, Unfinished, directory_of, read, read_groups, records_file, unfinished};
pub use summary::{FEW_CYCLES, JudgedMean, RunSummary, now};
pub use verify::{CheckedFile, Verified, verify};

use crate::charging_table::{CHARGINGS, LOADS, loads_batch};
use crate::file_error::FileError;
use crate::given_drive::{Followed, GivenDrive};
use crate::input_file;
use crate::records::RecordFormat;
use crate::sha256;
use crate::study::{JudgedDoubt, LoadedStudy, resolved_toml, study_hash};
use crate::table_file::encoded;
use crate::trucks::{self, TRUCKS};
use checksum::Checksums;
use chunks::{Chunks, is_chunk};
use durable::{create_directories, replace};
use ocmc_core::cost::CostModel;
use ocmc_core::operating_cycle::route::RouteModel;
use ocmc_core::random::sampling::Sampling;
use ocmc_core::record::Record;
use ocmc_core::study::fleet::FleetModel;
use ocmc_core::study::uncertainty::numbers_without_error;
use ocmc_core::vehicle::VehicleModel;
use ocmc_fleet::cost::TripPrices;
use ocmc_fleet::dependence::Dependence;
use ocmc_fleet::precision::Precision;
use ocmc_fleet::run::RunPlan;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::{Path, PathBuf};

/// Version of the layout of a run directory.
pub const FORMAT_VERSION: u32 = 1;

/// Version of the program.
const PROGRAM_VERSION: &str = env!("CARGO_PKG_VERSION");

/// Name of the manifest.
pub const MANIFEST: &str = "manifest.json";

/// Name of the summary.
pub const SUMMARY: &str = "summary.json";

/// Contents of a run directory. A function of study, seed and range, like the records themselves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Version of the layout.
    pub format_version: u32,
    /// Version of the program that wrote it.
    pub program_version: String,
    /// How far the run has come.
    pub status: RunStatus,
    /// Name of the study, and what was driven instead of its roads.
    pub study: String,
    /// Hash of the resolved study.
    pub study_hash: String,
    /// Master seed.
    pub seed: u64,
    /// Id of the first cycle.
    pub first_cycle: u64,
    /// Number of cycles that were asked for.
    pub cycles: u64,
    /// Number of cycles, from the first one on, whose records are there.
    pub completed: u64,
    /// Name of the file of records.
    pub records: String,
    /// The speed that the trucks follow; absent where drivers drive by themselves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub followed: Option<Followed>,
    /// At which precision the run may end before its last cycle; a run that has ended has its
    /// number of cycles instead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub precision: Option<Precision>,
    /// Effect of judged numbers on the mean; absent where nothing is judged.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub judged: Option<JudgedDoubt>,
    /// The resolved study, in TOML: a study file that, with what is followed, repeats the run.
    pub resolved_study: String,
    /// SHA-256 of the file of records; absent before it is there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub records_sha256: Option<String>,
    /// SHA-256 of the manifest's own text with nothing between the quotes of this value.
    pub manifest_sha256: String,
}

impl Manifest {
    /// Manifest of the run, before its first cycle.
    pub fn new(loaded: &LoadedStudy, plan: &RunPlan, given: &GivenDrive) -> Self {
        let study = &loaded.model;
        let judged = loaded.judged_doubt();
        // effects are stored of trucks on the roads of the study
        let on_its_roads = given.is_nothing();
        let stored = |doubt: JudgedDoubt| JudgedDoubt {
            stored: doubt.stored.filter(|_| on_its_roads),
            ..doubt
        };
        Self {
            format_version: FORMAT_VERSION,
            program_version: PROGRAM_VERSION.to_owned(),
            status: RunStatus::Running,
            study: given.name_of_run(&study.study.name),
            study_hash: study_hash(study),
            seed: plan.seed,
            first_cycle: plan.first_cycle,
            cycles: plan.cycles,
            completed: 0,
            records: String::new(),
            followed: given.followed(),
            precision: None,
            judged: judged.map(stored),
            resolved_study: resolved_toml(study),
            records_sha256: None,
            manifest_sha256: String::new(),
        }
    }

    /// Version of the program that wrote this text, whatever else is in it; none for this version.
    pub fn other_version(text: &str) -> Option<String> {
        let Stamp { format_version, program_version } = serde_json::from_str(text).ok()?;
        let is_ours = (format_version, &*program_version) == (FORMAT_VERSION, PROGRAM_VERSION);
        (!is_ours).then(|| format!("{program_version} (layout {format_version})"))
    }

    /// A value of the resolved study, by its dotted path.
    pub(crate) fn value(&self, path: &str) -> Option<toml::Value> {
        let study = toml::Value::Table(self.resolved_study.parse().unwrap_or_default());
        path.split('.').try_fold(&study, |value, key| value.get(key)).cloned()
    }

    /// Numbers of its study that have no standard error, counted by table; `known` has the keys of
    /// those that have one.
    pub fn numbers_without_error(&self, known: &[&str]) -> Vec<(String, usize)> {
        let study: toml::Table = self.resolved_study.parse().unwrap_or_default();
        let study = serde_json::to_value(study).unwrap_or_default();
        numbers_without_error(&study, known)
    }

    /// The routes of its study.
    pub fn routes(&self) -> Vec<RouteModel> {
        let routes = self.value("mission.routes");
        routes.and_then(|routes| routes.try_into().ok()).unwrap_or_default()
    }

    /// Prices of its study's trips; none where it has none.
    pub fn prices(&self) -> Option<TripPrices> {
        let cost: CostModel = self.value("cost")?.try_into().ok()?;
        let vehicle: VehicleModel = self.value("vehicle")?.try_into().ok()?;
        Some(TripPrices::new(&cost, &vehicle))
    }

    /// Dependence between the cycles.
    pub fn dependence(&self) -> Dependence {
        let uncertain = self.value("driver.curve_speed.parameter_uncertainty");
        let replicates = self.value("driver.curve_speed.replicates");
        let replicates = replicates.and_then(|value| u64::try_from(value.as_integer()?).ok());
        let replicates = replicates.filter(|_| uncertain == Some(true.into()));
        let sampling = self.value("simulation.sampling");
        let sampling: Option<Sampling> = sampling.and_then(|value| value.try_into().ok());
        let fleet = self.value("fleet").and_then(|fleet| fleet.try_into().ok());
        let fleet: FleetModel = fleet.unwrap_or_default();
        let replicates = replicates.map(|replicates: u64| replicates.max(1));
        Dependence::of_fleet(&fleet, sampling.unwrap_or_default(), replicates, self.seed)
    }
}

/// Keys that manifests of all versions have.
#[derive(Deserialize)]
struct Stamp {
    format_version: u32,
    program_version: String,
}

/// How far a run has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RunStatus {
    /// Being written, or ended without a word: what was finished lies in the chunks.
    Running,
    /// Stopped on request: the file of records holds what was finished, and so do the chunks.
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

/// A run directory that is being written.
#[derive(Debug)]
pub struct RunDirectory {
    path: PathBuf,
    manifest: Manifest,
    chunks: Chunks,
    /// Full chunks on the disk.
    full: u64,
    /// Records of the chunk that is not full yet.
    waiting: Vec<Record>,
    /// Whether something is missing but cycles.
    open: bool,
}

impl RunDirectory {
    /// Creates the directory and its manifest. Status, number of completed cycles and name of the
    /// records in the manifest are set here.
    ///
    /// # Errors
    /// An existing run is left alone, whole or not.
    pub fn create(
        path: &Path,
        format: RecordFormat,
        manifest: Manifest,
    ) -> Result<Self, RunDirectoryError> {
        check_free(path)?;
        create_directories(path)?;
        let manifest = Manifest {
            status: RunStatus::Running,
            completed: 0,
            records: format.file_name().to_owned(),
            records_sha256: None,
            ..manifest
        };
        write_manifest(path, &manifest)?;
        let chunks = Chunks::open(path, format, || Checksums::create(path))?;
        let (path, waiting) = (path.to_owned(), Vec::new());
        Ok(Self { path, manifest, chunks, full: 0, waiting, open: false })
    }

    /// Takes up an unfinished run, whose study is given. `sink` receives the records that are there
    /// already.
    ///
    /// The last record of each chunk is driven again, so that a chunk of another study or one that
    /// was changed is found.
    ///
    /// # Errors
    /// Names the chunk that is not what the manifest says.
    pub fn resume(
        unfinished: &Unfinished,
        sink: impl FnMut(&[Record]),
    ) -> Result<Self, RunDirectoryError> {
        let path = unfinished.path.clone();
        let mut chunks =
            Chunks::open(&path, unfinished.format, || match Checksums::read(&path)? {
                Some(sums) => Ok(sums),
                // ended between its manifest and its sums: there is nothing yet to have a sum
                None if unfinished.manifest.completed == 0 => Checksums::create(&path),
                None => Err(RunDirectoryError::without_sum(&path, CHECKSUMS)),
            })?;
        // as it is now that no other process writes
        let (status, records_sha256) = (RunStatus::Running, None);
        let manifest = Manifest { status, records_sha256, ..read_manifest(&path)? };
        let (full, waiting) = read_chunks(&chunks, &manifest, unfinished, sink)?;
        // first, so that no manifest of an ended run is without the sums of its files
        write_manifest(&path, &manifest)?;
        // the other files are written anew
        chunks.sums().retain(is_chunk);
        chunks.sums().write()?;
        Ok(Self { path, manifest, chunks, full, waiting, open: false })
    }

    /// Takes the next records. They are counted once they are on the disk, some chunks later.
    pub fn add(&mut self, records: &[Record]) -> Result<(), RunDirectoryError> {
        self.waiting.extend_from_slice(records);
        let mut used = 0;
        while let Some(rows) = self.waiting.get(used..used + CHUNK_ROWS) {
            self.chunks.begin(self.begun(), rows.to_vec());
            used += CHUNK_ROWS;
            let written = self.chunks.settle()?;
            self.count(written)?;
        }
        self.waiting.drain(..used);
        Ok(())
    }

    /// Waits until all full chunks are on the disk.
    pub fn settle(&mut self) -> Result<(), RunDirectoryError> {
        let written = self.chunks.place(usize::MAX)?;
        self.count(written)
    }

    /// Full chunks, those included that are not on the disk yet.
    fn begun(&self) -> u64 {
        self.full + self.chunks.under_way()
    }

    /// Says in the manifest that more chunks are on the disk.
    fn count(&mut self, written: u64) -> Result<(), RunDirectoryError> {
        if written == 0 {
            return Ok(());
        }
        self.full += written;
        self.manifest.completed = self.full * CHUNK_ROWS as u64;
        write_manifest(&self.path, &self.manifest)
    }

    /// The run is complete with the cycles that it has: it knows its answer precisely enough. The
    /// directory is then that of a run of so many cycles.
    pub fn end_here(&mut self) {
        self.manifest.cycles = self.begun() * CHUNK_ROWS as u64 + self.waiting.len() as u64;
    }

    /// The run has all its cycles, and not yet all of its answer.
    pub fn leave_open(&mut self) {
        self.open = true;
    }

    /// Completes the records, writes the summary, and then says in the manifest how far the run has
    /// come.
    pub fn finish(mut self, summary: &RunSummary) -> Result<Manifest, RunDirectoryError> {
        self.settle()?;
        if !self.waiting.is_empty() {
            self.chunks.write(self.full, &self.waiting)?;
        }
        self.manifest.completed = self.full * CHUNK_ROWS as u64 + self.waiting.len() as u64;
        let all = self.manifest.completed == self.manifest.cycles && !self.open;
        write_manifest(&self.path, &self.manifest)?;
        let threads = assembly::threads(summary.threads);
        self.assemble(threads)?;
        replace(&self.path.join(SUMMARY), summary.to_json().as_bytes())?;
        let (path, format) = (&self.path, self.chunks.format);
        let beside =
            |name, table| replace(&path.join(format.file_of(name)), &encoded(&table, format));
        if let Some(trucks) = &summary.summary.trucks {
            beside(TRUCKS, trucks::record_batch(&trucks.rows))?;
        }
        if let Some(loads) = &summary.summary.loads {
            beside(LOADS, loads_batch(&loads.rows))?;
            self.assemble_chargings(threads)?;
        }
        self.manifest.status = if all { RunStatus::Complete } else { RunStatus::Interrupted };
        if all {
            // until now: a program that is ended before has its answer to say again
            self.manifest.precision = None;
        }
        self.seal()?;
        if all {
            self.chunks.remove()?;
        }
        Ok(self.manifest)
    }

    /// Writes the checksums of the files as they are now, and the manifest that has them.
    fn seal(&mut self) -> Result<(), RunDirectoryError> {
        let directory = &self.path;
        let sum = |name: &str| {
            let path = directory.join(name);
            sha256::of_file(&path).map_err(FileError::read(&path))
        };
        let (summary, records) = (sum(SUMMARY)?, sum(&self.manifest.records)?);
        self.manifest.records_sha256 = Some(records.clone());
        let text = manifest_text(&mut self.manifest);
        let (format, sums) = (self.chunks.format, self.chunks.sums());
        sums.set(SUMMARY, summary);
        for name in tables_beside(format).iter().filter(|name| directory.join(name).exists()) {
            sums.set(name, sum(name)?);
        }
        sums.set(&self.manifest.records, records);
        sums.set(MANIFEST, sha256::of_bytes(text.as_bytes()));
        sums.write()?;
        replace(&directory.join(MANIFEST), text.as_bytes())
    }
}

/// Names of the tables that a run may have beside its records of that format.
pub(super) fn tables_beside(format: RecordFormat) -> [String; 3] {
    [TRUCKS, CHARGINGS, LOADS].map(|table| format.file_of(table))
}

/// Reads what an unfinished run has: the number of full chunks, and the rows of the one that is not
/// full.
fn read_chunks(
    chunks: &Chunks,
    manifest: &Manifest,
    unfinished: &Unfinished,
    mut sink: impl FnMut(&[Record]),
) -> Result<(u64, Vec<Record>), RunDirectoryError> {
    let rows = CHUNK_ROWS as u64;
    let (full, rest) = (manifest.completed / rows, (manifest.completed % rows) as usize);
    let mut waiting = Vec::new();
    let mut last = Vec::new();
    for k in 0..full + u64::from(rest > 0) {
        let wanted = if k < full { CHUNK_ROWS } else { rest };
        let records = chunks.read(k, manifest.first_cycle + k * rows, wanted)?;
        sink(&records);
        last.extend(records.last().map(|record| (chunks.path(k), record.clone())));
        if k == full {
            waiting = records;
        }
    }
    read::check_by_driving(&unfinished.study.study, &unfinished.given, manifest.seed, &last)?;
    Ok((full, waiting))
}

/// Reads the manifest of a run directory.
///
/// # Errors
/// [`RunDirectoryError`] where there is none, or its numbers cannot be.
pub fn read_manifest(directory: &Path) -> Result<Manifest, RunDirectoryError> {
    let path = directory.join(MANIFEST);
    let text = input_file::read_to_string(&path)
        .map_err(|source| RunDirectoryError::no_manifest(directory, source))?;
    if let Some(version) = Manifest::other_version(&text) {
        return Err(RunDirectoryError::OtherVersion(directory.to_owned(), version));
    }
    let manifest: Manifest = serde_json::from_str(&text)
        .map_err(|error| RunDirectoryError::Manifest(path.clone(), error))?;
    let sum = &manifest.manifest_sha256;
    if sha256::of_bytes(text.replacen(&own_sum(sum), &own_sum(""), 1).as_bytes()) != *sum {
        return Err(RunDirectoryError::Changed(path));
    }
    let Manifest { first_cycle, cycles, completed, .. } = manifest;
    let reason = if completed > cycles {
        format!("{completed} of {cycles} cycles are completed, allowed are at most {cycles}")
    } else if first_cycle.checked_add(cycles).is_none() {
        format!("{cycles} cycles from id {first_cycle} on go beyond the largest id")
    } else {
        return Ok(manifest);
    };
    Err(RunDirectoryError::Damaged(path, reason))
}

/// Checks that a new run may be written to this path.
pub fn check_free(path: &Path) -> Result<(), RunDirectoryError> {
    let exists = |what: String, unfinished: bool| RunDirectoryError::Exists {
        path: path.to_owned(),
        what,
        unfinished,
    };
    // what else is wrong with the path shows when the directory is created
    let Ok(metadata) = fs::metadata(path) else { return Ok(()) };
    if !metadata.is_dir() {
        return Err(RunDirectoryError::NotADirectory(path.to_owned()));
    }
    if path.join(MANIFEST).exists() {
        return Err(match read_manifest(path) {
            Ok(manifest) => {
                let Manifest { study, seed, completed, cycles, status, .. } = manifest;
                let how_far = format!("{completed} of {cycles} cycles, {}", status.name());
                let what = format!("study `{study}`, seed {seed}, {how_far}");
                exists(what, status != RunStatus::Complete)
            }
            Err(_) => exists(format!("its `{MANIFEST}` cannot be read"), false),
        });
    }
    let files = RecordFormat::ALL.map(RecordFormat::file_name).into_iter().chain([SUMMARY, CHUNKS]);
    match files.into_iter().find(|file| path.join(file).exists()) {
        Some(file) => Err(exists(format!("`{file}` without a manifest"), false)),
        None => Ok(()),
    }
}

fn write_manifest(directory: &Path, manifest: &Manifest) -> Result<(), RunDirectoryError> {
    let text = manifest_text(&mut manifest.clone());
    replace(&directory.join(MANIFEST), text.as_bytes())
}

/// A manifest as it is written, with the checksum of its own text.
fn manifest_text(manifest: &mut Manifest) -> String {
    manifest.manifest_sha256 = String::new();
    let text = indented(manifest);
    let sum = sha256::of_bytes(text.as_bytes());
    let text = text.replacen(&own_sum(""), &own_sum(&sum), 1);
    manifest.manifest_sha256 = sum;
    text
}

/// How a manifest says the checksum of its own text.
fn own_sum(sum: &str) -> String {
    format!("\"manifest_sha256\": \"{sum}\"")
}

fn indented(value: &impl Serialize) -> String {
    serde_json::to_string_pretty(value).expect("numbers, and keys that are words") + "\n"
}

#[cfg(test)]
pub(super) mod tests {
    use super::durable::temporary;
    use super::*;
    use crate::records::{self, GROUP_ROWS, examples};
    use crate::study::hash_of_resolved;
    use ocmc_fleet::summary::SummaryBuilder;

    pub(super) fn manifest(cycles: u64) -> Manifest {
        Manifest {
            format_version: FORMAT_VERSION,
            program_version: PROGRAM_VERSION.to_owned(),
            status: RunStatus::Complete,
            study: "s".to_owned(),
            study_hash: hash_of_resolved("a = 1\n").expect("TOML"),
            seed: u64::MAX,
            first_cycle: 0,
            cycles,
            completed: 7,
            records: String::new(),
            followed: None,
            precision: None,
            judged: None,
            resolved_study: "a = 1\n".to_owned(),
            records_sha256: None,
            manifest_sha256: String::new(),
        }
    }

    fn summary(records: &[Record]) -> RunSummary {
        let mut builder = SummaryBuilder::default();
        builder.add(records);
        RunSummary {
            note: None,
            study: "s".to_owned(),
            study_hash: manifest(0).study_hash,
            seed: u64::MAX,
            first_cycle: 0,
            summary: builder.finish(),
            judged: None,
            precision: None,
            ended_at: "2026-11-24T21:04:00Z".to_owned(),
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
            // those that are being written are not counted; how many depends on the machine
            let counted = || read_manifest(&path).expect("replaced").completed;
            assert_eq!(counted(), run.full * CHUNK_ROWS as u64);
            assert_eq!(run.begun() * CHUNK_ROWS as u64, GROUP_ROWS as u64);
            run.settle().expect("space");
            assert_eq!(counted(), GROUP_ROWS as u64);
            run.add(&rows[GROUP_ROWS..]).expect("space");
            let done = run.finish(&summary(&rows)).expect("space");
            assert_eq!((done.status, done.completed), (RunStatus::Complete, rows.len() as u64));
            assert_eq!(read_manifest(&path).expect("replaced"), done);
            assert_eq!(done.seed, u64::MAX);
            let mut back = Vec::new();
            records::read(&path.join(&done.records), |group| back.extend(group.records))
                .expect("complete");
            assert!(back == rows);
            let stored = read(&path).expect("complete");
            assert!(stored.records == rows && stored.manifest == done);
            assert_eq!(stored.summary.to_json(), summary(&rows).to_json());
            let text = fs::read_to_string(path.join(SUMMARY)).expect("written");
            let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
            assert_eq!(json["cycles"], rows.len());
            let files = || fs::read_dir(&path).expect("there").count();
            // records, summary, manifest, checksums
            assert_eq!(files(), 4, "no remnants");
            // ended while it took the sums of the chunks out of the file of sums
            let sums = path.join(CHECKSUMS);
            let whole = fs::read_to_string(&sums).expect("written");
            let chunk = format!("{:064}  {CHUNKS}/00000000.{}\n", 0, format.name());
            fs::write(&sums, chunk + &whole).expect("ours");
            fs::write(temporary(&sums), &whole[..20]).expect("ours");
            let files_of_studies = crate::study::Files::here();
            assert!(unfinished(&path, &files_of_studies).expect("complete").is_none());
            assert_eq!(files(), 4, "no remnants");
            assert_eq!(fs::read_to_string(&sums).expect("written"), whole);
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
        assert!(error().contains("layout 2"), "{}", error());
        fs::write(path.join(MANIFEST), "{").expect("space");
        assert!(error().contains("no manifest"), "{}", error());
    }

    #[test]
    fn an_existing_run_is_left_alone() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path();
        drop(RunDirectory::create(path, RecordFormat::Csv, manifest(5)).expect("empty"));
        let error =
            RunDirectory::create(path, RecordFormat::Parquet, manifest(5)).expect_err("a run");
        assert!(error.to_string().contains("0 of 5 cycles, running"), "{error}");
        fs::remove_file(path.join(MANIFEST)).expect("there");
        let error =
            RunDirectory::create(path, RecordFormat::Parquet, manifest(5)).expect_err("a run");
        assert!(error.to_string().contains("`chunks` without a manifest"), "{error}");
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

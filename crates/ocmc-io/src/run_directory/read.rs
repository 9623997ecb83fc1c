//! Reads run directories: whole ones, and what is needed to go on with unfinished ones.

use super::checksum::Checksums;
use super::chunks::{CHUNKS, check_rows, remove_left_over};
use super::error::RunDirectoryError;
use super::{CHECKSUMS, MANIFEST, Manifest, RunStatus, RunSummary, SUMMARY, read_manifest};
use crate::file_error::FileError;
use crate::given_drive::GivenDrive;
use crate::input_file;
use crate::records::{self, Group, RecordFormat};
use crate::sha256;
use crate::study::{self, Files, Given, LoadedStudy, hash_of_resolved};
use ocmc_core::record::Record;
use ocmc_core::study::Study;
use ocmc_fleet::adjustment::AdjustedStatistic;
use ocmc_fleet::summary::{Summary, SummaryBuilder};
use ocmc_fleet::uncertainty::ParameterUncertainty;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A run that was read back.
#[derive(Clone, Debug)]
pub struct StoredRun {
    /// Manifest of the run.
    pub manifest: Manifest,
    /// Its records.
    pub records: Vec<Record>,
    /// Totals of its cycles.
    pub summary: RunSummary,
}

/// Values in the summary of a run that its records do not hold.
#[derive(Deserialize)]
pub(super) struct Measured {
    pub(super) wall_s: f64,
    pub(super) threads: usize,
    pub(super) ended_at: String,
    #[serde(default)]
    pub(super) parameter_uncertainty: Option<ParameterUncertainty>,
    #[serde(default)]
    pub(super) statistics: BTreeMap<String, MeasuredStatistic>,
}

/// The adjusted values of a quantity, which the records alone do not give.
#[derive(Deserialize)]
pub(super) struct MeasuredStatistic {
    #[serde(default)]
    adjusted: Option<AdjustedStatistic>,
}

/// The run directory that a path means: the one around it, where it is that of a manifest.
pub fn directory_of(path: &Path) -> &Path {
    if path.file_name().is_none_or(|name| name != MANIFEST) || !path.is_file() {
        return path;
    }
    let around = path.parent().filter(|around| !around.as_os_str().is_empty());
    around.unwrap_or(Path::new("."))
}

/// Reads a run back, whole or interrupted, from its directory or by the name of its manifest.
pub fn read(directory: &Path) -> Result<StoredRun, RunDirectoryError> {
    let mut records = Vec::new();
    let (manifest, summary) = read_groups(directory, |group| records.extend(group.records))?;
    Ok(StoredRun { manifest, records, summary })
}

/// As [`read`], with the records in groups of rows.
///
/// # Errors
/// As [`read`].
pub fn read_groups(
    directory: &Path,
    mut sink: impl FnMut(Group),
) -> Result<(Manifest, RunSummary), RunDirectoryError> {
    let directory = directory_of(directory);
    let manifest = ended(directory)?;
    let Measured { wall_s, threads, ended_at, parameter_uncertainty, mut statistics } =
        measured(directory)?;
    let mut fleet = SummaryBuilder::new(manifest.dependence()).priced(manifest.prices());
    read_records(directory, &manifest, |group| {
        fleet.add(&group.records);
        sink(group);
        Ok(())
    })?;
    let mut summary = Summary { parameter_uncertainty, ..fleet.finish() };
    for statistic in &mut summary.statistics {
        let known = statistics.remove(statistic.column);
        statistic.adjusted = known.and_then(|known| known.adjusted);
    }
    let summary = RunSummary::new(&manifest, summary, wall_s, threads);
    Ok((manifest, RunSummary { ended_at, ..summary }))
}

/// The file of the records of a run that was ended, checked against its checksum.
///
/// # Errors
/// As [`read`].
pub fn records_file(directory: &Path) -> Result<PathBuf, RunDirectoryError> {
    let directory = directory_of(directory);
    Ok(directory.join(ended(directory)?.records))
}

/// The manifest of a run that was ended, whole or interrupted.
pub(super) fn ended(directory: &Path) -> Result<Manifest, RunDirectoryError> {
    let manifest = read_manifest(directory)?;
    if manifest.status == RunStatus::Running {
        let Manifest { completed, cycles, .. } = manifest;
        let path = directory.to_owned();
        return Err(RunDirectoryError::NotEnded { path, completed, cycles });
    }
    check_sums(directory, &manifest)?;
    Ok(manifest)
}

/// Checks the files of an ended run against their checksums, and the study
/// against its hash.
fn check_sums(directory: &Path, manifest: &Manifest) -> Result<(), RunDirectoryError> {
    check_study(directory, manifest)?;
    let sums = Checksums::read(directory)?
        .ok_or_else(|| RunDirectoryError::without_sum(directory, CHECKSUMS))?;
    // report and workbook may be written anew
    let own = [CHECKSUMS, MANIFEST, manifest.records.as_str()];
    let is_page = |name: &str| {
        Path::new(name).extension().is_some_and(|ending| ending == "html" || ending == "xlsx")
    };
    let is_other = |name: &&str| name.starts_with(CHUNKS) || is_page(name);
    for name in sums.names().into_iter().filter(|name| !own.contains(name) && !is_other(name)) {
        sums.check(name)?;
    }
    let path = directory.join(&manifest.records);
    let sum = sha256::of_file(&path).map_err(FileError::read(&path))?;
    if manifest.records_sha256.as_ref() == Some(&sum) {
        return Ok(());
    }
    Err(RunDirectoryError::Changed(path))
}

/// Checks the study of a manifest against its hash.
pub(super) fn check_study(directory: &Path, manifest: &Manifest) -> Result<(), RunDirectoryError> {
    match hash_of_resolved(&manifest.resolved_study) {
        Some(hash) if hash == manifest.study_hash => Ok(()),
        Some(hash) => Err(other_hash(directory, &hash, manifest)),
        None => Err(other_hash(directory, "of no TOML", manifest)),
    }
}

fn other_hash(directory: &Path, hash: &str, manifest: &Manifest) -> RunDirectoryError {
    let reason = format!("its study has the hash {hash}, not {}", manifest.study_hash);
    RunDirectoryError::Damaged(directory.join(MANIFEST), reason)
}

pub(super) fn measured(directory: &Path) -> Result<Measured, RunDirectoryError> {
    let path = directory.join(SUMMARY);
    let text = input_file::read_to_string(&path).map_err(FileError::read(&path))?;
    serde_json::from_str(&text).map_err(|error| {
        RunDirectoryError::NotWhole(directory.to_owned(), format!("`{SUMMARY}`: {error}"))
    })
}

/// Hands the records of an ended run over, group by group, and checks that they are those of its
/// manifest.
pub(super) fn read_records(
    directory: &Path,
    manifest: &Manifest,
    mut sink: impl FnMut(Group) -> Result<(), RunDirectoryError>,
) -> Result<(), RunDirectoryError> {
    let path = directory.join(&manifest.records);
    let mut rows = 0;
    let mut ended = Ok(());
    records::read(&path, |group| {
        if ended.is_ok() {
            let records = &group.records;
            ended = check_rows(&path, records, manifest.first_cycle + rows, records.len());
            rows += records.len() as u64;
            if ended.is_ok() {
                ended = sink(group);
            }
        }
    })?;
    ended?;
    if rows != manifest.completed {
        let reason = format!("{rows} records, but {} in `{MANIFEST}`", manifest.completed);
        return Err(RunDirectoryError::NotWhole(directory.to_owned(), reason));
    }
    Ok(())
}

/// A run that can be resumed.
#[derive(Clone, Debug)]
pub struct Unfinished {
    /// Manifest of the run.
    pub manifest: Manifest,
    /// Its study, as it is driven.
    pub study: LoadedStudy,
    /// Drive that it was given.
    pub given: GivenDrive,
    /// Format of its records.
    pub format: RecordFormat,
    pub(super) path: PathBuf,
}

/// Looks at a run that is to be resumed; none where it is complete. Its study may name these files.
///
/// # Errors
/// Says why this program cannot go on with it.
pub fn unfinished(
    directory: &Path,
    files: &Files,
) -> Result<Option<Unfinished>, RunDirectoryError> {
    let manifest = read_manifest(directory)?;
    if manifest.status == RunStatus::Complete {
        remove_left_over(directory)?;
        return Ok(None);
    }
    let format = RecordFormat::ALL.into_iter().find(|f| f.file_name() == manifest.records);
    let format = format.ok_or_else(|| {
        let reason = format!("it names the records `{}`", manifest.records);
        RunDirectoryError::Damaged(directory.join(MANIFEST), reason)
    })?;
    let (study, given) = study_of(directory, &manifest, files)?;
    Ok(Some(Unfinished { manifest, study, given, format, path: directory.to_owned() }))
}

/// The study that a manifest holds, checked against its hash, and what it was given to drive.
pub(super) fn study_of(
    directory: &Path,
    manifest: &Manifest,
    files: &Files,
) -> Result<(LoadedStudy, GivenDrive), RunDirectoryError> {
    let path = directory.join(MANIFEST);
    let given = GivenDrive::of_followed(manifest.followed.as_ref()).map_err(|error| {
        let reason = format!("what it follows cannot be read: {error}");
        RunDirectoryError::Damaged(path.clone(), reason)
    })?;
    check_study(directory, manifest)?;
    let unusable = |error| RunDirectoryError::Study(path.clone(), error);
    let name = path.display().to_string();
    let study = Given::Text(&name, &manifest.resolved_study);
    let study = study::open(&study, files, &[] as &[&str]).map_err(unusable)?;
    Ok((given.study_again(study).map_err(unusable)?, given))
}

/// Drives the cycles of these records again: a record of another study, seed or program, or one
/// that was changed or cut short, is not what comes out.
pub(super) fn check_by_driving(
    study: &Study,
    given: &GivenDrive,
    seed: u64,
    records: &[(PathBuf, Record)],
) -> Result<(), RunDirectoryError> {
    let ids: Vec<u64> = records.iter().map(|(_, record)| record.cycle_id).collect();
    for ((path, record), again) in records.iter().zip(given.replay(study, seed, &ids)) {
        // all digits: equal texts are equal bits
        if format!("{record:?}") != format!("{again:?}") {
            let id = record.cycle_id;
            let reason = format!(
                "the record of cycle {id} is not what its study and seed give with this program"
            );
            return Err(RunDirectoryError::Damaged(path.clone(), reason));
        }
    }
    Ok(())
}

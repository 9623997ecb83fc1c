//! Merges the parts of one run, from as many machines as there were, into the run that one machine
//! would have written.

use super::error::RunDirectoryError;
use super::read::{
    Measured, check_by_driving, directory_of, ended, measured, read_records, study_of,
};
use super::{
    CHECKSUMS, CHUNKS, MANIFEST, Manifest, RunDirectory, RunStatus, RunSummary, SUMMARY,
    tables_beside,
};
use crate::given_drive::GivenDrive;
use crate::records::{Group, RecordFormat};
use crate::shell_word::resume_command;
use crate::study::Files;
use ocmc_core::record::Record;
use ocmc_core::study::Study;
use ocmc_fleet::quantity::quantity;
use ocmc_fleet::run::RunPlan;
use ocmc_fleet::summary::SummaryBuilder;
use ocmc_fleet::uncertainty::Effects;
use std::convert::Infallible;
use std::fs;
use std::ops::ControlFlow::{self, Continue};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// One part, and where it lies.
struct Part<'a> {
    path: &'a Path,
    manifest: Manifest,
    measured: Measured,
}

impl Part<'_> {
    /// First id after the part.
    fn end(&self) -> u64 {
        self.manifest.first_cycle + self.manifest.completed
    }

    fn ids(&self) -> String {
        let Manifest { first_cycle, completed, .. } = self.manifest;
        match completed {
            0 => "no cycles".to_owned(),
            n => format!("ids {first_cycle} to {}", first_cycle + (n - 1)),
        }
    }
}

/// Merges parts, given in any order, into a new run directory, in the format of the first part
/// where none is given. Records and manifest are the bytes of the single run. The wall time is the
/// longest of the parts, the threads are all of theirs. A merge that fails leaves nothing behind.
///
/// # Errors
/// Names the parts that differ in study or seed, that leave a gap or overlap, or that are
/// not whole.
pub fn merge(
    parts: &[PathBuf],
    out: &Path,
    format: Option<RecordFormat>,
) -> Result<RunSummary, RunDirectoryError> {
    super::check_free(out)?;
    let mut parts = parts
        .iter()
        .map(|path| directory_of(path))
        .map(|path| Ok(Part { path, manifest: whole(path)?, measured: measured(path)? }))
        .collect::<Result<Vec<_>, RunDirectoryError>>()?;
    let Some(first) = parts.first() else {
        return Err(RunDirectoryError::NotOneRun("there are none".to_owned()));
    };
    let records = first.manifest.records.clone();
    let format = format
        .or_else(|| RecordFormat::ALL.into_iter().find(|f| f.file_name() == records))
        .unwrap_or_default();
    check_same(&parts)?;
    parts.sort_by_key(|part| (part.manifest.first_cycle, part.end()));
    check_neighbours(&parts)?;

    let begin = &parts[0];
    let (study, given) = study_of(begin.path, &begin.manifest, &Files::here())?;
    let created = missing(out);
    let merged = write_whole(&parts, &study.study, &given, out, format);
    let taken = |error: &RunDirectoryError| {
        matches!(error, RunDirectoryError::Exists { .. } | RunDirectoryError::Busy(_))
    };
    // what another program has put there since is not ours
    if merged.as_ref().is_err_and(|error| !taken(error)) {
        remove_written(out, &created);
    }
    merged
}

/// The manifest of a part that has all the cycles that it was asked for: of an interrupted one it
/// would not be known that the run has others.
fn whole(path: &Path) -> Result<Manifest, RunDirectoryError> {
    let manifest = ended(path)?;
    if manifest.status == RunStatus::Complete {
        return Ok(manifest);
    }
    let Manifest { completed, cycles, .. } = manifest;
    let help = format!("`{}` finishes it; then merge", resume_command(path));
    Err(RunDirectoryError::NotFinished { path: path.to_owned(), completed, cycles, help })
}

/// The folders that are created for this one, itself first.
fn missing(out: &Path) -> Vec<&Path> {
    let folders = out.ancestors().filter(|folder| !folder.as_os_str().is_empty());
    folders.take_while(|folder| !folder.exists()).collect()
}

/// Removes what a merge that failed has written, and the folders that were created for it. What
/// cannot be removed stays: what matters is why the merge failed.
fn remove_written(out: &Path, created: &[&Path]) {
    let _ = fs::remove_dir_all(out.join(CHUNKS));
    let files = RecordFormat::ALL.into_iter().flat_map(|format| {
        tables_beside(format).into_iter().chain([format.file_name().to_owned()])
    });
    for file in files.chain([SUMMARY, MANIFEST, CHECKSUMS].map(str::to_owned)) {
        let _ = fs::remove_file(out.join(file));
    }
    for folder in created {
        let _ = fs::remove_dir(folder);
    }
}

/// Writes the parts, one behind the other, as one run.
fn write_whole(
    parts: &[Part],
    study: &Study,
    given: &GivenDrive,
    out: &Path,
    format: RecordFormat,
) -> Result<RunSummary, RunDirectoryError> {
    let begin = &parts[0];
    let cycles = parts.iter().map(|part| part.manifest.completed).sum();
    // before anything is written: whoever ends it then has nothing to clear away
    let effects = effects_of(parts, study, given, cycles);
    let mut directory =
        RunDirectory::create(out, format, Manifest { cycles, ..begin.manifest.clone() })?;
    let mut fleet = SummaryBuilder::of(&Arc::new(study.clone()), begin.manifest.seed);
    for part in parts {
        let mut last: Option<Record> = None;
        read_records(part.path, &part.manifest, |Group { records, .. }| {
            fleet.add(&records);
            directory.add(&records)?;
            last = records.into_iter().next_back().or(last.take());
            Ok(())
        })?;
        let place = part.path.join(&part.manifest.records);
        let last: Vec<(PathBuf, Record)> = last.map(|record| (place, record)).into_iter().collect();
        check_by_driving(study, given, part.manifest.seed, &last)?;
    }
    let wall_s = parts.iter().map(|part| part.measured.wall_s).fold(0.0, f64::max);
    let threads = parts.iter().map(|part| part.measured.threads).sum();
    let manifest = directory.manifest.clone();
    let mut summary = fleet.finish();
    summary.know_effects(study, effects.as_ref());
    let ended_at = parts.iter().map(|part| part.measured.ended_at.clone()).max();
    let summary = RunSummary::new(&manifest, summary, wall_s, threads);
    let summary = RunSummary { ended_at: ended_at.unwrap_or_default(), ..summary };
    directory.finish(&summary)?;
    Ok(summary)
}

/// Effects of uncertain numbers' errors on the mean that the parts speak of; none where they do
/// not.
fn effects_of(parts: &[Part], study: &Study, given: &GivenDrive, cycles: u64) -> Option<Effects> {
    let known = parts.iter().find_map(|part| part.measured.parameter_uncertainty.as_ref())?;
    let Manifest { seed, first_cycle, .. } = parts[0].manifest;
    let plan = RunPlan::new(seed, first_cycle, cycles, None, None);
    let drive = |study: &Study, plan: &RunPlan| given.records(study, plan, |_| Continue(()));
    let driven: ControlFlow<Infallible, _> =
        Effects::drive(study, &plan, quantity(&known.column)?, drive);
    let Continue(effects) = driven;
    effects
}

/// Checks that the parts agree in everything but their range.
fn check_same(parts: &[Part]) -> Result<(), RunDirectoryError> {
    let first = &parts[0];
    for part in &parts[1..] {
        let (a, b) = (&first.manifest, &part.manifest);
        let (one, other) = (first.path.display(), part.path.display());
        let differences = [
            ("study", &a.study_hash, &b.study_hash),
            ("seed", &a.seed.to_string(), &b.seed.to_string()),
        ];
        let reason = if let Some((what, a, b)) = differences.into_iter().find(|(_, a, b)| a != b) {
            format!("`{one}` has {what} {a}, `{other}` has {what} {b}")
        } else if a.followed != b.followed {
            format!("the trucks of `{one}` and `{other}` do not follow the same speed")
        } else {
            continue;
        };
        return Err(RunDirectoryError::NotOneRun(reason));
    }
    Ok(())
}

/// Checks that each part begins where the one before it ends.
fn check_neighbours(parts: &[Part]) -> Result<(), RunDirectoryError> {
    for pair in parts.windows(2) {
        let (before, after) = (&pair[0], &pair[1]);
        let (end, start) = (before.end(), after.manifest.first_cycle);
        if start == end {
            continue;
        }
        let (one, other) = (before.path.display(), after.path.display());
        let between = if start > end {
            let missing = start - end;
            format!("{missing} cycles are missing between them, from id {end} on")
        } else {
            format!("they overlap from id {start} on")
        };
        let (ids, other_ids) = (before.ids(), after.ids());
        let reason = format!("`{one}` has {ids}, `{other}` has {other_ids}: {between}");
        return Err(RunDirectoryError::NotOneRun(reason));
    }
    Ok(())
}

//! Runs that are kept: read back from their directories, written to them, and put together from
//! parts in memory.

use crate::error::Error;
use crate::run::{Manifest, RecordFormat, RunAnswer, RunEnd};
use arrow_array::RecordBatch;
use ocmc_core::record::Record;
use ocmc_fleet::summary::SummaryBuilder;
use ocmc_io::run_directory::{RunDirectory, RunSummary, read_groups};
use ocmc_io::study::{Origin, load_text};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use thiserror::Error as ThisError;

pub use ocmc_io::records::GROUP_ROWS;
pub use ocmc_io::records::arrow::{in_our_order, record_batch, records, schema};

/// Reads a run back. `sink` receives its records, group by group.
///
/// # Errors
/// [`Error::RunDirectory`] where there is no run that was ended.
pub fn load(path: PathBuf, mut sink: impl FnMut(RecordBatch)) -> Result<RunAnswer, Error> {
    let (manifest, summary) = read_groups(&path, |group| sink(group.into_batch()))?;
    let stored = RunAnswer::stored(manifest, summary, RunEnd::WasComplete);
    Ok(RunAnswer { origin: Origin::File(path), ..stored })
}

/// Writes a run to a directory, as if it had been driven there.
///
/// # Errors
/// [`Error::RunDirectory`] where the directory holds a run already, or cannot be written.
pub fn save(
    run: &RunAnswer,
    path: &Path,
    format: RecordFormat,
    records: impl IntoIterator<Item = Vec<Record>>,
) -> Result<(), Error> {
    let mut directory = RunDirectory::create(path, format, run.manifest.clone())?;
    for group in records {
        directory.add(&group)?;
    }
    directory.finish(&run.summary)?;
    Ok(())
}

/// Totals of the records of a whole run. `measured` is how long it took, in s, and on how many
/// threads.
///
/// # Errors
/// That of the records.
pub fn summed_up<E>(
    manifest: Manifest,
    origin: Origin,
    (wall_s, threads): (f64, usize),
    records: impl IntoIterator<Item = Result<Vec<Record>, E>>,
) -> Result<RunAnswer, E> {
    // the roads that were given are not at hand, and what trips had on average neither
    let study = manifest.followed.is_none().then(|| {
        let no_settings: &[&str] = &[];
        load_text(&manifest.study, &manifest.resolved_study, no_settings).ok()
    });
    let mut fleet = match study.flatten() {
        Some(loaded) => SummaryBuilder::of(&Arc::new(loaded.study), manifest.seed),
        None => SummaryBuilder::new(manifest.dependence()).priced(manifest.prices()),
    };
    for group in records {
        fleet.add(&group?);
    }
    let summary = RunSummary::new(&manifest, fleet.finish(), wall_s, threads);
    Ok(RunAnswer { origin, ..RunAnswer::stored(manifest, summary, RunEnd::Complete) })
}

/// Why parts are not one run.
#[derive(Clone, Debug, PartialEq, Eq, ThisError)]
pub enum PartsError {
    /// There are none.
    #[error("a run has at least one part")]
    None,
    /// They are of several runs.
    #[error("the parts are not of one study and seed")]
    Other,
    /// They leave a gap, or overlap.
    #[error("a part begins with cycle {begins}, the one before ends before {due}")]
    Gap {
        /// First cycle of a part.
        begins: u64,
        /// The cycle that was due.
        due: u64,
    },
}

/// Run that consecutive parts make up.
///
/// ```
/// assert!(ocmc_api::joined(&[]).is_err());
/// ```
///
/// # Errors
/// Where the parts are of different studies or seeds, or leave a gap.
pub fn joined(parts: &[&Manifest]) -> Result<Manifest, PartsError> {
    let [first, others @ ..] = parts else { return Err(PartsError::None) };
    let mut whole = (*first).clone();
    for part in others {
        if (&part.study_hash, part.seed, &part.followed)
            != (&whole.study_hash, whole.seed, &whole.followed)
        {
            return Err(PartsError::Other);
        }
        let (begins, due) = (part.first_cycle, whole.first_cycle + whole.cycles);
        if begins != due {
            return Err(PartsError::Gap { begins, due });
        }
        whole.cycles += part.cycles;
        whole.completed += part.completed;
    }
    Ok(whole)
}

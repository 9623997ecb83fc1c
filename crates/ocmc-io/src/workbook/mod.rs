//! The workbook of a run (XLSX): its answer, its routes, its trucks, its records and its study, one
//! sheet each, for people who work with a spreadsheet.
//!
//! Records are written as they come, so that a million of them take no more memory than a thousand.
//! The file is a function of the run: it holds neither a date nor how long the run took.

mod answer;
mod package;
mod records_sheet;
mod sheet;
mod study_sheet;

use crate::file_error::FileError;
use crate::run_directory::{
    Manifest, RunDirectoryError, RunSummary, directory_of, read_groups, read_manifest,
};
use crate::trucks;
use arrow_array::RecordBatch;
use package::Package;
use records_sheet::{Records, add_table};
use sheet::MOST_ROWS;
use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, Seek, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Name of the workbook in a run directory.
pub const WORKBOOK: &str = "run.xlsx";

/// Most records of a workbook: the rows of a sheet without its header.
pub const MOST_RECORDS: u64 = MOST_ROWS - 1;

/// The sheets in the order in which a spreadsheet shows them; a run need not have all.
const SHEETS: [&str; 5] = [ANSWER, ROUTES, TRUCKS, RECORDS, STUDY];
const ANSWER: &str = "Answer";
const ROUTES: &str = "By route";
const TRUCKS: &str = "By truck";
const RECORDS: &str = "Records";
const STUDY: &str = "Study";

/// Why there is no workbook.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WorkbookError {
    /// A run that no sheet holds: so many cycles.
    #[error(
        "a workbook holds at most {MOST_RECORDS} records, as a sheet has no more rows, and the run \
         has {0}: keep its records as CSV or Parquet (`--format csv`), or make fewer cycles"
    )]
    TooManyRecords(u64),
    /// A text that no cell holds.
    #[error(
        "cycle {cycle_id}: `{column}` has {length} characters, a cell of a workbook holds at most \
         {}: keep the records as CSV or Parquet (`--format csv`)",
        sheet::MOST_CHARACTERS
    )]
    LongText {
        /// The cycle.
        cycle_id: u64,
        /// The column.
        column: String,
        /// Characters of the text.
        length: usize,
    },
    /// The workbook cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The run cannot be read.
    #[error(transparent)]
    RunDirectory(#[from] RunDirectoryError),
}

/// Checks that a run of so many cycles fits into a workbook.
///
/// # Errors
/// [`WorkbookError::TooManyRecords`].
pub fn check_cycles(cycles: u64) -> Result<(), WorkbookError> {
    if cycles > MOST_RECORDS {
        return Err(WorkbookError::TooManyRecords(cycles));
    }
    Ok(())
}

/// Writes the workbook of a run that lies in a directory. A file of that name is replaced, in one
/// go.
///
/// # Errors
/// Where there is no run that was ended or it does not fit, and where the file cannot be written.
pub fn write_stored(directory: &Path, file: &Path) -> Result<(), WorkbookError> {
    let rows = read_manifest(directory_of(directory))?.completed;
    check_cycles(rows)?;
    replaced(file, |out| {
        let mut records = Records::new(file, out, rows);
        let mut added = Ok(());
        let (manifest, summary) = read_groups(directory, |group| {
            if added.is_ok() {
                added = records.add(&group.into_batch());
            }
        })?;
        added?;
        rest(file, records.finish()?, &manifest, &summary)
    })
}

/// Writes the workbook of a run whose records are at hand. A file of that name is replaced, in one
/// go.
///
/// # Errors
/// Where it does not fit, and where the file cannot be written.
pub fn write<'a>(
    (manifest, summary): (&Manifest, &RunSummary),
    records: impl IntoIterator<Item = &'a RecordBatch>,
    file: &Path,
) -> Result<(), WorkbookError> {
    let rows = summary.summary.cycles;
    check_cycles(rows)?;
    replaced(file, |out| {
        let mut sheet = Records::new(file, out, rows);
        for batch in records {
            sheet.add(batch)?;
        }
        rest(file, sheet.finish()?, manifest, summary)
    })
}

/// Writes all sheets but the records.
fn rest<W: Write + Seek>(
    file: &Path,
    package: Package<W>,
    manifest: &Manifest,
    summary: &RunSummary,
) -> Result<(), WorkbookError> {
    let write = || {
        let mut package = answer::add(package, manifest, summary)?;
        if !summary.summary.routes.is_empty() {
            package = answer::add_routes(package, &summary.summary.routes)?;
        }
        if let Some(trucks) = &summary.summary.trucks {
            package = add_table(package, TRUCKS, &trucks::record_batch(&trucks.rows))?;
        }
        study_sheet::add(package, manifest)?.finish(&SHEETS)?.flush()
    };
    Ok(write().map_err(FileError::write(file))?)
}

/// Writes a file beside its place, and puts it there.
fn replaced(
    file: &Path,
    write: impl FnOnce(BufWriter<File>) -> Result<(), WorkbookError>,
) -> Result<(), WorkbookError> {
    // what a link leads to is replaced, not the link
    let file = fs::canonicalize(file).unwrap_or_else(|_| file.to_owned());
    let mut beside = file.clone().into_os_string();
    beside.push(format!(".{}.tmp", std::process::id()));
    let beside = PathBuf::from(beside);
    let opened = OpenOptions::new().write(true).create_new(true).open(&beside);
    let out = opened.map_err(FileError::write(&file))?;
    let written = write(BufWriter::new(out))
        .and_then(|()| Ok(fs::rename(&beside, &file).map_err(FileError::write(&file))?));
    if written.is_err() {
        // a remnant would do no harm; what matters is the first error
        let _ = fs::remove_file(&beside);
    }
    written
}

#[cfg(test)]
mod tests;

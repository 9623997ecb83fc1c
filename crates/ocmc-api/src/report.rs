//! Everything about a run as one page, or as one workbook.

use crate::error::Error;
use crate::run::RunAnswer;
use arrow_array::RecordBatch;
use ocmc_io::run_directory::{self, RunDirectoryError};
use ocmc_io::workbook;
use std::path::{Path, PathBuf};

pub use ocmc_io::report::{Gathered, REPORT, Reported, html as report};
pub use ocmc_io::run_directory::{FLEET, directory_of, runs_in};
pub use ocmc_io::workbook::{MOST_RECORDS, WORKBOOK, WorkbookError, check_cycles};

/// Notes the checksum of a report that was written to its run directory.
///
/// # Errors
/// Where the checksums cannot be read or written.
pub fn note_report(directory: &Path) -> Result<(), RunDirectoryError> {
    run_directory::note_file(directory, REPORT)
}

/// Writes the workbook of a run that lies in a directory: to a file, or to [`WORKBOOK`] in the
/// directory, which then notes its checksum. An existing file is replaced.
///
/// ```
/// use ocmc_api::{GivenDrive, RecordFormat, RunPlan, RunRequest};
/// use ocmc_api::{go_on, run, stored_workbook, study};
/// let study = study::load("field-truck", &["mission.length_m=3000"])?;
/// let (given, plan) = (&GivenDrive::nothing(), RunPlan::new(1, 0, 4, None, None));
/// let folder = tempfile::tempdir().expect("a directory");
/// let directory = folder.path().join("a");
/// let out = Some((directory.clone(), RecordFormat::Parquet));
/// run(&RunRequest { study: &study, given, plan, precision: None, out }, &mut |_| (), &mut go_on)?;
/// assert_eq!(stored_workbook(&directory, None)?, directory.join("run.xlsx"));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::RunDirectory`] where there is no run that was ended, and [`Error::Workbook`] where it
/// does not fit into a workbook, or the file cannot be written.
pub fn stored_workbook(directory: &Path, file: Option<&Path>) -> Result<PathBuf, Error> {
    let own = directory_of(directory).join(WORKBOOK);
    let path = file.unwrap_or(&own);
    workbook::write_stored(directory, path)?;
    if file.is_none() {
        run_directory::note_file(directory_of(directory), WORKBOOK)?;
    }
    Ok(path.to_owned())
}

/// Writes the workbook of a run with these records to a file. An existing one is replaced.
///
/// # Errors
/// [`Error::Workbook`].
pub fn run_workbook<'a>(
    run: &RunAnswer,
    records: impl IntoIterator<Item = &'a RecordBatch>,
    file: &Path,
) -> Result<(), Error> {
    Ok(workbook::write((&run.manifest, &run.summary), records, file)?)
}

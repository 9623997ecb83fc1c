//! Everything about a run as one page.

use ocmc_io::report;
use ocmc_io::run_directory::{self, RunDirectoryError};
use std::path::Path;

pub use ocmc_io::report::{Gathered, REPORT, Reported};
pub use ocmc_io::run_directory::directory_of;

/// Notes the checksum of a report that was written to its run directory.
///
/// # Errors
/// Where the checksums cannot be read or written.
pub fn note_report(directory: &Path) -> Result<(), RunDirectoryError> {
    run_directory::note_file(directory, REPORT)
}

/// The page: HTML that opens offline in any browser.
///
/// ```
/// use ocmc_api::{GivenDrive, RecordFormat, RunPlan, RunRequest, Reported, go_on, report, run, study};
/// let study = study::load("field-truck", &["mission.length_m=3000"])?;
/// let folder = tempfile::tempdir().expect("a directory");
/// let (given, plan) = (&GivenDrive::nothing(), RunPlan::new(1, 0, 4, None, None));
/// let out = Some((folder.path().join("a"), RecordFormat::Csv));
/// run(&RunRequest { study: &study, given, plan, precision: None, out }, &mut |_| (), &mut go_on)?;
/// let page = report(&Reported::read(&folder.path().join("a"))?);
/// assert!(page.starts_with("<!DOCTYPE html>"));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
pub fn report(run: &Reported) -> String {
    report::html(run)
}

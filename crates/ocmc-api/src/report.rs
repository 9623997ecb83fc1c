//! Everything about a run as one page.

use ocmc_io::run_directory::{self, RunDirectoryError};
use std::path::Path;

pub use ocmc_io::report::{Gathered, REPORT, Reported, html as report};
pub use ocmc_io::run_directory::directory_of;

/// Notes the checksum of a report that was written to its run directory.
///
/// # Errors
/// Where the checksums cannot be read or written.
pub fn note_report(directory: &Path) -> Result<(), RunDirectoryError> {
    run_directory::note_file(directory, REPORT)
}

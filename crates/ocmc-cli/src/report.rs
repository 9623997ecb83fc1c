//! `ocmc report`: one HTML file about a run.

use crate::arguments::ReportArguments;
use crate::failure::Failure;
use crate::output;
use ocmc_io::{report, run_directory};
use std::fs;

/// Reads the run and writes its report.
pub(crate) fn report(arguments: &ReportArguments) -> Result<(), Failure> {
    let run = run_directory::read(&arguments.directory)?;
    let directory = run_directory::directory_of(&arguments.directory);
    let path = arguments.out.clone().unwrap_or_else(|| directory.join(report::REPORT));
    fs::write(&path, report::html(&run))
        .map_err(|source| Failure::File { path: path.clone(), source })?;
    output::note(&format!("Written: `{}`. Any browser opens it.", path.display()));
    Ok(())
}

//! `ocmc report`: one HTML file about a run.

use crate::arguments::ReportArguments;
use crate::failure::Failure;
use crate::output;
use ocmc_api::{Error, REPORT, directory_of, note_report, read_run};
use std::fs;

/// Reads the run and writes its report.
pub(crate) fn report(arguments: &ReportArguments) -> Result<(), Failure> {
    let run = read_run(&arguments.directory).map_err(Error::from)?;
    let directory = directory_of(&arguments.directory);
    let path = arguments.out.clone().unwrap_or_else(|| directory.join(REPORT));
    fs::write(&path, ocmc_api::report(&run))
        .map_err(|source| Failure::File { path: path.clone(), source })?;
    if arguments.out.is_none() {
        note_report(directory).map_err(Error::from)?;
    }
    output::note(&format!("Written: `{}`. Any browser opens it.", path.display()));
    Ok(())
}

//! `ocmc verify`: whether the files of a run are what was written.

use crate::failure::Failure;
use crate::output;
use crate::progress::busy;
use clap::Args;
use std::path::PathBuf;

/// The run to check.
#[derive(Clone, Debug, Args)]
pub(crate) struct VerifyArguments {
    /// Directory of a run, as --out wrote it
    #[arg(value_name = "RUN_DIR")]
    directory: PathBuf,
    /// The answer as JSON
    #[arg(long)]
    json: bool,
}

/// Checks the files and prints what is wrong with which.
pub(crate) fn verify(arguments: &VerifyArguments) -> Result<(), Failure> {
    let VerifyArguments { directory, json } = arguments;
    let answer = busy(false, "checking the files", || ocmc_api::verify(directory))?;
    output::print(&answer, *json)?;
    if answer.whole { Ok(()) } else { Err(Failure::NotWhole { path: directory.clone() }) }
}

//! `ocmc verify`: whether the files of a run are what was written.

use crate::arguments::AnswerOptions;
use crate::failure::Failure;
use crate::progress::busy;
use clap::Args;
use std::path::PathBuf;

/// The run to check.
#[derive(Clone, Debug, Args)]
pub(crate) struct VerifyArguments {
    /// Directory of a run, as --out wrote it, or of a fleet's groups
    #[arg(value_name = "RUN_DIR")]
    directory: PathBuf,
    #[command(flatten)]
    answer: AnswerOptions,
}

/// Checks the files and prints what is wrong with which.
pub(crate) fn verify(arguments: &VerifyArguments) -> Result<(), Failure> {
    let VerifyArguments { directory, answer } = arguments;
    let verified = busy(answer.quiet, "checking the files", || ocmc_api::verify(directory))?;
    answer.show(&verified)?;
    if verified.whole { Ok(()) } else { Err(Failure::NotWhole { path: directory.clone() }) }
}

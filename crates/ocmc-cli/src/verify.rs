//! `ocmc verify`: whether the files of a run are what was written.

use crate::arguments::VerifyArguments;
use crate::failure::Failure;
use crate::output;

/// Checks the files and prints what is wrong with which.
pub(crate) fn verify(arguments: &VerifyArguments) -> Result<(), Failure> {
    let VerifyArguments { directory, json } = arguments;
    let answer = ocmc_api::verify(directory)?;
    output::print(&answer, *json)?;
    if answer.whole { Ok(()) } else { Err(Failure::NotWhole { path: directory.clone() }) }
}

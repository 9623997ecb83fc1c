//! `ocmc merge`: the parts of one run, from many machines, as one run.

use crate::arguments::MergeArguments;
use crate::failure::Failure;
use crate::{output, run};
use ocmc_api::MergeRequest;

/// Merges the parts and prints what their fleet adds up to.
pub(crate) fn merge(arguments: &MergeArguments) -> Result<(), Failure> {
    let MergeArguments { parts, out, format, .. } = arguments;
    let answer = ocmc_api::merge(&MergeRequest { parts, out, format: format.map(Into::into) })?;
    output::print_run(&answer, arguments.json)?;
    if !arguments.quiet && !arguments.json {
        output::note(&run::written(out, &answer.manifest));
    }
    Ok(())
}

//! `ocmc merge`: the parts of one run, from many machines, as one run.

use crate::arguments::MergeArguments;
use crate::failure::Failure;
use crate::run_text::{self, Circumstances};
use crate::{output, run};
use ocmc_io::run_directory;
use ocmc_io::study::Origin;

/// Merges the parts and prints what their fleet adds up to.
pub(crate) fn merge(arguments: &MergeArguments) -> Result<(), Failure> {
    let MergeArguments { parts, out, format, .. } = arguments;
    let summary = run_directory::merge(parts, out, format.map(Into::into))?;
    if arguments.json {
        output::answer(&summary.to_json())?;
    } else {
        let origin = Origin::BuiltIn(summary.study.clone());
        let circumstances = Circumstances { origin: &origin, width: output::width(), resumed: 0 };
        output::answer(&run_text::run_text(&summary, &circumstances))?;
    }
    if !arguments.quiet && !arguments.json {
        output::note(&run::written(out, &run_directory::read_manifest(out)?));
    }
    Ok(())
}

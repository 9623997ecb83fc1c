//! `ocmc trace`: the simulated time series of one cycle.

use crate::arguments::CycleArguments;
use crate::failure::Failure;
use crate::table_file;
use ocmc_api::study;

/// Drives one cycle and writes down every step.
pub(crate) fn trace(arguments: &CycleArguments) -> Result<(), Failure> {
    let target = table_file::target(arguments.out.as_deref())?;
    let loaded = study::load(&arguments.study, &arguments.set)?;
    let series = ocmc_api::trace(&loaded, arguments.seed, arguments.cycle_id);
    table_file::write(&target, &series, |bytes| series.write_csv(bytes))
}

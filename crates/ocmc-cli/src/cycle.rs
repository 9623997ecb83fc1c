//! `ocmc cycle`: one realised operating cycle, as tracks.

use crate::arguments::CycleArguments;
use crate::failure::Failure;
use crate::table_file;
use ocmc_api::{operating_cycle, study};

/// Draws one operating cycle and writes down its tracks.
pub(crate) fn cycle(arguments: &CycleArguments) -> Result<(), Failure> {
    let target = table_file::target(arguments.out.as_deref())?;
    let loaded = study::load(&arguments.study, &arguments.set)?;
    let cycle = operating_cycle(&loaded, arguments.seed, arguments.cycle_id);
    table_file::write(&target, &cycle, |bytes| cycle.write_csv(bytes))
}

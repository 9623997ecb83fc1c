//! `ocmc cycle`, `ocmc trace`: one realised operating cycle as tracks, and the simulated time
//! series of one cycle.

use crate::arguments::{QuietOption, StudyOptions, TableOptions, whole_number};
use crate::failure::Failure;
use clap::Args;
use ocmc_api::{LAST_CYCLE_ID, operating_cycle};

/// One cycle of a run.
#[derive(Clone, Debug, Args)]
pub(crate) struct CycleArguments {
    #[command(flatten)]
    study: StudyOptions,
    /// Id of the cycle, as in the records
    #[arg(
        long, value_name = "ID", allow_negative_numbers = true,
        value_parser = whole_number(0..=LAST_CYCLE_ID - 1)
    )]
    cycle_id: u64,
    /// Master seed of the run
    #[arg(
        long, value_name = "N", default_value = "1", allow_negative_numbers = true,
        value_parser = whole_number(0..=u64::MAX)
    )]
    seed: u64,
    #[command(flatten)]
    table: TableOptions,
    #[command(flatten)]
    quiet: QuietOption,
}

/// Draws one operating cycle and writes down its tracks.
pub(crate) fn cycle(arguments: &CycleArguments) -> Result<(), Failure> {
    let target = arguments.table.target()?;
    let cycle = operating_cycle(&arguments.study.load()?, arguments.seed, arguments.cycle_id);
    target.write(&cycle, |bytes| cycle.write_csv(bytes))
}

/// Drives one cycle and writes down every step.
pub(crate) fn trace(arguments: &CycleArguments) -> Result<(), Failure> {
    let target = arguments.table.target()?;
    let series = ocmc_api::trace(&arguments.study.load()?, arguments.seed, arguments.cycle_id);
    target.write(&series, |bytes| series.write_csv(bytes))
}

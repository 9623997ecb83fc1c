//! `ocmc cycle`, `ocmc trace`: one realised operating cycle as tracks, and the simulated time
//! series of one cycle.

use crate::arguments::{StudyOptions, whole_number};
use crate::failure::Failure;
use crate::output::Target;
use clap::Args;
use ocmc_api::{LAST_CYCLE_ID, operating_cycle};
use std::path::PathBuf;

/// One cycle of a run.
#[derive(Clone, Debug, Args)]
pub(crate) struct CycleArguments {
    #[command(flatten)]
    study: StudyOptions,
    /// Id of the cycle, as in the records
    #[arg(long, value_name = "ID", allow_negative_numbers = true, value_parser = whole_number(0..=LAST_CYCLE_ID - 1))]
    cycle_id: u64,
    /// Master seed of the run
    #[arg(long, value_name = "N", default_value = "1", allow_negative_numbers = true, value_parser = whole_number(0..=u64::MAX))]
    seed: u64,
    /// File to write, `.csv` or `.json`; an existing one is replaced [default: CSV to standard
    /// output]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// No hints: there are none here, and scripts give it to all commands
    #[arg(long)]
    quiet: bool,
}

/// Draws one operating cycle and writes down its tracks.
pub(crate) fn cycle(arguments: &CycleArguments) -> Result<(), Failure> {
    let target = Target::of(arguments.out.as_deref())?;
    let cycle = operating_cycle(&arguments.study.load()?, arguments.seed, arguments.cycle_id);
    target.write(&cycle, |bytes| cycle.write_csv(bytes))
}

/// Drives one cycle and writes down every step.
pub(crate) fn trace(arguments: &CycleArguments) -> Result<(), Failure> {
    let target = Target::of(arguments.out.as_deref())?;
    let series = ocmc_api::trace(&arguments.study.load()?, arguments.seed, arguments.cycle_id);
    target.write(&series, |bytes| series.write_csv(bytes))
}

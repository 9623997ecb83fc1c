//! `ocmc range`: how far battery trucks come.

use crate::arguments::{RangeArguments as CycleRange, StudyOptions, WorkOptions};
use crate::failure::Failure;
use clap::Args;
use ocmc_api::{RangeRequest, range_of_run};
use std::path::PathBuf;

/// Trucks whose range is asked for.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("study", |study| study.default_value("battery-truck")))]
pub(crate) struct BatteryRangeArguments {
    /// Directory of a run, whose records are taken instead of driving a study
    #[arg(
        value_name = "DIR",
        conflicts_with_all = ["study", "set", "cycles", "seed", "first_cycle", "threads"]
    )]
    run: Option<PathBuf>,
    #[command(flatten)]
    study: StudyOptions,
    #[command(flatten)]
    range: CycleRange,
    #[command(flatten)]
    work: WorkOptions,
}

/// Finds the range and prints it.
pub(crate) fn range(arguments: &BatteryRangeArguments) -> Result<(), Failure> {
    let BatteryRangeArguments { run, study, range, work } = arguments;
    if let Some(directory) = run {
        return work.answer.show(&range_of_run(directory)?);
    }
    let loaded = study.load()?;
    let study = (loaded.origin.to_string(), &loaded);
    let request = RangeRequest { study, plan: range.plan(work.threads)? };
    work.answer.print(|watch| ocmc_api::range(&request, watch))
}

//! `ocmc range`: how far battery trucks come.

use crate::arguments::{RangeArguments as CycleRange, StudyOptions, whole_number};
use crate::failure::Failure;
use crate::output;
use crate::progress::watched;
use clap::Args;
use ocmc_api::{MOST_THREADS, RangeRequest, range_of_run};
use std::path::PathBuf;

/// Whose range is asked for.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("study", |study| study.default_value("battery-truck")))]
pub(crate) struct RangeArguments {
    /// Directory of a run, whose records are taken instead of driving a study
    #[arg(value_name = "DIR", conflicts_with_all = ["study", "set", "cycles", "seed", "first_cycle", "threads"])]
    run: Option<PathBuf>,
    #[command(flatten)]
    study: StudyOptions,
    #[command(flatten)]
    range: CycleRange,
    /// Threads [default: one for each CPU]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole_number(1..=MOST_THREADS))]
    threads: Option<usize>,
    /// No progress
    #[arg(long)]
    quiet: bool,
    /// The answer as JSON
    #[arg(long)]
    json: bool,
}

/// Finds the range and prints it.
pub(crate) fn range(arguments: &RangeArguments) -> Result<(), Failure> {
    let RangeArguments { run, study, range, threads, quiet, json } = arguments;
    if let Some(directory) = run {
        return output::print(&range_of_run(directory)?, *json);
    }
    let loaded = study.load()?;
    let study = (loaded.origin.to_string(), &loaded);
    let request = RangeRequest { study, plan: range.plan(*threads)? };
    let answer = watched(*quiet, |watch| ocmc_api::range(&request, watch))?;
    output::print(&answer, *json)
}

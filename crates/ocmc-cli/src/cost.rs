//! `ocmc cost`: what trips cost, and which of two studies costs less.

use crate::arguments::{RangeArguments, StudyOptions, whole_number};
use crate::failure::Failure;
use crate::output;
use crate::progress::watched;
use clap::Args;
use ocmc_api::{CostRequest, MOST_THREADS};
use std::path::PathBuf;

/// What is to be costed.
#[derive(Clone, Debug, Args)]
#[command(
    mut_arg("cycles", |cycles| cycles.help("Number of cycles in each study")),
    mut_arg("set", |set| set.help("Replaces one value of the study, and of the one it is compared \
        with, as in cost.fuel_per_l=1.6; may be repeated"))
)]
pub(crate) struct CostArguments {
    #[command(flatten)]
    study: StudyOptions,
    /// Study B that it is compared with on the same cycles: a built-in name or a study file
    #[arg(long, value_name = "NAME|FILE")]
    against: Option<PathBuf>,
    #[command(flatten)]
    range: RangeArguments,
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

/// Costs the studies and prints what they cost.
pub(crate) fn cost(arguments: &CostArguments) -> Result<(), Failure> {
    let CostArguments { study, against, range, threads, quiet, json } = arguments;
    let a = study.load()?;
    let b = against.as_ref().map(|other| study.load_other(other)).transpose()?;
    let named = |loaded| (study_name(loaded), loaded);
    let request = CostRequest {
        study: named(&a),
        against: b.as_ref().map(named),
        plan: range.plan(*threads)?,
    };
    let answer = watched(*quiet, |watch| ocmc_api::cost(&request, watch))?;
    output::print(&answer, *json)
}

/// What an answer calls a study.
fn study_name(loaded: &ocmc_api::study::LoadedStudy) -> String {
    loaded.origin.to_string()
}

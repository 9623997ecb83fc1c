//! `ocmc cost`: what trips cost, and which of two studies costs less.

use crate::arguments::{RangeArguments, StudyOptions, TruckOptions, WorkOptions};
use crate::failure::Failure;
use clap::Args;
use ocmc_api::CostRequest;
use std::path::PathBuf;

/// Studies to be costed.
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
    #[command(flatten)]
    fleet: TruckOptions,
    #[command(flatten)]
    work: WorkOptions,
}

/// Costs the studies and prints what they cost.
pub(crate) fn cost(arguments: &CostArguments) -> Result<(), Failure> {
    let CostArguments { study, against, range, fleet, work } = arguments;
    let study = study.with(fleet.setting());
    let a = study.load()?;
    let b = against.as_ref().map(|other| study.load_other(other)).transpose()?;
    let range = fleet.range(*range, &a);
    let against = b.as_ref().map(|b| (b.origin.to_string(), b));
    let study = (a.origin.to_string(), &a);
    let request = CostRequest { study, against, plan: range.plan(work.threads)? };
    work.answer.print(|watch| ocmc_api::cost(&request, watch))
}

//! `ocmc bound`: the least energy for the same road, truck and trip time, and how far drivers are
//! from it.

use crate::arguments::{RangeArguments, StudyOptions, WorkOptions, whole_number};
use crate::failure::Failure;
use crate::output::Target;
use crate::progress::watched;
use clap::Args;
use ocmc_api::{BoundRequest, LAST_CYCLE_ID};
use std::path::PathBuf;

/// Cycles whose bounds are asked for.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("cycles", |cycles| cycles.default_value("20")))]
pub(crate) struct BoundArguments {
    #[command(flatten)]
    study: StudyOptions,
    #[command(flatten)]
    range: RangeArguments,
    /// This cycle alone
    #[arg(
        long, value_name = "ID", conflicts_with_all = ["cycles", "first_cycle"],
        allow_negative_numbers = true, value_parser = whole_number(0..=LAST_CYCLE_ID - 1)
    )]
    cycle_id: Option<u64>,
    /// With --cycle-id: file for speed and gear of the optimum, `.csv` or `.json`; an existing one
    /// is replaced
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    work: WorkOptions,
}

/// Finds the bounds and prints the potential.
pub(crate) fn bound(arguments: &BoundArguments) -> Result<(), Failure> {
    let BoundArguments { study, range, cycle_id, out, work } = arguments;
    if out.is_some() && cycle_id.is_none() {
        return Err(Failure::Usage("--out is for one cycle: give --cycle-id, too".to_owned()));
    }
    let target = out.as_deref().map(|path| Target::of(Some(path))).transpose()?;
    let study = &study.load()?;
    let range =
        cycle_id.map_or(*range, |id| RangeArguments { cycles: 1, first_cycle: id, ..*range });
    let request = BoundRequest { study, plan: range.plan(work.threads)? };
    let answer = watched(work.answer.quiet, |watch| ocmc_api::bound(&request, watch))?;
    if let (Some(target), Some(optimum)) = (target, &answer.optimum) {
        target.write(optimum, |bytes| optimum.write_csv(bytes))?;
    }
    work.answer.show(&answer)
}

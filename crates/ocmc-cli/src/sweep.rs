//! `ocmc sweep`: values of a study's keys, in a grid or one by one, on the same cycles.

use crate::analysis::any_column;
use crate::arguments::{FileOptions, RangeArguments, WorkOptions, one_of};
use crate::failure::Failure;
use crate::output::Target;
use crate::progress::watched;
use clap::Args;
use ocmc_api::{AGAINSTS, Against, Source, SweepPoints, SweepRequest};
use std::path::PathBuf;

/// Points of a study.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("cycles", |cycles| cycles.help("Number of cycles at each point")))]
#[command(mut_arg("column", any_column))]
pub(crate) struct SweepArguments {
    /// Name of a built-in study, a study file, or `-` for standard input
    #[arg(long, value_name = "NAME|FILE", default_value = "field-truck")]
    study: PathBuf,
    /// A key and its values, as in vehicle.drag_area_m2.median=5.5,5,4.5; several keys make a grid,
    /// and a key with one value holds for all points
    #[arg(long, value_name = "KEY=A,B,C")]
    set: Vec<String>,
    /// A table of the points instead of the grid: columns are keys, rows are points
    #[arg(long, value_name = "FILE")]
    list: Option<PathBuf>,
    /// Reference that the points are compared with [default: first]
    #[arg(long, value_name = "WHAT", value_parser = one_of(AGAINSTS))]
    against: Option<Against>,
    #[command(flatten)]
    files: FileOptions,
    #[command(flatten)]
    range: RangeArguments,
    /// Column that is compared
    #[arg(long, value_name = "NAME")]
    column: Option<String>,
    /// File for the table, `.csv`, or `.json` for the whole answer; an existing one is replaced
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    work: WorkOptions,
}

/// Drives the points and prints their table.
pub(crate) fn sweep(arguments: &SweepArguments) -> Result<(), Failure> {
    let SweepArguments { study, set, list, against, files, range, column, out, work } = arguments;
    let target = out.as_deref().map(|path| Target::of(Some(path))).transpose()?;
    let (fixed, mut points) = SweepPoints::of_settings(set)?;
    if let Some(list) = list {
        if let Some(key) = points.keys().first() {
            return Err(Failure::Usage(format!(
                "--list gives the points, and --set gives `{key}` several values: give it one \
                 value, or a column of the list"
            )));
        }
        points = SweepPoints::list(&Source::File(list.clone()))?;
    }
    let loaded = files.load(study, &fixed)?;
    let named = [vec![loaded.origin.to_string()], fixed].concat().join(" with ");
    let request = SweepRequest {
        study: (named, &loaded),
        points,
        against: against.unwrap_or_default(),
        plan: range.plan(work.threads)?,
        column: column.clone(),
    };
    let answer = watched(work.answer.quiet, |watch| ocmc_api::sweep(&request, watch))?;
    if let Some(target) = target {
        target.write(&answer, |bytes| answer.write_csv(bytes))?;
    }
    work.answer.show(&answer)
}

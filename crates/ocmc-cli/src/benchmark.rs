//! `ocmc benchmark`: trips as measured beside what a study expects of them.

use crate::arguments::{FiledWorkOptions, StudyOptions, whole_number};
use crate::failure::Failure;
use crate::output;
use clap::Args;
use ocmc_api::{
    BenchmarkAnswer, BenchmarkContrast, BenchmarkRequest, REPORT, Source, Watch, mappings,
};
use std::path::PathBuf;

/// Trips to be compared.
#[derive(Clone, Debug, Args)]
pub(crate) struct BenchmarkArguments {
    /// Table with one row a trip: distance_km, fuel_l or energy_kwh, and where known
    /// gross_weight_kg, driving_time_h, climb_m, truck, driver, date, route
    #[arg(value_name = "RECORDS")]
    trips: PathBuf,
    /// Says which column is what, as in fuel_amount_l=diesel; may be repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    map: Vec<String>,
    #[command(flatten)]
    study: StudyOptions,
    /// Also compares the trips since a date, such as 2024-03-01, with those before
    #[arg(long, value_name = "DATE", conflicts_with = "group")]
    since: Option<String>,
    /// Also compares the groups of this column, such as the make of the tyres
    #[arg(long, value_name = "COLUMN")]
    group: Option<String>,
    /// Keeps the names of the drivers, who else are numbered
    #[arg(long)]
    names: bool,
    /// Does not adjust for the mean speed of trips: it tells the roads, but a driver has a hand in
    /// it
    #[arg(long)]
    no_speed: bool,
    /// Trips of the study
    #[arg(
        long, value_name = "N", default_value = "3200", allow_negative_numbers = true,
        value_parser = whole_number(100..=1_000_000_u64)
    )]
    cycles: u64,
    /// Master seed
    #[arg(
        long, value_name = "N", default_value = "1", allow_negative_numbers = true,
        value_parser = whole_number(0..=u64::MAX)
    )]
    seed: u64,
    #[command(flatten)]
    work: FiledWorkOptions,
}

/// Compares the trips and prints what differs.
pub(crate) fn benchmark(arguments: &BenchmarkArguments) -> Result<(), Failure> {
    let BenchmarkArguments { trips, map, study, since, group, work, .. } = arguments;
    let loaded = study.load()?;
    work.check_out()?;
    let mut map = map.clone();
    map.extend(group.as_ref().map(|column| format!("group={column}")));
    let since = since.clone().map(BenchmarkContrast::Since);
    let request = BenchmarkRequest {
        trips: Source::File(trips.clone()),
        mappings: mappings(&map)?,
        study: (loaded.origin.to_string(), &loaded),
        contrast: since.or(group.as_ref().map(|_| BenchmarkContrast::Group)),
        names: arguments.names,
        speed: !arguments.no_speed,
        cycles: arguments.cycles,
        seed: arguments.seed,
        threads: work.threads,
    };
    work.write(|watch: &mut Watch| ocmc_api::benchmark(&request, watch), BenchmarkAnswer::save)?;
    if let Some(directory) = work.out.as_ref().filter(|_| !work.answer.quiet && !work.answer.json) {
        let shown = directory.display();
        let files = "benchmark.json, trips.csv and a page";
        output::note(&format!("Written to `{shown}`: {files}. Any browser opens {REPORT}."));
    }
    Ok(())
}

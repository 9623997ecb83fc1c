//! `ocmc training`: what it is worth to train the drivers who stand worst.

use crate::arguments::{MOST_TRIPS, StudyOptions, WorkOptions, check_range, share, whole_number};
use crate::failure::Failure;
use clap::Args;
use ocmc_api::{LAST_CYCLE_ID, MeasuredTrainingRequest, RunPlan, TrainingRequest, Watch};
use std::path::PathBuf;

/// Drivers whose training is asked about.
#[derive(Clone, Debug, Args)]
pub(crate) struct TrainingArguments {
    #[command(flatten)]
    study: StudyOptions,
    /// Number of trucks
    #[arg(
        long, value_name = "N", default_value = "200", allow_negative_numbers = true,
        value_parser = whole_number(2..=LAST_CYCLE_ID)
    )]
    trucks: u64,
    /// Trips of each truck: sets `fleet.trips_per_truck` of the study [default: the study's; 50
    /// where it has one trip]
    #[arg(
        long, value_name = "N", allow_negative_numbers = true,
        value_parser = whole_number(1..=MOST_TRIPS)
    )]
    trips: Option<u64>,
    /// Share of the drivers who are trained: those who stand worst in the records
    #[arg(long, value_name = "SHARE", default_value = "20%", value_parser = share)]
    share: f64,
    /// Changes by training in the study; may be repeated [default: trained drivers drive as the
    /// middle fifth of drivers]
    #[arg(long, value_name = "KEY=VALUE")]
    coached: Vec<String>,
    /// Drivers that were measured, instead of simulated ones: the benchmark.json of `ocmc
    /// benchmark`
    #[arg(long, value_name = "FILE", conflicts_with = "coached")]
    benchmark: Option<PathBuf>,
    /// Master seed
    #[arg(
        long, value_name = "N", default_value = "1", allow_negative_numbers = true,
        value_parser = whole_number(0..=u64::MAX)
    )]
    seed: u64,
    #[command(flatten)]
    work: WorkOptions,
}

/// Trips of a truck where neither the command nor the study says how many.
const TRIPS: u64 = 50;

/// Finds what training is worth and prints it.
pub(crate) fn training(arguments: &TrainingArguments) -> Result<(), Failure> {
    let loaded = arguments.study.load()?;
    let of_study = loaded.study.nesting().trips_per_truck;
    let standard = if of_study > 1 { of_study } else { TRIPS };
    let trips = arguments.trips.unwrap_or(standard);
    let loaded = loaded.set(&[format!("fleet.trips_per_truck={trips}")])?;
    let cycles = arguments.trucks.saturating_mul(trips);
    check_range(0, cycles)?;
    if let Some(benchmark) = arguments.benchmark.clone() {
        let request = MeasuredTrainingRequest {
            benchmark,
            study: (loaded.origin.to_string(), &loaded),
            share: arguments.share,
            plan: RunPlan::new(arguments.seed, 0, cycles, arguments.work.threads, None),
        };
        let ask = |watch: &mut Watch| ocmc_api::measured_training(&request, watch);
        return arguments.work.answer.print(ask);
    }
    let request = TrainingRequest {
        study: (loaded.origin.to_string(), &loaded),
        coached: arguments.coached.clone(),
        share: arguments.share,
        plan: RunPlan::new(arguments.seed, 0, cycles, arguments.work.threads, None),
    };
    arguments.work.answer.print(|watch| ocmc_api::training(&request, watch))
}

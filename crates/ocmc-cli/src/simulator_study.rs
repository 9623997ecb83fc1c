//! `ocmc simulator-study`: the paper's driving-simulator study, its tables and its pictures.

use crate::arguments::{StudyOptions, one_of, whole_number};
use crate::failure::Failure;
use crate::output;
use crate::progress::watched;
use clap::Args;
use ocmc_api::{
    MOST_REPETITIONS, MOST_THREADS, SPEED_TERMS, SimulatorStudyRequest, SpeedTerm, check_empty,
};
use std::path::PathBuf;

/// The study, and how often it is repeated.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("study", |study| study.default_value("simulator-study")))]
pub(crate) struct SimulatorStudyArguments {
    #[command(flatten)]
    study: StudyOptions,
    /// Master seed
    #[arg(long, value_name = "N", default_value = "1", allow_negative_numbers = true, value_parser = whole_number(0..=u64::MAX))]
    seed: u64,
    /// Repetitions of the study, each with eight drivers of its own
    #[arg(long, value_name = "N", default_value = "40", allow_negative_numbers = true, value_parser = whole_number(1..=MOST_REPETITIONS))]
    repetitions: u64,
    /// Speed that the objective compares with the set speed: the simulated one, as the paper's
    /// equation reads
    #[arg(long, value_name = "NAME", default_value = "simulated", value_parser = one_of(SPEED_TERMS))]
    speed_term: SpeedTerm,
    /// No gains: they take most of the time
    #[arg(long)]
    no_gains: bool,
    /// Threads [default: one for each CPU]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole_number(1..=MOST_THREADS))]
    threads: Option<usize>,
    /// Directory for tables, pictures and a page; it has to be empty, and is made where it is not
    /// there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// No progress
    #[arg(long)]
    quiet: bool,
    /// The answer as JSON
    #[arg(long)]
    json: bool,
}

/// Drives the study, and prints or writes what the paper shows.
pub(crate) fn simulator_study(arguments: &SimulatorStudyArguments) -> Result<(), Failure> {
    let SimulatorStudyArguments { study, out, quiet, json, .. } = arguments;
    if let Some(directory) = out {
        check_empty(directory)?;
    }
    let request = SimulatorStudyRequest {
        study: &study.load()?,
        seed: arguments.seed,
        repetitions: arguments.repetitions,
        threads: arguments.threads,
        identify: (!arguments.no_gains).then_some(arguments.speed_term),
    };
    let answer = watched(*quiet, |watch| ocmc_api::simulator_study(&request, watch))?;
    if let Some(directory) = out {
        answer.save(directory)?;
    }
    output::print(&answer, *json)
}

//! `ocmc simulator-study`: the paper's driving-simulator study, its tables and its pictures.

use crate::arguments::{FiledWorkOptions, StudyOptions, one_of, whole_number};
use crate::failure::Failure;
use clap::Args;
use ocmc_api::{
    MOST_REPETITIONS, SPEED_TERMS, SimulatorStudyAnswer, SimulatorStudyRequest, SpeedTerm, Watch,
};

/// The study, and how often it is repeated.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("study", |study| study.default_value("simulator-study")))]
pub(crate) struct SimulatorStudyArguments {
    #[command(flatten)]
    study: StudyOptions,
    /// Master seed
    #[arg(
        long, value_name = "N", default_value = "1", allow_negative_numbers = true,
        value_parser = whole_number(0..=u64::MAX)
    )]
    seed: u64,
    /// Repetitions of the study, each with eight drivers of its own
    #[arg(
        long, value_name = "N", default_value = "40", allow_negative_numbers = true,
        value_parser = whole_number(1..=MOST_REPETITIONS)
    )]
    repetitions: u64,
    /// Speed that the objective compares with the set speed: the simulated one, as the paper's
    /// equation reads
    #[arg(
        long, value_name = "NAME", default_value = "simulated", value_parser = one_of(SPEED_TERMS)
    )]
    speed_term: SpeedTerm,
    /// No gains: they take most of the time
    #[arg(long)]
    no_gains: bool,
    #[command(flatten)]
    work: FiledWorkOptions,
}

/// Drives the study, and prints or writes what the paper shows.
pub(crate) fn simulator_study(arguments: &SimulatorStudyArguments) -> Result<(), Failure> {
    let SimulatorStudyArguments { study, work, .. } = arguments;
    work.check_out()?;
    let request = SimulatorStudyRequest {
        study: &study.load()?,
        seed: arguments.seed,
        repetitions: arguments.repetitions,
        threads: work.threads,
        identify: (!arguments.no_gains).then_some(arguments.speed_term),
    };
    let ask = |watch: &mut Watch| ocmc_api::simulator_study(&request, watch);
    work.write(ask, SimulatorStudyAnswer::save)
}

//! `ocmc size`: how large a battery has to be.

use crate::arguments::{RangeArguments as CycleRange, StudyOptions, WorkOptions, one_of, share};
use crate::failure::Failure;
use clap::Args;
use ocmc_api::{SEASONS, Season, SizeRequest};

/// Trucks whose battery is asked for.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("study", |study| study.default_value("battery-truck")))]
pub(crate) struct SizeArguments {
    #[command(flatten)]
    study: StudyOptions,
    /// Share of the trips that has to arrive; may be repeated
    #[arg(
        long, value_name = "SHARE", default_value = "95%", allow_hyphen_values = true,
        value_parser = share
    )]
    arrive: Vec<f64>,
    /// Mass of the truck that a kWh of battery adds, in kg
    #[arg(long, value_name = "KG", default_value_t = 0.0, allow_negative_numbers = true)]
    kg_per_kwh: f64,
    /// Only the trips that depart in a season of the north
    #[arg(long, value_name = "SEASON", value_parser = one_of(SEASONS))]
    season: Option<Season>,
    #[command(flatten)]
    range: CycleRange,
    #[command(flatten)]
    work: WorkOptions,
}

/// Finds the battery and prints it.
pub(crate) fn size(arguments: &SizeArguments) -> Result<(), Failure> {
    let SizeArguments { study, arrive, kg_per_kwh, season, range, work } = arguments;
    let loaded = study.load()?;
    let study = (loaded.origin.to_string(), &loaded);
    let plan = range.plan(work.threads)?;
    let (arrive, kg_per_kwh, season) = (arrive.clone(), *kg_per_kwh, *season);
    let request = SizeRequest { study, arrive, kg_per_kwh, season, plan };
    work.answer.print(|watch| ocmc_api::size(&request, watch))
}

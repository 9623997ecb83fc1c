//! `ocmc fit traffic`: densities by the hour and road type.

use super::{no_fit, write_study};
use crate::answer::Answer;
use crate::arguments::TrafficArguments;
use crate::failure::Failure;
use crate::log::mappings;
use ocmc_core::study::StudyModel;
use ocmc_estimation::fit::traffic::{TrafficFit, fit};
use ocmc_io::study::FittedPart;
use ocmc_io::table::Source;
use ocmc_io::{study, traffic_table};

/// Where the values stand in a study.
const KEYS: [&str; 1] = ["traffic"];

/// Fits the traffic model and prints its numbers.
pub(crate) fn traffic(arguments: &TrafficArguments) -> Result<(), Failure> {
    let base = study::load(&arguments.fitted.base, &[] as &[&str])?;
    let records = traffic_table::read(
        Source::File(&arguments.file),
        &mappings(&arguments.map)?,
        &base.model.traffic,
        arguments.utc_offset,
    )?;
    let fit = fit(&records, &base.model.traffic).map_err(|error| no_fit(&arguments.file, error))?;
    let answer = traffic_answer(&fit, &base.model);
    super::print(&arguments.fitted, &answer)?;
    write_study(&arguments.fitted, "traffic", std::slice::from_ref(&arguments.file), &answer)
}

/// What the fit of traffic tells; `base` keeps what it does not tell.
pub fn traffic_answer(fit: &TrafficFit, base: &StudyModel) -> Answer {
    let part = FittedPart::new(base, &KEYS, &fit.model);
    let head = format!("{} densities", fit.n);
    super::answer_of_parameters(fit, &head, &fit.parameters, &fit.warnings, &part)
}

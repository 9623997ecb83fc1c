//! `ocmc fit weather`: the climate of hourly records.

use super::{no_fit, write_study};
use crate::answer::Answer;
use crate::arguments::WeatherArguments;
use crate::failure::Failure;
use crate::log::mappings;
use ocmc_core::study::StudyModel;
use ocmc_estimation::fit::weather::{WeatherFit, fit};
use ocmc_io::study::FittedPart;
use ocmc_io::table::Source;
use ocmc_io::{study, weather_table};

/// Where the values stand in a study.
const KEYS: [&str; 1] = ["weather"];

/// Fits the weather model and prints its numbers.
pub(crate) fn weather(arguments: &WeatherArguments) -> Result<(), Failure> {
    let base = study::load(&arguments.fitted.base, &[] as &[&str])?;
    let records = weather_table::read(
        Source::File(&arguments.file),
        &mappings(&arguments.map)?,
        arguments.utc_offset,
    )?;
    let fit = fit(&records, &base.model.weather).map_err(|error| no_fit(&arguments.file, error))?;
    let answer = weather_answer(&fit, &base.model);
    super::print(&arguments.fitted, &answer)?;
    write_study(&arguments.fitted, "weather", std::slice::from_ref(&arguments.file), &answer)
}

/// What the fit of weather tells; `base` keeps what it does not tell.
pub fn weather_answer(fit: &WeatherFit, base: &StudyModel) -> Answer {
    let part = FittedPart::new(base, &KEYS, &fit.model);
    let head = format!("{} hours over {:.1} years", fit.hours, fit.years);
    super::answer_of_parameters(fit, &head, &fit.parameters, &fit.warnings, &part)
}

//! `ocmc fit weather`: the climate of hourly records.

use super::{no_fit, parameter_table, write_study};
use crate::answer::Answer;
use crate::arguments::WeatherArguments;
use crate::failure::Failure;
use ocmc_core::fit::weather::{WeatherFit, fit};
use ocmc_io::study::{fitted_json, fitted_text};
use ocmc_io::{study, weather_table};

/// Where the values stand in a study.
const KEYS: [&str; 1] = ["weather"];

/// Fits the weather model and prints its numbers.
pub(crate) fn weather(arguments: &WeatherArguments) -> Result<(), Failure> {
    let base = study::load(&arguments.fitted.base, &[] as &[&str])?;
    let records = weather_table::read(&arguments.file)?;
    let fit = fit(&records, &base.model.weather).map_err(|error| no_fit(&arguments.file, error))?;
    super::print(&arguments.fitted, &weather_answer(&fit))?;
    let values = fitted_text(&KEYS, &fit.model);
    write_study(&arguments.fitted, "weather", &arguments.file, &values)
}

/// What the fit of weather tells.
pub fn weather_answer(fit: &WeatherFit) -> Answer {
    let mut json = serde_json::to_value(fit).expect("numbers, words and lists");
    json["study"] = fitted_json(&KEYS, &fit.model);
    let table = parameter_table("", &fit.parameters);
    let text = format!(
        "{} hours over {:.1} years\n{table}\nTo paste into a study:\n\n{}",
        fit.hours,
        fit.years,
        fitted_text(&KEYS, &fit.model)
    );
    Answer { json, text, warnings: fit.warnings.clone() }
}

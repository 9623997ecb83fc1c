//! `ocmc fit weather`: the climate of hourly records.

use super::{no_fit, parameter_table, write_study};
use crate::arguments::WeatherArguments;
use crate::failure::Failure;
use crate::output;
use ocmc_core::fit::weather::fit;
use ocmc_io::study::{fitted_json, fitted_text};
use ocmc_io::{study, weather_table};

/// Where the values stand in a study.
const KEYS: [&str; 1] = ["weather"];

/// Fits the weather model and prints its numbers.
pub(crate) fn weather(arguments: &WeatherArguments) -> Result<(), Failure> {
    let base = study::load(&arguments.fitted.base, &[] as &[&str])?;
    let records = weather_table::read(&arguments.file)?;
    let fit = fit(&records, &base.model.weather).map_err(|error| no_fit(&arguments.file, error))?;
    for warning in &fit.warnings {
        output::note(&format!("warning: {warning}"));
    }
    let values = fitted_text(&KEYS, &fit.model);
    if arguments.fitted.json {
        let mut json = serde_json::to_value(&fit).expect("numbers, words and lists");
        json["study"] = fitted_json(&KEYS, &fit.model);
        output::answer(&format!("{json:#}\n"))?;
    } else {
        let table = parameter_table("", &fit.parameters);
        output::answer(&format!(
            "{} hours over {:.1} years\n{table}\nTo paste into a study:\n\n{values}",
            fit.hours, fit.years
        ))?;
    }
    write_study(&arguments.fitted, "weather", &arguments.file, &values)
}

//! `ocmc fit traffic`: densities by the hour and road type.

use super::{no_fit, parameter_table, write_study};
use crate::answer::Answer;
use crate::arguments::TrafficArguments;
use crate::failure::Failure;
use ocmc_core::fit::traffic::{TrafficFit, fit};
use ocmc_io::study::{fitted_json, fitted_text};
use ocmc_io::{study, traffic_table};

/// Where the values stand in a study.
const KEYS: [&str; 1] = ["traffic"];

/// Fits the traffic model and prints its numbers.
pub(crate) fn traffic(arguments: &TrafficArguments) -> Result<(), Failure> {
    let base = study::load(&arguments.fitted.base, &[] as &[&str])?;
    let records = traffic_table::read(&arguments.file, &base.model.traffic)?;
    let fit = fit(&records, &base.model.traffic).map_err(|error| no_fit(&arguments.file, error))?;
    super::print(&arguments.fitted, &traffic_answer(&fit))?;
    let values = fitted_text(&KEYS, &fit.model);
    write_study(&arguments.fitted, "traffic", &arguments.file, &values)
}

/// What the fit of traffic tells.
pub fn traffic_answer(fit: &TrafficFit) -> Answer {
    let mut json = serde_json::to_value(fit).expect("numbers, words and lists");
    json["study"] = fitted_json(&KEYS, &fit.model);
    let table = parameter_table("", &fit.parameters);
    let values = fitted_text(&KEYS, &fit.model);
    let text = format!("{} densities\n{table}\nTo paste into a study:\n\n{values}", fit.n);
    Answer { json, text, warnings: fit.warnings.clone() }
}

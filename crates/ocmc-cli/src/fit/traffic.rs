//! `ocmc fit traffic`: densities by the hour and road type.

use super::{no_fit, parameter_table, write_study};
use crate::answer::Answer;
use crate::arguments::TrafficArguments;
use crate::failure::Failure;
use ocmc_core::fit::traffic::fit;
use ocmc_io::study::{fitted_json, fitted_text};
use ocmc_io::{study, traffic_table};

/// Where the values stand in a study.
const KEYS: [&str; 1] = ["traffic"];

/// Fits the traffic model and prints its numbers.
pub(crate) fn traffic(arguments: &TrafficArguments) -> Result<(), Failure> {
    let base = study::load(&arguments.fitted.base, &[] as &[&str])?;
    let records = traffic_table::read(&arguments.file, &base.model.traffic)?;
    let fit = fit(&records, &base.model.traffic).map_err(|error| no_fit(&arguments.file, error))?;
    let values = fitted_text(&KEYS, &fit.model);
    let mut json = serde_json::to_value(&fit).expect("numbers, words and lists");
    json["study"] = fitted_json(&KEYS, &fit.model);
    let table = parameter_table("", &fit.parameters);
    let text = format!("{} densities\n{table}\nTo paste into a study:\n\n{values}", fit.n);
    let answer = Answer { json, text, warnings: fit.warnings };
    super::print(&arguments.fitted, &answer)?;
    write_study(&arguments.fitted, "traffic", &arguments.file, &values)
}

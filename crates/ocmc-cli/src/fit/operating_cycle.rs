//! `ocmc fit operating-cycle`: the road model of given operating cycles, and their bird's-eye view.

use super::{no_fit, parameter_table, write_study};
use crate::answer::Answer;
use crate::arguments::OperatingCycleArguments;
use crate::failure::Failure;
use ocmc_core::fit::operating_cycle::{BirdsEye, RoadFit, fit};
use ocmc_io::study::{fitted_json, fitted_text};
use ocmc_io::{given_cycle, study};
use serde_json::json;
use std::fmt::Write;

/// Where the values stand in a study.
const KEYS: [&str; 2] = ["road", "types"];

/// Fits the road model and prints its numbers.
pub(crate) fn operating_cycle(arguments: &OperatingCycleArguments) -> Result<(), Failure> {
    let base = study::load(&arguments.fitted.base, &[] as &[&str])?;
    let mut cycles = Vec::with_capacity(arguments.files.len());
    for path in &arguments.files {
        cycles.push(given_cycle::read(path)?);
    }
    let source = &arguments.files[0];
    let fit = fit(&cycles, &base.model.road).map_err(|error| no_fit(source, error))?;
    super::print(&arguments.fitted, &operating_cycle_answer(&fit))?;
    let values = fitted_text(&KEYS, &fit.model.types);
    write_study(&arguments.fitted, "operating-cycle", source, &values)
}

/// What the fit of operating cycles tells.
pub fn operating_cycle_answer(fit: &RoadFit) -> Answer {
    let mut json = serde_json::to_value(fit).expect("numbers, words and lists");
    json["study"] = fitted_json(&KEYS, &fit.model.types);
    let text = text(fit, &fitted_text(&KEYS, &fit.model.types));
    Answer { json, text, warnings: fit.warnings.clone() }
}

fn text(fit: &RoadFit, values: &str) -> String {
    let mut text = format!("{} operating cycles, {:.1} km\n", fit.cycles, fit.length_m / 1000.0);
    text.push_str(&view(&fit.birds_eye));
    for of_type in &fit.types {
        let _ = writeln!(text, "\n{}, {:.1} km", of_type.road_type, of_type.length_m / 1000.0);
        text.push_str(&parameter_table("", &of_type.parameters));
    }
    let _ = write!(text, "\nTo paste into a study:\n\n{values}");
    text
}

/// A class in words.
fn words(class: &serde_json::Value) -> String {
    class.as_str().unwrap_or_default().replace('_', " ")
}

fn view(view: &BirdsEye) -> String {
    let [three, six, nine] = view.share_below.map(|share| 100.0 * share);
    let mut text = format!(
        "hilliness {}: below 3 % on {three:.1} %, 6 % on {six:.1} %, 9 % on {nine:.1} % of the way\n\
         transport cycle {}; {:.2} stops and {:.2} curves below 500 m per km\n",
        words(&json!(view.hilliness)),
        words(&json!(view.transport_cycle)),
        view.stops_per_km,
        view.curves_per_km
    );
    for (name, share) in &view.road_type_share {
        let _ = writeln!(text, "{name}: {:.1} % of the way", 100.0 * share);
    }
    text
}

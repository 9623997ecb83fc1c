//! `ocmc fit operating-cycle`: the road model of given operating cycles or logs, and their bird's-eye view.

use super::{no_fit, parameter_table, write_study};
use crate::answer::Answer;
use crate::arguments::OperatingCycleArguments;
use crate::failure::Failure;
use crate::output;
use ocmc_core::fit::operating_cycle::{BirdsEye, RoadFit, fit_told};
use ocmc_core::log::curve::CurveOptions;
use ocmc_core::log::road::RoadOptions;
use ocmc_io::log::curves::Steering;
use ocmc_io::log::mapping::Mapping;
use ocmc_io::log::read;
use ocmc_io::log::roads::{FoundRoads, NEEDS, is_log};
use ocmc_io::study::{fitted_json, fitted_text};
use ocmc_io::{given_cycle, study};
use serde_json::json;
use std::convert::Infallible;
use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::PathBuf;

/// Fits the road model and prints its numbers.
pub(crate) fn operating_cycle(arguments: &OperatingCycleArguments) -> Result<(), Failure> {
    let base = study::load(&arguments.fitted.base, &[] as &[&str])?;
    let mappings: Vec<Mapping> =
        arguments.map.iter().map(|text| Mapping::parse(text)).collect::<Result<_, _>>()?;
    let (logs, cycles): (Vec<&PathBuf>, Vec<&PathBuf>) =
        arguments.files.iter().partition(|path| !mappings.is_empty() || is_log(path, &mappings));
    let radius_range_m = arguments.radius_range.as_ref().map(|range| [range[0], range[1]]);
    let mut found = FoundRoads::default();
    if !logs.is_empty() {
        add_logs(&mut found, arguments, radius_range_m, &logs, &mappings)?;
    }
    for path in cycles {
        found.add_cycle(given_cycle::read(path)?);
    }
    let (source, told) = (&arguments.files[0], found.told(radius_range_m));
    let fit = fit_told(&found.roads, &told, &base.model).map_err(|error| no_fit(source, error))?;
    super::print(&arguments.fitted, &operating_cycle_answer(&fit))?;
    write_study(&arguments.fitted, "operating-cycle", source, &fitted_text(&[], &fit.study()))
}

fn add_logs(
    found: &mut FoundRoads,
    arguments: &OperatingCycleArguments,
    radius_range_m: Option<[f64; 2]>,
    logs: &[&PathBuf],
    mappings: &[Mapping],
) -> Result<(), Failure> {
    let standard = RoadOptions::default();
    let options = RoadOptions {
        curves: CurveOptions { split_ratio: arguments.split, ..standard.curves },
        radius_range_m: radius_range_m.unwrap_or(standard.radius_range_m),
        altitude_average_m: arguments.altitude_average,
        mission_stop_s: arguments.mission_stop,
        road_type: arguments.road_type.clone(),
    };
    let steering = arguments
        .steering_ratio
        .zip(arguments.wheelbase_m)
        .map(|(ratio, wheelbase_m)| Steering { ratio, wheelbase_m });
    for path in logs {
        let file = read(path, mappings, &NEEDS)?;
        for warning in file.warnings() {
            output::note(&format!("warning: {warning}"));
        }
        let go_on = || ControlFlow::<Infallible>::Continue(());
        let ControlFlow::Continue(()) = found.add(&file, &options, steering, go_on);
    }
    if let Some((place, fault)) = found.failed() {
        return Err(Failure::Drive { place: place.clone(), fault: fault.clone() });
    }
    for note in &found.notes {
        output::note(&format!("warning: {note}"));
    }
    for (place, fault) in &found.left_out {
        output::note(&format!("warning: {place} is left out: {fault}"));
    }
    Ok(())
}

/// What the fit of operating cycles tells.
pub fn operating_cycle_answer(fit: &RoadFit) -> Answer {
    let mut json = serde_json::to_value(fit).expect("numbers, words and lists");
    json["study"] = fitted_json(&[], &fit.study());
    let text = text(fit, &fitted_text(&[], &fit.study()));
    Answer { json, text, warnings: fit.warnings.clone() }
}

fn text(fit: &RoadFit, values: &str) -> String {
    let mut text = format!("{} operating cycles, {:.1} km\n", fit.cycles, fit.length_m / 1000.0);
    text.push_str(&view(&fit.birds_eye));
    for of_type in &fit.types {
        let _ = writeln!(text, "\n{}, {:.1} km", of_type.road_type, of_type.length_m / 1000.0);
        text.push_str(&parameter_table("", &of_type.parameters));
    }
    for (title, parameters) in
        [("turns at junctions", &fit.junction_turn), ("mission", &fit.mission)]
    {
        if !parameters.is_empty() {
            let _ = writeln!(text);
            text.push_str(&parameter_table(title, parameters));
        }
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
         transport cycle {}; stops {}, {:.2} per km; curves below 500 m {}, {:.2} per km\n",
        words(&json!(view.hilliness)),
        words(&json!(view.transport_cycle)),
        words(&json!(view.stop_density)),
        view.stops_per_km,
        words(&json!(view.curve_density)),
        view.curves_per_km
    );
    for (name, share) in &view.road_type_share {
        let _ = writeln!(text, "{name}: {:.1} % of the way", 100.0 * share);
    }
    text
}

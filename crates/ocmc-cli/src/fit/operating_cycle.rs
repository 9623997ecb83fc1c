//! `ocmc fit operating-cycle`: the road model of given operating cycles or logs, and their bird's-eye view.

use super::{no_fit, parameter_table, write_study};
use crate::answer::Answer;
use crate::arguments::OperatingCycleArguments;
use crate::birds_eye::birds_eye_text;
use crate::failure::Failure;
use crate::log::{mappings, read_logs, tell_left_out};
use crate::number_text::count_of;
use crate::output;
use ocmc_core::study::StudyModel;
use ocmc_estimation::fit::operating_cycle::{RoadFit, fit_with_coverage};
use ocmc_estimation::log::curve::CurveOptions;
use ocmc_estimation::log::road::RoadOptions;
use ocmc_io::log::roads::{FoundRoads, NEEDS, is_log};
use ocmc_io::study::FittedPart;
use ocmc_io::table::Mapping;
use ocmc_io::{given_cycle, study};
use std::convert::Infallible;
use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::PathBuf;

/// Fits the road model and prints its numbers.
pub(crate) fn operating_cycle(arguments: &OperatingCycleArguments) -> Result<(), Failure> {
    let base = study::load(&arguments.fitted.base, &[] as &[&str])?;
    let mappings = mappings(&arguments.map)?;
    let (logs, cycles): (Vec<&PathBuf>, Vec<&PathBuf>) =
        arguments.files.iter().partition(|path| !mappings.is_empty() || is_log(path, &mappings));
    let radius_range_m = arguments.radius_range.as_ref().map(|range| [range[0], range[1]]);
    let mut found = FoundRoads::default();
    if !logs.is_empty() {
        add_logs(&mut found, arguments, radius_range_m, &logs, &mappings)?;
    }
    for path in cycles {
        found.add_cycle(given_cycle::read(path, &[])?);
    }
    let (sources, coverage) = (&arguments.files, found.coverage(radius_range_m));
    let fit = fit_with_coverage(&found.roads, &coverage, &base.model)
        .map_err(|error| no_fit(&sources[0], error))?;
    let answer = operating_cycle_answer(&fit, &base.model);
    super::print(&arguments.fitted, &answer)?;
    write_study(&arguments.fitted, "operating-cycle", sources, &answer)
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
    let steering = arguments.steering.steering()?;
    let paths = logs.iter().map(|path| path.as_path());
    read_logs(paths, mappings, &NEEDS, |file| {
        let go_on = || ControlFlow::<Infallible>::Continue(());
        let ControlFlow::Continue(()) = found.add(file, &options, steering, go_on);
    })?;
    for note in &found.notes {
        output::note(&format!("warning: {note}"));
    }
    tell_left_out(found.failed(), &found.left_out)
}

/// What the fit of operating cycles tells; `base` keeps what it does not tell.
pub fn operating_cycle_answer(fit: &RoadFit, base: &StudyModel) -> Answer {
    let part = FittedPart::new(base, &[], &fit.study());
    super::answer(fit, text(fit, &part.text()), &fit.warnings, &part)
}

fn text(fit: &RoadFit, values: &str) -> String {
    let mut text = format!(
        "{}, {:.1} km\n",
        count_of(fit.cycles as u64, "operating cycle"),
        fit.length_m / 1000.0
    );
    text.push_str(&birds_eye_text(&fit.birds_eye));
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

//! `ocmc fit curve-speed`: the driver population of measured curves.

use super::curve_speed_text::curve_speed_text;
use super::{no_fit, write_study};
use crate::answer::Answer;
use crate::arguments::CurveSpeedArguments;
use crate::failure::Failure;
use crate::log::mappings;
use crate::request;
use ocmc_core::driver::curve_speed::CurveSpeedModel;
use ocmc_core::study::StudyModel;
use ocmc_estimation::fit::curve_speed::{CurveSpeedFit, CurveSpeedOptions, fit};
use ocmc_io::study::FittedPart;
use ocmc_io::table::Source;
use ocmc_io::{curve_table, study};

/// Where the values stand in a study.
const KEYS: [&str; 2] = ["driver", "curve_speed"];

/// Fits curve speeds and prints what they tell.
pub(crate) fn curve_speed(arguments: &CurveSpeedArguments) -> Result<(), Failure> {
    let base = study::load(&arguments.fitted.base, &[] as &[&str])?;
    let table = curve_table::read(Source::File(&arguments.file), &mappings(&arguments.map)?)?;
    let fit = fit(&table, &options(arguments)).map_err(|error| no_fit(&arguments.file, error))?;
    let censored = fit.tobit.as_ref().filter(|_| arguments.tobit);
    if arguments.tobit && censored.is_none() {
        return Err(request::usage(
            "--tobit needs a column limit_mps with limits above 0, and curves below them that determine the regression",
        ));
    }
    let population = fit.population(censored, &base.model.driver.curve_speed);
    let answer = curve_speed_answer(&fit, &population, table.driver.len(), &base.model);
    super::print(&arguments.fitted, &answer)?;
    write_study(&arguments.fitted, "curve-speed", std::slice::from_ref(&arguments.file), &answer)
}

/// What the fit of a table with so many rows tells; `population` is the part of a study that follows from it, `base` the study
/// that it is laid over.
pub fn curve_speed_answer(
    fit: &CurveSpeedFit,
    population: &CurveSpeedModel,
    rows: usize,
    base: &StudyModel,
) -> Answer {
    let part = FittedPart::new(base, &KEYS, population);
    let text = curve_speed_text(fit, rows, &part.text());
    super::answer(fit, text, &fit.warnings, &part)
}

fn options(arguments: &CurveSpeedArguments) -> CurveSpeedOptions {
    CurveSpeedOptions {
        reference_radius_m: arguments.reference_radius,
        radius_range_m: [arguments.minimum_radius, arguments.maximum_radius],
        minimum_route_m: arguments.minimum_route,
        fixed_exponent: arguments.fixed_exponent,
        significance: arguments.significance,
        limit_share: arguments.limit_share,
        coding: arguments.coding.into(),
    }
}

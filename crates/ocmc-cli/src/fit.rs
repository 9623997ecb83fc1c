//! `ocmc fit`: from measurements to the numbers of a study.

use crate::arguments::{
    CurveSpeedArguments, FitCommand, FittedArguments, OperatingCycleArguments,
    SpeedChangeArguments, TrafficArguments, WeatherArguments,
};
use crate::failure::Failure;
use crate::output::{self, warn};
use crate::study::write_new;
use ocmc_api::shell_word::shell_word;
use ocmc_api::study::{self, StudyModel, fitted_study};
use ocmc_api::{
    CurveOptions, CurveSpeedOptions, CurveSpeedRequest, FitAnswer, OperatingCycleRequest,
    RoadOptions, RoadSource, Source, SpeedChangeOptions, SpeedChangeRequest, TrafficRequest,
    WeatherRequest, go_on, mappings,
};
use serde::Serialize;
use std::path::PathBuf;

/// Most files that a study names as its sources.
const MOST_NAMED: usize = 4;

/// Fits what was asked for.
pub(crate) fn fit(command: &FitCommand) -> Result<(), Failure> {
    match command {
        FitCommand::CurveSpeed(arguments) => curve_speed(arguments),
        FitCommand::OperatingCycle(arguments) => operating_cycle(arguments),
        FitCommand::SpeedChange(arguments) => speed_change(arguments),
        FitCommand::Traffic(arguments) => traffic(arguments),
        FitCommand::Weather(arguments) => weather(arguments),
    }
}

fn curve_speed(arguments: &CurveSpeedArguments) -> Result<(), Failure> {
    let CurveSpeedArguments { file, fitted, tobit, .. } = arguments;
    let base = &base(fitted)?;
    let options = CurveSpeedOptions {
        reference_radius_m: arguments.reference_radius,
        radius_range_m: [arguments.minimum_radius, arguments.maximum_radius],
        minimum_route_m: arguments.minimum_route,
        fixed_exponent: arguments.fixed_exponent,
        significance: arguments.significance,
        limit_share: arguments.limit_share,
        coding: arguments.coding.into(),
    };
    let (curves, mappings) = (Source::File(file.clone()), mappings(&arguments.map)?);
    let request = CurveSpeedRequest { curves, mappings, base, options, tobit: *tobit };
    let answer = ocmc_api::fit_curve_speed(&request)?;
    deliver(fitted, "curve-speed", std::slice::from_ref(file), &answer)
}

fn speed_change(arguments: &SpeedChangeArguments) -> Result<(), Failure> {
    let SpeedChangeArguments { files, fitted, .. } = arguments;
    let base = &base(fitted)?;
    let mappings = mappings(&arguments.map)?;
    let options = SpeedChangeOptions {
        window_s: arguments.window,
        smallest_acceleration_mps2: arguments.smallest_acceleration,
        smallest_deceleration_mps2: arguments.smallest_deceleration,
        ..SpeedChangeOptions::default()
    };
    let (tables, untruncated) = (&sources(files)[..], arguments.untruncated);
    let request = SpeedChangeRequest { tables, mappings, base, options, untruncated };
    let answer = ocmc_api::fit_speed_change(&request, &mut warn, &mut go_on)?;
    deliver(fitted, "speed-change", files, &answer)
}

fn operating_cycle(arguments: &OperatingCycleArguments) -> Result<(), Failure> {
    let OperatingCycleArguments { files, fitted, .. } = arguments;
    let base = &base(fitted)?;
    let mappings = mappings(&arguments.map)?;
    let radius_range_m = arguments.radius_range.as_ref().map(|range| [range[0], range[1]]);
    let standard = RoadOptions::default();
    let options = RoadOptions {
        curves: CurveOptions { split_ratio: arguments.split, ..standard.curves },
        radius_range_m: radius_range_m.unwrap_or(standard.radius_range_m),
        altitude_average_m: arguments.altitude_average,
        mission_stop_s: arguments.mission_stop,
        road_type: arguments.road_type.clone(),
    };
    let steering = arguments.steering.steering()?;
    let roads: Vec<RoadSource> = sources(files).into_iter().map(RoadSource::Measured).collect();
    let roads = &roads[..];
    let request =
        OperatingCycleRequest { roads, mappings, base, options, radius_range_m, steering };
    let answer = ocmc_api::fit_operating_cycle(&request, &mut warn, &mut go_on)?;
    deliver(fitted, "operating-cycle", files, &answer)
}

fn traffic(arguments: &TrafficArguments) -> Result<(), Failure> {
    let TrafficArguments { file, map, fitted, utc_offset } = arguments;
    let base = &base(fitted)?;
    let (table, mappings) = (Source::File(file.clone()), mappings(map)?);
    let request = TrafficRequest { table, mappings, base, utc_offset_h: *utc_offset };
    let answer = ocmc_api::fit_traffic(&request)?;
    deliver(fitted, "traffic", std::slice::from_ref(file), &answer)
}

fn weather(arguments: &WeatherArguments) -> Result<(), Failure> {
    let WeatherArguments { file, map, fitted, utc_offset } = arguments;
    let base = &base(fitted)?;
    let (table, mappings) = (Source::File(file.clone()), mappings(map)?);
    let request = WeatherRequest { table, mappings, base, utc_offset_h: *utc_offset };
    let answer = ocmc_api::fit_weather(&request)?;
    deliver(fitted, "weather", std::slice::from_ref(file), &answer)
}

/// The study that keeps what is not fitted.
fn base(arguments: &FittedArguments) -> Result<StudyModel, Failure> {
    Ok(study::load(&arguments.base, &[] as &[&str])?.model)
}

/// Files to read.
pub(crate) fn sources(files: &[PathBuf]) -> Vec<Source> {
    files.iter().cloned().map(Source::File).collect()
}

/// Prints the answer of a fit, and writes the study with fitted values, where one was asked for.
fn deliver<Fit: Serialize>(
    arguments: &FittedArguments,
    command: &str,
    files: &[PathBuf],
    answer: &FitAnswer<Fit>,
) -> Result<(), Failure> {
    output::print(answer, arguments.json)?;
    let Some(path) = &arguments.study_out else {
        return Ok(());
    };
    let name = path.file_stem().map_or("fitted".into(), |stem| stem.to_string_lossy());
    let note = format!("Written by `ocmc fit {command}` from {}.", named(files));
    let (text, _) = fitted_study(&arguments.base, &name, &note, &answer.study)?;
    write_new(path, &text)?;
    let (shown, word) = (path.display(), shell_word(path));
    output::note(&format!("Written: `{shown}`. Run it: ocmc --study {word}"));
    Ok(())
}

/// Files by their names; of many, the first ones.
fn named(files: &[PathBuf]) -> String {
    let names = files.iter().take(MOST_NAMED).map(|file| format!("`{}`", file.display()));
    let names = names.collect::<Vec<_>>().join(", ");
    match files.len().saturating_sub(MOST_NAMED) {
        0 => names,
        more => format!("{names} and {more} more"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_are_named() {
        let files: Vec<PathBuf> = (1..=6).map(|k| PathBuf::from(format!("{k}.csv"))).collect();
        assert_eq!(named(&files[..1]), "`1.csv`");
        assert_eq!(named(&files[..4]), "`1.csv`, `2.csv`, `3.csv`, `4.csv`");
        assert_eq!(named(&files), "`1.csv`, `2.csv`, `3.csv`, `4.csv` and 2 more");
    }
}

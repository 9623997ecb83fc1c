//! `ocmc calibrate`: the laws behind measured tables.

use crate::arguments::{NoiseOptions, StudyOptions, WorkOptions, whole_number};
use crate::failure::Failure;
use crate::progress::watched;
use crate::study::write_fitted;
use clap::{Args, Subcommand};
use ocmc_api::study;
use ocmc_api::{
    CalibrateCurveSpeedRequest, CalibrateTotalsRequest, CalibrationOptions, CurveSpeedOptions,
    MeasuredTable, Source, Trips, mappings,
};
use std::path::{Path, PathBuf};

/// Parts that can be calibrated.
#[derive(Clone, Debug, Subcommand)]
pub(crate) enum CalibrateCommand {
    /// Curve speeds: the law with which a study, driven and measured as drivers were, gives a
    /// measured table back
    CurveSpeed(CurveSpeedArguments),
    /// Totals of trips: the judged numbers with which a study takes what the trips of a fleet, or
    /// the fills of its tanks, took
    Totals(TotalsArguments),
}

/// Options of the calibration to totals.
#[derive(Clone, Debug, Args)]
pub(crate) struct TotalsArguments {
    /// Table with one row a trip: distance_km, fuel_l or energy_kwh, and where known
    /// gross_weight_kg, driving_time_h, climb_m, truck, driver, date; or a row a fill: truck,
    /// odometer_km, litres, full
    #[arg(value_name = "TRIPS")]
    trips: PathBuf,
    /// Says which column is what, as in fuel_amount_l=diesel; may be repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    map: Vec<String>,
    #[command(flatten)]
    study: StudyOptions,
    #[command(flatten)]
    noise: NoiseOptions,
    /// Master seed
    #[arg(
        long, value_name = "N", default_value = "1", allow_negative_numbers = true,
        value_parser = whole_number(0..=u64::MAX)
    )]
    seed: u64,
    #[command(flatten)]
    work: WorkOptions,
    /// Study file to write: the study with what the table tells laid over it
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Options of the calibration of curve speeds.
#[derive(Clone, Debug, Args)]
pub(crate) struct CurveSpeedArguments {
    /// Table of curves, as `ocmc curves` writes it, or the name of a built-in study or a study file
    /// whose law is what was measured, such as `field-truck-printed`
    #[arg(value_name = "TABLE")]
    table: PathBuf,
    /// Says which column is what, as in speed_mph=gps_speed or yaw_rate_degps=-gyro; may be
    /// repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    map: Vec<String>,
    #[command(flatten)]
    study: StudyOptions,
    /// Drivers of the simulated table
    #[arg(
        long, value_name = "N", default_value = "240", allow_negative_numbers = true,
        value_parser = whole_number(20..=100_000_u64)
    )]
    drivers: u64,
    /// Trips of each of them
    #[arg(
        long, value_name = "N", default_value = "1", allow_negative_numbers = true,
        value_parser = whole_number(1..=1000_u64)
    )]
    trips: u64,
    /// Master seed
    #[arg(
        long, value_name = "N", default_value = "1", allow_negative_numbers = true,
        value_parser = whole_number(0..=u64::MAX)
    )]
    seed: u64,
    /// Smallest residual SD that the law may have
    #[arg(long, value_name = "SD", default_value = "0.048", allow_negative_numbers = true)]
    least_residual_sd: f64,
    /// Smallest radius that takes part, in m
    #[arg(long, value_name = "M", default_value = "20", allow_negative_numbers = true)]
    minimum_radius: f64,
    /// Largest radius that takes part, in m
    #[arg(long, value_name = "M", default_value = "500", allow_negative_numbers = true)]
    maximum_radius: f64,
    /// Only curves with at least this lateral acceleration (speed squared over radius) take part,
    /// in m/s²
    #[arg(long, value_name = "MPS2", default_value = "0", allow_negative_numbers = true)]
    least_lateral: f64,
    #[command(flatten)]
    work: WorkOptions,
    /// Study file to write: the study with the calibrated law laid over it
    #[arg(long, value_name = "FILE")]
    study_out: Option<PathBuf>,
}

/// Calibrates what was asked for.
pub(crate) fn calibrate(command: &CalibrateCommand) -> Result<(), Failure> {
    match command {
        CalibrateCommand::CurveSpeed(arguments) => curve_speed(arguments),
        CalibrateCommand::Totals(arguments) => totals(arguments),
    }
}

fn curve_speed(arguments: &CurveSpeedArguments) -> Result<(), Failure> {
    let CurveSpeedArguments { table, work: WorkOptions { threads, answer }, study_out, .. } =
        arguments;
    let study = &arguments.study.load()?;
    let law;
    let measured = if is_study(table) {
        law = study::load(&table.to_string_lossy(), &[] as &[&str])
            .map_err(ocmc_api::Error::from)?
            .model;
        MeasuredTable::Law(&law)
    } else {
        MeasuredTable::Curves(Source::File(table.clone()), mappings(&arguments.map)?)
    };
    let options = CalibrationOptions {
        trips: Trips {
            seed: arguments.seed,
            drivers: arguments.drivers,
            per_driver: arguments.trips,
            threads: threads.unwrap_or(0),
        },
        fit: CurveSpeedOptions {
            reference_radius_m: study.model.driver.curve_speed.reference_radius_m,
            radius_range_m: [arguments.minimum_radius, arguments.maximum_radius],
            least_lateral_mps2: arguments.least_lateral,
            ..CurveSpeedOptions::default()
        },
        least_residual_sd: arguments.least_residual_sd,
        ..CalibrationOptions::default()
    };
    let request = CalibrateCurveSpeedRequest { table: measured, study, options };
    let calibrated =
        watched(answer.quiet, |watch| ocmc_api::calibrate_curve_speed(&request, watch))?;
    answer.show(&calibrated)?;
    let Some(path) = study_out else { return Ok(()) };
    let by = ("calibrate curve-speed", &*format!("`{}`", table.display()));
    let base = arguments.study.study.to_string_lossy();
    write_fitted(path, &base, "calibrated", by, &calibrated.study, answer.quiet)
}

fn totals(arguments: &TotalsArguments) -> Result<(), Failure> {
    let TotalsArguments { trips, work, out, .. } = arguments;
    let request = CalibrateTotalsRequest {
        trips: Source::File(trips.clone()),
        mappings: mappings(&arguments.map)?,
        study: &arguments.study.load()?,
        noise: arguments.noise.noise(),
        seed: arguments.seed,
        threads: work.threads,
    };
    let answer = work.answer;
    let calibrated = watched(answer.quiet, |watch| ocmc_api::calibrate_totals(&request, watch))?;
    answer.show(&calibrated)?;
    let Some(path) = out else { return Ok(()) };
    let base = arguments.study.study.to_string_lossy();
    let by = ("calibrate totals", calibrated.standing.as_str());
    write_fitted(path, &base, "calibrated", by, &calibrated.study, answer.quiet)
}

/// Whether a table is a study: by the ending of its file, or by the name of a built-in one.
fn is_study(table: &Path) -> bool {
    let is_toml = table.extension().is_some_and(|end| end.eq_ignore_ascii_case("toml"));
    is_toml || (table.extension().is_none() && !table.exists())
}

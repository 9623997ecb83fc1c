//! `ocmc fit`: from measurements to the numbers of a study.

use crate::arguments::{AnswerOptions, FileOptions, one_of, share, sources, whole_number};
use crate::failure::Failure;
use crate::log::SteeringArguments;
use crate::output::warn;
use crate::study::write_fitted;
use clap::{Args, Subcommand};
use ocmc_api::number_text::count_of;
use ocmc_api::study::StudyModel;
use ocmc_api::{
    BESTS, Best, CODINGS, Coding, CurveOptions, CurveSpeedOptions, CurveSpeedRequest, FitAnswer,
    FleetOptions, FleetRequest, MOST_DRAWS, MOST_NEXT_TRIPS, OperatingCycleRequest, PlaceClock,
    RoadOptions, RoadSource, Source, SpeedChangeOptions, SpeedChangeRequest, TrafficRequest,
    WeatherRequest, fit_traffic, fit_weather, go_on, mappings,
};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::slice::from_ref;

/// Most files that a study names as its sources.
const MOST_NAMED: usize = 4;

/// Laws that can be fitted.
#[derive(Clone, Debug, Subcommand)]
pub(crate) enum FitCommand {
    /// Curve speeds: regression and analysis of variance of measured curves, and the driver
    /// population
    CurveSpeed(CurveSpeedArguments),
    /// Speed changes: log-normal accelerations and decelerations at changes of the speed limit
    SpeedChange(SpeedChangeArguments),
    /// Operating cycles: road types, signs, events, curves, slope, surface and mission of given
    /// roads, or of logs
    OperatingCycle(OperatingCycleArguments),
    /// Weather: the climate of hourly records
    Weather(WeatherArguments),
    /// Traffic: densities by the hour and road type
    Traffic(TrafficArguments),
    /// Records of a fleet: how much trucks, drivers and trips differ, a league table and how sure
    /// it is, how many trips tell two apart, and the year to come
    Fleet(FleetArguments),
}

/// Where fitted values go.
#[derive(Clone, Debug, Args)]
pub(crate) struct FittedArguments {
    #[command(flatten)]
    answer: AnswerOptions,
    /// Study file to write: the base with the fitted values laid over it
    #[arg(long, value_name = "FILE")]
    study_out: Option<PathBuf>,
    /// Name of a built-in study, or a study file, that keeps what is not fitted
    #[arg(long, value_name = "NAME|FILE", default_value = "field-truck")]
    base: String,
    #[command(flatten)]
    files: FileOptions,
}

impl FittedArguments {
    /// The study that keeps what is not fitted.
    fn base(&self) -> Result<StudyModel, Failure> {
        Ok(self.files.load(Path::new(&self.base), &[])?.model)
    }
}

/// Options of the fit of curve speeds.
#[derive(Clone, Debug, Args)]
pub(crate) struct CurveSpeedArguments {
    /// Table of curves: driver,radius_m,direction,speed_mps and, where known, route_m,limit_mps,
    /// gap_before_m,gap_after_m,slowest_near_mps,stop_near_m
    #[arg(value_name = "CURVES.csv")]
    file: PathBuf,
    /// Says which column is what, as in speed_mph=gps_speed or yaw_rate_degps=-gyro; may be
    /// repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    map: Vec<String>,
    /// Radius at which speeds are compared, in m
    #[arg(long, value_name = "M", default_value = "250", allow_negative_numbers = true)]
    reference_radius: f64,
    /// Smallest radius that takes part, in m
    #[arg(long, value_name = "M", default_value = "20", allow_negative_numbers = true)]
    minimum_radius: f64,
    /// Largest radius that takes part, in m
    #[arg(long, value_name = "M", default_value = "500", allow_negative_numbers = true)]
    maximum_radius: f64,
    /// Routes have to be longer than this, in m, where the table has route_m
    #[arg(long, value_name = "M", default_value = "5000", allow_negative_numbers = true)]
    minimum_route: f64,
    /// Only curves that were driven freely: none with another curve, a standstill, or the log's end
    /// within this way, in m, or with a slower speed near it (needs gap_before_m,gap_after_m)
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    isolated: Option<f64>,
    /// Only curves with at least this lateral acceleration (speed squared over radius), in m/s²
    #[arg(long, value_name = "MPS2", default_value = "0", allow_negative_numbers = true)]
    least_lateral: f64,
    /// Exponent of the second model, and the one that is tested
    #[arg(long, value_name = "DELTA", default_value = "0.5", allow_negative_numbers = true)]
    fixed_exponent: f64,
    /// The direction stays in the model where its p is below this
    #[arg(long, value_name = "P", default_value = "0.05", allow_negative_numbers = true)]
    significance: f64,
    /// The population from the censored regression at the speed limits (needs limit_mps)
    #[arg(long)]
    tobit: bool,
    /// Share of the speed limit from which on a curve counts as driven at the limit
    #[arg(long, value_name = "SHARE", default_value = "0.9", allow_negative_numbers = true)]
    limit_share: f64,
    /// How the coefficients of drivers and directions are listed in the JSON
    #[arg(
        long, value_name = "CODING", default_value = "sum-to-zero", value_parser = one_of(CODINGS)
    )]
    coding: Coding,
    #[command(flatten)]
    fitted: FittedArguments,
}

/// Options of the fit of speed changes.
#[derive(Clone, Debug, Args)]
pub(crate) struct SpeedChangeArguments {
    /// Tables of speed changes (acceleration_mps2 and, where known, category,driver), or logs
    /// (time, speed, limit)
    #[arg(required = true, value_name = "FILE.csv")]
    files: Vec<PathBuf>,
    /// Says which column is what, as in speed_mph=gps_speed or yaw_rate_degps=-gyro; may be
    /// repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    map: Vec<String>,
    /// Length of the window with the largest change of speed in a log, in s
    #[arg(long, value_name = "S", default_value = "2", allow_negative_numbers = true)]
    window: f64,
    /// Smallest acceleration that counts as a change, in m/s²
    #[arg(long, value_name = "MPS2", default_value = "0.2", allow_negative_numbers = true)]
    smallest_acceleration: f64,
    /// Smallest deceleration that counts as a change, in m/s²
    #[arg(long, value_name = "MPS2", default_value = "0.4", allow_negative_numbers = true)]
    smallest_deceleration: f64,
    /// The study from the laws with the thresholds in their likelihood
    #[arg(long)]
    untruncated: bool,
    #[command(flatten)]
    fitted: FittedArguments,
}

/// Options of the fit of operating cycles.
#[derive(Clone, Debug, Args)]
pub(crate) struct OperatingCycleArguments {
    /// Operating cycles with road types, as `ocmc cycle` writes them, or logs: CSV with time and
    /// speed
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Says which column is what, as in speed_mph=gps_speed or yaw_rate_degps=-gyro; may be
    /// repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    map: Vec<String>,
    /// Smallest and largest radius of the curves that are known, in m; the others are there and
    /// were not seen [default: 20 500 of logs, all of operating cycles]
    #[arg(long, value_names = ["LOWER", "UPPER"], num_args = 2, allow_negative_numbers = true)]
    radius_range: Option<Vec<f64>>,
    /// Road type of logs that have no column road_type [default: by the speed limit]
    #[arg(long, value_name = "NAME")]
    road_type: Option<String>,
    /// Length over which the altitudes of logs are averaged for the bird's-eye view, in m
    #[arg(long, value_name = "M", default_value = "200", allow_negative_numbers = true)]
    altitude_average: f64,
    /// Standstills of logs from this time on are stops of the mission, in s
    #[arg(long, value_name = "S", default_value = "300", allow_negative_numbers = true)]
    mission_stop: f64,
    /// Cuts a curve of a log in two where its curvature steps by this factor or more
    #[arg(long, value_name = "RATIO")]
    split: Option<f64>,
    #[command(flatten)]
    steering: SteeringArguments,
    #[command(flatten)]
    fitted: FittedArguments,
}

/// Options of the fit of the weather.
#[derive(Clone, Debug, Args)]
pub(crate) struct WeatherArguments {
    /// Tables of hours: time or time_s and any of temperature_k|_c, pressure_pa|_hpa,
    /// relative_humidity|_percent, precipitation_mps|_mm_per_h, wind_speed_mps,
    /// wind_direction_rad|_deg; several files of one place are joined by time
    #[arg(value_name = "HOURS.csv", required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    options: HourlyFitOptions,
}

/// Options of the fit of the traffic.
#[derive(Clone, Debug, Args)]
pub(crate) struct TrafficArguments {
    /// Table of measurements: road_type, time or time_s, one of density_share, density_per_m,
    /// speed_ratio, and, where there are several of a type, site
    #[arg(value_name = "TRAFFIC.csv")]
    file: PathBuf,
    #[command(flatten)]
    options: HourlyFitOptions,
}

/// Options of the fits of hours.
#[derive(Clone, Debug, Args)]
pub(crate) struct HourlyFitOptions {
    /// Says which column is what, as in speed_mph=gps_speed or yaw_rate_degps=-gyro; may be
    /// repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    map: Vec<String>,
    /// Hours by which the place's standard time is ahead of UTC, for times in UTC or with an
    /// offset, such as 2024-03-01T14:00Z
    #[arg(long, value_name = "H", allow_negative_numbers = true, value_parser = utc_offset)]
    utc_offset: Option<PlaceClock>,
    /// Time zone of the place, such as Europe/Berlin, for times in UTC or with an offset, and for
    /// local times with summer time
    #[arg(
        long, value_name = "NAME", conflicts_with = "utc_offset", value_parser = PlaceClock::zone
    )]
    zone: Option<PlaceClock>,
    #[command(flatten)]
    fitted: FittedArguments,
}

/// Options of the fit of a fleet's records.
#[derive(Clone, Debug, Args)]
pub(crate) struct FleetArguments {
    /// Records with one row a trip: truck_id and, where known, driver_id, or the directory of a run
    #[arg(value_name = "RECORDS")]
    records: PathBuf,
    /// Column that is compared [default: consumption_l_per_100km, of electric trucks
    /// consumption_kwh_per_km]
    #[arg(long, value_name = "COLUMN")]
    column: Option<String>,
    /// Column that says how much a trip counts, such as distance_m: the variance of a trip is
    /// inverse to it; `none`: each counts once [default: the distance, of amounts over the
    /// distance]
    #[arg(long, value_name = "COLUMN")]
    weight: Option<String>,
    /// Says which column is what, as in truck=plate; may be repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    map: Vec<String>,
    /// Drivers are numbered within each truck: driver 1 of two trucks are two drivers
    #[arg(long)]
    own_drivers: bool,
    /// Months are part of the model (needs departure_s_of_year)
    #[arg(long)]
    month: bool,
    /// Difference that is to be told apart, of the mean
    #[arg(
        long, value_name = "SHARE", default_value = "1%", value_parser = share,
        allow_negative_numbers = true
    )]
    differ: f64,
    /// Power with which it is to be told apart
    #[arg(
        long, value_name = "SHARE", default_value = "80%", value_parser = share,
        allow_negative_numbers = true
    )]
    power: f64,
    /// Trips of each truck in the next year [default: as in the records]
    #[arg(
        long, value_name = "N", value_parser = whole_number(1..=MOST_NEXT_TRIPS),
        allow_negative_numbers = true
    )]
    next_trips: Option<u64>,
    /// End of the column that stands first in the league
    #[arg(long, value_name = "END", default_value = "lowest", value_parser = one_of(BESTS))]
    best: Best,
    /// Draws of all trucks and drivers, in which it is counted how sure the league is
    #[arg(
        long, value_name = "N", default_value = "4000", value_parser = whole_number(1..=MOST_DRAWS),
        allow_negative_numbers = true
    )]
    draws: u64,
    /// Seed of these draws
    #[arg(
        long, value_name = "N", default_value = "1", value_parser = whole_number(0..=u64::MAX),
        allow_negative_numbers = true
    )]
    seed: u64,
    #[command(flatten)]
    answer: AnswerOptions,
}

/// The clock of a place by the hours by which its standard time is ahead of UTC.
fn utc_offset(text: &str) -> Result<PlaceClock, String> {
    PlaceClock::ahead(text.parse().unwrap_or(f64::NAN))
}

/// Fits what was asked for.
pub(crate) fn fit(command: &FitCommand) -> Result<(), Failure> {
    match command {
        FitCommand::CurveSpeed(arguments) => curve_speed(arguments),
        FitCommand::OperatingCycle(arguments) => operating_cycle(arguments),
        FitCommand::SpeedChange(arguments) => speed_change(arguments),
        FitCommand::Fleet(arguments) => fleet(arguments),
        FitCommand::Traffic(arguments) => traffic(arguments),
        FitCommand::Weather(arguments) => weather(arguments),
    }
}

fn curve_speed(arguments: &CurveSpeedArguments) -> Result<(), Failure> {
    let CurveSpeedArguments { file, fitted, tobit, .. } = arguments;
    let base = &fitted.base()?;
    let options = CurveSpeedOptions {
        reference_radius_m: arguments.reference_radius,
        radius_range_m: [arguments.minimum_radius, arguments.maximum_radius],
        minimum_route_m: arguments.minimum_route,
        isolated_m: arguments.isolated,
        least_lateral_mps2: arguments.least_lateral,
        fixed_exponent: arguments.fixed_exponent,
        significance: arguments.significance,
        limit_share: arguments.limit_share,
        coding: arguments.coding,
    };
    let (curves, mappings) = (Source::File(file.clone()), mappings(&arguments.map)?);
    let request = CurveSpeedRequest { curves, mappings, base, options, tobit: *tobit };
    let answer = ocmc_api::fit_curve_speed(&request)?;
    deliver(fitted, "curve-speed", from_ref(file), &answer)
}

fn speed_change(arguments: &SpeedChangeArguments) -> Result<(), Failure> {
    let SpeedChangeArguments { files, fitted, .. } = arguments;
    let base = &fitted.base()?;
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
    let base = &fitted.base()?;
    let mappings = mappings(&arguments.map)?;
    let radius_range_m = arguments.radius_range.as_ref().map(|range| [range[0], range[1]]);
    let standard = RoadOptions::default();
    let options = RoadOptions {
        curves: CurveOptions { split_ratio: arguments.split, ..standard.curves },
        radius_range_m: radius_range_m.unwrap_or(standard.radius_range_m),
        altitude_average_m: arguments.altitude_average,
        mission_stop_s: arguments.mission_stop,
        road_type: arguments.road_type.clone(),
        ..standard
    };
    let steering = arguments.steering.steering()?;
    let roads: Vec<RoadSource> = sources(files).into_iter().map(RoadSource::Measured).collect();
    let roads = &roads[..];
    let request =
        OperatingCycleRequest { roads, mappings, base, options, radius_range_m, steering };
    let answer = ocmc_api::fit_operating_cycle(&request, &mut warn, &mut go_on)?;
    deliver(fitted, "operating-cycle", files, &answer)
}

fn fleet(arguments: &FleetArguments) -> Result<(), Failure> {
    let request = FleetRequest {
        records: Source::File(arguments.records.clone()),
        mappings: mappings(&arguments.map)?,
        column: arguments.column.clone(),
        weight: arguments.weight.clone(),
        options: FleetOptions {
            own_drivers: arguments.own_drivers,
            month: arguments.month,
            differ: arguments.differ,
            power: arguments.power,
            next_trips: arguments.next_trips,
            best: arguments.best,
            draws: arguments.draws,
            seed: arguments.seed,
            ..FleetOptions::default()
        },
    };
    arguments.answer.show(&ocmc_api::fit_fleet(&request)?)
}

fn traffic(arguments: &TrafficArguments) -> Result<(), Failure> {
    let TrafficArguments { file, options } = arguments;
    let base = &options.fitted.base()?;
    let (table, mappings) = (Source::File(file.clone()), mappings(&options.map)?);
    let request = TrafficRequest { table, mappings, base, place: options.place() };
    deliver(&options.fitted, "traffic", from_ref(file), &fit_traffic(&request)?)
}

fn weather(arguments: &WeatherArguments) -> Result<(), Failure> {
    let WeatherArguments { files, options } = arguments;
    let base = &options.fitted.base()?;
    let (tables, mappings) = (&sources(files)[..], mappings(&options.map)?);
    let request = WeatherRequest { tables, mappings, base, place: options.place() };
    deliver(&options.fitted, "weather", files, &fit_weather(&request)?)
}

impl HourlyFitOptions {
    /// The clock of the place.
    fn place(&self) -> Option<PlaceClock> {
        self.utc_offset.clone().or_else(|| self.zone.clone())
    }
}

/// Prints the answer of a fit, and writes the study with fitted values, where one was asked for.
fn deliver<Fit: Serialize>(
    arguments: &FittedArguments,
    command: &str,
    files: &[PathBuf],
    answer: &FitAnswer<Fit>,
) -> Result<(), Failure> {
    arguments.answer.show(answer)?;
    let Some(path) = &arguments.study_out else { return Ok(()) };
    let rows: u64 = answer.inputs.iter().map(|input| input.rows as u64).sum();
    let sources = match rows {
        0 => named(files),
        rows => format!("{} of {}", count_of(rows, "row"), named(files)),
    };
    let by = (&*format!("fit {command}"), &*sources);
    write_fitted(path, &arguments.base, "fitted", by, &answer.study, arguments.answer.quiet)
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

//! What the user typed about fits.

use super::log::SteeringArguments;
use super::value::utc_offset_h;
use clap::{Args, Subcommand, ValueEnum};
use ocmc_api::Coding;
use std::path::PathBuf;

/// What can be fitted.
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
}

/// Where fitted values go.
#[derive(Clone, Debug, Args)]
pub(crate) struct FittedArguments {
    /// The answer as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Study file to write: the base with the fitted values laid over it
    #[arg(long, value_name = "FILE")]
    pub(crate) study_out: Option<PathBuf>,
    /// Name of a built-in study, or a study file, that keeps what is not fitted
    #[arg(long, value_name = "NAME|FILE", default_value = "field-truck")]
    pub(crate) base: String,
}

/// Options of the fit of curve speeds.
#[derive(Clone, Debug, Args)]
pub(crate) struct CurveSpeedArguments {
    /// Table of curves: driver,radius_m,direction,speed_mps and, where known, route_m,limit_mps
    #[arg(value_name = "CURVES.csv")]
    pub(crate) file: PathBuf,
    /// Says which column is what, as in speed_mph=gps_speed or yaw_rate_degps=-gyro; may be
    /// repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    pub(crate) map: Vec<String>,
    /// Radius at which speeds are compared, in m
    #[arg(long, value_name = "M", default_value = "250", allow_negative_numbers = true)]
    pub(crate) reference_radius: f64,
    /// Smallest radius that takes part, in m
    #[arg(long, value_name = "M", default_value = "20", allow_negative_numbers = true)]
    pub(crate) minimum_radius: f64,
    /// Largest radius that takes part, in m
    #[arg(long, value_name = "M", default_value = "500", allow_negative_numbers = true)]
    pub(crate) maximum_radius: f64,
    /// Routes have to be longer than this, in m, where the table has route_m
    #[arg(long, value_name = "M", default_value = "5000", allow_negative_numbers = true)]
    pub(crate) minimum_route: f64,
    /// Exponent of the second model, and the one that is tested
    #[arg(long, value_name = "DELTA", default_value = "0.5", allow_negative_numbers = true)]
    pub(crate) fixed_exponent: f64,
    /// The direction stays in the model where its p is below this
    #[arg(long, value_name = "P", default_value = "0.05", allow_negative_numbers = true)]
    pub(crate) significance: f64,
    /// The population from the censored regression at the speed limits (needs limit_mps)
    #[arg(long)]
    pub(crate) tobit: bool,
    /// Share of the speed limit from which on a curve counts as driven at the limit
    #[arg(long, value_name = "SHARE", default_value = "0.9", allow_negative_numbers = true)]
    pub(crate) limit_share: f64,
    /// How the coefficients of drivers and directions are listed in the JSON
    #[arg(long, value_name = "CODING", default_value = "sum-to-zero")]
    pub(crate) coding: CodingName,
    #[command(flatten)]
    pub(crate) fitted: FittedArguments,
}

/// Options of the fit of speed changes.
#[derive(Clone, Debug, Args)]
pub(crate) struct SpeedChangeArguments {
    /// Tables of speed changes (acceleration_mps2 and, where known, category,driver), or logs
    /// (time, speed, limit)
    #[arg(required = true, value_name = "FILE.csv")]
    pub(crate) files: Vec<PathBuf>,
    /// Says which column is what, as in speed_mph=gps_speed or yaw_rate_degps=-gyro; may be
    /// repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    pub(crate) map: Vec<String>,
    /// Length of the window with the largest change of speed in a log, in s
    #[arg(long, value_name = "S", default_value = "3", allow_negative_numbers = true)]
    pub(crate) window: f64,
    /// Smallest acceleration that counts as a change, in m/s²
    #[arg(long, value_name = "MPS2", default_value = "0.2", allow_negative_numbers = true)]
    pub(crate) smallest_acceleration: f64,
    /// Smallest deceleration that counts as a change, in m/s²
    #[arg(long, value_name = "MPS2", default_value = "0.4", allow_negative_numbers = true)]
    pub(crate) smallest_deceleration: f64,
    /// The study from the laws with the thresholds in their likelihood
    #[arg(long)]
    pub(crate) untruncated: bool,
    #[command(flatten)]
    pub(crate) fitted: FittedArguments,
}

/// Options of the fit of operating cycles.
#[derive(Clone, Debug, Args)]
pub(crate) struct OperatingCycleArguments {
    /// Operating cycles with road types, as `ocmc cycle` writes them, or logs: CSV with time and
    /// speed
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Says which column is what, as in speed_mph=gps_speed or yaw_rate_degps=-gyro; may be
    /// repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    pub(crate) map: Vec<String>,
    /// Smallest and largest radius of the curves that are known, in m; the others are there and
    /// were not seen [default: 20 500 of logs, all of operating cycles]
    #[arg(long, value_names = ["LOWER", "UPPER"], num_args = 2, allow_negative_numbers = true)]
    pub(crate) radius_range: Option<Vec<f64>>,
    /// Road type of logs that have no column road_type [default: by the speed limit]
    #[arg(long, value_name = "NAME")]
    pub(crate) road_type: Option<String>,
    /// Length over which the altitudes of logs are averaged, in m
    #[arg(long, value_name = "M", default_value = "200", allow_negative_numbers = true)]
    pub(crate) altitude_average: f64,
    /// Standstills of logs from this time on are stops of the mission, in s
    #[arg(long, value_name = "S", default_value = "300", allow_negative_numbers = true)]
    pub(crate) mission_stop: f64,
    /// Cuts a curve of a log in two where its curvature steps by this factor or more
    #[arg(long, value_name = "RATIO")]
    pub(crate) split: Option<f64>,
    #[command(flatten)]
    pub(crate) steering: SteeringArguments,
    #[command(flatten)]
    pub(crate) fitted: FittedArguments,
}

/// Options of the fit of weather.
#[derive(Clone, Debug, Args)]
pub(crate) struct WeatherArguments {
    /// Table of hours: time or time_s and any of temperature_k|_c, pressure_pa|_hpa,
    /// relative_humidity|_percent, precipitation_mps|_mm_per_h, wind_speed_mps,
    /// wind_direction_rad|_deg
    #[arg(value_name = "HOURS.csv")]
    pub(crate) file: PathBuf,
    /// Says which column is what, as in speed_mph=gps_speed or yaw_rate_degps=-gyro; may be
    /// repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    pub(crate) map: Vec<String>,
    /// Hours by which the place's standard time is ahead of UTC, for times in UTC or with an
    /// offset, such as 2024-03-01T14:00Z
    #[arg(long, value_name = "H", allow_negative_numbers = true, value_parser = utc_offset_h)]
    pub(crate) utc_offset: Option<f64>,
    #[command(flatten)]
    pub(crate) fitted: FittedArguments,
}

/// Options of the fit of traffic.
#[derive(Clone, Debug, Args)]
pub(crate) struct TrafficArguments {
    /// Table of measurements: road_type, time or time_s, one of density_share, density_per_m,
    /// speed_ratio, and, where there are several of a type, site
    #[arg(value_name = "TRAFFIC.csv")]
    pub(crate) file: PathBuf,
    /// Says which column is what, as in speed_mph=gps_speed or yaw_rate_degps=-gyro; may be
    /// repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    pub(crate) map: Vec<String>,
    /// Hours by which the place's standard time is ahead of UTC, for times in UTC or with an
    /// offset, such as 2024-03-01T14:00Z
    #[arg(long, value_name = "H", allow_negative_numbers = true, value_parser = utc_offset_h)]
    pub(crate) utc_offset: Option<f64>,
    #[command(flatten)]
    pub(crate) fitted: FittedArguments,
}

/// Codings, as typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum CodingName {
    /// As deviations from their unweighted mean
    SumToZero,
    /// As differences to the first driver and to left curves
    Treatment,
}

impl From<CodingName> for Coding {
    fn from(name: CodingName) -> Self {
        match name {
            CodingName::SumToZero => Self::SumToZero,
            CodingName::Treatment => Self::Treatment,
        }
    }
}

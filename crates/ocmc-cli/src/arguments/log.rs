//! What the user typed about logs: plain data, without side effects.

use crate::failure::Failure;
use clap::{Args, ValueEnum};
use ocmc_api::{Error, RadiusDefinition, Steering, TripError};
use std::path::PathBuf;

/// Log files, and what their columns are.
#[derive(Clone, Debug, Args)]
pub(crate) struct LogFileArguments {
    /// Log files: CSV, plain or compressed with gzip, with a line of column names
    #[arg(required = true, value_name = "LOG.csv")]
    pub(crate) logs: Vec<PathBuf>,
    /// Says which column is what, as in speed_mph=gps_speed or yaw_rate_degps=-gyro; may be
    /// repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    pub(crate) map: Vec<String>,
}

/// What the steering wheel does, for logs that only have its angle.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct SteeringArguments {
    /// Ratio of the steering, for logs that only have the angle of the steering wheel
    #[arg(long, value_name = "RATIO", requires = "wheelbase_m")]
    pub(crate) steering_ratio: Option<f64>,
    /// Wheelbase, in m, for logs that only have the angle of the steering wheel
    #[arg(long, value_name = "M", requires = "steering_ratio")]
    pub(crate) wheelbase_m: Option<f64>,
}

impl SteeringArguments {
    /// From the steering wheel to the path; none where nothing was given.
    pub(crate) fn steering(self) -> Result<Option<Steering>, Failure> {
        let given = self.steering_ratio.zip(self.wheelbase_m);
        let steering = given.map(|(ratio, wheelbase_m)| Steering::new(ratio, wheelbase_m));
        steering.transpose().map_err(|fault| {
            let place = "--steering-ratio, --wheelbase-m".to_owned();
            Error::Drive { place, fault: TripError::Log(fault) }.into()
        })
    }
}

/// Options of `ocmc curves`.
#[derive(Clone, Debug, Args)]
pub(crate) struct CurvesArguments {
    #[command(flatten)]
    pub(crate) files: LogFileArguments,
    /// File to write, `.csv` or `.json`; an existing one is replaced [default: CSV to standard
    /// output]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// How curves are distinguished from straights
    #[arg(long, value_name = "NAME", default_value = "hidden-markov")]
    pub(crate) detector: DetectorName,
    /// What the radius of a curve is
    #[arg(long, value_name = "NAME", default_value = "turn")]
    pub(crate) radius: RadiusName,
    /// Share of a curve's length, in its middle, in which speed and radius are measured [default:
    /// 1/3]
    #[arg(long, value_name = "SHARE")]
    pub(crate) central_share: Option<f64>,
    /// Cuts a curve in two where its curvature steps by this factor or more
    #[arg(long, value_name = "RATIO")]
    pub(crate) split: Option<f64>,
    /// Bias of the yaw rate, in rad/s [default: its median at standstill]
    #[arg(long, value_name = "RADPS", allow_negative_numbers = true)]
    pub(crate) gyro_bias_radps: Option<f64>,
    /// Time by which the speed comes later than the yaw rate, in s [default: by correlation with
    /// the course]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) speed_lag_s: Option<f64>,
    #[command(flatten)]
    pub(crate) steering: SteeringArguments,
    /// No account of what was found and left out
    #[arg(long)]
    pub(crate) quiet: bool,
}

/// Detectors, as typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum DetectorName {
    /// Hidden Markov states
    HiddenMarkov,
    /// Hidden Markov states whose laws are fitted to each drive first
    Trained,
    /// Thresholds with hysteresis
    Threshold,
}

/// Definitions of the radius, as typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum RadiusName {
    /// Length over heading change: 1 / mean |curvature|
    Turn,
    /// Mean of 1 / |curvature|, as in the paper; noise biases it upwards
    Mean,
    /// Circle through the positions (latitude and longitude)
    Positions,
}

impl From<RadiusName> for RadiusDefinition {
    fn from(name: RadiusName) -> Self {
        match name {
            RadiusName::Turn => Self::InverseMeanCurvature,
            RadiusName::Mean => Self::MeanRadius,
            RadiusName::Positions => Self::Positions,
        }
    }
}

/// Options of `ocmc identify`.
#[derive(Clone, Debug, Args)]
pub(crate) struct IdentifyArguments {
    #[command(flatten)]
    pub(crate) files: LogFileArguments,
    /// Study with the truck that was driven: name of a built-in one, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "simulator-study")]
    pub(crate) study: String,
    /// Replaces one value of the study, as in mission.payload_kg=12000; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Controller that is fitted
    #[arg(long, value_name = "NAME", default_value = "pid")]
    pub(crate) controller: ControllerName,
    /// Speed that the objective compares with the set speed: none by default, for both readings of
    /// the paper bias the gains
    #[arg(long, value_name = "NAME", default_value = "none")]
    pub(crate) speed_term: SpeedTermName,
    /// Starts of the search for each event
    #[arg(long, value_name = "N", default_value = "8", value_parser = clap::value_parser!(u16).range(1..=4096))]
    pub(crate) starts: u16,
    /// Bounds of K_P, in s/m
    #[arg(long, value_names = ["LOWER", "UPPER"], num_args = 2)]
    pub(crate) kp: Option<Vec<f64>>,
    /// Bounds of K_I, in 1/m
    #[arg(long, value_names = ["LOWER", "UPPER"], num_args = 2)]
    pub(crate) ki: Option<Vec<f64>>,
    /// Bounds of K_D, in s²/m
    #[arg(long, value_names = ["LOWER", "UPPER"], num_args = 2)]
    pub(crate) kd: Option<Vec<f64>>,
    /// No intervals: several times as fast
    #[arg(long)]
    pub(crate) no_intervals: bool,
    /// No account of what was left out
    #[arg(long)]
    pub(crate) quiet: bool,
    /// The answer as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Controllers, as typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ControllerName {
    /// PID
    Pid,
    /// Switched proportional
    Switched,
}

/// Speed terms, as typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SpeedTermName {
    /// The measured speed, as the paper may mean; it biases the gains
    Measured,
    /// The simulated speed, as the paper may mean, too; it biases the gains as much
    Simulated,
    /// No speed term; unbiased
    None,
}

//! `ocmc curves`, `ocmc identify`: the curves that were driven, and the pedal gains of drivers,
//! from measured logs.

use crate::arguments::{AnswerOptions, FileOptions, TableOptions, WorkOptions, one_of, sources};
use crate::failure::Failure;
use crate::output::{self, warn};
use crate::progress::watched;
use clap::Args;
use ocmc_api::{
    Answer, CONTROLLERS, ControllerKind, Correction, CurveOptions, CurvesRequest, Detector, Error,
    IdentifyOptions, IdentifyRequest, RADII, RadiusDefinition, SPEED_TERMS, SpeedTerm, Steering,
    TripError, UNKNOWNS, Unknown, Unknowns, detectors, go_on, mappings,
};
use std::path::PathBuf;

/// Log files, and what their columns are.
#[derive(Clone, Debug, Args)]
struct LogFileArguments {
    /// Log files: CSV, plain or compressed with gzip, with a line of column names
    #[arg(required = true, value_name = "LOG.csv")]
    logs: Vec<PathBuf>,
    /// Says which column is what, as in speed_mph=gps_speed or yaw_rate_degps=-gyro; may be
    /// repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    map: Vec<String>,
}

/// Steering ratio and wheelbase, for logs that only have the steering wheel's angle.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct SteeringArguments {
    /// Ratio of the steering, for logs that only have the angle of the steering wheel
    #[arg(long, value_name = "RATIO", requires = "wheelbase_m")]
    steering_ratio: Option<f64>,
    /// Wheelbase, in m, for logs that only have the angle of the steering wheel
    #[arg(long, value_name = "M", requires = "steering_ratio")]
    wheelbase_m: Option<f64>,
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
    files: LogFileArguments,
    #[command(flatten)]
    table: TableOptions,
    /// How curves are distinguished from straights
    #[arg(
        long, value_name = "NAME", default_value = "hidden-markov",
        value_parser = one_of(detectors())
    )]
    detector: Detector,
    /// Definition of the radius of a curve
    #[arg(long, value_name = "NAME", default_value = "turn", value_parser = one_of(RADII))]
    radius: RadiusDefinition,
    /// Share of a curve's length, in its middle, in which speed and radius are measured [default:
    /// 1/3]
    #[arg(long, value_name = "SHARE")]
    central_share: Option<f64>,
    /// Cuts a curve in two where its curvature steps by this factor or more
    #[arg(long, value_name = "RATIO")]
    split: Option<f64>,
    /// Bias of the yaw rate, in rad/s [default: its median at standstill]
    #[arg(long, value_name = "RADPS", allow_negative_numbers = true)]
    gyro_bias_radps: Option<f64>,
    /// Time by which the speed comes later than the yaw rate, in s [default: by correlation with
    /// the course]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    speed_lag_s: Option<f64>,
    #[command(flatten)]
    steering: SteeringArguments,
    /// No account of what was found and left out
    #[arg(long)]
    quiet: bool,
}

/// Options of `ocmc identify`.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("quiet", |quiet| quiet.help("No progress and no account of what was left out")))]
pub(crate) struct IdentifyArguments {
    #[command(flatten)]
    files: LogFileArguments,
    /// Study with the truck that was driven: name of a built-in one, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "simulator-slopes")]
    study: PathBuf,
    /// Replaces one value of the study, as in mission.payload_kg=12000; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    study_files: FileOptions,
    /// Controller that is fitted
    #[arg(long, value_name = "NAME", default_value = "pid", value_parser = one_of(CONTROLLERS))]
    controller: ControllerKind,
    /// Speed that the objective compares with the set speed: none by default, for both readings of
    /// the paper bias the gains and have no intervals
    #[arg(long, value_name = "NAME", default_value = "none", value_parser = one_of(SPEED_TERMS))]
    speed_term: SpeedTerm,
    /// Further unknowns, estimated with the gains; may be joined by commas. Default: all of it with
    /// a PID and without a speed term, otherwise none
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = one_of(UNKNOWNS))]
    unknown: Option<Vec<Unknown>>,
    /// Starts of the search for each event
    #[arg(
        long, value_name = "N", default_value = "8",
        value_parser = clap::value_parser!(u16).range(1..=4096)
    )]
    starts: u16,
    /// Bounds of K_P, in s/m
    #[arg(
        long, value_names = ["LOWER", "UPPER"], num_args = 2,
        default_values_t = IdentifyOptions::default().proportional
    )]
    kp: Vec<f64>,
    /// Bounds of K_I, in 1/m
    #[arg(
        long, value_names = ["LOWER", "UPPER"], num_args = 2,
        default_values_t = IdentifyOptions::default().integral
    )]
    ki: Vec<f64>,
    /// Bounds of K_D, in s²/m; the lower one may be negative
    #[arg(
        long, value_names = ["LOWER", "UPPER"], num_args = 2,
        default_values_t = IdentifyOptions::default().derivative, allow_negative_numbers = true
    )]
    kd: Vec<f64>,
    /// No intervals: several times as fast
    #[arg(long)]
    no_intervals: bool,
    #[command(flatten)]
    work: WorkOptions,
}

/// Finds the curves of all drives of the logs and writes them down.
pub(crate) fn curves(arguments: &CurvesArguments) -> Result<(), Failure> {
    let target = arguments.table.target()?;
    let given = |value: Option<f64>| value.map_or(Correction::Estimated, Correction::Given);
    let standard = CurveOptions::default();
    let options = CurveOptions {
        detector: arguments.detector,
        radius: arguments.radius,
        central_share: arguments.central_share.unwrap_or(standard.central_share),
        split_ratio: arguments.split,
        gyro_bias_radps: given(arguments.gyro_bias_radps),
        speed_lag_s: given(arguments.speed_lag_s),
        ..standard
    };
    let (logs, mappings) = (&sources(&arguments.files.logs)[..], mappings(&arguments.files.map)?);
    let steering = arguments.steering.steering()?;
    let request = CurvesRequest { logs, mappings, options, steering };
    let answer = ocmc_api::curves(&request, &mut warn, &mut go_on)?;
    if !arguments.quiet {
        output::note(&answer.account());
    }
    target.write(&answer, |bytes| answer.write_csv(bytes))
}

/// Fits each event of each log, and the population behind them.
pub(crate) fn identify(arguments: &IdentifyArguments) -> Result<(), Failure> {
    let IdentifyArguments { kp, ki, kd, work, .. } = arguments;
    let AnswerOptions { quiet, json } = work.answer;
    let range = |ends: &[f64]| [ends[0], ends[1]];
    let options = IdentifyOptions {
        controller: arguments.controller,
        speed_term: arguments.speed_term,
        unknown: arguments.unknown.as_deref().map_or_else(
            || Unknowns::standard(arguments.controller, arguments.speed_term),
            Unknowns::of,
        ),
        starts: usize::from(arguments.starts),
        intervals: !arguments.no_intervals,
        proportional: range(kp),
        integral: range(ki),
        derivative: range(kd),
        threads: work.threads.unwrap_or(0),
        ..IdentifyOptions::default()
    };
    let request = IdentifyRequest {
        logs: &sources(&arguments.files.logs),
        study: &arguments.study_files.load(&arguments.study, &arguments.set)?,
        mappings: mappings(&arguments.files.map)?,
        options,
        warn_of_rows: !quiet,
    };
    let answer = watched(quiet, |watch| ocmc_api::identify(&request, &mut warn, watch))?;
    if !quiet {
        answer.notes().iter().for_each(|told| output::note(told));
        answer.warnings().iter().for_each(|warning| warn(warning));
    }
    output::answer(&if json { format!("{}\n", answer.to_json()) } else { answer.text() })
}

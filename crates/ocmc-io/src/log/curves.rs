//! From log files to the curves that were driven, and the table of them: a row a curve, as `ocmc
//! fit curve-speed` reads it.

use super::{LogFile, LoggedTrip, Need};
use crate::intake::FileAccount;
use crate::intake::table::{Quantity, spreadsheet};
use ocmc_core::operating_cycle::given::GivenCycleError;
use ocmc_estimation::log::TripLog;
use ocmc_estimation::log::curve::{
    Correction, CurveDetection, CurveOptions, DrivenCurve, RadiusDefinition, detect_curves,
};
use ocmc_estimation::log::sensor::{course_of_positions, yaw_rate_of_course};
use ocmc_estimation::log::signal::LogError;
use ocmc_estimation::option_check::OptionError;
use serde::Serialize;
use std::borrow::Cow;
use std::io;
use std::ops::ControlFlow;

/// Quantities that curve detection needs of a log for radii of this definition.
pub fn needs(radius: RadiusDefinition) -> Vec<Need> {
    let mut needs: Vec<Need> = vec![&[Quantity::Time], &[Quantity::Speed], &TURNING];
    if radius == RadiusDefinition::Positions {
        needs.push(&[Quantity::Latitude]);
        needs.push(&[Quantity::Longitude]);
    }
    needs
}

/// Quantities that tell how a vehicle turns, the best first.
const TURNING: [Quantity; 5] = [
    Quantity::YawRate,
    Quantity::Curvature,
    Quantity::LateralAcceleration,
    Quantity::SteeringWheelAngle,
    Quantity::Course,
];

/// Slower than this, in m/s, a lateral acceleration tells no yaw rate.
const SLOWEST_MPS: f64 = 1.0;

/// From the steering wheel to the path of the vehicle: κ = δ / (i l), without slip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Steering {
    /// Ratio i of the angles of steering wheel and front wheels.
    pub ratio: f64,
    /// Wheelbase l, in m.
    pub wheelbase_m: f64,
}

impl Steering {
    /// A ratio of 1 to 100 and a wheelbase of 0.5 to 20 m; errors: other ones, which no vehicle
    /// has.
    pub fn new(ratio: f64, wheelbase_m: f64) -> Result<Self, LogError> {
        for (option, value, range, allowed) in [
            ("the ratio of the steering", ratio, 1.0..=100.0, "1 to 100"),
            ("the wheelbase, in m,", wheelbase_m, 0.5..=20.0, "0.5 to 20"),
        ] {
            if !range.contains(&value) {
                return Err(LogError::Option(OptionError { option, value, allowed }));
            }
        }
        Ok(Self { ratio, wheelbase_m })
    }
}

/// The curves of one drive.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TripCurves {
    /// The driver, or the truck.
    pub driver: String,
    /// The drive.
    pub drive: String,
    /// Source of the yaw rate.
    pub turning: &'static str,
    /// Detected curves.
    #[serde(flatten)]
    pub detection: CurveDetection,
}

/// Why a drive gives no curves.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TripError {
    /// The log cannot be used.
    #[error(transparent)]
    Log(#[from] LogError),
    /// Only the steering wheel is known, and not what it does.
    #[error(
        "only the angle of the steering wheel tells how the vehicle turns: give --steering-ratio \
         and --wheelbase-m"
    )]
    Steering,
    /// No limit is known.
    #[error(
        "no speed limit is known: give a column, one limit for the whole log, or take what the \
         speed shows"
    )]
    NoLimit,
    /// Error of a drive that shows no road.
    #[error(transparent)]
    Road(#[from] GivenCycleError),
}

/// The curves of many drives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoundCurves {
    /// Drives that could be used.
    pub drives: Vec<TripCurves>,
    /// Where the others stand, and why they could not.
    pub left_out: Vec<(String, TripError)>,
    /// Files that were read.
    pub inputs: Vec<FileAccount>,
}

impl FoundCurves {
    /// Finds the curves of a log's drives. `look` is called before each of them, and may break off.
    pub fn add<B>(
        &mut self,
        file: &LogFile,
        options: &CurveOptions,
        steering: Option<Steering>,
        mut look: impl FnMut() -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        self.inputs.push(file.read.clone());
        for drive in &file.drives {
            look()?;
            match detect(drive, options, steering) {
                Ok(detected) => self.drives.push(detected),
                Err(fault) => self.left_out.push((file.place(drive), fault)),
            }
        }
        ControlFlow::Continue(())
    }

    /// The first drive that was left out, where all were.
    pub fn failed(&self) -> Option<&(String, TripError)> {
        self.left_out.first().filter(|_| self.drives.is_empty())
    }
}

/// Finds the curves of a drive.
///
/// # Errors
/// [`TripError`] where the log cannot be used, or only tells steering angles and `steering` is not
/// given.
fn detect(
    drive: &LoggedTrip,
    options: &CurveOptions,
    steering: Option<Steering>,
) -> Result<TripCurves, TripError> {
    let (log, options) = turning_log(drive, steering, options)?;
    Ok(TripCurves {
        driver: drive.driver.clone(),
        drive: drive.drive.clone(),
        turning: turning(drive).name(),
        detection: detect_curves(&log, &options)?,
    })
}

/// Whether a column of a drive tells how its vehicle turned, so that its positions need not.
pub(super) fn tells_turns(drive: &LoggedTrip) -> bool {
    known_turning(drive).is_some()
}

/// Whether nothing but the angle of the steering wheel tells it.
pub(super) fn tells_steering_only(drive: &LoggedTrip) -> bool {
    known_turning(drive) == Some(Quantity::SteeringWheelAngle)
}

fn known_turning(drive: &LoggedTrip) -> Option<Quantity> {
    let known = |quantity: &Quantity| {
        drive.column(*quantity).is_some_and(|values| values.iter().any(|value| !value.is_nan()))
    };
    TURNING.into_iter().find(known)
}

/// Quantity that tells how the vehicle of a drive turned.
fn turning(drive: &LoggedTrip) -> Quantity {
    known_turning(drive).unwrap_or(Quantity::YawRate)
}

/// A drive with its yaw rate, and the options that go with where that comes from.
///
/// # Errors
/// [`TripError::Steering`] where only the steering wheel tells it and `steering` is not given.
pub(super) fn turning_log<'a>(
    drive: &'a LoggedTrip,
    steering: Option<Steering>,
    options: &CurveOptions,
) -> Result<(TripLog<'a>, CurveOptions), TripError> {
    let lent = |quantity| drive.column(quantity).map(Cow::Borrowed);
    let mut turning = turning(drive);
    let speed_mps = lent(Quantity::Speed).unwrap_or_default();
    let mut signal = lent(turning).unwrap_or_default();
    if signal.iter().all(|value| value.is_nan())
        && let Some((latitude, longitude)) =
            drive.column(Quantity::Latitude).zip(drive.column(Quantity::Longitude))
    {
        // nothing else tells it, and the course follows from where the vehicle was
        turning = Quantity::Course;
        signal = course_of_positions(latitude, longitude).into();
    }
    let times_speed = |factor: f64| {
        signal.iter().zip(&*speed_mps).map(|(signal, speed)| signal * speed * factor).collect()
    };
    let yaw_rate_radps = match turning {
        Quantity::Curvature => times_speed(1.0),
        Quantity::SteeringWheelAngle => {
            let steering = steering.ok_or(TripError::Steering)?;
            times_speed(1.0 / (steering.ratio * steering.wheelbase_m))
        }
        Quantity::LateralAcceleration => {
            let slow = |speed: f64| speed < SLOWEST_MPS;
            let rates = signal.iter().zip(&*speed_mps);
            rates.map(|(a, v)| if slow(*v) { 0.0 } else { a / v }).collect()
        }
        Quantity::Course => {
            let time_s = drive.column(Quantity::Time).unwrap_or_default();
            yaw_rate_of_course(time_s, &speed_mps, &signal).into()
        }
        _ => signal,
    };
    let mut options = *options;
    if turning != Quantity::YawRate && options.gyro_bias_radps == Correction::Estimated {
        // no gyro, no bias of it
        options.gyro_bias_radps = Correction::Given(0.0);
    }
    let log = TripLog {
        time_s: lent(Quantity::Time).unwrap_or_default(),
        speed_mps,
        yaw_rate_radps,
        // a course that stands for the yaw rate tells no lag behind it
        course_rad: lent(Quantity::Course).filter(|_| turning != Quantity::Course),
        latitude_deg: lent(Quantity::Latitude),
        longitude_deg: lent(Quantity::Longitude),
        limit_mps: lent(Quantity::Limit),
    };
    Ok((log, options))
}

/// Value of a curve of a drive in a column.
#[derive(Clone, Copy, Debug)]
pub enum CurveCell {
    /// A word.
    Word(for<'a> fn(&'a TripCurves, &DrivenCurve) -> &'a str),
    /// A number, where it is known.
    Number(fn(&TripCurves, &DrivenCurve) -> Option<f64>),
}

/// The columns of the table of curves.
pub const COLUMNS: [(&str, CurveCell); 18] = [
    ("driver", CurveCell::Word(|drive, _| &drive.driver)),
    ("drive", CurveCell::Word(|drive, _| &drive.drive)),
    ("direction", CurveCell::Word(|_, curve| if curve.left { "left" } else { "right" })),
    ("radius_m", CurveCell::Number(|_, curve| Some(curve.radius_m))),
    ("speed_mps", CurveCell::Number(|_, curve| Some(curve.speed_mps))),
    ("limit_mps", CurveCell::Number(|_, curve| curve.limit_mps)),
    ("length_m", CurveCell::Number(|_, curve| Some(curve.length_m()))),
    ("turn_rad", CurveCell::Number(|_, curve| Some(curve.turn_rad))),
    ("start_m", CurveCell::Number(|_, curve| Some(curve.start_m))),
    ("end_m", CurveCell::Number(|_, curve| Some(curve.end_m))),
    ("start_s", CurveCell::Number(|_, curve| Some(curve.start_s))),
    ("end_s", CurveCell::Number(|_, curve| Some(curve.end_s))),
    ("acceleration_mps2", CurveCell::Number(|_, curve| Some(curve.acceleration_mps2))),
    ("gap_before_m", CurveCell::Number(|_, curve| Some(curve.around.gap_before_m))),
    ("gap_after_m", CurveCell::Number(|_, curve| Some(curve.around.gap_after_m))),
    ("slowest_near_mps", CurveCell::Number(|_, curve| Some(curve.around.slowest_near_mps))),
    ("stop_near_m", CurveCell::Number(|_, curve| curve.around.stop_near_m)),
    ("route_m", CurveCell::Number(|drive, _| Some(drive.detection.way_m))),
];

/// Writes the curves as comma-separated values.
///
/// # Errors
/// Those of writing.
pub fn write_csv(out: impl io::Write, drives: &[TripCurves]) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(out);
    writer.write_record(COLUMNS.map(|(name, _)| name))?;
    for drive in drives {
        for curve in &drive.detection.curves {
            writer.write_record(COLUMNS.map(|(_, cell)| match cell {
                CurveCell::Word(word) => spreadsheet::written(word(drive, curve)).into_owned(),
                CurveCell::Number(number) => {
                    number(drive, curve).map_or_else(String::new, |number| format!("{number:?}"))
                }
            }))?;
        }
    }
    writer.flush()
}

//! Measured logs: the curves that were driven.

use crate::answer::warned;
use crate::error::exception;
use crate::input::input;
use crate::progress::watched;
use crate::table::Table;
use crate::value::one_of;
use arrow_array::{ArrayRef, Float64Array, StringArray};
use ocmc_api::{
    Correction, CurveOptions, CurvesRequest, Detector, DrivenCurve, HiddenMarkov, Mapping,
    RadiusDefinition, Steering, Threshold, TripCurves,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Find the curves that were driven, from speed and yaw rate.
///
/// Parameters
/// ----------
/// log : table, str or os.PathLike
///     One row a sample, columns by quantity and unit: ``time_s``, ``speed_mps`` or ``speed_kmh``, ``yaw_rate_radps`` or
///     ``yaw_rate_degps`` (positive to the left), and labels ``driver``, ``drive``. Any table that speaks Arrow, a
///     dictionary of columns, or a CSV file, plain or compressed by gzip.
/// columns : dict of str to str, optional
///     Which column is what, such as ``{"speed_mph": "gps_speed", "yaw_rate_degps": "-gyro"}``.
/// detector : {"hidden_markov", "trained", "threshold"}
///     How curves are distinguished from straights: hidden Markov states, the same fitted to each drive first, or thresholds.
/// radius : {"turn", "mean", "positions"}
///     What the radius of a curve is: length over heading change, the mean of 1 / curvature, or the circle through the
///     positions.
/// central_share : float, optional
///     Share of a curve's length, in its middle, in which speed and radius are measured; a third by default.
/// split_ratio : float, optional
///     Cut a curve in two where its curvature steps by this factor or more.
/// gyro_bias_radps : float, optional
///     Bias of the yaw rate, in rad/s; by default its median at standstill.
/// speed_lag_s : float, optional
///     Time by which the speed comes later than the yaw rate, in s; by default estimated from the course.
/// steering_ratio : float, optional
///     Ratio of the steering, 1 to 100, for logs that only have the angle of the steering wheel.
/// wheelbase_m : float, optional
///     Wheelbase, 0.5 to 20 m, for such logs.
///
/// Returns
/// -------
/// Table
///     One row a curve: ``driver``, ``drive``, ``direction``, ``radius_m``, ``speed_mps``, ``start_m`` and others, as
///     ``ocmc curves`` writes them.
///
/// Raises
/// ------
/// ValueError
///     Where a column is missing or unclear, where no drive can be used, or where an option is out of its range.
/// OSError
///     Where the file cannot be read.
///
/// Warns
/// -----
/// UserWarning
///     Where a drive is left out, and where cells are no numbers.
///
/// Notes
/// -----
/// A table of one drive that speaks Arrow is not copied where its columns are 64-bit floats in SI units, in one piece and
/// without nulls; other columns are copied once.
///
/// Examples
/// --------
/// >>> import numpy as np, ocmc
/// >>> time = np.arange(0.0, 60.0, 0.1)
/// >>> yaw_rate = np.where((time > 20) & (time < 30), 10.0 / 100.0, 0.0)  # 10 m/s, a radius of 100 m
/// >>> log = {"time_s": time, "speed_mps": np.full(time.size, 10.0), "yaw_rate_radps": yaw_rate}
/// >>> curves = ocmc.detect_curves(log, gyro_bias_radps=0.0)
/// >>> curves["direction"].tolist(), curves["radius_m"].round().tolist()
/// (['left'], [100.0])
#[pyfunction]
#[pyo3(signature = (
    log, *, columns=None, detector="hidden_markov", radius="turn", central_share=None, split_ratio=None,
    gyro_bias_radps=None, speed_lag_s=None, steering_ratio=None, wheelbase_m=None
))]
pub(crate) fn detect_curves(
    py: Python,
    log: &Bound<PyAny>,
    columns: Option<BTreeMap<String, String>>,
    detector: &str,
    radius: &str,
    central_share: Option<f64>,
    split_ratio: Option<f64>,
    gyro_bias_radps: Option<f64>,
    speed_lag_s: Option<f64>,
    steering_ratio: Option<f64>,
    wheelbase_m: Option<f64>,
) -> PyResult<Table> {
    let steering = steering(steering_ratio, wheelbase_m)?;
    let given = |value: Option<f64>| value.map_or(Correction::Estimated, Correction::Given);
    let standard = CurveOptions::default();
    let options = CurveOptions {
        detector: one_of("detector", detector, &detectors())?,
        radius: one_of("radius", radius, &RADII)?,
        central_share: central_share.unwrap_or(standard.central_share),
        split_ratio,
        gyro_bias_radps: given(gyro_bias_radps),
        speed_lag_s: given(speed_lag_s),
        ..standard
    };
    let (mappings, logs) = (mappings(columns)?, &[input(log, "log")?]);
    let request = CurvesRequest { logs, mappings, options, steering };
    let found =
        warned(py, |warn| watched(py, None, |watch| ocmc_api::curves(&request, warn, watch)))?;
    Ok(curve_table(&found.drives))
}

/// The steering of a vehicle whose logs only have the angle of the steering wheel.
pub(crate) fn steering(ratio: Option<f64>, wheelbase_m: Option<f64>) -> PyResult<Option<Steering>> {
    match (ratio, wheelbase_m) {
        (Some(ratio), Some(wheelbase_m)) => {
            let steering = Steering::new(ratio, wheelbase_m);
            Ok(Some(steering.map_err(|fault| PyValueError::new_err(fault.to_string()))?))
        }
        (None, None) => Ok(None),
        _ => {
            let text = "`steering_ratio` and `wheelbase_m` belong together: give both or neither";
            Err(PyValueError::new_err(text))
        }
    }
}

/// What a user says that columns are.
pub(crate) fn mappings(columns: Option<BTreeMap<String, String>>) -> PyResult<Vec<Mapping>> {
    let mappings = Mapping::of_columns(&columns.unwrap_or_default());
    mappings.map_err(|error| exception(&error.into()))
}

const RADII: [(&str, RadiusDefinition); 3] = [
    ("turn", RadiusDefinition::InverseMeanCurvature),
    ("mean", RadiusDefinition::MeanRadius),
    ("positions", RadiusDefinition::Positions),
];

fn detectors() -> [(&'static str, Detector); 3] {
    [
        ("hidden_markov", Detector::HiddenMarkov(HiddenMarkov::default())),
        ("trained", Detector::TrainedHiddenMarkov(HiddenMarkov::default())),
        ("threshold", Detector::Threshold(Threshold::default())),
    ]
}

/// The curves of all drives, one row a curve: the columns of the command's file.
fn curve_table(drives: &[TripCurves]) -> Table {
    let rows: Vec<(&TripCurves, &DrivenCurve)> = drives
        .iter()
        .flat_map(|drive| drive.detection.curves.iter().map(move |curve| (drive, curve)))
        .collect();
    let words = |word: fn(&TripCurves, &DrivenCurve) -> String| {
        Arc::new(StringArray::from_iter_values(rows.iter().map(|(d, c)| word(d, c)))) as ArrayRef
    };
    let numbers = |number: fn(&TripCurves, &DrivenCurve) -> Option<f64>| {
        let numbers: Float64Array = rows.iter().map(|(d, c)| number(d, c)).collect();
        Arc::new(numbers) as ArrayRef
    };
    Table::of_columns(vec![
        ("driver", words(|drive, _| drive.driver.clone())),
        ("drive", words(|drive, _| drive.drive.clone())),
        ("direction", words(|_, curve| if curve.left { "left" } else { "right" }.to_owned())),
        ("radius_m", numbers(|_, curve| Some(curve.radius_m))),
        ("speed_mps", numbers(|_, curve| Some(curve.speed_mps))),
        ("limit_mps", numbers(|_, curve| curve.limit_mps)),
        ("length_m", numbers(|_, curve| Some(curve.length_m()))),
        ("turn_rad", numbers(|_, curve| Some(curve.turn_rad))),
        ("start_m", numbers(|_, curve| Some(curve.start_m))),
        ("end_m", numbers(|_, curve| Some(curve.end_m))),
        ("start_s", numbers(|_, curve| Some(curve.start_s))),
        ("end_s", numbers(|_, curve| Some(curve.end_s))),
        ("route_m", numbers(|drive, _| Some(drive.detection.way_m))),
    ])
}

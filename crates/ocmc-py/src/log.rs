//! Measured logs: the curves that were driven, and the pedal gains of drivers.

use crate::answer::answer;
use crate::input::{input, inputs, mappings};
use crate::progress::warned;
use crate::study::PyStudy;
use crate::table::{Table, numbers, words};
use crate::value::{one_of, whole_number};
use ocmc_api::{
    CONTROLLERS, CURVE_COLUMNS, Correction, CurveCell, CurveOptions, CurvesRequest, DrivenCurve,
    IdentifyOptions, IdentifyRequest, RADII, SPEED_TERMS, Steering, TripCurves, UNKNOWNS, Unknowns,
    detectors,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// Most starts of a search, as on the command line.
const MOST_STARTS: u64 = 4096;

/// Find the curves that were driven, from speed and yaw rate.
///
/// Parameters
/// ----------
/// log : table, str or os.PathLike
///     One row a sample, columns by quantity and unit: ``time_s``, ``speed_mps`` or ``speed_kmh``,
///     ``yaw_rate_radps`` or
///     ``yaw_rate_degps`` (positive to the left), and labels ``driver``, ``drive``. Any table that
///     exports Arrow, a dictionary of columns, or a CSV file, plain or compressed by gzip.
/// columns : dict of str to str, optional
///     Which column is what, such as ``{"speed_mph": "gps_speed", "yaw_rate_degps": "-gyro"}``.
/// detector : {"hidden_markov", "trained", "threshold"}
///     How curves are distinguished from straights: hidden Markov states, the same fitted to each
///     drive first, or thresholds.
/// radius : {"turn", "mean", "positions"}
///     How the radius of a curve is found: length over heading change, the mean of 1 / curvature,
///     or the circle through the positions.
/// central_share : float, optional
///     Share of a curve's length, in its middle, in which speed and radius are measured; a third by
///     default.
/// split_ratio : float, optional
///     Cut a curve in two where its curvature steps by this factor or more.
/// gyro_bias_radps : float, optional
///     Bias of the yaw rate, in rad/s; by default its median at standstill.
/// speed_lag_s : float, optional
///     Time by which the speed comes later than the yaw rate, in s; by default estimated from the
///     course.
/// steering_ratio : float, optional
///     Ratio of the steering, 1 to 100, for logs that only have the angle of the steering wheel.
/// wheelbase_m : float, optional
///     Wheelbase, 0.5 to 20 m, for such logs.
///
/// Returns
/// -------
/// Table
///     One row a curve: ``driver``, ``drive``, ``direction``, ``radius_m``, ``speed_mps``,
///     ``start_m`` and others, as ``ocmc curves`` writes them. Among them are ``gap_before_m``,
///     ``gap_after_m``, ``slowest_near_mps`` and ``stop_near_m``, by which `fit_curve_speed` with
///     ``isolated_m`` finds the curves that were driven freely.
///
/// Raises
/// ------
/// ValueError
///     Where a column is missing or unclear, where no drive can be used, or where an option is out
///     of its range.
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
/// A table of one drive that exports Arrow is not copied where its columns are 64-bit floats in SI
/// units, in one piece and without nulls. Other columns are copied once.
///
/// Examples
/// --------
/// >>> import numpy as np, ocmc
/// >>> time = np.arange(0.0, 60.0, 0.1)
/// >>> turns = (time > 20) & (time < 30)  # at 10 m/s, with a radius of 100 m
/// >>> yaw_rate = np.where(turns, 10.0 / 100.0, 0.0)
/// >>> log = {"time_s": time, "speed_mps": np.full(time.size, 10.0), "yaw_rate_radps": yaw_rate}
/// >>> curves = ocmc.detect_curves(log, gyro_bias_radps=0.0)
/// >>> curves["direction"].tolist(), curves["radius_m"].round().tolist()
/// (['left'], [100.0])
#[pyfunction]
#[pyo3(signature = (
    log, *, columns=None, detector="hidden_markov", radius="turn", central_share=None,
    split_ratio=None, gyro_bias_radps=None, speed_lag_s=None, steering_ratio=None, wheelbase_m=None
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
    let drives = &warned(py, None, |warn, watch| ocmc_api::curves(&request, warn, watch))?.drives;
    let rows = || drives.iter().flat_map(curves_of);
    let columns = CURVE_COLUMNS.map(|(name, cell)| match cell {
        CurveCell::Word(word) => (name, words(rows().map(|(d, curve)| Some(word(d, curve))))),
        CurveCell::Number(number) => (name, numbers(rows().map(|(d, curve)| number(d, curve)))),
    });
    Ok(Table::of_columns(columns.to_vec()))
}

/// The curves of a drive, with the drive.
fn curves_of(drive: &TripCurves) -> impl Iterator<Item = (&TripCurves, &DrivenCurve)> {
    drive.detection.curves.iter().map(move |curve| (drive, curve))
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

/// Identify the pedal gains of drivers, one fit for each driver and event.
///
/// Parameters
/// ----------
/// logs : table, str or os.PathLike, or a list of these
///     One row a sample, at least one a second, columns by quantity and unit: ``time_s``,
///     ``speed_mps`` or ``speed_kmh``,
///     ``accelerator`` and ``brake`` (0 to 1) or ``accelerator_percent`` and ``brake_percent``,
///     ``grade`` or
///     ``grade_percent``; where known ``position_m`` and ``gear``, and labels ``driver``,
///     ``drive``, ``event``. Any table that exports Arrow, a dictionary of columns, or a CSV file,
///     plain or compressed by gzip.
/// study : Study
///     The study with the truck that was driven, such as ``Study("simulator-slopes")``.
/// columns : dict of str to str, optional
///     Which column is what, such as ``{"grade_percent": "slope"}``.
/// controller : {"pid", "switched"}
///     Controller that is fitted.
/// speed_term : {"none", "measured", "simulated"}
///     Speed that the objective compares with the set speed. The paper may mean the measured or the
///     simulated one: both bias the gains, and there are no intervals with them. Without this term
///     they are unbiased.
/// unknown : sequence of {"delay", "mass", "resistance", "none"}, optional
///     What else is estimated. ``delay`` is how late the driver sees the speed, ``mass`` that of
///     the truck, ``resistance`` that in rolling and in air. All of them with a PID and without a
///     speed term, otherwise none.
/// starts : int
///     Starts of the search for each event, at least 1.
/// kp : tuple of float
///     Bounds of K_P, in s/m.
/// ki : tuple of float
///     Bounds of K_I, in 1/m.
/// kd : tuple of float
///     Bounds of K_D, in s²/m.
/// intervals : bool
///     Work out intervals; without them it is several times as fast.
/// progress : bool or callable, optional
///     As for `Study.run`, in events.
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc identify --json``: ``fits`` with ``driver``, ``event``, ``kp`` (s/m),
///     ``ki`` (1/m), ``kd`` (s²/m), ``set_speed_mps``, ``at_bound``, ``not_identifiable``,
///     ``no_intervals``, ``warnings`` and others. ``no_intervals`` says why there are none:
///     residuals that are not the noise of sensors. Beside ``fits`` there are ``trucks`` (the mass
///     by all events of a log) and ``population`` (of three drivers or more). ``left_out`` and
///     ``notes`` are on rows that are not used.
///
/// Raises
/// ------
/// ValueError
///     Where a column is missing or unclear, where no event can be identified, or where an option
///     is out of its range.
/// OSError
///     Where a file cannot be read.
///
/// Warns
/// -----
/// UserWarning
///     Where an event or a drive is left out, where a fit does not explain its pedals or has
///     warnings, and where cells are no numbers.
///
/// See Also
/// --------
/// ocmc.plot.identified : Draws the gains.
///
/// Notes
/// -----
/// min ∫ (a − â)² + (b − b̂)² + ((v_d − v) / 20 m/s)² dt in closed loop: Romano, Godio, Bruzelius,
/// Johannesson; by default without the last term, and with pedals in units of their noise.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> study = ocmc.Study("simulator-slopes")
/// >>> trace = study.trace(0)
/// >>> names = ["time_s", "speed_mps", "accelerator", "brake", "grade", "gear"]
/// >>> log = {name: trace[name][2400:3200] for name in names}
/// >>> log |= {"driver": ["a"] * 800, "event": ["up"] * 800}
/// >>> import warnings
/// >>> with warnings.catch_warnings():
/// ...     warnings.simplefilter("ignore")  # a short piece of a trace leaves much open
/// ...     answer = ocmc.identify(log, study, starts=1, intervals=False)
/// >>> [(fit["driver"], fit["event"]) for fit in answer["fits"]]
/// [('a', 'up')]
#[pyfunction]
#[pyo3(
    signature = (
        logs, study, *, columns=None, controller="pid", speed_term="none", unknown=None,
        starts=None, kp=None, ki=None, kd=None, intervals=true, progress=None
    ),
    text_signature = "(logs, study, *, columns=None, controller='pid', speed_term='none', \
                      unknown=None, starts=8, kp=(0.01, 2.0), ki=(0.0001, 0.2), kd=(0.0, 2.0), \
                      intervals=True, progress=None)"
)]
pub(crate) fn identify<'py>(
    py: Python<'py>,
    logs: &Bound<'py, PyAny>,
    study: &Bound<'py, PyStudy>,
    columns: Option<BTreeMap<String, String>>,
    controller: &str,
    speed_term: &str,
    unknown: Option<Vec<String>>,
    starts: Option<&Bound<'py, PyAny>>,
    kp: Option<(f64, f64)>,
    ki: Option<(f64, f64)>,
    kd: Option<(f64, f64)>,
    intervals: bool,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let standard = IdentifyOptions::default();
    let starts = starts.map(|starts| whole_number(starts, "starts", 1, MOST_STARTS)).transpose()?;
    let [measured, simulated, none] = SPEED_TERMS;
    let controller = one_of("controller", controller, &CONTROLLERS)?;
    let speed_term = one_of("speed_term", speed_term, &[none, measured, simulated])?;
    let word = |name: &String| one_of("unknown", name, &UNKNOWNS);
    let unknown = match unknown {
        Some(names) => Unknowns::of(&names.iter().map(word).collect::<PyResult<Vec<_>>>()?),
        None => Unknowns::standard(controller, speed_term),
    };
    let options = IdentifyOptions {
        unknown,
        controller,
        speed_term,
        starts: starts.map_or(standard.starts, |starts| starts as usize),
        intervals,
        proportional: kp.map_or(standard.proportional, Into::into),
        integral: ki.map_or(standard.integral, Into::into),
        derivative: kd.map_or(standard.derivative, Into::into),
        ..standard
    };
    let request = IdentifyRequest {
        logs: &inputs(logs, "logs")?,
        study: &study.get().loaded,
        mappings: mappings(columns)?,
        options,
        warn_of_rows: false,
    };
    answer(py, &warned(py, progress, |warn, watch| ocmc_api::identify(&request, warn, watch))?)
}

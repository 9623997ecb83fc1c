//! The road of a drive as an operating cycle, and measured drives over simulated ones.

use crate::answer::answer;
use crate::error::exception;
use crate::input::{inputs, mappings};
use crate::log::steering;
use crate::plan::{seed_of, threads_of};
use crate::progress::warned;
use crate::study::PyStudy;
use crate::value::{one_of, whole_number};
use ocmc_api::{
    CurveOptions, FEWEST_TRIPS, KEEPS, Keep, MOST_TRIPS, MissingLimits, RUN_IN_M, RoadOptions,
    RoadRequest, RunPlan, ValidateRequest, check_empty,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// How roads are found in logs.
fn options(limit_mps: Option<f64>, road_type: Option<String>, split: Option<f64>) -> RoadOptions {
    let standard = RoadOptions::default();
    RoadOptions {
        curves: CurveOptions { split_ratio: split, ..standard.curves },
        road_type,
        missing_limits: limit_mps.map_or(MissingLimits::OfSpeed, MissingLimits::Everywhere),
        ..standard
    }
}

/// The trips that are simulated.
fn trips_of(
    trips: Option<&Bound<PyAny>>,
    seed: Option<&Bound<PyAny>>,
    threads: Option<&Bound<PyAny>>,
) -> PyResult<RunPlan> {
    let trips = trips.map_or(Ok(FEWEST_TRIPS), |n| whole_number(n, "trips", 2, MOST_TRIPS))?;
    let threads = threads_of(threads)?;
    Ok(RunPlan::new(seed_of(seed)?, 0, trips, threads, None))
}

/// Make an operating cycle of the road that a log was driven on.
///
/// Parameters
/// ----------
/// logs : table, str or os.PathLike, or a list of these
///     One row a sample: ``time_s``, ``speed_mps`` or ``speed_kmh``, and where known
///     ``yaw_rate_radps`` (or ``latitude_deg`` and ``longitude_deg``), ``limit_mps``, ``grade`` or
///     ``altitude_m``, ``road_type``, ``map_object``, ``position_m`` and others. Any table that
///     exports Arrow, a dictionary of columns, a CSV file, or VECTO's time series (``.vmod``).
/// columns : dict of str to str, optional
///     Which column is what, such as ``{"speed_mph": "gps_speed"}``.
/// limit_mps : float, optional
///     Speed limit of logs that have no column of limits, in m/s; by default found from their
///     speed.
/// road_type : str, optional
///     Road type of logs without a column ``road_type``; by default it follows from the limit.
/// stops : bool
///     Whether standstills are stops of the road; objects of the map and stops of the mission are
///     in any case.
/// split_ratio : float, optional
///     Cut a curve in two where its curvature steps by this factor or more.
/// steering_ratio : float, optional
///     Ratio of the steering, 1 to 100, for logs that only have the angle of the steering wheel.
/// wheelbase_m : float, optional
///     Wheelbase, 0.5 to 20 m, for such logs.
///
/// Returns
/// -------
/// Answer
///     ``roads``, one for each piece of a drive, with ``name``, ``length_m``, ``curves``,
///     ``stops``, ``climb_m``, ``limit_source`` and ``tracks``: written as JSON, each of them is a
///     file that `Study.drive` takes. ``left_out`` counts drives that gave none.
///
/// Raises
/// ------
/// ValueError
///     Where a column is missing or unclear, where no drive gives a road, or where an option is out
///     of its range.
/// OSError
///     Where a file cannot be read.
///
/// Warns
/// -----
/// UserWarning
///     Where limits follow from the speed, and where a part of a log is not used.
///
/// See Also
/// --------
/// ocmc.validate : Lays drives over simulated ones on such a road.
///
/// Examples
/// --------
/// >>> import numpy as np, ocmc
/// >>> time = np.arange(0.0, 100.0, 0.1)
/// >>> log = {"time_s": time, "position_m": 10.0 * time, "speed_mps": np.full(time.size, 10.0)}
/// >>> log |= {"limit_mps": np.full(time.size, 13.9), "road_type": ["urban"] * time.size}
/// >>> [road] = ocmc.road(log)["roads"]
/// >>> round(road["length_m"]), road["limit_source"]
/// (999, 'column')
#[pyfunction]
#[pyo3(signature = (
    logs, *, columns=None, limit_mps=None, road_type=None, stops=true, split_ratio=None,
    steering_ratio=None, wheelbase_m=None
))]
pub(crate) fn road<'py>(
    py: Python<'py>,
    logs: &Bound<'py, PyAny>,
    columns: Option<BTreeMap<String, String>>,
    limit_mps: Option<f64>,
    road_type: Option<String>,
    stops: bool,
    split_ratio: Option<f64>,
    steering_ratio: Option<f64>,
    wheelbase_m: Option<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let request = RoadRequest {
        logs: &inputs(logs, "logs")?,
        mappings: mappings(columns)?,
        options: options(limit_mps, road_type, split_ratio),
        steering: steering(steering_ratio, wheelbase_m)?,
        stops,
    };
    answer(py, &warned(py, None, |warn, watch| ocmc_api::road(&request, warn, watch))?)
}

/// Lay measured drives over simulated ones on the same road.
///
/// Parameters
/// ----------
/// logs : table, str or os.PathLike, or a list of these
///     As for `road`; ``fuel_kgps`` or ``battery_power_w`` where energy is to be compared.
/// study : Study
///     The study with drivers and trucks.
/// road : str or os.PathLike, optional
///     Road that all of the logs were driven on: a file as `Study.drive` takes it. By default each
///     drive on the road that its own log shows, of which limits and stops are then no validation.
/// trips : int
///     Independent trips that are simulated on each road, 2 to 20000; bands want 2000.
/// seed : int
///     Master seed of the trips.
/// columns : dict of str to str, optional
///     Which column is what, such as ``{"speed_mph": "gps_speed"}``.
/// keep : list of {"weather", "traffic", "mission"}, optional
///     Parts that are taken from the road instead of being drawn from the study.
/// limit_mps : float, optional
///     As for `road`.
/// road_type : str, optional
///     As for `road`.
/// stops : bool
///     As for `road`.
/// split_ratio : float, optional
///     As for `road`.
/// steering_ratio : float, optional
///     As for `road`.
/// wheelbase_m : float, optional
///     As for `road`.
/// run_in_m : float
///     Way behind a moving start and before a moving end that is not scored, in m: simulated trips
///     begin and end at rest.
/// out : str or os.PathLike, optional
///     Empty directory for tables, pictures and a page.
/// threads : int, optional
///     Threads to use, one for each CPU by default.
/// progress : bool or callable, optional
///     As for `Study.run`, in trips.
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc validate --json``: ``pooled`` and ``drives`` with their scores,
///     ``roads`` with bands over the way, ``circular``, the parts of the road that come from the
///     validated logs themselves.
///
/// Raises
/// ------
/// ValueError
///     Where a log or the road cannot be used, or an option is out of its range.
/// OSError
///     Where a file cannot be read or written.
///
/// Warns
/// -----
/// UserWarning
///     Where the road comes from the validated log, where there are few trips, and where a drive is
///     left out.
///
/// See Also
/// --------
/// ocmc.plot.validation : Draws the bands and the drives.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> study = ocmc.Study("passenger-car").set("mission.length_m", 3000.0)
/// >>> study = study.set("simulation.step_s", 0.5)
/// >>> trace = study.trace(3, seed=7)
/// >>> names = ["time_s", "speed_mps", "position_m", "yaw_rate_radps", "limit_mps", "grade"]
/// >>> log = {name: trace[name] for name in names}
/// >>> import warnings
/// >>> with warnings.catch_warnings(action="ignore"):
/// ...     answer = ocmc.validate(log, study, trips=20)
/// >>> answer["pooled"][0]["quantity"], len(answer["roads"])
/// ('speed', 1)
#[pyfunction]
#[pyo3(
    signature = (
        logs, study, *, road=None, trips=None, seed=None, columns=None, keep=None, limit_mps=None,
        road_type=None, stops=true, split_ratio=None, steering_ratio=None, wheelbase_m=None,
        run_in_m=None, out=None, threads=None, progress=None
    ),
    text_signature = "(logs, study, *, road=None, trips=2000, seed=1, columns=None, keep=None, \
                      limit_mps=None, road_type=None, stops=True, split_ratio=None, \
                      steering_ratio=None, wheelbase_m=None, run_in_m=500.0, out=None, \
                      threads=None, progress=None)"
)]
pub(crate) fn validate<'py>(
    py: Python<'py>,
    logs: &Bound<'py, PyAny>,
    study: &Bound<'py, PyStudy>,
    road: Option<PathBuf>,
    trips: Option<&Bound<'py, PyAny>>,
    seed: Option<&Bound<'py, PyAny>>,
    columns: Option<BTreeMap<String, String>>,
    keep: Option<Vec<String>>,
    limit_mps: Option<f64>,
    road_type: Option<String>,
    stops: bool,
    split_ratio: Option<f64>,
    steering_ratio: Option<f64>,
    wheelbase_m: Option<f64>,
    run_in_m: Option<f64>,
    out: Option<PathBuf>,
    threads: Option<&Bound<'py, PyAny>>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let keep = keep.unwrap_or_default();
    let keep: Vec<Keep> =
        keep.iter().map(|word| one_of("keep", word, &KEEPS)).collect::<PyResult<_>>()?;
    let run_in_m = run_in_m.unwrap_or(RUN_IN_M);
    if !(run_in_m >= 0.0 && run_in_m.is_finite()) {
        let text = format!("`run_in_m` is {run_in_m}, allowed is a number from 0 on");
        return Err(PyValueError::new_err(text));
    }
    out.as_deref().map_or(Ok(()), check_empty).map_err(exception)?;
    let request = ValidateRequest {
        logs: &inputs(logs, "logs")?,
        mappings: mappings(columns)?,
        study: &study.get().loaded,
        road: road.as_deref(),
        options: options(limit_mps, road_type, split_ratio),
        steering: steering(steering_ratio, wheelbase_m)?,
        stops,
        keep,
        plan: trips_of(trips, seed, threads)?,
        run_in_m,
    };
    let validation = warned(py, progress, |warn, watch| ocmc_api::validate(&request, warn, watch))?;
    out.map_or(Ok(()), |out| validation.save(&out)).map_err(exception)?;
    answer(py, &validation)
}

//! Fits of roads: from operating cycles or logs to the numbers of a study.

use crate::answer::{answer, warned};
use crate::fit::base_model;
use crate::input::{input, is_path, is_table, sequence};
use crate::log::{mappings, steering};
use crate::operating_cycle::PyOperatingCycle;
use crate::progress::watched;
use crate::study::PyStudy;
use crate::value::shown;
use ocmc_api::{CurveOptions, OperatingCycleRequest, RoadOptions, RoadSource};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// Fit the road model of given operating cycles or logs, and look at them from above.
///
/// Parameters
/// ----------
/// cycles : OperatingCycle, str, os.PathLike or table, or a list of these
///     Operating cycles with the track ``road_type``: from `Study.operating_cycle`, or files as ``ocmc cycle`` writes them. Or logs:
///     ``time_s``, ``speed_mps`` or ``speed_kmh``, and where known ``yaw_rate_radps``, ``limit_mps``, ``grade`` or ``altitude_m``,
///     ``road_type``, ``map_object``, ``position_m``, ``payload_kg`` and others; any table that speaks Arrow, a dictionary of
///     columns, or a CSV file.
/// columns : dict of str to str, optional
///     Which column of a log is what, such as ``{"speed_mph": "gps_speed"}``; then all files are logs.
/// base : Study, optional
///     The study with these road types that keeps what roads do not tell; ``field-truck`` by default.
/// radius_range_m : tuple of float, optional
///     Smallest and largest radius of the curves that are known, in m; the others are there and were not seen. 20 to 500 m for
///     logs, all for operating cycles by default.
/// road_type : str, optional
///     Road type of logs without a column ``road_type``; by default it follows from the speed limit.
/// altitude_average_m : float
///     Length over which the altitudes of logs are averaged, in m.
/// mission_stop_s : float
///     Standstills of logs from this time on are stops of the mission, in s.
/// split_ratio : float, optional
///     Cut a curve of a log in two where its curvature steps by this factor or more.
/// steering_ratio : float, optional
///     Ratio of the steering, 1 to 100, for logs that only have the angle of the steering wheel.
/// wheelbase_m : float, optional
///     Wheelbase, 0.5 to 20 m, for such logs.
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc fit operating-cycle --json``: ``types`` with their ``parameters``, ``junction_turn``, ``mission``,
///     ``birds_eye`` and others; ``study`` is the part of a study that follows from it. Lengths are in m.
///
/// Raises
/// ------
/// ValueError
///     Where a cycle has no road types, or one that the base study does not have, where a file is no operating cycle, where a log
///     cannot be used, or where an option is out of its range.
/// OSError
///     Where a file cannot be read.
///
/// Warns
/// -----
/// UserWarning
///     Where the roads do not tell something, which then stays as in the base study, and where a part of a log is not used.
///
/// Notes
/// -----
/// Maximum likelihood or moments of the model that draws each part of the road: the guide's page on it has the list.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> study = ocmc.Study("field-truck")
/// >>> fit = ocmc.fit_operating_cycle([study.operating_cycle(k) for k in range(20)])
/// >>> fit["cycles"], [road["road_type"] for road in fit["types"]]
/// (20, ['motorway', 'rural', 'urban'])
#[pyfunction]
#[pyo3(
    signature = (
        cycles, *, columns=None, base=None, radius_range_m=None, road_type=None, altitude_average_m=200.0,
        mission_stop_s=300.0, split_ratio=None, steering_ratio=None, wheelbase_m=None
    ),
    text_signature = "(cycles, *, columns=None, base=None, radius_range_m=None, road_type=None, \
                      altitude_average_m=200.0, mission_stop_s=300.0, split_ratio=None, steering_ratio=None, \
                      wheelbase_m=None)"
)]
pub(crate) fn fit_operating_cycle<'py>(
    py: Python<'py>,
    cycles: &Bound<'py, PyAny>,
    columns: Option<BTreeMap<String, String>>,
    base: Option<&Bound<'py, PyStudy>>,
    radius_range_m: Option<(f64, f64)>,
    road_type: Option<String>,
    altitude_average_m: f64,
    mission_stop_s: f64,
    split_ratio: Option<f64>,
    steering_ratio: Option<f64>,
    wheelbase_m: Option<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let standard = RoadOptions::default();
    let radius_range_m: Option<[f64; 2]> = radius_range_m.map(Into::into);
    let options = RoadOptions {
        curves: CurveOptions { split_ratio, ..standard.curves },
        radius_range_m: radius_range_m.unwrap_or(standard.radius_range_m),
        altitude_average_m,
        mission_stop_s,
        road_type,
    };
    let steering = steering(steering_ratio, wheelbase_m)?;
    let mappings = mappings(columns)?;
    let given = sequence(cycles, "cycles")?.unwrap_or_else(|| vec![cycles.clone()]);
    let roads = given.iter().enumerate().map(|(k, cycle)| road(cycle, k));
    let (roads, base) = (&roads.collect::<PyResult<Vec<_>>>()?[..], &base_model(base));
    let request =
        OperatingCycleRequest { roads, mappings, base, options, radius_range_m, steering };
    let fitted = warned(py, |warn| {
        watched(py, None, |watch| ocmc_api::fit_operating_cycle(&request, warn, watch))
    })?;
    answer(py, &fitted)
}

/// An operating cycle, or what one or a log is read from.
fn road<'a>(cycle: &'a Bound<PyAny>, k: usize) -> PyResult<RoadSource<'a>> {
    if let Ok(cycle) = cycle.cast::<PyOperatingCycle>() {
        return Ok(RoadSource::Cycle(cycle.get().realised()));
    }
    if !is_path(cycle)? && !is_table(cycle)? {
        let allowed = "a path, a log or an ocmc.OperatingCycle, or a list of these";
        let text = format!("`cycles` is {}, allowed is {allowed}", shown(cycle));
        return Err(PyTypeError::new_err(text));
    }
    Ok(RoadSource::Measured(input(cycle, &format!("cycles[{k}]"))?))
}

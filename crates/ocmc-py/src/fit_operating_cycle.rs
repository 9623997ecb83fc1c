//! Fits of roads: from operating cycles or logs to the numbers of a study.

use crate::error::{given_cycle_error, no_fit};
use crate::fit::{answer, base_model, warn};
use crate::input::{Input, input, is_path, is_table, sequence};
use crate::log::{mappings, read_input, steering};
use crate::operating_cycle::PyOperatingCycle;
use crate::progress::Watch;
use crate::study::PyStudy;
use crate::value::shown;
use ocmc_cli::operating_cycle_answer;
use ocmc_estimation::fit::operating_cycle::fit_with_coverage;
use ocmc_estimation::log::curve::CurveOptions;
use ocmc_estimation::log::road::RoadOptions;
use ocmc_io::given_cycle;
use ocmc_io::log::curves::Steering;
use ocmc_io::log::roads::{FoundRoads, NEEDS, is_log};
use ocmc_io::table::Mapping;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

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
    let logs = Logs {
        options: RoadOptions {
            curves: CurveOptions { split_ratio, ..standard.curves },
            radius_range_m: radius_range_m.unwrap_or(standard.radius_range_m),
            altitude_average_m,
            mission_stop_s,
            road_type,
        },
        steering: steering(steering_ratio, wheelbase_m)?,
        mappings: mappings(columns)?,
    };
    let given = sequence(cycles, "cycles")?.unwrap_or_else(|| vec![cycles.clone()]);
    let mut found = FoundRoads::default();
    let mut source = PathBuf::from("cycles");
    for (k, cycle) in given.iter().enumerate() {
        py.check_signals()?;
        if let Ok(cycle) = cycle.cast::<PyOperatingCycle>() {
            let cycle = cycle.get();
            let road = py.detach(|| cycle.given());
            found.add_cycle(road.map_err(|error| no_fit(Path::new("cycles"), &error))?);
            continue;
        }
        if !is_path(cycle)? && !is_table(cycle)? {
            let allowed = "a path, a log or an ocmc.OperatingCycle, or a list of these";
            let text = format!("`cycles` is {}, allowed is {allowed}", shown(cycle));
            return Err(PyTypeError::new_err(text));
        }
        let item = input(cycle, &format!("cycles[{k}]"))?;
        if k == 0 {
            item.path().clone_into(&mut source);
        }
        match item {
            Input::File(path) if logs.mappings.is_empty() && !is_log(&path, &[]) => {
                let road = py.detach(|| given_cycle::read(&path, &[]));
                found.add_cycle(road.map_err(|error| given_cycle_error(&error))?);
            }
            log => logs.add(py, &mut found, &log)?,
        }
    }
    if let Some((place, fault)) = found.failed() {
        return Err(PyValueError::new_err(format!("{place}: {fault}")));
    }
    for note in &found.notes {
        warn(py, note)?;
    }
    for (place, fault) in &found.left_out {
        warn(py, &format!("{place} is left out: {fault}"))?;
    }
    let model = base_model(base);
    let coverage = found.coverage(radius_range_m);
    let answered = py.detach(|| {
        let fit = fit_with_coverage(&found.roads, &coverage, &model);
        fit.map(|fit| operating_cycle_answer(&fit, &model)).map_err(|error| no_fit(&source, &error))
    })?;
    answer(py, &answered)
}

/// How logs are read.
struct Logs {
    options: RoadOptions,
    steering: Option<Steering>,
    mappings: Vec<Mapping>,
}

impl Logs {
    /// Adds the roads of a log, and warns of what is odd in it.
    fn add(&self, py: Python, found: &mut FoundRoads, log: &Input) -> PyResult<()> {
        let mut watch = Watch::without_bar();
        let file = py.detach(|| {
            let file = read_input(log, &self.mappings, &NEEDS)?;
            let ended = found.add(&file, &self.options, self.steering, || match watch.look(0) {
                Ok(()) => ControlFlow::Continue(()),
                Err(interrupt) => ControlFlow::Break(interrupt),
            });
            match ended {
                ControlFlow::Continue(()) => Ok(file),
                ControlFlow::Break(interrupt) => Err(interrupt),
            }
        })?;
        file.warnings().iter().try_for_each(|warning| warn(py, warning))
    }
}

//! Identification: the pedal gains of drivers.

use crate::answer::{answer, warned};
use crate::input::inputs;
use crate::log::mappings;
use crate::progress::watched;
use crate::study::PyStudy;
use crate::value::{one_of, whole_number};
use ocmc_api::{ControllerKind, IdentifyOptions, IdentifyRequest, SpeedTerm};
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// Most starts of a search, as on the command line.
const MOST_STARTS: u64 = 4096;

/// Identify the pedal gains of drivers, one fit for each driver and event.
///
/// Parameters
/// ----------
/// logs : table, str or os.PathLike, or a list of these
///     One row a sample, at least one a second, columns by quantity and unit: ``time_s``, ``speed_mps`` or ``speed_kmh``,
///     ``accelerator`` and ``brake`` (0 to 1) or ``accelerator_percent`` and ``brake_percent``, ``grade`` or
///     ``grade_percent``; where known ``position_m`` and ``gear``, and labels ``driver``, ``drive``, ``event``. Any table that
///     speaks Arrow, a dictionary of columns, or a CSV file, plain or compressed by gzip.
/// study : Study
///     The study with the truck that was driven, such as ``Study("simulator-study")``.
/// columns : dict of str to str, optional
///     Which column is what, such as ``{"grade_percent": "slope"}``.
/// controller : {"pid", "switched"}
///     Controller that is fitted.
/// speed_term : {"none", "measured", "simulated"}
///     Speed that the objective compares with the set speed. The paper may mean the measured or the
///     simulated one: both bias the gains. Without this term they are unbiased.
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
///     The content of ``ocmc identify --json``: ``fits`` with ``driver``, ``event``, ``kp`` (s/m), ``ki`` (1/m), ``kd`` (s²/m),
///     ``set_speed_mps``, ``at_bound``, ``not_identifiable`` and others; ``population``, of three drivers or more; ``left_out``, and
///     ``notes`` on rows that are not used.
///
/// Raises
/// ------
/// ValueError
///     Where a column is missing or unclear, where no event can be identified, or where an option is out of its range.
/// OSError
///     Where a file cannot be read.
///
/// Warns
/// -----
/// UserWarning
///     Where an event or a drive is left out, and where cells are no numbers.
///
/// See Also
/// --------
/// ocmc.plot.identified : Draws the gains.
///
/// Notes
/// -----
/// min ∫ (a − â)² + (b − b̂)² + ((v_d − v) / 20 m/s)² dt in closed loop: Romano, Godio, Bruzelius, Johannesson.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> study = ocmc.Study("simulator-study")
/// >>> trace = study.trace(0)
/// >>> names = ["time_s", "speed_mps", "accelerator", "brake", "grade", "gear"]
/// >>> log = {name: trace[name][2400:3200] for name in names} | {"driver": ["a"] * 800, "event": ["up"] * 800}
/// >>> answer = ocmc.identify(log, study, starts=1, intervals=False)
/// >>> [(fit["driver"], fit["event"]) for fit in answer["fits"]]
/// [('a', 'up')]
#[pyfunction]
#[pyo3(
    signature = (
        logs, study, *, columns=None, controller="pid", speed_term="none", starts=None, kp=None, ki=None, kd=None,
        intervals=true, progress=None
    ),
    text_signature = "(logs, study, *, columns=None, controller='pid', speed_term='none', starts=8, \
                      kp=(0.01, 2.0), ki=(0.0001, 0.2), kd=(0.0, 2.0), intervals=True, progress=None)"
)]
pub(crate) fn identify<'py>(
    py: Python<'py>,
    logs: &Bound<'py, PyAny>,
    study: &Bound<'py, PyStudy>,
    columns: Option<BTreeMap<String, String>>,
    controller: &str,
    speed_term: &str,
    starts: Option<&Bound<'py, PyAny>>,
    kp: Option<(f64, f64)>,
    ki: Option<(f64, f64)>,
    kd: Option<(f64, f64)>,
    intervals: bool,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let standard = IdentifyOptions::default();
    let starts = starts.map(|starts| whole_number(starts, "starts", 1, MOST_STARTS)).transpose()?;
    let options = IdentifyOptions {
        controller: one_of("controller", controller, &CONTROLLERS)?,
        speed_term: one_of("speed_term", speed_term, &SPEED_TERMS)?,
        starts: starts.map_or(standard.starts, |starts| starts as usize),
        intervals,
        proportional: kp.map_or(standard.proportional, Into::into),
        integral: ki.map_or(standard.integral, Into::into),
        derivative: kd.map_or(standard.derivative, Into::into),
        ..standard
    };
    let request = IdentifyRequest {
        logs: &inputs(logs, "logs")?,
        study: study.get().loaded(),
        mappings: mappings(columns)?,
        options,
        warn_of_rows: false,
    };
    let identified = warned(py, |warn| {
        watched(py, progress, |watch| ocmc_api::identify(&request, warn, watch))
    })?;
    answer(py, &identified)
}

const CONTROLLERS: [(&str, ControllerKind); 2] =
    [("pid", ControllerKind::Pid), ("switched", ControllerKind::Switched)];

const SPEED_TERMS: [(&str, SpeedTerm); 3] = [
    ("none", SpeedTerm::None),
    ("measured", SpeedTerm::Measured),
    ("simulated", SpeedTerm::Simulated),
];

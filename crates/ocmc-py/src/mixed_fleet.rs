//! A fleet of groups of trucks, from Python.

use crate::answer::answer;
use crate::plan::{seed_of, threads_of};
use crate::progress::watched;
use crate::study::opened;
use crate::value::one_of;
use ocmc_api::study::Opened;
use ocmc_api::{CpuLevel, FORMATS, MixedFleetRequest};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::path::PathBuf;

/// Drive a fleet of groups of trucks, the ``[[fleet.group]]`` of a study, and add up what they use.
///
/// Parameters
/// ----------
/// study : str, os.PathLike or dict
///     The study file, or a dictionary of its shape.
/// seed : int
///     Master seed.
/// out : str or os.PathLike, optional
///     Directory in which each group has its run, a folder of its name, beside ``fleet.json`` and
///     ``report.html`` of them all.
/// format : {"parquet", "csv"}, optional
///     Format of the records in `out`; Parquet by default.
/// threads : int, optional
///     Threads to use, one for each CPU by default.
/// progress : bool or callable, optional
///     As for `Study.run`.
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc --study FILE --json``: ``totals`` of the fleet, each with its ``unit``
///     and ``prediction95``, and ``groups`` with their ``totals`` and ``run``. ``replaceable`` are
///     the trucks whose trips arrive with the truck of a group that has a battery.
///
/// Raises
/// ------
/// ValueError
///     Where the study has no groups, or where one is wrong.
/// OSError
///     Where a file cannot be read or written.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> group = {"name": "near", "trucks": 2, "mission": {"length_m": 5000.0}}
/// >>> fleet = {"trips_per_truck": 2, "group": [group]}
/// >>> answer = ocmc.mixed_fleet({"study": {"base": "field-truck"}, "fleet": fleet})
/// >>> [(total["name"], total["unit"]) for total in answer["totals"]][:2]
/// [('fuel', 'L'), ('CO2', 't')]
#[pyfunction]
#[pyo3(
    signature = (study, *, seed=None, out=None, format=None, threads=None, progress=None),
    text_signature = "(study, *, seed=1, out=None, format=None, threads=None, progress=None)"
)]
pub(crate) fn mixed_fleet<'py>(
    py: Python<'py>,
    study: &Bound<'py, PyAny>,
    seed: Option<&Bound<'py, PyAny>>,
    out: Option<PathBuf>,
    format: Option<&str>,
    threads: Option<&Bound<'py, PyAny>>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let format = format.map(|word| one_of("format", word, &FORMATS)).transpose()?;
    let Opened::Fleet(groups) = opened(study, true)? else {
        let text =
            "the study has no `[[fleet.group]]`: `ocmc.Study(...).run(trucks=...)` drives it";
        return Err(PyValueError::new_err(text));
    };
    let request = MixedFleetRequest {
        groups: &groups,
        seed: seed_of(seed)?,
        threads: threads_of(threads)?,
        level: CpuLevel::best(),
        out: out.map(|path| (path, format.unwrap_or_default())),
        resume: false,
    };
    answer(py, &watched(py, progress, |watch| ocmc_api::mixed_fleet(&request, watch))?)
}

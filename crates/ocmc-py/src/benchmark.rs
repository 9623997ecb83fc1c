//! Measured trips beside what a study expects of them.

use crate::answer::answer;
use crate::input::{input, mappings};
use crate::plan::{seed_of, threads_of};
use crate::progress::watched;
use crate::study::PyStudy;
use ocmc_api::{BenchmarkContrast, BenchmarkRequest, check_empty};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Set measured trips beside what a study expects of them.
///
/// Parameters
/// ----------
/// trips : table, str or os.PathLike
///     One row a trip: ``distance_km``, ``fuel_l`` or ``energy_kwh``, and where known
///     ``gross_weight_kg``, ``driving_time_h``, ``climb_m``, ``truck``, ``driver``, ``date``,
///     ``route``.
/// study : Study
///     The study that says what is expected.
/// columns : dict of str to str, optional
///     Which column is what, such as ``{"fuel_amount_l": "diesel"}``.
/// since : str, optional
///     Also compare the trips since a date, such as ``"2024-03-01"``, with those before.
/// group : str, optional
///     Also compare the groups of this column.
/// names : bool
///     Whether drivers keep their names; else they are numbered.
/// speed : bool
///     Whether trips are adjusted for their mean speed, where driving times are known.
/// cycles : int
///     Trips of the study, from 100 on.
/// seed : int
///     Master seed.
/// threads : int, optional
///     Threads to use, one for each CPU by default.
/// out : str or os.PathLike, optional
///     Directory for the answer, its trips and a page; it has to be empty.
/// progress : bool or callable, optional
///     Whether to show a bar; by default where standard error is a terminal.
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc benchmark --json``: ``ratio``, ``levels`` with the ``members`` of
///     those that differ beyond chance, ``adjusted_for``, ``compared``, ``far`` and others.
///
/// Raises
/// ------
/// ValueError
///     Where the table cannot be read or has too few rows, or where its amounts are of another
///     carrier than the study's. Where what is compared is not in it.
/// OSError
///     Where the file cannot be read.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> try:
/// ...     ocmc.benchmark("trips.csv", ocmc.Study("field-truck"), since="May", group="tyre")
/// ... except ValueError as error:
/// ...     print(error)
/// `since` and `group` are both given, allowed is one of them
#[pyfunction]
#[pyo3(
    signature = (
        trips, study, *, columns=None, since=None, group=None, names=false, speed=true,
        cycles=3200, seed=None, threads=None, out=None, progress=None
    ),
    text_signature = "(trips, study, *, columns=None, since=None, group=None, names=False, \
                      speed=True, cycles=3200, seed=1, threads=None, out=None, progress=None)"
)]
pub(crate) fn benchmark<'py>(
    py: Python<'py>,
    trips: &Bound<'py, PyAny>,
    study: &Bound<'py, PyStudy>,
    columns: Option<BTreeMap<String, String>>,
    since: Option<String>,
    group: Option<String>,
    names: bool,
    speed: bool,
    cycles: u64,
    seed: Option<&Bound<'py, PyAny>>,
    threads: Option<&Bound<'py, PyAny>>,
    out: Option<PathBuf>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    if since.is_some() && group.is_some() {
        let text = "`since` and `group` are both given, allowed is one of them";
        return Err(PyValueError::new_err(text));
    }
    if !(100..=1_000_000).contains(&cycles) {
        let text = format!("`cycles` is {cycles}, allowed is 100 to 1000000");
        return Err(PyValueError::new_err(text));
    }
    if let Some(directory) = &out {
        check_empty(directory).map_err(crate::error::exception)?;
    }
    let mut columns = columns.unwrap_or_default();
    let of_group = group.map(|column| columns.insert("group".to_owned(), column));
    let contrast = of_group.map(|_| BenchmarkContrast::Group);
    let study = &study.get().loaded;
    let request = BenchmarkRequest {
        trips: input(trips, "trips")?,
        mappings: mappings(Some(columns))?,
        study: (study.origin.to_string(), study),
        contrast: since.map(BenchmarkContrast::Since).or(contrast),
        names,
        speed,
        cycles,
        seed: seed_of(seed)?,
        threads: threads_of(threads)?,
    };
    let benchmarked = watched(py, progress, |watch| ocmc_api::benchmark(&request, watch))?;
    if let Some(directory) = &out {
        benchmarked.save(directory).map_err(crate::error::exception)?;
    }
    answer(py, &benchmarked)
}

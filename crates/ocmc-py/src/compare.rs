//! `ocmc.compare`: two studies on the same cycles.

use crate::answer::answer;
use crate::error::exception;
use crate::plan::plan_of;
use crate::progress::watched;
use crate::study::PyStudy;
use crate::value::one_of;
use ocmc_api::{CompareRequest, FORMATS, check_empty};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::path::PathBuf;

/// Compare two studies on the same cycles: the difference of each pair is that of the studies
/// alone.
///
/// Parameters
/// ----------
/// a, b : Study
///     The studies.
/// cycles : int
///     Number of cycles that each of them drives, at least 1.
/// seed : int
///     Master seed.
/// first_cycle : int
///     Id of the first cycle.
/// column : str, optional
///     The quantity that is compared, such as ``"mean_speed_mps"``, or another column of the
///     records that is a number, such as ``"fuel_kg_urban"``. By default the first consumption that
///     both have: fuel, electricity, or the work at the wheels.
/// out : str or os.PathLike, optional
///     Directory for the runs of the studies (``a`` and ``b``), the values pair by pair, the
///     studies, ``comparison.json`` and a page. It has to be empty, and is made where it is not
///     there.
/// format : {"parquet", "csv"}, optional
///     Format of the records in `out`; Parquet by default.
/// names : sequence of str, optional
///     What the answer, the pictures and the page call the two; by default the studies' names.
/// threads : int, optional
///     Threads to use, one for each CPU by default.
/// progress : bool or callable, optional
///     As for `Study.run`.
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc compare --json``: ``a`` and ``b`` (means of the fleets),
///     ``difference`` (b less a) with its 95 % interval ``ci95``, ``share_a_lower``,
///     ``variance_reduction`` and others, in the column's unit.
///
/// Raises
/// ------
/// ValueError
///     Where a number is out of its range, where there is no such column, or where there are not
///     two names.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> study = ocmc.Study("field-truck").set("mission.length_m", 5000.0)
/// >>> loaded = study.set("mission.payload_kg", 20000.0)
/// >>> answer = ocmc.compare(study, loaded, cycles=100)
/// >>> answer["difference"] > 0.0
/// True
#[pyfunction]
#[pyo3(
    signature = (
        a, b, *, cycles, seed=None, first_cycle=None, column=None, out=None, format=None,
        names=None, threads=None, progress=None
    ),
    text_signature = "(a, b, *, cycles, seed=1, first_cycle=0, column=None, out=None, format=None, \
                      names=None, threads=None, progress=None)"
)]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyStudy>,
    b: &Bound<'py, PyStudy>,
    cycles: &Bound<'py, PyAny>,
    seed: Option<&Bound<'py, PyAny>>,
    first_cycle: Option<&Bound<'py, PyAny>>,
    column: Option<&str>,
    out: Option<PathBuf>,
    format: Option<&str>,
    names: Option<Vec<String>>,
    threads: Option<&Bound<'py, PyAny>>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let format = format.map(|word| one_of("format", word, &FORMATS)).transpose()?;
    out.as_deref().map_or(Ok(()), check_empty).map_err(exception)?;
    let plan = plan_of(cycles, seed, first_cycle, threads)?;
    let mut studies = [a, b].map(|study| study.get().named());
    if let Some(names) = names {
        let [name_a, name_b] = <[String; 2]>::try_from(names).map_err(|names| {
            PyValueError::new_err(format!("`names` has {} items, allowed are 2", names.len()))
        })?;
        (studies[0].0, studies[1].0) = (name_a, name_b);
    }
    let (column, keep) = (column.map(str::to_owned), out.is_some());
    let request = CompareRequest { studies: studies.to_vec(), plan, column, keep };
    let comparison = watched(py, progress, |watch| ocmc_api::compare(&request, watch))?;
    let saved = out.map_or(Ok(()), |out| comparison.save(&out, format.unwrap_or_default()));
    saved.map_err(exception)?;
    answer(py, &comparison)
}

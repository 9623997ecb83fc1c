//! Learning: a study from the files of a fleet.

use crate::answer::answer;
use crate::error::exception;
use crate::input::mappings;
use crate::plan::{seed_of, threads_of};
use crate::progress::watched;
use ocmc_api::{LearnRequest, Noise, study};
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Learn a study from a folder with the files of a fleet.
///
/// Parameters
/// ----------
/// folder : str or os.PathLike
///     Folder with tables of trips or fills, logs and tracks, tables of weather, traffic, curves
///     and speed changes; what each file is, its columns say.
/// base : str
///     Name of a built-in study, or a study file, that keeps what is not learnt.
/// name : str
///     Name of the new study.
/// columns : dict of str to str, optional
///     Which column is what, such as ``{"fuel_amount_l": "diesel"}``, in all tables that have it.
/// hold_back : float
///     Share of the trips that the check is made on, whole days of a truck; 0 for none.
/// amount_noise : float
///     Noise of the amounts, SD as a share.
/// weight_noise : float
///     Noise of the gross weights, SD as a share.
/// seed : int
///     Master seed.
/// threads : int, optional
///     Threads to use, one for each CPU by default.
/// page : str or os.PathLike, optional
///     HTML page to write, which opens offline.
/// progress : bool or callable, optional
///     As for `Study.run`.
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc learn --json``: ``files``, ``parts`` (the fits), ``totals`` (the
///     calibration), ``held_back`` (the check), ``doubt`` before and after; ``study_toml`` is the
///     study.
///
/// Raises
/// ------
/// ValueError
///     Where nothing in the folder can be learnt from, or where a number is out of its range.
/// OSError
///     Where the folder cannot be read.
///
/// Examples
/// --------
/// >>> import ocmc, pathlib, tempfile
/// >>> with tempfile.TemporaryDirectory() as folder:
/// ...     _ = pathlib.Path(folder, "notes.txt").write_text("a note")
/// ...     try:
/// ...         ocmc.learn(folder)
/// ...     except ValueError as error:
/// ...         print("nothing in it can be learnt from" in str(error))
/// True
#[pyfunction]
#[pyo3(
    signature = (
        folder, *, base="field-truck", name="my-fleet", columns=None, hold_back=0.2,
        amount_noise=0.03, weight_noise=0.05, seed=None, threads=None, page=None, progress=None
    ),
    text_signature = "(folder, *, base='field-truck', name='my-fleet', columns=None, \
                      hold_back=0.2, amount_noise=0.03, weight_noise=0.05, seed=1, threads=None, \
                      page=None, progress=None)"
)]
pub(crate) fn learn<'py>(
    py: Python<'py>,
    folder: PathBuf,
    base: &str,
    name: &str,
    columns: Option<BTreeMap<String, String>>,
    hold_back: f64,
    amount_noise: f64,
    weight_noise: f64,
    seed: Option<&Bound<'py, PyAny>>,
    threads: Option<&Bound<'py, PyAny>>,
    page: Option<PathBuf>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let loaded = study::load(base, &[] as &[&str]).map_err(|error| exception(error.into()))?;
    let request = LearnRequest {
        folder,
        mappings: mappings(columns)?,
        base: (base.to_owned(), &loaded),
        name: name.to_owned(),
        noise: Noise { amount: amount_noise, weight: weight_noise },
        hold_back,
        seed: seed_of(seed)?,
        threads: threads_of(threads)?,
    };
    let learnt = watched(py, progress, |watch| ocmc_api::learn(&request, watch))?;
    page.map_or(Ok(()), |page| learnt.save_page(&page)).map_err(exception)?;
    answer(py, &learnt)
}

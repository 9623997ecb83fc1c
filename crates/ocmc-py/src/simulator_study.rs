//! The paper's driving-simulator study.

use crate::answer::answer;
use crate::error::exception;
use crate::plan::{seed_of, threads_of};
use crate::progress::watched;
use crate::study::PyStudy;
use crate::value::{one_of, whole_number};
use ocmc_api::{MOST_REPETITIONS, SPEED_TERMS, SimulatorStudyRequest, check_empty};
use pyo3::prelude::*;
use std::path::PathBuf;

/// Repetitions by default.
const REPETITIONS: u64 = 40;

/// Repeat the paper's driving-simulator study: its tables and pictures, beside the paper's numbers.
///
/// Parameters
/// ----------
/// study : Study
///     The study, ``Study("simulator-study")`` or one that differs from it: cycle 8 r + d is
///     driver d of repetition r.
/// repetitions : int
///     How often the study is repeated, each time with eight other drivers.
/// seed : int
///     Master seed.
/// gains : bool
///     Whether the gains of the first repetition are identified, which takes most of the time.
/// speed_term : {"simulated", "measured", "none"}
///     Speed that the objective of the identification compares with the set speed.
/// out : str or os.PathLike, optional
///     Empty directory for tables, pictures and a page.
/// threads : int, optional
///     Threads to use, one for each CPU by default.
/// progress : bool or callable, optional
///     As for `Study.run`, in drives and in events.
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc simulator-study --json``: ``compared``, the paper's numbers beside
///     those of the repetitions, ``curve_speed`` and ``speed_change`` of the first one, ``events``
///     with their gains, ``curves`` and ``changes``.
///
/// Raises
/// ------
/// ValueError
///     Where curves or changes have no fit, or an option is out of its range.
/// OSError
///     Where a file cannot be written.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> study = ocmc.Study("simulator-study").set("simulation.step_s", 0.5)
/// >>> answer = ocmc.simulator_study(study, repetitions=2, gains=False)
/// >>> [row["df"] for row in answer["curve_speed"]["anova"]]
/// [1, 7, 1, 38]
#[pyfunction]
#[pyo3(
    signature = (
        study, *, repetitions=None, seed=None, gains=true, speed_term="simulated", out=None,
        threads=None, progress=None
    ),
    text_signature = "(study, *, repetitions=40, seed=1, gains=True, speed_term='simulated', \
                      out=None, threads=None, progress=None)"
)]
pub(crate) fn simulator_study<'py>(
    py: Python<'py>,
    study: &Bound<'py, PyStudy>,
    repetitions: Option<&Bound<'py, PyAny>>,
    seed: Option<&Bound<'py, PyAny>>,
    gains: bool,
    speed_term: &str,
    out: Option<PathBuf>,
    threads: Option<&Bound<'py, PyAny>>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let speed_term = one_of("speed_term", speed_term, &SPEED_TERMS)?;
    let count = |n| whole_number(n, "repetitions", 1, MOST_REPETITIONS);
    let threads = threads_of(threads)?;
    out.as_deref().map_or(Ok(()), check_empty).map_err(exception)?;
    let request = SimulatorStudyRequest {
        study: &study.get().loaded,
        seed: seed_of(seed)?,
        repetitions: repetitions.map_or(Ok(REPETITIONS), count)?,
        threads,
        identify: gains.then_some(speed_term),
    };
    let studied = watched(py, progress, |watch| ocmc_api::simulator_study(&request, watch))?;
    out.map_or(Ok(()), |out| studied.save(&out)).map_err(exception)?;
    answer(py, &studied)
}

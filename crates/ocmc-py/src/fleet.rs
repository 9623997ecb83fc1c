//! Questions about a fleet: which study is better, what drives the spread.

use crate::fit::answer;
use crate::progress::Watch;
use crate::study::{PyStudy, plan_of};
use ocmc_cli::{birds_eye_answer, comparison_answer, sensitivity_answer};
use ocmc_core::fleet::comparison;
use ocmc_core::fleet::quantity::{QUANTITIES, RecordQuantity, quantity};
use ocmc_core::fleet::run::RunPlan;
use ocmc_core::fleet::sensitivity::{self, factor_groups};
use ocmc_core::study::{Study, StudyModel};
use ocmc_estimation::fit::operating_cycle::birds_eye_of_study;
use ocmc_io::study::LoadedStudy;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::time::Instant;

/// Drives what an answer needs, without the interpreter but for a look at its signals and the progress bar. Returns the
/// answer and the seconds that it took.
fn driven<T: Send>(
    py: Python,
    cycles: u64,
    progress: Option<&Bound<PyAny>>,
    drive: impl FnOnce(&mut dyn FnMut(u64) -> ControlFlow<PyErr>) -> ControlFlow<PyErr, T> + Send,
) -> PyResult<(T, f64)> {
    let mut watch = Watch::new(py, progress, cycles)?;
    let clock = Instant::now();
    let mut done = 0;
    let ended = py.detach(|| {
        drive(&mut |driven| {
            done = driven;
            match watch.look(driven) {
                Ok(()) => ControlFlow::Continue(()),
                Err(interrupt) => ControlFlow::Break(interrupt),
            }
        })
    });
    let wall_s = clock.elapsed().as_secs_f64();
    let answer = match ended {
        ControlFlow::Continue(answer) => {
            done = cycles;
            Ok(answer)
        }
        ControlFlow::Break(interrupt) => Err(interrupt),
    };
    let finished = watch.finish(py, done);
    let answer = answer?;
    finished?;
    Ok((answer, wall_s))
}

/// The quantity that is asked about.
fn quantity_of(column: Option<&str>) -> PyResult<Option<&'static RecordQuantity>> {
    let Some(column) = column else { return Ok(None) };
    let known = quantity(column).ok_or_else(|| {
        let names = QUANTITIES.map(|quantity| quantity.column).join(", ");
        PyValueError::new_err(format!("`column` is {column:?}, allowed is one of: {names}"))
    })?;
    Ok(Some(known))
}

/// `Study.sensitivity`.
pub(crate) fn shares<'py>(
    py: Python<'py>,
    study: &LoadedStudy,
    plan: &RunPlan,
    column: Option<&str>,
    factors: Option<Vec<String>>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let quantity = quantity_of(column)?;
    let mut groups = factor_groups();
    if let Some(factors) = factors {
        if let Some(wrong) = factors.iter().find(|name| groups.iter().all(|g| g.name != *name)) {
            let names: Vec<&str> = groups.iter().map(|group| group.name).collect();
            let text = format!("`factors` has {wrong:?}, allowed are: {}", names.join(", "));
            return Err(PyValueError::new_err(text));
        }
        groups.retain(|group| factors.iter().any(|name| name == group.name));
    }
    let cycles = plan.cycles.saturating_mul(2 + groups.len() as u64);
    let (shares, wall_s) = driven(py, cycles, progress, |look| {
        sensitivity::sensitivity(&study.study, plan, &groups, quantity, look)
    })?;
    let shares = shares.map_err(|error| PyValueError::new_err(error.to_string()))?;
    answer(py, &sensitivity_answer(study, plan, &shares, None, wall_s))
}

/// `Study.birds_eye`.
pub(crate) fn birds_eye<'py>(
    py: Python<'py>,
    study: &LoadedStudy,
    plan: &RunPlan,
) -> PyResult<Bound<'py, PyAny>> {
    let ids = plan.first_cycle..plan.first_cycle + plan.cycles;
    let (view, _) = driven(py, plan.cycles, None, |look| {
        birds_eye_of_study(&study.study, plan.seed, ids.clone(), look)
    })?;
    answer(py, &birds_eye_answer(study, plan.seed, &ids, &view))
}

/// Compare two studies on the same cycles: the difference of each pair is that of the studies alone.
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
///     The quantity that is compared, such as ``"mean_speed_mps"``; by default the first consumption that both have:
///     fuel, electricity, or the work at the wheels.
/// threads : int, optional
///     Threads to use, one for each CPU by default.
/// progress : bool or callable, optional
///     As for `Study.run`.
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc compare --json``: ``a`` and ``b`` (means of the fleets), ``difference`` (b less a) with its
///     95 % interval ``ci95``, ``share_a_lower``, ``variance_reduction`` and others, in the column's unit.
///
/// Raises
/// ------
/// ValueError
///     Where a number is out of its range, or where there is no such column.
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
    signature = (a, b, *, cycles, seed=None, first_cycle=None, column=None, threads=None, progress=None),
    text_signature = "(a, b, *, cycles, seed=1, first_cycle=0, column=None, threads=None, progress=None)"
)]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyStudy>,
    b: &Bound<'py, PyStudy>,
    cycles: &Bound<'py, PyAny>,
    seed: Option<&Bound<'py, PyAny>>,
    first_cycle: Option<&Bound<'py, PyAny>>,
    column: Option<&str>,
    threads: Option<&Bound<'py, PyAny>>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let plan = plan_of(cycles, seed, first_cycle, threads)?;
    let quantity = quantity_of(column)?;
    let loaded = [a, b].map(|study| study.get().loaded());
    let studies: [&Study; 2] = loaded.map(|study| &study.study);
    let (comparisons, wall_s) = driven(py, plan.cycles.saturating_mul(2), progress, |look| {
        comparison::compare(&studies, &plan, quantity, look)
    })?;
    let named: [(&str, &StudyModel); 2] =
        loaded.map(|study| (study.model.study.name.as_str(), &study.model));
    answer(py, &comparison_answer(&named, &plan, &comparisons, quantity.is_some(), wall_s))
}

//! Costs of studies, from Python.

use crate::answer::answer;
use crate::plan::{plan_of_trucks, with_trips};
use crate::progress::watched;
use crate::study::PyStudy;
use ocmc_api::CostRequest;
use pyo3::prelude::*;

type Given<'a, 'py> = Option<&'a Bound<'py, PyAny>>;

/// Costs of a study, or of two: `of` has cycles, trucks and trips, `work` seed, first cycle and
/// threads.
pub(crate) fn costed<'py>(
    py: Python<'py>,
    study: &PyStudy,
    against: Option<&Bound<'py, PyStudy>>,
    (cycles, trucks, trips): (Given<'_, 'py>, Given<'_, 'py>, Given<'_, 'py>),
    (seed, first_cycle, threads): (Given<'_, 'py>, Given<'_, 'py>, Given<'_, 'py>),
    progress: Given<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let own = with_trips(&study.loaded, trips)?;
    let plan = plan_of_trucks(&own, cycles, trucks, seed, first_cycle, threads)?;
    let other = against.map(|study| with_trips(&study.get().loaded, trips)).transpose()?;
    let against = against.zip(other.as_ref()).map(|(study, b)| (study.get().named().0, b));
    let request = CostRequest { study: (study.named().0, &own), against, plan };
    answer(py, &watched(py, progress, |watch| ocmc_api::cost(&request, watch))?)
}

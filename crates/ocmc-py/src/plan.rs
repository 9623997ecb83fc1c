//! How many cycles are asked for, from which id and seed, on how many threads.

use crate::value::whole_number;
use ocmc_api::study::LoadedStudy;
use ocmc_api::{LAST_CYCLE_ID, MOST_THREADS, Precision, RunPlan};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// Most trips of a truck.
const MOST_TRIPS: u64 = 1_000_000;

/// Cycles to run, and the number of threads.
pub(crate) fn plan_of(
    cycles: &Bound<PyAny>,
    seed: Option<&Bound<PyAny>>,
    first_cycle: Option<&Bound<PyAny>>,
    threads: Option<&Bound<PyAny>>,
) -> PyResult<RunPlan> {
    let cycles = whole_number(cycles, "cycles", 1, LAST_CYCLE_ID)?;
    plan_of_number(cycles, seed, first_cycle, threads)
}

/// As [`plan_of`], of so many cycles, or of a study's trucks.
pub(crate) fn plan_of_trucks(
    study: &LoadedStudy,
    cycles: Option<&Bound<PyAny>>,
    trucks: Option<&Bound<PyAny>>,
    seed: Option<&Bound<PyAny>>,
    first_cycle: Option<&Bound<PyAny>>,
    threads: Option<&Bound<PyAny>>,
) -> PyResult<RunPlan> {
    let of_truck = study.study.nesting().trips_per_truck;
    let cycles = number_of_cycles(cycles, trucks, of_truck, false)?.unwrap_or_default();
    plan_of_number(cycles, seed, first_cycle, threads)
}

fn plan_of_number(
    cycles: u64,
    seed: Option<&Bound<PyAny>>,
    first_cycle: Option<&Bound<PyAny>>,
    threads: Option<&Bound<PyAny>>,
) -> PyResult<RunPlan> {
    let seed = seed_of(seed)?;
    let last = LAST_CYCLE_ID - cycles;
    let first_cycle = first_cycle.map_or(Ok(0), |id| whole_number(id, "first_cycle", 0, last))?;
    Ok(RunPlan::new(seed, first_cycle, cycles, threads_of(threads)?, None))
}

pub(crate) fn threads_of(threads: Option<&Bound<PyAny>>) -> PyResult<Option<usize>> {
    let most = MOST_THREADS as u64;
    let threads = threads.map(|n| whole_number(n, "threads", 1, most)).transpose()?;
    Ok(threads.map(|n| n as usize))
}

pub(crate) fn cycle_id_of(cycle_id: &Bound<PyAny>) -> PyResult<u64> {
    whole_number(cycle_id, "cycle_id", 0, LAST_CYCLE_ID - 1)
}

/// The precision with which a run ends.
pub(crate) fn precision_of(text: Option<&str>) -> PyResult<Option<Precision>> {
    let wrong = |text, error| format!("`precision` is {text:?}: {error}");
    let precision =
        |text| ocmc_api::precision(text).map_err(|error| PyValueError::new_err(wrong(text, error)));
    text.map(precision).transpose()
}

pub(crate) fn seed_of(seed: Option<&Bound<PyAny>>) -> PyResult<u64> {
    seed.map_or(Ok(1), |seed| whole_number(seed, "seed", 0, u64::MAX))
}

/// The study, with so many trips of each truck where that is said.
pub(crate) fn with_trips(
    study: &LoadedStudy,
    trips: Option<&Bound<PyAny>>,
) -> PyResult<LoadedStudy> {
    let Some(trips) = trips else { return Ok(study.clone()) };
    let trips = whole_number(trips, "trips", 1, MOST_TRIPS)?;
    let set = study.set(&[format!("fleet.trips_per_truck={trips}")]);
    set.map_err(|error| PyValueError::new_err(error.to_string()))
}

/// Cycles that a run is to have: their number, or that of trucks with so many trips each.
pub(crate) fn number_of_cycles(
    cycles: Option<&Bound<PyAny>>,
    trucks: Option<&Bound<PyAny>>,
    of_truck: u64,
    may_lack: bool,
) -> PyResult<Option<u64>> {
    match (cycles, trucks) {
        (Some(cycles), None) => Ok(Some(whole_number(cycles, "cycles", 1, LAST_CYCLE_ID)?)),
        (None, Some(trucks)) => {
            Ok(Some(whole_number(trucks, "trucks", 1, LAST_CYCLE_ID / of_truck)? * of_truck))
        }
        (None, None) if may_lack => Ok(None),
        (None, None) => Err(PyTypeError::new_err(
            "`cycles` is None, allowed is a whole number from 1; or give `trucks`",
        )),
        _ => Err(PyValueError::new_err("give `cycles` or `trucks`, and not both")),
    }
}

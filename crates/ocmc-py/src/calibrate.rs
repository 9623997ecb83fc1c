//! Calibration: the laws with which a study gives measured tables back.

use crate::answer::answer;
use crate::input::{input, mappings};
use crate::plan::{seed_of, threads_of};
use crate::progress::watched;
use crate::study::PyStudy;
use ocmc_api::study::LoadedStudy;
use ocmc_api::{
    CalibrateCurveSpeedRequest, CalibrateTotalsRequest, CalibrationOptions, CurveSpeedOptions,
    MeasuredTable, Noise, Trips,
};
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// Find the law of curve speeds with which a study gives a measured table back.
///
/// Parameters
/// ----------
/// curves : Study, table, str or os.PathLike
///     The measured curves: one row a curve as for `fit_curve_speed`, or a study whose law was
///     measured, such as ``Study("field-truck-printed")``.
/// study : Study
///     The study that is driven and is to give the table back.
/// columns : dict of str to str, optional
///     Which column is what, such as ``{"speed_kmh": "v"}``.
/// drivers : int
///     Drivers of the simulated table, at least 20.
/// trips : int
///     Trips of each of them.
/// seed : int
///     Master seed.
/// least_residual_sd : float
///     Smallest residual SD that the law may have.
/// radius_range_m : tuple of float
///     Smallest and largest radius that take part, in m.
/// least_lateral_mps2 : float
///     Only curves with at least this lateral acceleration, speed squared over radius, take part,
///     in m/s².
/// progress : bool or callable, optional
///     Whether to show a bar; by default where standard error is a terminal.
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc calibrate curve-speed --json``: ``measured``, ``before``, ``law`` with
///     its ``standard_errors``, ``simulated``, ``at_bound``, ``surroundings`` and others;
///     ``study`` is the part of a study that follows from it.
///
/// Raises
/// ------
/// ValueError
///     Where the curves cannot be read or have no fit. Where the study takes its law from a table
///     of trucks, or where an option is out of its range.
/// OSError
///     Where the file cannot be read.
///
/// Notes
/// -----
/// Indirect inference (Gouriéroux, Monfort, Renault 1993) with the same random numbers at every
/// point of the search.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> short = ocmc.Study("field-truck").set("mission.length_m", 2000.0)
/// >>> try:
/// ...     ocmc.calibrate_curve_speed(short, short, drivers=3)
/// ... except ValueError as error:
/// ...     print(error)
/// the number of drivers is 3; allowed is a number from 20 on
#[pyfunction]
#[pyo3(
    signature = (
        curves, study, *, columns=None, drivers=240, trips=1, seed=1, least_residual_sd=0.048,
        radius_range_m=(20.0, 500.0), least_lateral_mps2=0.0, progress=None
    ),
    text_signature = "(curves, study, *, columns=None, drivers=240, trips=1, seed=1, \
                      least_residual_sd=0.048, radius_range_m=(20.0, 500.0), \
                      least_lateral_mps2=0.0, progress=None)"
)]
pub(crate) fn calibrate_curve_speed<'py>(
    py: Python<'py>,
    curves: &Bound<'py, PyAny>,
    study: &Bound<'py, PyStudy>,
    columns: Option<BTreeMap<String, String>>,
    drivers: u64,
    trips: u64,
    seed: u64,
    least_residual_sd: f64,
    radius_range_m: (f64, f64),
    least_lateral_mps2: f64,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let law = curves.cast::<PyStudy>().ok().map(|study| study.get().loaded.model.clone());
    let table = match &law {
        Some(model) => MeasuredTable::Law(model),
        None => MeasuredTable::Curves(input(curves, "curves")?, mappings(columns)?),
    };
    let study = &study.get().loaded;
    let options = CalibrationOptions {
        trips: Trips { seed, drivers, per_driver: trips, threads: 0 },
        fit: CurveSpeedOptions {
            reference_radius_m: study.model.driver.curve_speed.reference_radius_m,
            radius_range_m: radius_range_m.into(),
            least_lateral_mps2,
            ..CurveSpeedOptions::default()
        },
        least_residual_sd,
        ..CalibrationOptions::default()
    };
    let request = CalibrateCurveSpeedRequest { table, study, options };
    answer(py, &watched(py, progress, |watch| ocmc_api::calibrate_curve_speed(&request, watch))?)
}

/// Calibrates a study to the totals of trips: a table, and which of its columns is what.
pub(crate) fn totals<'py>(
    py: Python<'py>,
    (trips, columns): (&Bound<'py, PyAny>, Option<BTreeMap<String, String>>),
    study: &LoadedStudy,
    [amount, weight]: [f64; 2],
    (seed, threads): (Option<&Bound<'py, PyAny>>, Option<&Bound<'py, PyAny>>),
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (seed, threads) = (seed_of(seed)?, threads_of(threads)?);
    let (trips, mappings) = (input(trips, "trips")?, mappings(columns)?);
    let noise = Noise { amount, weight };
    let request = CalibrateTotalsRequest { trips, mappings, study, noise, seed, threads };
    answer(py, &watched(py, progress, |watch| ocmc_api::calibrate_totals(&request, watch))?)
}

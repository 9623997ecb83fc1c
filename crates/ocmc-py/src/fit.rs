//! Fits: from measurements to the numbers of a study.

use crate::answer::{answer, warned};
use crate::error::exception;
use crate::input::{input, inputs};
use crate::log::mappings;
use crate::progress::watched;
use crate::study::PyStudy;
use crate::value::one_of;
use ocmc_api::study::{self, StudyModel};
use ocmc_api::{
    Coding, CurveSpeedOptions, CurveSpeedRequest, SpeedChangeOptions, SpeedChangeRequest,
    fit_curve_speed as ask_curve_speed, fit_speed_change as ask_speed_change,
};
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// Fit the curve speeds of drivers: regression, analysis of variance, population.
///
/// Parameters
/// ----------
/// curves : table, str or os.PathLike
///     One row a curve: ``driver`` (or ``truck``), ``radius_m`` (m), ``speed_mps`` (m/s), and where known ``direction``
///     (``left`` or ``right``), ``route_m`` (length of the route, m), ``limit_mps`` (m/s). Any table that speaks Arrow, a
///     dictionary of columns, or a CSV file.
/// columns : dict of str to str, optional
///     Which column is what, such as ``{"speed_kmh": "v"}``.
/// base : Study, optional
///     The study that keeps what curves do not tell; ``field-truck`` by default.
/// tobit : bool
///     Take the population from the censored regression at the speed limits.
/// reference_radius_m : float
///     Radius at which speeds are compared, in m.
/// radius_range_m : tuple of float
///     Smallest and largest radius that take part, in m.
/// minimum_route_m : float
///     Routes have to be longer than this, in m, where their lengths are known.
/// fixed_exponent : float
///     Exponent of the second model, and the one that is tested.
/// significance : float
///     The direction stays in the model where its p is below this.
/// limit_share : float
///     Share of the speed limit from which on a curve counts as driven at the limit.
/// coding : {"sum_to_zero", "treatment"}
///     How the coefficients of drivers and directions are listed.
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc fit curve-speed --json``: ``anova``, ``estimated``, ``fixed``, ``by_driver`` and others;
///     ``study`` is the part of a study that follows from it.
///
/// Raises
/// ------
/// ValueError
///     Where a column is missing or a cell is wrong, where the curves do not determine the model, or where an option is
///     out of its range.
/// OSError
///     Where the file cannot be read.
///
/// Notes
/// -----
/// ln v = ln v₀ + δ (ln R − ln R₀) + driver + direction + residual: Romano, Godio, Bruzelius, Johannesson.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> radius = [50.0, 100.0, 200.0, 400.0]
/// >>> curves = {"driver": ["a"] * 4 + ["b"] * 4, "radius_m": radius * 2}
/// >>> speed = [10.1, 13.9, 20.2, 27.8, 11.1, 15.3, 22.1, 30.6]
/// >>> fit = ocmc.fit_curve_speed(curves | {"speed_mps": speed})
/// >>> round(fit["estimated"]["exponent"], 2)
/// 0.49
/// >>> study = ocmc.Study({"study": {"base": "field-truck"}} | fit["study"])
#[pyfunction]
#[pyo3(
    signature = (
        curves, *, columns=None, base=None, tobit=false, reference_radius_m=250.0, radius_range_m=(20.0, 500.0),
        minimum_route_m=5000.0, fixed_exponent=0.5, significance=0.05, limit_share=0.9, coding="sum_to_zero"
    ),
    text_signature = "(curves, *, columns=None, base=None, tobit=False, reference_radius_m=250.0, \
                      radius_range_m=(20.0, 500.0), minimum_route_m=5000.0, fixed_exponent=0.5, significance=0.05, limit_share=0.9, \
                      coding='sum_to_zero')"
)]
pub(crate) fn fit_curve_speed<'py>(
    py: Python<'py>,
    curves: &Bound<'py, PyAny>,
    columns: Option<BTreeMap<String, String>>,
    base: Option<&Bound<'py, PyStudy>>,
    tobit: bool,
    reference_radius_m: f64,
    radius_range_m: (f64, f64),
    minimum_route_m: f64,
    fixed_exponent: f64,
    significance: f64,
    limit_share: f64,
    coding: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let options = CurveSpeedOptions {
        reference_radius_m,
        radius_range_m: radius_range_m.into(),
        minimum_route_m,
        fixed_exponent,
        significance,
        limit_share,
        coding: one_of("coding", coding, &CODINGS)?,
    };
    let mappings = mappings(columns)?;
    let (curves, base) = (input(curves, "curves")?, &base_model(base));
    let request = CurveSpeedRequest { curves, mappings, base, options, tobit };
    let fitted = py.detach(|| ask_curve_speed(&request));
    answer(py, &fitted.map_err(|error| exception(&error))?)
}

const CODINGS: [(&str, Coding); 2] =
    [("sum_to_zero", Coding::SumToZero), ("treatment", Coding::Treatment)];

/// The study that keeps what is not fitted.
pub(crate) fn base_model(base: Option<&Bound<PyStudy>>) -> StudyModel {
    match base {
        Some(study) => study.get().loaded().model.clone(),
        None => study::load("field-truck", &[] as &[&str]).expect("a built-in study is one").model,
    }
}

/// Fit accelerations and decelerations at changes of the speed limit: log-normal laws.
///
/// Parameters
/// ----------
/// table : table, str or os.PathLike, or a list of these
///     One row a speed change: ``acceleration_mps2`` (m/s², negative for slowing down), and where known ``category`` and
///     ``driver`` (or ``truck``). Or logs: ``time_s``, ``speed_mps`` or ``speed_kmh``, ``limit_mps`` or ``limit_kmh``. Any
///     table that speaks Arrow, a dictionary of columns, or a CSV file.
/// columns : dict of str to str, optional
///     Which column of a log is what, such as ``{"speed_mph": "gps_speed"}``.
/// base : Study, optional
///     The study that keeps what was not measured; ``field-truck`` by default.
/// untruncated : bool
///     Take the study from the laws with the thresholds in their likelihood.
/// window_s : float
///     Length of the window with the largest change of speed in a log, in s.
/// smallest_acceleration_mps2 : float
///     Smallest acceleration that counts as a change, in m/s².
/// smallest_deceleration_mps2 : float
///     Smallest deceleration that counts as a change, as a positive number, in m/s².
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc fit speed-change --json``: ``acceleration``, ``deceleration``, ``by_category`` and others;
///     ``study`` is the part of a study that follows from it.
///
/// Raises
/// ------
/// ValueError
///     Where a column is missing or a cell is wrong, where no speed change is left, or where an option is out of its range.
/// OSError
///     Where a file cannot be read.
///
/// Warns
/// -----
/// UserWarning
///     Where no acceleration or no deceleration was measured, and where cells of a log are no numbers.
///
/// Notes
/// -----
/// a = a₀ exp(e), e normal: Romano, Godio, Bruzelius, Johannesson.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> fit = ocmc.fit_speed_change({"acceleration_mps2": [0.4, 0.5, 0.8, -0.5, -0.6, -0.9]})
/// >>> round(fit["acceleration"]["median_mps2"], 3), fit["deceleration"]["n"]
/// (0.543, 3)
/// >>> study = ocmc.Study({"study": {"base": "field-truck"}} | fit["study"])
#[pyfunction]
#[pyo3(
    signature = (
        table, *, columns=None, base=None, untruncated=false, window_s=3.0, smallest_acceleration_mps2=0.2,
        smallest_deceleration_mps2=0.4
    ),
    text_signature = "(table, *, columns=None, base=None, untruncated=False, window_s=3.0, \
                      smallest_acceleration_mps2=0.2, smallest_deceleration_mps2=0.4)"
)]
pub(crate) fn fit_speed_change<'py>(
    py: Python<'py>,
    table: &Bound<'py, PyAny>,
    columns: Option<BTreeMap<String, String>>,
    base: Option<&Bound<'py, PyStudy>>,
    untruncated: bool,
    window_s: f64,
    smallest_acceleration_mps2: f64,
    smallest_deceleration_mps2: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let options = SpeedChangeOptions {
        window_s,
        smallest_acceleration_mps2,
        smallest_deceleration_mps2,
        ..SpeedChangeOptions::default()
    };
    let mappings = mappings(columns)?;
    let (tables, base) = (&inputs(table, "table")?[..], &base_model(base));
    let request = SpeedChangeRequest { tables, mappings, base, options, untruncated };
    let fitted =
        warned(py, |warn| watched(py, None, |watch| ask_speed_change(&request, warn, watch)))?;
    answer(py, &fitted)
}

//! Fits: from measurements to the numbers of a study.

use crate::error::{curve_fit_error, table_error};
use crate::input::{Input, input};
use crate::study::PyStudy;
use ocmc_cli::{Answer, curve_speed_answer};
use ocmc_core::fit::curve_speed::{Coding, CurveSpeedOptions, fit};
use ocmc_io::column_file::ColumnFile;
use ocmc_io::curve_table;
use ocmc_io::study;
use pyo3::exceptions::{PyUserWarning, PyValueError};
use pyo3::prelude::*;
use std::ffi::CString;
use std::path::Path;

/// An answer as ``ocmc.Answer``, and its warnings as warnings.
pub(crate) fn answer<'py>(py: Python<'py>, answer: &Answer) -> PyResult<Bound<'py, PyAny>> {
    for warning in &answer.warnings {
        warn(py, warning)?;
    }
    let content = py.import("json")?.call_method1("loads", (answer.json.to_string(),))?;
    py.import("ocmc._answer")?.call_method1("Answer", (content, &answer.text))
}

/// Something that has to be known, as a warning.
pub(crate) fn warn(py: Python, text: &str) -> PyResult<()> {
    let text = CString::new(text.replace('\0', " ")).expect("no zeros are left");
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1)
}

/// Fit the curve speeds of drivers: regression, analysis of variance, population.
///
/// Parameters
/// ----------
/// curves : table, str or os.PathLike
///     One row a curve: ``driver`` (or ``truck``), ``radius_m`` (m), ``speed_mps`` (m/s), and where known ``direction``
///     (``left`` or ``right``), ``route_length_m`` (m), ``speed_limit_mps`` (m/s). Any table that speaks Arrow, a
///     dictionary of columns, or a CSV file.
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
        curves, *, base=None, tobit=false, reference_radius_m=250.0, radius_range_m=(20.0, 500.0),
        minimum_route_m=5000.0, fixed_exponent=0.5, significance=0.05, limit_share=0.9, coding="sum_to_zero"
    ),
    text_signature = "(curves, *, base=None, tobit=False, reference_radius_m=250.0, radius_range_m=(20.0, 500.0), \
                      minimum_route_m=5000.0, fixed_exponent=0.5, significance=0.05, limit_share=0.9, \
                      coding='sum_to_zero')"
)]
pub(crate) fn fit_curve_speed<'py>(
    py: Python<'py>,
    curves: &Bound<'py, PyAny>,
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
    let coding = match coding {
        "sum_to_zero" => Coding::SumToZero,
        "treatment" => Coding::Treatment,
        other => {
            let allowed = "sum_to_zero, treatment";
            let text = format!("`coding` is {other:?}, allowed is one of: {allowed}");
            return Err(PyValueError::new_err(text));
        }
    };
    let options = CurveSpeedOptions {
        reference_radius_m,
        radius_range_m: radius_range_m.into(),
        minimum_route_m,
        fixed_exponent,
        significance,
        limit_share,
        coding,
    };
    let table = match input(curves, "curves")? {
        Input::File(path) => py.detach(|| curve_table::read(&path)),
        Input::Text(text) => py.detach(|| {
            curve_table::read_columns(ColumnFile::new(Path::new("curves"), text.as_slice())?)
        }),
    };
    let table = table.map_err(|error| table_error(&error))?;
    let model = match base {
        Some(study) => study.get().loaded().model.clone(),
        None => study::load("field-truck", &[] as &[&str]).expect("a built-in study is one").model,
    };
    let answered = py.detach(|| {
        let fit = fit(&table, &options).map_err(|error| curve_fit_error(&error))?;
        let best = if tobit { fit.tobit.as_ref() } else { Some(&fit.estimated) };
        let best = best.ok_or_else(|| {
            PyValueError::new_err(
                "`tobit` needs a column speed_limit_mps, and curves below the limit that determine the regression",
            )
        })?;
        let population = fit.population(best, &model.driver.curve_speed);
        Ok::<Answer, PyErr>(curve_speed_answer(&fit, &population, table.driver.len()))
    })?;
    answer(py, &answered)
}

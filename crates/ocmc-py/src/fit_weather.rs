//! The fit of weather: from hourly records to the numbers of a study.

use crate::answer::answer;
use crate::error::exception;
use crate::fit::base_model;
use crate::input::input;
use crate::log::mappings;
use crate::study::PyStudy;
use crate::value::utc_offset;
use ocmc_api::WeatherRequest;
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// Fit the climate of hourly records.
///
/// Parameters
/// ----------
/// table : table, str or os.PathLike
///     One row an hour: ``time`` (such as ``2024-03-01T14:00``, the place's standard time) or ``time_s`` (from a midnight of
///     1 January), and any of ``temperature_k`` or ``temperature_c``, ``pressure_pa`` or ``pressure_hpa``, ``relative_humidity``
///     (0 to 1) or ``relative_humidity_percent``, ``precipitation_mps`` or ``precipitation_mm_per_h``, ``wind_speed_mps``,
///     ``wind_direction_rad`` or ``wind_direction_deg``. Any table that speaks Arrow, a dictionary of columns, or a CSV file.
/// columns : dict of str to str, optional
///     Which column is what, such as ``{"time": "stamp"}``.
/// base : Study, optional
///     The study that keeps what was not recorded; ``field-truck`` by default.
/// utc_offset_h : float, optional
///     Hours by which the place's standard time is ahead of UTC. Times in UTC need it; times with another offset are taken at that of
///     the first row without it.
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc fit weather --json``: ``parameters``, ``hours``, ``years`` and others; ``study`` is the part of a
///     study that follows from it.
///
/// Raises
/// ------
/// ValueError
///     Where a column is missing or a cell is wrong, or where the records do not determine the climate.
/// OSError
///     Where the file cannot be read.
///
/// Warns
/// -----
/// UserWarning
///     Where the records do not tell something, which then stays as in the base study.
///
/// Notes
/// -----
/// Harmonics of year and day, autoregressions, a chain of wet hours, Weibull winds: the guide's page on it has the list.
///
/// Examples
/// --------
/// >>> import numpy as np, ocmc
/// >>> time = 3600.0 * np.arange(4 * 8766)
/// >>> day = 2 * np.pi * time / 86400
/// >>> noise = np.random.default_rng(1).normal(size=time.size)
/// >>> year = 2 * np.pi * time / 86400 / 365.25
/// >>> table = {"time_s": time, "temperature_c": 8 - 9 * np.cos(year) - 2 * np.cos(day) + noise}
/// >>> import warnings
/// >>> with warnings.catch_warnings():
/// ...     warnings.simplefilter("ignore")  # only temperatures were recorded
/// ...     fit = ocmc.fit_weather(table)
/// >>> round(fit["study"]["weather"]["temperature"]["mean_k"])
/// 281
#[pyfunction]
#[pyo3(signature = (table, *, columns=None, base=None, utc_offset_h=None))]
pub(crate) fn fit_weather<'py>(
    py: Python<'py>,
    table: &Bound<'py, PyAny>,
    columns: Option<BTreeMap<String, String>>,
    base: Option<&Bound<'py, PyStudy>>,
    utc_offset_h: Option<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let mappings = mappings(columns)?;
    let utc_offset_h = utc_offset_h.map(utc_offset).transpose()?;
    let (table, base) = (input(table, "table")?, &base_model(base));
    let request = WeatherRequest { table, mappings, base, utc_offset_h };
    let fitted = py.detach(|| ocmc_api::fit_weather(&request));
    answer(py, &fitted.map_err(|error| exception(&error))?)
}

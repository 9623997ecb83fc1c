//! The fit of traffic: from measured densities to the numbers of a study.

use crate::answer::answer;
use crate::error::exception;
use crate::fit::base_model;
use crate::input::input;
use crate::log::mappings;
use crate::study::PyStudy;
use crate::value::utc_offset;
use ocmc_api::TrafficRequest;
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// Fit traffic densities by the hour and road type.
///
/// Parameters
/// ----------
/// table : table, str or os.PathLike
///     One row a measurement: ``road_type``, ``time`` (such as ``2024-03-01T14:00``) or ``time_s`` (from a midnight), one of
///     ``density_share`` (of the density of standing traffic), ``density_per_m`` (vehicles per m and lane) and ``speed_ratio``
///     (of the free speed), and, where there are several of a type, ``site``. Any table that speaks Arrow, a dictionary of
///     columns, or a CSV file.
/// columns : dict of str to str, optional
///     Which column is what, such as ``{"time": "stamp"}``.
/// base : Study, optional
///     The study that keeps what was not measured; ``field-truck`` by default.
/// utc_offset_h : float, optional
///     Hours by which the place's standard time is ahead of UTC. Times in UTC need it; times with another offset are taken at that of
///     the first row without it.
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc fit traffic --json``: ``parameters``, ``n`` and others; ``study`` is the part of a study that
///     follows from it.
///
/// Raises
/// ------
/// ValueError
///     Where a column is missing or a cell is wrong, or where the measurements do not determine the densities.
/// OSError
///     Where the file cannot be read.
///
/// Warns
/// -----
/// UserWarning
///     Where the measurements do not tell something, which then stays as in the base study.
///
/// Notes
/// -----
/// Off-peak and peak densities with an autoregression on the logit scale: the guide's page on it has the list.
///
/// Examples
/// --------
/// >>> import numpy as np, ocmc
/// >>> time = 300.0 * np.arange(20 * 288)
/// >>> share = 0.1 * np.exp(0.2 * np.random.default_rng(1).normal(size=time.size))
/// >>> table = {"time_s": time, "road_type": ["rural"] * time.size, "density_share": share}
/// >>> import warnings
/// >>> with warnings.catch_warnings():
/// ...     warnings.simplefilter("ignore")  # noise without a correlation
/// ...     fit = ocmc.fit_traffic(table)
/// >>> round(fit["study"]["traffic"]["types"]["rural"]["off_peak_share"], 1)
/// 0.1
#[pyfunction]
#[pyo3(signature = (table, *, columns=None, base=None, utc_offset_h=None))]
pub(crate) fn fit_traffic<'py>(
    py: Python<'py>,
    table: &Bound<'py, PyAny>,
    columns: Option<BTreeMap<String, String>>,
    base: Option<&Bound<'py, PyStudy>>,
    utc_offset_h: Option<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let mappings = mappings(columns)?;
    let utc_offset_h = utc_offset_h.map(utc_offset).transpose()?;
    let (table, base) = (input(table, "table")?, &base_model(base));
    let request = TrafficRequest { table, mappings, base, utc_offset_h };
    let fitted = py.detach(|| ocmc_api::fit_traffic(&request));
    answer(py, &fitted.map_err(|error| exception(&error))?)
}

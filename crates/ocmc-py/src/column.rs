//! Columns as numpy arrays.

use numpy::PyArray1;
use ocmc_core::operating_cycle::tracks::{Track, Values};
use ocmc_core::simulation::record::{Cell, Column, Record};
use ocmc_core::simulation::trace::TableColumn;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::json;

/// One column of the records: whole numbers, numbers (NaN where there is none), or words.
pub(crate) fn column<'py>(
    py: Python<'py>,
    records: &[Record],
    column: &Column,
) -> PyResult<Bound<'py, PyAny>> {
    let cells = records.iter().map(column.get);
    match (column.get)(&Record::default()) {
        Cell::Integer(_) => Ok(PyArray1::from_iter(py, cells.map(integer)).into_any()),
        Cell::Number(_) => Ok(PyArray1::from_iter(py, cells.map(number)).into_any()),
        Cell::Outcome(_) => words(py, records.iter().map(|record| record.outcome.name()).collect()),
    }
}

fn integer(cell: Cell) -> u64 {
    if let Cell::Integer(value) = cell { value } else { 0 }
}

fn number(cell: Cell) -> f64 {
    if let Cell::Number(Some(value)) = cell { value } else { f64::NAN }
}

/// Words, as long as the longest of them.
fn words<'py>(py: Python<'py>, words: Vec<&str>) -> PyResult<Bound<'py, PyAny>> {
    py.import("numpy")?.call_method1("array", (words, "U"))
}

/// Tracks by their names, each with the keys of the command's JSON.
pub(crate) fn tracks(py: Python, tracks: Vec<Track>) -> PyResult<Bound<PyDict>> {
    let by_name = PyDict::new(py);
    for track in tracks {
        let parts = PyDict::new(py);
        parts.set_item("rule", json!(track.rule).as_str())?;
        parts.set_item("position_m", PyArray1::from_vec(py, track.position_m))?;
        let value = match track.value {
            Values::Numbers(values) => PyArray1::from_vec(py, values).into_any(),
            Values::Names(names) => words(py, names.iter().map(String::as_str).collect())?,
        };
        parts.set_item("value", value)?;
        by_name.set_item(track.name, parts)?;
    }
    Ok(by_name)
}

/// A table as a dictionary of arrays.
pub(crate) fn table(py: Python, columns: Vec<TableColumn>) -> PyResult<Bound<PyDict>> {
    let table = PyDict::new(py);
    for column in columns {
        table.set_item(column.name, PyArray1::from_vec(py, column.values))?;
    }
    Ok(table)
}

//! Columns as numpy arrays.

use numpy::PyArray1;
use ocmc_core::simulation::record::{Cell, Column, Outcome, Record};
use ocmc_core::simulation::trace::TableColumn;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

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
        Cell::Outcome(_) => {
            let words = PyList::new(py, records.iter().map(|record| record.outcome.name()))?;
            let longest = Outcome::ALL.into_iter().map(|outcome| outcome.name().len()).max();
            let kind = format!("U{}", longest.unwrap_or(1));
            py.import("numpy")?.call_method1("array", (words, kind))
        }
    }
}

fn integer(cell: Cell) -> u64 {
    if let Cell::Integer(value) = cell { value } else { 0 }
}

fn number(cell: Cell) -> f64 {
    if let Cell::Number(Some(value)) = cell { value } else { f64::NAN }
}

/// A table as a dictionary of arrays.
pub(crate) fn table(py: Python, columns: Vec<TableColumn>) -> PyResult<Bound<PyDict>> {
    let table = PyDict::new(py);
    for column in columns {
        table.set_item(column.name, PyArray1::from_vec(py, column.values))?;
    }
    Ok(table)
}

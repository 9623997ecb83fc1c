//! Tables that come in: whatever speaks Arrow, a mapping from names to columns, or a file.

use crate::value::shown;
use arrow_array::{ArrayRef, Float64Array, Int64Array, StringArray, UInt64Array};
use numpy::PyReadonlyArray1;
use ocmc_api::{GivenTable, Source};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyString, PyTuple};
use pyo3_arrow::input::AnyRecordBatch;
use std::sync::Arc;

/// A file, or a table of any library. `argument` is its name in messages.
///
/// # Errors
/// ``TypeError`` where it is neither, ``ValueError`` where its columns do not fit together.
pub(crate) fn input(table: &Bound<PyAny>, argument: &str) -> PyResult<Source> {
    if is_path(table)? {
        return Ok(Source::File(table.extract()?));
    }
    let (names, pieces) = if speaks_arrow(table)? {
        let (batches, schema) = table.extract::<AnyRecordBatch>()?.into_table()?.into_inner();
        let names = schema.fields().iter().map(|field| field.name().clone()).collect();
        (names, batches.iter().map(|batch| batch.columns().to_vec()).collect())
    } else if is_mapping(table)? {
        let (names, columns) = mapping(table, argument)?;
        (names, vec![columns])
    } else {
        let allowed = "a path, a table that speaks Arrow (pandas, polars, pyarrow, duckdb) or a dictionary of columns";
        return Err(PyTypeError::new_err(format!(
            "`{argument}` is {}, allowed is {allowed}",
            shown(table)
        )));
    };
    Ok(Source::Table(GivenTable::new(argument, names, pieces)))
}

/// One or several of what [`input`] takes.
///
/// # Errors
/// As [`input`], and ``ValueError`` where there is none.
pub(crate) fn inputs(tables: &Bound<PyAny>, argument: &str) -> PyResult<Vec<Source>> {
    let Some(tables) = sequence(tables, argument)? else {
        return Ok(vec![input(tables, argument)?]);
    };
    let named = tables.iter().enumerate();
    named.map(|(k, table)| input(table, &format!("{argument}[{k}]"))).collect()
}

/// The items of a list or a tuple; none where it is something else.
///
/// # Errors
/// ``ValueError`` where it has no items.
pub(crate) fn sequence<'py>(
    value: &Bound<'py, PyAny>,
    argument: &str,
) -> PyResult<Option<Vec<Bound<'py, PyAny>>>> {
    if !value.is_instance_of::<PyList>() && !value.is_instance_of::<PyTuple>() {
        return Ok(None);
    }
    let items = value.try_iter()?.collect::<PyResult<Vec<_>>>()?;
    if items.is_empty() {
        return Err(PyValueError::new_err(format!(
            "`{argument}` is empty, allowed is one or more"
        )));
    }
    Ok(Some(items))
}

/// Whether it names a file.
pub(crate) fn is_path(value: &Bound<PyAny>) -> PyResult<bool> {
    Ok(value.is_instance_of::<PyString>() || value.hasattr("__fspath__")?)
}

/// Whether it is a table of any library, or a mapping that may be one.
pub(crate) fn is_table(value: &Bound<PyAny>) -> PyResult<bool> {
    Ok(speaks_arrow(value)? || is_mapping(value)?)
}

fn speaks_arrow(value: &Bound<PyAny>) -> PyResult<bool> {
    Ok(value.hasattr("__arrow_c_stream__")? || value.hasattr("__arrow_c_array__")?)
}

fn is_mapping(value: &Bound<PyAny>) -> PyResult<bool> {
    Ok(value.hasattr("keys")? && value.hasattr("__getitem__")?)
}

/// Names and columns of a mapping.
fn mapping(table: &Bound<PyAny>, argument: &str) -> PyResult<(Vec<String>, Vec<ArrayRef>)> {
    let mut names: Vec<String> = Vec::new();
    let mut columns: Vec<ArrayRef> = Vec::new();
    for key in table.call_method0("keys")?.try_iter()? {
        let key = key?;
        let name: String = key.extract().map_err(|_| {
            let text = format!("`{argument}` has a column {}, allowed is a text", shown(&key));
            PyTypeError::new_err(text)
        })?;
        let column = table.get_item(&key)?;
        let array = array(&column).ok_or_else(|| {
            let what = "allowed are numbers or texts, one a row";
            let text = format!("`{argument}`: column `{name}` is {}, {what}", shown(&column));
            PyValueError::new_err(text)
        })?;
        if let Some(first) = columns.first()
            && first.len() != array.len()
        {
            let (rows, wanted) = (array.len(), first.len());
            let text = format!(
                "`{argument}`: column `{name}` has {rows} rows, `{}` has {wanted}",
                names[0]
            );
            return Err(PyValueError::new_err(text));
        }
        names.push(name);
        columns.push(array);
    }
    Ok((names, columns))
}

/// A column of a mapping: numbers where numpy sees numbers, otherwise texts. None where it is no column. A copy, since
/// Python may write into an array at any time.
fn array(column: &Bound<PyAny>) -> Option<ArrayRef> {
    let numpy = column.py().import("numpy").ok()?;
    let array = numpy.call_method1("asarray", (column,)).ok()?;
    let kind: String = array.getattr("dtype").ok()?.getattr("kind").ok()?.extract().ok()?;
    if array.getattr("ndim").ok()?.extract::<usize>().ok()? != 1 {
        return None;
    }
    let as_type = |name: &str| array.call_method1("astype", (name,)).ok();
    match kind.as_str() {
        "f" | "b" => {
            let numbers: PyReadonlyArray1<f64> = as_type("float64")?.extract().ok()?;
            let numbers = numbers.as_array();
            return Some(Arc::new(Float64Array::from_iter_values(numbers.iter().copied())));
        }
        "i" => {
            let numbers: PyReadonlyArray1<i64> = as_type("int64")?.extract().ok()?;
            return Some(Arc::new(Int64Array::from_iter_values(
                numbers.as_array().iter().copied(),
            )));
        }
        "u" => {
            let numbers: PyReadonlyArray1<u64> = as_type("uint64")?.extract().ok()?;
            return Some(Arc::new(UInt64Array::from_iter_values(
                numbers.as_array().iter().copied(),
            )));
        }
        _ => {}
    }
    let words: Vec<Option<String>> = array.call_method0("tolist").ok()?.extract().ok()?;
    Some(Arc::new(StringArray::from(words)))
}

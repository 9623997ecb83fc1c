//! Tables that come in: whatever exports Arrow, a mapping from names to columns, or a file.

use crate::error::exception;
use crate::value::{shown, wrong_type};
use arrow_array::types::{ArrowPrimitiveType, Float64Type, Int64Type, UInt64Type};
use arrow_array::{Array, ArrayRef, PrimitiveArray, StringArray};
use numpy::{Element, PyReadonlyArray1};
use ocmc_api::{GivenTable, Mapping, Source};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyString, PyTuple};
use pyo3_arrow::input::{AnyArray, AnyRecordBatch};
use std::collections::BTreeMap;
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
        let allowed = "a path, a table that exports Arrow (pandas, polars, pyarrow, duckdb) or a \
                       dictionary of columns";
        return Err(wrong_type(table, argument, allowed));
    };
    Ok(Source::Table(GivenTable::new(argument, names, pieces)))
}

/// Mappings of columns as a user states them.
pub(crate) fn mappings(columns: Option<BTreeMap<String, String>>) -> PyResult<Vec<Mapping>> {
    let mappings = Mapping::of_columns(&columns.unwrap_or_default());
    mappings.map_err(|error| exception(error.into()))
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
        let text = format!("`{argument}` is empty, allowed is one or more");
        return Err(PyValueError::new_err(text));
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

/// Whether it gives its rows in Arrow's form.
pub(crate) fn speaks_arrow(value: &Bound<PyAny>) -> PyResult<bool> {
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
            let (rows, wanted, first) = (array.len(), first.len(), &names[0]);
            let text =
                format!("`{argument}`: column `{name}` has {rows} rows, `{first}` has {wanted}");
            return Err(PyValueError::new_err(text));
        }
        names.push(name);
        columns.push(array);
    }
    Ok((names, columns))
}

/// A column of a mapping: times of whatever exports Arrow as they are, with their zone, numbers
/// where numpy sees numbers, otherwise texts, and dates as texts. None where it is no column. A
/// copy, since Python may write into an array at any time.
fn array(column: &Bound<PyAny>) -> Option<ArrayRef> {
    if let Some(times) = times(column) {
        return Some(times);
    }
    let numpy = column.py().import("numpy").ok()?;
    let array = numpy.call_method1("asarray", (column,)).ok()?;
    let kind: String = array.getattr("dtype").ok()?.getattr("kind").ok()?.extract().ok()?;
    if array.getattr("ndim").ok()?.extract::<usize>().ok()? != 1 {
        return None;
    }
    match kind.as_str() {
        "f" | "b" => numbers::<Float64Type>(&array, "float64"),
        "i" => numbers::<Int64Type>(&array, "int64"),
        "u" => numbers::<UInt64Type>(&array, "uint64"),
        _ => {
            let array = if kind == "M" {
                numpy.call_method1("datetime_as_string", (array,)).ok()?
            } else {
                array
            };
            let cells = array.call_method0("tolist").ok()?;
            let words = cells.try_iter().ok()?.map(|cell| word(&cell?));
            let words: Vec<Option<String>> = words.collect::<PyResult<_>>().ok()?;
            Some(Arc::new(StringArray::from(words)))
        }
    }
}

/// A column of times that exports Arrow and lies in one piece; numpy has no zones.
fn times(column: &Bound<PyAny>) -> Option<ArrayRef> {
    if !speaks_arrow(column).ok()? {
        return None;
    }
    let pieces = column.extract::<AnyArray>().ok()?.into_chunked_array().ok()?;
    match pieces.chunks() {
        [times] if times.data_type().is_temporal() => Some(times.clone()),
        _ => None,
    }
}

/// A cell of texts: a text, a date or a time of Python or pandas in ISO 8601, or none.
fn word(cell: &Bound<PyAny>) -> PyResult<Option<String>> {
    let word: Option<String> = if cell.hasattr("isoformat")? {
        cell.call_method0("isoformat")?.extract()?
    } else {
        cell.extract()?
    };
    Ok(word.filter(|word| word != "NaT"))
}

/// The numbers of an array of numpy, as this type of it.
fn numbers<T>(array: &Bound<PyAny>, name: &str) -> Option<ArrayRef>
where
    T: ArrowPrimitiveType<Native: Element>,
{
    let numbers: PyReadonlyArray1<T::Native> =
        array.call_method1("astype", (name,)).ok()?.extract().ok()?;
    let numbers = numbers.as_array();
    Some(Arc::new(PrimitiveArray::<T>::from_iter_values(numbers.iter().copied())))
}

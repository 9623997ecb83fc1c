//! Tables that come in: whatever speaks Arrow, a mapping from names to columns, or a file.
//!
//! A table becomes the text that the same table would have as a file, so that one reader finds columns, units, missing
//! values and faults for both. Numbers are written so that they read back as the same numbers.

use crate::value::shown;
use arrow_array::cast::AsArray;
use arrow_array::{Array, ArrayRef, Float64Array, StringArray};
use arrow_cast::cast;
use arrow_schema::DataType;
use numpy::PyReadonlyArray1;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyString;
use pyo3_arrow::input::AnyRecordBatch;
use std::path::PathBuf;
use std::sync::Arc;

/// Where a table is read from.
pub(crate) enum Input {
    /// A file.
    File(PathBuf),
    /// A table of the user, as comma-separated values.
    Text(Vec<u8>),
}

/// A file, or a table of any library. `argument` is its name in messages.
///
/// # Errors
/// ``TypeError`` where it is neither, ``ValueError`` where its columns do not fit together.
pub(crate) fn input(table: &Bound<PyAny>, argument: &str) -> PyResult<Input> {
    if table.is_instance_of::<PyString>() || table.hasattr("__fspath__")? {
        return Ok(Input::File(table.extract()?));
    }
    let (names, batches) = if table.hasattr("__arrow_c_stream__")?
        || table.hasattr("__arrow_c_array__")?
    {
        let (batches, schema) = table.extract::<AnyRecordBatch>()?.into_table()?.into_inner();
        let names = schema.fields().iter().map(|field| field.name().clone()).collect();
        (names, batches.iter().map(|batch| batch.columns().to_vec()).collect())
    } else if table.hasattr("keys")? && table.hasattr("__getitem__")? {
        let (names, columns) = mapping(table, argument)?;
        (names, vec![columns])
    } else {
        let allowed = "a path, a table that speaks Arrow (pandas, polars, pyarrow, duckdb) or a dictionary of columns";
        return Err(PyTypeError::new_err(format!(
            "`{argument}` is {}, allowed is {allowed}",
            shown(table)
        )));
    };
    Ok(Input::Text(table.py().detach(|| text(&names, &batches, argument))?))
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

/// A column of a mapping: numbers where numpy sees numbers, otherwise texts. None where it is no column.
fn array(column: &Bound<PyAny>) -> Option<ArrayRef> {
    let numpy = column.py().import("numpy").ok()?;
    let array = numpy.call_method1("asarray", (column,)).ok()?;
    let kind: String = array.getattr("dtype").ok()?.getattr("kind").ok()?.extract().ok()?;
    if array.getattr("ndim").ok()?.extract::<usize>().ok()? != 1 {
        return None;
    }
    if matches!(kind.as_str(), "f" | "i" | "u" | "b") {
        let numbers = array.call_method1("astype", ("float64",)).ok()?;
        let numbers: PyReadonlyArray1<f64> = numbers.extract().ok()?;
        return Some(Arc::new(Float64Array::from_iter_values(numbers.as_array().iter().copied())));
    }
    let words: Vec<Option<String>> = array.call_method0("tolist").ok()?.extract().ok()?;
    Some(Arc::new(StringArray::from(words)))
}

/// The table as comma-separated values.
fn text(names: &[String], batches: &[Vec<ArrayRef>], argument: &str) -> PyResult<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let into_memory = "memory takes every row of the header's length";
    if !names.is_empty() {
        writer.write_record(names).expect(into_memory);
    }
    for columns in batches {
        let cells = names.iter().zip(columns).map(|(name, column)| {
            cast(column, &DataType::Utf8).map_err(|_| {
                let found = column.data_type();
                let what = "allowed are numbers or texts";
                PyValueError::new_err(format!(
                    "`{argument}`: column `{name}` is of type {found}, {what}"
                ))
            })
        });
        let cells = cells.collect::<PyResult<Vec<ArrayRef>>>()?;
        let columns: Vec<&StringArray> = cells.iter().map(AsArray::as_string).collect();
        for row in 0..columns.first().map_or(0, |first| Array::len(*first)) {
            let cells = columns.iter().copied().map(|column: &StringArray| {
                if column.is_null(row) { "" } else { column.value(row) }
            });
            writer.write_record(cells).expect(into_memory);
        }
    }
    Ok(writer.into_inner().expect("memory takes everything"))
}

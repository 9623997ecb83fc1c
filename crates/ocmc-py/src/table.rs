//! `ocmc.Table`: columns of equal length, for all that take Arrow or numpy.

use crate::pickle::{checksum, read, stream_of};
use crate::value::shown;
use arrow_array::cast::AsArray;
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::{Float32Type, Float64Type, Int64Type, UInt64Type};
use arrow_array::{
    Array, ArrayRef, Float64Array, LargeStringArray, RecordBatch, RecordBatchIterator, StringArray,
    StringViewArray,
};
use arrow_schema::{DataType, Field, Schema, SchemaRef};
use numpy::PyArray1;
use ocmc_api::TableColumn;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyCapsule, PyDict, PyIterator, PyList};
use pyo3_arrow::PySchema;
use pyo3_arrow::error::PyArrowResult;
use pyo3_arrow::ffi::to_schema_pycapsule;
use std::sync::Arc;

/// Arguments of `unpickled_table`.
type Pickled<'py> = (Bound<'py, PyBytes>, Vec<u8>);

/// A column of numbers.
pub(crate) fn numbers(numbers: impl Iterator<Item = Option<f64>>) -> ArrayRef {
    Arc::new(numbers.collect::<Float64Array>())
}

/// A column of words.
pub(crate) fn words<'a>(words: impl Iterator<Item = Option<&'a str>>) -> ArrayRef {
    Arc::new(words.collect::<StringArray>())
}

/// A column as another type of the same kind of cells; none where a cell is lost.
fn as_type(column: &ArrayRef, to: &DataType) -> Option<ArrayRef> {
    Some(match (column.data_type(), to) {
        (own, to) if own == to => column.clone(),
        (DataType::Float64, DataType::Float32) => {
            Arc::new(column.as_primitive::<Float64Type>().unary::<_, Float32Type>(|x| x as f32))
        }
        (DataType::UInt64, DataType::Int64) => Arc::new(
            column.as_primitive::<UInt64Type>().try_unary::<_, Int64Type, _>(i64::try_from).ok()?,
        ),
        (DataType::UInt64, DataType::Float64) => {
            Arc::new(column.as_primitive::<UInt64Type>().unary::<_, Float64Type>(|n| n as f64))
        }
        (DataType::Utf8, DataType::LargeUtf8) => {
            Arc::new(column.as_string::<i32>().iter().collect::<LargeStringArray>())
        }
        (DataType::Utf8, DataType::Utf8View) => {
            Arc::new(column.as_string::<i32>().iter().collect::<StringViewArray>())
        }
        _ => return None,
    })
}

/// A table: named columns of equal length, in SI units with the unit as the name's suffix.
///
/// It speaks the Arrow PyCapsule protocol, so that ``pyarrow.table(table)``,
/// ``polars.DataFrame(table)``,
/// ``pandas.DataFrame.from_arrow(table)`` and duckdb take it as it is, without a copy.
/// `to_pandas` and `to_polars` make data frames. ``table["column"]`` is one column as a new numpy
/// array, NaN where there is no number and ``""`` where there is no word; ``dict(table)`` is all of
/// them. As in a data frame, ``len(table)`` counts rows, and iteration goes over the names of the
/// columns.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> table = ocmc.Study("field-truck").set("mission.length_m", 5000.0).trace(3)
/// >>> table.columns[:3]
/// ['time_s', 'step_s', 'position_m']
/// >>> table["speed_mps"].dtype
/// dtype('float64')
#[pyclass(name = "Table", module = "ocmc", frozen, mapping)]
#[derive(Clone)]
pub(crate) struct Table {
    pub(crate) schema: SchemaRef,
    /// Its rows, some in a batch.
    pub(crate) batches: Vec<RecordBatch>,
}

impl Table {
    /// A table of batches that have this schema.
    pub(crate) fn new(schema: SchemaRef, batches: Vec<RecordBatch>) -> Self {
        Self { schema, batches }
    }

    /// A table of named arrays of equal length; a column with nulls may hold more of them.
    pub(crate) fn of_columns(columns: Vec<(&str, ArrayRef)>) -> Self {
        let field = |(name, array): &(&str, ArrayRef)| {
            Field::new(*name, array.data_type().clone(), array.null_count() > 0)
        };
        let schema = Arc::new(Schema::new(columns.iter().map(field).collect::<Vec<_>>()));
        let arrays = columns.into_iter().map(|(_, array)| array).collect();
        let batch = RecordBatch::try_new(schema.clone(), arrays).expect("columns of equal length");
        Self::new(schema, vec![batch])
    }

    /// The same rows in another schema, where its columns are these.
    fn in_schema(&self, schema: &Schema) -> Option<Self> {
        let names =
            |fields: &Schema| fields.fields().iter().map(|f| f.name().clone()).collect::<Vec<_>>();
        if names(schema) != names(&self.schema) {
            return None;
        }
        let fields = schema.fields().iter().map(|field| field.as_ref().clone());
        let schema = Arc::new(Schema::new_with_metadata(
            fields.collect::<Vec<_>>(),
            self.schema.metadata().clone(),
        ));
        let batches = self.batches.iter().map(|batch| {
            let columns = batch.columns().iter().zip(schema.fields());
            let columns: Option<_> =
                columns.map(|(c, field)| as_type(c, field.data_type())).collect();
            RecordBatch::try_new(schema.clone(), columns?).ok()
        });
        let batches = batches.collect::<Option<_>>()?;
        Some(Self::new(schema, batches))
    }

    /// A table of numbers.
    pub(crate) fn of_numbers(columns: Vec<TableColumn>) -> Self {
        let array = |values| Arc::new(Float64Array::from(values)) as ArrayRef;
        Self::of_columns(columns.into_iter().map(|c| (c.name, array(c.values))).collect())
    }
}

/// A pickled table.
#[pyfunction]
pub(crate) fn unpickled_table(stream: &[u8], sum: &[u8]) -> PyResult<Table> {
    let (schema, batches) = read("", stream, sum)?;
    Ok(Table::new(schema, batches))
}

#[pymethods]
impl Table {
    /// Names of the columns.
    #[getter]
    pub(crate) fn columns(&self) -> Vec<&str> {
        self.schema.fields().iter().map(|field| field.name().as_str()).collect()
    }

    /// Names of the columns, so that ``dict(table)`` is a dictionary of arrays.
    ///
    /// Returns
    /// -------
    /// list of str
    ///     The same as `columns`.
    fn keys(&self) -> Vec<&str> {
        self.columns()
    }

    /// All columns as numpy arrays.
    ///
    /// Returns
    /// -------
    /// dict of str to numpy.ndarray
    ///     New arrays, one value a row.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> table = ocmc.Study("field-truck").set("mission.length_m", 5000.0).trace(3)
    /// >>> table.to_dict()["time_s"].shape == (len(table),)
    /// True
    fn to_dict<'py>(slf: &Bound<'py, Self>, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dictionary = PyDict::new(py);
        for name in slf.get().columns() {
            dictionary.set_item(name, slf.get_item(name)?)?;
        }
        Ok(dictionary)
    }

    /// The table as a data frame of pandas, null where there is no number or word.
    ///
    /// ``pandas.DataFrame(table)`` has the same rows and columns, and takes a hundred times as
    /// long: it goes row by row. Without pyarrow a word that is missing is ``""``.
    ///
    /// Returns
    /// -------
    /// pandas.DataFrame
    ///     A row for each row, and all columns.
    ///
    /// Raises
    /// ------
    /// ModuleNotFoundError
    ///     Where pandas is not installed.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> table = ocmc.Study("field-truck").set("mission.length_m", 5000.0).trace(3)
    /// >>> table.to_pandas().shape == (len(table), len(table.columns))
    /// True
    pub(crate) fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("ocmc._frame")?.call_method1("to_pandas", (slf,))
    }

    /// The table as a data frame of polars, which shares its memory.
    ///
    /// Returns
    /// -------
    /// polars.DataFrame
    ///     A row for each row, and all columns; null where there is no number or word.
    ///
    /// Raises
    /// ------
    /// ModuleNotFoundError
    ///     Where polars is not installed.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> table = ocmc.Study("field-truck").set("mission.length_m", 5000.0).trace(3)
    /// >>> table.to_polars().shape == (len(table), len(table.columns))
    /// True
    pub(crate) fn to_polars<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("ocmc._frame")?.call_method1("to_polars", (slf,))
    }

    /// The rows for numpy, each an object with the columns as attributes:
    /// ``pandas.DataFrame(table)`` makes rows of them, and not a column of names.
    #[pyo3(signature = (dtype=None, copy=None))]
    pub(crate) fn __array__<'py>(
        slf: &Bound<'py, Self>,
        dtype: Option<Bound<'py, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("ocmc._frame")?.call_method1("rows", (slf, dtype, copy))
    }

    pub(crate) fn __getitem__<'py>(
        &self,
        py: Python<'py>,
        column: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let name = column.extract::<String>().ok();
        let place = name.and_then(|name| self.schema.index_of(&name).ok()).ok_or_else(|| {
            PyKeyError::new_err(format!("no column {}; `columns` lists them", shown(column)))
        })?;
        let parts = || self.batches.iter().map(|batch| batch.column(place));
        match self.schema.field(place).data_type() {
            // numpy's integers have no NaN
            DataType::UInt64 if parts().any(|part| part.null_count() > 0) => {
                let counts = parts().flat_map(|part| part.as_primitive::<UInt64Type>().iter());
                let numbers = counts.map(|count| count.map_or(f64::NAN, |count| count as f64));
                Ok(PyArray1::from_vec(py, numbers.collect()).into_any())
            }
            DataType::UInt64 => {
                let counts = parts().flat_map(|part| part.as_primitive::<UInt64Type>().values());
                Ok(PyArray1::from_vec(py, counts.copied().collect()).into_any())
            }
            DataType::Float64 => {
                let numbers = parts().flat_map(|part| part.as_primitive::<Float64Type>().iter());
                let numbers = numbers.map(|number| number.unwrap_or(f64::NAN));
                Ok(PyArray1::from_vec(py, numbers.collect()).into_any())
            }
            _ => {
                let words = parts().flat_map(|part| part.as_string::<i32>().iter());
                let words =
                    PyList::new(py, words.map(Option::unwrap_or_default).collect::<Vec<_>>())?;
                py.import("numpy")?.call_method1("array", (words, "U"))
            }
        }
    }

    pub(crate) fn __contains__(&self, column: &Bound<PyAny>) -> bool {
        column.extract::<String>().is_ok_and(|name| self.schema.index_of(&name).is_ok())
    }

    pub(crate) fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        PyList::new(py, self.columns())?.try_iter()
    }

    pub(crate) fn __len__(&self) -> usize {
        self.batches.iter().map(RecordBatch::num_rows).sum()
    }

    fn _ipython_key_completions_(&self) -> Vec<&str> {
        self.columns()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Pickled<'py>)> {
        let stream = PyBytes::new(py, &py.detach(|| stream_of(&self.schema, &self.batches))?);
        let sum = checksum("", stream.as_bytes());
        Ok((py.import("ocmc._ocmc")?.getattr("unpickled_table")?, (stream, sum)))
    }

    fn __repr__(&self) -> String {
        let columns = self.columns();
        let shown = columns.iter().take(4).copied().collect::<Vec<_>>().join(", ");
        let more = if columns.len() > 4 { ", …" } else { "" };
        format!("<ocmc.Table of {} rows, {} columns: {shown}{more}>", self.__len__(), columns.len())
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("ocmc._display")?.call_method1("table", (slf,))
    }

    /// The schema, for all that take Arrow.
    pub(crate) fn __arrow_c_schema__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyArrowResult<Bound<'py, PyCapsule>> {
        to_schema_pycapsule(py, self.schema.as_ref())
    }

    /// The rows, for all that take Arrow: shared, not copied.
    #[pyo3(signature = (requested_schema=None))]
    pub(crate) fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyCapsule>>,
    ) -> PyArrowResult<Bound<'py, PyCapsule>> {
        let requested =
            requested_schema.as_ref().map(PySchema::from_arrow_pycapsule).transpose()?;
        // the protocol lets a producer keep its own schema where it cannot meet another one
        let met = requested.and_then(|schema| self.in_schema(&schema.into_inner()));
        let Self { schema, batches } = met.unwrap_or_else(|| self.clone());
        let rows = RecordBatchIterator::new(batches.into_iter().map(Ok), schema);
        let stream = FFI_ArrowArrayStream::new(Box::new(rows));
        Ok(PyCapsule::new_with_value(py, stream, c"arrow_array_stream")?)
    }
}

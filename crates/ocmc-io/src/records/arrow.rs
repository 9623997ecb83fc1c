//! Records as Arrow tables: what Parquet files hold and what Python receives.

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, UInt64Type};
use arrow_array::{Array, ArrayRef, Float64Array, RecordBatch, StringArray, UInt64Array};
use arrow_schema::{DataType, Field, Schema, SchemaRef};
use ocmc_core::simulation::record::{COLUMNS, Cell, Column, Outcome, Record};
use serde::Deserialize;
use serde::de::value::{Error, MapDeserializer, StrDeserializer};
use serde::de::{Deserializer, Error as _, IntoDeserializer, Visitor};
use serde::forward_to_deserialize_any;
use std::sync::Arc;

/// The schema of the records: counts are integers, quantities are numbers or null, the outcome is a word.
pub fn schema() -> SchemaRef {
    let blank = Record::default();
    let field = |column: &Column| match (column.get)(&blank) {
        Cell::Integer(_) => Field::new(column.name, DataType::UInt64, false),
        Cell::Number(_) => Field::new(column.name, DataType::Float64, true),
        Cell::Outcome(_) => Field::new(column.name, DataType::Utf8, false),
    };
    Arc::new(Schema::new(COLUMNS.iter().map(field).collect::<Vec<_>>()))
}

/// Records as one table.
pub fn record_batch(records: &[Record]) -> RecordBatch {
    let schema = schema();
    let columns = COLUMNS.iter().zip(schema.fields()).map(|(column, field)| {
        let cells = records.iter().map(column.get);
        match field.data_type() {
            DataType::UInt64 => {
                Arc::new(UInt64Array::from_iter_values(cells.map(integer))) as ArrayRef
            }
            DataType::Float64 => Arc::new(cells.map(number).collect::<Float64Array>()),
            _ => Arc::new(StringArray::from_iter_values(cells.map(word))),
        }
    });
    let columns = columns.collect();
    RecordBatch::try_new(schema, columns).expect("every column has its type and length")
}

fn integer(cell: Cell) -> u64 {
    if let Cell::Integer(value) = cell { value } else { 0 }
}

fn number(cell: Cell) -> Option<f64> {
    if let Cell::Number(value) = cell { value } else { None }
}

fn word(cell: Cell) -> &'static str {
    if let Cell::Outcome(outcome) = cell { outcome.name() } else { "" }
}

/// The records of a table. Columns are found by their names, in any order; others are ignored.
///
/// # Errors
/// Names the column that is missing, or whose type or value is no quantity of a record.
pub fn records(batch: &RecordBatch) -> Result<Vec<Record>, Error> {
    let columns: Vec<(&str, &ArrayRef)> = COLUMNS
        .iter()
        .filter_map(|column| Some((column.name, batch.column_by_name(column.name)?)))
        .collect();
    (0..batch.num_rows())
        .map(|row| {
            let mut cells = Vec::with_capacity(columns.len());
            for (name, array) in &columns {
                let cell = cell(array, row);
                cells.push((
                    *name,
                    Value(cell.map_err(|e| Error::custom(format!("column `{name}`: {e}")))?),
                ));
            }
            Record::deserialize(MapDeserializer::new(cells.into_iter()))
                .map_err(|error| Error::custom(format!("row {}: {error}", row + 1)))
        })
        .collect()
}

/// One value of an array.
fn cell(array: &ArrayRef, row: usize) -> Result<Cell, String> {
    match array.data_type() {
        _ if array.is_null(row) => Ok(Cell::Number(None)),
        DataType::UInt64 => Ok(Cell::Integer(array.as_primitive::<UInt64Type>().value(row))),
        DataType::Float64 => Ok(Cell::Number(Some(array.as_primitive::<Float64Type>().value(row)))),
        DataType::Utf8 => {
            let name = array.as_string::<i32>().value(row);
            let outcome = Outcome::ALL.into_iter().find(|outcome| outcome.name() == name);
            outcome.map(Cell::Outcome).ok_or_else(|| format!("`{name}` is no outcome"))
        }
        other => Err(format!("type {other} is not that of a record")),
    }
}

/// A cell on its way into a field of a record.
struct Value(Cell);

impl IntoDeserializer<'_> for Value {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> Deserializer<'de> for Value {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.0 {
            Cell::Integer(value) => visitor.visit_u64(value),
            Cell::Number(Some(value)) => visitor.visit_f64(value),
            Cell::Number(None) => visitor.visit_unit(),
            Cell::Outcome(outcome) => visitor.visit_str(outcome.name()),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.0 {
            Cell::Number(None) => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let Cell::Outcome(outcome) = self.0 else {
            return Err(Error::custom(format!("`{name}` has to be a word")));
        };
        let word: StrDeserializer<Error> = outcome.name().into_deserializer();
        word.deserialize_enum(name, variants, visitor)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct
        newtype_struct seq tuple tuple_struct map struct identifier ignored_any
    }
}

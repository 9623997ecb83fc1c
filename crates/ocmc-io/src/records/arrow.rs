//! Records as Arrow tables: what Parquet files hold and what Python receives.

use super::{CHARGING_EVENTS, charging_text};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, UInt64Type};
use arrow_array::{Array, ArrayRef, Float64Array, RecordBatch, StringArray, UInt64Array};
use arrow_schema::{DataType, Field, Schema, SchemaRef};
use ocmc_core::breakdown::{Breakdown, BreakdownColumns};
use ocmc_core::charging::ChargingEvent;
use ocmc_core::record::{COLUMNS, Cell, Column, Outcome, Record, own_columns};
use serde::Deserialize;
use serde::de::value::{Error, SeqDeserializer, StrDeserializer};
use serde::de::{Deserializer, Error as _, IntoDeserializer, Visitor};
use serde::forward_to_deserialize_any;
use serde_json::Value as Json;
use std::sync::Arc;

/// The schema of records such as this one: that of all records, and the columns that it has beside
/// these: of its breakdown and of its chargings.
pub(super) fn schema_like(record: Option<&Record>) -> SchemaRef {
    let Some(record) = record else { return schema() };
    schema_with(record.breakdown.names(), record.charging_events.is_some())
}

/// The schema of the records of a study without a breakdown.
pub fn schema() -> SchemaRef {
    schema_with(&[], false)
}

/// The schema of the records: counts are integers, null where a cycle may lack them, quantities are
/// numbers or null, the outcome is a word.
fn schema_with(breakdown: &[String], has_chargings: bool) -> SchemaRef {
    let blank = Record::default();
    let field = |column: &Column| match column.get(&blank) {
        Cell::Integer(value) => Field::new(column.name, DataType::UInt64, value.is_none()),
        Cell::Number(_) => Field::new(column.name, DataType::Float64, true),
        Cell::Outcome(_) => Field::new(column.name, DataType::Utf8, false),
    };
    let parts = breakdown.iter().map(|name| Field::new(name, DataType::Float64, true));
    let chargings = has_chargings.then(|| Field::new(CHARGING_EVENTS, DataType::Utf8, true));
    Arc::new(Schema::new(
        COLUMNS.iter().map(field).chain(parts).chain(chargings).collect::<Vec<_>>(),
    ))
}

/// Records as one table, with the columns of the first one.
pub fn record_batch(records: &[Record]) -> RecordBatch {
    record_batch_like(records.first(), records)
}

/// Records as one table, with the columns of records such as `like`.
pub(super) fn record_batch_like(like: Option<&Record>, records: &[Record]) -> RecordBatch {
    let schema = schema_like(like);
    let columns = COLUMNS.iter().zip(schema.fields()).map(|(column, field)| {
        let cells = records.iter().map(|record| column.get(record));
        match field.data_type() {
            DataType::UInt64 => Arc::new(cells.map(integer).collect::<UInt64Array>()) as ArrayRef,
            DataType::Float64 => Arc::new(cells.map(number).collect::<Float64Array>()),
            _ => Arc::new(StringArray::from_iter_values(cells.map(word))),
        }
    });
    let names = like.map_or(&[][..], |like| like.breakdown.names());
    let parts = (0..names.len()).map(|k| {
        let alike = |record: &&Record| record.breakdown.names() == names;
        let value = |record: &Record| Some(record).filter(alike)?.breakdown.value(k);
        Arc::new(records.iter().map(value).collect::<Float64Array>()) as ArrayRef
    });
    let has_chargings = like.is_some_and(|like| like.charging_events.is_some());
    let chargings = has_chargings
        .then(|| Arc::new(records.iter().map(charging_text).collect::<StringArray>()) as ArrayRef);
    let columns = columns.chain(parts).chain(chargings).collect();
    RecordBatch::try_new(schema, columns).expect("every column has its type and length")
}

pub(crate) fn integer(cell: Cell) -> Option<u64> {
    if let Cell::Integer(value) = cell { value } else { None }
}

pub(crate) fn number(cell: Cell) -> Option<f64> {
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
    // in the order in which a record is made of a sequence; null is what it may lack
    let blank = serde_json::to_value(Record::default()).map_err(Error::custom)?;
    let fields: Vec<(&String, &Json)> = blank.as_object().into_iter().flatten().collect();
    let known = fields.iter().map(|(name, _)| cells(batch, name));
    let known = known.collect::<Result<Vec<_>, _>>()?;
    let own = own_columns().iter().map(|column| cells(batch, column.name));
    let own = own.collect::<Result<Vec<_>, _>>()?;
    let breakdown = breakdown_of(batch);
    let names = breakdown.iter().flat_map(|columns| columns.names());
    let parts = names.map(|name| cells(batch, name)).collect::<Result<Vec<_>, _>>()?;
    let chargings = chargings_of(batch)?;
    let record = |row: usize| {
        let values = known.iter().map(|cells| Value(cells[row]));
        let mut record = Record::deserialize(SeqDeserializer::new(values)).map_err(|error| {
            // a null where there has to be a value
            let gap = known.iter().zip(&fields).find(|(cells, (_, value))| {
                !value.is_null() && matches!(cells[row], Cell::Number(None) | Cell::Integer(None))
            });
            let gap = gap.map_or_else(String::new, |(_, (name, _))| format!(" in column `{name}`"));
            Error::custom(format!("row {}: {error}{gap}", row + 1))
        })?;
        for (own, cells) in record.own_columns.iter_mut().zip(&own) {
            *own = number(cells[row]);
        }
        if let Some(columns) = &breakdown {
            let values = parts.iter().map(|cells| number(cells[row])).collect();
            record.breakdown = Breakdown::new(Arc::clone(columns), values);
        }
        if let Some(text) = chargings.filter(|texts| texts.is_valid(row)) {
            record.charging_events = Some(charging_events(text.value(row), row + 1)?);
        }
        Ok(record)
    };
    (0..batch.num_rows()).map(record).collect()
}

/// The column of chargings, where there is one.
fn chargings_of(batch: &RecordBatch) -> Result<Option<&StringArray>, Error> {
    let Some(array) = batch.column_by_name(CHARGING_EVENTS) else { return Ok(None) };
    let wrong = || {
        let other = array.data_type();
        Error::custom(format!("column `{CHARGING_EVENTS}`: type {other} is not that of a record"))
    };
    array.as_string_opt::<i32>().map(Some).ok_or_else(wrong)
}

fn charging_events(text: &str, row: usize) -> Result<Vec<ChargingEvent>, Error> {
    super::charging_events(text)
        .map_err(|error| Error::custom(format!("row {row}: column `{CHARGING_EVENTS}`: {error}")))
}

/// The breakdown that a table has.
fn breakdown_of(batch: &RecordBatch) -> Option<Arc<BreakdownColumns>> {
    let schema = batch.schema_ref();
    BreakdownColumns::among(&schema.fields().iter().map(|field| field.name().as_str()))
}

/// A table of records as [`record_batch`] has it: columns in its order, others left out.
///
/// # Errors
/// As [`records`], of names and types alone.
pub fn in_our_order(batch: &RecordBatch) -> Result<RecordBatch, Error> {
    let breakdown = breakdown_of(batch);
    let names = breakdown.as_ref().map_or(&[][..], |columns| columns.names());
    let schema = schema_with(names, batch.column_by_name(CHARGING_EVENTS).is_some());
    let column = |field: &Arc<Field>| column(batch, field.name()).map(Arc::clone);
    let columns = schema.fields().iter().map(column).collect::<Result<_, _>>()?;
    RecordBatch::try_new(schema, columns).map_err(Error::custom)
}

fn column<'a>(batch: &'a RecordBatch, name: &str) -> Result<&'a ArrayRef, Error> {
    let missing = || Error::custom(format!("there is no column `{name}`"));
    batch.column_by_name(name).ok_or_else(missing)
}

/// The cells of a column.
fn cells(batch: &RecordBatch, name: &str) -> Result<Vec<Cell>, Error> {
    let array = column(batch, name)?;
    match array.data_type() {
        DataType::UInt64 => {
            Ok(array.as_primitive::<UInt64Type>().iter().map(Cell::Integer).collect())
        }
        DataType::Float64 => {
            Ok(array.as_primitive::<Float64Type>().iter().map(Cell::Number).collect())
        }
        DataType::Utf8 => {
            let outcomes = array.as_string::<i32>().iter().map(|word| {
                let word = word.unwrap_or_default();
                let outcome = Outcome::ALL.into_iter().find(|outcome| outcome.name() == word);
                let none = || Error::custom(format!("column `{name}`: `{word}` is no outcome"));
                outcome.map(Cell::Outcome).ok_or_else(none)
            });
            outcomes.collect()
        }
        other => {
            Err(Error::custom(format!("column `{name}`: type {other} is not that of a record")))
        }
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
            Cell::Integer(Some(value)) => visitor.visit_u64(value),
            Cell::Number(Some(value)) => visitor.visit_f64(value),
            Cell::Integer(None) | Cell::Number(None) => visitor.visit_unit(),
            Cell::Outcome(outcome) => visitor.visit_enum(StrDeserializer::new(outcome.name())),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.0 {
            Cell::Integer(None) | Cell::Number(None) => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit
        unit_struct newtype_struct seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::records::examples;

    #[test]
    fn columns_are_found_in_any_order() {
        let rows = examples::records(10);
        let batch = record_batch(&rows);
        let places: Vec<usize> = (0..batch.num_columns()).rev().collect();
        let turned = batch.project(&places).expect("all columns");
        assert!(records(&turned).expect("all are there") == rows);
        assert_eq!(in_our_order(&turned).expect("all are there"), batch);
    }

    #[test]
    fn every_column_is_needed() {
        let batch = record_batch(&examples::records(10));
        for column in COLUMNS {
            let schema = batch.schema();
            let others =
                (0..batch.num_columns()).filter(|k| schema.field(*k).name() != column.name);
            let without = batch.project(&others.collect::<Vec<_>>()).expect("the others");
            let named = format!("`{}`", column.name);
            assert!(records(&without).expect_err("needed").to_string().contains(&named));
            assert!(in_our_order(&without).expect_err("needed").to_string().contains(&named));
        }
    }

    #[test]
    fn wrong_values_name_their_place() {
        let batch = record_batch(&examples::records(3));
        let with = |name: &str, array: ArrayRef| {
            let ours = batch.schema();
            let fields = ours.fields().iter().map(|field| {
                let data_type =
                    if field.name() == name { array.data_type() } else { field.data_type() };
                Field::new(field.name(), data_type.clone(), true)
            });
            let schema = Arc::new(Schema::new(fields.collect::<Vec<_>>()));
            let column = |(k, column): (usize, &ArrayRef)| {
                Arc::clone(if ours.field(k).name() == name { &array } else { column })
            };
            let columns = batch.columns().iter().enumerate().map(column).collect();
            let batch = RecordBatch::try_new(schema, columns).expect("three rows");
            records(&batch).expect_err("wrong").to_string()
        };
        let null: ArrayRef = Arc::new(Float64Array::from(vec![Some(1.0), None, Some(1.0)]));
        let error = with("distance_m", null);
        assert!(error.contains("row 2") && error.contains("`distance_m`"), "{error}");
        let many: ArrayRef = Arc::new(UInt64Array::from(vec![1, 1 << 40, 1]));
        let error = with("n_stops", many);
        assert!(error.contains("row 2") && error.contains("1099511627776"), "{error}");
        let words: ArrayRef = Arc::new(StringArray::from(vec!["completed", "flown", "stalled"]));
        let error = with("outcome", words);
        assert!(error.contains("`outcome`") && error.contains("`flown`"), "{error}");
    }
}

//! Truck-years in files: one row a truck and year, a column for each total and each quantity.

use crate::records::RecordFormat;
use arrow_array::{ArrayRef, Float64Array, RecordBatch, UInt64Array};
use arrow_schema::{DataType, Field, Schema};
use ocmc_core::fleet::truck_year::{TRUCK_COLUMNS, TruckColumn, TruckTime};
use ocmc_core::record::Cell;
use parquet::arrow::ArrowWriter;
use parquet::errors::ParquetError;
use std::io::Write;
use std::sync::Arc;

/// Name of the file beside records of that format.
pub fn file_name(format: RecordFormat) -> &'static str {
    match format {
        RecordFormat::Parquet => "trucks.parquet",
        RecordFormat::Csv => "trucks.csv",
    }
}

/// Truck-years as one table: integers and numbers, null for what a powertrain does not have.
pub fn record_batch(trucks: &[TruckTime]) -> RecordBatch {
    let blank = TruckTime::default();
    let column = |column: &TruckColumn| -> (Field, ArrayRef) {
        let cells = trucks.iter().map(|truck| column.get(truck));
        if let Cell::Integer(_) = column.get(&blank) {
            let values: UInt64Array = cells.map(integer).collect();
            (Field::new(column.name, DataType::UInt64, false), Arc::new(values))
        } else {
            let values: Float64Array = cells.map(number).collect();
            (Field::new(column.name, DataType::Float64, true), Arc::new(values))
        }
    };
    let (fields, columns): (Vec<Field>, Vec<ArrayRef>) = TRUCK_COLUMNS.iter().map(column).unzip();
    let schema = Arc::new(Schema::new(fields));
    RecordBatch::try_new(schema, columns).expect("every column has its type and length")
}

fn integer(cell: Cell) -> Option<u64> {
    if let Cell::Integer(value) = cell { value } else { None }
}

fn number(cell: Cell) -> Option<f64> {
    if let Cell::Number(value) = cell { value } else { None }
}

/// The bytes of a file of truck-years: a function of its rows alone.
pub(crate) fn encoded(trucks: &[TruckTime], format: RecordFormat) -> Vec<u8> {
    match format {
        RecordFormat::Parquet => parquet(trucks).expect("memory takes every table"),
        RecordFormat::Csv => csv(trucks),
    }
}

fn parquet(trucks: &[TruckTime]) -> Result<Vec<u8>, ParquetError> {
    let table = record_batch(trucks);
    let properties = crate::records::parquet::properties();
    let mut file = ArrowWriter::try_new(Vec::new(), table.schema(), Some(properties))?;
    file.write(&table)?;
    file.into_inner()
}

fn csv(trucks: &[TruckTime]) -> Vec<u8> {
    let names: Vec<&str> = TRUCK_COLUMNS.iter().map(|column| column.name).collect();
    let mut text = (names.join(",") + "\n").into_bytes();
    for truck in trucks {
        let cells = TRUCK_COLUMNS.iter().map(|column| match column.get(truck) {
            Cell::Integer(Some(value)) => value.to_string(),
            // the shortest that reads back as the same number
            Cell::Number(Some(value)) => format!("{value:?}"),
            _ => String::new(),
        });
        let cells: Vec<String> = cells.collect();
        writeln!(text, "{}", cells.join(",")).expect("memory takes every text");
    }
    text
}

//! Truck-years in files: one row a truck and year, a column for each total and each quantity.

use crate::records::arrow::{integer, number};
use arrow_array::{ArrayRef, Float64Array, RecordBatch, UInt64Array};
use arrow_schema::{DataType, Field, Schema};
use ocmc_core::record::Cell;
use ocmc_fleet::truck_column::{TRUCK_COLUMNS, TruckColumn};
use ocmc_fleet::truck_year::TruckTime;
use std::sync::Arc;

/// Name of the table.
pub(crate) const TRUCKS: &str = "trucks";

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

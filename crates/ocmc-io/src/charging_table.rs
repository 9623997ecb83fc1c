//! Charging in files: one row for each charging of a trip, and load curves, one row for each kind
//! of chargers and quarter of an hour.

use crate::records::{GROUP_ROWS, RecordFormat, RecordsError};
use crate::table_file::TableWriter;
use arrow_array::{ArrayRef, Float64Array, RecordBatch, StringArray, UInt64Array};
use ocmc_core::charging::ChargingEvent;
use ocmc_core::record::Record;
use ocmc_fleet::load::Load;
use std::path::Path;
use std::sync::Arc;

/// Name of the table of chargings.
pub(crate) const CHARGINGS: &str = "chargings";
/// Name of the table of load curves.
pub(crate) const LOADS: &str = "loads";

/// Load curves as one table.
pub fn loads_batch(loads: &[Load]) -> RecordBatch {
    let number = |value_of: fn(&Load) -> f64| numbers(loads.iter().map(value_of));
    let count = |value_of: fn(&Load) -> u64| counts(loads.iter().map(value_of));
    table(vec![
        ("place", words(loads.iter().map(|load| load.place.name()))),
        ("quarter_hour", count(|load| load.quarter_hour)),
        ("mean_power_w", number(|load| load.mean_power_w)),
        ("p50_power_w", number(|load| load.p50_power_w)),
        ("p95_power_w", number(|load| load.p95_power_w)),
        ("highest_power_w", number(|load| load.highest_power_w)),
        ("days", count(|load| load.days)),
    ])
}

/// The chargings of trips as one table.
pub fn chargings_batch(records: &[Record]) -> RecordBatch {
    let mut rows: Vec<(&Record, &ChargingEvent)> = Vec::new();
    for record in records {
        rows.extend(record.charging_events.iter().flatten().map(|event| (record, event)));
    }
    batch(&rows)
}

/// Chargings with the records of their trips as one table.
fn batch(rows: &[(&Record, &ChargingEvent)]) -> RecordBatch {
    let number = |value_of: fn(&ChargingEvent) -> f64| {
        numbers(rows.iter().map(|(_, event)| value_of(event)))
    };
    let count = |value_of: fn(&Record) -> u64| counts(rows.iter().map(|(trip, _)| value_of(trip)));
    let by_the_clock = rows.iter().map(|(trip, event)| trip.departure_s_of_year + event.begin_s);
    table(vec![
        ("cycle_id", count(|trip| trip.cycle_id)),
        ("truck_id", count(|trip| trip.truck_id)),
        ("trip", count(|trip| trip.trip)),
        ("place", words(rows.iter().map(|(_, event)| event.place.name()))),
        ("position_m", number(|event| event.position_m)),
        ("arrival_s", number(|event| event.arrival_s)),
        ("wait_s", number(|event| event.wait_s)),
        ("begin_s", number(|event| event.begin_s)),
        ("begin_s_of_year", numbers(by_the_clock)),
        ("charging_s", number(|event| event.charging_s)),
        ("begin_charge", number(|event| event.begin_charge)),
        ("end_charge", number(|event| event.end_charge)),
        ("charged_energy_j", number(|event| event.charged_energy_j)),
        ("grid_energy_j", number(|event| event.grid_energy_j)),
        ("peak_power_w", number(|event| event.peak_power_w)),
    ])
}

fn table(columns: Vec<(&str, ArrayRef)>) -> RecordBatch {
    RecordBatch::try_from_iter(columns).expect("columns of equal length")
}

fn numbers(values: impl Iterator<Item = f64>) -> ArrayRef {
    Arc::new(Float64Array::from_iter_values(values))
}

fn counts(values: impl Iterator<Item = u64>) -> ArrayRef {
    Arc::new(UInt64Array::from_iter_values(values))
}

fn words<'a>(values: impl Iterator<Item = &'a str>) -> ArrayRef {
    Arc::new(StringArray::from_iter_values(values))
}

/// Writes the chargings of trips to a new file, in groups of rows.
#[derive(Debug)]
pub(crate) struct ChargingsWriter {
    file: TableWriter,
    /// Trips whose chargings are not written yet, and how many these are.
    waiting: Vec<Record>,
    rows: usize,
}

impl ChargingsWriter {
    /// Creates the file, which must not exist.
    pub(crate) fn create(path: &Path, format: RecordFormat) -> Result<Self, RecordsError> {
        let file = TableWriter::create(path, format, batch(&[]).schema())?;
        Ok(Self { file, waiting: Vec::new(), rows: 0 })
    }

    /// Takes the next records: a group has the chargings of whole trips.
    pub(crate) fn add(&mut self, records: &[Record]) -> Result<(), RecordsError> {
        for record in records {
            let events = record.charging_events.as_ref().map_or(0, Vec::len);
            if events == 0 {
                continue;
            }
            self.rows += events;
            self.waiting.push(record.clone());
            if self.rows >= GROUP_ROWS {
                self.write()?;
            }
        }
        Ok(())
    }

    fn write(&mut self) -> Result<(), RecordsError> {
        let written = self.file.add(&chargings_batch(&self.waiting));
        self.waiting.clear();
        self.rows = 0;
        written
    }

    /// Writes what is left and completes the file.
    pub(crate) fn finish(mut self) -> Result<(), RecordsError> {
        if self.rows > 0 {
            self.write()?;
        }
        self.file.finish()
    }
}

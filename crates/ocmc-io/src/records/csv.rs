//! Records as comma-separated values: shortest decimals that read back as the same numbers, an
//! empty cell for null.

use super::{CHARGING_EVENTS, GROUP_ROWS, Group, RecordsError, charging_events, charging_text};
use crate::file_error::FileError;
use ocmc_core::breakdown::{Breakdown, BreakdownColumns};
use ocmc_core::record::{COLUMNS, Cell, Record, own_columns};
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

/// Rows on their way into a file, and the line above the first of them.
#[derive(Debug)]
pub struct Text {
    like: Option<Box<Record>>,
    rows: Vec<u8>,
}

impl Text {
    /// No rows yet, of records such as this one.
    pub(super) fn new(like: Option<Box<Record>>) -> Self {
        Self { like, rows: Vec::new() }
    }

    /// Adds rows.
    pub(super) fn add(&mut self, records: &[Record]) {
        write_rows(&mut self.rows, self.like.as_deref(), records)
            .expect("memory takes every record");
    }

    /// The names of the columns.
    pub(super) fn header(&self) -> String {
        let names = COLUMNS.iter().map(|column| column.name.to_owned());
        let like = self.like.as_deref();
        let parts = like.map_or(&[][..], |like| like.breakdown.names());
        let parts = parts.iter().map(|name| quoted(name));
        let chargings = like.filter(|like| like.charging_events.is_some());
        let chargings = chargings.map(|_| CHARGING_EVENTS.to_owned());
        let names: Vec<String> = names.chain(parts).chain(chargings).collect();
        names.join(",") + "\n"
    }

    /// The rows.
    pub(super) fn rows(&self) -> &[u8] {
        &self.rows
    }
}

/// A name as a field: in quotes where it has to be, as that of a road type may.
fn quoted(name: &str) -> String {
    if name.contains(['"', ',', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}

/// Writes rows, with the columns of records such as `like`. Neither numbers nor names of outcomes
/// ever need quotes.
fn write_rows(out: &mut impl Write, like: Option<&Record>, records: &[Record]) -> io::Result<()> {
    let parts = like.map_or(&[][..], |like| like.breakdown.names());
    let has_chargings = like.is_some_and(|like| like.charging_events.is_some());
    for record in records {
        for (k, column) in COLUMNS.iter().enumerate() {
            if k > 0 {
                out.write_all(b",")?;
            }
            match column.get(record) {
                Cell::Integer(Some(value)) => write!(out, "{value}")?,
                // the Debug form is the shortest that reads back as the same number, with an
                // exponent where it is large or small
                Cell::Number(Some(value)) => write!(out, "{value:?}")?,
                Cell::Integer(None) | Cell::Number(None) => (),
                Cell::Outcome(outcome) => out.write_all(outcome.name().as_bytes())?,
            }
        }
        let is_alike = record.breakdown.names() == parts;
        for k in 0..parts.len() {
            out.write_all(b",")?;
            if let Some(value) = record.breakdown.value(k).filter(|_| is_alike) {
                write!(out, "{value:?}")?;
            }
        }
        if has_chargings {
            let text = charging_text(record).unwrap_or_default();
            write!(out, ",{}", quoted(&text))?;
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

/// Reads records, a group at a time. Columns are found by their names, in any order.
pub fn read(path: &Path, file: File, mut sink: impl FnMut(Group)) -> Result<(), RecordsError> {
    let mut sink = |records| sink(Group { records, batch: None });
    let mut reader = csv::Reader::from_reader(file);
    let failed = |error| read_error(path, error);
    let headers = reader.headers().map_err(failed)?.clone();
    let place = |name: &str| headers.iter().position(|header| header == name);
    if let Some(column) = COLUMNS.iter().find(|column| place(column.name).is_none()) {
        let reason = format!("there is no column `{}`", column.name);
        return Err(RecordsError::Malformed(path.to_owned(), reason));
    }
    let own_places: Vec<Option<usize>> =
        own_columns().iter().map(|column| place(column.name)).collect();
    let breakdown = BreakdownColumns::among(&headers.iter());
    let names = breakdown.iter().flat_map(|columns| columns.names());
    let part_places: Vec<Option<usize>> = names.map(|name| place(name)).collect();
    let chargings_place = place(CHARGING_EVENTS);
    let mut group = Vec::new();
    for row in reader.records() {
        let row = row.map_err(failed)?;
        let mut record: Record = row.deserialize(Some(&headers)).map_err(failed)?;
        let number = |place: &Option<usize>| -> Result<Option<f64>, RecordsError> {
            let cell = place.and_then(|k| row.get(k)).filter(|cell| !cell.is_empty());
            cell.map(str::parse).transpose().map_err(|error| {
                let reason = format!("cycle {}: {error}", record.cycle_id);
                RecordsError::Malformed(path.to_owned(), reason)
            })
        };
        let own: Vec<Option<f64>> = own_places.iter().map(number).collect::<Result<_, _>>()?;
        if let Some(columns) = &breakdown {
            let values = part_places.iter().map(number).collect::<Result<_, _>>()?;
            record.breakdown = Breakdown::new(Arc::clone(columns), values);
        }
        let text = chargings_place.and_then(|k| row.get(k)).filter(|text| !text.is_empty());
        record.charging_events = text.map(charging_events).transpose().map_err(|error| {
            let reason = format!("cycle {}: `{CHARGING_EVENTS}`: {error}", record.cycle_id);
            RecordsError::Malformed(path.to_owned(), reason)
        })?;
        record.own_columns.copy_from_slice(&own);
        group.push(record);
        if group.len() == GROUP_ROWS {
            sink(std::mem::take(&mut group));
        }
    }
    if !group.is_empty() {
        sink(group);
    }
    Ok(())
}

fn read_error(path: &Path, error: csv::Error) -> RecordsError {
    let reason = error.to_string();
    match error.into_kind() {
        csv::ErrorKind::Io(source) => FileError::read(path)(source).into(),
        _ => RecordsError::Malformed(path.to_owned(), reason),
    }
}

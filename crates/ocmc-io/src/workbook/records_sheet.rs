//! Tables of Arrow as sheets: the records, one row a cycle, and the trucks.

use super::package::Package;
use super::sheet::{Cell, MOST_CHARACTERS, Sheet};
use super::{RECORDS, WorkbookError};
use crate::file_error::FileError;
use crate::records::arrow::schema;
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, UInt64Type};
use arrow_array::{Array, ArrayRef, RecordBatch};
use arrow_schema::{DataType, SchemaRef};
use std::io::{self, Seek, Write};
use std::path::Path;

/// Most bytes of a cell of a number, about.
const CELL_BYTES: u64 = 64;

/// The sheet of the records, which is written as they come.
pub(super) struct Records<'a, W: Write + Seek> {
    file: &'a Path,
    state: State<W>,
    schema: SchemaRef,
    rows: u64,
}

enum State<W: Write + Seek> {
    /// The first records say what columns there are.
    New(Package<W>),
    Begun(Sheet<Package<W>>),
    /// It could not be begun.
    Failed,
}

impl<'a, W: Write + Seek> Records<'a, W> {
    /// Sheet of records of a workbook that begins with it. `file` is where it is written, `rows`
    /// how many will come.
    pub(super) fn new(file: &'a Path, out: W, rows: u64) -> Self {
        Self { file, state: State::New(Package::new(out)), schema: schema(), rows }
    }

    /// Writes the next records.
    pub(super) fn add(&mut self, records: &RecordBatch) -> Result<(), WorkbookError> {
        check_texts(records)?;
        if matches!(self.state, State::New(_)) {
            self.schema = records.schema();
        }
        let written = begun(&mut self.state, &self.schema, self.rows)
            .and_then(|sheet| add_rows(sheet, &self.schema, records));
        Ok(written.map_err(FileError::write(self.file))?)
    }

    /// Ends the sheet.
    pub(super) fn finish(mut self) -> Result<Package<W>, WorkbookError> {
        let begun = begun(&mut self.state, &self.schema, self.rows).map(|_| ());
        let ended = begun.and_then(|()| match self.state {
            State::Begun(sheet) => sheet.end(),
            State::New(_) | State::Failed => Err(not_begun()),
        });
        Ok(ended.map_err(FileError::write(self.file))?)
    }
}

/// The sheet, begun where it is not.
fn begun<'a, W: Write + Seek>(
    state: &'a mut State<W>,
    schema: &SchemaRef,
    rows: u64,
) -> io::Result<&'a mut Sheet<Package<W>>> {
    *state = match std::mem::replace(state, State::Failed) {
        State::New(package) => State::Begun(begin(package, RECORDS, schema, rows)?),
        other => other,
    };
    match state {
        State::Begun(sheet) => Ok(sheet),
        State::New(_) | State::Failed => Err(not_begun()),
    }
}

fn not_begun() -> io::Error {
    io::Error::other("it could not be begun")
}

/// Writes a table as a sheet.
pub(super) fn add_table<W: Write + Seek>(
    package: Package<W>,
    name: &'static str,
    table: &RecordBatch,
) -> io::Result<Package<W>> {
    let schema = table.schema();
    let rows = table.num_rows() as u64;
    let mut sheet = begin(package, name, &schema, rows)?;
    add_rows(&mut sheet, &schema, table)?;
    sheet.end()
}

fn begin<W: Write + Seek>(
    package: Package<W>,
    name: &'static str,
    schema: &SchemaRef,
    rows: u64,
) -> io::Result<Sheet<Package<W>>> {
    let names = schema.fields().iter().map(|field| field.name().as_str());
    let bytes = CELL_BYTES * rows * schema.fields().len() as u64;
    package.sheet(name, names, &[], bytes)
}

/// Writes the rows of a table; a column that it lacks stays empty.
fn add_rows<W: Write>(
    sheet: &mut Sheet<W>,
    schema: &SchemaRef,
    table: &RecordBatch,
) -> io::Result<()> {
    let columns: Vec<Option<&ArrayRef>> =
        schema.fields().iter().map(|field| table.column_by_name(field.name())).collect();
    for row in 0..table.num_rows() {
        sheet.row(
            columns.iter().map(|column| column.map_or(Cell::Empty, |column| cell(column, row))),
        )?;
    }
    Ok(())
}

/// A cell of a table, empty where there is nothing.
fn cell(column: &ArrayRef, row: usize) -> Cell<'_> {
    if column.is_null(row) {
        return Cell::Empty;
    }
    match column.data_type() {
        DataType::UInt64 => Cell::Integer(column.as_primitive::<UInt64Type>().value(row)),
        DataType::Float64 => Cell::Number(column.as_primitive::<Float64Type>().value(row)),
        _ => column.as_string::<i32>().value(row).into(),
    }
}

/// Checks that each text of the records fits into a cell.
fn check_texts(records: &RecordBatch) -> Result<(), WorkbookError> {
    let schema = records.schema();
    for (field, column) in schema.fields().iter().zip(records.columns()) {
        let Some(texts) = column.as_string_opt::<i32>() else { continue };
        let lengths = texts.iter().map(|text| text.map_or(0, |text| text.encode_utf16().count()));
        let Some((row, length)) = lengths.enumerate().find(|(_, length)| *length > MOST_CHARACTERS)
        else {
            continue;
        };
        let ids = records.column_by_name("cycle_id");
        let id = ids.and_then(|ids| ids.as_primitive_opt::<UInt64Type>());
        let cycle_id = id.map_or(row as u64, |ids| ids.value(row));
        return Err(WorkbookError::LongText { cycle_id, column: field.name().clone(), length });
    }
    Ok(())
}

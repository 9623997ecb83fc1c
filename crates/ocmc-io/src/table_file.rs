//! Tables beside the records of a run, in the format of these: integers, numbers and words.

use crate::file_error::FileError;
use crate::records::{RecordFormat, RecordsError, parquet};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, UInt64Type};
use arrow_array::{Array, ArrayRef, RecordBatch};
use arrow_schema::{DataType, SchemaRef};
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file of a table that is written batch by batch.
#[derive(Debug)]
pub(crate) struct TableWriter {
    path: PathBuf,
    file: TableFile<File>,
}

#[derive(Debug)]
enum TableFile<W: Write + Send> {
    Parquet(parquet::TableFile<W>),
    Csv(BufWriter<W>),
}

impl<W: Write + Send> TableFile<W> {
    fn begin(out: W, format: RecordFormat, schema: SchemaRef) -> io::Result<Self> {
        match format {
            RecordFormat::Parquet => parquet::TableFile::begin(out, schema).map(Self::Parquet),
            RecordFormat::Csv => {
                let mut file = BufWriter::new(out);
                let names: Vec<&str> = schema.fields().iter().map(|f| f.name().as_str()).collect();
                writeln!(file, "{}", names.join(","))?;
                Ok(Self::Csv(file))
            }
        }
    }

    fn add(&mut self, batch: &RecordBatch) -> io::Result<()> {
        match self {
            Self::Parquet(file) => file.add(batch),
            Self::Csv(file) => write_rows(file, batch),
        }
    }

    fn end(self) -> io::Result<W> {
        match self {
            Self::Parquet(file) => file.end(),
            Self::Csv(file) => Ok(file.into_inner()?),
        }
    }
}

impl TableWriter {
    /// Creates the file, which must not exist.
    pub(crate) fn create(
        path: &Path,
        format: RecordFormat,
        schema: SchemaRef,
    ) -> Result<Self, RecordsError> {
        let file = OpenOptions::new().write(true).create_new(true).open(path);
        let file = file.map_err(FileError::create(path))?;
        let file = TableFile::begin(file, format, schema).map_err(FileError::write(path))?;
        Ok(Self { path: path.to_owned(), file })
    }

    /// Writes a batch: in Parquet a row group.
    pub(crate) fn add(&mut self, batch: &RecordBatch) -> Result<(), RecordsError> {
        Ok(self.file.add(batch).map_err(FileError::write(&self.path))?)
    }

    /// Completes the file and makes sure that it is on the disk.
    pub(crate) fn finish(self) -> Result<(), RecordsError> {
        let finished = self.file.end().and_then(|file| file.sync_all());
        Ok(finished.map_err(FileError::write(&self.path))?)
    }
}

/// The bytes of a file of one table: a function of its rows alone.
pub(crate) fn encoded(table: &RecordBatch, format: RecordFormat) -> Vec<u8> {
    let written = TableFile::begin(Vec::new(), format, table.schema()).and_then(|mut file| {
        file.add(table)?;
        file.end()
    });
    written.expect("memory takes every table")
}

/// Rows as comma-separated values. No word of them ever needs quotes.
fn write_rows(out: &mut impl Write, table: &RecordBatch) -> io::Result<()> {
    for row in 0..table.num_rows() {
        for (k, column) in table.columns().iter().enumerate() {
            if k > 0 {
                out.write_all(b",")?;
            }
            write_cell(out, column, row)?;
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

/// One cell, empty where there is nothing.
fn write_cell(out: &mut impl Write, column: &ArrayRef, row: usize) -> io::Result<()> {
    if column.is_null(row) {
        return Ok(());
    }
    match column.data_type() {
        DataType::UInt64 => write!(out, "{}", column.as_primitive::<UInt64Type>().value(row)),
        // the shortest that reads back as the same number
        DataType::Float64 => {
            write!(out, "{:?}", column.as_primitive::<Float64Type>().value(row))
        }
        _ => out.write_all(column.as_string::<i32>().value(row).as_bytes()),
    }
}

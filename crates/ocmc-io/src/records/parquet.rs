//! Records as Apache Parquet: a row group for each group of rows, compressed by zstd.

use super::arrow::{in_our_order, record_batch, records, schema};
use super::{GROUP_ROWS, Group, RecordsError};
use crate::file_error::FileError;
use ocmc_core::record::Record;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::{Compression, ZstdLevel};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::schema::types::ColumnPath;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::thread;

/// Groups that are decompressed ahead.
const GROUPS_AHEAD: usize = 4;

/// A Parquet file of records that is being written.
#[derive(Debug)]
pub struct ParquetRecords {
    path: PathBuf,
    writer: ArrowWriter<File>,
}

impl ParquetRecords {
    /// Begins the file.
    pub fn new(path: &Path, file: File) -> Result<Self, RecordsError> {
        let writer = ArrowWriter::try_new(file, schema(), Some(properties()));
        let writer = writer.map_err(|error| write_error(path, error))?;
        Ok(Self { path: path.to_owned(), writer })
    }

    /// Writes one row group.
    pub fn write(&mut self, records: &[Record]) -> Result<(), RecordsError> {
        let written = self.writer.write(&record_batch(records)).and_then(|()| self.writer.flush());
        written.map_err(|error| write_error(&self.path, error))
    }

    /// Writes the footer and makes sure that the file is on the disk.
    pub fn finish(mut self) -> Result<(), RecordsError> {
        let path = &self.path;
        self.writer.finish().map_err(|error| write_error(path, error))?;
        let synced = self.writer.inner().sync_all();
        Ok(synced.map_err(FileError::write(path))?)
    }
}

fn properties() -> WriterProperties {
    WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_max_row_group_row_count(Some(GROUP_ROWS))
        .set_max_row_group_bytes(None)
        // numbers of different cycles are hardly ever the same
        .set_dictionary_enabled(false)
        .set_column_dictionary_enabled(ColumnPath::from("outcome"), true)
        .build()
}

fn write_error(path: &Path, error: ParquetError) -> RecordsError {
    FileError::write(path)(io_error(error)).into()
}

/// The operating system's error where there is one, so that a full disk is called a full disk.
fn io_error(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(source) => {
            source.downcast::<io::Error>().map_or_else(io::Error::other, |error| *error)
        }
        other => io::Error::other(other),
    }
}

/// Reads records, a group at a time: one thread decompresses the next groups while this one takes
/// those before.
pub fn read(path: &Path, file: File, mut sink: impl FnMut(Group)) -> Result<(), RecordsError> {
    let malformed = |reason: String| RecordsError::Malformed { path: path.to_owned(), reason };
    let builder = ParquetRecordBatchReaderBuilder::try_new(file);
    let builder = builder.map_err(|error| malformed(error.to_string()))?;
    let reader = builder.with_batch_size(GROUP_ROWS).build();
    let reader = reader.map_err(|error| malformed(error.to_string()))?;
    thread::scope(|scope| {
        let (sender, batches) = mpsc::sync_channel(GROUPS_AHEAD);
        scope.spawn(move || {
            for batch in reader {
                if sender.send(batch).is_err() {
                    return;
                }
            }
        });
        for batch in batches {
            let batch = batch.map_err(|error| malformed(error.to_string()))?;
            let records = records(&batch).map_err(|error| malformed(error.to_string()))?;
            let batch = in_our_order(&batch).map_err(|error| malformed(error.to_string()))?;
            sink(Group { records, batch: Some(batch) });
        }
        Ok(())
    })
}

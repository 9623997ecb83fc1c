//! Records as Apache Parquet: a row group for each group of rows, compressed by zstd.

use super::arrow::{in_our_order, record_batch, records, schema_of};
use super::{GROUP_ROWS, Group, RecordsError};
use ocmc_core::record::Record;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::{Compression, ZstdLevel};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::schema::types::ColumnPath;
use std::error::Error;
use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::mpsc;
use std::thread;

/// Groups that are decompressed ahead.
const GROUPS_AHEAD: usize = 4;

/// Begins a file of records such as these.
pub(super) fn begin(file: File, records: &[Record]) -> io::Result<ArrowWriter<File>> {
    ArrowWriter::try_new(file, schema_of(records), Some(properties())).map_err(io_error)
}

/// Writes one row group.
pub(super) fn write_group(file: &mut ArrowWriter<File>, records: &[Record]) -> io::Result<()> {
    file.write(&record_batch(records)).and_then(|()| file.flush()).map_err(io_error)
}

/// Writes the footer.
pub(super) fn end(file: &mut ArrowWriter<File>) -> io::Result<()> {
    file.finish().map(drop).map_err(io_error)
}

pub(crate) fn properties() -> WriterProperties {
    WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_max_row_group_row_count(Some(GROUP_ROWS))
        .set_max_row_group_bytes(None)
        // numbers of different cycles are hardly ever the same
        .set_dictionary_enabled(false)
        .set_column_dictionary_enabled(ColumnPath::from("outcome"), true)
        .set_column_dictionary_enabled(ColumnPath::from("place"), true)
        .build()
}

/// The operating system's error where there is one, so that a full disk is called a full disk.
pub(crate) fn io_error(error: ParquetError) -> io::Error {
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
    let malformed = |error: &dyn Error| RecordsError::Malformed(path.to_owned(), error.to_string());
    let undecodable =
        |_| RecordsError::Malformed(path.to_owned(), "it cannot be decoded".to_owned());
    let open = move || {
        let builder = ParquetRecordBatchReaderBuilder::try_new(file);
        builder.and_then(|builder| builder.with_batch_size(GROUP_ROWS).build())
    };
    // the library ends some damaged files by a panic, not by an error: here and below
    let reader = thread::spawn(open).join().map_err(undecodable)?;
    let reader = reader.map_err(|error| malformed(&error))?;
    thread::scope(|scope| {
        let (sender, batches) = mpsc::sync_channel(GROUPS_AHEAD);
        let decoder = scope.spawn(move || {
            for batch in reader {
                if sender.send(batch).is_err() {
                    return;
                }
            }
        });
        let taken: Result<(), RecordsError> = batches.into_iter().try_for_each(|batch| {
            let batch = batch.map_err(|error| malformed(&error))?;
            let records = records(&batch).map_err(|error| malformed(&error))?;
            let batch = in_our_order(&batch).map_err(|error| malformed(&error))?;
            sink(Group { records, batch: Some(batch) });
            Ok(())
        });
        let decoded = decoder.join();
        taken?;
        decoded.map_err(undecodable)
    })
}

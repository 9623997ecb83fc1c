//! Records and other tables as Apache Parquet: a row group for each group of rows.

use super::arrow::{in_our_order, record_batch_like, records, schema_like};
use super::{Compression, GROUP_ROWS, Group, RecordsError};
use arrow_array::cast::AsArray;
use arrow_array::{Array, ArrayRef, RecordBatch, RecordBatchReader, StringArray};
use arrow_schema::{DataType, FieldRef, Schema, SchemaRef};
use ocmc_core::record::Record;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::arrow::arrow_writer::{ArrowColumnChunk, ArrowRowGroupWriterFactory, compute_leaves};
use parquet::basic::{Compression as Codec, ZstdLevel};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::ColumnPath;
use std::error::Error;
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::sync::{Arc, mpsc};
use std::thread;

/// A file that takes row groups.
pub(super) type GroupsFile = SerializedFileWriter<File>;

/// Groups that are decompressed ahead.
const GROUPS_AHEAD: usize = 4;

/// Records that become a row group.
pub(super) struct RowGroupEncoder {
    like: Option<Box<Record>>,
    compression: Compression,
    parts: Vec<RecordBatch>,
}

impl RowGroupEncoder {
    /// No rows yet, of records such as this one.
    pub(super) fn new(like: Option<Box<Record>>, compression: Compression) -> Self {
        Self { like, compression, parts: Vec::new() }
    }

    /// Adds rows.
    pub(super) fn add(&mut self, records: &[Record]) {
        if !records.is_empty() {
            self.parts.push(record_batch_like(self.like.as_deref(), records));
        }
    }

    /// The row group; it has no columns where there are no rows.
    pub(super) fn finish(self) -> RowGroup {
        let schema = schema_like(self.like.as_deref());
        let fields = schema.fields().iter().enumerate().filter(|_| !self.parts.is_empty());
        let columns = fields.map(|(k, field)| {
            let parts = self.parts.iter().map(|part| part.column(k));
            encoded(field, parts, self.compression).expect("a column of the schema, in memory")
        });
        RowGroup { columns: columns.collect(), schema }
    }
}

/// A column of a row group, of what its parts have. One after the other: what encodes a column has
/// contexts of its own for the compression, which together are larger than the values.
fn encoded<'a>(
    field: &FieldRef,
    parts: impl Iterator<Item = &'a ArrayRef>,
    compression: Compression,
) -> Result<ArrowColumnChunk, ParquetError> {
    let schema = Arc::new(Schema::new([Arc::clone(field)]));
    let (_, row_groups) = writer(io::sink(), &schema, compression)?;
    let [mut column] = <[_; 1]>::try_from(row_groups.create_column_writers(0)?)
        .map_err(|_| ParquetError::General("a column of ours is a leaf".to_owned()))?;
    let mut write = |part: &ArrayRef| {
        compute_leaves(field, part)?.iter().try_for_each(|leaf| column.write(leaf))
    };
    if *field.data_type() == DataType::Utf8 {
        // a page of texts ends where a part does
        let texts = parts.flat_map(AsArray::as_string::<i32>);
        write(&(Arc::new(texts.collect::<StringArray>()) as ArrayRef))?;
    } else {
        parts.into_iter().try_for_each(write)?;
    }
    column.close()
}

/// A row group on its way into a file.
#[derive(Debug)]
pub struct RowGroup {
    schema: SchemaRef,
    columns: Vec<ArrowColumnChunk>,
}

impl RowGroup {
    /// Begins a file of row groups such as this one.
    pub(super) fn begin(&self, file: File) -> io::Result<GroupsFile> {
        let file = writer(file, &self.schema, Compression::Zstd);
        file.map(|(file, _)| file).map_err(io_error)
    }

    /// Writes it behind the others.
    pub(super) fn append_to(self, file: &mut GroupsFile) -> io::Result<()> {
        if self.columns.is_empty() {
            return Ok(());
        }
        let append = || {
            let mut group = file.next_row_group()?;
            self.columns
                .into_iter()
                .try_for_each(|column| column.append_to_row_group(&mut group))?;
            group.close()
        };
        append().map(drop).map_err(io_error)
    }
}

/// A file of tables of that schema, and what encodes its row groups.
fn writer<W: Write + Send>(
    file: W,
    schema: &SchemaRef,
    compression: Compression,
) -> Result<(SerializedFileWriter<W>, ArrowRowGroupWriterFactory), ParquetError> {
    ArrowWriter::try_new(file, Arc::clone(schema), Some(properties(compression)))?
        .into_serialized_writer()
}

/// Writes the footer, and makes sure that the file is on the disk.
pub(super) fn end(file: &mut GroupsFile) -> io::Result<()> {
    file.finish().map_err(io_error)?;
    file.inner().sync_all()
}

/// A file of a table that is written batch by batch, each of which is a row group.
#[derive(Debug)]
pub(crate) struct TableFile<W: Write + Send>(Box<ArrowWriter<W>>);

impl<W: Write + Send> TableFile<W> {
    /// Begins it.
    pub(crate) fn begin(out: W, schema: SchemaRef) -> io::Result<Self> {
        let file = ArrowWriter::try_new(out, schema, Some(properties(Compression::Zstd)));
        file.map(|file| Self(Box::new(file))).map_err(io_error)
    }

    /// Writes a batch.
    pub(crate) fn add(&mut self, batch: &RecordBatch) -> io::Result<()> {
        self.0.write(batch).and_then(|()| self.0.flush()).map_err(io_error)
    }

    /// Writes the footer.
    pub(crate) fn end(self) -> io::Result<W> {
        self.0.into_inner().map_err(io_error)
    }
}

/// Names of columns, and columns in pieces.
pub(crate) type Columns = (Vec<String>, Vec<Vec<ArrayRef>>);

/// Reads a table of any program, or says what is wrong with it.
pub(crate) fn columns(file: File) -> Result<Columns, String> {
    // the library ends some damaged files by a panic, not by an error
    let decoded = thread::spawn(move || decoded(file)).join();
    decoded.unwrap_or_else(|_| Err("it cannot be decoded".to_owned()))
}

fn decoded(file: File) -> Result<Columns, String> {
    let reader = ParquetRecordBatchReaderBuilder::try_new(file)
        .and_then(ParquetRecordBatchReaderBuilder::build)
        .map_err(|error| error.to_string())?;
    let names = reader.schema().fields().iter().map(|field| field.name().clone()).collect();
    let mut pieces = Vec::new();
    for batch in reader {
        pieces.push(batch.map_err(|error| error.to_string())?.columns().to_vec());
    }
    pieces.retain(|piece| piece.first().is_some_and(|column| !column.is_empty()));
    Ok((names, pieces))
}

fn properties(compression: Compression) -> WriterProperties {
    let codec = match compression {
        Compression::Zstd => Codec::ZSTD(ZstdLevel::default()),
        Compression::Snappy => Codec::SNAPPY,
    };
    WriterProperties::builder()
        .set_compression(codec)
        .set_max_row_group_row_count(Some(GROUP_ROWS))
        .set_max_row_group_bytes(None)
        // numbers of different cycles are hardly ever the same
        .set_dictionary_enabled(false)
        .set_column_dictionary_enabled(ColumnPath::from("outcome"), true)
        .set_column_dictionary_enabled(ColumnPath::from("place"), true)
        .build()
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

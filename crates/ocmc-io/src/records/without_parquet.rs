//! Stand-in for Apache Parquet in a program that is built without: each file of it is refused.

use super::{Compression, Group, RecordsError};
use arrow_array::{ArrayRef, RecordBatch};
use arrow_schema::SchemaRef;
use ocmc_core::record::Record;
use std::fs::File;
use std::io::{self, Write};
use std::marker::PhantomData;
use std::path::Path;

const REFUSED: &str = "this program is built without Parquet; write the table as CSV";

/// A file that takes row groups: there is none.
#[derive(Debug)]
pub(super) enum GroupsFile {}

/// Records that would become a row group.
pub(super) struct RowGroupEncoder;

impl RowGroupEncoder {
    /// No rows.
    pub(super) fn new(_like: Option<Box<Record>>, _compression: Compression) -> Self {
        Self
    }

    /// Takes rows for nothing.
    pub(super) fn add(&mut self, _records: &[Record]) {}

    /// A row group that no file takes.
    pub(super) fn finish(self) -> RowGroup {
        RowGroup
    }
}

/// A row group that no file takes.
#[derive(Debug)]
pub struct RowGroup;

impl RowGroup {
    /// Refuses to begin a file.
    pub(super) fn begin(&self, _file: File) -> io::Result<GroupsFile> {
        Err(io::Error::other(REFUSED))
    }

    /// Never called.
    pub(super) fn append_to(self, file: &mut GroupsFile) -> io::Result<()> {
        match *file {}
    }
}

/// Never called.
pub(super) fn end(file: &mut GroupsFile) -> io::Result<()> {
    match *file {}
}

/// A file of a table: there is none.
#[derive(Debug)]
pub(crate) struct TableFile<W: Write + Send>(Never, PhantomData<W>);

#[derive(Debug)]
enum Never {}

impl<W: Write + Send> TableFile<W> {
    /// Refuses to begin a file.
    pub(crate) fn begin(_out: W, _schema: SchemaRef) -> io::Result<Self> {
        Err(io::Error::other(REFUSED))
    }

    /// Never called.
    pub(crate) fn add(&mut self, _batch: &RecordBatch) -> io::Result<()> {
        match self.0 {}
    }

    /// Never called.
    pub(crate) fn end(self) -> io::Result<W> {
        match self.0 {}
    }
}

/// Names of columns, and columns in pieces.
pub(crate) type Columns = (Vec<String>, Vec<Vec<ArrayRef>>);

/// Refuses a table.
pub(crate) fn columns(_file: File) -> Result<Columns, String> {
    Err(REFUSED.to_owned())
}

/// Refuses a file of records.
pub fn read(path: &Path, _file: File, _sink: impl FnMut(Group)) -> Result<(), RecordsError> {
    Err(RecordsError::Malformed(path.to_owned(), REFUSED.to_owned()))
}

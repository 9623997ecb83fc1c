//! The records of a run that is under way: small files, each of which is on the disk before the
//! manifest counts it.
//!
//! Chunk `k` holds the rows from `k` · [`CHUNK_ROWS`] on; all but the last one are full. A chunk is
//! written beside its place, synced, renamed, and its directory synced: at any moment it is there
//! whole or not at all. The file `lock` is locked by the program that writes.

use super::checksum::{CHECKSUMS, Checksums};
use super::durable::{replaced, sync_directory, temporary};
use super::error::RunDirectoryError;
use crate::file_error::FileError;
use crate::records::{self, RecordFormat, RecordWriter};
use ocmc_core::record::{COLUMNS, Cell, Column, Record};
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// Rows of a chunk: what a power cut costs at most, for each run.
pub const CHUNK_ROWS: usize = 1024;

/// Name of the folder of chunks in a run directory.
pub const CHUNKS: &str = "chunks";

const LOCK: &str = "lock";

/// The chunks of a run that is being written, held by this program alone.
#[derive(Debug)]
pub(super) struct Chunks {
    folder: PathBuf,
    pub(super) format: RecordFormat,
    sums: Checksums,
    /// Held for as long as the run is written.
    lock: File,
}

impl Chunks {
    /// Opens the folder of chunks, which is created where there is none. `sums` makes or reads the
    /// checksums of the directory once no other program can write to it.
    pub(super) fn open(
        directory: &Path,
        format: RecordFormat,
        sums: impl FnOnce() -> Result<Checksums, RunDirectoryError>,
    ) -> Result<Self, RunDirectoryError> {
        let folder = directory.join(CHUNKS);
        fs::create_dir_all(&folder).map_err(FileError::create(&folder))?;
        let path = folder.join(LOCK);
        let write = FileError::write(&path);
        if path.is_symlink() {
            let reason = "it is a symbolic link, and what it names is not ours".to_owned();
            return Err(RunDirectoryError::Damaged(path.clone(), reason));
        }
        let lock = File::options().write(true).create(true).truncate(false).open(&path);
        let lock = lock.map_err(&write)?;
        match lock.try_lock() {
            // a file system without locks protects nothing, and is no reason not to run
            Ok(()) => (),
            Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => (),
            Err(TryLockError::Error(error)) => return Err(write(error).into()),
            Err(TryLockError::WouldBlock) => {
                return Err(RunDirectoryError::Busy(directory.to_owned()));
            }
        }
        sync_directory(directory)?;
        Ok(Self { folder, format, sums: sums()?, lock })
    }

    /// The checksums of the directory.
    pub(super) fn sums(&mut self) -> &mut Checksums {
        &mut self.sums
    }

    /// Name of a chunk in the directory.
    fn name(&self, index: u64) -> String {
        format!("{CHUNKS}/{index:08}.{}", self.format.name())
    }

    /// Where a chunk is.
    pub(super) fn path(&self, index: u64) -> PathBuf {
        self.folder.join(format!("{index:08}.{}", self.format.name()))
    }

    /// Writes one chunk, or replaces it by a longer one.
    pub(super) fn write(&mut self, index: u64, rows: &[Record]) -> Result<(), RunDirectoryError> {
        let (path, name) = (self.path(index), self.name(index));
        replaced(&path, || {
            let mut writer = RecordWriter::create(&temporary(&path), self.format)?;
            writer.add(rows)?;
            writer.finish()?;
            self.sums.add(&name, &temporary(&path))
        })
    }

    /// Reads one chunk, which has to hold that many rows from that cycle id on.
    pub(super) fn read(
        &self,
        index: u64,
        first_cycle: u64,
        rows: usize,
    ) -> Result<Vec<Record>, RunDirectoryError> {
        let path = self.path(index);
        self.sums.check(&self.name(index))?;
        let mut records = Vec::with_capacity(rows);
        records::read(&path, |group| records.extend(group.records))?;
        // a longer one was written when the program ended before the manifest could count it
        records.truncate(rows);
        check_rows(&path, &records, first_cycle, rows)?;
        Ok(records)
    }

    /// Removes the chunks, once the records are whole, and their checksums.
    pub(super) fn remove(mut self) -> Result<(), RunDirectoryError> {
        drop(self.lock);
        remove(&self.folder)?;
        self.sums.retain(|name| !is_chunk(name));
        self.sums.write()
    }
}

/// The checksums of a directory that was begun without: those of its chunks as they are now.
pub(super) fn adopted(directory: &Path) -> Result<Checksums, RunDirectoryError> {
    let folder = directory.join(CHUNKS);
    let failed = FileError::read(&folder);
    let mut sums = Checksums::create(directory)?;
    for entry in fs::read_dir(&folder).map_err(&failed)? {
        let name = entry.map_err(&failed)?.file_name().to_string_lossy().into_owned();
        if name != LOCK && Path::new(&name).extension().is_some_and(|ending| ending != "tmp") {
            sums.add(&format!("{CHUNKS}/{name}"), &folder.join(&name))?;
        }
    }
    Ok(sums)
}

/// Whether a file of a run directory is a chunk.
pub(super) fn is_chunk(name: &str) -> bool {
    name.split('/').next() == Some(CHUNKS)
}

/// Removes what a program that ended in the wrong moment has left of its chunks.
pub(super) fn remove_left_over(directory: &Path) -> Result<(), RunDirectoryError> {
    let folder = directory.join(CHUNKS);
    if folder.exists() {
        remove(&folder)?;
    }
    // it may have ended while it took the sums of the chunks out
    let half_written = temporary(&directory.join(CHECKSUMS));
    if half_written.exists() {
        fs::remove_file(&half_written).map_err(FileError::write(&half_written))?;
    }
    let Some(mut sums) = Checksums::read(directory)? else { return Ok(()) };
    if !sums.names().into_iter().any(is_chunk) {
        return Ok(());
    }
    sums.retain(|name| !is_chunk(name));
    sums.write()
}

fn remove(folder: &Path) -> Result<(), RunDirectoryError> {
    Ok(fs::remove_dir_all(folder).map_err(FileError::write(folder))?)
}

/// Checks that records are those of consecutive cycles, and that their numbers are some.
pub(super) fn check_rows(
    path: &Path,
    records: &[Record],
    first_cycle: u64,
    rows: usize,
) -> Result<(), RunDirectoryError> {
    let damaged = |reason| Err(RunDirectoryError::Damaged(path.to_owned(), reason));
    if records.len() != rows {
        return damaged(format!("{} records instead of {rows}", records.len()));
    }
    for (id, record) in (first_cycle..).zip(records) {
        if record.cycle_id != id {
            return damaged(format!("cycle {} where cycle {id} should be", record.cycle_id));
        }
        if let Some((column, number)) = not_finite(record) {
            let allowed = "allowed is a finite number, or nothing";
            return damaged(format!("`{column}` of cycle {id} is {number}, {allowed}"));
        }
    }
    Ok(())
}

/// A number of a record that is none: no column has an infinite one.
fn not_finite(record: &Record) -> Option<(&str, f64)> {
    let number = |column: &'static Column| match column.get(record) {
        Cell::Number(Some(number)) if !number.is_finite() => Some((column.name, number)),
        _ => None,
    };
    let parts = record.breakdown.names().iter().enumerate();
    let mut parts = parts.filter_map(|(k, name)| Some((name.as_str(), record.breakdown.value(k)?)));
    COLUMNS.iter().find_map(number).or_else(|| parts.find(|(_, number)| !number.is_finite()))
}

//! The records of a run that is under way: small files, each of which is on the disk before the
//! manifest counts it.
//!
//! Chunk `k` holds the rows from `k` · [`CHUNK_ROWS`] on; all but the last one are full. A chunk is
//! written beside its place, synced, renamed, and its directory synced: at any moment it is there
//! whole or not at all. Chunks are encoded and synced side by side, and take their places in order:
//! those that are ready at a time share the syncs of checksums and directory. The file `lock` is
//! locked by the program that writes.

use super::checksum::{CHECKSUMS, Checksums};
use super::durable::{replaced, sync, temporary};
use super::error::RunDirectoryError;
use crate::file_error::FileError;
use crate::records::{self, Compression, EncodedGroup, RecordFormat, RecordWriter};
use crate::sha256;
use ocmc_core::record::{COLUMNS, Cell, Column, Record};
use std::collections::VecDeque;
use std::fs::{self, File, TryLockError};
use std::io;
use std::num::NonZero;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::thread::{self, JoinHandle};

/// Rows of a chunk. A power cut costs those that are under way, and less than one more.
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
    /// Chunks that are being written, each giving its checksum, in the order of their indices.
    under_way: VecDeque<UnderWay>,
    /// How many of them there may be.
    side_by_side: usize,
    /// Held for as long as the run is written.
    lock: Option<File>,
}

/// A chunk that is being written beside its place.
#[derive(Debug)]
struct UnderWay {
    index: u64,
    sum: JoinHandle<Result<String, RunDirectoryError>>,
}

/// Most chunks that are written side by side: for each four threads of the machine one, which keeps
/// up with cycles of 10 km.
const THREADS_A_CHUNK: usize = 4;

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
        sync(directory)?;
        let threads = thread::available_parallelism().map_or(1, NonZero::get);
        let (under_way, side_by_side) = (VecDeque::new(), threads.div_ceil(THREADS_A_CHUNK));
        Ok(Self { folder, format, sums: sums()?, under_way, side_by_side, lock: Some(lock) })
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
            let sum = write_beside(&path, self.format, rows)?;
            self.sums.add(vec![(sum, name)])
        })
    }

    /// Chunks that are being written.
    pub(super) fn under_way(&self) -> u64 {
        self.under_way.len() as u64
    }

    /// Begins to write the chunk that follows.
    pub(super) fn begin(&mut self, index: u64, rows: Vec<Record>) {
        let (path, format) = (self.path(index), self.format);
        let sum = thread::spawn(move || write_beside(&path, format, &rows));
        self.under_way.push_back(UnderWay { index, sum });
    }

    /// Gives the chunks that are ready their places, and waits for no more of the others than it
    /// has to. Returns how many took their place.
    pub(super) fn settle(&mut self) -> Result<u64, RunDirectoryError> {
        let ready = self.under_way.iter().take_while(|chunk| chunk.sum.is_finished()).count();
        self.place(ready.max(self.under_way.len().saturating_sub(self.side_by_side)))
    }

    /// Gives the first chunks under way, as many as there are up to a count, their places, once
    /// they are written. Returns how many took their place.
    pub(super) fn place(&mut self, count: usize) -> Result<u64, RunDirectoryError> {
        let (mut lines, mut paths) = (Vec::new(), Vec::new());
        while lines.len() < count
            && let Some(UnderWay { index, sum }) = self.under_way.pop_front()
        {
            let sum = sum.join().unwrap_or_else(|panic| resume_unwind(panic))?;
            lines.push((sum, self.name(index)));
            paths.push(self.path(index));
        }
        if lines.is_empty() {
            return Ok(0);
        }
        self.sums.add(lines)?;
        for path in &paths {
            fs::rename(temporary(path), path).map_err(FileError::write(path))?;
        }
        sync(&self.folder)?;
        Ok(paths.len() as u64)
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
        drop(self.lock.take());
        remove(&self.folder)?;
        self.sums.retain(|name| !is_chunk(name));
        self.sums.write()
    }
}

impl Drop for Chunks {
    /// No chunk is written any more once the lock is gone.
    fn drop(&mut self) {
        while let Some(UnderWay { index, sum }) = self.under_way.pop_front() {
            // whoever drops it has another error, or none that this could change
            let _ = sum.join();
            let _ = fs::remove_file(temporary(&self.path(index)));
        }
    }
}

/// Writes a chunk to [`temporary`], down to the disk, and gives its checksum.
fn write_beside(
    path: &Path,
    format: RecordFormat,
    rows: &[Record],
) -> Result<String, RunDirectoryError> {
    let beside = temporary(path);
    // left by a program that was ended while it wrote
    let _ = fs::remove_file(&beside);
    let written = || {
        let mut writer = RecordWriter::create(&beside)?;
        let rows: [Result<_, RunDirectoryError>; 1] = [Ok(rows)];
        writer.add(EncodedGroup::new(rows, format, Compression::Snappy)?)?;
        writer.finish()?;
        Ok(sha256::of_file(&beside).map_err(FileError::read(&beside))?)
    };
    written().inspect_err(|_| {
        // a remnant would do no harm; what matters is the first error
        let _ = fs::remove_file(&beside);
    })
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

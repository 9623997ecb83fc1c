//! The file of records, and that of chargings, from the chunks of a run: groups of rows are read
//! and encoded side by side, and written in their order.

use super::chunks::CHUNK_ROWS;
use super::durable::{replaced, temporary};
use super::{RunDirectory, RunDirectoryError};
use crate::charging_table::{CHARGINGS, ChargingsWriter};
use crate::records::{Compression, EncodedGroup, GROUP_ROWS, RecordWriter};
use ocmc_core::record::Record;
use std::collections::VecDeque;
use std::num::NonZero;
use std::panic::resume_unwind;
use std::thread::{self, ScopedJoinHandle};

/// Chunks of a group of rows.
const CHUNKS_A_GROUP: u64 = (GROUP_ROWS / CHUNK_ROWS) as u64;

/// Most threads that encode groups: each takes 10 to 15 MB.
const MOST_THREADS: usize = 8;

/// Threads that encode groups of a run that was driven by so many; those of a merged run drove one
/// after the other, or elsewhere.
pub(super) fn threads(drove: usize) -> usize {
    let here = thread::available_parallelism().map_or(1, NonZero::get);
    drove.min(here).min(MOST_THREADS)
}

impl RunDirectory {
    /// Writes the file of records from the chunks. It is a function of its rows alone.
    pub(super) fn assemble(&self, threads: usize) -> Result<(), RunDirectoryError> {
        let path = self.path.join(&self.manifest.records);
        let format = self.chunks.format;
        let encode = |group| EncodedGroup::new(self.rows_of(group), format, Compression::Zstd);
        replaced(&path, || {
            let mut writer = RecordWriter::create(&temporary(&path))?;
            self.each_group(threads, encode, |group| Ok(writer.add(group)?))?;
            Ok(writer.finish()?)
        })
    }

    /// Writes the file of chargings likewise.
    pub(super) fn assemble_chargings(&self, threads: usize) -> Result<(), RunDirectoryError> {
        let path = self.path.join(self.chunks.format.file_of(CHARGINGS));
        replaced(&path, || {
            let mut writer = ChargingsWriter::create(&temporary(&path), self.chunks.format)?;
            let read = |group| self.rows_of(group).collect::<Result<Vec<_>, _>>();
            self.each_group(threads, read, |parts| {
                parts.iter().try_for_each(|rows| Ok(writer.add(rows)?))
            })?;
            Ok(writer.finish()?)
        })
    }

    /// Hands over what is made of each group of rows, in their order. At most that many threads
    /// make something of groups, side by side. Without a row there is one group, too.
    fn each_group<T: Send>(
        &self,
        threads: usize,
        make: impl Fn(u64) -> Result<T, RunDirectoryError> + Sync,
        mut sink: impl FnMut(T) -> Result<(), RunDirectoryError>,
    ) -> Result<(), RunDirectoryError> {
        let groups = self.manifest.completed.div_ceil(GROUP_ROWS as u64).max(1);
        let make = &make;
        thread::scope(|scope| {
            let mut under_way = VecDeque::new();
            for group in 0..groups {
                if under_way.len() >= threads
                    && let Some(first) = under_way.pop_front()
                {
                    sink(joined(first)?)?;
                }
                under_way.push_back(scope.spawn(move || make(group)));
            }
            under_way.into_iter().try_for_each(|group| sink(joined(group)?))
        })
    }

    /// The rows of a group: of its chunks, and those that fill none.
    fn rows_of(&self, group: u64) -> impl Iterator<Item = Result<Vec<Record>, RunDirectoryError>> {
        let (begin, end) = (group * CHUNKS_A_GROUP, (group + 1) * CHUNKS_A_GROUP);
        let first_cycle = |chunk| self.manifest.first_cycle + chunk * CHUNK_ROWS as u64;
        let read = move |chunk| self.chunks.read(chunk, first_cycle(chunk), CHUNK_ROWS);
        let rest = (end > self.full).then(|| Ok(self.waiting.clone()));
        (begin..end.min(self.full)).map(read).chain(rest)
    }
}

/// Result of a thread.
fn joined<T>(thread: ScopedJoinHandle<'_, T>) -> T {
    thread.join().unwrap_or_else(|panic| resume_unwind(panic))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::records::{RecordFormat, RecordsError, examples};
    use crate::run_directory::tests::manifest;
    use std::fs;

    #[test]
    fn bytes_depend_on_the_rows_alone() {
        let directory = tempfile::tempdir().expect("a directory");
        // the last group has full chunks, and one that is not
        let rows = examples::records((2 * GROUP_ROWS + 3 * CHUNK_ROWS + 10) as u64);
        for format in RecordFormat::ALL {
            let written =
                [(1, rows.len()), (2, 1000), (7, CHUNK_ROWS)].map(|(threads, portion)| {
                    let path = directory.path().join(format!("{threads} {}", format.name()));
                    let manifest = manifest(rows.len() as u64);
                    let mut run = RunDirectory::create(&path, format, manifest).expect("free");
                    rows.chunks(portion).for_each(|rows| run.add(rows).expect("space"));
                    run.settle().expect("space");
                    run.manifest.completed = rows.len() as u64;
                    run.assemble(threads).expect("space");
                    fs::read(path.join(format.file_name())).expect("just written")
                });
            assert!(written.windows(2).all(|pair| pair[0] == pair[1]), "{format:?}");
            let parts = rows.chunks(GROUP_ROWS).map(|rows| {
                EncodedGroup::new([Ok::<_, RecordsError>(rows)], format, Compression::Zstd)
            });
            let path = directory.path().join("at once");
            let mut writer = RecordWriter::create(&path).expect("free");
            parts.for_each(|group| writer.add(group.expect("rows")).expect("space"));
            writer.finish().expect("space");
            assert!(fs::read(&path).expect("just written") == written[0], "{format:?}");
            fs::remove_file(path).expect("ours");
        }
    }

    #[test]
    fn a_chunk_that_cannot_be_read_ends_the_file_of_records() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path();
        let rows = examples::records(3 * GROUP_ROWS as u64);
        let manifest = manifest(rows.len() as u64);
        let mut run = RunDirectory::create(path, RecordFormat::Parquet, manifest).expect("empty");
        run.add(&rows).expect("space");
        run.settle().expect("space");
        fs::write(run.chunks.path(CHUNKS_A_GROUP + 1), "flipped").expect("ours");
        for threads in [1, 4] {
            let error = run.assemble(threads).expect_err("no chunk").to_string();
            assert!(error.contains("00000009.parquet"), "{error}");
            assert!(!path.join(RecordFormat::Parquet.file_name()).exists(), "not half of it");
        }
    }
}

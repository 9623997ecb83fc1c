//! Records in files: one row a cycle, in the order of cycle ids, a column for each quantity.
//!
//! A file is a function of its rows alone: whatever the chunks in which rows arrive, they are
//! written in groups of [`GROUP_ROWS`], each in one go.

pub mod arrow;
pub mod csv;
pub mod parquet;

use crate::file_error::FileError;
use crate::input_file;
use ::parquet::arrow::ArrowWriter;
use arrow::record_batch;
use arrow_array::RecordBatch;
use ocmc_core::charging::ChargingEvent;
use ocmc_core::record::Record;
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Rows that are written at a time: the row group of a Parquet file.
pub const GROUP_ROWS: usize = 8192;

/// Name of the column of what a trip charged, which records of a study with `[charging]` have
/// behind all others: a list of chargings, as JSON.
pub const CHARGING_EVENTS: &str = "charging_events";

/// What a trip charged, as JSON.
fn charging_text(record: &Record) -> Option<String> {
    let events = record.charging_events.as_ref()?;
    Some(serde_json::to_string(events).expect("numbers and words"))
}

/// What a trip charged, from JSON.
fn charging_events(text: &str) -> Result<Vec<ChargingEvent>, serde_json::Error> {
    serde_json::from_str(text)
}

/// How records are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RecordFormat {
    /// Apache Parquet, compressed by zstd.
    #[default]
    Parquet,
    /// Comma-separated values; an empty cell is null.
    Csv,
}

impl RecordFormat {
    /// Both formats.
    pub const ALL: [Self; 2] = [Self::Parquet, Self::Csv];

    /// Its name on the command line, and the extension of its files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Parquet => "parquet",
            Self::Csv => "csv",
        }
    }

    /// Name of the file in a run directory.
    pub fn file_name(self) -> &'static str {
        match self {
            Self::Parquet => "records.parquet",
            Self::Csv => "records.csv",
        }
    }
}

/// What can go wrong with a file of records.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RecordsError {
    /// The file cannot be created, written or read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file is not what its name says: what is wrong, and where.
    #[error("`{}` is no file of records: {}", .0.display(), .1)]
    Malformed(PathBuf, String),
}

/// Writes records to a new file, group by group.
#[derive(Debug)]
pub struct RecordWriter {
    path: PathBuf,
    format: RecordFormat,
    file: Groups,
    /// Records of the group that is not full yet.
    waiting: Vec<Record>,
    written: u64,
}

/// A file that takes whole groups; the first one says what columns it has.
#[derive(Debug)]
enum Groups {
    New(File),
    /// It could not be begun.
    Failed,
    Parquet(Box<ArrowWriter<File>>),
    Csv(BufWriter<File>),
}

impl RecordWriter {
    /// Creates the file, which must not exist.
    pub fn create(path: &Path, format: RecordFormat) -> Result<Self, RecordsError> {
        let file = OpenOptions::new().write(true).create_new(true).open(path);
        Ok(Self::new(path, file.map_err(FileError::create(path))?, format))
    }

    fn new(path: &Path, file: File, format: RecordFormat) -> Self {
        let file = Groups::New(file);
        Self { path: path.to_owned(), format, file, waiting: Vec::new(), written: 0 }
    }

    /// Takes the next records, and writes the groups that they fill.
    pub fn add(&mut self, records: &[Record]) -> Result<(), RecordsError> {
        self.waiting.extend_from_slice(records);
        let mut full = 0;
        while let Some(group) = self.waiting.get(full..full + GROUP_ROWS) {
            self.file.write(group, self.format).map_err(FileError::write(&self.path))?;
            self.written += GROUP_ROWS as u64;
            full += GROUP_ROWS;
        }
        self.waiting.drain(..full);
        Ok(())
    }

    /// Writes what is left, completes the file and makes sure that it is on the disk. Returns the
    /// number of rows.
    pub fn finish(mut self) -> Result<u64, RecordsError> {
        let mut finished = Ok(());
        // a file without rows is one, too
        if !self.waiting.is_empty() || self.written == 0 {
            finished = self.file.write(&self.waiting, self.format);
            self.written += self.waiting.len() as u64;
        }
        finished.and_then(|()| self.file.finish()).map_err(FileError::write(&self.path))?;
        Ok(self.written)
    }
}

impl Groups {
    /// Begins a file of records such as these.
    fn begin(file: File, records: &[Record], format: RecordFormat) -> io::Result<Self> {
        match format {
            RecordFormat::Parquet => {
                parquet::begin(file, records).map(|file| Self::Parquet(Box::new(file)))
            }
            RecordFormat::Csv => {
                let mut file = BufWriter::new(file);
                csv::write_header(&mut file, records).map(|()| Self::Csv(file))
            }
        }
    }

    /// Writes a group, down to the operating system.
    fn write(&mut self, group: &[Record], format: RecordFormat) -> io::Result<()> {
        *self = match std::mem::replace(self, Self::Failed) {
            Self::New(file) => Self::begin(file, group, format)?,
            begun => begun,
        };
        match self {
            _ if group.is_empty() => Ok(()),
            Self::Parquet(file) => parquet::write_group(file, group),
            Self::Csv(file) => csv::write_rows(file, group).and_then(|()| file.flush()),
            Self::New(_) | Self::Failed => Err(not_begun()),
        }
    }

    /// Completes the file and makes sure that it is on the disk.
    fn finish(&mut self) -> io::Result<()> {
        match self {
            Self::Parquet(file) => parquet::end(file).and_then(|()| file.inner().sync_all()),
            Self::Csv(file) => file.flush().and_then(|()| file.get_ref().sync_all()),
            Self::New(_) | Self::Failed => Err(not_begun()),
        }
    }
}

fn not_begun() -> io::Error {
    io::Error::other("it could not be begun")
}

/// Records that were read together.
#[derive(Clone, Debug)]
pub struct Group {
    /// The records.
    pub records: Vec<Record>,
    /// The same as a table, where the file has it in that form.
    batch: Option<RecordBatch>,
}

impl Group {
    /// The records as a table.
    pub fn into_batch(self) -> RecordBatch {
        self.batch.unwrap_or_else(|| record_batch(&self.records))
    }
}

/// Reads the records of a file, group by group, in the format that its extension names.
pub fn read(path: &Path, sink: impl FnMut(Group)) -> Result<(), RecordsError> {
    let open = || input_file::open(path).map_err(FileError::read(path));
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("parquet") => parquet::read(path, open()?, sink),
        Some("csv") => csv::read(path, open()?, sink),
        _ => {
            let reason = "its name ends neither in `.parquet` nor in `.csv`".to_owned();
            Err(RecordsError::Malformed(path.to_owned(), reason))
        }
    }
}

#[cfg(test)]
pub(crate) mod examples {
    //! Records for tests, with values that are hard to write.

    use ocmc_core::charging::{ChargingEvent, ChargingPlace};
    use ocmc_core::record::{Outcome, Record};

    /// A record whose values depend on its id.
    pub(crate) fn record(cycle_id: u64) -> Record {
        let x = cycle_id as f64 + 1.0;
        Record {
            cycle_id,
            outcome: Outcome::ALL[(cycle_id % 4) as usize],
            distance_m: x / 3.0,
            duration_s: x * 1e-300,
            mean_speed_mps: 0.1 + 0.2 * x,
            n_stops: cycle_id as u32,
            fuel_kg: cycle_id.is_multiple_of(2).then_some(x * 1e20),
            driver_effect: cycle_id.is_multiple_of(3).then_some(-x / 7.0),
            n_curves: (!cycle_id.is_multiple_of(5)).then_some(cycle_id as u32),
            potential_change_j: -0.0,
            ..Record::default()
        }
    }

    fn event(x: f64) -> ChargingEvent {
        ChargingEvent {
            place: ChargingPlace::Public,
            position_m: x / 3.0,
            arrival_s: 1e-300 * x,
            wait_s: -0.0,
            begin_s: 0.1 + 0.2 * x,
            charging_s: x * 1e20,
            begin_charge: 1.0 / x,
            end_charge: 0.9,
            charged_energy_j: x.sqrt(),
            grid_energy_j: x,
            peak_power_w: 0.1,
            quarter_hours_j: vec![x / 7.0, 5e-324],
        }
    }

    /// The first `n` records, with chargings.
    pub(crate) fn charged(n: u64) -> Vec<Record> {
        let charge = |mut record: Record| {
            let events = vec![event(record.distance_m); (record.cycle_id % 3) as usize];
            record.charging_events = (record.cycle_id != 4).then_some(events);
            record
        };
        records(n).into_iter().map(charge).collect()
    }

    /// The first `n` records.
    pub(crate) fn records(n: u64) -> Vec<Record> {
        (0..n).map(record).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(path: &Path, format: RecordFormat, records: &[Record], chunk: usize) {
        let mut writer = RecordWriter::create(path, format).expect("a new file");
        for records in records.chunks(chunk) {
            writer.add(records).expect("space");
        }
        assert_eq!(writer.finish().expect("space"), records.len() as u64);
    }

    #[test]
    fn what_is_written_is_read_back_exactly() {
        let directory = tempfile::tempdir().expect("a directory");
        for format in RecordFormat::ALL {
            for n in [0, 1, 300, GROUP_ROWS as u64, 3 * GROUP_ROWS as u64 + 17] {
                let records = examples::records(n);
                let path = directory.path().join(format!("{n}.{}", format.name()));
                write(&path, format, &records, 256);
                let mut back = Vec::new();
                read(&path, |group| back.extend(group.records)).expect("just written");
                assert_eq!(back.len(), records.len());
                assert!(back == records, "{path:?}");
            }
        }
    }

    #[test]
    fn chargings_are_read_back_exactly() {
        let directory = tempfile::tempdir().expect("a directory");
        let records = examples::charged(300);
        for format in RecordFormat::ALL {
            let path = directory.path().join(format!("charged.{}", format.name()));
            write(&path, format, &records, 256);
            let mut back = Vec::new();
            read(&path, |group| back.extend(group.records)).expect("just written");
            assert!(back == records, "{path:?}");
        }
        let path = directory.path().join("wrong.csv");
        write(&path, RecordFormat::Csv, &records[..1], 1);
        let text = std::fs::read_to_string(&path).expect("just written");
        std::fs::write(&path, text.replace("[]", "[3]")).expect("space");
        let error = read(&path, |_| ()).expect_err("no charging").to_string();
        assert!(error.contains("`charging_events`"), "{error}");
    }

    #[test]
    fn bytes_do_not_depend_on_chunks() {
        let directory = tempfile::tempdir().expect("a directory");
        let records = examples::records(2 * GROUP_ROWS as u64 + 100);
        for format in RecordFormat::ALL {
            let bytes = [1, 100, GROUP_ROWS, 20_000].map(|chunk| {
                let path = directory.path().join(format!("{chunk}.{}", format.name()));
                write(&path, format, &records, chunk);
                std::fs::read(path).expect("just written")
            });
            assert!(bytes.windows(2).all(|pair| pair[0] == pair[1]), "{format:?}");
        }
    }

    #[test]
    fn an_existing_file_is_not_overwritten() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("records.csv");
        std::fs::write(&path, "mine").expect("space");
        let error = RecordWriter::create(&path, RecordFormat::Csv).expect_err("it exists");
        assert!(error.to_string().contains("records.csv"), "{error}");
        assert_eq!(std::fs::read(&path).expect("still there"), b"mine");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_full_disk_is_an_error_with_the_name_of_the_file() {
        let full = Path::new("/dev/full");
        let open = || OpenOptions::new().write(true).open(full).expect("Linux has it");
        let rows = examples::records(GROUP_ROWS as u64);
        let errors = RecordFormat::ALL.map(|format| {
            let mut file = RecordWriter::new(full, open(), format);
            file.add(&rows).and_then(|()| file.finish())
        });
        for error in errors {
            let error = error.expect_err("nothing fits").to_string();
            assert!(error.contains("/dev/full") && error.contains("No space left"), "{error}");
        }
    }

    #[test]
    fn files_that_are_no_records_are_errors_with_their_name() {
        let directory = tempfile::tempdir().expect("a directory");
        for (name, text) in [
            ("a.csv", "nonsense\n1\n"),
            ("b.csv", "cycle_id,outcome\n1,flown\n"),
            ("c.parquet", "no parquet"),
            ("d.txt", ""),
        ] {
            let path = directory.path().join(name);
            std::fs::write(&path, text).expect("space");
            let error = read(&path, |_| ()).expect_err("no records").to_string();
            assert!(error.contains(name), "{error}");
        }
    }
}

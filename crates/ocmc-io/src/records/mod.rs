//! Records in files: one row a cycle, in the order of cycle ids, a column for each quantity.
//!
//! A file is a function of its rows alone: they stand in groups of [`GROUP_ROWS`], each of which is
//! encoded by itself.

pub mod arrow;
pub mod csv;
#[cfg_attr(not(feature = "files"), path = "without_parquet.rs")]
pub mod parquet;

use self::parquet::RowGroupEncoder;
use crate::file_error::FileError;
use crate::input_file;
use arrow::record_batch;
use arrow_array::RecordBatch;
use ocmc_core::charging::ChargingEvent;
use ocmc_core::record::Record;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Rows that are written at a time: the row group of a Parquet file.
pub const GROUP_ROWS: usize = 8192;

/// Name of the column of what a trip charged, which records of a study with `[charging]` have
/// behind all others: a list of chargings, as JSON.
pub const CHARGING_EVENTS: &str = "charging_events";

/// Charging of a trip, as JSON.
fn charging_text(record: &Record) -> Option<String> {
    let events = record.charging_events.as_ref()?;
    Some(serde_json::to_string(events).expect("numbers and words"))
}

/// Charging of a trip, from JSON.
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

    /// Name of the file of a table beside the records.
    pub(crate) fn file_of(self, table: &str) -> String {
        format!("{table}.{}", self.name())
    }
}

/// How the values of a Parquet file are compressed; text never is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    /// Small: for a file that stays.
    Zstd,
    /// Fast: for a file of few rows that is soon read back, of which the contexts of zstd, two for
    /// each column, would take most of the time.
    Snappy,
}

/// Errors of a file of records.
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

/// A group of records as it stands in a file of them. It is a function of its rows alone, so that
/// groups can be encoded side by side.
#[derive(Debug)]
pub enum EncodedGroup {
    /// A row group, and what columns it has.
    Parquet(parquet::RowGroup),
    /// Rows, and the line above the first of them.
    Csv(csv::Text),
}

impl EncodedGroup {
    /// Encodes at most [`GROUP_ROWS`] records, which come in parts. They have the columns of the
    /// first one.
    pub fn new<R: AsRef<[Record]>, E>(
        parts: impl IntoIterator<Item = Result<R, E>>,
        format: RecordFormat,
        compression: Compression,
    ) -> Result<Self, E> {
        let mut parts = parts.into_iter();
        let first = parts.next().transpose()?;
        let like = first.as_ref().and_then(|rows| rows.as_ref().first().cloned().map(Box::new));
        let mut parts = first.into_iter().map(Ok).chain(parts);
        match format {
            RecordFormat::Parquet => {
                let mut group = RowGroupEncoder::new(like, compression);
                parts.try_for_each(|rows| rows.map(|rows| group.add(rows.as_ref())))?;
                Ok(Self::Parquet(group.finish()))
            }
            RecordFormat::Csv => {
                let mut text = csv::Text::new(like);
                parts.try_for_each(|rows| rows.map(|rows| text.add(rows.as_ref())))?;
                Ok(Self::Csv(text))
            }
        }
    }
}

/// Writes records to a new file, group by group.
#[derive(Debug)]
pub struct RecordWriter {
    path: PathBuf,
    file: Groups,
}

/// A file that takes groups; the first one says what columns it has.
#[derive(Debug)]
enum Groups {
    New(File),
    /// It could not be begun.
    Failed,
    Parquet(Box<parquet::GroupsFile>),
    Csv(File),
}

impl RecordWriter {
    /// Creates the file, which must not exist.
    pub fn create(path: &Path) -> Result<Self, RecordsError> {
        let file = OpenOptions::new().write(true).create_new(true).open(path);
        Ok(Self::new(path, file.map_err(FileError::create(path))?))
    }

    fn new(path: &Path, file: File) -> Self {
        Self { path: path.to_owned(), file: Groups::New(file) }
    }

    /// Writes the next group. All but the last one have [`GROUP_ROWS`] rows; one without rows makes
    /// a file without rows.
    pub fn add(&mut self, group: EncodedGroup) -> Result<(), RecordsError> {
        Ok(self.file.write(group).map_err(FileError::write(&self.path))?)
    }

    /// Completes the file and makes sure that it is on the disk.
    pub fn finish(mut self) -> Result<(), RecordsError> {
        Ok(self.file.finish().map_err(FileError::write(&self.path))?)
    }
}

impl Groups {
    /// Begins a file of groups such as this one.
    fn begin(mut file: File, group: &EncodedGroup) -> io::Result<Self> {
        match group {
            EncodedGroup::Parquet(group) => group.begin(file).map(Box::new).map(Self::Parquet),
            EncodedGroup::Csv(text) => {
                file.write_all(text.header().as_bytes()).map(|()| Self::Csv(file))
            }
        }
    }

    /// Writes a group, down to the operating system.
    fn write(&mut self, group: EncodedGroup) -> io::Result<()> {
        *self = match std::mem::replace(self, Self::Failed) {
            Self::New(file) => Self::begin(file, &group)?,
            begun => begun,
        };
        match (self, group) {
            (Self::Parquet(file), EncodedGroup::Parquet(group)) => group.append_to(file),
            (Self::Csv(file), EncodedGroup::Csv(text)) => file.write_all(text.rows()),
            _ => Err(not_begun()),
        }
    }

    /// Completes the file and makes sure that it is on the disk.
    fn finish(&mut self) -> io::Result<()> {
        match self {
            Self::Parquet(file) => parquet::end(file),
            Self::Csv(file) => file.sync_all(),
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
    use ocmc_core::energy::Carrier;
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
            driver_effect: cycle_id.is_multiple_of(3).then_some(-x / 7.0),
            n_curves: (!cycle_id.is_multiple_of(5)).then_some(cycle_id as u32),
            potential_change_j: -0.0,
            ..Record::default().with(
                Carrier::LiquidFuel,
                [cycle_id.is_multiple_of(2).then_some(x * 1e20), None, None],
            )
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
    use std::convert::Infallible;

    /// A group that comes in parts of so many rows.
    fn group(records: &[Record], format: RecordFormat, part: usize) -> EncodedGroup {
        let parts = records.chunks(part).map(Ok::<_, Infallible>);
        let Ok(group) = EncodedGroup::new(parts, format, Compression::Zstd);
        group
    }

    fn write(path: &Path, format: RecordFormat, records: &[Record], part: usize) {
        let mut writer = RecordWriter::create(path).expect("a new file");
        if records.is_empty() {
            writer.add(group(records, format, part)).expect("space");
        }
        for records in records.chunks(GROUP_ROWS) {
            writer.add(group(records, format, part)).expect("space");
        }
        writer.finish().expect("space");
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
    fn bytes_do_not_depend_on_the_parts_of_groups() {
        let directory = tempfile::tempdir().expect("a directory");
        // texts of chargings fill more than one page of a group
        let records = examples::charged(GROUP_ROWS as u64 + 100);
        for format in RecordFormat::ALL {
            let bytes = [1, 100, GROUP_ROWS].map(|part| {
                let path = directory.path().join(format!("{part}.{}", format.name()));
                write(&path, format, &records, part);
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
        let error = RecordWriter::create(&path).expect_err("it exists");
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
            let mut file = RecordWriter::new(full, open());
            file.add(group(&rows, format, GROUP_ROWS)).and_then(|()| file.finish())
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

//! Measured speed changes: a table of accelerations, one row a change, or the logs in which they happened.
//!
//! A file with a column `acceleration_mps2` and without `time_s` is a table; `category` and `driver` (or `truck`) may be absent.
//! Any other file is a log with time, speed and limit.

use crate::column_file::{ColumnFile, ColumnFileError, WordColumn};
use crate::given_table::GivenTable;
use crate::log::error::LogFileError;
use crate::log::mapping::Mapping;
use crate::log::quantity::Quantity;
use crate::log::{LogFile, Need, read as read_log, read_table as read_log_table};
use ocmc_core::fit::speed_change::{
    SpeedChangeError, SpeedChangeOptions, SpeedChangeTable, SpeedLog, accelerations,
};
use std::path::Path;
use thiserror::Error;

/// What has to be in a log.
const NEEDS: [Need; 3] = [
    Need { what: "time", any_of: &[Quantity::Time] },
    Need { what: "speed", any_of: &[Quantity::Speed] },
    Need { what: "speed limit", any_of: &[Quantity::Limit] },
];

/// Why speed changes cannot be read.
#[derive(Debug, Error)]
pub enum SpeedChangeFileError {
    /// A table that cannot be read.
    #[error(transparent)]
    Table(#[from] ColumnFileError),
    /// A log that cannot be read.
    #[error(transparent)]
    Log(#[from] LogFileError),
    /// A log that cannot be used.
    #[error("`{}`, drive `{drive}`: {source}", path.display())]
    Drive {
        /// The file.
        path: std::path::PathBuf,
        /// The drive.
        drive: String,
        /// What is wrong.
        source: SpeedChangeError,
    },
}

/// Appends the speed changes of a file to a table, and returns the log where it is one.
///
/// # Errors
/// [`SpeedChangeFileError`] names the file, the place in it and what is allowed.
pub fn append(
    table: &mut SpeedChangeTable,
    path: &Path,
    mappings: &[Mapping],
    options: &SpeedChangeOptions,
) -> Result<Option<LogFile>, SpeedChangeFileError> {
    // a compressed log is no table, and says so by its first bytes
    if let Some(file) = ColumnFile::open(path).ok().filter(is_table) {
        append_table(table, file)?;
        return Ok(None);
    }
    append_log(table, read_log(path, mappings, &NEEDS)?, options).map(Some)
}

/// As [`append`], of a table of a calling program.
///
/// # Errors
/// As [`append`].
pub fn append_given(
    table: &mut SpeedChangeTable,
    given: &GivenTable,
    mappings: &[Mapping],
    options: &SpeedChangeOptions,
) -> Result<Option<LogFile>, SpeedChangeFileError> {
    let file = ColumnFile::of_table(given.clone())?;
    if is_table(&file) {
        append_table(table, file)?;
        return Ok(None);
    }
    append_log(table, read_log_table(given, mappings, &NEEDS)?, options).map(Some)
}

fn is_table(file: &ColumnFile) -> bool {
    file.has(&["acceleration_mps2"]) && !file.has(&["time_s"])
}

fn append_log(
    table: &mut SpeedChangeTable,
    log: LogFile,
    options: &SpeedChangeOptions,
) -> Result<LogFile, SpeedChangeFileError> {
    for drive in &log.drives {
        let column = |quantity| drive.column(quantity).unwrap_or_default();
        let series = SpeedLog {
            time_s: column(Quantity::Time),
            speed_mps: column(Quantity::Speed),
            limit_mps: column(Quantity::Limit),
        };
        let found =
            accelerations(&series, options).map_err(|source| SpeedChangeFileError::Drive {
                path: log.path.clone(),
                drive: drive.drive.clone(),
                source,
            })?;
        for (category, acceleration) in found {
            table.driver.push(drive.driver.clone());
            table.category.push(category);
            table.acceleration_mps2.push(acceleration);
        }
    }
    Ok(log)
}

fn append_table(table: &mut SpeedChangeTable, mut file: ColumnFile) -> Result<(), ColumnFileError> {
    let acceleration = file.need_numbers(&["acceleration_mps2"])?;
    let driver = file.words(&["driver", "truck"])?;
    let category = file.words(&["category"])?;
    file.for_each(|row| {
        let text = |column: Option<WordColumn>| column.map_or("", |c| row.text(c)).to_owned();
        table.acceleration_mps2.push(row.number(acceleration)?);
        table.driver.push(text(driver));
        table.category.push(text(category));
        Ok(())
    })
}

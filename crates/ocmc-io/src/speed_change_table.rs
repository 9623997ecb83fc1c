//! Measured speed changes: a table of accelerations, one row a change, or the logs in which they happened.
//!
//! A file with a column `acceleration_mps2` and without `time_s` is a table; `category` and `driver` (or `truck`) may be absent.
//! Any other file is a log with time, speed and limit.

use crate::column_file::{ColumnFile, ColumnFileError};
use crate::log::error::LogFileError;
use crate::log::mapping::Mapping;
use crate::log::quantity::Quantity;
use crate::log::{LogFile, Need, read as read_log};
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
    let file = ColumnFile::open(path).ok();
    let is_table = |file: &ColumnFile| {
        file.find(&["acceleration_mps2"]).is_some() && file.find(&["time_s"]).is_none()
    };
    if let Some(file) = file.filter(is_table) {
        append_table(table, file)?;
        return Ok(None);
    }
    let log = read_log(path, mappings, &NEEDS)?;
    for drive in &log.drives {
        let column = |quantity| drive.column(quantity).unwrap_or_default();
        let series = SpeedLog {
            time_s: column(Quantity::Time),
            speed_mps: column(Quantity::Speed),
            limit_mps: column(Quantity::Limit),
        };
        let found =
            accelerations(&series, options).map_err(|source| SpeedChangeFileError::Drive {
                path: path.to_owned(),
                drive: drive.drive.clone(),
                source,
            })?;
        for (category, acceleration) in found {
            table.driver.push(drive.driver.clone());
            table.category.push(category);
            table.acceleration_mps2.push(acceleration);
        }
    }
    Ok(Some(log))
}

fn append_table(table: &mut SpeedChangeTable, file: ColumnFile) -> Result<(), ColumnFileError> {
    let acceleration = file.need(&["acceleration_mps2"])?;
    let (driver, category) = (file.find(&["driver", "truck"]), file.find(&["category"]));
    file.for_each(|row| {
        let text = |column: Option<usize>| column.map_or("", |column| row.text(column)).to_owned();
        table.acceleration_mps2.push(row.number(acceleration)?);
        table.driver.push(text(driver));
        table.category.push(text(category));
        Ok(())
    })
}

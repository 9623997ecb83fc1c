//! Measured speed changes: a table of accelerations, one row a change, or the logs in which they happened.
//!
//! A file with a column `acceleration_mps2` and without `time_s` is a table; `category` and `driver` (or `truck`) may be absent.
//! Any other file is a log with time, speed and limit.

use crate::column_file::{ColumnFile, ColumnFileError, WordColumn};
use crate::given_table::GivenTable;
use crate::log::error::LogFileError;
use crate::log::mapping::Mapping;
use crate::log::quantity::Quantity;
use crate::log::{
    LogFile, Need, counted, read as read_log, read_table as read_log_table, row_notes,
};
use ocmc_estimation::fit::speed_change::{
    LoggedChanges, SpeedChangeError, SpeedChangeOptions, SpeedChangeTable, SpeedLog, accelerations,
};
use std::path::{Path, PathBuf};
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
    /// A log without a drive that can be used.
    #[error("{place}: {source}")]
    Drive {
        /// Where the first drive stands.
        place: String,
        /// What is wrong with it.
        source: SpeedChangeError,
    },
    /// Neither a table nor a log.
    #[error(
        "`{}` is neither a table of speed changes (acceleration_mps2) nor a log (time, speed, limit); its columns are {found}; --map \
         says which column of a log is what",
        path.display()
    )]
    Neither {
        /// The file.
        path: PathBuf,
        /// Its columns.
        found: String,
    },
}

/// Appends the speed changes of a file to a table, and returns what has to be known of it.
///
/// # Errors
/// [`SpeedChangeFileError`] names the file, the place in it and what is allowed.
pub fn append(
    table: &mut SpeedChangeTable,
    path: &Path,
    mappings: &[Mapping],
    options: &SpeedChangeOptions,
) -> Result<Vec<String>, SpeedChangeFileError> {
    // what cannot be opened here says so as a log
    if let Ok(file) = ColumnFile::open(path)
        && is_table(&file, mappings)?
    {
        append_table(table, file)?;
        return Ok(Vec::new());
    }
    append_log(table, &read_log(path, mappings, &NEEDS)?, options)
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
) -> Result<Vec<String>, SpeedChangeFileError> {
    let file = ColumnFile::of_table(given.clone())?;
    if is_table(&file, mappings)? {
        append_table(table, file)?;
        return Ok(Vec::new());
    }
    append_log(table, &read_log_table(given, mappings, &NEEDS)?, options)
}

/// Whether a file is a table of accelerations, and no log.
fn is_table(file: &ColumnFile, mappings: &[Mapping]) -> Result<bool, SpeedChangeFileError> {
    let accelerations = ["acceleration_mps2"];
    let any = file.has(&accelerations) || file.other_unit(&accelerations).is_some();
    let logged = |quantity: Quantity| {
        file.names().iter().any(|name| Quantity::with_wrong_unit(name) == Some(quantity))
    };
    let log = [Quantity::Time, Quantity::Speed, Quantity::Limit].map(logged);
    if !any
        && mappings.is_empty()
        && log == [false; 3]
        && file.names().iter().all(|name| is_text(name))
    {
        let found = file.names().join(", ");
        return Err(SpeedChangeFileError::Neither { path: file.path().to_owned(), found });
    }
    Ok(any && !file.has(&["time_s"]))
}

/// Whether a name is one, and not a piece of a file that is no text.
fn is_text(name: &str) -> bool {
    !name.contains(|c: char| c.is_control() || c == char::REPLACEMENT_CHARACTER)
}

fn append_log(
    table: &mut SpeedChangeTable,
    log: &LogFile,
    options: &SpeedChangeOptions,
) -> Result<Vec<String>, SpeedChangeFileError> {
    let mut notes = log.warnings();
    let mut left_out = Vec::new();
    for drive in &log.drives {
        let column = |quantity| drive.column(quantity).unwrap_or_default();
        let series = SpeedLog {
            time_s: column(Quantity::Time),
            speed_mps: column(Quantity::Speed),
            limit_mps: column(Quantity::Limit),
        };
        let place = log.place(drive);
        let found = match accelerations(&series, options) {
            Ok(found) => found,
            Err(source) => {
                left_out.push((place, source));
                continue;
            }
        };
        notes.extend(drive_notes(&place, &found));
        for (category, acceleration) in found.changes {
            table.driver.push(drive.driver.clone());
            table.category.push(category);
            table.acceleration_mps2.push(acceleration);
        }
    }
    if left_out.len() == log.drives.len()
        && let Some((place, source)) = left_out.pop()
    {
        return Err(SpeedChangeFileError::Drive { place, source });
    }
    notes.extend(left_out.iter().map(|(place, fault)| format!("{place} is left out: {fault}")));
    Ok(notes)
}

/// What was not used of a drive.
fn drive_notes(place: &str, found: &LoggedChanges) -> Vec<String> {
    let mut notes = row_notes(place, &found.rows);
    notes.extend(counted(
        place,
        [
            (found.rows.gaps, "gaps in time: no window reaches over one"),
            (found.without_limit, "rows without a possible speed limit: the one before holds"),
            (
                found.without_window,
                "changes of the limit without enough rows around them are left out",
            ),
        ],
    ));
    notes
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

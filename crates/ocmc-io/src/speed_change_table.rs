//! Measured speed changes: a table of accelerations, one row a change, or the logs in which they
//! happened.
//!
//! A file with a column `acceleration_mps2` and without `time_s` is a table; `category` and
//! `driver` (or `truck`) may be absent. Any other file is a log with time, speed and limit.

use crate::intake::FileAccount;
use crate::intake::table::error::Fault;
use crate::intake::table::formats::{LOG, SPEED_CHANGES};
use crate::intake::table::{Mapping, Quantity, Source, Table, TableError};
use crate::log::{self, LogFile, counted, row_notes};
use ocmc_estimation::fit::speed_change::{
    LoggedChanges, SpeedChangeError, SpeedChangeOptions, SpeedChangeTable, SpeedLog, accelerations,
};
use thiserror::Error;

/// Needs of speed changes in a log.
const NEEDS: [&[Quantity]; 3] = [&[Quantity::Time], &[Quantity::Speed], &[Quantity::Limit]];

/// Why speed changes cannot be read.
#[derive(Debug, Error)]
pub enum SpeedChangeFileError {
    /// A table or a log that cannot be read.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A log without a drive that can be used.
    #[error("{place}: {source}")]
    Drive {
        /// Where the first drive stands.
        place: String,
        /// Error of the drive.
        source: SpeedChangeError,
    },
}

/// Appends the speed changes of a table or a log, and returns what was read and what of a log was
/// not used.
///
/// # Errors
/// [`SpeedChangeFileError`] names the file, the place in it and what is allowed.
pub fn append(
    table: &mut SpeedChangeTable,
    source: Source,
    mappings: &[Mapping],
    options: &SpeedChangeOptions,
) -> Result<(FileAccount, Vec<String>), SpeedChangeFileError> {
    let of_table: Vec<Mapping> =
        mappings.iter().filter(|mapping| mapping.is_of(&SPEED_CHANGES)).cloned().collect();
    let file = Table::open(source, &SPEED_CHANGES, &of_table)?;
    let log = file.names().iter().any(|name| name == "time_s");
    if !log && file.has(Quantity::Acceleration) {
        return Ok((append_table(table, file)?, Vec::new()));
    }
    refuse_other(&file, mappings)?;
    let log = log::read(source, mappings, &NEEDS)?;
    let notes = append_log(table, &log, options)?;
    Ok((log.read, notes))
}

/// Refuses a table that holds nothing of a log.
fn refuse_other(file: &Table, mappings: &[Mapping]) -> Result<(), TableError> {
    let logged = |name: &String| LOG.means(name).is_some_and(|q| NEEDS.concat().contains(&q));
    if mappings.is_empty()
        && !file.names().iter().any(logged)
        && file.names().iter().all(|name| is_text(name))
    {
        return Err(TableError::of(file.path(), Fault::Neither(file.names().join(", "))));
    }
    Ok(())
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
    let mut notes = Vec::new();
    let mut left_out = Vec::new();
    for drive in &log.drives {
        let column = |quantity| drive.column(quantity).unwrap_or_default();
        let series = SpeedLog {
            time_s: column(Quantity::Time),
            speed_mps: column(Quantity::Speed),
            limit_mps: column(Quantity::Limit),
        };
        let place = log.place(drive);
        let logged = match accelerations(&series, options) {
            Ok(logged) => logged,
            Err(source) => {
                left_out.push((place, source));
                continue;
            }
        };
        notes.extend(drive_notes(&place, &logged));
        for (category, acceleration) in logged.changes {
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

/// Notes on parts of a drive that were not used.
fn drive_notes(place: &str, logged: &LoggedChanges) -> Vec<String> {
    let mut notes = row_notes(place, &logged.rows);
    notes.extend(counted(
        place,
        [
            (logged.rows.gaps, "gap", "in time: no window reaches over one"),
            (logged.without_limit, "row", "without a possible speed limit: the one before holds"),
            (
                logged.without_window,
                "change",
                "of the limit without enough rows around it: left out",
            ),
        ],
    ));
    notes
}

fn append_table(table: &mut SpeedChangeTable, file: Table) -> Result<FileAccount, TableError> {
    file.refuse_other_units()?;
    file.need(&[Quantity::Acceleration])?;
    file.for_each(|row| {
        table.acceleration_mps2.push(row.number(Quantity::Acceleration)?);
        table.driver.push(row.text(Quantity::Driver).to_owned());
        table.category.push(row.text(Quantity::Category).to_owned());
        Ok(())
    })
}

//! The clock of tables of measurements: a date and time of the day, or seconds.

use crate::column_file::{ColumnFile, ColumnFileError, Row};
use std::io::Read;

const DAY_S: f64 = 86_400.0;
const YEAR_S: f64 = 365.0 * DAY_S;

/// The column `time` (dates) or `time_s` (seconds since the midnight of a 1 January).
pub(crate) struct ClockColumn {
    column: usize,
    is_date: bool,
}

impl ClockColumn {
    /// Finds the clock of a table.
    pub(crate) fn find(file: &ColumnFile<impl Read>) -> Result<Self, ColumnFileError> {
        let column = file.need(&["time", "time_s"])?;
        Ok(Self { column, is_date: file.names()[column] == "time" })
    }

    /// Time since some midnight, in s, and day of the year with its fraction, of a row that has to come after a time.
    pub(crate) fn after(
        &self,
        row: &Row,
        last: Option<f64>,
    ) -> Result<(f64, f64), ColumnFileError> {
        let (time_s, day_of_year) =
            if self.is_date { date(row, self.column)? } else { seconds(row, self.column)? };
        if last.is_some_and(|last| time_s <= last) {
            return Err(row.refuse(self.column, "a time after that of the row before"));
        }
        Ok((time_s, day_of_year))
    }
}

/// Time, and the day of a year of 365 days.
fn seconds(row: &Row, column: usize) -> Result<(f64, f64), ColumnFileError> {
    let time_s = row.number(column)?;
    if !(time_s >= 0.0 && time_s.is_finite()) {
        return Err(row.refuse(column, "seconds since the midnight of a 1 January"));
    }
    Ok((time_s, time_s % YEAR_S / DAY_S))
}

/// Time since the midnight of 1 January 1900, and the day of the year, of a date such as `2024-03-01T14:00`.
fn date(row: &Row, column: usize) -> Result<(f64, f64), ColumnFileError> {
    parse_date(row.text(column))
        .ok_or_else(|| row.refuse(column, "a date and time such as 2024-03-01T14:00"))
}

fn parse_date(text: &str) -> Option<(f64, f64)> {
    let (date, clock) = text.trim_end_matches('Z').split_once(['T', ' '])?;
    let mut date = date.split('-').map(|part| part.parse::<u32>().ok());
    let (year, month, day) = (date.next()??, date.next()??, date.next()??);
    let mut clock = clock.split(':').map(|part| part.parse::<f64>().ok());
    let (hour, minute) = (clock.next()??, clock.next()??);
    let second = match clock.next() {
        None => 0.0,
        Some(second) => second?,
    };
    let leap = |year: u32| {
        year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
    };
    let february = if leap(year) { 29 } else { 28 };
    let lengths = [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let before = lengths.get(..month.checked_sub(1)? as usize)?;
    let in_range = *lengths.get(before.len())? >= day
        && day > 0
        && (1900..2200).contains(&year)
        && (0.0..24.0).contains(&hour)
        && (0.0..60.0).contains(&minute)
        && (0.0..60.0).contains(&second);
    if !in_range || date.next().is_some() || clock.next().is_some() {
        return None;
    }
    let days = f64::from(before.iter().sum::<u32>() + day - 1);
    let years: u32 = (1900..year).map(|year| if leap(year) { 366 } else { 365 }).sum();
    let of_day_s = (hour * 60.0 + minute) * 60.0 + second;
    Some(((f64::from(years) + days) * DAY_S + of_day_s, days + of_day_s / DAY_S))
}

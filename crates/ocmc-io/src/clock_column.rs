//! The clock of tables of measurements: a date and time of the day, or seconds.

use crate::column_file::{ColumnFile, ColumnFileError, NumberColumn, Row, WordColumn};
use std::io::Read;

const DAY_S: f64 = 86_400.0;
const YEAR_S: f64 = 365.0 * DAY_S;

/// The clock of a table.
pub(crate) enum ClockColumn {
    /// `time`: dates such as `2024-03-01T14:00`.
    Date(WordColumn),
    /// `time_s`: seconds since the midnight of a 1 January.
    Seconds(NumberColumn),
}

impl ClockColumn {
    /// Finds it.
    pub(crate) fn find(file: &mut ColumnFile<impl Read>) -> Result<Self, ColumnFileError> {
        Ok(match file.numbers(&["time_s"])? {
            Some(column) => Self::Seconds(column),
            None => Self::Date(file.need_words(&["time", "time_s"])?),
        })
    }

    /// Time since some midnight, in s, and day of the year with its fraction, of a row that has to come after a time.
    pub(crate) fn after(
        &self,
        row: &Row,
        last: Option<f64>,
    ) -> Result<(f64, f64), ColumnFileError> {
        let refuse = |allowed| match self {
            Self::Date(column) => row.refuse(*column, allowed),
            Self::Seconds(column) => row.refuse_number(*column, allowed),
        };
        let (time_s, day_of_year) = match self {
            Self::Date(column) => parse_date(row.text(*column))
                .ok_or_else(|| refuse("a date and time such as 2024-03-01T14:00"))?,
            Self::Seconds(column) => {
                let time_s = row.number(*column)?;
                if !(time_s >= 0.0 && time_s.is_finite()) {
                    return Err(refuse("seconds since the midnight of a 1 January"));
                }
                (time_s, time_s % YEAR_S / DAY_S)
            }
        };
        if last.is_some_and(|last| time_s <= last) {
            return Err(refuse("a time after that of the row before"));
        }
        Ok((time_s, day_of_year))
    }
}

/// Time since the midnight of 1 January 1900, in s, and the day of the year, of a date such as `2024-03-01T14:00`.
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

//! The clock of tables of measurements: a date and time of the day, or seconds.
//!
//! A study's clock is the standard time of its place, all year. A stamp without a zone is taken for that. One with an offset, such
//! as `2024-07-01T14:00+02:00`, names an instant: it is told in the zone that the caller gives, otherwise at the offset of the first
//! row. A stamp in UTC (`Z`, `+00:00`) does not tell where the place is, so that the zone has to be given.

use crate::column_file::{ColumnFile, ColumnFileError, NumberColumn, Row, WordColumn};
use std::io::Read;

const DAY_S: f64 = 86_400.0;
const YEAR_S: f64 = 365.0 * DAY_S;

/// Offsets from UTC that standard times have, in h.
pub const UTC_OFFSETS_H: std::ops::RangeInclusive<f64> = -12.0..=14.0;

/// The clock of a table.
pub(crate) enum ClockColumn {
    /// `time`: dates such as `2024-03-01T14:00`, and the offset of the place's standard time from UTC, in s, as far as it is known.
    Date(WordColumn, Option<f64>),
    /// `time_s`: seconds since the midnight of a 1 January.
    Seconds(NumberColumn),
}

impl ClockColumn {
    /// Finds it.
    pub(crate) fn find(
        file: &mut ColumnFile<impl Read>,
        utc_offset_h: Option<f64>,
    ) -> Result<Self, ColumnFileError> {
        if let Some(column) = file.numbers(&["time_s"])? {
            return Ok(Self::Seconds(column));
        }
        let offset_s = utc_offset_h.map(|hours| 3600.0 * hours);
        Ok(Self::Date(file.need_words(&["time", "time_s"])?, offset_s))
    }

    /// Time since some midnight, in s, and day of the year with its fraction, of a row that has to come after a time.
    pub(crate) fn after(
        &mut self,
        row: &Row,
        last: Option<f64>,
    ) -> Result<(f64, f64), ColumnFileError> {
        let refuse = |clock: &Self, allowed| match clock {
            Self::Date(column, _) => row.refuse(*column, allowed),
            Self::Seconds(column) => row.refuse_number(*column, allowed),
        };
        let (time_s, day_of_year) = match self {
            Self::Date(column, place_s) => {
                let (stamp_s, offset_s) = parse_date(row.text(*column)).ok_or_else(|| {
                    row.refuse(*column, "a date and time such as 2024-03-01T14:00")
                })?;
                let time_s = match (offset_s, *place_s) {
                    (None, _) => stamp_s,
                    (Some(offset_s), Some(place_s)) => stamp_s - offset_s + place_s,
                    (Some(0.0), None) => {
                        return Err(row.refuse(
                            *column,
                            "a time of the place: this one is UTC; say by how many hours the place's standard time is ahead of it \
                             (--utc-offset, utc_offset_h in Python)",
                        ));
                    }
                    (Some(offset_s), None) => {
                        *place_s = Some(offset_s);
                        stamp_s
                    }
                };
                (time_s, day_of_year(time_s))
            }
            Self::Seconds(column) => {
                let time_s = row.number(*column)?;
                if !(time_s >= 0.0 && time_s.is_finite()) {
                    return Err(refuse(self, "seconds since the midnight of a 1 January"));
                }
                (time_s, time_s % YEAR_S / DAY_S)
            }
        };
        if last.is_some_and(|last| time_s <= last) {
            return Err(refuse(self, "a time after that of the row before"));
        }
        Ok((time_s, day_of_year))
    }
}

fn is_leap(year: u32) -> bool {
    year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
}

/// The day of the year, with its fraction, of a time since the midnight of 1 January 1900, in s.
fn day_of_year(time_s: f64) -> f64 {
    let whole = (time_s / DAY_S).floor();
    let mut day = whole;
    for year in 1900.. {
        let length = if is_leap(year) { 366.0 } else { 365.0 };
        if day < length {
            break;
        }
        day -= length;
    }
    day + (time_s - whole * DAY_S) / DAY_S
}

/// Time since the midnight of 1 January 1900, in s, of a date such as `2024-03-01T14:00`, and its offset from UTC, where it says one.
fn parse_date(text: &str) -> Option<(f64, Option<f64>)> {
    let (date, clock) = text.split_once(['T', ' '])?;
    let (clock, offset_s) = zone(clock.trim())?;
    let mut date = date.split('-').map(|part| part.parse::<u32>().ok());
    let (year, month, day) = (date.next()??, date.next()??, date.next()??);
    let mut clock = clock.split(':').map(|part| part.parse::<f64>().ok());
    let (hour, minute) = (clock.next()??, clock.next()??);
    let second = match clock.next() {
        None => 0.0,
        Some(second) => second?,
    };
    let february = if is_leap(year) { 29 } else { 28 };
    let lengths = [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let before = lengths.get(..month.checked_sub(1)? as usize)?;
    let in_range = *lengths.get(before.len())? >= day
        && day > 0
        && (1901..2200).contains(&year)
        && (0.0..24.0).contains(&hour)
        && (0.0..60.0).contains(&minute)
        && (0.0..60.0).contains(&second);
    if !in_range || date.next().is_some() || clock.next().is_some() {
        return None;
    }
    let days = before.iter().sum::<u32>() + day - 1;
    let years: u32 = (1900..year).map(|year| if is_leap(year) { 366 } else { 365 }).sum();
    let of_day_s = (hour * 60.0 + minute) * 60.0 + second;
    Some((f64::from(years + days) * DAY_S + of_day_s, offset_s))
}

/// A time of the day without the zone at its end, and the offset of that zone from UTC, in s.
fn zone(clock: &str) -> Option<(&str, Option<f64>)> {
    if let Some(clock) = clock.strip_suffix(['Z', 'z']) {
        return Some((clock, Some(0.0)));
    }
    let Some(at) = clock.find(['+', '-']) else { return Some((clock, None)) };
    let (clock, offset) = clock.split_at(at);
    let sign = if offset.starts_with('-') { -1.0 } else { 1.0 };
    let digits = offset[1..].replace(':', "");
    let (hours, minutes) = match digits.len() {
        2 => (digits.parse::<u32>().ok()?, 0),
        4 => (digits.get(..2)?.parse().ok()?, digits.get(2..)?.parse::<u32>().ok()?),
        _ => return None,
    };
    let offset_s = sign * f64::from(hours * 3600 + minutes * 60);
    (UTC_OFFSETS_H.contains(&(offset_s / 3600.0)) && minutes < 60)
        .then_some((clock.trim_end(), Some(offset_s)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// Hours from the first to the last row, and the day of the year of the last one.
    fn read(stamps: &[&str], utc_offset_h: Option<f64>) -> Result<(f64, f64), ColumnFileError> {
        let text = format!("time\n{}\n", stamps.join("\n"));
        let mut file = ColumnFile::new(Path::new("t.csv"), text.as_bytes())?;
        let mut clock = ClockColumn::find(&mut file, utc_offset_h)?;
        let (mut first, mut last) = (None, None);
        file.for_each(|row| {
            let (time_s, day) = clock.after(row, last.map(|(time_s, _)| time_s))?;
            first.get_or_insert(time_s);
            last = Some((time_s, day));
            Ok(())
        })?;
        let ((time_s, day), first_s) = (last.unwrap(), first.unwrap());
        Ok(((time_s - first_s) / 3600.0, day))
    }

    #[test]
    fn a_stamp_without_a_zone_is_the_clock_of_the_place() {
        let (hours, day) = read(&["2024-02-29T23:00", "2024-03-01 01:30:00"], None).unwrap();
        assert!(
            (hours - 2.5).abs() < 1e-9 && (day - 60.0 - 1.5 / 24.0).abs() < 1e-12,
            "{hours} {day}"
        );
        // whatever the zone of the others
        assert_eq!(
            read(&["2024-02-29T23:00", "2024-03-01 01:30:00"], Some(5.5)).unwrap(),
            (hours, day)
        );
    }

    #[test]
    fn utc_is_told_in_the_zone_of_the_place() {
        for stamp in ["2023-12-31T23:30Z", "2023-12-31 23:30:00+00:00", "2024-01-01T05:00+05:30"] {
            let (_, day) = read(&[stamp], Some(1.0)).unwrap();
            assert!((day - 0.5 / 24.0).abs() < 1e-12, "{stamp}: {day}");
            let (_, day) = read(&[stamp], Some(-3.5)).unwrap();
            assert!((day - 364.0 - 20.0 / 24.0).abs() < 1e-11, "{stamp}: {day}");
        }
        let told = read(&["2023-12-31T23:30Z"], None).unwrap_err().to_string();
        assert!(told.contains("line 2") && told.contains("--utc-offset"), "{told}");
    }

    #[test]
    fn summer_time_with_offsets_is_told_at_the_first_one() {
        // the clock jumps from 2 to 3 o'clock: an hour passes
        let (hours, day) =
            read(&["2024-03-31T01:00+01:00", "2024-03-31T03:00+02:00"], None).unwrap();
        assert!(
            (hours - 1.0).abs() < 1e-9 && (day - 90.0 - 2.0 / 24.0).abs() < 1e-12,
            "{hours} {day}"
        );
        // and back: 2:30 twice
        let back = ["2024-01-01T00:00+01:00", "2024-10-27T02:30+02:00", "2024-10-27T02:30+01:00"];
        let (_, day) = read(&back, None).unwrap();
        assert!((day - 300.0 - 2.5 / 24.0).abs() < 1e-11, "{day}");
    }

    #[test]
    fn what_is_no_time_is_refused() {
        for stamp in [
            "2024-03-01",
            "2024-13-01T00:00",
            "2023-02-29T00:00",
            "2024-03-01T24:00",
            "2024-03-01T00:00+25:00",
            "2024-03-01T00:00+1",
            "2024-03-01T00:00 CET",
        ] {
            let told = read(&[stamp], None).unwrap_err().to_string();
            assert!(told.contains(stamp) && told.contains("2024-03-01T14:00"), "{told}");
        }
        let told = read(&["2024-03-01T02:00", "2024-03-01T02:00"], None).unwrap_err().to_string();
        assert!(told.contains("line 3") && told.contains("after that of the row before"), "{told}");
    }
}

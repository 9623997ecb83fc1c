//! The clock of tables of measurements: a date and time of the day, or seconds.
//!
//! A study's clock is the standard time of its place, all year. A stamp without a zone is taken for
//! that. One with an offset, such as `2024-07-01T14:00+02:00`, names an instant: it is converted to
//! the zone that the caller gives, otherwise at the offset of the first row. A stamp in UTC (`Z`,
//! `+00:00`) does not tell where the place is, so that the zone has to be given.

use super::error::TableError;
use super::quantity::Quantity;
use super::{Row, Table};
use jiff::civil::{DateTime, date};
use jiff::fmt::temporal::Pieces;
use jiff::{Span, civil};

const DAY_S: f64 = 86_400.0;
const YEAR_S: f64 = 365.0 * DAY_S;

/// Offsets from UTC that standard times have, in h.
pub const UTC_OFFSETS_H: std::ops::RangeInclusive<f64> = -12.0..=14.0;

/// Where dates are counted from.
const ORIGIN: civil::Date = date(1900, 1, 1);

/// The clock of a table.
pub(crate) struct ClockColumn {
    /// Dates such as `2024-03-01T14:00`, or time since the midnight of a 1 January.
    quantity: Quantity,
    /// Offset of the place's standard time from UTC, in s, as far as it is known.
    place_s: Option<f64>,
}

impl ClockColumn {
    /// Finds it.
    pub(crate) fn find(table: &Table, utc_offset_h: Option<f64>) -> Result<Self, TableError> {
        let seconds = table.column(Quantity::Time);
        let any = [Quantity::Date, Quantity::Time];
        let column = seconds.map_or_else(|| table.need_any("time", &any), Ok)?;
        let place_s = utc_offset_h.map(|hours| 3600.0 * hours);
        Ok(Self { quantity: column.quantity, place_s })
    }

    /// Time since some midnight, in s, and day of the year with its fraction, of a row that has to
    /// come after a time.
    pub(crate) fn after(&mut self, row: &Row, last: Option<f64>) -> Result<(f64, f64), TableError> {
        let refuse = |allowed| row.refuse(self.quantity, allowed);
        let (time_s, day_of_year) = if self.quantity == Quantity::Date {
            let (stamp_s, offset_s) = parse_date(row.text(self.quantity))
                .ok_or_else(|| refuse("a date and time such as 2024-03-01T14:00"))?;
            let time_s = match (offset_s, self.place_s) {
                (Some(offset_s), Some(place_s)) => stamp_s - offset_s + place_s,
                (Some(0.0), None) => {
                    return Err(refuse(
                        "a time of the place: this one is UTC; say by how many hours the place's \
                         standard time is ahead of it (--utc-offset, utc_offset_h in Python)",
                    ));
                }
                _ => stamp_s,
            };
            self.place_s = self.place_s.or(offset_s);
            (time_s, day_of_year(time_s))
        } else {
            let time_s = row.number(self.quantity)?;
            if !(time_s >= 0.0 && time_s.is_finite()) {
                return Err(refuse("seconds since the midnight of a 1 January"));
            }
            (time_s, time_s % YEAR_S / DAY_S)
        };
        if last.is_some_and(|last| time_s <= last) {
            return Err(row.refuse(self.quantity, "a time after that of the row before"));
        }
        Ok((time_s, day_of_year))
    }
}

/// The day of the year, with its fraction, of a time since [`ORIGIN`], in s.
fn day_of_year(time_s: f64) -> f64 {
    let whole = (time_s / DAY_S).floor();
    let day = ORIGIN.saturating_add(Span::new().days(whole as i64)).day_of_year();
    f64::from(day - 1) + (time_s - whole * DAY_S) / DAY_S
}

/// Time since [`ORIGIN`], in s, of a date such as `2024-03-01T14:00`, and its offset from UTC,
/// where it says one.
fn parse_date(text: &str) -> Option<(f64, Option<f64>)> {
    let (date, clock) = text.split_once(['T', ' '])?;
    let (clock, zone) = clock.split_at(clock.find(['Z', 'z', '+', '-']).unwrap_or(clock.len()));
    let stamp = format!("{date} {}", clock.trim());
    let formats = ["%Y-%m-%d %H:%M:%S%.f", "%Y-%m-%d %H:%M"];
    let time = formats.iter().find_map(|format| DateTime::strptime(format, &stamp).ok())?;
    if !(1901..2200).contains(&time.year()) {
        return None;
    }
    let since = time.duration_since(ORIGIN.to_datetime(civil::Time::midnight()));
    let offset_s = if zone.is_empty() { None } else { Some(offset(zone)?) };
    Some((since.as_secs_f64(), offset_s))
}

/// The offset from UTC, in s, of the zone at the end of a date.
fn offset(zone: &str) -> Option<f64> {
    let pieces = format!("2000-01-01T00:00{zone}");
    let offset = Pieces::parse(&pieces).ok()?.to_numeric_offset()?;
    let offset_s = f64::from(offset.seconds());
    UTC_OFFSETS_H.contains(&(offset_s / 3600.0)).then_some(offset_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::Source;
    use std::path::Path;

    /// Hours from the first to the last row, and the day of the year of the last one.
    fn read(stamps: &[&str], utc_offset_h: Option<f64>) -> Result<(f64, f64), TableError> {
        let text = format!("time\n{}\n", stamps.join("\n"));
        let source = Source::Text(Path::new("t.csv"), &text);
        let file = Table::open(source, &crate::table::formats::WEATHER, &[])?;
        let mut clock = ClockColumn::find(&file, utc_offset_h)?;
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
        let message = read(&["2023-12-31T23:30Z"], None).unwrap_err().to_string();
        assert!(message.contains("line 2") && message.contains("--utc-offset"), "{message}");
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
            let message = read(&[stamp], None).unwrap_err().to_string();
            assert!(message.contains(stamp) && message.contains("2024-03-01T14:00"), "{message}");
        }
        let message =
            read(&["2024-03-01T02:00", "2024-03-01T02:00"], None).unwrap_err().to_string();
        assert!(
            message.contains("line 3") && message.contains("after that of the row before"),
            "{message}"
        );
    }
}

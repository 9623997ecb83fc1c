//! The clock of tables of measurements: a date and time of the day, or seconds.
//!
//! A study's clock is the standard time of its place, all year. A stamp without a zone is taken for
//! that, or for the clock of a zone, with its summer time, where the caller names one. One with an
//! offset, such as `2024-07-01T14:00+02:00`, names an instant: it is converted to
//! the zone that the caller gives, otherwise at the offset of the first row. A stamp in UTC (`Z`,
//! `+00:00`) does not tell where the place is, so that the zone has to be given.

use super::date::{self, day_of_year, may_change_clocks};
use super::dwd;
use super::error::TableError;
use super::quantity::Quantity;
use super::{Row, Table};
use crate::intake::Finding;
use jiff::tz::TimeZone;

use super::date::UTC_OFFSETS_H;

const DAY_S: f64 = 86_400.0;
const HOUR_S: f64 = 3600.0;
const YEAR_S: f64 = 365.0 * DAY_S;

/// The clock of the place, where a caller knows it.
#[derive(Clone, Debug)]
pub enum PlaceClock {
    /// Hours by which its standard time is ahead of UTC.
    Ahead(f64),
    /// A zone: times without an offset are its local times, with summer time.
    Zone(TimeZone),
}

impl PlaceClock {
    /// A standard time.
    ///
    /// # Errors
    /// What is allowed.
    pub fn ahead(hours: f64) -> Result<Self, String> {
        let [least, most] = [UTC_OFFSETS_H.start(), UTC_OFFSETS_H.end()];
        let is_one = UTC_OFFSETS_H.contains(&hours);
        is_one
            .then_some(Self::Ahead(hours))
            .ok_or_else(|| format!("allowed are hours from {least} to {most}"))
    }

    /// The zone of a name.
    ///
    /// # Errors
    /// What is allowed.
    pub fn zone(name: &str) -> Result<Self, String> {
        let zone = date::zone(name).map(Self::Zone);
        zone.ok_or_else(|| {
            format!(
                "`{name}` is no time zone: allowed are names such as Europe/Berlin or \
                 America/Chicago"
            )
        })
    }
}

/// The clock of a table.
pub(crate) struct ClockColumn {
    /// Dates such as `2024-03-01T14:00`, or time since the midnight of a 1 January.
    quantity: Quantity,
    /// Offset of the place's standard time from UTC, in s, as far as it is known.
    place_s: Option<f64>,
    zone: Option<TimeZone>,
    /// The instant of the row before, in s of UTC.
    last_utc_s: f64,
    /// A column of UTC by its name, which says no zone.
    utc: Option<String>,
    changes: ClockChanges,
}

/// Changes between standard and summer time of a clock that says no zone: the hour that is missing
/// in spring and the hour that comes twice in autumn. Times go on as if the clock had not changed.
#[derive(Clone, Debug, Default)]
pub(crate) struct ClockChanges {
    /// Time that is added to the clock, in s.
    added_s: f64,
    /// The last stamp, and the time between the last two.
    last: Option<f64>,
    step_s: Option<f64>,
    seen: Vec<&'static str>,
}

impl ClockChanges {
    /// The time that goes on, of the next stamp, in s.
    pub(crate) fn continued(&mut self, stamp_s: f64) -> f64 {
        let step_s = self.last.map(|last| stamp_s - last);
        if let (Some(step_s), Some(usual_s)) = (step_s, self.step_s)
            && usual_s > 0.0
            && usual_s <= HOUR_S
            && may_change_clocks(stamp_s)
        {
            let is = |wanted: f64| (step_s - usual_s - wanted).abs() < 1e-3 + 0.5 * usual_s;
            if is(-HOUR_S) {
                self.added_s += HOUR_S;
                self.seen.push("set back");
            } else if is(HOUR_S) {
                self.added_s -= HOUR_S;
                self.seen.push("put forward");
            }
        } else if step_s.is_some() {
            self.step_s = step_s;
        }
        self.last = Some(stamp_s);
        stamp_s + self.added_s
    }

    /// Changes that were made up for.
    pub(crate) fn finding(&self) -> Option<Finding> {
        let count = self.seen.len();
        let first = self.seen.first()?;
        let text = format!(
            "the clock changes between summer and standard time (first {first} by an hour): times \
             go on in the time of the first row"
        );
        (count > 0).then(|| Finding::mended("clock-change", [count as f64, 0.0], text))
    }
}

impl ClockColumn {
    /// Finds it.
    pub(crate) fn find(table: &Table, place: Option<&PlaceClock>) -> Result<Self, TableError> {
        let seconds = table.column(Quantity::Time);
        let any = [Quantity::Date, Quantity::Day, Quantity::Time];
        let column = seconds.map_or_else(|| table.need_any("time", &any), Ok)?;
        let name = &table.names()[column.place];
        let is_utc = dwd::is_clock(name);
        let (place_s, zone) = match place {
            None => (None, None),
            Some(PlaceClock::Ahead(hours)) => (Some(3600.0 * hours), None),
            Some(PlaceClock::Zone(zone)) => (None, Some(zone.clone())),
        };
        let utc = is_utc.then(|| name.clone());
        let (changes, last_utc_s) = (ClockChanges::default(), f64::NEG_INFINITY);
        Ok(Self { quantity: column.quantity, place_s, zone, last_utc_s, utc, changes })
    }

    /// Whether its times are dates.
    pub(crate) fn is_dated(&self) -> bool {
        self.quantity.is_text()
    }

    /// The clock of the place, as far as the rows tell it.
    pub(crate) fn place(&self) -> Option<PlaceClock> {
        let ahead = || self.place_s.map(|place_s| PlaceClock::Ahead(place_s / HOUR_S));
        self.zone.clone().map(PlaceClock::Zone).or_else(ahead)
    }

    /// Corrections that were made, and oddities.
    pub(crate) fn findings(&self) -> Vec<Finding> {
        let unplaced = self.utc.as_ref().filter(|_| self.place_s.is_none() && self.zone.is_none());
        let of_utc = unplaced.map(|name| {
            let text = format!(
                "the times of `{name}` are UTC, and are taken for the standard time of the place: \
                 hours of the day are off by as much"
            );
            let remedy = "say where it is, as in --zone Europe/Berlin (zone in Python)";
            Finding::warned("utc-stamps", [0.0, 0.0], text, remedy)
        });
        of_utc.into_iter().chain(self.changes.finding()).collect()
    }

    /// The standard time of the place, in s since 1900, of a stamp.
    fn place_time_s(&mut self, stamp_s: f64, offset_s: Option<f64>) -> Option<f64> {
        let offset_s = offset_s.or(self.utc.is_some().then_some(0.0));
        if let Some(zone) = &self.zone {
            let utc_s = if let Some(offset_s) = offset_s {
                stamp_s - offset_s
            } else {
                let [earlier, later] = date::instants(zone, stamp_s)?;
                if earlier > self.last_utc_s { earlier } else { later }
            };
            self.last_utc_s = utc_s;
            let ahead_s = self.place_s.unwrap_or_else(|| date::standard_offset_s(zone, utc_s));
            self.place_s = Some(ahead_s);
            return Some(utc_s + ahead_s);
        }
        let time_s = match (offset_s, self.place_s) {
            (Some(offset_s), Some(place_s)) => stamp_s - offset_s + place_s,
            (Some(_), None) => stamp_s,
            (None, _) => self.changes.continued(stamp_s),
        };
        if self.utc.is_none() {
            self.place_s = self.place_s.or(offset_s);
        }
        Some(time_s)
    }

    /// Time since some midnight, in s, and day of the year with its fraction, of a row that has to
    /// come after a time.
    pub(crate) fn after(&mut self, row: &Row, last: Option<f64>) -> Result<(f64, f64), TableError> {
        let quantity = self.quantity;
        let refuse = |allowed| row.refuse(quantity, allowed);
        let (time_s, day_of_year) = if quantity.is_text() {
            let wanted = "a date and time such as 2024-03-01T14:00 (of 3/1/2024 it is not clear \
                          which is the month)";
            let (stamp_s, offset_s) = date::parse(&dated(row)).ok_or_else(|| refuse(wanted))?;
            if offset_s == Some(0.0) && self.place_s.is_none() && self.zone.is_none() {
                return Err(refuse(
                    "a time of the place: this one is UTC; say where it is (--zone Europe/Berlin, \
                     zone in Python), or by how many hours the place's standard time is ahead of \
                     it (--utc-offset, utc_offset_h in Python)",
                ));
            }
            let time_s = self.place_time_s(stamp_s, offset_s).ok_or_else(|| refuse(wanted))?;
            (time_s, day_of_year(time_s))
        } else {
            let time_s = row.number(quantity)?;
            if !(time_s >= 0.0 && time_s.is_finite()) {
                return Err(refuse("seconds since the midnight of a 1 January"));
            }
            (time_s, time_s % YEAR_S / DAY_S)
        };
        if last.is_some_and(|last| time_s <= last) {
            return Err(row.refuse(quantity, "a time after that of the row before"));
        }
        Ok((time_s, day_of_year))
    }
}

/// The clock of a log: dates and times, with or without a zone.
#[derive(Clone, Debug, Default)]
pub(crate) struct LogClock {
    changes: ClockChanges,
    /// Days that have passed since the first row, of times of the day, and the last one.
    days: f64,
    last_s: Option<f64>,
}

/// The date of a row, from one column or from two.
pub(crate) fn dated(row: &Row) -> String {
    let (day, time) = (row.text(Quantity::Day), row.text(Quantity::Date));
    if day.is_empty() || time.is_empty() { format!("{day}{time}") } else { format!("{day} {time}") }
}

impl LogClock {
    /// Time since some midnight, in s, of a date; NaN of an empty cell, the text of another one.
    pub(crate) fn time_s(&mut self, text: &str) -> Result<f64, String> {
        if text.is_empty() {
            return Ok(f64::NAN);
        }
        match date::parse(text) {
            Some((stamp_s, Some(offset_s))) => Ok(stamp_s - offset_s),
            Some((stamp_s, None)) => Ok(self.changes.continued(stamp_s)),
            None => self.time_of_day_s(text).ok_or_else(|| text.to_owned()),
        }
    }

    /// Time since the midnight before the first row, in s, of a time of the day.
    fn time_of_day_s(&mut self, text: &str) -> Option<f64> {
        let second_s = date::second_of_day(text)?;
        // half a day back is the next day
        if self.last_s.is_some_and(|last_s| second_s < last_s - 0.5 * DAY_S) {
            self.days += 1.0;
        }
        self.last_s = Some(second_s);
        Some(second_s + DAY_S * self.days)
    }

    /// Changes that were made up for.
    pub(crate) fn finding(&self) -> Option<Finding> {
        self.changes.finding()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intake::table::Source;
    use std::path::Path;

    /// Hours from the first to the last row, and the day of the year of the last one.
    fn read(stamps: &[&str], utc_offset_h: Option<f64>) -> Result<(f64, f64), TableError> {
        let text = format!("time\n{}\n", stamps.join("\n"));
        let source = Source::Text(Path::new("t.csv"), &text);
        let file = Table::open(source, &crate::intake::table::formats::WEATHER, &[])?;
        let mut clock = ClockColumn::find(&file, utc_offset_h.map(PlaceClock::Ahead).as_ref())?;
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
    fn a_time_some_seconds_back_is_of_the_same_day_and_one_behind_midnight_of_the_next() {
        let mut clock = LogClock::default();
        let rows = ["23:59:58", "23:59:57", "00:00:01", "00:00:00"];
        let times_s = rows.map(|row| clock.time_s(row).unwrap());
        assert_eq!(times_s, [86_398.0, 86_397.0, 86_401.0, 86_400.0]);
    }

    #[test]
    fn what_is_no_time_is_refused() {
        for stamp in [
            "2024-03-01",
            "2024-13-01T00:00",
            "2023-02-29T00:00",
            "2024-03-01T24:30",
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

//! Dates and times as they are written: ISO 8601 with or without a zone, points and slashes, digits
//! alone, hours up to 24.

use jiff::civil::{self, DateTime, date};
use jiff::fmt::temporal::Pieces;
use jiff::{Span, ToSpan};

/// Offsets from UTC that standard times have, in h.
pub const UTC_OFFSETS_H: std::ops::RangeInclusive<f64> = -12.0..=14.0;

const DAY_S: f64 = 86_400.0;

/// Where dates are counted from.
const ORIGIN: civil::Date = date(1900, 1, 1);

/// Forms of a date without its clock; the order of day and month is only clear with points, or
/// where the year comes first.
const DATES: [&str; 4] = ["%Y-%m-%d", "%Y/%m/%d", "%d.%m.%Y", "%Y%m%d"];
const CLOCKS: [&str; 3] = ["%H:%M:%S%.f", "%H:%M", "%H"];

/// Time since 1900, in s, and the offset from UTC, where the text says one; none where it is no
/// date with a time.
pub(crate) fn parse(text: &str) -> Option<(f64, Option<f64>)> {
    let text = text.trim();
    if text.bytes().all(|byte| byte.is_ascii_digit()) {
        // year, month, day, hour, and minute and second where they are there
        let (day, clock) = text.split_at_checked(8)?;
        let pairs: Vec<&str> = (0..clock.len() / 2).map(|k| &clock[2 * k..2 * k + 2]).collect();
        let whole = matches!(clock.len(), 2 | 4 | 6);
        return whole.then(|| stamp(day, &pairs.join(":"), None)).flatten();
    }
    let (day, clock) = text.split_once(['T', ' '])?;
    let (clock, zone) = clock.split_at(clock.find(['Z', 'z', '+', '-']).unwrap_or(clock.len()));
    let offset_s = if zone.is_empty() { None } else { Some(offset(zone)?) };
    stamp(day, clock.trim(), offset_s)
}

fn stamp(day: &str, clock: &str, offset_s: Option<f64>) -> Option<(f64, Option<f64>)> {
    // the end of a day is the beginning of the next one
    let end = clock.strip_prefix("24").filter(|rest| rest.chars().all(|c| ":0.".contains(c)));
    let clock = if end.is_some() { "00:00" } else { clock };
    let mut forms = DATES.iter().flat_map(|day| CLOCKS.iter().map(move |clock| (day, clock)));
    let text = format!("{day} {clock}");
    let time =
        forms.find_map(|(day, clock)| DateTime::strptime(format!("{day} {clock}"), &text).ok())?;
    let time = if end.is_some() { time.checked_add(1.day()).ok()? } else { time };
    if !(1901..2200).contains(&time.year()) {
        return None;
    }
    let since = time.duration_since(ORIGIN.to_datetime(civil::Time::midnight()));
    Some((since.as_secs_f64(), offset_s))
}

/// The day of the year, with its fraction, of a time since 1900, in s.
pub(super) fn day_of_year(time_s: f64) -> f64 {
    let whole = (time_s / DAY_S).floor();
    let day = ORIGIN.saturating_add(Span::new().days(whole as i64)).day_of_year();
    f64::from(day - 1) + (time_s - whole * DAY_S) / DAY_S
}

/// Time since the beginning of its year, in s, of a date with or without a time.
pub(crate) fn second_of_year(text: &str) -> Option<f64> {
    let whole_day = || stamp(text.trim(), "00:00", None);
    let (time_s, _) = parse(text).or_else(whole_day)?;
    // months are those of a year without a leap day: its 29 February is a second 28th
    let day = day_of_year(time_s);
    let is_leap =
        day_of_year(stamp(&format!("{}-12-31", year_of(time_s)), "00:00", None)?.0) > 364.5;
    Some((if is_leap && day >= 59.0 { day - 1.0 } else { day }) * DAY_S)
}

fn year_of(time_s: f64) -> i16 {
    let whole = (time_s / DAY_S).floor();
    ORIGIN.saturating_add(Span::new().days(whole as i64)).year()
}

/// Whether a time since 1900, in s, lies in the night in which clocks change: the first hours of a
/// Sunday from September to November, or from March to May.
pub(super) fn may_change_clocks(time_s: f64) -> bool {
    let whole = (time_s / DAY_S).floor();
    let day = ORIGIN.saturating_add(Span::new().days(whole as i64));
    day.weekday() == civil::Weekday::Sunday
        && matches!(day.month(), 3..=5 | 9..=11)
        && time_s - whole * DAY_S <= 4.0 * 3600.0
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

    #[test]
    fn one_moment_in_its_forms() {
        let wanted = parse("2024-03-01T14:30").unwrap();
        for text in [
            "2024-03-01 14:30:00",
            "2024/03/01 14:30",
            "01.03.2024 14:30:00.000",
            "202403011430",
            "20240301143000",
            "20240301 14:30",
        ] {
            assert_eq!(parse(text), Some(wanted), "{text}");
        }
        assert_eq!(parse("2024-02-29T24:00"), parse("2024-03-01T00:00"));
        assert_eq!(parse("2024030114"), parse("2024-03-01T14:00"));
        assert_eq!(parse("2024-03-01T14:30:00.5+02:00"), Some((wanted.0 + 0.5, Some(7200.0))));
        for text in ["03/01/2024 14:30", "2024-03-01T24:30", "2024-13-01T00:00", "12.5", "0", ""] {
            assert_eq!(parse(text), None, "{text}");
        }
    }

    #[test]
    fn clocks_change_in_a_night_to_sunday() {
        let may = |text: &str| may_change_clocks(parse(text).unwrap().0);
        assert!(may("2024-10-27T02:30") && may("2024-03-31T03:00"));
        assert!(!may("2024-10-26T02:30") && !may("2024-10-27T12:00") && !may("2024-07-28T02:30"));
    }
}

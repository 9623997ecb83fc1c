//! Dates and times as they are written: ISO 8601 with or without a zone, points and slashes, digits
//! alone, hours up to 24.

use jiff::civil::{self, DateTime, date};
use jiff::fmt::temporal::Pieces;
use jiff::tz::TimeZone;
use jiff::{SignedDuration, Span, ToSpan};

/// Offsets from UTC that standard times have, in h.
pub(super) const UTC_OFFSETS_H: std::ops::RangeInclusive<f64> = -12.0..=14.0;

const DAY_S: f64 = 86_400.0;

/// Where dates are counted from.
const ORIGIN: civil::Date = date(1900, 1, 1);

/// Forms of a date without its clock; the order of day and month is only clear with points, or
/// where the year comes first.
const DATES: [&str; 4] = ["%Y-%m-%d", "%Y/%m/%d", "%d.%m.%Y", "%Y%m%d"];
const CLOCKS: [&str; 6] = ["%H:%M:%S%.f", "%H:%M", "%H", "%I:%M:%S%.f %p", "%I:%M %p", "%I %p"];

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
    // a name behind the offset, `[Europe/Berlin]`, says no more than the offset
    let (clock, name) = clock.split_once('[').unwrap_or((clock, ""));
    let (clock, zone) = clock.split_at(clock.find(['Z', 'z', '+', '-']).unwrap_or(clock.len()));
    if zone.is_empty() && !name.is_empty() {
        return None;
    }
    let offset_s = if zone.is_empty() { None } else { Some(offset(zone)?) };
    stamp(day, clock.trim(), offset_s)
}

/// Time since midnight, in s, of a time of the day without a date; none of anything else.
pub(crate) fn second_of_day(text: &str) -> Option<f64> {
    let (time_s, offset_s) =
        text.contains(':').then(|| stamp("1901-01-01", text.trim(), None))??;
    offset_s.is_none().then_some(time_s % DAY_S)
}

/// A standard zone of a place by its name, such as `Europe/Berlin`.
pub(super) fn zone(name: &str) -> Option<TimeZone> {
    TimeZone::get(name).ok()
}

/// Times since 1900 in UTC, in s, that the clock of a zone shows as a time since 1900: the earlier
/// and the later one where clocks were set back.
pub(super) fn instants(zone: &TimeZone, local_s: f64) -> Option<[f64; 2]> {
    let whole_s = local_s.floor();
    let local = ORIGIN.to_datetime(civil::Time::midnight());
    let local = local.checked_add(SignedDuration::from_secs(whole_s as i64)).ok()?;
    let instants = zone.to_ambiguous_timestamp(local);
    let since =
        |instant: jiff::Timestamp| (instant.as_second() - origin_s()) as f64 + local_s - whole_s;
    Some([since(instants.earlier().ok()?), since(instants.later().ok()?)])
}

/// Offset of the standard time of a zone from UTC, in s, in the year of a time since 1900.
pub(super) fn standard_offset_s(zone: &TimeZone, time_s: f64) -> f64 {
    let months = (0..12).map(|month| time_s + f64::from(month) * 30.0 * DAY_S);
    let offset = |time_s: f64| {
        let instant = jiff::Timestamp::from_second(time_s as i64 + origin_s());
        instant.map_or(0.0, |instant| f64::from(zone.to_offset(instant).seconds()))
    };
    months.map(offset).fold(f64::INFINITY, f64::min)
}

/// The origin of times, in s since 1970.
fn origin_s() -> i64 {
    -(25_567 * DAY_S as i64)
}

fn stamp(day: &str, clock: &str, offset_s: Option<f64>) -> Option<(f64, Option<f64>)> {
    // the end of a day is the beginning of the next one
    let end = clock.strip_prefix("24").filter(|rest| rest.chars().all(|c| ":0.".contains(c)));
    let clock = if end.is_some() { "00:00" } else { clock };
    let clock = clock.replace(',', ".");
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

/// Time since 1900, in s, of a date with or without a time, as its clock shows it.
pub(crate) fn time_of(text: &str) -> Option<f64> {
    let whole_day = || stamp(text.trim(), "00:00", None);
    Some(parse(text).or_else(whole_day)?.0)
}

/// Time since the beginning of its year, in s, of a date with or without a time.
pub(crate) fn second_of_year(text: &str) -> Option<f64> {
    let time_s = time_of(text)?;
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
            "2024-03-01 02:30:00 PM",
            "2024-03-01 2:30 pm",
            "2024-03-01T14:30:00,000",
        ] {
            assert_eq!(parse(text), Some(wanted), "{text}");
        }
        let offset = parse("2024-03-01T14:30+01:00[Europe/Berlin]").unwrap();
        assert_eq!(offset, (wanted.0, Some(3600.0)));
        assert_eq!(parse("2024-03-01T14:30[Europe/Berlin]"), None);
        assert_eq!(second_of_day("14:30:02.5"), Some(52_202.5));
        assert_eq!(second_of_day("14"), None);
        assert_eq!(parse("2024-02-29T24:00"), parse("2024-03-01T00:00"));
        assert_eq!(parse("2024030114"), parse("2024-03-01T14:00"));
        assert_eq!(parse("2024-03-01T14:30:00.5+02:00"), Some((wanted.0 + 0.5, Some(7200.0))));
        for text in ["03/01/2024 14:30", "2024-03-01T24:30", "2024-13-01T00:00", "12.5", "0", ""] {
            assert_eq!(parse(text), None, "{text}");
        }
    }

    #[test]
    fn zones_tell_the_instant_and_their_standard_time() {
        let berlin = zone("Europe/Berlin").unwrap();
        let utc = |text: &str| parse(text).unwrap().0;
        let instants_of = |text: &str| instants(&berlin, utc(text)).unwrap();
        assert_eq!(instants_of("2024-07-01T14:00"), [utc("2024-07-01T12:00"); 2]);
        assert_eq!(instants_of("2024-01-01T14:00"), [utc("2024-01-01T13:00"); 2]);
        assert_eq!(
            instants_of("2024-10-27T02:30"),
            [utc("2024-10-27T00:30"), utc("2024-10-27T01:30")]
        );
        assert_eq!(standard_offset_s(&berlin, utc("2024-07-01T14:00")), 3600.0);
        assert_eq!(
            standard_offset_s(&zone("Europe/Dublin").unwrap(), utc("2024-07-01T14:00")),
            0.0
        );
        assert!(zone("Mars/Olympus").is_none());
    }

    #[test]
    fn clocks_change_in_a_night_to_sunday() {
        let may = |text: &str| may_change_clocks(parse(text).unwrap().0);
        assert!(may("2024-10-27T02:30") && may("2024-03-31T03:00"));
        assert!(!may("2024-10-26T02:30") && !may("2024-10-27T12:00") && !may("2024-07-28T02:30"));
    }
}

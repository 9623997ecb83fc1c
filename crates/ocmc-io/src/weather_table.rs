//! Tables of hourly weather, one row an hour, as weather services give them.
//!
//! The clock is the place's standard time all year ([`crate::intake::table::clock`]). Beside it
//! stands any of the quantities of the weather. Services give a table for each of them, too: those
//! of one station are joined by time.

use crate::intake::table::clock::{ClockColumn, PlaceClock};
use crate::intake::table::formats::WEATHER;
use crate::intake::table::{Mapping, Quantity, Source, Table, TableError};
use crate::intake::{FileAccount, Finding};
use crate::number_text::{count_of, rounded};
use ocmc_core::operating_cycle::weather::{STANDARD_WEATHER, Weather};
use ocmc_estimation::fit::weather::HourlyRecord;
use std::collections::BTreeMap;

const HOUR_S: f64 = 3600.0;

/// Where a variable of the weather is kept.
type Into = fn(&mut Weather) -> &mut f64;

const VARIABLES: [(Quantity, Into); 6] = [
    (Quantity::Temperature, |weather| &mut weather.temperature_k),
    (Quantity::Pressure, |weather| &mut weather.pressure_pa),
    (Quantity::RelativeHumidity, |weather| &mut weather.relative_humidity),
    (Quantity::Precipitation, |weather| &mut weather.precipitation_mps),
    (Quantity::WindSpeed, |weather| &mut weather.wind_speed_mps),
    (Quantity::WindDirection, |weather| &mut weather.wind_direction_rad),
];

/// Reads tables of hourly weather of one station, joined by time; `place` is the clock of the
/// place, where that is known. Of two values of one hour that of the first table is taken.
///
/// # Errors
/// [`TableError`] names the file, the place in it and what is allowed.
pub fn read(
    sources: &[Source],
    mappings: &[Mapping],
    place: Option<&PlaceClock>,
) -> Result<(Vec<HourlyRecord>, Vec<FileAccount>), TableError> {
    let (mut accounts, mut joined) = (Vec::new(), Joined::default());
    let mut place = place.cloned();
    for source in sources {
        let Series { records, mut account, clock, site } =
            series(*source, mappings, place.as_ref())?;
        let findings = joined.add(records, clock.is_dated(), &site);
        account.judged(source.path(), findings)?;
        // a clock that the first rows set is that of all
        place = clock.place();
        accounts.push(account);
    }
    let told = joined.told(accounts.len());
    let mut records: Vec<HourlyRecord> =
        joined.hours.into_values().map(|(record, _)| record).collect();
    if let Some(account) = accounts.first_mut() {
        account.findings.extend(told);
        account.findings.extend(hourly(&mut records));
    }
    Ok((records, accounts))
}

/// A table as it was read.
struct Series {
    records: Vec<HourlyRecord>,
    account: FileAccount,
    clock: ClockColumn,
    /// Its station; empty where it does not say one.
    site: String,
}

fn series(
    source: Source,
    mappings: &[Mapping],
    place: Option<&PlaceClock>,
) -> Result<Series, TableError> {
    let file = Table::open(source, &WEATHER, mappings)?;
    file.refuse_other_units()?;
    let mut clock = ClockColumn::find(&file, place)?;
    file.need_any("weather", &VARIABLES.map(|(quantity, _)| quantity))?;
    let has = VARIABLES.map(|(quantity, _)| file.column(quantity).is_some());
    let (mut records, mut site) = (Vec::<HourlyRecord>::new(), String::new());
    let mut missing = [0_u64; VARIABLES.len()];
    let mut account = file.for_each(|row| {
        let last = records.last().map(|last| last.time_s);
        let (time_s, day_of_year) = clock.after(row, last)?;
        let mut weather = STANDARD_WEATHER;
        for ((quantity, into), missing) in VARIABLES.into_iter().zip(&mut missing) {
            let number = row.number(quantity)?;
            *missing += u64::from(number.is_nan());
            *into(&mut weather) = number;
        }
        if site.is_empty() {
            row.text(Quantity::Site).clone_into(&mut site);
        }
        records.push(HourlyRecord { time_s, day_of_year, weather });
        Ok(())
    })?;
    account.findings.extend(clock.findings());
    let lacking = VARIABLES.iter().zip(missing).zip(has);
    let lacking = lacking.filter(|((_, missing), has)| *has && *missing > 0);
    let lacking: Vec<String> = lacking
        .map(|(((quantity, _), missing), _)| format!("{} in {missing}", quantity.name()))
        .collect();
    if !lacking.is_empty() {
        let text = format!("missing of {} rows: {}", account.rows, lacking.join(", "));
        account.findings.push(Finding::noted("missing-hours", [0.0, 0.0], text, ""));
    }
    Ok(Series { records, account, clock, site })
}

/// Hours of several tables.
#[derive(Default)]
struct Joined {
    /// By their second: the weather, and the number of tables that have the hour.
    hours: BTreeMap<i64, (HourlyRecord, usize)>,
    /// Whether the times of the first table are dates, and its station.
    first: Option<(bool, String)>,
}

impl Joined {
    /// Adds a table, and says what does not fit to those before.
    fn add(&mut self, records: Vec<HourlyRecord>, is_dated: bool, site: &str) -> Vec<Finding> {
        let (first_dated, first_site) =
            self.first.get_or_insert_with(|| (is_dated, site.to_owned()));
        let mut findings = Vec::new();
        if !site.is_empty() && !first_site.is_empty() && site != first_site {
            let text = format!("it is of station {site}, the first file of {first_site}");
            let remedy = "give files of one station";
            findings.push(Finding::refused("two-stations", [2.0, 1.0], text, remedy));
        }
        if is_dated != *first_dated {
            let text = "its times and those of the first file are dates here and seconds there";
            let remedy = "give dates, or seconds, in all of them";
            findings.push(Finding::refused("two-clocks", [2.0, 1.0], text.to_owned(), remedy));
        }
        let (mut both, mut first) = (0_u64, None);
        for record in records {
            let key = record.time_s.round() as i64;
            let (known, files) = self.hours.entry(key).or_insert((record, 0));
            *files += 1;
            let mut weather = record.weather;
            for (quantity, into) in VARIABLES {
                let (old, new) = (into(&mut known.weather), *into(&mut weather));
                if old.is_nan() {
                    *old = new;
                } else if new.is_finite() && (*old - new).abs() > 1e-9 * old.abs() {
                    both += 1;
                    first.get_or_insert((quantity, *old, new));
                }
            }
        }
        findings.extend(first.map(|(quantity, old, new)| {
            let text = format!(
                "{} differ from those of a file before it, first {} with {} and {} (SI): those \
                 before are used",
                count_of(both, "value"),
                quantity.name(),
                rounded(old),
                rounded(new)
            );
            Finding::warned("two-values", [both as f64, 0.0], text, "which file is right?")
        }));
        findings
    }

    /// Finding on what was joined, of so many tables.
    fn told(&self, files: usize) -> Option<Finding> {
        let common = self.hours.values().filter(|(_, count)| *count == files).count();
        let all = self.hours.len();
        let text = format!(
            "joined by time with {}: {all} hours, {common} of them in every file",
            count_of(files as u64 - 1, "other file")
        );
        (files > 1).then(|| Finding::noted("joined", [common as f64, all as f64], text, ""))
    }
}

/// Leaves a record an hour of records that are closer: the laws are those of hours. Full hours
/// where there are some, otherwise every first one an hour after the last.
fn hourly(records: &mut Vec<HourlyRecord>) -> Option<Finding> {
    let mut steps_s: Vec<f64> =
        records.windows(2).map(|pair| pair[1].time_s - pair[0].time_s).collect();
    steps_s.sort_by(f64::total_cmp);
    let step_s = *steps_s.get(steps_s.len() / 2)?;
    if step_s >= HOUR_S - 1.0 {
        return None;
    }
    let into_hour_s = |time_s: f64| {
        let rest = time_s.rem_euclid(HOUR_S);
        rest.min(HOUR_S - rest)
    };
    let all = records.len();
    let is_full = |record: &HourlyRecord| into_hour_s(record.time_s) <= 1.0;
    // rows at full hours now and then are not those of a clock that has them all
    let has_full = records.iter().filter(|record| is_full(record)).count() as f64
        > 0.5 * all as f64 * step_s / HOUR_S;
    let mut last_s = f64::NEG_INFINITY;
    records.retain(|record| {
        let keep = if has_full { is_full(record) } else { record.time_s - last_s >= HOUR_S - 1.0 };
        last_s = if keep { record.time_s } else { last_s };
        keep
    });
    let which = if has_full { "at full hours" } else { "an hour apart" };
    let text = format!(
        "rows are {} min apart: the {} of {all} {which} are used",
        rounded(step_s / 60.0),
        records.len()
    );
    Some(Finding::mended("closer-than-hours", [step_s, HOUR_S], text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn table(text: &str) -> Result<Vec<HourlyRecord>, TableError> {
        read(&[Source::Text(Path::new("hours.csv"), text)], &[], None).map(|(records, _)| records)
    }

    /// Series of the German weather service as it publishes them.
    const SERIES: [&str; 3] = [
        "STATIONS_ID;MESS_DATUM;QN_9;TT_TU;RF_TU;eor\n\
         \u{20}         433;2023123122;    3;  -5.9;  80.0;eor\n\
         \u{20}         433;2023123123;    3;-999  ;  81.0;eor\n",
        "STATIONS_ID;MESS_DATUM;QN_3;   F;   D;eor\n\
         \u{20}         433;2023123123;    3;   4.2; 180;eor\n\
         \u{20}         433;2024010100;    3;-999;-999;eor\n",
        "STATIONS_ID;MESS_DATUM;QN_8;   P;  P0;eor\n\
         \u{20}         433;2023123123;    3; 1020.0; 1013.5;eor\n",
    ];

    fn joined(texts: &[&str]) -> Result<(Vec<HourlyRecord>, Vec<FileAccount>), TableError> {
        let named = texts.iter().map(|text| Source::Text(Path::new("produkt.txt"), text));
        read(&named.collect::<Vec<_>>(), &[], Some(&PlaceClock::Ahead(1.0)))
    }

    #[test]
    fn series_of_the_german_weather_service_are_joined() {
        let (records, accounts) = joined(&SERIES).unwrap();
        let hours: Vec<f64> =
            records.iter().map(|record| (record.day_of_year * 24.0).round()).collect();
        assert_eq!(hours, [8759.0, 0.0, 1.0]);
        let weather = records[1].weather;
        assert!(weather.temperature_k.is_nan() && (weather.relative_humidity - 0.81).abs() < 1e-12);
        assert_eq!((weather.wind_speed_mps, weather.pressure_pa), (4.2, 101_350.0));
        assert!((weather.wind_direction_rad - std::f64::consts::PI).abs() < 1e-12);
        assert!(records[2].weather.wind_speed_mps.is_nan());
        let told = FileAccount::told_of(&accounts).join("\n");
        for words in [
            "joined by time with 2 other files: 3 hours, 1 of them in every file",
            "missing of 2 rows: temperature in 1",
            "missing of 2 rows: wind_speed in 1, wind_direction in 1",
            "`F` as wind_speed in mps",
            "not used: `QN_8`, `P`, `eor`",
        ] {
            assert!(told.contains(words), "{told}");
        }
    }

    #[test]
    fn files_that_do_not_fit_together_are_told() {
        let later = SERIES[0].replace("-5.9", "-6.1");
        let (records, accounts) = joined(&[SERIES[0], &later]).unwrap();
        assert_eq!(records[0].weather.temperature_k, 273.15 - 5.9);
        assert!(accounts[1].warnings()[0].contains("[two-values]"), "{:?}", accounts[1]);
        let elsewhere = SERIES[1].replace("433", "44");
        for (other, words) in [
            (elsewhere.as_str(), "it is of station 44, the first file of 433"),
            ("time_s,pressure_hpa\n0,1013\n", "[two-clocks]"),
        ] {
            let message = joined(&[SERIES[0], other]).unwrap_err().to_string();
            assert!(message.contains(words), "{message}");
        }
    }

    #[test]
    fn names_and_codes_of_the_service_mean_nothing_elsewhere() {
        let message = table("time_s,F,D\n0,4.2,180\n").unwrap_err().to_string();
        assert!(message.contains("no column for the weather"), "{message}");
        let message = table("time_s,wind_speed_mps\n0,-999\n").unwrap_err().to_string();
        assert!(message.contains("wind speed"), "{message}");
    }

    #[test]
    fn units_and_dates_are_understood() {
        let records = table(
            "time,temperature_c,pressure_hpa,relative_humidity_percent,\
             precipitation_mm_per_h,wind_direction_deg,note\n\
             2024-02-29T23:00,-3.5,1013,80,0.36,180,a leap day\n\
             2024-03-01 00:00:00,,1012,,0,,the next hour\n",
        )
        .unwrap();
        let weather = records[0].weather;
        assert!((weather.temperature_k - 269.65).abs() < 1e-9);
        assert!((weather.pressure_pa - 101_300.0).abs() < 1e-9);
        assert!((weather.relative_humidity - 0.8).abs() < 1e-12);
        assert!((weather.precipitation_mps - 1e-7).abs() < 1e-18);
        assert!((weather.wind_direction_rad - std::f64::consts::PI).abs() < 1e-12);
        assert!(weather.wind_speed_mps.is_nan() && records[1].weather.temperature_k.is_nan());
        assert!((records[1].time_s - records[0].time_s - 3600.0).abs() < 1e-6);
        assert!((records[0].day_of_year - (59.0 + 23.0 / 24.0)).abs() < 1e-12);
        assert!((records[1].day_of_year - 60.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_weather_is_refused_with_its_place() {
        for (text, words) in [
            ("time_s,rain\n0,1\n", "temperature_k"),
            ("time_s,temperature_bar\n0,59\n", "has a unit that is not read"),
            ("time_s,temperature_c,wind_speed_fps\n0,5,3\n", "allowed is `wind_speed_mps`"),
            ("time_s,temperature_c\n", "no rows"),
            ("temperature_k\n280\n", "no column for the time: name it `time`, `date`, `time_s`"),
            ("time_s,temperature_k\n0,15\n", "line 2"),
            ("time_s,temperature_k\n3600,280\n0,281\n", "line 3"),
            ("time,temperature_k\n2023-02-29T00:00,280\n", "2024-03-01T14:00"),
            ("time,temperature_k\nyesterday,280\n", "yesterday"),
            ("time_s,relative_humidity\n0,80\n", "105 %"),
        ] {
            let message = table(text).unwrap_err().to_string();
            assert!(message.contains(words), "{text}: {message}");
        }
    }
}

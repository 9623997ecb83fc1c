//! Tables of hourly weather, one row an hour, as weather services give them.
//!
//! The clock is the place's standard time all year ([`crate::intake::table::clock`]). Beside it stands any
//! of the quantities of the weather.

use crate::intake::table::clock::{ClockColumn, PlaceClock};
use crate::intake::table::formats::WEATHER;
use crate::intake::table::source::{ending, read_text};
use crate::intake::table::{Mapping, Quantity, Source, Table, TableError};
use crate::intake::{FileAccount, Finding, epw};
use crate::number_text::rounded;
use ocmc_core::operating_cycle::weather::{STANDARD_WEATHER, Weather};
use ocmc_estimation::fit::weather::HourlyRecord;

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

/// Reads a table of hourly weather; `place` is the clock of the place, where that is known.
///
/// # Errors
/// [`TableError`] names the file, the place in it and what is allowed.
pub fn read(
    source: Source,
    mappings: &[Mapping],
    place: Option<&PlaceClock>,
) -> Result<(Vec<HourlyRecord>, FileAccount), TableError> {
    if let Source::File(path) = source
        && ending(path) == "epw"
    {
        let text = read_text(path)?;
        if epw::is_one(&text) {
            let table = epw::as_table(&text);
            return read(Source::Text(path, &table), mappings, place);
        }
    }
    let file = Table::open(source, &WEATHER, mappings)?;
    file.refuse_other_units()?;
    let mut clock = ClockColumn::find(&file, place)?;
    file.need_any("weather", &VARIABLES.map(|(quantity, _)| quantity))?;
    let mut records: Vec<HourlyRecord> = Vec::new();
    let mut account = file.for_each(|row| {
        let last = records.last().map(|last| last.time_s);
        let (time_s, day_of_year) = clock.after(row, last)?;
        let mut weather = STANDARD_WEATHER;
        for (quantity, into) in VARIABLES {
            *into(&mut weather) = row.number(quantity)?;
        }
        records.push(HourlyRecord { time_s, day_of_year, weather });
        Ok(())
    })?;
    account.findings.extend(clock.findings());
    account.findings.extend(hourly(&mut records));
    Ok((records, account))
}

/// Leaves a record an hour of records that are closer: the laws are those of hours. Full hours where
/// there are some, otherwise every first one an hour after the last.
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
        read(Source::Text(Path::new("hours.csv"), text), &[], None).map(|(records, _)| records)
    }

    #[test]
    fn units_and_dates_are_understood() {
        let records = table(
            "time,temperature_c,pressure_hpa,relative_humidity_percent,precipitation_mm_per_h,wind_direction_deg,note\n\
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

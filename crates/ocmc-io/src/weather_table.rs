//! Tables of hourly weather, one row an hour, as weather services give them.
//!
//! The clock is the place's standard time all year: `time`, such as `2024-03-01T14:00` or `2024-03-01 14:00:00`, or `time_s`,
//! counted from a midnight of 1 January. Times with an offset are told in that clock ([`crate::clock_column`]). Then any of
//!
//! - `temperature_k` or `temperature_c`
//! - `pressure_pa` or `pressure_hpa`, at the place, not reduced to the sea
//! - `relative_humidity` (0 to 1) or `relative_humidity_percent`
//! - `precipitation_mps` or `precipitation_mm_per_h`, as water
//! - `wind_speed_mps` at 10 m
//! - `wind_direction_rad` or `wind_direction_deg`, where it comes from, from north, clockwise
//!
//! Other columns are not looked at. An empty cell is a missing value.

use crate::clock_column::ClockColumn;
use crate::column_file::{ColumnFile, ColumnFileError};
use ocmc_core::operating_cycle::weather::{STANDARD_WEATHER, Weather};
use ocmc_estimation::fit::weather::HourlyRecord;
use std::io::Read;
use std::path::Path;

/// What a column may hold: from and to, in SI, and how that reads.
type Range = (f64, f64, &'static str);

/// A variable: its columns with the factor and the offset to SI, and its range.
struct Variable {
    columns: &'static [(&'static str, f64, f64)],
    range: Range,
    into: fn(&mut Weather) -> &mut f64,
}

const VARIABLES: [Variable; 6] = [
    Variable {
        columns: &[("temperature_k", 1.0, 0.0), ("temperature_c", 1.0, 273.15)],
        range: (173.15, 343.15, "a temperature between -100 and 70 °C, or nothing"),
        into: |weather| &mut weather.temperature_k,
    },
    Variable {
        columns: &[("pressure_pa", 1.0, 0.0), ("pressure_hpa", 100.0, 0.0)],
        range: (3e4, 1.2e5, "a pressure between 300 and 1200 hPa, or nothing"),
        into: |weather| &mut weather.pressure_pa,
    },
    Variable {
        columns: &[("relative_humidity", 1.0, 0.0), ("relative_humidity_percent", 0.01, 0.0)],
        range: (0.0, 1.05, "a relative humidity between 0 and 1.05 (105 %), or nothing"),
        into: |weather| &mut weather.relative_humidity,
    },
    Variable {
        columns: &[("precipitation_mps", 1.0, 0.0), ("precipitation_mm_per_h", 1e-3 / 3600.0, 0.0)],
        range: (0.0, 1.4e-4, "between 0 and 500 mm an hour, or nothing"),
        into: |weather| &mut weather.precipitation_mps,
    },
    Variable {
        columns: &[("wind_speed_mps", 1.0, 0.0)],
        range: (0.0, 120.0, "a wind speed between 0 and 120 m/s, or nothing"),
        into: |weather| &mut weather.wind_speed_mps,
    },
    Variable {
        columns: &[
            ("wind_direction_rad", 1.0, 0.0),
            ("wind_direction_deg", std::f64::consts::PI / 180.0, 0.0),
        ],
        range: (-7.0, 7.0, "a direction of at most one turn, or nothing"),
        into: |weather| &mut weather.wind_direction_rad,
    },
];

/// Reads a table of hourly weather. `utc_offset_h` is by how many hours the place's standard time is ahead of UTC, where that is known.
///
/// # Errors
/// [`ColumnFileError`] names the file, the place in it and what is allowed.
pub fn read(path: &Path, utc_offset_h: Option<f64>) -> Result<Vec<HourlyRecord>, ColumnFileError> {
    read_columns(ColumnFile::open(path)?, utc_offset_h)
}

/// Reads a table whose header has been read.
///
/// # Errors
/// As [`read`].
pub fn read_columns(
    mut file: ColumnFile<impl Read>,
    utc_offset_h: Option<f64>,
) -> Result<Vec<HourlyRecord>, ColumnFileError> {
    let mut clock = ClockColumn::find(&mut file, utc_offset_h)?;
    let mut found = Vec::new();
    for variable in &VARIABLES {
        let names: Vec<&str> = variable.columns.iter().map(|(name, ..)| *name).collect();
        let unit = variable.columns.iter().find(|(name, ..)| file.has(&[name]));
        if let (Some(column), Some((_, factor, offset))) = (file.numbers(&names)?, unit) {
            found.push((column, *factor, *offset, variable));
        }
    }
    if found.is_empty() {
        let names: Vec<&str> =
            VARIABLES.iter().flat_map(|v| v.columns.iter().map(|(name, ..)| *name)).collect();
        file.need_numbers(&names)?;
    }
    let mut records: Vec<HourlyRecord> = Vec::new();
    file.for_each(|row| {
        let last = records.last().map(|last| last.time_s);
        let (time_s, day_of_year) = clock.after(row, last)?;
        let mut weather = MISSING;
        for (column, factor, offset, variable) in &found {
            let value = row.number(*column)? * factor + offset;
            let (from, to, allowed) = variable.range;
            if value < from || value > to {
                return Err(row.refuse_number(*column, allowed));
            }
            *(variable.into)(&mut weather) = value;
        }
        records.push(HourlyRecord { time_s, day_of_year, weather });
        Ok(())
    })?;
    Ok(records)
}

/// Nothing was recorded.
const MISSING: Weather = Weather {
    temperature_k: f64::NAN,
    pressure_pa: f64::NAN,
    relative_humidity: f64::NAN,
    precipitation_mps: f64::NAN,
    wind_speed_mps: f64::NAN,
    wind_direction_rad: f64::NAN,
    ..STANDARD_WEATHER
};

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Result<Vec<HourlyRecord>, ColumnFileError> {
        read_columns(ColumnFile::new(Path::new("hours.csv"), text.as_bytes())?, None)
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
            ("time_s,temperature_f\n0,59\n", "allowed is `temperature_k` or `temperature_c`"),
            ("time_s,temperature_c,wind_speed_kmh\n0,5,3\n", "allowed is `wind_speed_mps`"),
            ("time_s,temperature_c\n", "no rows"),
            ("temperature_k\n280\n", "`time` or `time_s`"),
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

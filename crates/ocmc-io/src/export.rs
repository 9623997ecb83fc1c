//! The files of a fleet's export: what each of them is, by its columns, and which trips are held
//! back when a study is learnt from them.

use crate::given_cycle;
use crate::intake::table::formats::{CURVES, LOG, SPEED_CHANGES, TRAFFIC, TRIP_TOTALS, WEATHER};
use crate::intake::table::schema::Schema;
use crate::intake::table::source::{ending, is_table, is_track};
use crate::intake::table::{Mapping, Quantity as Q, Source, Table, TableError};
use crate::sha256;
use crate::trip_totals;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::{fs, io};

/// Distance of a trip that is none, in m.
const SHORTEST_TRIP_M: f64 = 500.0;
/// A counter falls, where it is set back, less often than once in so many rows.
const MOST_FALLS: usize = 20;
/// Rows of which nothing is said.
const FEW: usize = 5;
/// Most folders below each other.
const MOST_DEEP: usize = 8;
/// Digits of a checksum of which a number is made.
const DIGITS: usize = 12;

/// Kind of a file of an export.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ExportKind {
    /// A log, or a track: time, and speed or positions.
    Log,
    /// Totals of trips, or fills.
    Totals,
    /// Hours of weather.
    Weather,
    /// Densities or speeds of the traffic.
    Traffic,
    /// Measured curves.
    Curves,
    /// Measured changes of speed.
    SpeedChanges,
    /// An operating cycle, as `ocmc cycle` writes it.
    OperatingCycle,
}

impl ExportKind {
    /// Name of it for people.
    pub fn words(self) -> &'static str {
        match self {
            Self::Log => "log",
            Self::Totals => "totals of trips",
            Self::Weather => "weather",
            Self::Traffic => "traffic",
            Self::Curves => "curves",
            Self::SpeedChanges => "speed changes",
            Self::OperatingCycle => "operating cycle",
        }
    }
}

/// One of each list of quantities, by which a kind of table is known; the first kind that has all.
const KNOWN_BY: [(ExportKind, &Schema, &[&[Q]]); 6] = [
    (ExportKind::Log, &LOG, &[&[Q::Time, Q::Date, Q::Day], &[Q::Speed, Q::Latitude]]),
    (
        ExportKind::Totals,
        &TRIP_TOTALS,
        &[&[Q::Distance, Q::Odometer], &[Q::FuelAmount, Q::EnergyAmount]],
    ),
    (ExportKind::Curves, &CURVES, &[&[Q::Radius], &[Q::Speed]]),
    (
        ExportKind::Traffic,
        &TRAFFIC,
        &[&[Q::RoadType], &[Q::DensityShare, Q::Density, Q::SpeedRatio]],
    ),
    (
        ExportKind::Weather,
        &WEATHER,
        &[
            &[Q::Time, Q::Date, Q::Day],
            &[Q::Temperature, Q::WindSpeed, Q::Pressure, Q::RelativeHumidity, Q::Precipitation],
        ],
    ),
    (ExportKind::SpeedChanges, &SPEED_CHANGES, &[&[Q::Acceleration]]),
];

/// Finds the kind of a file; none where no reader takes it.
///
/// # Errors
/// [`TableError`] where a table cannot be read at all.
pub fn kind_of(path: &Path, mappings: &[Mapping]) -> Result<Option<ExportKind>, TableError> {
    if is_track(path) {
        return Ok(Some(ExportKind::Log));
    }
    if ending(path) == "json" {
        let is_cycle = given_cycle::read(path, &[]).is_ok();
        return Ok(is_cycle.then_some(ExportKind::OperatingCycle));
    }
    if !is_table(path) {
        return Ok(None);
    }
    let mut fault = None;
    let is_totals = tells_trips(path, mappings);
    for (kind, schema, lists) in KNOWN_BY {
        // a table of trips may have their mean speeds, and places
        if kind == ExportKind::Log && is_totals {
            continue;
        }
        let own: Vec<Mapping> = mappings.iter().filter(|m| m.is_of(schema)).cloned().collect();
        match Table::open(Source::File(path), schema, &own) {
            Ok(table) if lists.iter().all(|any| any.iter().any(|q| table.has(*q))) => {
                return Ok(Some(kind));
            }
            Ok(_) => {}
            Err(error) => fault = fault.or(Some(error)),
        }
    }
    fault.map_or(Ok(None), Err)
}

/// Whether a table has a distance and an amount in each row that are those of a trip: most are
/// longer than [`SHORTEST_TRIP_M`], and no counter, which does not fall.
fn tells_trips(path: &Path, mappings: &[Mapping]) -> bool {
    let own: Vec<Mapping> = mappings.iter().filter(|m| m.is_of(&TRIP_TOTALS)).cloned().collect();
    let Ok((totals, _)) = trip_totals::read(Source::File(path), &own) else { return false };
    let rows = &totals.rows;
    let long = rows.iter().filter(|row| row.distance_m > SHORTEST_TRIP_M).count();
    let falls = rows.windows(2).filter(|pair| pair[1].distance_m < pair[0].distance_m).count();
    !totals.of_fills
        && 2 * long > rows.len()
        && (MOST_FALLS * falls > rows.len() || rows.len() < FEW)
}

/// Whether a log has speed limits.
pub fn has_limits(path: &Path, mappings: &[Mapping]) -> bool {
    let own: Vec<Mapping> = mappings.iter().filter(|m| m.is_of(&LOG)).cloned().collect();
    let table = Table::open(Source::File(path), &LOG, &own);
    table.is_ok_and(|table| table.column(Q::Limit).is_some())
}

/// The files of a folder and of those in it, in the order of their names; hidden ones are left out.
///
/// # Errors
/// Where a folder cannot be read.
pub fn files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut paths = Vec::new();
    collect(folder, MOST_DEEP, &mut paths)?;
    Ok(paths)
}

fn collect(folder: &Path, deep: usize, paths: &mut Vec<PathBuf>) -> io::Result<()> {
    let entries = fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path()));
    let mut entries = entries.collect::<io::Result<Vec<PathBuf>>>()?;
    entries.sort();
    for path in entries {
        let is_hidden = path.file_name().is_some_and(|name| name.as_encoded_bytes()[0] == b'.');
        if is_hidden {
            continue;
        }
        if !path.is_dir() {
            paths.push(path);
        } else if deep > 0 {
            collect(&path, deep - 1, paths)?;
        }
    }
    Ok(())
}

/// A number from 0 to 1 that is drawn for a trip: one for all trips of a truck on a day, and of
/// what names neither for each row by itself. The trips with the smallest ones are held back, the
/// same ones in every file.
pub fn drawn(seed: u64, truck: &str, day_of_year: f64, otherwise: &str) -> f64 {
    let is_known = !truck.is_empty() && day_of_year.is_finite();
    let key = if is_known {
        format!("{seed}\n{truck}\n{}", libm::floor(day_of_year))
    } else {
        format!("{seed}\n\n\n{otherwise}")
    };
    let digits = sha256::of_bytes(key.as_bytes());
    let number = u64::from_str_radix(&digits[..DIGITS], 16).expect("hexadecimal digits");
    number as f64 / libm::exp2(4.0 * DIGITS as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_known_by_their_columns() {
        let folder = tempfile::tempdir().unwrap();
        let kind = |name: &str, text: &str| {
            let path = folder.path().join(name);
            fs::write(&path, text).unwrap();
            kind_of(&path, &[]).unwrap()
        };
        for (name, text, expected) in [
            ("a.csv", "time_s,speed_kmh\n0,50\n", Some(ExportKind::Log)),
            (
                "a1.csv",
                "time_s,speed_kmh,distance_km,litres\n0,50,1,1\n1,50,2,1\n2,50,3,1\n3,50,4,1\n\
                 4,50,5,1\n5,50,6,1\n",
                Some(ExportKind::Log),
            ),
            (
                "a2.csv",
                "date,speed_kmh,km,litres\n2024-03-01,50,90,30\n2024-03-02,50,60,20\n",
                Some(ExportKind::Totals),
            ),
            ("b.csv", "truck,date,km,litres\na,2024-03-01,100,30\n", Some(ExportKind::Totals)),
            (
                "c.csv",
                "truck,date,odometer_km,litres\na,2024-03-01,9,3\n",
                Some(ExportKind::Totals),
            ),
            ("d.csv", "time,temperature_c\n2024-03-01T00:00,3\n", Some(ExportKind::Weather)),
            ("e.csv", "time_s,road_type,density_share\n0,urban,0.1\n", Some(ExportKind::Traffic)),
            ("f.csv", "driver,radius_m,speed_mps\na,50,10\n", Some(ExportKind::Curves)),
            ("g.csv", "driver,acceleration_mps2\na,0.5\n", Some(ExportKind::SpeedChanges)),
            ("h.csv", "invoice,amount_eur\n1,5\n", None),
            ("i.txt.bak", "notes", None),
            ("j.json", "{}", None),
        ] {
            assert_eq!(kind(name, text), expected, "{name}");
        }
        fs::create_dir(folder.path().join("0")).unwrap();
        fs::write(folder.path().join("0/z.csv"), "").unwrap();
        fs::write(folder.path().join(".hidden"), "").unwrap();
        let paths = files(folder.path()).unwrap();
        assert!(paths.len() == 13 && paths[0].ends_with("z.csv"), "{paths:?}");
    }

    #[test]
    fn trips_of_a_truck_on_a_day_are_drawn_together_and_uniformly() {
        let draw = |truck: &str, day: f64, row: &str| drawn(3, truck, day, row);
        for day in 0..20 {
            let day = f64::from(day);
            assert_eq!(draw("a", day, "1"), draw("a", day + 0.9, "2"));
        }
        assert_ne!(draw("a", f64::NAN, "1"), draw("a", f64::NAN, "2"));
        // of 2000 groups a fifth: 400 ± 18
        let all = (0..2000).map(|k| draw(&format!("t{}", k / 40), f64::from(k % 40), ""));
        let count = all.filter(|drawn| *drawn < 0.2).count();
        assert!((340..460).contains(&count), "{count}");
    }
}

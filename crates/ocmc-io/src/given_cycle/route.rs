//! A route by rows, as a planner or a logger gives it.
//!
//! | column | unit | meaning |
//! |---|---|---|
//! | `position_m` | m | distance along the road; or it is computed from `lat` and `lon` |
//! | `lat`, `lon` | ° | for length, curves and the heading at the start |
//! | `speed_limit_mps` or `speed_limit_kmh` | m/s, km/h | limit from here on |
//! | `altitude_m` (`elevation_m`) or `grade` | m, - | height, linear between rows; or slope as climb per metre from here on |
//! | `curvature_per_m` | 1/m | from here on, left positive; instead of `lat` and `lon` |
//! | `stop_s` | s | above 0: a stop line with this standstill; 0 or empty: none |
//! | `road_type` | - | name of a road type of the study |
//!
//! Geometry: points are put on a plane around the first one (equirectangular, good for a few hundred km), resampled every 5 m, and
//! averaged over 45 m, because the roads of maps turn at their points only. Curvature is the change of direction per metre; curves
//! are found in it by [`ocmc_core::operating_cycle::road::route_geometry`]. Altitude is taken as it is given: smooth GPS heights before.

use super::{GivenCycleFileError, in_file, refuse_over_time, within, within_or};
use crate::delimited::{DelimitedTable, KMH, METRES, MPS};
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::road::route_geometry::{self, Path2d};
use ocmc_core::operating_cycle::tracks::{Rule, Track, Values};

/// The columns.
const COLUMNS: [&str; 13] = [
    "position_m",
    "lat",
    "latitude",
    "lon",
    "longitude",
    "speed_limit_mps",
    "speed_limit_kmh",
    "altitude_m",
    "elevation_m",
    "grade",
    "curvature_per_m",
    "stop_s",
    "road_type",
];

/// Quantities, each with the columns of which a route may have one.
const QUANTITIES: [(&str, &[&str]); 9] = [
    ("the position", &["position_m"]),
    ("the latitude", LATITUDE),
    ("the longitude", LONGITUDE),
    ("the speed limit", &["speed_limit_mps", "speed_limit_kmh"]),
    ("the altitude", &["altitude_m", "elevation_m"]),
    ("the grade", &["grade"]),
    ("the curvature", &["curvature_per_m"]),
    ("the standstill", &["stop_s"]),
    ("the road type", &["road_type"]),
];
const LATITUDE: &[&str] = &["lat", "latitude"];
const LONGITUDE: &[&str] = &["lon", "longitude"];

/// Allowed latitudes and longitudes, in °; some count eastwards all around.
const LATITUDES: [f64; 2] = [-90.0, 90.0];
const LONGITUDES: [f64; 2] = [-180.0, 360.0];
/// Allowed curvatures, in 1/m: those of a track.
const CURVATURES_PER_M: [f64; 2] = [-0.5, 0.5];
/// Allowed standstills, in s; 0 is none.
const STOPS_S: [f64; 2] = [0.0, 172_800.0];

/// Reads a route.
pub(super) fn read(table: &DelimitedTable) -> Result<GivenCycle, GivenCycleFileError> {
    refuse_over_time(table, &[&["position_m"], LATITUDE, LONGITUDE].concat())?;
    table.refuse_others(&COLUMNS)?;
    refuse_two_of_a_kind(table)?;
    let latitude = within(table, LATITUDE, LATITUDES)?;
    let longitude = within(table, LONGITUDE, LONGITUDES)?;
    // one of the two tells no place
    if latitude.is_some() != longitude.is_some() {
        table.column(LATITUDE)?;
        table.column(LONGITUDE)?;
    }
    let path = latitude.zip(longitude).map(|(lat, lon)| Path2d::new(&lat, &lon));
    let positions = match (table.numbers_in(&["position_m"], METRES)?, &path) {
        (Some(positions), _) => positions,
        (None, Some(path)) => path.position_m.clone(),
        (None, None) => table.numbers(table.column(&["position_m", "lat"])?)?,
    };
    let start_m = positions[0];
    let positions: Vec<f64> = positions.iter().map(|position_m| position_m - start_m).collect();
    if let Some(k) = positions.windows(2).position(|pair| pair[1] <= pair[0]) {
        let line = table.lines().nth(k + 1).unwrap_or_default();
        let (path, position_m) = (table.path().to_owned(), positions[k + 1]);
        return Err(GivenCycleFileError::Order { path, line, position_m });
    }
    let limits = if let Some(limits) = table.numbers_in(&["speed_limit_mps"], MPS)? {
        limits
    } else {
        let column = table.column(&["speed_limit_kmh", "speed_limit_mps"])?;
        table.check_unit(column, KMH)?;
        table.numbers(column)?.iter().map(|limit| limit / 3.6).collect()
    };
    let track = |name, rule, value: Vec<f64>| Track {
        name,
        rule,
        position_m: positions.clone(),
        value: Values::Numbers(value),
    };
    let mut tracks = vec![track("speed_limit_mps", Rule::Constant, limits)];
    if let Some(grades) = table.numbers_of(&["grade"])? {
        tracks.push(track("grade", Rule::Constant, grades));
    } else if let Some(altitudes) = table.numbers_in(&["altitude_m", "elevation_m"], METRES)? {
        tracks.push(track("altitude_m", Rule::Linear, altitudes));
    }
    if let Some(stops_s) = within_or(table, &["stop_s"], STOPS_S, Some(0.0))? {
        let mut stops = Track::empty("stop_sign_s", Rule::Event);
        for (position_m, stop_s) in positions.iter().zip(stops_s).filter(|(_, stop)| *stop > 0.0) {
            stops.push(*position_m, stop_s);
        }
        tracks.push(stops);
    }
    if let Some(column) = table.find(&["road_type"]) {
        let value = Values::Names(table.words(column));
        let position_m = positions.clone();
        tracks.push(Track { name: "road_type", rule: Rule::Constant, position_m, value });
    }
    let curvature = within(table, &["curvature_per_m"], CURVATURES_PER_M)?;
    for track in &mut tracks {
        track.merge_equal();
    }
    let length_m = positions.last().copied();
    let mut cycle = GivenCycle::from_tracks(&tracks, length_m).map_err(in_file(table.path()))?;
    if let Some(curvature) = curvature {
        cycle.curves = route_geometry::curves_of_curvature(&positions, &curvature);
    } else if let Some(path) = &path {
        cycle.curves = path.curves(&positions);
    }
    cycle.heading_rad = path.as_ref().map(Path2d::heading_rad);
    Ok(cycle)
}

/// Refuses two columns for one quantity: nothing says which of them is meant.
fn refuse_two_of_a_kind(table: &DelimitedTable) -> Result<(), GivenCycleFileError> {
    for (quantity, names) in QUANTITIES {
        let mut found = table.names().filter(|name| names.contains(&name.as_str()));
        if let (Some(one), Some(other)) = (found.next(), found.next()) {
            let (path, columns) = (table.path().to_owned(), [one, other]);
            return Err(GivenCycleFileError::Ambiguous { path, quantity, columns });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write;
    use std::path::Path;

    fn parse(text: &str) -> Result<GivenCycle, GivenCycleFileError> {
        read(&DelimitedTable::parse(Path::new("r.csv"), text).unwrap())
    }

    #[test]
    fn a_circle_in_degrees_has_its_radius() {
        // a quarter turn to the left of 200 m radius between two straights, at 52° north
        let (lat_m, lon_m) = (111_195.0, 111_195.0 * 52f64.to_radians().cos());
        let mut text = "lat,lon,speed_limit_kmh\n".to_owned();
        let mut add = |x: f64, y: f64| {
            let (lat, lon) = (52.0 + y / lat_m, 9.0 + x / lon_m);
            writeln!(text, "{lat:.8},{lon:.8},50").unwrap();
        };
        for k in 0..50 {
            add(0.0, 10.0 * f64::from(k));
        }
        for k in 0..=31 {
            let angle = f64::from(k) * 0.05;
            add(200.0 * (angle.cos() - 1.0), 500.0 + 200.0 * angle.sin());
        }
        for k in 1..50 {
            add(-200.0 - 10.0 * f64::from(k), 700.0);
        }
        let cycle = parse(&text).unwrap();
        assert_eq!(cycle.curves.len(), 1, "{:?}", cycle.curves);
        let curve = cycle.curves[0];
        assert!(curve.left && (curve.radius_m / 200.0 - 1.0).abs() < 0.03, "{curve:?}");
        assert!((curve.end_m - curve.start_m - 314.0).abs() < 50.0, "{curve:?}");
        assert!((cycle.length_m - (500.0 + 314.0 + 490.0)).abs() < 12.0, "{}", cycle.length_m);
        assert!(cycle.heading_rad.unwrap().abs() < 1e-6, "north");
    }

    #[test]
    fn rows_with_altitude_stops_and_curvature() {
        let text = "position_m,speed_limit_kmh,elevation_m,stop_s,curvature_per_m\n\
                    0,50,10,0,0\n100,50,12,0,0.01\n150,70,12,20,0\n600,70,3,0,0\n";
        let cycle = parse(text).unwrap();
        assert_eq!(cycle.limits, [(0.0, 50.0 / 3.6), (150.0, 70.0 / 3.6)]);
        assert!((cycle.altitude_m(50.0) - 11.0).abs() < 1e-12);
        assert_eq!(cycle.events[0].kind.standstill_s(), Some(20.0));
        assert_eq!(cycle.curves.len(), 1);
        assert!((cycle.curves[0].radius_m - 100.0).abs() < 1e-9 && cycle.curves[0].left);
        let empty = "position_m,speed_limit_kmh,stop_s\n0,50,\n150,70,20\n600,70,\n";
        let cycle = parse(empty).unwrap();
        assert_eq!(cycle.events.len(), 1);
        assert_eq!(cycle.events[0].position_m, 150.0);
        let fault = parse("position_m,limit\n0,50\n300,50\n").unwrap_err().to_string();
        assert!(fault.contains("`limit`") && fault.contains("speed_limit_kmh"), "{fault}");
    }

    #[test]
    fn numbers_that_cannot_be_are_refused_with_their_line() {
        for (text, message) in [
            (
                "lat,lon,speed_limit_kmh\n52,9,50\n95,9,50\n",
                "r.csv:3: `lat` is 95, allowed is -90 to 90",
            ),
            (
                "lat,lon,speed_limit_kmh\n52,-181,50\n53,9,50\n",
                "r.csv:2: `lon` is -181, allowed is -180 to 360",
            ),
            (
                "# mine\nposition_m,speed_limit_kmh,stop_s\n0,50,0\n300,50,-5\n",
                "r.csv:4: `stop_s` is -5, allowed is 0 to 172800",
            ),
            (
                "position_m,speed_limit_kmh,curvature_per_m\n0,50,0\n300,50,7\n",
                "r.csv:3: `curvature_per_m` is 7, allowed is -0.5 to 0.5",
            ),
            (
                "position_m,speed_limit_kmh\n0,50\n300,\n",
                "r.csv:3: `speed_limit_kmh` is empty, allowed is a finite number",
            ),
            ("time_s,speed_kmh\n0,0\n9,50\n", "is a speed over time: it has a column `time_s`"),
            (
                "time_s,position_m,speed_kmh\n0,0,0\n9,50,50\n",
                "unknown columns `time_s`, `speed_kmh` (did you mean `speed_limit_kmh`?); allowed",
            ),
            ("lat,speed_limit_kmh\n52,50\n53,50\n", "`r.csv` has no column `lon` or `longitude`"),
            ("lon,speed_limit_kmh\n9,50\n10,50\n", "`r.csv` has no column `lat` or `latitude`"),
            ("position_m [km],speed_limit_kmh\n0,50\n9,50\n", "is read in m, not in km"),
        ] {
            let fault = parse(text).unwrap_err().to_string();
            assert!(fault.contains(message), "{fault}");
        }
    }

    #[test]
    fn two_columns_for_one_quantity_are_refused() {
        for (header, one, other, quantity) in [
            (
                "position_m,speed_limit_kmh,speed_limit_mps",
                "speed_limit_kmh",
                "speed_limit_mps",
                "speed limit",
            ),
            (
                "position_m,speed_limit_kmh,Speed_limit_kmh",
                "speed_limit_kmh",
                "speed_limit_kmh",
                "speed limit",
            ),
            ("lat,latitude,lon,speed_limit_kmh", "lat", "latitude", "latitude"),
            ("position_m,position_m,speed_limit_kmh", "position_m", "position_m", "position"),
            (
                "position_m,speed_limit_kmh,altitude_m,elevation_m",
                "altitude_m",
                "elevation_m",
                "altitude",
            ),
        ] {
            let cells = header.split(',').count();
            let row = |value: &str| vec![value; cells].join(",");
            let fault = parse(&format!("{header}\n{}\n{}\n", row("1"), row("50")));
            let fault = fault.unwrap_err().to_string();
            let message = format!(
                "`r.csv` has the columns `{one}` and `{other}`, which are both the {quantity}"
            );
            assert!(fault.contains(&message) && fault.contains("one of them"), "{fault}");
        }
    }
}

//! A route by rows, as a planner or a logger gives it.
//!
//! Numbers hold from their row on; altitudes are linear between rows. The position is computed from
//! latitude and longitude where it is not there.
//!
//! Geometry: points are put on a plane around the first one (equirectangular, good for a few
//! hundred km), resampled every 5 m, and averaged over 45 m, because the roads of maps turn at
//! their points only. Curvature is the change of direction per metre; curves are found in it by
//! [`ocmc_core::operating_cycle::road::route_geometry`]. Where positions or altitudes scatter by
//! 0.5 m or more, as a receiver's do, they are smoothed first
//! ([`ocmc_core::operating_cycle::road::route_noise`]); where they are far apart their turns are
//! spread ([`ocmc_core::operating_cycle::road::route_fillet`]). Rows of a receiver at standstill
//! become one.

use super::objects::Objects;
use super::{in_file, refuse_over_time};
use crate::intake::drift::{standing, standstill_drift};
use crate::intake::lacks::lacks;
use crate::intake::spacing::{LONGEST_M, beeline, sparse_points, tells_no_curves};
use crate::intake::table::error::Fault;
use crate::intake::table::formats::ROUTE;
use crate::intake::table::given::RowPlace;
use crate::intake::table::unit::KMH;
use crate::intake::table::{Mapping, Quantity, Source, Table, TableError};
use crate::intake::{
    Extent, FileAccount, Finding, contradiction, jump, limit_unit, scatter, sparse_altitudes,
};
use crate::number_text::count_of;
use ocmc_core::operating_cycle::drawn_part::Draw;
use ocmc_core::operating_cycle::given::{GivenCycle, GivenCycleError, PointNoise};
use ocmc_core::operating_cycle::road::route_fillet::Rounding;
use ocmc_core::operating_cycle::road::route_geometry::{self, Path2d, interpolate};
use ocmc_core::operating_cycle::road::route_noise::{
    LEAST_NOISE_M, MOST_NOISE_M, least_noise_of_altitudes_m, noise_of_altitudes, smooth_altitudes,
};
use ocmc_core::operating_cycle::tracks::{Rule, Track, Values};
use std::ops::Range;

/// Limit by which the points of a road are judged whose limits are drawn, in m/s.
const NOMINAL_MPS: f64 = 80.0 / 3.6;
/// Most that a road is longer than the beelines between its places (judgement).
const MOST_AROUND: f64 = 2.5;

/// The rows of a route; a column that is not there has none.
#[derive(Default)]
struct Rows {
    places: Vec<RowPlace>,
    position_m: Vec<f64>,
    latitude: Vec<f64>,
    longitude: Vec<f64>,
    limit_mps: Vec<f64>,
    altitude_m: Vec<f64>,
    grade: Vec<f64>,
    curvature: Vec<f64>,
    stop_s: Vec<f64>,
    road_type: Vec<String>,
    map_object: Vec<String>,
}

impl Rows {
    fn read(table: Table, draw: &[Draw]) -> Result<(Self, FileAccount), TableError> {
        if !draw.contains(&Draw::Limits) {
            table.need(&[Quantity::Limit])?;
        }
        let [has_stops, has_types, has_objects] =
            [Quantity::Stop, Quantity::RoadType, Quantity::MapObject]
                .map(|quantity| table.column(quantity).is_some());
        let (mut rows, path) = (Self::default(), table.path().to_owned());
        let account = table.for_each(|row| {
            rows.places.push(row.place());
            rows.limit_mps.extend(row.divided(Quantity::Limit, KMH, 3.6)?);
            rows.position_m.extend(row.optional(Quantity::Position)?);
            if let [.., a, b] = rows.position_m[..]
                && b <= a
            {
                let since_m = b - rows.position_m[0];
                return Err(TableError::of(&path, Fault::Order(row.place(), since_m)));
            }
            rows.latitude.extend(row.optional(Quantity::Latitude)?);
            rows.longitude.extend(row.optional(Quantity::Longitude)?);
            rows.altitude_m.extend(row.optional(Quantity::Altitude)?);
            rows.grade.extend(row.optional(Quantity::Grade)?);
            rows.curvature.extend(row.optional(Quantity::Curvature)?);
            if has_stops {
                let empty = row.text(Quantity::Stop).is_empty();
                rows.stop_s.push(if empty { 0.0 } else { row.number(Quantity::Stop)? });
            }
            if has_types {
                rows.road_type.push(row.text(Quantity::RoadType).to_owned());
            }
            if has_objects {
                rows.map_object.push(row.text(Quantity::MapObject).to_owned());
            }
            Ok(())
        })?;
        Ok((rows, account))
    }

    /// Altitudes that a receiver lacks, straight between the rows that have one; none where no row
    /// has.
    fn fill_altitudes(&mut self) -> Option<Finding> {
        let known: Vec<usize> =
            (0..self.altitude_m.len()).filter(|k| self.altitude_m[*k].is_finite()).collect();
        let missing = self.altitude_m.len() - known.len();
        if missing == 0 {
            return None;
        }
        let (at, values): (Vec<f64>, Vec<f64>) =
            known.iter().map(|k| (*k as f64, self.altitude_m[*k])).unzip();
        if known.is_empty() {
            self.altitude_m.clear();
            return None;
        }
        for (k, altitude_m) in self.altitude_m.iter_mut().enumerate() {
            *altitude_m = interpolate(&at, &values, k as f64);
        }
        let text = format!(
            "{} without altitude: straight between the others",
            count_of(missing as u64, "point")
        );
        Some(Finding::mended("missing-altitudes", [missing as f64, 0.0], text))
    }

    /// The points on a plane, where they are given.
    fn path(&self) -> Option<Path2d> {
        (!self.latitude.is_empty()).then(|| Path2d::new(&self.latitude, &self.longitude))
    }

    /// Makes one row of each range: its first, with its longest stop.
    fn merge(&mut self, ranges: &[Range<usize>]) {
        for rows in ranges {
            if let Some(stops) = self.stop_s.get_mut(rows.clone()) {
                stops[0] = stops.iter().copied().fold(0.0, f64::max);
            }
            if let Some(objects) = self.map_object.get_mut(rows.clone())
                && let Some(object) = objects.iter().find(|object| !object.is_empty()).cloned()
            {
                objects[0] = object;
            }
        }
        let mut left_out = vec![false; self.places.len()];
        for rows in ranges {
            left_out[rows.start + 1..rows.end].fill(true);
        }
        self.leave_out(&left_out);
    }

    /// Leaves rows out.
    fn leave_out(&mut self, rows: &[bool]) {
        let keep: Vec<bool> = rows.iter().map(|left_out| !left_out).collect();
        retain(&mut self.places, &keep);
        retain(&mut self.road_type, &keep);
        retain(&mut self.map_object, &keep);
        for values in [
            &mut self.position_m,
            &mut self.latitude,
            &mut self.longitude,
            &mut self.limit_mps,
            &mut self.altitude_m,
            &mut self.grade,
            &mut self.curvature,
            &mut self.stop_s,
        ] {
            retain(values, &keep);
        }
    }
}

/// Keeps some rows of a column.
fn retain<T>(values: &mut Vec<T>, keep: &[bool]) {
    let mut keep = keep.iter();
    values.retain(|_| keep.next().copied().unwrap_or(true));
}

/// The points of a route that has coordinates, and where they are along it.
pub(super) struct Points {
    pub(super) latitude_deg: Vec<f64>,
    pub(super) longitude_deg: Vec<f64>,
    pub(super) position_m: Vec<f64>,
}

/// Reads a route, and its points where it has coordinates.
pub(super) fn read(
    source: Source,
    mappings: &[Mapping],
    draw: &[Draw],
) -> Result<(GivenCycle, FileAccount, Option<Points>), TableError> {
    let table = Table::open(source, &ROUTE, mappings)?;
    let file = source.path();
    let [position, latitude, longitude] =
        [Quantity::Position, Quantity::Latitude, Quantity::Longitude];
    refuse_over_time(&table, &[position, latitude, longitude])?;
    table.refuse_others()?;
    if table.is_export() && table.names().iter().any(|name| name == "drive") {
        return Err(TableError::of(file, Fault::SeveralTracks));
    }
    table.need_any("position", &[position, latitude, longitude])?;
    // one of the two tells no place
    if table.column(latitude).is_some() || table.column(longitude).is_some() {
        table.need(&[latitude, longitude])?;
    }
    let quantities: Vec<Quantity> = table.columns().iter().map(|column| column.quantity).collect();
    let limit = table.column(Quantity::Limit);
    let (mut rows, mut account) = Rows::read(table, draw)?;
    account.findings.extend(rows.fill_altitudes());
    let mut path = rows.path();
    // places of a plan tell neither the curves of the road nor, without an odometer, its length
    let is_plan = draw.contains(&Draw::Curves)
        && rows.curvature.is_empty()
        && path.as_ref().is_some_and(tells_no_curves);
    if let Some(track) = path.as_ref().filter(|_| rows.position_m.is_empty()) {
        let (x_m, y_m) = track.points_m();
        let clusters = standing(x_m, y_m);
        if !clusters.is_empty() {
            account.judged(file, standstill_drift(x_m, y_m, &clusters))?;
            rows.merge(&clusters);
            path = rows.path();
        }
    }
    if let Some(track) = path.as_ref().filter(|_| !is_plan) {
        let (x_m, y_m) = track.points_m();
        let aside = jump::points_aside(x_m, y_m, track.noise_m());
        let finding = jump::position_jump(&aside, |row| rows.places[row].to_string());
        if let Some(finding) = finding {
            account.findings.push(finding);
            rows.leave_out(&aside);
            path = rows.path();
        }
    }
    if let Some(track) = path.as_ref().filter(|_| !is_plan) {
        let (x_m, y_m) = track.points_m();
        let jump =
            jump::lasting_jump(x_m, y_m, track.noise_m(), |row| rows.places[row].to_string());
        account.findings.extend(jump);
        account.findings.extend(jump::gap(x_m, y_m, |row| rows.places[row].to_string()));
    }
    let odometer_m = (!rows.position_m.is_empty()).then_some(rows.position_m.as_slice());
    let Rows { altitude_m, grade, curvature, .. } = &rows;
    // a road is longer than the beelines between the places of a plan
    let of_road = path.as_ref().filter(|path| !(is_plan && goes_around(odometer_m, path)));
    let contradictions = contradiction::of_route(odometer_m, of_road, altitude_m, grade, curvature);
    account.judged(file, contradictions)?;
    if let Some(path) = path.as_ref().filter(|_| is_plan && odometer_m.is_none()) {
        account.judged(file, beeline(path))?;
    }
    let positions = match &path {
        Some(path) if rows.position_m.is_empty() => &path.position_m,
        _ => &rows.position_m,
    };
    let start_m = positions[0];
    let mut positions: Vec<f64> = positions.iter().map(|position_m| position_m - start_m).collect();
    let mut noise = PointNoise::default();
    // curvature tells the curves where it is there; the positions then only tell the way
    let mut road = None;
    if let Some(path) = &path
        && (rows.position_m.is_empty() || rows.curvature.is_empty())
        && !is_plan
    {
        noise.positions_m = checked_noise("positions", path.noise_m()).map_err(in_file(file))?;
        let is_grown = positions.windows(2).all(|pair| pair[1] > pair[0]);
        let odometer = !rows.position_m.is_empty();
        if noise.positions_m >= LEAST_NOISE_M && (is_grown || !odometer) {
            account.findings.push(scatter::smoothed("positions", noise.positions_m));
            let (x_m, y_m) = path.points_m();
            account.findings.extend(scatter::with_memory(x_m, y_m));
            let measured = odometer.then_some(positions.as_slice());
            let (smooth, given_m) = path.smoothed(measured, noise.positions_m);
            let start_m = given_m[0];
            positions = given_m.iter().map(|given_m| given_m - start_m).collect();
            road = Some(smooth);
        } else if is_grown && positions.len() > 2 {
            let measured = odometer.then_some(positions.as_slice());
            let nominal = vec![NOMINAL_MPS; positions.len()];
            let drawn = rows.limit_mps.is_empty();
            let limit_mps = if drawn { &nominal } else { &rows.limit_mps };
            account.judged(file, sparse_points(path, measured, limit_mps))?;
            let lengths_m = path.position_m.last().into_iter().chain(positions.last());
            if lengths_m.fold(0.0, |most: f64, m| most.max(*m)) < LONGEST_M
                && let Some((rounded, given_m)) = path.rounded(measured, Rounding::LIKELY)
            {
                positions = given_m;
                road = Some(rounded);
            }
        }
    }
    if let Some(k) = positions.windows(2).position(|pair| pair[1] <= pair[0]) {
        return Err(TableError::of(file, Fault::Order(rows.places[k + 1], positions[k + 1])));
    }
    let ways_m = positions.windows(2).map(|pair| pair[1] - pair[0]);
    let limits: Vec<(f64, f64)> = ways_m.zip(rows.limit_mps.iter().copied()).collect();
    account.findings.extend(limit.and_then(|column| limit_unit::judge(&limits, &column)));
    let track = |name, rule, value: Vec<f64>| Track {
        name,
        rule,
        position_m: positions.clone(),
        value: Values::Numbers(value),
    };
    let mut tracks = Vec::new();
    if !rows.limit_mps.is_empty() {
        tracks.push(track("speed_limit_mps", Rule::Constant, rows.limit_mps));
    }
    if !rows.grade.is_empty() {
        tracks.push(track("grade", Rule::Constant, rows.grade));
    } else if !rows.altitude_m.is_empty() {
        if !draw.contains(&Draw::Hills) {
            account.findings.extend(sparse_altitudes::judge(&positions, &rows.altitude_m));
        }
        let place = |row: usize| rows.places[row].to_string();
        let spikes = jump::altitude_spikes(&positions, &mut rows.altitude_m, place);
        account.findings.extend(spikes);
        let noise_m = noise_of_altitudes(&positions, &rows.altitude_m);
        noise.altitudes_m = checked_noise("altitudes", noise_m).map_err(in_file(file))?;
        let mut altitude = track("altitude_m", Rule::Linear, rows.altitude_m);
        if noise.altitudes_m >= least_noise_of_altitudes_m(&positions)
            && let Values::Numbers(altitude_m) = &altitude.value
        {
            account.findings.push(scatter::smoothed("altitudes", noise.altitudes_m));
            let smooth = smooth_altitudes(&positions, altitude_m, noise.altitudes_m);
            let (position_m, altitude_m) = smooth.into_iter().unzip();
            (altitude.position_m, altitude.value) = (position_m, Values::Numbers(altitude_m));
        }
        tracks.push(altitude);
    }
    let objects = Objects::of(&positions, &rows.map_object, &rows.stop_s).map_err(in_file(file))?;
    if !rows.stop_s.is_empty() {
        let mut stops = Track::empty("stop_sign_s", Rule::Event);
        let at = positions.iter().zip(&objects.other_stop_s).filter(|(_, stop)| **stop > 0.0);
        at.for_each(|(position_m, stop_s)| stops.push(*position_m, *stop_s));
        tracks.push(stops);
    }
    if !rows.road_type.is_empty() {
        let value = Values::Names(rows.road_type);
        let position_m = positions.clone();
        tracks.push(Track { name: "road_type", rule: Rule::Constant, position_m, value });
    }
    for track in &mut tracks {
        track.merge_equal();
    }
    account.extent = Extent::of_way(&positions);
    let length_m = positions.last().copied();
    let mut cycle = GivenCycle::from_partial_tracks(&tracks, length_m).map_err(in_file(file))?;
    objects.put_into(&mut cycle);
    if !rows.curvature.is_empty() {
        cycle.curves = route_geometry::curves_of_curvature(&positions, &rows.curvature);
    } else if let Some(road) = &road {
        cycle.curves = road.curves(&road.position_m);
        // the grid of a smoothed road ends behind its last point
        cycle.curves.retain(|curve| curve.start_m < cycle.length_m);
        for curve in &mut cycle.curves {
            curve.end_m = curve.end_m.min(cycle.length_m);
        }
    } else if let Some(path) = path.as_ref().filter(|_| !is_plan) {
        cycle.curves = path.curves(&positions);
    }
    cycle.heading_rad = road.as_ref().or(path.as_ref()).map(Path2d::heading_rad);
    cycle.lacks_curves &= path.is_none() || is_plan;
    cycle.noise = noise;
    account.judged(file, lacks(&quantities, draw))?;
    let Rows { latitude: latitude_deg, longitude: longitude_deg, .. } = rows;
    let points = Points { latitude_deg, longitude_deg, position_m: positions };
    let points = path.is_some().then_some(points);
    Ok((cycle, account, points))
}

/// Whether the way is longer than the beelines by what a road may be.
fn goes_around(odometer_m: Option<&[f64]>, path: &Path2d) -> bool {
    let Some([first_m, .., last_m]) = odometer_m else { return false };
    let beelines_m = path.position_m.last().copied().unwrap_or(0.0);
    (beelines_m..=MOST_AROUND * beelines_m).contains(&(last_m - first_m))
}

/// Refuses points that scatter so much that they tell no road.
pub(crate) fn checked_noise(what: &'static str, noise_m: f64) -> Result<f64, GivenCycleError> {
    let most_m = MOST_NOISE_M;
    if noise_m <= most_m {
        Ok(noise_m)
    } else {
        Err(GivenCycleError::Noise { what, noise_m, most_m })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write;
    use std::path::Path;

    fn parse(text: &str) -> Result<GivenCycle, TableError> {
        read(Source::Text(Path::new("r.csv"), text), &[], &[]).map(|(cycle, ..)| cycle)
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
    fn rows_at_standstill_are_one_and_what_is_missing_is_said() {
        let row = |x_m: f64, y_m: f64| {
            let (lat, lon) = (y_m / 111_195.0, x_m / 111_195.0);
            format!("{lat:.8},{lon:.8},50\n")
        };
        let way = |from: u32, to: u32| (from..to).map(|k| row(20.0 * f64::from(k), 0.0));
        // around the place at 1000 m, on a way of 60 m
        let wanders = (1..300).map(|k: u32| {
            let angle = f64::from(k * k % 628) / 100.0;
            row(1000.0 + 0.2 * angle.cos(), 0.2 * angle.sin())
        });
        let header = "lat,lon,speed_limit_kmh\n".to_owned();
        let read = |text: String| {
            super::read(Source::Text(Path::new("r.csv"), &text), &[], &[]).expect("a route")
        };
        let (plain, ..) = read(header.clone() + &way(0, 101).collect::<String>());
        let stands = way(0, 51).chain(wanders).chain(way(51, 101));
        let (cycle, account, _) = read(header + &stands.collect::<String>());
        assert!((cycle.length_m - plain.length_m).abs() < 1.0, "{}", cycle.length_m);
        assert!(cycle.curves.is_empty(), "{:?}", cycle.curves);
        let checks: Vec<&str> = account.findings.iter().map(|finding| finding.check).collect();
        assert_eq!(checks, ["standstill-drift", "lacks"]);
        assert!(account.warnings()[0].contains("no altitudes, no stops"), "{account:?}");
    }

    #[test]
    fn two_sources_that_differ_are_refused() {
        for (text, message) in [
            (
                "position_m,speed_limit_kmh,altitude_m,grade\n0,70,100,0\n20000,70,700,0\n",
                "altitudes climb by 3.000 % in the mean, its slopes by",
            ),
            (
                "lat,lon,position_m,speed_limit_kmh\n0,0,0,50\n0,.009,1,50\n0,.018,2,50\n\
                 0,.027,3,50\n0,.036,4,50\n0,.045,5,50\n0,.054,6,50\n",
                "km taken for m?",
            ),
        ] {
            let fault = parse(text).unwrap_err().to_string();
            assert!(fault.contains(message), "{fault}");
        }
    }

    #[test]
    fn numbers_that_cannot_be_are_refused_with_their_line() {
        for (text, message) in [
            (
                "lat,lon,speed_limit_kmh\n52,9,50\n95,9,50\n",
                "`r.csv`, line 3, column `lat`: `95`; allowed is -90 to 90",
            ),
            (
                "lat,lon,speed_limit_kmh\n52,-181,50\n53,9,50\n",
                "`r.csv`, line 2, column `lon`: `-181`; allowed is -180 to 360",
            ),
            (
                "# mine\nposition_m,speed_limit_kmh,stop_s\n0,50,0\n300,50,-5\n",
                "`r.csv`, line 4, column `stop_s`: `-5`; allowed is 0 to 172800",
            ),
            (
                "position_m,speed_limit_kmh,curvature_per_m\n0,50,0\n300,50,7\n",
                "`r.csv`, line 3, column `curvature_per_m`: `7`; allowed is -0.5 to 0.5",
            ),
            (
                "position_m,speed_limit_kmh\n0,50\n300,\n",
                "`r.csv`, line 3, column `speed_limit_kmh`: empty; allowed is a finite number",
            ),
            (
                "position_m;speed_limit_kmh\n0.5;50\n300,5;50\n",
                "column `position_m`: `300,5`; allowed is a finite number with a decimal point",
            ),
            (
                "position_m;speed_limit_kmh\n0,5;50\n300.5;50\n",
                "column `position_m`: `300.5`; allowed is a finite number with a decimal comma",
            ),
            ("time_s,speed_kmh\n0,0\n9,50\n", "is a speed over time: it has a column `time_s`"),
            (
                "time_s,position_m,speed_kmh\n0,0,0\n9,50,50\n",
                "unknown columns `time_s`, `speed_kmh` (did you mean `speed_limit_kmh`?); allowed",
            ),
            (
                "lat,speed_limit_kmh\n52,50\n53,50\n",
                "`r.csv` has no column for the longitude: name it `lon`, `longitude`",
            ),
            (
                "lon,speed_limit_kmh\n9,50\n10,50\n",
                "`r.csv` has no column for the latitude: name it `lat`, `latitude`",
            ),
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
                "Speed_limit_kmh",
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
            assert!(fault.contains(&message) && fault.contains("--map"), "{fault}");
        }
    }
}

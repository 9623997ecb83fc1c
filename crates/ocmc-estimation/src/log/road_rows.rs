//! The rows of one road: way, limits, altitude, curves and events.

use super::Samples;
use super::curve::DrivenCurve;
use super::road::{LoggedRoad, RoadCounts, RoadLog, RoadOptions};
use super::road_slope::{Climb, MeasuredAltitude, measured};
use super::sensor::STANDSTILL_MPS;
use super::signal::{LIMITS_MPS, longest_interval_s};
use super::standstill::{Standstill, standstills};
use super::way::DrivenWay;
use ocmc_core::operating_cycle::coverage::UnobservedSpans;
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::road::curvature::Curve;
use ocmc_core::operating_cycle::road::point_event::{
    EventDeclaration, EventKind, KINDS, PointEvent,
};
use ocmc_core::operating_cycle::road::route_geometry::interpolate;
use ocmc_core::operating_cycle::route::type_by_limit;

/// Time without rows through which a road goes on, in s.
const LONGEST_BRIDGE_S: f64 = 10.0;
/// A vehicle that has not moved by more than this stood, in m.
const SAME_PLACE_M: f64 = 1.0;
/// Shortest road, in m: that of a given cycle.
pub(super) const SHORTEST_ROAD_M: f64 = 200.0;
/// Limits that differ by less are one, in m/s.
const SAME_LIMIT_MPS: f64 = 0.1;
/// A limit that changes this close to where the road type does changes with it, in m (judgement).
const AT_TYPE_M: f64 = 25.0;
/// A standstill belongs to an object of the map from so far before it, in m: a queue at a light
/// (judgement).
const QUEUE_M: f64 = 100.0;
/// And up to so far behind it, in m.
const BEHIND_M: f64 = 10.0;

/// Rows of one road.
#[derive(Default)]
pub(super) struct RoadRows {
    /// Rows of the log.
    row: Vec<usize>,
    time_s: Vec<f64>,
    speed_mps: Vec<f64>,
    /// Whether nothing was logged before a row.
    unseen: Vec<bool>,
}

impl RoadRows {
    /// Whether the road goes on at a row behind a time without rows.
    pub(super) fn goes_on(&self, log: &RoadLog, row: usize) -> bool {
        let Some(&last) = self.row.last() else { return true };
        let gap_s = log.drive.time_s[row] - log.drive.time_s[last];
        gap_s <= LONGEST_BRIDGE_S || stood(log, last, row)
    }

    pub(super) fn append(
        &mut self,
        log: &RoadLog,
        row: &[usize],
        time_s: &[f64],
        speed_mps: &[f64],
    ) {
        let still = self.row.last().is_some_and(|&last| stood(log, last, row[0]));
        self.unseen.push(still);
        self.unseen.resize(self.row.len() + row.len(), false);
        self.row.extend_from_slice(row);
        self.time_s.extend_from_slice(time_s);
        self.speed_mps.extend_from_slice(speed_mps);
    }

    /// The first row of the log on it.
    pub(super) fn first_row(&self) -> usize {
        self.row.first().copied().unwrap_or(0)
    }

    /// The last row of the log on it.
    pub(super) fn last_row(&self) -> usize {
        self.row.last().copied().unwrap_or(0)
    }

    /// The drive along its way.
    pub(super) fn way(&self, log: &RoadLog) -> DrivenWay {
        let (way_m, position_m) = self.way_m(log);
        let (time_s, speed_mps) = (self.time_s.clone(), self.speed_mps.clone());
        let (row, unseen) = (self.row.clone(), self.unseen.clone());
        DrivenWay { row, time_s, speed_mps, way_m, position_m, unseen }
    }

    /// Way from the first row on, in m, and the position of that row; none where the way is the
    /// integral of the speed.
    fn way_m(&self, log: &RoadLog) -> (Vec<f64>, Option<f64>) {
        if let Some(positions) = &log.position_m {
            let way: Vec<f64> = self.row.iter().map(|&row| positions[row]).collect();
            let rises = way.windows(2).all(|pair| pair[1] >= pair[0]);
            if rises && way.iter().all(|at| at.is_finite()) {
                let first_m = way.first().copied();
                let way = way.iter().map(|at| at - first_m.unwrap_or(0.0)).collect();
                return (way, first_m);
            }
        }
        let mut way_m = vec![0.0; self.row.len().min(1)];
        for k in 1..self.row.len() {
            let mean = 0.5 * (self.speed_mps[k - 1] + self.speed_mps[k]);
            let mean = if self.unseen[k] { 0.0 } else { mean };
            way_m.push(way_m[k - 1] + mean * (self.time_s[k] - self.time_s[k - 1]));
        }
        (way_m, None)
    }

    /// The road; none where it is too short, or nothing determines its type.
    pub(super) fn road(
        &self,
        log: &RoadLog,
        options: &RoadOptions,
        curves: &[DrivenCurve],
        counts: &mut RoadCounts,
    ) -> Option<LoggedRoad> {
        let way = self.way(log);
        let (way_m, length_m) = (way.way_m.clone(), way.length_m());
        if !(length_m >= SHORTEST_ROAD_M) {
            counts.too_short += 1;
            return None;
        }
        counts.by_speed |= way.position_m.is_none();
        let limits = self.limits(log, &way_m, counts);
        let word = |row: usize| log.road_type.as_ref().map(|words| words[row]);
        let (known, missing) =
            self.steps(&way_m, |row| word(row).filter(|word| !word.is_empty()), |a, b| a == b);
        let road_types: Vec<(f64, &str)> = match &options.road_type {
            _ if !known.is_empty() => {
                counts.without_road_type += missing;
                known
            }
            Some(name) => vec![(0.0, name)],
            None if limits.iter().all(|limit| limit.1.is_nan()) => {
                counts.untyped += 1;
                return None;
            }
            None => {
                counts.typed_by_limit += 1;
                let by_limit = limits.iter().map(|(at_m, limit)| (*at_m, type_by_limit(*limit)));
                let mut types: Vec<_> = by_limit.collect();
                types.dedup_by_key(|start| start.1);
                types
            }
        };
        let limits = at_types(limits, &road_types);
        let stops = standstills(&self.time_s, &self.speed_mps, &way_m, &self.unseen);
        let (events, explained) = self.events(log, options, &way_m, &stops, counts);
        let first = |column: &Option<Samples>| {
            let values = column.as_ref()?;
            self.row.iter().map(|&row| values[row]).find(|value| value.is_finite())
        };
        let rough = |row: usize| log.roughness_m3.as_ref().map(|values| values[row]);
        let (roughness, _) =
            self.steps(&way_m, |row| rough(row).filter(|value| *value > 0.0), |a, b| a == b);
        let (climb, altitudes) = self.climb(log, options, &way_m);
        counts.without_slope += climb.missing;
        counts.altitude_jumps_m += climb.jumps_m;
        let longest_s = longest_interval_s(counts.rows.interval_s);
        let curves_m = self.unturned(log, &way_m, longest_s, counts);
        let unobserved = UnobservedSpans { slope_m: climb.unobserved_m, curves_m };
        let cycle = GivenCycle {
            length_m,
            road_types: Some(
                road_types.iter().map(|(at_m, name)| (*at_m, (*name).to_owned())).collect(),
            ),
            limits,
            altitude: climb.altitude,
            curves: self.curves(options, &way_m, curves, counts),
            roughness: (!roughness.is_empty()).then_some(roughness),
            payload_kg: first(&log.payload_kg),
            departure: first(&log.time_of_day_s)
                .map(|second| (second, first(&log.day_of_year).unwrap_or(f64::NAN))),
            events,
            ..GivenCycle::default()
        };
        let open = stops.into_iter().zip(explained).filter(|(_, explained)| !explained);
        let standstills = open.map(|(stop, _)| stop).collect();
        let row_way_m = way.length_m() / (way.row.len() as f64).max(1.0);
        Some(LoggedRoad { cycle, standstills, unobserved, altitudes, way, row_way_m, part: None })
    }

    /// Values from the places on at which they change, the first one from the start on, and how
    /// many rows have none.
    fn steps<T: Copy>(
        &self,
        way_m: &[f64],
        value: impl Fn(usize) -> Option<T>,
        same: impl Fn(T, T) -> bool,
    ) -> (Vec<(f64, T)>, usize) {
        let mut steps: Vec<(f64, T)> = Vec::new();
        let mut missing = 0;
        for (&row, &at_m) in self.row.iter().zip(way_m) {
            match value(row) {
                None => missing += 1,
                Some(value) if steps.last().is_some_and(|last| same(last.1, value)) => {}
                Some(value) => steps.push((at_m, value)),
            }
        }
        if let Some(first) = steps.first_mut() {
            first.0 = 0.0;
        }
        (one_a_place(steps), missing)
    }

    /// Where limits begin; one without a value where none is known.
    fn limits(&self, log: &RoadLog, way_m: &[f64], counts: &mut RoadCounts) -> Vec<(f64, f64)> {
        let unknown = vec![(0.0, f64::NAN)];
        let Some(column) = &log.drive.limit_mps else { return unknown };
        let possible = |limit: &f64| (LIMITS_MPS[0]..=LIMITS_MPS[1]).contains(limit);
        let value = |row: usize| Some(column[row]).filter(possible);
        let same = |a: f64, b: f64| (a - b).abs() <= SAME_LIMIT_MPS;
        let (limits, missing) = self.steps(way_m, value, same);
        counts.without_limit += missing;
        if limits.is_empty() { unknown } else { limits }
    }

    /// Altitude over the way: of slopes where this road has any, otherwise of altitudes; and these
    /// as they were measured.
    fn climb(
        &self,
        log: &RoadLog,
        options: &RoadOptions,
        way_m: &[f64],
    ) -> (Climb, Vec<MeasuredAltitude>) {
        let own = |column: &Option<Samples>| {
            let values = self.row.iter().map(|&row| column.as_ref()?.get(row).copied());
            let values: Vec<f64> = values.collect::<Option<_>>()?;
            values.iter().any(|value| value.is_finite()).then_some(values)
        };
        if let Some(grade) = own(&log.grade) {
            (Climb::of_grades(way_m, &grade), Vec::new())
        } else if let Some(altitude_m) = own(&log.altitude_m) {
            let average_m = options.altitude_average_m;
            let climb = Climb::of_altitudes(way_m, &self.time_s, &altitude_m, average_m);
            (climb, measured(way_m, &self.time_s, &altitude_m))
        } else {
            (Climb::unobserved(way_m), Vec::new())
        }
    }

    /// Ways without yaw rates, from and to: a detector sees no curve where rows with one are more
    /// than `longest_s` apart.
    fn unturned(
        &self,
        log: &RoadLog,
        way_m: &[f64],
        longest_s: f64,
        counts: &mut RoadCounts,
    ) -> Vec<[f64; 2]> {
        let mut ways = Vec::new();
        let mut known = None;
        for (k, &row) in self.row.iter().enumerate() {
            if !log.drive.yaw_rate_radps.get(row).is_some_and(|yaw| yaw.is_finite()) {
                counts.without_yaw_rate += 1;
                continue;
            }
            let (from_m, time_s) = known.unwrap_or((0.0, f64::NEG_INFINITY));
            if self.time_s[k] - time_s > longest_s && way_m[k] > from_m {
                ways.push([from_m, way_m[k]]);
            }
            known = Some((way_m[k], self.time_s[k]));
        }
        let (from_m, length_m) = (known.map_or(0.0, |known| known.0), way_m[way_m.len() - 1]);
        if length_m > from_m {
            ways.push([from_m, length_m]);
        }
        ways
    }

    /// Curves that lie on this road, within the range of radii.
    fn curves(
        &self,
        options: &RoadOptions,
        way_m: &[f64],
        driven: &[DrivenCurve],
        counts: &mut RoadCounts,
    ) -> Vec<Curve> {
        let (begin_s, end_s) = (self.time_s[0], self.time_s[self.time_s.len() - 1]);
        let here = driven.iter().filter(|c| c.start_s >= begin_s && c.end_s <= end_s);
        let mut curves = Vec::new();
        let window = options.window();
        for curve in here {
            let length_m = curve.turn_rad * curve.radius_m;
            if !window.sees(curve.radius_m, length_m) {
                counts.curves_outside += 1;
                continue;
            }
            let at = |time_s| interpolate(&self.time_s, way_m, time_s);
            let middle_m = 0.5 * (at(curve.start_s) + at(curve.end_s));
            let start_m = (middle_m - 0.5 * length_m).max(0.0);
            let (radius_m, left) = (curve.radius_m, curve.left);
            curves.push(Curve { start_m, end_m: start_m + length_m, radius_m, left });
        }
        curves
    }

    /// Objects of the map with what happened there, and stops of the mission; which standstills
    /// they explain.
    fn events(
        &self,
        log: &RoadLog,
        options: &RoadOptions,
        way_m: &[f64],
        stops: &[Standstill],
        counts: &mut RoadCounts,
    ) -> (Vec<PointEvent>, Vec<bool>) {
        let objects = self.objects(log);
        let count = objects.len();
        let declared = |(first, last, word)| {
            let kind = KINDS.into_iter().find(|kind| kind.map_object == word)?;
            Some((first, last, kind))
        };
        let known: Vec<(usize, usize, &EventDeclaration)> =
            objects.into_iter().filter_map(declared).collect();
        counts.unknown_objects += count - known.len();
        // each standstill belongs to the nearest object at which one stops
        let distance_m = |&(first, last, _): &(usize, usize, &EventDeclaration), at_m: f64| {
            let (before, behind) = (way_m[first] - at_m, at_m - way_m[last]);
            let reach = before <= QUEUE_M && behind <= BEHIND_M;
            if reach { before.max(behind).max(0.0) } else { f64::INFINITY }
        };
        let mut standstill_s: Vec<Option<f64>> = vec![None; known.len()];
        let mut explained = vec![false; stops.len()];
        for (stop, explained) in stops.iter().zip(&mut explained) {
            let apart_m = |k: &usize| distance_m(&known[*k], stop.position_m);
            let places = (0..known.len()).filter(|k| known[*k].2.stops);
            let nearest = places.min_by(|a, b| apart_m(a).total_cmp(&apart_m(b)));
            if let Some(k) = nearest.filter(|k| apart_m(k).is_finite()) {
                *standstill_s[k].get_or_insert(0.0) += stop.duration_s;
                *explained = true;
            }
        }
        let mut events = Vec::with_capacity(known.len());
        for (&(first, last, declared), standstill_s) in known.iter().zip(standstill_s) {
            let slowest_mps =
                self.speed_mps[first..=last].iter().copied().fold(f64::INFINITY, f64::min);
            let kind = (declared.of_log)(standstill_s, slowest_mps);
            let position_m = 0.5 * (way_m[first] + way_m[last]);
            events.push(PointEvent { position_m, kind, turns: false });
        }
        for (stop, explained) in stops.iter().zip(&mut explained) {
            if !*explained && stop.duration_s >= options.mission_stop_s {
                let kind = EventKind::MissionStop { standstill_s: stop.duration_s };
                events.push(PointEvent { position_m: stop.position_m, kind, turns: false });
                *explained = true;
            }
        }
        events.sort_by(|a, b| a.position_m.total_cmp(&b.position_m));
        (events, explained)
    }

    /// Runs of rows with one object: first row, last row, name.
    fn objects<'b>(&self, log: &'b RoadLog) -> Vec<(usize, usize, &'b str)> {
        let mut runs: Vec<(usize, usize, &str)> = Vec::new();
        let Some(column) = &log.map_object else { return runs };
        for (k, &row) in self.row.iter().enumerate() {
            match runs.last_mut() {
                Some(run) if run.1 + 1 == k && run.2 == column[row] => run.1 = k,
                _ if column[row].is_empty() => {}
                _ => runs.push((k, k, column[row])),
            }
        }
        runs
    }
}

/// Whether a vehicle stood between two rows: both at rest, or one of them and no way between.
fn stood(log: &RoadLog, from: usize, to: usize) -> bool {
    let rests = |row: usize| log.drive.speed_mps[row] < STANDSTILL_MPS;
    let moved_m = log.position_m.as_ref().map(|positions| (positions[to] - positions[from]).abs());
    match moved_m {
        Some(moved_m) if moved_m.is_finite() => {
            (rests(from) || rests(to)) && moved_m < SAME_PLACE_M
        }
        _ => rests(from) && rests(to),
    }
}

/// Limits with those that change where the road type does moved to that place: two columns seldom
/// change in the same row.
fn at_types(mut limits: Vec<(f64, f64)>, types: &[(f64, &str)]) -> Vec<(f64, f64)> {
    for (start_m, _) in types.iter().skip(1) {
        for limit in limits.iter_mut().skip(1).filter(|l| (l.0 - start_m).abs() < AT_TYPE_M) {
            limit.0 = *start_m;
        }
    }
    one_a_place(limits)
}

/// Keeps the last of several values at one place.
fn one_a_place<T: Copy>(mut points: Vec<(f64, T)>) -> Vec<(f64, T)> {
    points.dedup_by(|point, kept| {
        let same = point.0 <= kept.0;
        if same {
            kept.1 = point.1;
        }
        same
    });
    points
}

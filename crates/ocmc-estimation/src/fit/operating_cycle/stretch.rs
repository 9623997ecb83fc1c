//! Stretches of road types, and the signs on them.

use super::{SignedCurve, TypeRoads};
use crate::fit::study_parameter::Estimates;
use crate::log::road::LoggedRoad;
use ocmc_core::operating_cycle::coverage::{Coverage, UnobservedSpans, overlap_m};
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::road::curvature::Curve;
use ocmc_core::operating_cycle::road::{RoadModel, RoadTypeModel};
use std::collections::BTreeMap;

/// Start, end and type.
pub(super) type Stretch<'a> = (f64, f64, &'a str);

/// Curves with a smaller gap between them touch, in m: the rounding of positions in files.
const TOUCHING_M: f64 = 1e-3;

/// Face of a sign that is not known.
const NO_FACE: i64 = 0;

/// A sign's face, in tenths of km/h; [`NO_FACE`] where it is not known.
pub(super) fn face(speed_mps: f64) -> i64 {
    if speed_mps.is_finite() { libm::round(36.0 * speed_mps) as i64 } else { NO_FACE }
}

/// The value of a constant track at a position; none of a track without points.
fn held<T: Copy>(points: &[(f64, T)], at_m: f64) -> Option<T> {
    let k = points.partition_point(|point| point.0 <= at_m);
    points.get(k.saturating_sub(1)).map(|point| point.1)
}

/// The stretches of one cycle; none where it has no road types.
pub(super) fn stretches(cycle: &GivenCycle) -> Option<Vec<Stretch<'_>>> {
    let types = cycle.road_types.as_ref().filter(|types| !types.is_empty())?;
    let ends = types.iter().skip(1).map(|start| start.0).chain([cycle.length_m]);
    let stretches = types.iter().zip(ends).map(|((start, name), end)| (*start, end, name.as_str()));
    Some(stretches.filter(|stretch| stretch.1 > stretch.0).collect())
}

/// Adds all that a cycle determines to its types.
pub(super) fn collect(
    stretches: &[Stretch],
    number: usize,
    road: &LoggedRoad,
    coverage: &Coverage,
    base: &RoadModel,
    roads: &mut BTreeMap<String, TypeRoads>,
) {
    let LoggedRoad { cycle, standstills, unobserved, altitudes, .. } = road;
    let near = |curve: &Curve, at_m: f64| (curve.start_m - at_m).abs() < coverage.turn_within_m;
    let junction = |at_m: f64| cycle.curves.iter().find(|curve| near(curve, at_m)).copied();
    let turns = cycle.events.iter().filter_map(|event| junction(event.position_m));
    let turns: Vec<f64> = turns.map(|curve| curve.start_m).collect();
    for (k, &(start, end, name)) in stretches.iter().enumerate() {
        let inside = |at_m: f64| (start..end).contains(&at_m);
        let road = roads.entry(name.to_owned()).or_default();
        let types = base.types.get(name);
        let follow = types.is_some_and(|model| model.curves.reference_sign_mps.is_some());
        road.length_m += end - start;
        road.stretches.push((end - start, k + 1 < stretches.len()));
        if let Some(next) = stretches.get(k + 1) {
            *road.next.entry(next.2.to_owned()).or_insert(0) += 1;
        }
        signs(cycle, unobserved, follow, [start, end], road);
        for (place, curve) in cycle.curves.iter().enumerate() {
            if !inside(curve.start_m) {
                continue;
            }
            let sign_mps = held(&cycle.limits, curve.start_m).unwrap_or(f64::NAN);
            if turns.contains(&curve.start_m) {
                road.turns.push((*curve, face(sign_mps)));
            } else if follow && sign_mps.is_nan() {
                road.unsigned_curves += 1;
            } else {
                let is_cut = curve.end_m >= cycle.length_m;
                let may_be_pushed = row_begins_m(&cycle.curves[..=place]) < start;
                let curve = SignedCurve { curve: *curve, sign_mps, is_cut, may_be_pushed };
                road.curves.push(curve);
            }
        }
        for event in cycle.events.iter().filter(|event| inside(event.position_m)) {
            road.events.push((event.kind, junction(event.position_m).is_some()));
        }
        let stood = standstills.iter().filter(|stop| inside(stop.position_m));
        road.standstills_s.extend(stood.map(|stop| stop.duration_s));
        let free = base.event_free_end_m;
        road.eventless_m += (free - start).clamp(0.0, end - start)
            + (end - (cycle.length_m - free)).clamp(0.0, end - start);
        if altitudes.is_empty() {
            let runs = slopes(cycle, unobserved, base.slope_step_m, start, end);
            road.slopes.extend(runs.into_iter().map(|run| (number, run)));
        }
        if let Some(points) = &cycle.roughness {
            let block = |k: &usize| inside(*k as f64 * base.roughness_block_m);
            let last = libm::ceil(cycle.length_m / base.roughness_block_m) as usize;
            let middle = |k: usize| (k as f64 + 0.5) * base.roughness_block_m;
            let value_at = |k: usize| held(points, middle(k)).unwrap_or(f64::NAN);
            road.blocks.extend((0..last).filter(block).map(value_at));
        }
        if let Some(ground) = cycle.grounds.as_ref().and_then(|grounds| held(grounds, start)) {
            *road.grounds.entry(ground).or_insert(0) += 1;
        }
    }
}

/// Where the row of curves begins that follow each other without a gap up to the last one, in m.
fn row_begins_m(curves: &[Curve]) -> f64 {
    let gap = |pair: &[Curve]| pair[1].start_m - pair[0].end_m > TOUCHING_M;
    let first = curves.windows(2).rposition(gap).map_or(0, |before| before + 1);
    curves[first].start_m
}

/// Lengths under signs, their changes, and the length on which curves are known, within one
/// stretch. Curves that follow the signs are not known where the sign is not.
fn signs(
    cycle: &GivenCycle,
    unobserved: &UnobservedSpans,
    follow: bool,
    [start, end]: [f64; 2],
    road: &mut TypeRoads,
) {
    let changes = cycle.limits.iter().map(|limit| limit.0).filter(|at| *at > start && *at < end);
    let starts: Vec<f64> = [start].into_iter().chain(changes).chain([end]).collect();
    let sign = |at_m: &f64| held(&cycle.limits, *at_m).map_or(NO_FACE, face);
    let faces: Vec<i64> = starts.iter().map(sign).collect();
    for k in 0..starts.len() - 1 {
        let (from, to, known) = (starts[k], starts[k + 1], faces[k] != NO_FACE);
        if known {
            *road.sign_length_m.entry(faces[k]).or_insert(0.0) += to - from;
        }
        if known || !follow {
            let seen = to - from - overlap_m(&unobserved.curves_m, from, to);
            *road.curve_way_m.entry(faces[k]).or_insert(0.0) += seen;
        }
        if k > 0 && faces[k] != faces[k - 1] && known && faces[k - 1] != NO_FACE {
            road.sign_changes.push((faces[k - 1], faces[k]));
        }
    }
}

/// Slopes of the steps that begin within a stretch, less the road's mean slope, in runs of steps
/// whose slope is known.
fn slopes(
    cycle: &GivenCycle,
    unobserved: &UnobservedSpans,
    step_m: f64,
    start: f64,
    end: f64,
) -> Vec<Vec<f64>> {
    let climb_m = |from_m: f64, to_m: f64| cycle.altitude_m(to_m) - cycle.altitude_m(from_m);
    let (mut way_m, mut climbed_m, mut from_m) = (0.0, 0.0, 0.0);
    for [gap_m, to_m] in unobserved.slope_m.iter().copied().chain([[cycle.length_m; 2]]) {
        way_m += gap_m - from_m;
        climbed_m += climb_m(from_m, gap_m);
        from_m = to_m;
    }
    let whole = climbed_m / way_m;
    let first = libm::ceil(start / step_m) as usize;
    let last = libm::ceil(end.min(cycle.length_m - step_m) / step_m) as usize;
    let mut runs = vec![Vec::new()];
    for k in first..last {
        let at = k as f64 * step_m;
        if overlap_m(&unobserved.slope_m, at, at + step_m) > 0.0 {
            runs.push(Vec::new());
        } else if let Some(run) = runs.last_mut() {
            run.push(climb_m(at, at + step_m) / step_m - whole);
        }
    }
    runs.retain(|run| !run.is_empty());
    runs
}

/// Mean length, and the types that follow.
pub(super) fn fit_chain(roads: &TypeRoads, model: &mut RoadTypeModel, estimates: &mut Estimates) {
    let ended = roads.stretches.iter().filter(|stretch| stretch.1).count();
    if ended == 0 {
        estimates.warn(
            "no stretch of it ends before its road: mean length and next type stay \
            those of the base study",
        );
        return;
    }
    let minimum = model.minimum_length_m;
    let beyond: f64 = roads.stretches.iter().map(|stretch| (stretch.0 - minimum).max(0.0)).sum();
    let mean = beyond / ended as f64;
    let error = Some(mean / libm::sqrt(ended as f64));
    estimates.set("mean_length_m", &mut model.mean_length_m, minimum + mean, error, ended);
    // a type that never followed keeps its key: a study that is laid over another one replaces
    // keys, and drops none
    for share in model.next.values_mut() {
        *share = 0.0;
    }
    for (name, &count) in &roads.next {
        let into = model.next.entry(name.clone()).or_default();
        estimates.share(&format!("next.{name}"), into, count, ended);
    }
}

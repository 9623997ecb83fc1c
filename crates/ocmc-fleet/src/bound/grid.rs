//! The places of a leg at which its optimum may change speed: dense near rest, at every change of
//! what is allowed, and even in between.

use super::driven::{DrivenLeg, Heights};
use ocmc_core::event_kind::Point;
use ocmc_core::operating_cycle::segments::Segment;
use ocmc_core::tactical::SpeedProfile;

/// How fine the search is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fineness {
    /// Longest piece of road between two places, in m.
    pub piece_m: f64,
    /// Difference of the speeds that are tried last, in m/s.
    pub speed_mps: f64,
}

impl Default for Fineness {
    fn default() -> Self {
        Self { piece_m: 40.0, speed_mps: 0.2 }
    }
}

/// Near rest the places are as far apart as a truck takes to gain so much, in m/s.
const GAIN_MPS: f64 = 1.0;
/// Acceleration by which they are placed, in m/s².
const PLACING_MPS2: f64 = 0.5;
/// Closer places are one, in m: near rest, and elsewhere.
const CLOSEST_M: [f64; 2] = [0.4, 4.0];
/// Way from a rest that is near it, in m.
const NEAR_REST_M: f64 = 20.0;
/// Limits that differ by less are the same, in m/s.
const SAME_LIMIT_MPS: f64 = 0.05;

/// A place of a leg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    /// Way since the leg's start, in m.
    pub way_m: f64,
    /// Height over the road's start, in m.
    pub height_m: f64,
    /// Highest allowed speed, by the plan and by the drive, in m/s.
    pub most_mps: f64,
    /// Driven speed, in m/s.
    pub driven_mps: f64,
    /// Planned speed, in m/s.
    pub planned_mps: f64,
    /// Static limit behind the place, in m/s.
    pub limit_mps: f64,
    /// Whether a curve makes that limit.
    pub in_curve: bool,
    /// Index of the section behind the place.
    pub section: u32,
}

/// Points that decide the kinds of the pieces between the places of a leg.
pub(super) fn points(places: &[Place]) -> Vec<Point> {
    let last = places.len() - 1;
    let point = |(k, place): (usize, &Place)| Point {
        way_m: place.way_m,
        height_m: place.height_m,
        planned_mps: place.planned_mps,
        driven_mps: place.driven_mps,
        limit_mps: place.limit_mps,
        in_curve: place.in_curve,
        is_start: k == 0,
        is_stop: k == last,
    };
    places.iter().enumerate().map(point).collect()
}

/// Number of the segment that a place of the road lies in.
fn segment_at(segments: &[Segment], place_m: f64) -> usize {
    segments.partition_point(|segment| segment.start_m <= place_m).max(1) - 1
}

/// The places of a leg, from rest to rest.
pub(super) fn places(
    leg: &DrivenLeg,
    plan: &SpeedProfile,
    heights: &Heights,
    fineness: &Fineness,
) -> Vec<Place> {
    let length_m = leg.length_m();
    let ways = ways(leg, plan, fineness);
    let last = ways.len() - 1;
    let place = |(k, way_m): (usize, f64)| {
        let at_m = leg.place_m(way_m);
        let i = segment_at(&plan.segments, at_m);
        let segment = &plan.segments[i];
        let driven_mps = leg.speed_at(way_m);
        let mut planned_mps = plan.speed_mps(i, (at_m - segment.start_m).min(segment.length_m));
        // at a boundary what was before counts, too
        if at_m - segment.start_m < CLOSEST_M[0] && i > 0 {
            planned_mps = planned_mps.min(plan.speed_mps(i - 1, plan.segments[i - 1].length_m));
        }
        let ends = k == 0 || k == last;
        let branch = &plan.branches[i];
        Place {
            way_m: if k == last { length_m } else { way_m },
            height_m: heights.at(at_m),
            most_mps: if ends { 0.0 } else { planned_mps.max(driven_mps).max(0.1) },
            driven_mps: if ends { 0.0 } else { driven_mps.max(0.05) },
            planned_mps,
            limit_mps: branch.limit.sqrt(),
            in_curve: segment.curve().is_some() && !branch.by_sign,
            section: segment.section,
        }
    };
    ways.into_iter().enumerate().map(place).collect()
}

/// Ways of the places of a leg, in m.
fn ways(leg: &DrivenLeg, plan: &SpeedProfile, fineness: &Fineness) -> Vec<f64> {
    let length_m = leg.length_m();
    let per_road = length_m / (leg.road_m[1] - leg.road_m[0]).max(1e-3);
    let mut kinks = Vec::new();
    let first = segment_at(&plan.segments, leg.road_m[0]);
    for i in first + 1..plan.segments.len() {
        let segment = &plan.segments[i];
        if segment.start_m >= leg.road_m[1] {
            break;
        }
        let change = plan.branches[i].limit.sqrt() - plan.branches[i - 1].limit.sqrt();
        if change.abs() > SAME_LIMIT_MPS || segment.event().is_some() {
            kinks.push((segment.start_m - leg.road_m[0]) * per_road);
        }
    }
    // the least distance to a place from either end, and its successor
    let scale = fineness.piece_m / Fineness::default().piece_m;
    let near = |k: f64, mps2: f64| (k * GAIN_MPS) * (k * GAIN_MPS) * scale / (2.0 * mps2);
    let half_m = 0.5 * length_m;
    let mut ways = vec![0.0, length_m];
    for (mps2, from_end) in [(PLACING_MPS2, false), (0.5 * plan.twice_deceleration, true)] {
        let (mut k, mut before_m) = (1.0, 0.0);
        loop {
            let at_m = near(k, mps2);
            let step_m = (at_m - before_m).min(fineness.piece_m);
            before_m += step_m;
            if before_m >= half_m {
                break;
            }
            ways.push(if from_end { length_m - before_m } else { before_m });
            k += 1.0;
        }
    }
    if ways.len() == 2 {
        ways.push(half_m);
    }
    ways.sort_by(f64::total_cmp);
    let even = ways.len();
    ways.extend(kinks.iter().filter(|way| **way > 0.0 && **way < length_m));
    let (even, kinks) = ways.split_at(even);
    // kinks stay where they are, even places give way to them
    let mut all: Vec<(f64, bool)> = even.iter().map(|way| (*way, false)).collect();
    all.extend(kinks.iter().map(|way| (*way, true)));
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut kept: Vec<(f64, bool)> = Vec::with_capacity(all.len());
    for (way_m, kink) in all {
        let from_rest_m = way_m.min(length_m - way_m);
        let closest_m = CLOSEST_M[usize::from(from_rest_m > NEAR_REST_M)];
        let ends = way_m == 0.0 || way_m == length_m;
        match kept.last().copied() {
            Some((before_m, fixed)) if way_m - before_m < closest_m => {
                if ends && before_m > 0.0 || kink && !fixed {
                    kept.pop();
                    kept.push((way_m, true));
                }
            }
            _ => kept.push((way_m, kink || ends)),
        }
    }
    if kept.len() == 2 {
        kept.insert(1, (half_m, false));
    }
    kept.into_iter().map(|(way_m, _)| way_m).collect()
}

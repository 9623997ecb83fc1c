//! The speed that a driver wants along a road as a drive cycle: for following it exactly, on drawn
//! and on given roads.

use super::drive_cycle::{DriveCycle, SHORTEST_STEP_S};
use crate::operating_cycle::segments::Segment;
use crate::study::{Scenario, Study};
use crate::tactical::{SpeedProfile, plan};

/// Longest piece of road that one step covers, in m.
const LONGEST_M: f64 = 10.0;
/// Shorter pieces are joined to the next one, in m.
const SHORTEST_M: f64 = 1.0;

/// The planned speed of a scenario over time, from rest to rest, its standstills included.
pub fn planned_cycle(study: &Study, scenario: &Scenario) -> DriveCycle {
    let mut profile = SpeedProfile::default();
    plan(study, scenario, &mut profile);
    let road = &scenario.cycle.road;
    let (mut time, mut speed, mut slope) = (vec![0.0], vec![0.0], vec![0.0]);
    let (mut way_m, mut climb_m, mut now_s, mut now_mps) = (0.0, 0.0, 0.0, 0.0);
    let last = profile.segments.len() - 1;
    for (i, segment) in profile.segments.iter().enumerate() {
        let next = profile.segments.get(i + 1);
        let event = next.and_then(Segment::event);
        let rest_s = event.and_then(|k| scenario.passage(k).standstill_s());
        let pieces = libm::ceil(segment.length_m / LONGEST_M).max(1.0);
        let piece_m = segment.length_m / pieces;
        for k in 1..=pieces as usize {
            way_m += piece_m;
            climb_m += piece_m * road.slopes[segment.slope as usize];
            let ends = k == pieces as usize;
            let rests = ends && (rest_s.is_some() || i == last);
            if way_m < SHORTEST_M && !rests {
                continue;
            }
            let mut end_mps = profile.speed_mps(i, k as f64 * piece_m);
            if ends && i < last {
                end_mps = end_mps.min(profile.speed_mps(i + 1, 0.0));
            }
            if rests {
                end_mps = 0.0;
            }
            // a truck that rests at both ends of a short piece of road has to move in between
            let mean_mps = (0.5 * (now_mps + end_mps)).max(0.5);
            now_s += (way_m / mean_mps).max(SHORTEST_STEP_S);
            now_mps = end_mps;
            time.push(now_s);
            speed.push(end_mps);
            slope.push((climb_m / way_m).clamp(-0.5, 0.5));
            (way_m, climb_m) = (0.0, 0.0);
            if rests && i < last {
                now_s += rest_s.unwrap_or(0.0).max(0.01);
                time.push(now_s);
                speed.push(0.0);
                slope.push(0.0);
            }
        }
    }
    DriveCycle::of_plan(time, speed, slope)
}

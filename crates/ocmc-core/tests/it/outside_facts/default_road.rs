//! Roads of the default study: their curves as drawn, and as the detector would find them on a map.

use super::curve_detector::{STEP_M, curvature, detect};
use super::curve_table::CurveTable;
use ocmc_core::operating_cycle::road::Road;
use ocmc_core::operating_cycle::road::curvature::Curve;

/// Limit at a position, in km/h.
fn limit_kmh(road: &Road, position_m: f64) -> f64 {
    let behind = road.signs.partition_point(|sign| sign.start_m <= position_m);
    3.6 * road.signs[behind.saturating_sub(1)].speed_mps
}

/// The road's curves, with or without turns at junctions.
pub(crate) fn curves(road: &Road, turns: bool) -> Vec<Curve> {
    let at_junction = |curve: &Curve| {
        road.events.iter().any(|event| event.turns && event.position_m == curve.start_m)
    };
    road.curves.iter().filter(|curve| turns || !at_junction(curve)).copied().collect()
}

/// Adds a road's length by limit.
pub(crate) fn add_length(road: &Road, table: &mut CurveTable) {
    for (k, sign) in road.signs.iter().enumerate() {
        let end_m = road.signs.get(k + 1).map_or(road.length_m, |next| next.start_m);
        table.add_length(3.6 * sign.speed_mps, end_m - sign.start_m);
    }
}

/// Adds curves as drawn, each to the limit at its middle.
pub(crate) fn add_drawn(road: &Road, curves: &[Curve], table: &mut CurveTable) {
    for curve in curves {
        let middle_m = f64::midpoint(curve.start_m, curve.end_m);
        table.add_curve(limit_kmh(road, middle_m), curve.radius_m);
    }
}

/// Adds curves as the detector finds them on the road's path.
pub(crate) fn add_detected(road: &Road, curves: &[Curve], half: usize, table: &mut CurveTable) {
    let (x, y) = path(road.length_m, curves);
    for found in detect(&curvature(&x, &y, half)) {
        table.add_curve(limit_kmh(road, found.middle() as f64 * STEP_M), found.radius_m);
    }
}

/// Positions every [`STEP_M`]: straights and circles.
fn path(length_m: f64, curves: &[Curve]) -> (Vec<f64>, Vec<f64>) {
    let steps = (length_m / STEP_M) as usize;
    let mut turn = vec![0.0; steps];
    for curve in curves {
        let (first, last) = ((curve.start_m / STEP_M) as usize, (curve.end_m / STEP_M) as usize);
        for (k, turn) in turn.iter_mut().enumerate().take(last + 1).skip(first) {
            let start_m = k as f64 * STEP_M;
            let inside_m = (start_m + STEP_M).min(curve.end_m) - start_m.max(curve.start_m);
            *turn += curve.curvature_per_m() * inside_m.max(0.0);
        }
    }
    let (mut x, mut y, mut heading) = (vec![0.0], vec![0.0], 0.0);
    for (k, turn) in turn.iter().enumerate() {
        let middle: f64 = heading + 0.5 * turn;
        x.push(x[k] + STEP_M * middle.cos());
        y.push(y[k] + STEP_M * middle.sin());
        heading += turn;
    }
    (x, y)
}

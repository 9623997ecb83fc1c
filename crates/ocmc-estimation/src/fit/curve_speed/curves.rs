//! Measured curves: what is used of them, and what is left out and why.

use super::{CurveSpeedFitError, CurveSpeedOptions};
use crate::log::surroundings::Surroundings;
use std::collections::BTreeMap;

/// A truck that was slower than this share of its speed in a curve somewhere near the curve was
/// slowed by something else than the curve (judgement).
const FREE_SHARE: f64 = 0.8;

/// A truck that gains speed faster than this in the middle of a curve, in m/s², has not reached the
/// speed that its driver wants there (judgement: at 15 m/s it gains 2 % of its speed in 100 m).
const STEADY_MPS2: f64 = 0.05;

/// Measured curves as columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurveTable {
    /// Driver or truck: the groups of the analysis.
    pub driver: Vec<String>,
    /// Radius of the curve, in m.
    pub radius_m: Vec<f64>,
    /// Speed in the curve, in m/s.
    pub speed_mps: Vec<f64>,
    /// Whether the curve turns left, where the direction is known.
    pub left: Option<Vec<bool>>,
    /// Length of the route that the curve belongs to, in m, where it is known.
    pub route_m: Option<Vec<f64>>,
    /// Speed limit in the curve, in m/s, where limits are known; NaN or 0 where this one is not,
    /// infinite where there is none.
    pub limit_mps: Option<Vec<f64>>,
    /// Mean acceleration in the middle of the curve, in m/s², where it is known; NaN where this one
    /// is not.
    pub acceleration_mps2: Option<Vec<f64>>,
    /// Surroundings of the curve, where they are known; NaN where a number is not.
    pub around: Option<Vec<Surroundings>>,
}

/// Rows left out, by reason.
pub type Dropped = BTreeMap<&'static str, usize>;

/// One curve that takes part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Curve {
    /// Place of the driver in [`Curves::drivers`].
    pub driver: usize,
    /// ln R − ln R₀.
    pub log_radius: f64,
    /// ln v.
    pub log_speed: f64,
    pub left: bool,
    /// ln of the speed limit; infinite where there is none, NaN where it is not known.
    pub log_limit: f64,
    /// Whether the truck still gained speed in the middle.
    pub accelerating: bool,
}

/// The curves that take part.
#[derive(Clone, Debug)]
pub(super) struct Curves {
    /// Names, in the order of their first curve.
    pub drivers: Vec<String>,
    pub rows: Vec<Curve>,
    pub smallest_radius_m: f64,
    pub largest_radius_m: f64,
}

impl Curves {
    /// The curves of these places alone; drivers without one are left out.
    pub(super) fn only(&self, keep: impl Fn(&Curve) -> bool) -> Self {
        let mut place = vec![None; self.drivers.len()];
        let mut drivers = Vec::new();
        let mut curves = Vec::new();
        for curve in self.rows.iter().filter(|curve| keep(curve)) {
            let driver = *place[curve.driver].get_or_insert_with(|| {
                drivers.push(self.drivers[curve.driver].clone());
                drivers.len() - 1
            });
            curves.push(Curve { driver, ..*curve });
        }
        Self { drivers, rows: curves, ..*self }
    }

    /// Number of curves of each driver.
    pub(super) fn counts(&self) -> Vec<usize> {
        let mut counts = vec![0; self.drivers.len()];
        for curve in &self.rows {
            counts[curve.driver] += 1;
        }
        counts
    }
}

/// Sorts out which curves take part.
pub(super) fn select(
    table: &CurveTable,
    options: &CurveSpeedOptions,
) -> Result<(Curves, Dropped), CurveSpeedFitError> {
    let n = table.driver.len();
    let lengths = [
        ("radius_m", Some(table.radius_m.len())),
        ("speed_mps", Some(table.speed_mps.len())),
        ("direction", table.left.as_ref().map(Vec::len)),
        ("route_m", table.route_m.as_ref().map(Vec::len)),
        ("limit_mps", table.limit_mps.as_ref().map(Vec::len)),
        ("acceleration_mps2", table.acceleration_mps2.as_ref().map(Vec::len)),
        ("gap_before_m", table.around.as_ref().map(Vec::len)),
    ];
    if options.isolated_m.is_some() && table.around.is_none() {
        return Err(CurveSpeedFitError::NoGaps);
    }
    for (column, length) in lengths {
        if let Some(length) = length.filter(|&length| length != n) {
            return Err(CurveSpeedFitError::UnequalColumns { column, length, wanted: n });
        }
    }
    let mut dropped = Dropped::new();
    let mut places = BTreeMap::new();
    let mut drivers = Vec::new();
    let mut curves = Vec::with_capacity(n);
    let (mut smallest, mut largest) = (f64::INFINITY, 0.0f64);
    for k in 0..n {
        let (radius, speed) = (table.radius_m[k], table.speed_mps[k]);
        let route = table.route_m.as_ref().map(|lengths| lengths[k]);
        let missing = table.driver[k].is_empty() || radius.is_nan() || !speed.is_finite();
        let [tightest, widest] = options.radius_range_m;
        let slow = speed * speed < options.least_lateral_mps2 * radius;
        let against = [
            (missing, "missing_value"),
            (!(speed > 0.0), "speed_not_positive"),
            (!(radius > 0.0), "radius_not_positive"),
            (radius < tightest, "radius_too_small"),
            (radius > widest, "radius_too_large"),
            (slow, "lateral_acceleration_too_small"),
            (route.is_some_and(|length| !(length > options.minimum_route_m)), "route_too_short"),
        ];
        let around = table.around.as_ref().zip(options.isolated_m);
        let near = around.and_then(|(around, way_m)| not_free(&around[k], speed, way_m));
        let held = against.into_iter().find(|(holds, _)| *holds).map(|(_, reason)| reason);
        if let Some(reason) = held.or(near) {
            *dropped.entry(reason).or_insert(0) += 1;
            continue;
        }
        let driver = *places.entry(table.driver[k].as_str()).or_insert_with(|| {
            drivers.push(table.driver[k].clone());
            drivers.len() - 1
        });
        let limit = table.limit_mps.as_ref().map_or(f64::NAN, |limits| limits[k]);
        smallest = smallest.min(radius);
        largest = largest.max(radius);
        curves.push(Curve {
            driver,
            log_radius: libm::log(radius / options.reference_radius_m),
            log_speed: libm::log(speed),
            left: table.left.as_ref().is_none_or(|left| left[k]),
            log_limit: if limit > 0.0 { libm::log(limit) } else { f64::NAN },
            accelerating: table
                .acceleration_mps2
                .as_ref()
                .is_some_and(|accelerations| accelerations[k] > STEADY_MPS2),
        });
    }
    if curves.is_empty() {
        return Err(CurveSpeedFitError::NoCurves { rows: n, dropped });
    }
    let curves =
        Curves { drivers, rows: curves, smallest_radius_m: smallest, largest_radius_m: largest };
    Ok((curves, dropped))
}

/// Why a curve was not driven freely: what lies within `way_m` of it; none where it was.
fn not_free(around: &Surroundings, speed_mps: f64, way_m: f64) -> Option<&'static str> {
    let gap_m = around.gap_before_m.min(around.gap_after_m);
    let missing = around.gap_before_m.is_nan() || around.gap_after_m.is_nan();
    let against = [
        (missing, "missing_value"),
        (gap_m < way_m, "near_another_curve"),
        (around.stop_near_m.is_some_and(|stop_m| stop_m < way_m), "near_a_standstill"),
        (around.slowest_near_mps < FREE_SHARE * speed_mps, "slower_nearby"),
    ];
    against.into_iter().find(|(holds, _)| *holds).map(|(_, reason)| reason)
}

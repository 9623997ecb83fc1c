//! The mission driven here: by VECTO's driver, and by ours.

use super::VectoRequest;
use super::error::ComparisonError;
use super::terms::Terms;
use super::truck::ComparedTruck;
use crate::driver::{LookAhead, VectoDriver, plan};
use crate::file::MissionFile;
use ocmc_core::kernel::drive::scheduler::drive_scenario;
use ocmc_core::powertrain::ShiftConvention;
use ocmc_core::prescribed::DriveCycle;
use ocmc_core::record::Outcome;
use ocmc_io::given_cycle::RouteOptions;
use serde::Serialize;
use std::path::Path;

/// Step of the grid over distance on which speeds are compared, in m.
const GRID_M: f64 = 1.0;
/// Distance that a truck may lack of VECTO's and still cover the mission, in m: half a second of
/// travel.
const SHORT_M: f64 = 10.0;

/// How the driven speed lies to VECTO's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SpeedMatch {
    /// Root mean square of the difference of v(s) on a grid of a metre over the common distance, in
    /// km/h.
    pub rms_kmh: f64,
    /// Whether the truck covers the distance of VECTO's.
    pub covers: bool,
}

/// VECTO's driver on a mission: what it takes, and its speed.
pub(super) fn by_vectos_driver(
    truck: &ComparedTruck,
    mission: &MissionFile,
    auxiliary_w: f64,
    driver: &VectoDriver,
) -> Result<(Terms, DriveCycle), ComparisonError> {
    let constant_w = (auxiliary_w - mission.added_power_w).max(0.0);
    let planned = plan(&mission.mission, &truck.body, truck.combustion()?, constant_w, driver);
    let cycle = planned.drive_cycle().map_err(ComparisonError::Plan)?;
    // an engine of VECTO 3 drags and turns down in a gap
    let convention = match driver.look_ahead {
        Some(LookAhead::DecisionFactor { .. }) => ShiftConvention::Lost,
        _ => ShiftConvention::Returned,
    };
    let terms = truck.follow(&cycle, convention)?;
    Ok((terms, cycle))
}

/// Our typical driver on a mission that begins at rest, in VECTO's air; none on others, and where
/// the truck does not arrive.
pub(super) fn by_our_driver(
    request: &VectoRequest,
    compared: &ComparedTruck,
    file: &Path,
    mission: &MissionFile,
) -> Result<Option<Terms>, ComparisonError> {
    if !mission.begins_at_rest {
        return Ok(None);
    }
    let loaded = compared.in_vectos_air(request)?;
    let given = loaded.on_routes(&[file.to_owned()], &[], RouteOptions::default())?;
    let record = drive_scenario(&given.study, given.study.sample(1, 0));
    Ok((record.outcome == Outcome::Completed).then(|| Terms::record(&record)))
}

/// Compares two speeds over distance.
pub(super) fn speed_match(ours: &DriveCycle, vectos: &DriveCycle) -> SpeedMatch {
    let (ours, vectos) = (over_distance(ours), over_distance(vectos));
    let end_m = |points: &[[f64; 2]]| points.last().map_or(0.0, |point| point[0]);
    let common_m = end_m(&ours).min(end_m(&vectos));
    let places = (common_m / GRID_M).floor() as usize;
    let squares = (0..=places).map(|k| {
        let at_m = GRID_M * k as f64;
        let apart_kmh = 3.6 * (at(&ours, at_m) - at(&vectos, at_m));
        apart_kmh * apart_kmh
    });
    let mean = squares.sum::<f64>() / (places + 1) as f64;
    SpeedMatch { rms_kmh: mean.sqrt(), covers: end_m(&ours) >= end_m(&vectos) - SHORT_M }
}

/// Position and speed of the points of a cycle that moves.
fn over_distance(cycle: &DriveCycle) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = Vec::new();
    let (mut position_m, mut last) = (0.0, [0.0, 0.0]);
    for (k, [time_s, speed_mps, _]) in cycle.points().enumerate() {
        if k > 0 {
            position_m += 0.5 * (speed_mps + last[1]) * (time_s - last[0]);
        }
        points.push([position_m, speed_mps]);
        last = [time_s, speed_mps];
    }
    points
}

/// Speed at a position, linear between the points.
fn at(points: &[[f64; 2]], position_m: f64) -> f64 {
    let k = points.partition_point(|point| point[0] <= position_m);
    let (Some(before), Some(after)) = (k.checked_sub(1).map(|k| points[k]), points.get(k)) else {
        return points.get(k).or(points.last()).map_or(0.0, |point| point[1]);
    };
    let share = (position_m - before[0]) / (after[0] - before[0]);
    before[1] + share * (after[1] - before[1])
}

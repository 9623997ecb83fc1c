//! The tactical module: from a scenario to the desired speed along the road.
//!
//! The paper's Eq. 1 takes the lowest of five static speeds (sign, curve, bump, stop, traffic) and of their five
//! anticipating versions. Anticipation at constant deceleration is linear in n = v², so all constraints ahead
//! together are one backward sweep, n_b(x) = min_j [n_j + 2 a (x_j − x)]; looking only at the next change, as printed, fails
//! where a low limit follows a mild one closely. A rise of the limit is followed with the driver's acceleration, one
//! forward sweep (or at once, `rise = "paper"`). A standing truck starts because the accelerating branch never lies below
//! the launch speed (closed-loop rule 1).
//!
//! The printed v' = √(v_{i+1} − 2 a (x_{i+1} − x)) subtracts m²/s² from m/s: v_{i+1} has to be squared.

use crate::driver::Driver;
use crate::driver::speed_change::Rise;
use crate::operating_cycle::OperatingCycle;
use crate::operating_cycle::segments::{Segment, lower};
use crate::road::point_event::EventKind;
use crate::study::{Scenario, Study};

/// Desired speed squared of one segment, in m²/s²: the lowest of three branches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedBranch {
    /// Static limit.
    pub limit: f64,
    /// Braking branch at the segment's end; grows by 2 a_dec for each m before it.
    pub backward_end: f64,
    /// Accelerating branch at the segment's start; grows by 2 a_acc for each m behind it, and is at least launch².
    pub forward_start: f64,
}

/// Desired speed squared along the road: piecewise linear in position, stops included.
#[derive(Clone, Debug, Default)]
pub struct SpeedProfile {
    /// The stretches on which everything is constant.
    pub segments: Vec<Segment>,
    /// The branches of each segment.
    pub branches: Vec<SpeedBranch>,
    /// Twice the deceleration, in m/s².
    pub twice_deceleration: f64,
    /// Twice the acceleration, in m/s².
    pub twice_acceleration: f64,
    /// Square of the launch speed, in m²/s².
    pub launch: f64,
}

impl SpeedProfile {
    /// Desired speed in segment `i`, `behind_m` behind its start, in m/s.
    pub fn speed_mps(&self, i: usize, behind_m: f64) -> f64 {
        let branch = &self.branches[i];
        let ahead_m = self.segments[i].length_m - behind_m;
        let backward = branch.backward_end + self.twice_deceleration * ahead_m;
        let forward = (branch.forward_start + self.twice_acceleration * behind_m).max(self.launch);
        branch.limit.min(backward).min(forward).sqrt()
    }
}

/// Plans the speed profile of a scenario into `profile`, whose buffers are reused.
pub fn plan(study: &Study, scenario: &Scenario, profile: &mut SpeedProfile) {
    let (cycle, driver) = (&scenario.cycle, &scenario.driver);
    cycle.segments(&mut profile.segments);
    static_limits(study, scenario, profile);
    let change = &driver.speed_change;
    profile.twice_deceleration = 2.0 * change.deceleration_mps2;
    profile.twice_acceleration = 2.0 * change.acceleration_mps2;
    profile.launch = change.launch_speed_mps * change.launch_speed_mps;
    backward_sweep(profile, cycle, driver);
    forward_sweep(profile, cycle, driver);
}

/// The lowest static speed of each segment: sign, curve, traffic.
fn static_limits(study: &Study, scenario: &Scenario, profile: &mut SpeedProfile) {
    let (cycle, driver) = (&scenario.cycle, &scenario.driver);
    let road = &cycle.road;
    let curve_speeds: Vec<f64> = road
        .curves
        .iter()
        .zip(&scenario.curve_residuals)
        .map(|(curve, z)| driver.curve_speed.speed_mps(curve.radius_m, curve.left, *z))
        .collect();
    let types = study.operating_cycle().road().types();
    let traffic = study.operating_cycle().traffic();
    let (mut key, mut base) = ((u32::MAX, u32::MAX, u32::MAX), 0.0);
    profile.branches.clear();
    for segment in &profile.segments {
        // sign and traffic hold over many segments
        let here = (segment.sign, segment.traffic, segment.section);
        if here != key {
            key = here;
            let sign_mps = road.signs[segment.sign as usize].speed_mps;
            let road_type = road.sections[segment.section as usize].road_type;
            let truck_limit = types[road_type].truck_limit_mps.unwrap_or(f64::INFINITY);
            let density = cycle.traffic[segment.traffic as usize].density_per_m;
            let flow =
                if density > 0.0 { traffic.speed_mps(density, sign_mps) } else { f64::INFINITY };
            base = driver.speed_limit.sign_speed_mps(sign_mps, truck_limit).min(flow);
        }
        let speed = segment.curve().map_or(base, |k| base.min(curve_speeds[k]));
        profile.branches.push(SpeedBranch {
            limit: speed * speed,
            backward_end: 0.0,
            forward_start: 0.0,
        });
    }
}

/// Speed squared that an event allows at its place.
fn event_limit(kind: &EventKind, driver: &Driver) -> f64 {
    match kind {
        EventKind::StopSign { .. }
        | EventKind::GiveWayStop { .. }
        | EventKind::RedLight { .. }
        | EventKind::MissionStop { .. } => 0.0,
        EventKind::GiveWayPass { speed_mps } => speed_mps * speed_mps,
        EventKind::GreenLight => f64::INFINITY,
        EventKind::SpeedBump { length_m, height_m } => {
            let speed = driver.speed_limit.bump_speed_mps(*length_m, *height_m);
            speed * speed
        }
    }
}

/// Speed squared allowed where segment `i` starts, by the event there alone.
fn node_limit(segment: &Segment, cycle: &OperatingCycle, driver: &Driver) -> f64 {
    segment.event().map_or(f64::INFINITY, |k| event_limit(&cycle.road.events[k].kind, driver))
}

/// From the end, where the truck stops, to the start.
fn backward_sweep(profile: &mut SpeedProfile, cycle: &OperatingCycle, driver: &Driver) {
    let mut node: f64 = 0.0;
    for i in (0..profile.segments.len()).rev() {
        let (segment, branch) = (&profile.segments[i], &mut profile.branches[i]);
        branch.backward_end = node;
        let reached = node + profile.twice_deceleration * segment.length_m;
        let allowed = lower(branch.limit, node_limit(segment, cycle, driver));
        node = lower(reached, allowed);
    }
}

/// From the start, where the truck stands, to the end.
fn forward_sweep(profile: &mut SpeedProfile, cycle: &OperatingCycle, driver: &Driver) {
    if driver.speed_change.rise == Rise::Paper {
        for branch in &mut profile.branches {
            branch.forward_start = f64::INFINITY;
        }
        // a stop is left at once, too
        return;
    }
    let mut node = 0.0;
    for i in 0..profile.segments.len() {
        let (segment, branch) = (&profile.segments[i], &mut profile.branches[i]);
        let event = node_limit(segment, cycle, driver);
        branch.forward_start = lower(node, lower(event, branch.limit));
        let reached = branch.forward_start + profile.twice_acceleration * segment.length_m;
        // what is really reached: no branch may lie above the others at the node. The launch speed is a floor under the
        // whole branch wherever it is read; a floor at the nodes, too, would make the ramp depend on where nodes lie.
        node = lower(reached, lower(branch.backward_end, branch.limit));
    }
}

//! Chargers of a planned road, as the driver of a truck looks at them.

use super::rest_stops::is_mission_stop;
use crate::charging::ChargingPolicy;
use crate::study::{Scenario, Study};
use crate::tactical::SpeedProfile;

/// Distance before a braking ramp that a driver keeps to see it, in m.
const ROOM_M: f64 = 300.0;
/// Places closer than this are one, in m.
const SAME_M: f64 = 1e-3;

/// A charger of the way, and what its driver looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Site {
    /// Where it is, in m, and the row that ends there.
    pub position_m: f64,
    pub row: usize,
    /// Where he decides, in m.
    pub decided_at_m: f64,
    /// How high it lies above the start, in m.
    pub altitude_m: f64,
    /// The next place at which the truck can be charged, or the end, in m, and the climb to it, in
    /// m.
    pub reach_m: f64,
    pub reach_climb_m: f64,
    /// The next place at which the driver can rest, or the end, in m.
    pub pause_m: f64,
    /// Where the mission has a stop on the way to it that charges, it is decided from there.
    pub after_m: f64,
}

/// Where roads are cut for it, in m.
pub(super) fn cuts_m(study: &Study, scenario: &Scenario) -> impl Iterator<Item = f64> {
    let ahead_m = decides_before_m(study, scenario);
    let chargers = scenario.chargers.iter().map(|charger| charger.position_m);
    chargers.flat_map(move |at_m| [at_m - ahead_m, at_m])
}

/// How far before a charger is decided, in m.
fn decides_before_m(study: &Study, scenario: &Scenario) -> f64 {
    let driver = &scenario.driver;
    let signs = scenario.cycle.road.signs.iter();
    let speeds = signs.map(|sign| driver.speed_limit.sign_speed_mps(sign.speed_mps, f64::INFINITY));
    let most_mps = speeds.fold(0.0, f64::max);
    let ramp_m = 0.5 * most_mps * most_mps / driver.speed_change.deceleration_mps2 + ROOM_M;
    ramp_m.max(study.vehicle().powertrain.preconditions_from_m())
}

/// The chargers of a planned road, as its driver looks at them. `stop_rows`: rows that end at a
/// stop line, and its event.
pub(super) fn sites(
    study: &Study,
    policy: &ChargingPolicy,
    scenario: &Scenario,
    profile: &SpeedProfile,
    stop_rows: &[(usize, Option<usize>)],
) -> Vec<Site> {
    let ahead_m = decides_before_m(study, scenario);
    let (road, chargers) = (&scenario.cycle.road, &scenario.chargers);
    let row_to = |place_m: f64| {
        let starts_before = |start_m: f64| start_m < place_m - SAME_M;
        profile.segments.partition_point(|segment| starts_before(segment.start_m)) - 1
    };
    // stops of the mission: where, the row, and whether the truck is charged there
    let stops = stop_rows.iter().filter_map(|(row, event)| {
        let event = &road.events[(*event)?];
        let standstill_s = event.kind.standstill_s().filter(|_| is_mission_stop(event))?;
        let charges = policy.stop.as_ref().is_some_and(|stop| standstill_s >= stop.shortest_s);
        Some((event.position_m, *row, charges))
    });
    let stops: Vec<(f64, usize, bool)> = stops.collect();
    let (mut at_m, mut altitude_m) = (0.0, 0.0);
    let site = |(k, charger): (usize, &crate::charging::Charger)| {
        let position_m = charger.position_m;
        altitude_m += road.climb_m([at_m, position_m]);
        at_m = position_m;
        let next_m = chargers.get(k + 1).map_or(road.length_m, |next| next.position_m);
        let mut ahead = stops.iter().filter(|(at_m, ..)| *at_m > position_m);
        let reach = ahead.clone().find(|(at_m, _, charges)| *charges && *at_m < next_m);
        let pause_m = ahead.next().map_or(next_m, |(at_m, ..)| at_m.min(next_m));
        let reach_m = reach.map_or(next_m, |(at_m, ..)| *at_m);
        let before = stops.iter().rev().find(|(at_m, _, charges)| *charges && *at_m < position_m);
        Site {
            position_m,
            row: row_to(position_m),
            decided_at_m: position_m - ahead_m,
            altitude_m,
            reach_m,
            reach_climb_m: road.climb_m([position_m, reach_m]),
            pause_m,
            after_m: before.map_or(0.0, |(at_m, ..)| *at_m),
        }
    };
    chargers.iter().enumerate().map(site).collect()
}

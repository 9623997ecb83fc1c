//! Where a driver stops to charge and to rest: he decides at the place where he would have to brake
//! for a charger, or to heat his battery for it, by a forecast.
//!
//! He stops where the next place at which he could charge is out of reach with his reserve, and where
//! the next place at which he could rest is out of reach by the law. What he gets wrong uses up his
//! reserve, or makes him rest on the spot. Nothing is driven twice.

use super::lane_task::LaneTask;
use super::rest_stops::{AHEAD_S, LAST_S, NEAR_M, is_mission_stop};
use super::road_row::RoadRow;
use super::state::Lane;
use super::stop_ahead::{Standing, StopAhead};
use crate::charging::{ChargingPolicy, Driven, Goal};
use crate::energy_ledger::Term;
use crate::powertrain::Powertrain;
use crate::study::{Scenario, Study};
use crate::tactical::SpeedProfile;
use fearless_simd::Simd;

/// What a driver keeps before a braking ramp to see it, in m.
const ROOM_M: f64 = 300.0;
/// The longest stretch of road without a place to halt, in m.
const LONGEST_M: f64 = 2000.0;
/// Places closer than this are one, in m.
const SAME_M: f64 = 1e-3;

/// A charger of the way, and what its driver looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Site {
    /// Where it is, in m, and the row that ends there.
    pub position_m: f64,
    row: usize,
    /// Where he decides, in m.
    pub decided_at_m: f64,
    /// The last row before the next place at which the truck can be charged, or of the road.
    reach_row: usize,
    /// The next place at which the driver can rest, or the end, in m.
    pause_m: f64,
    /// Where the mission has a stop on the way to it that charges, it is decided from there.
    after_m: f64,
}

/// The longest braking ramp, in m, and where roads are cut, in m.
pub(super) fn cuts(study: &Study, scenario: &Scenario) -> (f64, Vec<f64>) {
    let [ramp_m, ahead_m] = distances_m(study, scenario);
    let chargers = scenario.chargers.iter().map(|charger| charger.position_m);
    let mut places_m: Vec<f64> =
        chargers.flat_map(|at_m| [at_m - ahead_m, at_m]).filter(|at_m| *at_m > 0.0).collect();
    let road = &scenario.cycle.road;
    if road.slope_step_m > LONGEST_M {
        let count = (road.length_m / LONGEST_M) as u32;
        places_m.extend((1..=count).map(|k| LONGEST_M * f64::from(k)));
    }
    places_m.sort_unstable_by(f64::total_cmp);
    (ramp_m, places_m)
}

/// How long braking ramps are at most, and how far before a charger is decided, in m.
fn distances_m(study: &Study, scenario: &Scenario) -> [f64; 2] {
    let driver = &scenario.driver;
    let signs = scenario.cycle.road.signs.iter();
    let speeds = signs.map(|sign| driver.speed_limit.sign_speed_mps(sign.speed_mps, f64::INFINITY));
    let most_mps = speeds.fold(0.0, f64::max);
    let ramp_m = 0.5 * most_mps * most_mps / driver.speed_change.deceleration_mps2 + ROOM_M;
    [ramp_m, ramp_m.max(study.vehicle().powertrain.preconditions_from_m())]
}

/// The chargers of a planned road, as its driver looks at them. `stop_rows`: rows that end at a stop
/// line, and its event.
pub(super) fn sites(
    study: &Study,
    policy: &ChargingPolicy,
    scenario: &Scenario,
    profile: &SpeedProfile,
    stop_rows: &[(usize, Option<usize>)],
) -> Vec<Site> {
    let [_, ahead_m] = distances_m(study, scenario);
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
    let last = profile.segments.len() - 1;
    let of = |(k, charger): (usize, &crate::charging::Charger)| {
        let position_m = charger.position_m;
        let next = chargers.get(k + 1).map(|next| (next.position_m, row_to(next.position_m)));
        let (next_m, next_row) = next.unwrap_or((road.length_m, last));
        let mut ahead = stops.iter().filter(|(at_m, ..)| *at_m > position_m);
        let reach = ahead.clone().find(|(at_m, _, charges)| *charges && *at_m < next_m);
        let pause_m = ahead.next().map_or(next_m, |(at_m, ..)| at_m.min(next_m));
        let before = stops.iter().rev().find(|(at_m, _, charges)| *charges && *at_m < position_m);
        Site {
            position_m,
            row: row_to(position_m),
            decided_at_m: position_m - ahead_m,
            reach_row: reach.map_or(next_row, |(_, row, _)| *row),
            pause_m,
            after_m: before.map_or(0.0, |(at_m, ..)| *at_m),
        }
    };
    chargers.iter().enumerate().map(of).collect()
}

impl LaneTask {
    /// The trip so far, as its driver knows it. `from`: the row that begins where he is.
    fn driven<S: Simd, P: Powertrain>(&mut self, lane: &Lane<S, P>, from: usize) -> Driven {
        let number = lane.number;
        let (ledger, rows) = (&lane.state.ledger, &lane.state.motion.roads[number]);
        let mut climb_m2ps2 = 0.0;
        if let Some(charging) = &mut self.charging {
            let progress = &mut charging.progress;
            if progress.climbed_rows < from {
                progress.climb_m2ps2 += climb(&rows[progress.climbed_rows..from]);
                progress.climbed_rows = from;
            }
            climb_m2ps2 = progress.climb_m2ps2;
        }
        Driven {
            way_m: ledger[Term::Distance][number],
            time_s: ledger[Term::Time][number],
            drawn_j: ledger[Term::Battery][number],
            climbed_j: self.scenario.vehicle.mass_kg * climb_m2ps2,
        }
    }

    /// Decides at all chargers at which it is time to, where the truck is. `from`: the row that begins
    /// there.
    pub(super) fn decide<S: Simd, P: Powertrain>(
        &mut self,
        lane: &mut Lane<S, P>,
        here_m: f64,
        from: usize,
    ) {
        loop {
            let waits = self.has_stop_ahead(here_m + SAME_M);
            let Some(charging) = &mut self.charging else { return };
            let Some(site) = charging.sites.get(charging.progress.next_site).copied() else {
                return;
            };
            let is_here = site.decided_at_m.max(site.after_m) <= here_m + SAME_M;
            if waits || !is_here {
                return;
            }
            charging.progress.next_site += 1;
            if site.row < from {
                continue;
            }
            let [charges, rests] = self.needs(lane, here_m, from, &site);
            if charges && let Some(charging) = &mut self.charging {
                charging.planned.push(site.position_m);
            }
            if charges || rests {
                let (row, position_m) = (site.row, site.position_m);
                self.stop_ahead(lane, from, StopAhead { row, position_m, rests });
            }
        }
    }

    /// Whether a driver stops at a charger, to charge and to rest.
    fn needs<S: Simd, P: Powertrain>(
        &mut self,
        lane: &Lane<S, P>,
        here_m: f64,
        from: usize,
        site: &Site,
    ) -> [bool; 2] {
        let driven = self.driven(lane, from);
        let powertrain = lane.parameters.powertrain;
        let known = lane.parameters.charging.and_then(|policy| {
            let (public, forecast) = (policy.public.as_ref()?, policy.forecast.as_ref()?);
            let charge = powertrain.charge_of(&lane.state.powertrain, lane.number)?;
            Some((policy, public, forecast, charge, powertrain.store()?))
        });
        let Some((policy, public, forecast, charge, store)) = known else { return [false; 2] };
        let rows = &lane.state.motion.roads[lane.number];
        let mass_kg = self.scenario.vehicle.mass_kg;
        let takes = |from: usize, to: usize| {
            let rows = &rows[from..=to];
            forecast.energy_j(&driven, length_m(rows), mass_kg * climb(rows)) / store.capacity_j
        };
        let arrives = charge - takes(from, site.row);
        let reaches = arrives - takes(site.row + 1, site.reach_row);
        let keeps = store.lowest_charge.max(policy.reserve);
        let charges = reaches < keeps && arrives < public.end_at;
        let with_margin = 1.0 + forecast.margin;
        let way_s = with_margin * driven.time_s(site.position_m - here_m);
        let next_s = with_margin * driven.time_s(site.pause_m - site.position_m);
        let rests = self.rests.as_mut().is_some_and(|rests| {
            rests.drive_to(driven.time_s);
            rests.has_to_rest_at(way_s, next_s)
        });
        [charges, rests]
    }

    /// State of charge with which the goal of a truck that is charged at a place comes within its reach,
    /// by its driver's forecast; infinite where it is to be charged to the end.
    pub(super) fn enough_charge<S: Simd, P: Powertrain>(
        &mut self,
        lane: &Lane<S, P>,
        at: &Standing,
    ) -> f64 {
        let is_planned =
            self.charging.as_ref().is_some_and(|stops| stops.planned.contains(&at.position_m));
        let known = lane.parameters.charging.filter(|_| is_planned).and_then(|policy| {
            let (public, forecast) = (policy.public.as_ref()?, policy.forecast.as_ref()?);
            let enough = public.enough.as_ref()?;
            Some((policy, enough, forecast, lane.parameters.powertrain.store()?))
        });
        let Some((policy, enough, forecast, store)) = known else { return f64::INFINITY };
        let driven = self.driven(lane, at.row + 1);
        let rows = &lane.state.motion.roads[lane.number];
        let sites = self.charging.iter().flat_map(|charging| &charging.sites);
        let next =
            sites.filter(|site| site.position_m > at.position_m + SAME_M).map(|site| site.row);
        let to = match enough.reach {
            Goal::Destination => None,
            Goal::NextCharger => next.min(),
        };
        let ahead = &rows[at.row + 1..=to.unwrap_or(rows.len() - 1)];
        let climb_j = self.scenario.vehicle.mass_kg * climb(ahead);
        let way_m = (1.0 + enough.margin) * length_m(ahead);
        let takes_j = forecast.energy_j(&driven, way_m, climb_j);
        store.lowest_charge.max(policy.reserve) + takes_j.max(0.0) / store.capacity_j
    }

    /// How long a truck has to stand where it does, because the next place to rest is out of reach by
    /// the law, in s; 0 where it is not. `stands_s`: how long it stands without the law.
    pub(super) fn rest_asked_s<S: Simd, P: Powertrain>(
        &mut self,
        lane: &Lane<S, P>,
        at: &Standing,
        stands_s: f64,
    ) -> f64 {
        let driven = self.driven(lane, at.row + 1);
        let forecast = lane.parameters.charging.and_then(|policy| policy.forecast.as_ref());
        let next_m = self.next_pause_m(at.position_m);
        let Some(rests) = self.rests.as_mut().filter(|_| at.is_rest) else { return 0.0 };
        let with_margin = 1.0 + forecast.map_or(0.0, |forecast| forecast.margin);
        let next_s = with_margin * driven.time_s(next_m - at.position_m);
        rests.drive_to(driven.time_s);
        rests.asked_s(stands_s, next_s, at.rests)
    }

    /// The next place behind another one at which a driver can rest, or the end, in m.
    fn next_pause_m(&self, behind_m: f64) -> f64 {
        let road = &self.scenario.cycle.road;
        let mut events = road.events.iter();
        let stop =
            events.find(|event| event.position_m > behind_m + SAME_M && is_mission_stop(event));
        let mut chargers = self.scenario.chargers.iter().map(|charger| charger.position_m);
        let charger_m = chargers.find(|at_m| *at_m > behind_m + SAME_M);
        let end_m = road.length_m;
        stop.map_or(end_m, |stop| stop.position_m).min(charger_m.unwrap_or(end_m))
    }

    /// Whether the law on rests is kept by stops that the driver decides on.
    pub(super) fn rests_ahead(&self) -> bool {
        self.charging.is_some() && self.rests.is_some()
    }

    /// Where the limit of driving is near, and no stop is, a rest is taken on the spot: at the first
    /// place at which the truck can halt.
    pub(super) fn rest_on_the_spot<S: Simd, P: Powertrain>(&mut self, lane: &mut Lane<S, P>) {
        let left_s = self.rests.as_ref().map_or(f64::INFINITY, |rests| rests.left_s());
        if left_s > AHEAD_S {
            return;
        }
        let here_m = Self::position_m(lane);
        let next_m = self.next_pause_m(here_m);
        let is_near = next_m < here_m + 2.0 * NEAR_M;
        if self.has_stop_ahead(here_m) || is_near && left_s > LAST_S {
            return;
        }
        let ramp_m = self.charging.as_ref().map_or(0.0, |charging| charging.ramp_m);
        let at = lane.state.motion.at[lane.number];
        let rows = &lane.state.motion.roads[lane.number];
        let mut end_m = here_m + lane.state.motion.left[lane.number];
        let mut found = None;
        for (row, RoadRow(columns)) in rows.iter().enumerate().skip(at + 1) {
            end_m += columns[RoadRow::LENGTH];
            if end_m > next_m {
                break;
            }
            let is_free = columns[RoadRow::DWELL] < 0.0;
            if is_free && end_m > here_m + ramp_m {
                found = Some(row);
                break;
            }
        }
        let Some(row) = found else { return };
        self.stop_ahead(lane, at + 1, StopAhead { row, position_m: end_m, rests: true });
    }
}

fn length_m(rows: &[RoadRow]) -> f64 {
    rows.iter().map(|row| row.0[RoadRow::LENGTH]).sum()
}

/// g times the climb of rows, in m²/s².
fn climb(rows: &[RoadRow]) -> f64 {
    rows.iter().map(|row| row.0[RoadRow::GRADE] * row.0[RoadRow::LENGTH]).sum()
}

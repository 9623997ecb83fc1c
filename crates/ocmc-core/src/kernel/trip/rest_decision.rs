//! Where a driver rests: he decides on his way, by what he has driven so far.
//!
//! Where he stands at a place to rest, at a stop of the mission or a charger, he stays for as long
//! as the law asks if the next one is out of reach of its limit. At a charger that he only passes
//! he stops for it ([`super::charging_decision`]). Near the limit he looks how long it takes to
//! halt, and halts on the spot as late as that allows: the limit is never passed. Nothing is driven
//! twice.

use super::lane_task::LaneTask;
use super::rest_stops::{AGAIN_S, AHEAD_S, is_mission_stop};
use super::stop_ahead::{Standing, StopAhead};
use crate::energy::ledger::Term;
use crate::kernel::step::road_row::RoadRow;
use crate::kernel::step::state::Lane;
use crate::powertrain::Powertrain;
use fearless_simd::Simd;

/// Margin that a driver adds to the time that he expects, over it, where the study has no forecast
/// (judgement).
const MARGIN: f64 = 0.05;
/// At his present speed he drives on for this before he brakes for a place that he has chosen, in
/// s.
const ROOM_S: f64 = 10.0;
/// Time that he keeps in reserve when he halts, in s (judgement).
const KEPT_S: f64 = 60.0;
/// Places closer than this are one, in m.
const SAME_M: f64 = 1e-3;

/// A place at which a truck can halt.
struct Place {
    row: usize,
    /// The way to it, in m.
    way_m: f64,
    /// How long it takes to halt there, in s.
    halting_s: f64,
}

impl LaneTask {
    /// How long a truck has to stand where it does, because the next place to rest is out of reach
    /// by the law, in s; 0 where it is not. `stands_s`: how long it stands without the law.
    pub(super) fn rest_asked_s<S: Simd, P: Powertrain>(
        &mut self,
        lane: &mut Lane<S, P>,
        at: &Standing,
        stands_s: f64,
    ) -> f64 {
        if self.rests.is_none() {
            return 0.0;
        }
        let driven = self.driven(lane, 0.0, 0.0);
        let forecast = lane.parameters.charging.and_then(|policy| policy.forecast.as_ref());
        let with_margin = 1.0 + forecast.map_or(MARGIN, |forecast| forecast.margin);
        let next_m = self.next_pause_m(at.position_m);
        let next_s = with_margin * driven.time_s(next_m - at.position_m);
        let Some(rests) = self.rests.as_mut().filter(|_| at.is_rest) else { return 0.0 };
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

    /// Where the limit of driving is near, a driver who will not reach a place to rest in time
    /// halts on the spot, as late as he can.
    pub(super) fn rest_on_the_spot<S: Simd, P: Powertrain>(&mut self, lane: &mut Lane<S, P>) {
        let Some(rests) = &mut self.rests else { return };
        rests.drive_to(lane.state.ledger[Term::Time][lane.number]);
        let left_s = rests.left_s();
        if left_s > AHEAD_S {
            return;
        }
        let at = lane.state.motion.at[lane.number];
        // on his way to a charger he may come to see that it is too far
        let mut ahead = self.stops_ahead.iter().filter(|stop| stop.row >= at);
        if ahead.any(|stop| !self.is_charger(stop.row)) {
            return;
        }
        let place = place_to_halt(lane, self.next_pause_row(at), left_s);
        let Some(place) = place.filter(|place| place.halting_s + AGAIN_S + KEPT_S > left_s) else {
            return;
        };
        let position_m = Self::position_m(lane) + place.way_m;
        let stop = StopAhead { row: place.row, position_m, rests: true };
        for later in &mut self.stops_ahead {
            later.rests = false;
        }
        self.stop_ahead(lane, at + 1, stop);
    }

    /// Whether a charger is at the end of a row.
    fn is_charger(&self, row: usize) -> bool {
        let mut sites = self.charging.iter().flat_map(|charging| &charging.sites);
        sites.any(|site| site.row == row)
    }

    /// The row at whose end the next place is at which a driver can rest, or the last one. A
    /// charger that he has decided to pass is none.
    fn next_pause_row(&self, at: usize) -> usize {
        let events = &self.scenario.cycle.road.events;
        let is_pause = |event: Option<usize>| event.is_none_or(|k| is_mission_stop(&events[k]));
        let mut stops =
            self.road.stops.iter().filter(|(row, _, event)| *row >= at && is_pause(*event));
        let undecided = self.charging.iter().flat_map(|charging| {
            charging.sites[charging.progress.next_site..].iter().map(|site| site.row)
        });
        let decided = self.stops_ahead.iter().map(|stop| stop.row);
        let charger = undecided.chain(decided).filter(|row| *row >= at).min();
        stops.next().map_or(usize::MAX, |stop| stop.0).min(charger.unwrap_or(usize::MAX))
    }
}

/// The first place at which a truck can halt; none where the next place to rest comes before it, or
/// is reached in the time that is left.
fn place_to_halt<S: Simd, P: Powertrain>(
    lane: &Lane<S, P>,
    pause_row: usize,
    left_s: f64,
) -> Option<Place> {
    let (motion, number) = (&lane.state.motion, lane.number);
    let (at, speed_mps) = (motion.at[number], motion.speed[number]);
    let twice_deceleration = lane.state.constants.twice_deceleration[number];
    let ramp_m = speed_mps * speed_mps / twice_deceleration;
    // braking takes twice as long as its way at this speed
    let (mut way_m, mut time_s) = (0.0, speed_mps / twice_deceleration);
    let mut place: Option<Place> = None;
    for (row, columns) in motion.roads[number].iter().enumerate().skip(at) {
        let length_m = if row == at { motion.left[number] } else { columns.0[RoadRow::LENGTH] };
        way_m += length_m;
        time_s += length_m / speed_mps.min(columns.static_mps()).max(1.0);
        if row >= pause_row {
            return place.filter(|_| time_s + KEPT_S > left_s);
        }
        let dwell_s = columns.dwell_s();
        let is_free = row > at && dwell_s.is_none();
        if place.is_none() && is_free && way_m > ramp_m + ROOM_S * speed_mps {
            place = Some(Place { row, way_m, halting_s: time_s });
        }
        time_s += dwell_s.unwrap_or(0.0);
        if place.is_some() && time_s + KEPT_S > left_s {
            break;
        }
    }
    place
}

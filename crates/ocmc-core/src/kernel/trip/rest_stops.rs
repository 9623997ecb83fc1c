//! Rests on one trip: what the law's clock says while the truck is driven and stands. Where it
//! stops for them its driver decides on his way ([`super::rest_decision`]).

use super::stop_ahead::Standing;
use crate::operating_cycle::road::Road;
use crate::operating_cycle::road::point_event::{EventKind, PointEvent};
use crate::rest::{Activity, DutyClock};
use crate::study::{Scenario, Study};

/// Driving time that is to be left at the next place to rest, in s: the time that it takes to halt
/// (judgement).
const HALTING_S: f64 = 60.0;
/// Shortest driving time at departure without a rest before, in s.
pub(crate) const SHORTEST_START_S: f64 = 300.0;
/// So long before the limit a driver begins to look how long it takes to halt, in s (judgement).
pub(super) const AHEAD_S: f64 = 300.0;
/// He looks again after this, in s.
pub(super) const AGAIN_S: f64 = 10.0;
/// The longest stretch of road without a place to halt, in m.
const LONGEST_M: f64 = 200.0;

/// The rests of one trip.
#[derive(Clone, Debug)]
pub(super) struct RestStops {
    at_departure: DutyClock,
    clock: DutyClock,
    /// Driving time, standstill not counted, up to which the clock has gone.
    driven_s: f64,
    /// Time that the law has added to the standstill, in s, and number of its additions.
    pub added_s: f64,
    pub taken: u32,
}

impl RestStops {
    /// Rests of a trip, where the study has a law on rests.
    pub(super) fn new(study: &Study, scenario: &Scenario) -> Option<Self> {
        let model = study.model().rest.as_ref()?;
        let after = |driven_s| DutyClock::new(model.law, model.drivers, driven_s);
        let brought = scenario.handover.as_ref().and_then(|handover| handover.clock);
        let mut clock = brought.unwrap_or_else(|| after(scenario.driven_before_s));
        if clock.left_s() < SHORTEST_START_S {
            clock = after(0.0);
        }
        Some(Self { at_departure: clock, clock, driven_s: 0.0, added_s: 0.0, taken: 0 })
    }

    /// The trip begins.
    pub(super) fn depart(&mut self) {
        let clock = self.at_departure;
        *self = Self { at_departure: clock, clock, driven_s: 0.0, added_s: 0.0, taken: 0 };
    }

    /// The clock at the end of a trip, after this driving time.
    pub(super) fn clock_at_end(&self, driven_s: f64) -> DutyClock {
        let mut clock = self.clock;
        clock.pass(Activity::Driving, driven_s - self.driven_s);
        clock
    }

    /// The truck has been driven on, to this driving time.
    pub(super) fn drive_to(&mut self, driven_s: f64) {
        self.clock.pass(Activity::Driving, driven_s - self.driven_s);
        self.driven_s = driven_s;
    }

    /// The truck stands for some time, of which the law has added a part, in s; below zero where it
    /// has not. A stop of the mission is a rest, any other one a part of the driving.
    pub(super) fn stand(&mut self, at: &Standing, dwell_s: f64, added_s: f64) {
        let activity = if at.is_rest { Activity::Rest } else { Activity::Driving };
        self.clock.pass(activity, dwell_s);
        if added_s > 0.0 {
            self.added_s += added_s;
            self.taken += 1;
        }
    }

    /// How long may still be driven, in s.
    pub(super) fn left_s(&self) -> f64 {
        self.clock.left_s()
    }

    /// Whether a driver has to rest at a place so far away, in s, because the one behind it is out
    /// of reach of the limit; only where it is within reach after the rest.
    pub(super) fn has_to_rest_at(&self, way_s: f64, next_s: f64) -> bool {
        let mut then = self.clock;
        if then.left_s() <= way_s || then.left_s() >= way_s + next_s + HALTING_S {
            return false;
        }
        then.pass(Activity::Driving, way_s);
        then.pass(Activity::Rest, then.length_s(then.next_rest().0));
        then.left_s() >= next_s + HALTING_S
    }

    /// How long a truck that stands for some time has to stand, because the next place is out of
    /// reach of the limit, in s; 0 where it is not. `is_due`: its driver has stopped for it.
    pub(super) fn asked_s(&self, stands_s: f64, next_s: f64, is_due: bool) -> f64 {
        let clock = self.clock;
        let mut then = clock;
        then.pass(Activity::Rest, stands_s);
        let length_s = clock.length_s(clock.next_rest().0);
        let mut rested = clock;
        rested.pass(Activity::Rest, length_s);
        let reaches = |clock: DutyClock| clock.left_s() >= next_s + HALTING_S;
        if is_due || !reaches(then) && reaches(rested) { length_s } else { 0.0 }
    }
}

pub(super) fn is_mission_stop(event: &PointEvent) -> bool {
    matches!(event.kind, EventKind::MissionStop { .. })
}

/// Where the slopes of a road are too long to halt at their ends alone: places between, in m.
pub(super) fn halts_m(road: &Road) -> impl Iterator<Item = f64> {
    let is_long = road.slope_step_m > LONGEST_M;
    let count = if is_long { (road.length_m / LONGEST_M) as u32 } else { 0 };
    (1..=count).map(|k| LONGEST_M * f64::from(k))
}

/// Driving time until the limit has to be looked at again, in s, where so much is left.
pub(super) fn until_look_s(left_s: f64) -> f64 {
    if left_s > AHEAD_S { left_s - AHEAD_S } else { AGAIN_S }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rest::RestLaw;

    #[test]
    fn a_driver_rests_where_the_next_place_is_out_of_reach_before_it_and_within_reach_after() {
        let clock = DutyClock::new(RestLaw::Eu561, 1, 0.0);
        let stops = RestStops { at_departure: clock, clock, driven_s: 0.0, added_s: 0.0, taken: 0 };
        // 4 h 30 min may be driven: 16,200 s, of which 60 s are for halting
        assert_eq!(clock.left_s(), 16_200.0);
        for (way_s, next_s, rests) in [
            (10_000.0, 6_140.0, false),
            (10_000.0, 6_141.0, true),
            (10_000.0, 16_140.0, true),
            (10_000.0, 16_141.0, false),
            (16_199.0, 1_000.0, true),
            (16_200.0, 1_000.0, false),
        ] {
            assert_eq!(stops.has_to_rest_at(way_s, next_s), rests, "{way_s} {next_s}");
        }
    }
}

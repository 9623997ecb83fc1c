//! Rests on one trip: where the law's clock comes to its limit, the trip ends there, gets its rest
//! put in, and is driven again from its start, until it is driven to its end. Who charges on the way
//! decides on his rests there, too ([`super::charging_decision`]): nothing is driven again.

use super::stop_ahead::Standing;
use crate::operating_cycle::road::point_event::{EventKind, PointEvent};
use crate::rest::{Activity, DutyClock};
use crate::study::{Scenario, Study};

/// A driver looks for a place to rest so long before the limit, in s: the time that it takes to halt
/// (judgement).
pub(super) const HALTING_S: f64 = 60.0;
/// The same of a driver who decides on his way, in s (judgement): he has to find a place.
pub(super) const AHEAD_S: f64 = 240.0;
/// At this time before the limit he must not go on, in s: two steps.
pub(super) const LAST_S: f64 = 5.0;
/// A stop so near is still reached, in m: how far a truck comes in the time to halt.
pub(super) const NEAR_M: f64 = 1500.0;
/// Who may drive no longer than this at departure has rested before, in s.
pub(super) const SHORTEST_START_S: f64 = 300.0;
/// Room of a rest beside other events, in m.
const ROOM_M: f64 = 5.0;
/// Attempts after which a trip is given up.
const MOST_ATTEMPTS: u32 = 1000;

/// A stop that the law has put in or made longer.
#[derive(Clone, Copy, Debug)]
struct RestStop {
    position_m: f64,
    /// What it would have been without the law; none where it would not be there.
    own_s: Option<f64>,
}

/// What the law has seen of a trip so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct RestProgress {
    clock: DutyClock,
    /// Driving time, standstill not counted, up to which the clock has gone.
    driven_s: f64,
    /// Where the last rest was, in m.
    rested_at_m: f64,
    /// The last stop of the mission since then, and the clock before it.
    last_stop: Option<(usize, DutyClock)>,
    /// What the law has added to the standstill, in s, and how often.
    pub added_s: f64,
    pub taken: u32,
}

impl RestProgress {
    fn new(clock: DutyClock) -> Self {
        let (driven_s, rested_at_m, added_s) = (0.0, 0.0, 0.0);
        Self { clock, driven_s, rested_at_m, last_stop: None, added_s, taken: 0 }
    }
}

/// The rests of one trip.
#[derive(Clone, Debug)]
pub(super) struct RestStops {
    at_departure: DutyClock,
    stops: Vec<RestStop>,
    /// Where a rest has to be put in, in m.
    due_at_m: Option<f64>,
    attempts: u32,
    /// What has been seen so far.
    pub progress: RestProgress,
}

impl RestStops {
    /// Those of a trip, where the study has a law on rests.
    pub(super) fn new(study: &Study, scenario: &Scenario) -> Option<Box<Self>> {
        let model = study.model().rest.as_ref()?;
        let after = |driven_s| DutyClock::new(model.law, model.drivers, driven_s);
        let brought = scenario.handover.as_ref().and_then(|handover| handover.clock);
        let mut clock = brought.unwrap_or_else(|| after(scenario.driven_before_s));
        if clock.left_s() < SHORTEST_START_S {
            clock = after(0.0);
        }
        Some(Box::new(Self {
            at_departure: clock,
            stops: Vec::new(),
            due_at_m: None,
            attempts: 0,
            progress: RestProgress::new(clock),
        }))
    }

    /// An attempt begins.
    pub(super) fn depart(&mut self) {
        self.progress = RestProgress::new(self.at_departure);
        self.due_at_m = None;
        self.attempts += 1;
    }

    /// The clock at the end of a trip, after this driving time.
    pub(super) fn clock_at_end(&self, driven_s: f64) -> DutyClock {
        let mut clock = self.progress.clock;
        clock.pass(Activity::Driving, driven_s - self.progress.driven_s);
        clock
    }

    /// The truck has been driven on, to this driving time.
    pub(super) fn drive_to(&mut self, driven_s: f64) {
        self.progress.clock.pass(Activity::Driving, driven_s - self.progress.driven_s);
        self.progress.driven_s = driven_s;
    }

    /// The truck stands, for longer than planned where it is charged. A stop of the mission is a rest,
    /// any other one a part of the driving. Returns whether the law asked for it.
    pub(super) fn stand(&mut self, at: &Standing, planned_s: f64, dwell_s: f64) -> bool {
        let position_m = at.position_m;
        if !at.is_rest {
            self.progress.clock.pass(Activity::Driving, dwell_s);
            return false;
        }
        let before = self.progress.clock;
        self.progress.clock.pass(Activity::Rest, dwell_s);
        let added = self.stops.iter().find(|stop| stop.position_m == position_m);
        if let Some(stop) = added {
            self.progress.added_s += planned_s - stop.own_s.unwrap_or(0.0);
            self.progress.taken += 1;
        }
        if self.progress.clock.driven_s() == 0.0 {
            (self.progress.rested_at_m, self.progress.last_stop) = (position_m, None);
        } else if let Some(event) = at.event {
            self.progress.last_stop = Some((event, before));
        }
        added.is_some()
    }

    /// How long may still be driven, in s.
    pub(super) fn left_s(&self) -> f64 {
        self.progress.clock.left_s()
    }

    /// Whether a driver has to rest at a place so far away, in s, because the one behind it is out of
    /// reach of the limit; only where it is within reach after the rest.
    pub(super) fn has_to_rest_at(&self, way_s: f64, next_s: f64) -> bool {
        let mut then = self.progress.clock;
        if then.left_s() <= way_s || then.left_s() >= way_s + next_s + HALTING_S {
            return false;
        }
        then.pass(Activity::Driving, way_s);
        then.pass(Activity::Rest, then.length_s(then.next_rest().0));
        then.left_s() >= next_s + HALTING_S
    }

    /// How long a truck that stands for some time has to stand, because the next place is out of reach
    /// of the limit, in s; 0 where it is not. `is_due`: its driver has stopped for it.
    pub(super) fn asked_s(&self, stands_s: f64, next_s: f64, is_due: bool) -> f64 {
        let clock = self.progress.clock;
        let mut then = clock;
        then.pass(Activity::Rest, stands_s);
        let length_s = clock.length_s(clock.next_rest().0);
        let mut rested = clock;
        rested.pass(Activity::Rest, length_s);
        let reaches = |clock: DutyClock| clock.left_s() >= next_s + HALTING_S;
        if is_due || !reaches(then) && reaches(rested) { length_s } else { 0.0 }
    }

    /// The law makes a standstill longer, by some time in s.
    pub(super) fn is_made_longer(&mut self, by_s: f64) {
        self.progress.added_s += by_s;
        self.progress.taken += 1;
    }

    /// Driving time until the limit has to be looked at again, in s.
    /// `ahead_s`: so long before the limit a driver looks for a place.
    pub(super) fn until_check_s(&self, ahead_s: f64) -> f64 {
        let left_s = self.progress.clock.left_s();
        let until_s = if left_s > ahead_s { left_s - ahead_s } else { left_s - LAST_S };
        until_s.max(0.0)
    }

    /// Notes whether the truck has to rest before it goes on from where it is; false: it goes on.
    pub(super) fn has_to_rest(&mut self, scenario: &Scenario, here_m: impl Fn() -> f64) -> bool {
        let left_s = self.progress.clock.left_s();
        if left_s > HALTING_S {
            return false;
        }
        let here_m = here_m();
        let ahead = |place_m: f64| place_m > here_m && place_m < here_m + NEAR_M;
        let road = &scenario.cycle.road;
        let is_near = || {
            let mut stops = road.events.iter().filter(|event| is_mission_stop(event));
            ahead(road.length_m) || stops.any(|stop| ahead(stop.position_m))
        };
        let is_due = left_s <= LAST_S || !is_near();
        if is_due {
            // who has no time left to halt has to rest before
            let back_m = if left_s <= LAST_S { NEAR_M } else { 0.0 };
            let middle_m = 0.5 * (here_m + self.progress.rested_at_m);
            self.due_at_m = Some((here_m - back_m).max(middle_m));
        }
        is_due
    }

    /// Whether a rest has to be put in.
    pub(super) fn are_missing(&self) -> bool {
        self.due_at_m.is_some()
    }

    /// Whether the trip is given up.
    pub(super) fn are_too_many(&self) -> bool {
        self.attempts > MOST_ATTEMPTS
    }

    /// Puts the rest that is due into the trip: at the last stop of the mission or charger since the
    /// last rest, where there is none on the spot; returns where, in m.
    pub(super) fn put_in(&mut self, scenario: &mut Scenario) -> Option<f64> {
        let mut here_m = self.due_at_m.take()?;
        let (rest, length_s) = self.progress.clock.next_rest();
        let stop_m =
            self.progress.last_stop.map(|(event, _)| scenario.cycle.road.events[event].position_m);
        let since_m = stop_m.unwrap_or(self.progress.rested_at_m);
        let ahead = |at_m: f64| at_m > since_m && at_m <= here_m;
        let charger = scenario.chargers.iter().rev().find(|charger| ahead(charger.position_m));
        let charger_m = charger.map(|charger| charger.position_m);
        here_m = charger_m.or(stop_m).unwrap_or(here_m);
        let events = &mut scenario.cycle.road.events;
        if let (Some((event, before)), None) = (self.progress.last_stop, charger_m) {
            let stop = &mut events[event];
            let own_s = stop.kind.standstill_s().unwrap_or(0.0);
            let known = self.stops.iter().any(|known| known.position_m == stop.position_m);
            if !known {
                self.stops.push(RestStop { position_m: stop.position_m, own_s: Some(own_s) });
            }
            let standstill_s = own_s.max(before.length_s(rest));
            stop.kind = EventKind::MissionStop { standstill_s };
            return Some(stop.position_m);
        }
        // a rest on the spot that was not reached in time
        self.stops.retain(|stop| {
            let goes = stop.own_s.is_none() && stop.position_m > here_m;
            if goes {
                events.retain(|event| event.position_m != stop.position_m);
            }
            !goes
        });
        let mut position_m = here_m.max(ROOM_M);
        while charger_m.is_none()
            && let Some(event) =
                events.iter().rev().find(|event| (event.position_m - position_m).abs() < ROOM_M)
        {
            position_m = event.position_m - ROOM_M;
        }
        let kind = EventKind::MissionStop { standstill_s: length_s };
        let at = events.partition_point(|event| event.position_m < position_m);
        events.insert(at, PointEvent { position_m, kind, turns: false });
        self.stops.push(RestStop { position_m, own_s: None });
        Some(position_m)
    }
}

pub(super) fn is_mission_stop(event: &PointEvent) -> bool {
    matches!(event.kind, EventKind::MissionStop { .. })
}

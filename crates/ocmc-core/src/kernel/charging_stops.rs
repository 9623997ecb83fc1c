//! Charging on one trip: where its driver would use up his reserve, the trip gets a stop at the last
//! charger before that place, and is driven again from its start, until it arrives or no charger
//! helps.

use super::rest_stops::RestStops;
use crate::charging::{ChargeCourse, Charger, ChargingEvent, ChargingPlace, ChargingPolicy};
use crate::operating_cycle::road::point_event::{EventKind, PointEvent};
use crate::powertrain::{Charge, Plug};
use crate::record::Record;
use crate::study::{Scenario, Study};

/// Stops after which a trip is given up.
const MOST_ATTEMPTS: u32 = 1000;

/// What charging at one kind of place did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ChargedAt {
    /// The energy.
    pub charge: Charge,
    /// Stops.
    pub stops: u32,
}

/// A place at which the truck stands, and what it offers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Offer<'a> {
    /// The charger.
    pub plug: Plug<'a>,
    /// State of charge below which it is used.
    begin_below: f64,
    /// Whether it is a public one.
    is_public: bool,
    /// Whether the truck stays as long as charging takes.
    stays: bool,
    /// Time before and behind the charging, in s, and what of it is the wait.
    idle_s: f64,
    wait_s: f64,
    /// Efficiency from the meter to the terminals.
    efficiency: f64,
}

/// A truck that comes to a charger.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrival {
    /// Where, in m.
    pub position_m: f64,
    /// When, in s after the departure.
    pub at_s: f64,
    /// The departure by the clock, in s from a full hour.
    pub departure_s: f64,
    /// Its state of charge.
    pub charge: f64,
}

/// What a charger did.
#[derive(Clone, Copy, Debug)]
pub(super) struct Charged<'a> {
    /// Time and energy.
    pub charge: &'a Charge,
    /// How it went on.
    pub course: &'a ChargeCourse,
    /// By how much the state of charge rose.
    pub rise: f64,
}

impl Arrival {
    /// The charging that follows, after a wait and half of the time for the plug.
    fn charged(
        self,
        place: ChargingPlace,
        [wait_s, connection_s]: [f64; 2],
        efficiency: f64,
        Charged { charge, course, rise }: Charged,
    ) -> ChargingEvent {
        let begin_s = self.at_s + wait_s + 0.5 * connection_s;
        let at_terminals_j = course.by_quarter_hour_j(self.departure_s + begin_s);
        ChargingEvent {
            place,
            position_m: self.position_m,
            arrival_s: self.at_s,
            wait_s,
            begin_s,
            charging_s: charge.time_s,
            begin_charge: self.charge,
            end_charge: self.charge + rise,
            charged_energy_j: charge.gained_j,
            grid_energy_j: charge.supplied_j / efficiency,
            peak_power_w: course.peak_power_w() / efficiency,
            quarter_hours_j: at_terminals_j.iter().map(|energy_j| energy_j / efficiency).collect(),
        }
    }
}

/// The charging stops of one trip.
#[derive(Clone, Debug, Default)]
pub(super) struct ChargingStops {
    /// Chargers at which the trip charges to the end, in m.
    planned: Vec<f64>,
    /// The last of them that the truck has left, in m.
    left_m: f64,
    /// Where a stop has to be put in, in m.
    due_at_m: Option<f64>,
    attempts: u32,
    /// What was charged on the way so far.
    pub public: ChargedAt,
    /// What was charged at stops of the mission.
    pub stop: ChargedAt,
    /// Time that the truck waited for chargers, in s.
    pub wait_s: f64,
    /// Each charging on the way.
    events: Vec<ChargingEvent>,
}

impl ChargingStops {
    /// Those of a trip, where the study has a policy.
    pub(super) fn new(study: &Study) -> Option<Box<Self>> {
        study.model().charging.as_ref().map(|_| Box::default())
    }

    /// An attempt begins.
    pub(super) fn depart(&mut self) {
        let planned = std::mem::take(&mut self.planned);
        *self = Self { planned, attempts: self.attempts + 1, ..Self::default() };
    }

    /// What the place of an event offers a truck that would stand there for some time, in s.
    pub(super) fn offer<'a>(
        &self,
        policy: &'a ChargingPolicy,
        scenario: &Scenario,
        event: usize,
        standstill_s: f64,
    ) -> Option<Offer<'a>> {
        let PointEvent { position_m, kind, .. } = scenario.cycle.road.events[event];
        if !matches!(kind, EventKind::MissionStop { .. }) {
            return None;
        }
        let curve = policy.curve.as_ref();
        let efficiency = policy.efficiency;
        let at_terminals = |power_w: f64| power_w * efficiency;
        let charger = scenario.chargers.iter().find(|charger| charger.position_m == position_m);
        if let (Some(charger), Some(public)) = (charger, &policy.public) {
            let stays = self.planned.contains(&position_m);
            let idle_s = charger.wait_s + policy.connection_s;
            let longest_s = if stays { f64::INFINITY } else { standstill_s - idle_s };
            let power_w = at_terminals(charger.power_w);
            let plug = Plug { power_w, curve, end_at: public.end_at, longest_s };
            let (begin_below, wait_s) = (f64::INFINITY, charger.wait_s);
            let is_public = true;
            return Some(Offer { plug, begin_below, is_public, stays, idle_s, wait_s, efficiency });
        }
        let stop = policy.stop.as_ref().filter(|stop| standstill_s >= stop.shortest_s)?;
        let (idle_s, power_w) = (policy.connection_s, at_terminals(stop.power_w));
        let longest_s = standstill_s - idle_s;
        let plug = Plug { power_w, curve, end_at: stop.end_at, longest_s };
        let (begin_below, wait_s) = (stop.begin_below, 0.0);
        let (is_public, stays) = (false, false);
        Some(Offer { plug, begin_below, is_public, stays, idle_s, wait_s, efficiency })
    }

    /// Notes what was charged at a place; returns for how long the truck stands there, in s, where
    /// it would have stood for some time without it.
    pub(super) fn charged(
        &mut self,
        offer: &Offer,
        charged: Charged,
        arrival: Arrival,
        standstill_s: f64,
    ) -> f64 {
        let charge = charged.charge;
        if offer.stays {
            self.left_m = arrival.position_m;
        }
        if charge.gained_j <= 0.0 {
            return standstill_s;
        }
        let sums = if offer.is_public { &mut self.public } else { &mut self.stop };
        sums.charge.add(charge);
        sums.stops += 1;
        self.wait_s += offer.wait_s;
        let place = if offer.is_public { ChargingPlace::Public } else { ChargingPlace::Stop };
        let waits_s = [offer.wait_s, offer.idle_s - offer.wait_s];
        self.events.push(arrival.charged(place, waits_s, offer.efficiency, charged));
        if offer.stays { standstill_s.max(offer.idle_s + charge.time_s) } else { standstill_s }
    }

    /// Whether a charger before a place where the reserve is used up would have helped: then a stop
    /// there is due.
    pub(super) fn finds_charger(&mut self, scenario: &Scenario, here_m: f64) -> bool {
        let helps = |charger: &&Charger| {
            let at_m = charger.position_m;
            at_m <= here_m && at_m > self.left_m && !self.planned.contains(&at_m)
        };
        let last = scenario.chargers.iter().rev().find(helps);
        self.due_at_m = last.map(|charger| charger.position_m).filter(|_| !self.are_too_many());
        self.due_at_m.is_some()
    }

    /// Fills in the columns of charging, a depot's after the trip among them: a truck that did not
    /// arrive is towed there. Without a battery there are none.
    pub(super) fn fill(
        &self,
        policy: &ChargingPolicy,
        scenario: &Scenario,
        charged_by: impl Fn(&Plug, f64, &mut ChargeCourse) -> Option<(Charge, f64)>,
        record: &mut Record,
    ) {
        let Some(charge) = record.final_charge else { return };
        let at_meter_j = |charge: &Charge| charge.supplied_j / policy.efficiency;
        let (public, stop) = (&self.public.charge, &self.stop.charge);
        record.charged_energy_public_j = Some(public.gained_j);
        record.charged_energy_stop_j = Some(stop.gained_j);
        record.grid_energy_public_j = Some(at_meter_j(public));
        record.grid_energy_stop_j = Some(at_meter_j(stop));
        record.n_charging_stops = Some(self.public.stops + self.stop.stops);
        record.charging_s = Some(public.time_s + stop.time_s);
        record.charging_wait_s = Some(self.wait_s);
        let events = record.charging_events.insert(self.events.clone());
        let Some(depot) = &policy.depot else { return };
        let (mut full_charge, mut parked_s) = (scenario.vehicle.initial_charge, depot.parked_s);
        if let Some(handover) = &scenario.handover {
            full_charge = handover.full_charge;
            if let Some(next_s) = handover.next_departure_s {
                parked_s = next_s - record.duration_s;
            }
        }
        let plug = Plug {
            power_w: depot.power_w * policy.efficiency,
            curve: policy.curve.as_ref(),
            end_at: full_charge.unwrap_or(0.0),
            longest_s: parked_s - policy.connection_s,
        };
        let is_charged = record.outcome.counts() && plug.longest_s > 0.0;
        let mut course = ChargeCourse::default();
        let done = if is_charged { charged_by(&plug, charge, &mut course) } else { None };
        let (done, rise) = done.unwrap_or_default();
        if done.gained_j > 0.0 {
            let arrival = Arrival {
                position_m: record.distance_m,
                at_s: record.duration_s,
                departure_s: record.departure_s_of_year,
                charge,
            };
            let waits_s = [0.0, policy.connection_s];
            let charged = Charged { charge: &done, course: &course, rise };
            events.push(arrival.charged(ChargingPlace::Depot, waits_s, policy.efficiency, charged));
        }
        record.charged_energy_depot_j = Some(done.gained_j);
        record.grid_energy_depot_j = Some(at_meter_j(&done));
        record.depot_charging_s = Some(done.time_s);
        let sums = [&mut record.charged_energy_j, &mut record.charging_loss_j];
        for (sum, added_j) in sums.into_iter().zip([done.gained_j, done.loss_j]) {
            *sum = sum.map(|sum_j| sum_j + added_j);
        }
    }

    /// Whether a stop has to be put in.
    pub(super) fn are_missing(&self) -> bool {
        self.due_at_m.is_some()
    }

    /// Whether the trip is given up.
    fn are_too_many(&self) -> bool {
        self.attempts > MOST_ATTEMPTS
    }

    /// Puts the stop that is due into the trip. What was planned behind it is planned anew.
    pub(super) fn put_in(&mut self, scenario: &mut Scenario, rests: Option<&mut RestStops>) {
        let Some(position_m) = self.due_at_m.take() else { return };
        if let Some(rests) = rests {
            rests.forget_behind(position_m, scenario);
        }
        self.forget_behind(position_m, scenario);
        self.planned.push(position_m);
        let events = &mut scenario.cycle.road.events;
        let at = events.partition_point(|event| event.position_m < position_m);
        if events.get(at).is_none_or(|event| event.position_m != position_m) {
            let kind = EventKind::MissionStop { standstill_s: 0.0 };
            events.insert(at, PointEvent { position_m, kind, turns: false });
        }
    }

    /// Takes the stops at chargers behind a place off the trip.
    pub(super) fn forget_behind(&mut self, place_m: f64, scenario: &mut Scenario) {
        self.planned.retain(|at_m| *at_m <= place_m);
        let Scenario { cycle, chargers, .. } = scenario;
        let is_at_charger = |at_m: f64| chargers.iter().any(|charger| charger.position_m == at_m);
        cycle
            .road
            .events
            .retain(|event| event.position_m <= place_m || !is_at_charger(event.position_m));
    }
}

impl Offer<'_> {
    /// Whether a truck with this state of charge uses it.
    pub(super) fn is_used(&self, charge: f64) -> bool {
        charge < self.begin_below && self.plug.longest_s > 0.0
    }
}

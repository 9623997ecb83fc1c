//! Charging on one trip: where its driver would use up his reserve, the trip gets a stop at the last
//! charger before that place, and is driven again from its start, until it arrives or no charger
//! helps.

use super::rest_stops::RestStops;
use crate::charging::{Charger, ChargingPolicy, EnoughModel, Goal};
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
    /// Whether it ends before the battery is charged as far as may be.
    charges_enough: bool,
    /// Time before and behind the charging, in s, and what of it is the wait.
    idle_s: f64,
    wait_s: f64,
}

/// What a trip has charged so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ChargingProgress {
    /// The last planned charger that the truck has left, in m.
    left_m: f64,
    /// What was charged on the way so far.
    public: ChargedAt,
    /// What was charged at stops of the mission.
    stop: ChargedAt,
    /// Time that the truck waited for chargers, in s.
    wait_s: f64,
    /// Whether it charged there no more than enough.
    charged_enough: bool,
}

/// What a trip has taken so far, and what its truck may use.
#[derive(Clone, Copy, Debug)]
pub(super) struct Need {
    /// State of charge that each metre has taken.
    pub per_m: f64,
    /// State of charge at which the truck stops.
    pub lowest_charge: f64,
}

impl Need {
    /// That of a truck without a battery.
    pub(super) const NONE: Self = Self { per_m: 0.0, lowest_charge: 0.0 };
}

/// The charging stops of one trip.
#[derive(Clone, Debug, Default)]
pub(super) struct ChargingStops {
    /// Chargers at which the trip charges to the end, in m.
    planned: Vec<f64>,
    /// Those of them at which enough was not enough, in m.
    filled: Vec<f64>,
    /// Where a stop has to be put in, in m.
    due_at_m: Option<f64>,
    attempts: u32,
    /// What has been done so far.
    pub progress: ChargingProgress,
}

impl ChargingStops {
    /// Those of a trip, where the study has a policy.
    pub(super) fn new(study: &Study) -> Option<Box<Self>> {
        study.model().charging.as_ref().map(|_| Box::default())
    }

    /// An attempt begins.
    pub(super) fn depart(&mut self) {
        self.due_at_m = None;
        self.attempts += 1;
        self.progress = ChargingProgress::default();
    }

    /// What the place of an event offers a truck that would stand there for some time, in s.
    pub(super) fn offer<'a>(
        &self,
        policy: &'a ChargingPolicy,
        scenario: &Scenario,
        event: usize,
        standstill_s: f64,
        need: Need,
    ) -> Option<Offer<'a>> {
        let PointEvent { position_m, kind, .. } = scenario.cycle.road.events[event];
        if !matches!(kind, EventKind::MissionStop { .. }) {
            return None;
        }
        let curve = policy.curve.as_ref();
        let at_terminals = |power_w: f64| power_w * policy.efficiency;
        let charger = scenario.chargers.iter().find(|charger| charger.position_m == position_m);
        if let (Some(charger), Some(public)) = (charger, &policy.public) {
            let stays = self.planned.contains(&position_m);
            let idle_s = charger.wait_s + policy.connection_s;
            let longest_s = if stays { f64::INFINITY } else { standstill_s - idle_s };
            let power_w = at_terminals(charger.power_w);
            let enough = public.enough.as_ref().filter(|_| stays && !self.fills(position_m));
            let enough = enough.map_or(f64::INFINITY, |enough| {
                need.lowest_charge + need.per_m * enough.way_m(scenario, position_m)
            });
            let end_at = public.end_at.min(enough);
            let charges_enough = end_at < public.end_at;
            let plug = Plug { power_w, curve, end_at, longest_s };
            let (begin_below, wait_s) = (f64::INFINITY, charger.wait_s);
            let is_public = true;
            let offer =
                Offer { plug, begin_below, is_public, stays, charges_enough, idle_s, wait_s };
            return Some(offer);
        }
        let stop = policy.stop.as_ref().filter(|stop| standstill_s >= stop.shortest_s)?;
        let (idle_s, power_w) = (policy.connection_s, at_terminals(stop.power_w));
        let longest_s = standstill_s - idle_s;
        let plug = Plug { power_w, curve, end_at: stop.end_at, longest_s };
        let begin_below = stop.begin_below;
        let (is_public, stays, charges_enough, wait_s) = (false, false, false, 0.0);
        Some(Offer { plug, begin_below, is_public, stays, charges_enough, idle_s, wait_s })
    }

    /// Whether the trip charges up to the end at a charger.
    fn fills(&self, position_m: f64) -> bool {
        self.filled.contains(&position_m)
    }

    /// Whether the trip charges to the end between two places.
    pub(super) fn are_within(&self, from_m: f64, to_m: f64) -> bool {
        self.planned.iter().any(|at_m| *at_m > from_m && *at_m <= to_m)
    }

    /// Notes what was charged at a place; returns for how long the truck stands there, in s, where
    /// it would have stood for some time without it.
    pub(super) fn charged(
        &mut self,
        offer: &Offer,
        charge: &Charge,
        position_m: f64,
        standstill_s: f64,
    ) -> f64 {
        if offer.stays {
            self.progress.left_m = position_m;
            self.progress.charged_enough = offer.charges_enough;
        }
        if charge.gained_j <= 0.0 {
            return standstill_s;
        }
        let sums =
            if offer.is_public { &mut self.progress.public } else { &mut self.progress.stop };
        sums.charge.add(charge);
        sums.stops += 1;
        self.progress.wait_s += offer.wait_s;
        if offer.stays { standstill_s.max(offer.idle_s + charge.time_s) } else { standstill_s }
    }

    /// Whether a charger before a place where the reserve is used up would have helped: then a stop
    /// there is due.
    pub(super) fn finds_charger(&mut self, scenario: &Scenario, here_m: f64) -> bool {
        let helps = |charger: &&Charger| {
            let at_m = charger.position_m;
            at_m <= here_m && at_m > self.progress.left_m && !self.planned.contains(&at_m)
        };
        let last = scenario.chargers.iter().rev().find(helps).map(|charger| charger.position_m);
        // what the forecast called enough was not
        let left_m = self.progress.charged_enough.then_some(self.progress.left_m);
        let fills = last.is_none() && left_m.is_some() && !self.are_too_many();
        if fills {
            self.filled.extend(left_m);
        }
        self.due_at_m = last.or(left_m).filter(|_| !self.are_too_many());
        self.due_at_m.is_some()
    }

    /// Fills in the columns of charging, a depot's after the trip among them: a truck that did not
    /// arrive is towed there. Without a battery there are none.
    pub(super) fn fill(
        &self,
        policy: &ChargingPolicy,
        departure_charge: f64,
        charged_by: impl Fn(&Plug, f64) -> Option<Charge>,
        record: &mut Record,
    ) {
        let Some(charge) = record.final_charge else { return };
        let at_meter_j = |charge: &Charge| charge.supplied_j / policy.efficiency;
        let (public, stop) = (&self.progress.public.charge, &self.progress.stop.charge);
        record.charged_energy_public_j = Some(public.gained_j);
        record.charged_energy_stop_j = Some(stop.gained_j);
        record.grid_energy_public_j = Some(at_meter_j(public));
        record.grid_energy_stop_j = Some(at_meter_j(stop));
        record.n_charging_stops = Some(self.progress.public.stops + self.progress.stop.stops);
        record.charging_s = Some(public.time_s + stop.time_s);
        record.charging_wait_s = Some(self.progress.wait_s);
        let Some(depot) = &policy.depot else { return };
        let plug = Plug {
            power_w: depot.power_w * policy.efficiency,
            curve: policy.curve.as_ref(),
            end_at: departure_charge,
            longest_s: depot.parked_s - policy.connection_s,
        };
        let is_charged = record.outcome.counts() && plug.longest_s > 0.0;
        let done = if is_charged { charged_by(&plug, charge) } else { None }.unwrap_or_default();
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

    /// Puts the stop that is due into the trip, and returns where, in m. What was planned behind it is
    /// planned anew.
    pub(super) fn put_in(
        &mut self,
        scenario: &mut Scenario,
        rests: Option<&mut RestStops>,
    ) -> Option<f64> {
        let position_m = self.due_at_m.take()?;
        if let Some(rests) = rests {
            rests.forget_behind(position_m, scenario);
        }
        self.forget_behind(position_m, scenario);
        if !self.planned.contains(&position_m) {
            self.planned.push(position_m);
        }
        let events = &mut scenario.cycle.road.events;
        let at = events.partition_point(|event| event.position_m < position_m);
        if events.get(at).is_none_or(|event| event.position_m != position_m) {
            let kind = EventKind::MissionStop { standstill_s: 0.0 };
            events.insert(at, PointEvent { position_m, kind, turns: false });
        }
        Some(position_m)
    }

    /// Takes the stops at chargers behind a place off the trip.
    pub(super) fn forget_behind(&mut self, place_m: f64, scenario: &mut Scenario) {
        self.planned.retain(|at_m| *at_m <= place_m);
        self.filled.retain(|at_m| *at_m <= place_m);
        let Scenario { cycle, chargers, .. } = scenario;
        let is_at_charger = |at_m: f64| chargers.iter().any(|charger| charger.position_m == at_m);
        cycle
            .road
            .events
            .retain(|event| event.position_m <= place_m || !is_at_charger(event.position_m));
    }
}

impl EnoughModel {
    /// How far a truck that leaves a charger has to come by its forecast, margin included, in m.
    fn way_m(&self, scenario: &Scenario, from_m: f64) -> f64 {
        let end_m = scenario.cycle.road.length_m;
        let mut ahead = scenario.chargers.iter().map(|charger| charger.position_m);
        let to_m = match self.reach {
            Goal::Destination => end_m,
            Goal::NextCharger => ahead.find(|at_m| *at_m > from_m).unwrap_or(end_m),
        };
        (to_m - from_m) * (1.0 + self.margin)
    }
}

impl Offer<'_> {
    /// Whether a truck with this state of charge uses it.
    pub(super) fn is_used(&self, charge: f64) -> bool {
        charge < self.begin_below && self.plug.longest_s > 0.0
    }
}

//! Charging on one trip: what a place offers a truck that stands there, and what was charged. Where
//! it stops its driver decides on his way ([`super::charging_decision`]).

use super::charging_site::Site;
use super::stop_ahead::Standing;
use crate::charging::{ChargeCourse, ChargingEvent, ChargingPlace, ChargingPolicy};
use crate::powertrain::{Charge, Plug};
use crate::record::Record;
use crate::study::{Scenario, Study};

/// The longest for which a truck stays to be charged, in s: a daily rest (judgement). A charger
/// that gives next to nothing does not hold it for ever.
const LONGEST_STAY_S: f64 = 39_600.0;

/// Totals of charging at one kind of place.
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
    pub time_s: f64,
    /// The departure by the clock, in s from a full hour.
    pub departure_s: f64,
    /// Its state of charge.
    pub charge: f64,
}

/// Result of a charger.
#[derive(Clone, Debug)]
pub(super) struct Charged {
    /// Time and energy.
    pub charge: Charge,
    /// How it went on, what the auxiliaries got among it.
    pub course: ChargeCourse,
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
        Charged { charge, course, rise }: &Charged,
    ) -> ChargingEvent {
        let begin_s = self.time_s + wait_s + 0.5 * connection_s;
        let clock_s = self.departure_s + begin_s;
        ChargingEvent {
            place,
            position_m: self.position_m,
            arrival_s: self.time_s,
            wait_s,
            begin_s,
            charging_s: charge.time_s,
            begin_charge: self.charge,
            end_charge: self.charge + rise,
            charged_energy_j: charge.gained_j,
            grid_energy_j: (charge.supplied_j + charge.carried_j) / efficiency,
            peak_power_w: course.peak_power_w() / efficiency,
            quarter_hours_j: at_meter_j(course, clock_s, efficiency),
        }
    }
}

/// Energy that the meter counts in each quarter of an hour, in J, of a course that begins at a time
/// of the clock, in s.
fn at_meter_j(course: &ChargeCourse, clock_s: f64, efficiency: f64) -> Vec<f64> {
    let at_plug_j = course.by_quarter_hour_j(clock_s);
    at_plug_j.iter().map(|energy_j| energy_j / efficiency).collect()
}

/// A truck that is plugged in.
#[derive(Clone, Debug)]
struct Plugged {
    /// Course of the charge so far.
    course: ChargeCourse,
    /// Begin of the charging by the clock, in s.
    clock_s: f64,
    efficiency: f64,
    is_public: bool,
    /// How long it takes to unplug it, in s.
    unplugging_s: f64,
}

/// Charging of a trip so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ChargingProgress {
    /// The next site at which is decided.
    pub next_site: usize,
    /// Charging on the way so far.
    public: ChargedAt,
    /// Charging at stops of the mission.
    stop: ChargedAt,
    /// Time that the truck waited for chargers, in s.
    wait_s: f64,
}

impl ChargingProgress {
    /// Stops at which something was charged.
    fn stops(&self) -> usize {
        (self.public.stops + self.stop.stops) as usize
    }
}

/// The charging stops of one trip.
#[derive(Clone, Debug, Default)]
pub(super) struct ChargingStops {
    /// Chargers of the way, with what a driver looks at to decide, in order.
    pub sites: Vec<Site>,
    /// Chargers at which the trip charges to the end, in m.
    pub planned: Vec<f64>,
    /// Progress so far.
    pub progress: ChargingProgress,
    /// Each charging on the way.
    events: Vec<ChargingEvent>,
    plugged: Option<Plugged>,
}

impl ChargingStops {
    /// Charging stops of a trip, where the study has a policy and its trucks have a battery.
    pub(super) fn new(study: &Study) -> Option<Box<Self>> {
        let plugs_in = study.vehicle().powertrain.plugs_in();
        study.model().charging.as_ref().filter(|_| plugs_in).map(|_| Box::default())
    }

    /// The trip begins.
    pub(super) fn depart(&mut self) {
        self.planned.clear();
        self.events.clear();
        self.plugged = None;
        self.progress = ChargingProgress::default();
    }

    /// Offer of a place to a truck that would stand there for some time, in s. `enough`: the state
    /// of charge that it needs, where it is to be charged no more.
    pub(super) fn offer<'a>(
        &self,
        policy: &'a ChargingPolicy,
        scenario: &Scenario,
        at: &Standing,
        standstill_s: f64,
        enough: f64,
    ) -> Option<Offer<'a>> {
        let Standing { position_m, of_mission, is_rest, .. } = *at;
        if !is_rest {
            return None;
        }
        let curve = policy.curve.as_ref();
        let efficiency = policy.efficiency;
        let at_terminals = |power_w: f64| power_w * efficiency;
        let charger = scenario.chargers.iter().find(|charger| charger.position_m == position_m);
        if let (Some(charger), Some(public)) = (charger, &policy.public) {
            let stays = self.planned.contains(&position_m);
            let idle_s = charger.wait_s + policy.connection_s;
            let longest_s = if stays { LONGEST_STAY_S } else { standstill_s - idle_s };
            let power_w = at_terminals(charger.power_w);
            let end_at = if stays { public.end_at.min(enough) } else { public.end_at };
            let plug = Plug { power_w, curve, end_at, longest_s };
            let (begin_below, wait_s) = (f64::INFINITY, charger.wait_s);
            let is_public = true;
            let offer = Offer { plug, begin_below, is_public, stays, idle_s, wait_s, efficiency };
            return Some(offer);
        }
        let stop = policy.stop.as_ref().filter(|stop| standstill_s >= stop.shortest_s);
        let stop = stop.filter(|_| of_mission)?;
        let (idle_s, power_w) = (policy.connection_s, at_terminals(stop.power_w));
        let longest_s = standstill_s - idle_s;
        let plug = Plug { power_w, curve, end_at: stop.end_at, longest_s };
        let begin_below = stop.begin_below;
        let (is_public, stays, wait_s) = (false, false, 0.0);
        Some(Offer { plug, begin_below, is_public, stays, idle_s, wait_s, efficiency })
    }

    /// Whether the trip charges to the end between two places.
    pub(super) fn are_within(&self, from_m: f64, to_m: f64) -> bool {
        self.planned.iter().any(|at_m| *at_m > from_m && *at_m <= to_m)
    }

    /// Notes what was charged at a place; returns for how long the truck stands there at least, in
    /// s.
    pub(super) fn charged(&mut self, offer: &Offer, charged: Charged, arrival: Arrival) -> f64 {
        let Offer { is_public, wait_s, idle_s, efficiency, .. } = *offer;
        let charge = &charged.charge;
        if charge.gained_j <= 0.0 {
            return 0.0;
        }
        let stands_s = if offer.stays { idle_s + charge.time_s } else { 0.0 };
        let sums = self.sums(is_public);
        sums.charge.add(charge);
        sums.stops += 1;
        self.progress.wait_s += wait_s;
        let place = if is_public { ChargingPlace::Public } else { ChargingPlace::Stop };
        let event = arrival.charged(place, [wait_s, idle_s - wait_s], efficiency, &charged);
        let clock_s = arrival.departure_s + event.begin_s;
        let (course, unplugging_s) = (charged.course, idle_s - offer.before_s());
        self.plugged = Some(Plugged { course, clock_s, efficiency, is_public, unplugging_s });
        self.events.push(event);
        stands_s
    }

    fn sums(&mut self, is_public: bool) -> &mut ChargedAt {
        if is_public { &mut self.progress.public } else { &mut self.progress.stop }
    }

    /// How long it takes to unplug the truck, in s, where it is plugged in.
    pub(super) fn unplugging_s(&self) -> Option<f64> {
        self.plugged.as_ref().map(|plugged| plugged.unplugging_s)
    }

    /// The truck is unplugged after it was plugged in for some time more, in s, in which the
    /// charger gave its auxiliaries an energy, in J.
    pub(super) fn unplug(&mut self, time_s: f64, carried_j: f64) {
        let Some(Plugged { mut course, clock_s, efficiency, is_public, .. }) = self.plugged.take()
        else {
            return;
        };
        if carried_j > 0.0 {
            course.go_on(time_s, carried_j);
            self.sums(is_public).charge.carried_j += carried_j;
            let event = self.events.last_mut().expect("the truck has been charged");
            event.grid_energy_j += carried_j / efficiency;
            event.quarter_hours_j = at_meter_j(&course, clock_s, efficiency);
        }
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
        let grid_j = |charge: &Charge| (charge.supplied_j + charge.carried_j) / policy.efficiency;
        let (public, stop) = (&self.progress.public.charge, &self.progress.stop.charge);
        record.charged_energy_public_j = Some(public.gained_j);
        record.charged_energy_stop_j = Some(stop.gained_j);
        record.grid_energy_public_j = Some(grid_j(public));
        record.grid_energy_stop_j = Some(grid_j(stop));
        record.charger_auxiliary_energy_j = Some(public.carried_j + stop.carried_j);
        record.n_charging_stops = Some(self.progress.stops() as u32);
        record.charging_s = Some(public.time_s + stop.time_s);
        record.charging_wait_s = Some(self.progress.wait_s);
        let arrivals = self.events.iter().map(|event| event.begin_charge);
        record.lowest_charge = Some(arrivals.fold(charge, f64::min));
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
                time_s: record.duration_s,
                departure_s: record.departure_s_of_year,
                charge,
            };
            let waits_s = [0.0, policy.connection_s];
            let charged = Charged { charge: done, course, rise };
            let place = ChargingPlace::Depot;
            events.push(arrival.charged(place, waits_s, policy.efficiency, &charged));
        }
        record.charged_energy_depot_j = Some(done.gained_j);
        record.grid_energy_depot_j = Some(grid_j(&done));
        record.depot_charging_s = Some(done.time_s);
        let sums = [&mut record.charged_energy_j, &mut record.charging_loss_j];
        for (sum, added_j) in sums.into_iter().zip([done.gained_j, done.loss_j]) {
            *sum = sum.map(|sum_j| sum_j + added_j);
        }
    }
}

impl Offer<'_> {
    /// Whether a truck with this state of charge uses it.
    pub(super) fn is_used(&self, charge: f64) -> bool {
        charge < self.begin_below && self.plug.longest_s > 0.0
    }

    /// Time before the charging, in s: the wait, and half of the time for the plug.
    pub(super) fn before_s(&self) -> f64 {
        0.5 * (self.idle_s + self.wait_s)
    }
}

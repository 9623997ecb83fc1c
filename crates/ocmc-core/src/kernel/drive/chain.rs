//! Trips of a truck that chain: it departs with what its depot has charged by then, its drivers go
//! on with their clocks, and who comes back late departs late.
//!
//! The trips of one truck are driven one after the other, those of the trucks of a range side by
//! side: the next trip of the truck that has made the fewest goes to the lane that is free. So a
//! record is a function of study, seed and cycle id, and of nothing else.
//!
//! A truck is in its depot from its arrival to the next departure: charged, and its drivers rest. A
//! trip that was not driven to its end ends there, too: the truck is towed. Who may drive on for
//! less than five minutes rests first, and departs later by that rest. Weather and traffic do not
//! wait.

use super::cpu::CpuLevel;
use super::scheduler::{Deliver, Driving, drive_tasks};
use crate::charging::ChargingPlace;
use crate::kernel::trip::lane_task::LaneTask;
use crate::kernel::trip::rest_stops::SHORTEST_START_S;
use crate::random::PickFreeze;
use crate::record::Record;
use crate::rest::{Activity, DutyClock};
use crate::study::handover::Handover;
use crate::study::{Scenario, Study};
use crate::tactical::SpeedProfile;
use crate::threads::deep;
use std::cell::RefCell;
use std::ops::Range;
use std::sync::atomic::Ordering;

/// Seconds of a day.
const DAY_S: f64 = 86_400.0;

/// Where draws come from.
#[derive(Clone, Copy, Debug)]
pub struct Draw {
    /// Master seed.
    pub seed: u64,
    /// Streams that are taken from the second sample.
    pub pick_freeze: PickFreeze,
}

/// A truck that makes its trips.
#[derive(Debug)]
struct Truck {
    /// Id of its first cycle.
    first_cycle: u64,
    /// Trips that it makes here, and those that it has made.
    trips: u64,
    made: u64,
    /// Whether it is on the road.
    is_away: bool,
    /// The trip ahead, as it was drawn.
    ahead: Option<Scenario>,
    /// State of charge in the depot; none before the first trip.
    charge: Option<f64>,
    /// When it is back in the depot, in s of its calendar.
    back_s: f64,
    /// Drivers who have driven it, with their clocks at their arrival, and when that was.
    drivers: Vec<(u64, DutyClock, f64)>,
}

/// Drives the cycles of a range, each after the trips of its truck that were before it; the records
/// come in any order. Once the flag is set there are no more.
pub fn drive_chained(driving: Driving, draw: Draw, cycles: &Range<u64>, deliver: Deliver) {
    let Driving { study, stop, .. } = driving;
    let trips = study.nesting().trips_per_truck;
    let ids = cycles.start / trips..cycles.end.div_ceil(trips);
    let trucks = ids.map(|id| Truck::new(id * trips, trips.min(cycles.end - id * trips)));
    let trucks = RefCell::new(trucks.collect::<Vec<_>>());
    let mut profile = SpeedProfile::default();
    let mut next = |used| {
        let mut trucks = trucks.borrow_mut();
        let ready = trucks.iter_mut().filter(|truck| !truck.is_away && truck.made < truck.trips);
        let truck =
            ready.min_by_key(|truck| truck.made).filter(|_| !stop.load(Ordering::Relaxed))?;
        Some(LaneTask::of(study, truck.depart(study, draw), used, &mut profile))
    };
    let mut arrived = |record: &Record| {
        let mut trucks = trucks.borrow_mut();
        let mut away = trucks.iter_mut().filter(|truck| truck.is_away);
        let truck = away.find(|truck| truck.first_cycle + truck.made == record.cycle_id);
        truck.expect("it has departed").arrive(record);
    };
    let mut deliver = |mut record: Record| {
        if cycles.contains(&record.cycle_id) {
            record.clock_at_end = None;
            deliver(record);
        }
    };
    driving.each_arriving(&mut next, &mut arrived, &mut deliver);
}

/// The scenario of one cycle, with what its truck brings from the trips before.
pub fn chained_scenario(study: &Study, seed: u64, cycle_id: u64) -> Scenario {
    let draw = Draw { seed, pick_freeze: PickFreeze::NONE };
    let before = cycle_id % study.nesting().trips_per_truck;
    let mut truck = Truck::new(cycle_id - before, before + 1);
    for _ in 0..before {
        let mut task = Some(LaneTask::new(study, truck.depart(study, draw)));
        let records = deep(|| drive_tasks(study, &mut |_| task.take(), CpuLevel::best()));
        truck.arrive(&records[0]);
    }
    truck.depart(study, draw)
}

impl Truck {
    fn new(first_cycle: u64, trips: u64) -> Self {
        let (ahead, charge, drivers) = (None, None, Vec::new());
        Self { first_cycle, trips, made: 0, is_away: false, ahead, charge, back_s: 0.0, drivers }
    }

    /// The next trip as it departs: late, with what the battery has, and with the driver's clock.
    fn depart(&mut self, study: &Study, draw: Draw) -> Scenario {
        let (Draw { seed, pick_freeze }, trip) = (draw, self.made);
        let sample = |trip| study.sample_pick_freeze(seed, self.first_cycle + trip, pick_freeze);
        let mut scenario = self.ahead.take().unwrap_or_else(|| sample(trip));
        let is_last = trip + 1 == study.nesting().trips_per_truck;
        let ahead = (!is_last).then(|| sample(trip + 1));
        let planned_s = planned_departure_s(study, &scenario, trip);
        let mut departs_s = planned_s.max(self.back_s);
        let driver_id = scenario.trip.driver_id;
        let known = self.drivers.iter().find(|(id, ..)| *id == driver_id);
        let clock = known.map(|(_, clock, since_s)| {
            let mut clock = *clock;
            clock.pass(Activity::Rest, departs_s - since_s);
            if clock.left_s() < SHORTEST_START_S {
                let (_, rest_s) = clock.next_rest();
                clock.pass(Activity::Rest, rest_s);
                departs_s += rest_s;
            }
            clock
        });
        let next_departure_s = ahead
            .as_ref()
            .map(|ahead| (planned_departure_s(study, ahead, trip + 1) - departs_s).max(0.0));
        let full_charge = scenario.vehicle.initial_charge;
        scenario.cycle.mission.departure_s += departs_s - planned_s;
        scenario.vehicle.initial_charge = self.charge.or(full_charge);
        scenario.handover = Some(Handover { full_charge, clock, next_departure_s });
        self.ahead = ahead;
        self.back_s = departs_s;
        self.is_away = true;
        scenario
    }

    /// The truck is back: `back_s` was its departure.
    fn arrive(&mut self, record: &Record) {
        self.is_away = false;
        self.made += 1;
        self.back_s += record.duration_s;
        let last = record.charging_events.iter().flatten().last();
        let in_depot = last.filter(|event| event.place == ChargingPlace::Depot);
        self.charge = in_depot.map(|event| event.end_charge).or(record.final_charge);
        let driver_id = record.driver_id.unwrap_or(0);
        self.drivers.retain(|(id, ..)| *id != driver_id);
        if let Some(clock) = record.clock_at_end {
            self.drivers.push((driver_id, clock, self.back_s));
        }
    }
}

/// When a trip departs by its plan, in s from the first day of the calendar.
fn planned_departure_s(study: &Study, scenario: &Scenario, trip: u64) -> f64 {
    let day = study.nesting().days.map_or(0, |days| days.day_of(trip));
    DAY_S * day as f64 + scenario.cycle.mission.departure_s
}

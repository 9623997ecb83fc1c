//! Trips of a truck that chain: it departs with what its depot has charged by then, its drivers go on
//! with their clocks, and who comes back late departs late.
//!
//! The trips of one truck are driven one after the other, those of the trucks of a range side by side:
//! first the first trip of each, then the second. So a record is a function of study, seed and cycle
//! id, and of nothing else.
//!
//! A truck is in its depot from its arrival to the next departure: charged, and its drivers rest. A trip
//! that was not driven to its end ends there, too: the truck is towed. Who may drive on for less than
//! five minutes rests first, and departs later by that rest. Weather and traffic do not wait.

use super::cpu::CpuLevel;
use super::lane_task::LaneTask;
use super::rest_stops::SHORTEST_START_S;
use super::scheduler::drive_until;
use crate::charging::ChargingPlace;
use crate::random::PickFreeze;
use crate::record::Record;
use crate::rest::{Activity, DutyClock};
use crate::study::handover::Handover;
use crate::study::{Scenario, Study};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

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

/// A truck between two trips.
#[derive(Debug)]
struct Truck {
    /// Id of its first cycle.
    first_cycle: u64,
    /// The trip ahead, as it was drawn.
    ahead: Option<Scenario>,
    /// State of charge in the depot; none before the first trip.
    charge: Option<f64>,
    /// When it is back in the depot, in s of its calendar.
    back_s: f64,
    /// Drivers who have driven it, with their clocks at their arrival, and when that was.
    drivers: Vec<(u64, DutyClock, f64)>,
}

/// Drives the cycles of a range, each after the trips of its truck that were before it; the records are
/// in the order of their ids. Once the flag is set there are none.
pub fn drive_chained(
    study: &Study,
    draw: Draw,
    cycles: Range<u64>,
    level: CpuLevel,
    stop: &AtomicBool,
) -> Vec<Record> {
    let mut records = Vec::new();
    each_trip(study, draw, &cycles, |scenarios| {
        let mut scenarios = scenarios.into_iter();
        let mut next = |_| {
            let scenario = scenarios.next().filter(|_| !stop.load(Ordering::Relaxed))?;
            Some(LaneTask::new(study, scenario))
        };
        let driven = drive_until(study, &mut next, level, stop);
        let is_whole = !stop.load(Ordering::Relaxed);
        if is_whole {
            records.extend(driven.iter().filter(|r| cycles.contains(&r.cycle_id)).cloned());
        }
        is_whole.then_some(driven)
    });
    if stop.load(Ordering::Relaxed) {
        return Vec::new();
    }
    records.sort_by_key(|record| record.cycle_id);
    for record in &mut records {
        record.clock_at_end = None;
    }
    records
}

/// The scenario of one cycle, with what its truck brings from the trips before.
pub fn chained_scenario(study: &Study, seed: u64, cycle_id: u64) -> Scenario {
    let draw = Draw { seed, pick_freeze: PickFreeze::NONE };
    let mut found = None;
    each_trip(study, draw, &(cycle_id..cycle_id + 1), |scenarios| {
        let wanted = scenarios.iter().find(|scenario| scenario.cycle_id == cycle_id);
        if let Some(wanted) = wanted {
            found = Some(wanted.clone());
            return None;
        }
        let mut scenarios = scenarios.into_iter();
        let mut next = |_| scenarios.next().map(|scenario| LaneTask::new(study, scenario));
        Some(drive_until(study, &mut next, CpuLevel::best(), &AtomicBool::new(false)))
    });
    found.expect("its truck makes the trip")
}

/// Goes through the trips of the trucks of a range, one of each truck at a time, as far as the range
/// goes. `drive` gives their records, in the order of the scenarios, or breaks by none.
fn each_trip(
    study: &Study,
    draw: Draw,
    cycles: &Range<u64>,
    mut drive: impl FnMut(Vec<Scenario>) -> Option<Vec<Record>>,
) {
    let trips = study.nesting().trips_per_truck;
    let trucks = cycles.start / trips..cycles.end.div_ceil(trips);
    let mut trucks: Vec<Truck> = trucks.map(|id| Truck::new(id * trips)).collect();
    for trip in 0..trips {
        let is_asked_for = |truck: &&mut Truck| truck.first_cycle + trip < cycles.end;
        let mut asked: Vec<&mut Truck> = trucks.iter_mut().filter(is_asked_for).collect();
        if asked.is_empty() {
            return;
        }
        let scenarios = asked.iter_mut().map(|truck| truck.depart(study, draw, trip)).collect();
        let Some(records) = drive(scenarios) else { return };
        for (truck, record) in asked.into_iter().zip(&records) {
            truck.arrive(record, trip);
        }
    }
}

impl Truck {
    fn new(first_cycle: u64) -> Self {
        let (ahead, charge) = (None, None);
        Self { first_cycle, ahead, charge, back_s: 0.0, drivers: Vec::new() }
    }

    /// The trip as it departs: late, with what the battery has, and with the driver's clock.
    fn depart(&mut self, study: &Study, draw: Draw, trip: u64) -> Scenario {
        let Draw { seed, pick_freeze } = draw;
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
        scenario
    }

    /// The truck is back: `back_s` was its departure.
    fn arrive(&mut self, record: &Record, trip: u64) {
        debug_assert_eq!(record.cycle_id, self.first_cycle + trip);
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

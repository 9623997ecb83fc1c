//! Trips within trucks: at which level a quantity is drawn, and what each level's draws depend on.
//!
//! Trip t of truck k is cycle k·T + t, where each truck makes T trips. Draws of a level are a
//! function of the seed, the stream and the level's own ids alone:
//!
//! | level | ids |
//! |---|---|
//! | trip | truck, trip; those of trip 0 are the draws that cycle k has where each truck makes one trip |
//! | driver | driver |
//! | truck | truck |
//! | day | day on which trucks drive: all that drive on it share the draws |
//!
//! So more trucks, or more trips of each, change no trip that was there. Driver d of truck k has id
//! k·D + d, where each truck has D drivers, who take turns; a pool of drivers numbers its own, and
//! each trip draws one of them.
//!
//! Checked: the records of studies without trucks are the bytes of the version before
//! (`scripts/same-records`), and a fleet by hand, one study a truck, is the same fleet
//! (`scripts/fleet_by_hand.py`).

use super::{Draws, Sample, Stream};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// At which level a quantity is drawn.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// For each trip anew.
    #[default]
    Trip,
    /// Once for a driver.
    Driver,
    /// Once for a truck.
    Truck,
    /// Once for all trucks that drive on a day.
    Day,
}

impl Level {
    /// All levels.
    pub const ALL: [Self; 4] = [Self::Trip, Self::Driver, Self::Truck, Self::Day];
}

/// Drivers of a truck.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drivers {
    /// So many drivers of its own, in turn from trip to trip.
    OfTruck(u64),
    /// One of a pool that all trucks share, drawn for each trip.
    OfPool(u64),
}

/// Drivers whom all trucks share under a seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pool {
    /// The seed that assigns them.
    pub seed: u64,
    /// How many they are.
    pub drivers: u64,
}

impl Pool {
    /// Driver of a trip of a truck.
    pub fn driver_of(self, truck_id: u64, trip: u64) -> u64 {
        let ids = Ids { id: truck_id, trip, is_day: false };
        let mut draws = Draws::of(self.seed, Sample::First, ids, Stream::DriverAssignment);
        (draws.uniform() * self.drivers as f64) as u64
    }
}

/// Days on which trucks drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OperatingDays {
    /// Days of a week on which trucks drive.
    pub per_week: u64,
    /// Trips of a truck on such a day.
    pub trips: u64,
    /// From one departure of a day to the next, in s.
    pub departure_interval_s: f64,
}

/// Days of a year.
pub const DAYS_OF_YEAR: u64 = 365;

impl OperatingDays {
    /// Operating day of a trip, numbered from 0 without gaps.
    pub fn number_of(self, trip: u64) -> u64 {
        trip / self.trips
    }

    /// Day of a trip, counted from the first day of the first year.
    pub fn day_of(self, trip: u64) -> u64 {
        let day = self.number_of(trip);
        day / self.per_week * 7 + day % self.per_week
    }

    /// How many departures of the same day were before this one.
    pub fn departure_of(self, trip: u64) -> u64 {
        trip % self.trips
    }
}

/// How trips belong to trucks, drivers and days.
#[derive(Clone, Debug, PartialEq)]
pub struct Nesting {
    /// Trips of each truck, at least 1.
    pub trips_per_truck: u64,
    /// Drivers of the trucks.
    pub drivers: Drivers,
    /// When they are driven; none where each trip draws its day.
    pub days: Option<OperatingDays>,
    /// Streams that are drawn at another level than usual.
    pub levels: Vec<(Stream, Level)>,
    /// Number of the first trip of each truck.
    pub first_trip: u64,
}

/// One trip's place in its fleet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Trip {
    /// The truck.
    pub truck_id: u64,
    /// Its driver.
    pub driver_id: u64,
    /// Number of the trip among those of its truck, from 0.
    pub trip: u64,
}

/// Ids on which the draws of a level depend beside seed and stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Ids {
    pub(super) id: u64,
    pub(super) trip: u64,
    pub(super) is_day: bool,
}

impl Ids {
    /// Ids of a cycle that is a truck by itself.
    pub(super) fn of_cycle(cycle_id: u64) -> Self {
        Self { id: cycle_id, trip: 0, is_day: false }
    }
}

impl Nesting {
    /// Each cycle has a truck and a driver of its own.
    pub const NONE: Self = Self {
        trips_per_truck: 1,
        drivers: Drivers::OfTruck(1),
        days: None,
        levels: Vec::new(),
        first_trip: 0,
    };

    /// The nesting of trucks that make this one trip of the calendar alone, each with a driver of
    /// its own and days that it shares with none.
    #[must_use]
    pub fn of_trip_alone(&self, trip: u64) -> Self {
        Self { days: self.days, first_trip: trip, ..Self::NONE }
    }

    /// Truck and number of the trip of a cycle.
    pub fn truck_and_trip(&self, cycle_id: u64) -> (u64, u64) {
        (cycle_id / self.trips_per_truck, self.first_trip + cycle_id % self.trips_per_truck)
    }

    /// The level at which a stream is drawn.
    pub fn level_of(&self, stream: Stream) -> Level {
        let own = self.levels.iter().find(|(other, _)| *other == stream);
        own.map_or_else(|| stream.usual_level(), |(_, level)| *level)
    }

    /// The day of a trip on which trucks drive, numbered from 0 without gaps.
    pub(super) fn day_of(&self, trip: u64) -> u64 {
        self.days.map_or(trip, |days| days.number_of(trip))
    }
}

impl Stream {
    /// The level at which it is drawn where a study says nothing else: what a driver is belongs to
    /// the driver, what a truck is to the truck, all else to the trip.
    pub fn usual_level(self) -> Level {
        use Stream as S;
        match self {
            S::CurveSpeed
            | S::SpeedChange
            | S::Compliance
            | S::Pedals
            | S::BumpComfort
            | S::SignOffset => Level::Driver,
            S::Vehicle | S::TruckEffect => Level::Truck,
            _ => Level::Trip,
        }
    }
}

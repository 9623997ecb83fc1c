//! Trucks of a fleet that a battery truck can replace: those whose trips arrive.
//!
//! Of N trucks k make all of their trips, or at least 95 % of them. The interval of the share of
//! such trucks is Wilson's: the shares p with |k/N − p| ≤ z √(p (1 − p) / N), z = 1.96, so that it
//! stays within 0 and 1, and has a width where all trucks arrive. Source: E. B. Wilson, *J. Am.
//! Stat. Assoc.* 22 (1927) 209 \[PK\]. Trucks count as independent of one another. Trips that
//! stalled or timed out do not count.

use super::dependence::Dependence;
use ocmc_core::record::{Outcome, Record};
use schemars::JsonSchema;
use serde::Serialize;

/// Shares of a truck's trips that have to arrive.
pub const WANTED: [f64; 2] = [1.0, 0.95];
/// Standard errors of half a 95 % interval.
const HALF_WIDTH: f64 = 1.959_963_984_540_054;

/// Trucks of which a share of the trips arrives.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct TruckArrivals {
    /// Share of a truck's trips that has to arrive.
    pub share_of_trips: f64,
    /// Trucks of which as many do.
    pub trucks: u64,
    /// All trucks.
    pub of: u64,
    /// 95 % interval of the share of such trucks.
    pub ci95: [f64; 2],
}

/// Counts trips of trucks, in the order of their cycles.
#[derive(Clone, Debug, Default)]
pub struct TruckArrivalBuilder {
    trucks: u64,
    enough: [u64; WANTED.len()],
    /// The truck whose trips come, its trips, and those that arrived.
    truck_id: Option<u64>,
    trips: u64,
    arrived: u64,
}

impl TruckArrivalBuilder {
    /// Adds a trip of a battery truck; others do not count.
    pub fn add(&mut self, record: &Record, dependence: &Dependence) {
        if record.final_charge.is_none() || !record.outcome.counts() {
            return;
        }
        let truck_id = Some(record.cycle_id / dependence.trips_per_truck);
        if truck_id != self.truck_id {
            self.close();
            self.truck_id = truck_id;
        }
        self.trips += 1;
        self.arrived += u64::from(record.outcome == Outcome::Completed);
    }

    /// The truck has no more trips.
    fn close(&mut self) {
        if self.trips > 0 {
            self.trucks += 1;
            for (enough, wanted) in self.enough.iter_mut().zip(WANTED) {
                *enough += u64::from(self.arrived as f64 >= wanted * self.trips as f64);
            }
        }
        (self.trips, self.arrived) = (0, 0);
    }

    /// The trucks, one entry for each share; none without battery trucks that make several trips.
    pub fn finish(mut self) -> Vec<TruckArrivals> {
        self.close();
        if self.trucks == 0 {
            return Vec::new();
        }
        let arrivals = |(share_of_trips, trucks): (f64, u64)| TruckArrivals {
            share_of_trips,
            trucks,
            of: self.trucks,
            ci95: wilson(trucks, self.trucks),
        };
        WANTED.into_iter().zip(self.enough).map(arrivals).collect()
    }
}

/// Wilson's 95 % interval of a share, of k among n.
pub fn wilson(k: u64, n: u64) -> [f64; 2] {
    let (k, n) = (k as f64, n as f64);
    let squared = HALF_WIDTH * HALF_WIDTH;
    let middle = (k + 0.5 * squared) / (n + squared);
    let half = HALF_WIDTH / (n + squared) * (k * (n - k) / n + 0.25 * squared).sqrt();
    [(middle - half).max(0.0), (middle + half).min(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trucks_count_by_their_trips() {
        let dependence = Dependence { trips_per_truck: 20, ..Dependence::default() };
        let mut builder = TruckArrivalBuilder::default();
        for cycle_id in 0..60 {
            // truck 0: all; truck 1: one of 20 fails; truck 2: two, and one that stalled
            let outcome = match cycle_id {
                25 | 41 | 59 => Outcome::Depleted,
                50 => Outcome::Stalled,
                _ => Outcome::Completed,
            };
            let final_charge = Some(0.5);
            builder
                .add(&Record { cycle_id, outcome, final_charge, ..Record::default() }, &dependence);
        }
        let arrivals = builder.finish();
        let counts: Vec<u64> = arrivals.iter().map(|arrivals| arrivals.trucks).collect();
        assert_eq!((counts, arrivals[0].of), (vec![1, 2], 3));
        let mut diesel = TruckArrivalBuilder::default();
        diesel.add(&Record::default(), &dependence);
        assert!(diesel.finish().is_empty());
    }

    #[test]
    fn the_interval_solves_its_equation() {
        for (k, n) in [(0, 10), (3, 20), (15, 20), (20, 20), (970, 1000)] {
            let [low, high] = wilson(k, n);
            let share = k as f64 / n as f64;
            for end in [low, high].into_iter().filter(|end| *end > 1e-12 && *end < 1.0 - 1e-12) {
                let error = (end * (1.0 - end) / n as f64).sqrt();
                assert!(((share - end).abs() / error - HALF_WIDTH).abs() < 1e-9, "{k} {n} {end}");
            }
            assert!(low <= share && share <= high);
        }
        // all of 20 arrive: from 84 % on
        assert!((wilson(20, 20)[0] - 0.8389).abs() < 1e-4);
    }
}

//! How large a battery has to be for a share of the trips to arrive.
//!
//! All sizes are tried on the same trips. A trip that arrives with a battery arrives with a larger
//! one, too: so each trip has a largest battery with which it has failed and a smallest one with
//! which it has arrived, and a size is tried only on the trips for which it lies between the two.
//! The share that arrives then rises with the size, and the size for a share is found by
//! bisection. Its interval are the sizes for the share less and plus 1.96 of its standard errors,
//! of trips that depend on one another as the study says.

use super::range::season_of;
use super::run::{Ranges, RunPlan, each, run_with};
use ocmc_core::kernel::drive::scheduler::{Deliver, Driving, sampled};
use ocmc_core::record::{Outcome, Record};
use ocmc_core::study::Study;
use schemars::JsonSchema;
use serde::Serialize;
use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;

/// Smallest and largest battery that is tried, in J: those that a study can have.
pub const SIZES_J: [f64; 2] = [1.0e6, 1.0e11];
/// Relative width to which a size is found.
const WIDTH: f64 = 1.0 / 1024.0;
/// Seconds of a day.
const DAY_S: f64 = 86_400.0;
/// Standard errors of half a 95 % interval.
const HALF_WIDTH: f64 = 1.959_963_984_540_054;

/// A size that was tried.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct TriedSize {
    /// The battery's energy, in J.
    pub capacity_j: f64,
    /// Share of the trips that arrives.
    pub share: f64,
}

/// The battery with which a share of the trips arrives.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct SizeFor {
    /// The share.
    pub share: f64,
    /// The battery's energy, in J; none where no battery is enough.
    pub capacity_j: Option<f64>,
    /// Its 95 % interval; an end is none where the trips are too few to tell.
    pub ci95_j: [Option<f64>; 2],
}

/// Knowledge of one trip.
#[derive(Clone, Copy, Debug)]
struct Known {
    fails_j: f64,
    arrives_j: f64,
    given_up: bool,
}

/// Trips on which sizes are tried.
#[derive(Clone, Debug)]
pub struct Sizing {
    trips: Vec<Known>,
    /// The cluster of each trip: trips of one depend on one another. In order.
    clusters: Vec<u64>,
    tried: Vec<TriedSize>,
    start_j: f64,
    /// Trips driven, over all sizes.
    pub drives: u64,
}

impl Sizing {
    /// Trips of these clusters, in order, and the size with which to begin.
    pub fn new(clusters: Vec<u64>, start_j: f64) -> Self {
        let unknown = Known { fails_j: 0.0, arrives_j: f64::INFINITY, given_up: false };
        let trips = vec![unknown; clusters.len()];
        Self { trips, clusters, tried: Vec::new(), start_j, drives: 0 }
    }

    /// The smallest battery with which this share arrives, to 0.1 %, and its interval. `drive`
    /// tells how these trips end with a battery.
    pub fn size_for<B>(
        &mut self,
        share: f64,
        drive: &mut impl FnMut(f64, &[u64]) -> ControlFlow<B, Vec<Outcome>>,
    ) -> ControlFlow<B, SizeFor> {
        let capacity_j = self.find(share, drive)?;
        let mut ci95_j = [None; 2];
        if let Some(capacity_j) = capacity_j {
            let half = HALF_WIDTH * self.standard_error(capacity_j);
            for (end, wanted) in ci95_j.iter_mut().zip([share - half, share + half]) {
                if wanted > 0.0 && wanted < 1.0 && half > 0.0 {
                    *end = self.find(wanted, drive)?;
                }
            }
        }
        ControlFlow::Continue(SizeFor { share, capacity_j, ci95_j })
    }

    /// The sizes that were tried, from the smallest.
    pub fn tried(&self) -> &[TriedSize] {
        &self.tried
    }

    /// Trips that were given up for another reason than the battery.
    pub fn given_up(&self) -> u64 {
        self.trips.iter().filter(|trip| trip.given_up).count() as u64
    }

    fn find<B>(
        &mut self,
        share: f64,
        drive: &mut impl FnMut(f64, &[u64]) -> ControlFlow<B, Vec<Outcome>>,
    ) -> ControlFlow<B, Option<f64>> {
        loop {
            let enough = self.tried.iter().find(|tried| tried.share >= share);
            let too_small = self.tried.iter().rev().find(|tried| tried.share < share);
            let next_j = match (too_small, enough) {
                (None, None) => self.start_j,
                (Some(small), None) if small.capacity_j >= SIZES_J[1] => {
                    return ControlFlow::Continue(None);
                }
                (Some(small), None) => 2.0 * small.capacity_j,
                (None, Some(enough)) if enough.capacity_j <= SIZES_J[0] => {
                    return ControlFlow::Continue(Some(enough.capacity_j));
                }
                (None, Some(enough)) => 0.5 * enough.capacity_j,
                (Some(small), Some(enough)) => {
                    if enough.capacity_j <= small.capacity_j * (1.0 + WIDTH) {
                        return ControlFlow::Continue(Some(enough.capacity_j));
                    }
                    (small.capacity_j * enough.capacity_j).sqrt()
                }
            };
            self.attempt(next_j.clamp(SIZES_J[0], SIZES_J[1]), drive)?;
        }
    }

    /// Tries a size on the trips that do not tell already.
    fn attempt<B>(
        &mut self,
        capacity_j: f64,
        drive: &mut impl FnMut(f64, &[u64]) -> ControlFlow<B, Vec<Outcome>>,
    ) -> ControlFlow<B> {
        let is_open = |trip: &Known| {
            !trip.given_up && trip.fails_j < capacity_j && capacity_j < trip.arrives_j
        };
        let open: Vec<u64> =
            (0..).zip(&self.trips).filter(|(_, trip)| is_open(trip)).map(|(k, _)| k).collect();
        if !open.is_empty() {
            self.drives += open.len() as u64;
            for (k, outcome) in open.iter().zip(drive(capacity_j, &open)?) {
                let trip = &mut self.trips[*k as usize];
                match outcome {
                    Outcome::Completed => trip.arrives_j = capacity_j,
                    Outcome::Depleted => trip.fails_j = capacity_j,
                    _ => trip.given_up = true,
                }
            }
        }
        let counted = self.trips.iter().filter(|trip| !trip.given_up);
        let (mut all, mut arrived) = (0_u64, 0_u64);
        for trip in counted {
            all += 1;
            arrived += u64::from(trip.arrives_j <= capacity_j);
        }
        let share = arrived as f64 / all.max(1) as f64;
        let at = self.tried.partition_point(|tried| tried.capacity_j < capacity_j);
        self.tried.insert(at, TriedSize { capacity_j, share });
        ControlFlow::Continue(())
    }

    /// Standard error of the share that arrives with a battery that was tried: that of a ratio of
    /// clusters.
    fn standard_error(&self, capacity_j: f64) -> f64 {
        let mut trips = self.trips.iter();
        let clusters: Vec<[f64; 2]> = self
            .clusters
            .chunk_by(|a, b| a == b)
            .map(|cluster| {
                let own = trips.by_ref().take(cluster.len()).filter(|trip| !trip.given_up);
                own.fold([0.0, 0.0], |[all, arrived], trip| {
                    [all + 1.0, arrived + f64::from(u8::from(trip.arrives_j <= capacity_j))]
                })
            })
            .collect();
        let [all, arrived] =
            clusters.iter().fold([0.0, 0.0], |sum, one| [sum[0] + one[0], sum[1] + one[1]]);
        let n = clusters.len() as f64;
        if n < 2.0 || all < 1.0 {
            return 0.0;
        }
        let share = arrived / all;
        let squares = clusters.iter().map(|[all, arrived]| {
            let residual = arrived - share * all;
            residual * residual
        });
        (squares.fold(0.0, |sum, square| sum + square) * n / (n - 1.0)).sqrt() / all
    }
}

/// Places of the cycles of a plan that depart in a season, by its place in
/// [`super::range::SEASONS`]. `progress` as for [`drive_some`], of cycles that were drawn.
pub fn of_season<B>(
    study: &Study,
    plan: &RunPlan,
    season: usize,
    progress: impl FnMut(u64) -> ControlFlow<B>,
) -> ControlFlow<B, Vec<u64>> {
    let departs_then = |cycle_id: u64, _: &AtomicBool| {
        let mission = study.sample(plan.seed, cycle_id).cycle.mission;
        season_of(mission.day_of_year * DAY_S + mission.departure_s) == season
    };
    let flags = each(plan, &departs_then, progress)?;
    let places = (0..plan.cycles).zip(flags).filter(|(_, is_then)| *is_then);
    ControlFlow::Continue(places.map(|(place, _)| place).collect())
}

/// Drives single cycles of a plan until they arrive or are empty, in the order of their places in
/// it. `progress` receives the number of cycles driven so far; breaking ends the run.
pub fn drive_some<B>(
    study: &Study,
    plan: &RunPlan,
    places: &[u64],
    mut progress: impl FnMut(u64) -> ControlFlow<B>,
) -> ControlFlow<B, Vec<Outcome>> {
    // the cycles of this run are numbered by their order among the places
    let drive = |ranges: Ranges, stop: &AtomicBool, deliver: Deliver| {
        let ids = ranges.flatten().map(|k| plan.first_cycle + places[k as usize]);
        let mut numbered = |record: Record| {
            let place = record.cycle_id - plan.first_cycle;
            let k = places.binary_search(&place).expect("places are in order, and this is one");
            deliver(Record { cycle_id: k as u64, ..record });
        };
        let driving = Driving { study, level: plan.level, stop, whole_trips: false };
        driving.each(&mut sampled(study, plan.seed, ids), &mut numbered);
    };
    let all = places.len() as u64;
    let some = RunPlan::new(plan.seed, 0, all, Some(plan.threads), None);
    let mut outcomes = Vec::with_capacity(places.len());
    run_with(&some, &drive, |records: Vec<Record>| {
        outcomes.extend(records.iter().map(|record| record.outcome));
        progress(outcomes.len() as u64)
    })?;
    ControlFlow::Continue(outcomes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    /// Trips k of n that need a battery of (1 + k) GJ.
    fn stairs(capacity_j: f64, trips: &[u64]) -> Vec<Outcome> {
        let needs_j = |k: u64| 1.0e9 * (1 + k) as f64;
        let arrives = |k: &u64| needs_j(*k) <= capacity_j;
        trips
            .iter()
            .map(|k| if arrives(k) { Outcome::Completed } else { Outcome::Depleted })
            .collect()
    }

    #[test]
    fn the_size_is_the_quantile_of_what_the_trips_need() {
        let mut sizing = Sizing::new((0..100).collect(), 1.0e9);
        let mut drive = |capacity_j: f64, trips: &[u64]| {
            ControlFlow::<Infallible, _>::Continue(stairs(capacity_j, trips))
        };
        let ControlFlow::Continue(sized) = sizing.size_for(0.8, &mut drive);
        let size_j = sized.capacity_j.unwrap();
        assert!((size_j / 80.0e9 - 1.0).abs() < 1.1 * WIDTH && size_j >= 80.0e9, "{sized:?}");
        // binomial: 0.8 ± 1.96 × 0.04; a share between two stairs takes the next one
        let [low, high] = sized.ci95_j.map(Option::unwrap);
        assert!(
            (low / 73.0e9 - 1.0).abs() < 2e-3 && (high / 88.0e9 - 1.0).abs() < 2e-3,
            "{sized:?}"
        );
        // each size was tried on the trips alone that did not tell
        assert!(sizing.drives < 900, "{}", sizing.drives);
        assert!(sizing.tried().windows(2).all(|pair| pair[0].share <= pair[1].share));
        // 100 of 100 trips need 100 GJ, the largest there is
        let ControlFlow::Continue(all) = sizing.size_for(1.0, &mut drive);
        assert!((all.capacity_j.unwrap() / 100.0e9 - 1.0).abs() < 2e-3, "{all:?}");
    }

    #[test]
    fn trips_that_are_alike_tell_less_and_no_battery_is_enough_for_some() {
        let sizing = |cluster: u64| {
            let clusters = (0..100).map(|k| k / cluster).collect();
            let mut sizing = Sizing::new(clusters, 50.0e9);
            let mut drive = |capacity_j: f64, trips: &[u64]| {
                let trips: Vec<u64> = trips.iter().map(|k| k - k % 10).collect();
                ControlFlow::<Infallible, _>::Continue(stairs(capacity_j, &trips))
            };
            let ControlFlow::Continue(sized) = sizing.size_for(0.5, &mut drive);
            sized.ci95_j.map(Option::unwrap)
        };
        let (own, alike) = (sizing(1), sizing(10));
        assert!(alike[1] - alike[0] > 2.0 * (own[1] - own[0]), "{own:?} {alike:?}");
        let mut never = |_: f64, trips: &[u64]| {
            ControlFlow::<Infallible, _>::Continue(vec![Outcome::Depleted; trips.len()])
        };
        let ControlFlow::Continue(sized) =
            Sizing::new((0..5).collect(), 1e9).size_for(0.9, &mut never);
        assert_eq!((sized.capacity_j, sized.ci95_j), (None, [None; 2]));
    }
}

//! Dependence between cycles of a run.
//!
//! Where the cycles of a batch spread evenly ([`ocmc_core::random::sampling`]), they are not
//! independent, but batches are. A batch then counts as one: with y_b and x_b the totals of batch
//! b, the fleet's mean is R = Σ y_b / Σ x_b as ever, and its interval is that of a ratio of batches
//! ([`super::ratio`]), which is narrower the more evenly they spread. A batch that the run has only
//! a part of counts as a smaller one. So are the trips of one truck, which share truck and driver:
//! a truck counts as one; where trucks spread evenly, too, a batch of trucks does. Trucks that
//! share drivers of a pool, or days, depend on one another in several ways ([`super::clustering`]).
//! Source: W. G. Cochran, *Sampling Techniques*, 3rd ed. (1977), chapter 9A, the ratio estimator of
//! clusters of different size \[PK\].

use ocmc_core::random::nesting::{Drivers, Level, Nesting, OperatingDays, Pool};
use ocmc_core::random::sampling::Sampling;
use ocmc_core::study::StudyModel;
use ocmc_core::study::fleet::FleetModel;

/// Dependence between cycles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dependence {
    /// Cycles of a batch: those with the same quotient of their id by this. 1 where all are
    /// independent.
    pub batch: u64,
    /// Replicates of uncertain parameters that the cycles share, where there are any.
    pub replicates: Option<u64>,
    /// Trips of each truck.
    pub trips_per_truck: u64,
    /// When trucks drive; none where each trip draws its day.
    pub days: Option<OperatingDays>,
    /// Drivers whom trucks share; none where each has its own.
    pub pool: Option<Pool>,
    /// Whether trucks share what is drawn for a day.
    pub shares_days: bool,
}

impl Default for Dependence {
    fn default() -> Self {
        let (replicates, days, pool) = (None, None, None);
        Self { batch: 1, replicates, trips_per_truck: 1, days, pool, shares_days: false }
    }
}

impl Dependence {
    /// Dependence of a study's cycles under a seed.
    pub fn of(study: &StudyModel, seed: u64) -> Self {
        let replicates = study.driver.curve_speed.uncertain_replicates();
        Self::of_fleet(&study.fleet, study.simulation.sampling, replicates, seed)
    }

    /// Dependence in a fleet whose cycles share out their draws like this.
    pub fn of_fleet(
        fleet: &FleetModel,
        sampling: Sampling,
        replicates: Option<u64>,
        seed: u64,
    ) -> Self {
        let Nesting { trips_per_truck, drivers, days, levels, .. } = fleet.nesting();
        let shares_days = levels.iter().any(|(_, level)| *level == Level::Day);
        let pool = match drivers {
            Drivers::OfTruck(_) => None,
            Drivers::OfPool(drivers) => Some(Pool { seed, drivers }),
        };
        let batch = sampling.batch() * trips_per_truck;
        Self { batch, replicates, trips_per_truck, days, pool, shares_days }
    }

    /// Whether cycles of several trucks depend on one another.
    pub fn is_shared(self) -> bool {
        self.pool.is_some() || self.shares_days
    }

    /// The group of cycles that a cycle depends on: its replicate, or its batch.
    pub(super) fn group_of(self, cycle_id: u64) -> u64 {
        match self.replicates {
            Some(replicates) => cycle_id / self.trips_per_truck % replicates,
            None => cycle_id / self.batch,
        }
    }

    /// The day on which trucks drive of a cycle, numbered without gaps.
    pub(super) fn day_of(self, cycle_id: u64) -> u64 {
        let trip = cycle_id % self.trips_per_truck;
        self.days.map_or(trip, |days| days.number_of(trip))
    }

    /// Whether trucks make several trips.
    pub fn has_trucks(self) -> bool {
        self.trips_per_truck > 1
    }

    /// Dependence of pairs of cycles of two studies, which depend on one another where the cycles
    /// of either study do. Where both have replicates, and not as many, their pairs share none.
    #[must_use]
    pub fn of_pairs(self, other: Self) -> Self {
        let replicates = match (self.replicates, other.replicates) {
            (Some(a), Some(b)) if a != b => None,
            (a, b) => a.or(b),
        };
        let shares_days = self.shares_days || other.shares_days;
        let (batch, pool) = (self.batch.max(other.batch), self.pool.or(other.pool));
        Self { batch, replicates, pool, shares_days, ..self }
    }

    /// Totals (Σ y, Σ x) of each batch, from (cycle id, y, x) in the order of the ids.
    pub fn batch_totals(self, cycles: impl Iterator<Item = (u64, f64, f64)>) -> Vec<(f64, f64)> {
        let mut totals: Vec<(f64, f64)> = Vec::new();
        let mut last = None;
        for (cycle_id, y, x) in cycles {
            let batch = Some(cycle_id / self.batch);
            match totals.last_mut() {
                Some(total) if batch == last => {
                    total.0 += y;
                    total.1 += x;
                }
                _ => totals.push((y, x)),
            }
            last = batch;
        }
        totals
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::assert_share;
    use crate::summary::SummaryBuilder;
    use ocmc_core::energy::Carrier;
    use ocmc_core::random::sampling::Sampling;
    use ocmc_core::random::{Stream, Streams};
    use ocmc_core::record::Record;

    #[test]
    fn a_batch_is_cut_by_the_ids_and_not_by_the_first_cycle() {
        let cycles = || (6..13).filter(|id| *id != 9).map(|id| (id, id as f64, 1.0));
        let in_batches = |batch| Dependence { batch, ..Dependence::default() };
        let totals = |batch| in_batches(batch).batch_totals(cycles());
        assert_eq!(totals(4), [(13.0, 2.0), (29.0, 3.0), (12.0, 1.0)]);
        assert_eq!(totals(1).len(), 6);
        assert_eq!(totals(100), [(54.0, 6.0)]);
    }

    #[test]
    fn pairs_depend_as_the_cycles_of_either_study_do() {
        let dependence =
            |batch, replicates| Dependence { batch, replicates, ..Dependence::default() };
        assert_eq!(
            dependence(16, None).of_pairs(dependence(1, Some(64))),
            dependence(16, Some(64))
        );
        assert_eq!(
            dependence(1, Some(64)).of_pairs(dependence(1, Some(64))),
            dependence(1, Some(64))
        );
        assert_eq!(dependence(1, Some(64)).of_pairs(dependence(1, Some(32))), dependence(1, None));
    }

    /// A fleet of cycles that spread evenly: litres are 30, what the driver does (all of it
    /// explained by the spread draws) and what the road does; distances vary with the road.
    fn fleet(run: u64, cycles: u64) -> SummaryBuilder {
        let sampling = Sampling::Sobol;
        let mut fleet =
            SummaryBuilder::new(Dependence { batch: sampling.batch(), ..Dependence::default() });
        let records: Vec<Record> = (0..cycles)
            .map(|k| {
                let streams = Streams { sampling, ..Streams::new(1, 1_000_003 * run + k) };
                let mut driver = streams.open(Stream::Payload);
                let mut road = streams.open(Stream::Curve);
                let empty = if driver.happens(0.2) { -10.0 } else { 0.0 };
                let litres = 30.0 + empty + 4.0 * driver.normal() + 3.0 * road.normal();
                Record {
                    cycle_id: streams.cycle_id,
                    distance_m: libm::exp(0.3 * road.normal()),
                    duration_s: 1.0,
                    ..Record::default().with(Carrier::LiquidFuel, [None, Some(litres), None])
                }
            })
            .collect();
        fleet.add(&records);
        fleet
    }

    #[test]
    fn intervals_of_batches_cover_the_truth_and_are_narrower() {
        const RUNS: u64 = 2000;
        // median of 0.8 N(30, 5²) + 0.2 N(20, 5²): 0.8 Φ((x − 30)/5) + 0.2 Φ((x − 20)/5) = 0.5
        let (mut low, mut high) = (20.0, 30.0);
        for _ in 0..60 {
            let x = 0.5 * (low + high);
            let below = |mean: f64| 0.5 * libm::erfc((mean - x) / 50f64.sqrt());
            let share = 0.8 * below(30.0) + 0.2 * below(20.0);
            if share < 0.5 { low = x } else { high = x }
        }
        let median = low;
        let (mut mean_covered, mut median_covered, mut widths) = (0, 0, 0.0);
        for run in 0..RUNS {
            // ids begin in the middle of a batch, and end in another one
            let summary = fleet(run, 500).finish();
            let litres = summary.consumption().expect("fuel");
            let holds =
                |[low, high]: [f64; 2], truth: f64| usize::from(low <= truth && truth <= high);
            let ci95 = litres.ci95.expect("500 cycles");
            mean_covered += holds(ci95, 28.0);
            median_covered += holds(litres.quantiles[2].ci95.expect("500 cycles"), median);
            widths += (ci95[1] - ci95[0]) / RUNS as f64;
        }
        assert_share("mean", mean_covered, RUNS as usize, 0.95);
        // rounded outwards, by up to two of 500 ranks of about ±40
        let share = median_covered as f64 / RUNS as f64;
        let error = (0.95 * 0.05 / RUNS as f64).sqrt();
        assert!(share > 0.95 - 4.0 * error && share < 0.97 + 4.0 * error, "{share}");
        // the variance between cycles is 16 (payload) + 16 (empty) + 9; weights of e^(0.3 z) cost
        // e^0.09 of the road's part, and of the spread part what they do to its balance: less than
        // half of the whole is left
        let independent = 2.0 * 1.96 * (41.0 * libm::exp(0.09) / 500.0_f64).sqrt();
        assert!(widths < 0.75 * independent, "{widths} {independent}");
    }
}

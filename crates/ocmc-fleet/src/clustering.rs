//! Intervals of fleets whose trips depend on one another in several ways at once: they are of the
//! same truck, of the same driver of a pool, of the same shared day.
//!
//! An estimate's error is a sum over its trips, Σ u_i, with u_i a trip's influence: of a ratio R =
//! Σ y / Σ x it is u_i = (y_i − R x_i) / Σ x. With the ways W in which trips belong together, and
//! for each non-empty subset S of them the clusters c of trips that agree in all ways of S,
//!
//! V = Σ_S (−1)^(|S|+1) V_S,   V_S = G_S/(G_S − 1) Σ_c (Σ_{i in c} u_i)²
//!
//! with G_S the number of clusters of S. V may come out below the V of one way alone, where that is
//! all there is; the largest of these is then taken. The interval is ± t₀.₉₇₅(ν) √V, and
//!
//! ν = V² / Σ_w V_w²/(G_w − 1)
//!
//! over the single ways, within the range of G_w − 1. A way of which there is one cluster tells
//! nothing of how clusters differ, and there is no interval.
//!
//! Sources: A. C. Cameron, J. B. Gelbach, D. L. Miller, Robust inference with multiway clustering,
//! *Journal of Business & Economic Statistics* 29 (2011) 238-249 \[PK\]; F. E. Satterthwaite,
//! *Biometrics Bulletin* 2 (1946) 110-114, for ν \[PK\].

use super::dependence::Dependence;
use super::ratio::{Ratio, student_975};

/// In which clusters the cycles of a run are.
#[derive(Clone, Debug)]
pub struct Clusters {
    dependence: Dependence,
    /// Where cycles belong together in several ways.
    several: Option<Ways>,
}

/// The subsets of the ways in which cycles belong together.
#[derive(Clone, Debug)]
struct Ways {
    cycle_ids: Vec<u64>,
    subsets: Vec<Subset>,
}

#[derive(Clone, Debug)]
struct Subset {
    /// Number of its ways.
    ways: u32,
    /// Cluster of each cycle, numbered from 0.
    cluster: Vec<u32>,
    /// Number of clusters.
    clusters: usize,
}

/// How sure an estimate is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spread {
    /// Square of its standard error.
    pub(super) variance: f64,
    /// Degrees of freedom of that.
    pub(super) degrees: f64,
    /// Part of it that is there by trucks alone.
    pub(super) by_trucks: f64,
}

impl Spread {
    /// Half of the 95 % interval.
    pub(super) fn half_width(&self) -> f64 {
        student_975(self.degrees) * libm::sqrt(self.variance)
    }

    /// The 95 % interval.
    pub(super) fn around(&self, value: f64) -> [f64; 2] {
        let half_width = self.half_width();
        [value - half_width, value + half_width]
    }

    /// Half of a 95 % interval by trucks alone, with what trucks share added: that moves all of
    /// them alike.
    pub(super) fn widened(&self, by_trucks_alone: f64) -> f64 {
        let t = student_975(self.degrees);
        let shared = (self.variance - self.by_trucks).max(0.0);
        libm::sqrt(by_trucks_alone * by_trucks_alone + t * t * shared)
    }
}

/// Clusters of cycles that are told apart by their ids alone.
impl From<Dependence> for Clusters {
    fn from(dependence: Dependence) -> Self {
        Self { dependence, several: None }
    }
}

impl Clusters {
    /// Clusters of cycles with these ids, in their order.
    pub fn of(dependence: Dependence, cycle_ids: impl Iterator<Item = u64>) -> Self {
        let several = dependence.is_shared().then(|| Ways::of(dependence, cycle_ids.collect()));
        Self { dependence, several }
    }

    /// Whether no cycle depends on another.
    pub(super) fn are_independent(&self) -> bool {
        self.dependence.batch == 1 && self.several.is_none()
    }

    /// Whether cycles belong together in several ways.
    pub(super) fn has_several_ways(&self) -> bool {
        self.several.is_some()
    }

    /// Σ y / Σ x, from (cycle id, y, x) in the order of the ids; none where Σ x is not positive.
    pub(super) fn ratio(
        &self,
        rows: impl Iterator<Item = (u64, f64, f64)> + Clone,
    ) -> Option<Ratio> {
        if self.several.is_none() {
            if self.dependence.batch == 1 {
                return Ratio::estimate(rows.map(|(_, y, x)| (y, x)));
            }
            return Ratio::estimate(self.dependence.batch_totals(rows).into_iter());
        }
        let (mut sum_y, mut sum_x) = (0.0, 0.0);
        for (_, y, x) in rows.clone() {
            sum_y += y;
            sum_x += x;
        }
        if sum_x.is_nan() || sum_x <= 0.0 {
            return None;
        }
        let ratio = sum_y / sum_x;
        let spread = self.spread(rows.map(|(id, y, x)| (id, (y - ratio * x) / sum_x)));
        Some(Ratio { ratio, ci95: spread.map(|spread| spread.around(ratio)) })
    }

    /// How sure an estimate is whose error is the sum of these influences, each after its cycle's
    /// id, in the order of the ids; none from a single cluster, and where cycles belong together in
    /// one way alone.
    pub(super) fn spread(&self, influences: impl Iterator<Item = (u64, f64)>) -> Option<Spread> {
        self.several.as_ref()?.spread(influences)
    }
}

impl Ways {
    fn of(dependence: Dependence, cycle_ids: Vec<u64>) -> Self {
        let of_way = |way: &dyn Fn(u64) -> u64| -> Vec<u64> {
            cycle_ids.iter().map(|cycle_id| way(*cycle_id)).collect()
        };
        let mut ways = vec![of_way(&|cycle_id| cycle_id / dependence.batch)];
        if let Some(pool) = dependence.pool {
            ways.push(of_way(&|cycle_id| {
                let trips = dependence.trips_per_truck;
                pool.driver_of(cycle_id / trips, cycle_id % trips)
            }));
        }
        if dependence.shares_days {
            ways.push(of_way(&|cycle_id| dependence.day_of(cycle_id)));
        }
        let subsets = (1_u32..1 << ways.len()).map(|subset| {
            let inside = ways.iter().enumerate().filter(|(way, _)| subset >> way & 1 == 1);
            let joined = inside.map(|(_, of_way)| ranks(of_way));
            let (cluster, clusters) = joined.reduce(join).expect("no subset is empty");
            Subset { ways: subset.count_ones(), cluster, clusters }
        });
        let subsets = subsets.collect();
        Self { cycle_ids, subsets }
    }

    fn spread(&self, influences: impl Iterator<Item = (u64, f64)>) -> Option<Spread> {
        let mut totals: Vec<Vec<f64>> =
            self.subsets.iter().map(|subset| vec![f64::NAN; subset.clusters]).collect();
        let mut place = 0;
        for (cycle_id, influence) in influences {
            while *self.cycle_ids.get(place)? < cycle_id {
                place += 1;
            }
            for (subset, totals) in self.subsets.iter().zip(&mut totals) {
                let total = &mut totals[subset.cluster[place] as usize];
                *total = if total.is_nan() { influence } else { *total + influence };
            }
        }
        let (mut variance, mut largest, mut weights) = (0.0, 0.0_f64, 0.0);
        let (mut fewest, mut most, mut by_trucks) = (f64::INFINITY, 0.0_f64, None);
        for (subset, totals) in self.subsets.iter().zip(&totals) {
            let own = totals.iter().filter(|total| !total.is_nan());
            let (clusters, squares) =
                own.fold((0.0, 0.0), |(n, sum), total| (n + 1.0, sum + total * total));
            if clusters < 2.0 {
                return None;
            }
            let degrees = clusters - 1.0;
            let own = clusters / degrees * squares;
            variance += if subset.ways % 2 == 1 { own } else { -own };
            if subset.ways == 1 {
                by_trucks.get_or_insert(own);
                largest = largest.max(own);
                weights += own * own / degrees;
                fewest = fewest.min(degrees);
                most = most.max(degrees);
            }
        }
        let variance = libm::fmax(variance, largest);
        let degrees =
            if weights > 0.0 { (variance * variance / weights).clamp(fewest, most) } else { most };
        Some(Spread { variance, degrees, by_trucks: by_trucks? })
    }
}

/// Numbers of keys in their order, from 0, and how many there are.
fn ranks(keys: &[u64]) -> (Vec<u32>, usize) {
    let mut sorted = keys.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    let rank = |key| sorted.binary_search(key).unwrap_or_else(|place| place) as u32;
    (keys.iter().map(rank).collect(), sorted.len())
}

/// Clusters of cycles that are in the same of both.
fn join(a: (Vec<u32>, usize), b: (Vec<u32>, usize)) -> (Vec<u32>, usize) {
    let ((a, _), (b, clusters)) = (a, b);
    let key = |(a, b): (&u32, &u32)| u64::from(*a) * clusters as u64 + u64::from(*b);
    ranks(&a.iter().zip(&b).map(key).collect::<Vec<u64>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{LITRES, quantity};
    use crate::statistics::assert_share;
    use crate::summary::{Summary, SummaryBuilder};
    use crate::truck_year::Total;
    use ocmc_core::energy::Carrier;
    use ocmc_core::random::nesting::{OperatingDays, Pool};
    use ocmc_core::random::{Draws, Stream};
    use ocmc_core::record::Record;

    const TRUCKS: u64 = 60;
    const TRIPS: u64 = 25;

    /// Trucks that make one trip a day, and share what is said.
    fn dependence(pool: Option<Pool>, shares_days: bool) -> Dependence {
        let days = Some(OperatingDays { per_week: 7, trips: 1, departure_interval_s: 0.0 });
        let (batch, trips_per_truck) = (TRIPS, TRIPS);
        Dependence { batch, trips_per_truck, days, pool, shares_days, ..Dependence::default() }
    }

    /// A fleet whose trips have normal parts of their truck (SD 1.5), of what they share (each with
    /// SD 2) and of their own (SD 5), around 30 litres; distances are log-normal.
    fn fleet(seed: u64, dependence: Dependence) -> Vec<Record> {
        let mut draws = Draws::new(seed, 0, Stream::Curve);
        let mut normals =
            |n: u64, sd: f64| -> Vec<f64> { (0..n).map(|_| sd * draws.normal()).collect() };
        let (trucks, days) = (normals(TRUCKS, 1.5), normals(TRIPS, 2.0));
        let drivers = normals(dependence.pool.map_or(0, |pool| pool.drivers), 2.0);
        let trips = normals(TRUCKS * TRIPS, 5.0);
        let lengths = normals(TRUCKS * TRIPS, 0.3);
        let trip = |cycle_id: u64| {
            let (truck, trip) = (cycle_id / TRIPS, cycle_id % TRIPS);
            let driver =
                dependence.pool.map_or(0.0, |pool| drivers[pool.driver_of(truck, trip) as usize]);
            let day = if dependence.shares_days { days[trip as usize] } else { 0.0 };
            let litres = 30.0 + trucks[truck as usize] + driver + day + trips[cycle_id as usize];
            let km = libm::exp(lengths[cycle_id as usize]);
            Record {
                cycle_id,
                distance_m: 1000.0 * km,
                duration_s: 60.0 * km,
                co2_g_per_km: Some(26.0 * litres),
                ..Record::default().with(Carrier::LiquidFuel, [None, Some(litres), None])
            }
        };
        (0..TRUCKS * TRIPS).map(trip).collect()
    }

    fn summary(records: &[Record], dependence: Dependence) -> Summary {
        let mut fleet = SummaryBuilder::new(dependence);
        fleet.add(records);
        fleet.finish()
    }

    fn holds(ci95: Option<[f64; 2]>, truth: f64) -> usize {
        let [low, high] = ci95.expect("two clusters of each way");
        usize::from(low <= truth && truth <= high)
    }

    /// Shares of fleets whose intervals hold the truth: mean, by trucks alone, P95, annual mean,
    /// median of truck-years, another fleet's year.
    fn coverage(pool: Option<u64>, shares_days: bool, sd: f64) -> [f64; 6] {
        const RUNS: u64 = 1000;
        let p95 = 30.0 + 1.644_853_627 * libm::sqrt(1.5 * 1.5 + sd * sd + 25.0);
        let mut covered = [0; 6];
        let mut before: Option<f64> = None;
        for seed in 0..RUNS {
            let dependence = dependence(pool.map(|drivers| Pool { seed, drivers }), shares_days);
            let records = fleet(seed, dependence);
            let summed = summary(&records, dependence);
            let alone = Dependence { pool: None, shares_days: false, ..dependence };
            let litres = quantity(LITRES).expect("known");
            let totals = records.iter().map(|record| {
                let (y, x) = litres.totals(record).expect("fuel");
                (record.cycle_id, y, x)
            });
            let alone = Clusters::from(alone).ratio(totals).expect("trips");
            let own = summed.consumption().expect("fuel");
            let trucks = summed.trucks.as_ref().expect("trucks");
            let annual = &trucks.truck_years[0];
            let Total { total, prediction95 } = trucks.totals.co2_kg.expect("fuel");
            let now = [
                holds(own.ci95, 30.0),
                holds(alone.ci95, 30.0),
                holds(own.quantiles[4].ci95, p95),
                holds(annual.ci95, 30.0),
                holds(annual.quantiles[2].ci95, 30.0),
                // the fleet of the seed before is another one
                before.map_or(1, |other| holds(prediction95, other)),
            ];
            before = Some(total);
            for (sum, one) in covered.iter_mut().zip(now) {
                *sum += one;
            }
        }
        assert_share("mean", covered[0], RUNS as usize, 0.95);
        covered.map(|count| count as f64 / RUNS as f64)
    }

    fn assert_near(shares: [f64; 6]) {
        let [mean, alone, p95, annual, median, year] = shares;
        assert!(alone < 0.75, "by trucks alone {alone}");
        for (name, share) in [("mean", mean), ("P95", p95), ("annual", annual), ("year", year)] {
            assert!((0.93..=0.97).contains(&share), "{name} {share}: {shares:?}");
        }
        // order statistics of 60 trucks are rounded outwards
        assert!((0.93..=0.985).contains(&median), "median {median}");
    }

    #[test]
    fn trucks_that_share_drivers_of_a_pool() {
        assert_near(coverage(Some(30), false, 2.0));
    }

    #[test]
    fn trucks_that_share_days() {
        assert_near(coverage(None, true, 2.0));
    }

    #[test]
    fn trucks_that_share_drivers_and_days() {
        assert_near(coverage(Some(30), true, libm::sqrt(8.0)));
    }

    #[test]
    fn a_small_case_by_hand() {
        // truck 0 on days 0 and 1, truck 1 on the same two days
        let days = Some(OperatingDays { per_week: 7, trips: 1, departure_interval_s: 0.0 });
        let two = Dependence {
            batch: 2,
            trips_per_truck: 2,
            days,
            shares_days: true,
            ..Dependence::default()
        };
        let rows = [(0, 3.0, 1.0), (1, 5.0, 1.0), (2, 1.0, 1.0), (3, 3.0, 1.0)];
        let clusters = Clusters::of(two, rows.iter().map(|(id, ..)| *id));
        let estimate = clusters.ratio(rows.iter().copied()).expect("four trips");
        // R = 3, u = 0, 1/2, -1/2, 0: trucks 2 (1/4 + 1/4), days the same, trips 4/3 (1/4 + 1/4):
        // V = 1 + 1 - 2/3 = 4/3; ν = (16/9)/(1 + 1) = 0.89, at least 1
        assert_eq!(estimate.ratio, 3.0);
        let [low, high] = estimate.ci95.expect("two of each");
        let half_width = 12.706_204_736 * libm::sqrt(4.0 / 3.0);
        assert!((high - 3.0 - half_width).abs() < 1e-6 && (low + high - 6.0).abs() < 1e-12);
        // on one day alone nothing tells how days differ
        let one_day = rows.iter().copied().step_by(2);
        assert_eq!(clusters.ratio(one_day).expect("two trips").ci95, None);
    }

    #[test]
    fn what_is_shared_by_nothing_is_as_before() {
        let apart = dependence(None, false);
        let records = fleet(1, apart);
        let rows = records.iter().map(|record| (record.cycle_id, record.duration_s, 1.0));
        let clusters = Clusters::of(apart, records.iter().map(|record| record.cycle_id));
        let totals = apart.batch_totals(rows.clone());
        assert_eq!(clusters.ratio(rows), Ratio::estimate(totals.into_iter()));
    }
}

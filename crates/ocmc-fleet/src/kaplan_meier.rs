//! The share that survives, from observations of which some were cut off before the event: the
//! product-limit estimator of Kaplan and Meier.
//!
//! With Y_j observations at risk at the event distance x_j and d_j events there, h_j = d_j / Y_j,
//! S(x) = Π_{x_j ≤ x} (1 − h_j). Observation i moves ln S(x) by
//!
//! ψ_i(x) = − Σ_{x_j ≤ x} (dN_ij − Y_ij h_j) / (Y_j (1 − h_j)),
//!
//! N its event and Y whether it is at risk. Observations of one cluster (the trips of a truck) are
//! summed: Var ln S = C/(C − 1) Σ_c (Σ_{i ∈ c} ψ_i)². With C clusters of one observation each, Σ
//! ψ_i² is Greenwood's sum Σ d_j / (Y_j (Y_j − d_j)).
//!
//! Intervals are those of a binomial law with as many observations as would give S its variance,
//! n = (1 − S) / (S Var ln S), fewer by (t₀.₉₇₅(N−1) / t₀.₉₇₅(C−1))² where C clusters say less of
//! the variance than N observations: exact where nothing is cut off and nothing depends on another,
//! and right at the ends, where few events are. Before the first event n is what is at risk there,
//! where all is gone what it was before. A quantile's interval holds the distances at which that of
//! S holds the level: of a sample that nothing cuts off it is that of its order statistics, and a
//! side that none of them bounds is open.
//!
//! Sources: E. L. Kaplan, P. Meier, *Nonparametric Estimation from Incomplete Observations*, J. Am.
//! Stat. Assoc. 53 (1958); J. P. Klein, M. L. Moeschberger, *Survival Analysis*, 2nd ed. (2003),
//! sections 4.2, 4.3 and 4.5 \[PK\]; E. L. Korn, B. I. Graubard, *Confidence Intervals for
//! Proportions with Small Expected Number of Positive Counts*, Survey Methodology 24 (1998) \[PK\].

use super::quantile::{TAIL, binomial_tails};
use super::ratio::student_975;

/// One observation: how far it was followed, and whether the event ended it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// Cluster of observations that belong together.
    pub cluster: u64,
    /// Distance, in m.
    pub distance_m: f64,
    /// Whether the event was there, not the end of what is known.
    pub event: bool,
}

/// A distance with events.
#[derive(Clone, Copy, Debug)]
struct EventPoint {
    distance_m: f64,
    /// ln S after it; without end where nothing is left.
    log_share: f64,
    /// Y.
    at_risk: f64,
    /// 1 / (Y (1 − h)).
    weight: f64,
    /// Σ h / (Y (1 − h)) up to and with it.
    compensator: f64,
}

/// The share that is left beyond each distance.
#[derive(Clone, Debug)]
pub struct Survival {
    /// By cluster.
    observations: Vec<Observation>,
    points: Vec<EventPoint>,
    clusters: f64,
    /// The farthest that anything was followed, in m.
    last_m: f64,
}

impl Survival {
    /// Survival from at least one observation; none of none.
    pub fn new(mut observations: Vec<Observation>) -> Option<Self> {
        // events first where others are cut off at the same distance
        observations
            .sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m).then(b.event.cmp(&a.event)));
        let last_m = observations.last()?.distance_m;
        let mut points: Vec<EventPoint> = Vec::new();
        let (mut log_share, mut compensator, mut k) = (0.0, 0.0, 0);
        while k < observations.len() {
            let distance_m = observations[k].distance_m;
            let here = observations[k..].iter().take_while(|o| o.distance_m == distance_m);
            let (n, events) = here.fold((0, 0), |(n, e), o| (n + 1, e + usize::from(o.event)));
            if events > 0 {
                let (at_risk, events) = ((observations.len() - k) as f64, events as f64);
                let hazard = events / at_risk;
                log_share += libm::log1p(-hazard);
                let weight = 1.0 / (at_risk - events);
                compensator += hazard * weight;
                points.push(EventPoint { distance_m, log_share, at_risk, weight, compensator });
            }
            k += n;
        }
        observations.sort_by_key(|observation| observation.cluster);
        let clusters = observations.chunk_by(|a, b| a.cluster == b.cluster).count() as f64;
        Some(Self { observations, points, clusters, last_m })
    }

    /// The last point at or before a distance.
    fn point(&self, distance_m: f64) -> Option<&EventPoint> {
        let after = self.points.partition_point(|point| point.distance_m <= distance_m);
        self.points[..after].last()
    }

    /// The share that is left beyond a distance, in m; none beyond the last observation where some
    /// are left then, as nothing is known there.
    pub fn share(&self, distance_m: f64) -> Option<f64> {
        let share = self.point(distance_m).map_or(1.0, |point| libm::exp(point.log_share));
        (share == 0.0 || distance_m <= self.last_m).then_some(share)
    }

    /// Its 95 % interval.
    pub fn ci95(&self, distance_m: f64) -> Option<[f64; 2]> {
        self.share(distance_m)?;
        let (n, gone) = self.counted(self.event_place(distance_m), distance_m);
        // the shares of which so many gone are as few, or as many, as one of forty times
        let end = |tail: usize| {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..HALVINGS {
                let gone_share = 0.5 * (low + high);
                let is_above = binomial_tails(n, gone_share, gone)[tail] < TAIL;
                let bound = if is_above == (tail == 0) { &mut high } else { &mut low };
                *bound = gone_share;
            }
            1.0 - 0.5 * (low + high)
        };
        let low = if gone == n { 0.0 } else { end(0) };
        let high = if gone == 0 { 1.0 } else { end(1) };
        Some([low, high])
    }

    /// Place of the last point at or before a distance.
    fn event_place(&self, distance_m: f64) -> Option<usize> {
        self.points.partition_point(|point| point.distance_m <= distance_m).checked_sub(1)
    }

    /// Numbers of observations and of events among them that say as much of the share at a distance
    /// behind a point.
    fn counted(&self, place: Option<usize>, distance_m: f64) -> (usize, usize) {
        let observations = self.observations.len() as f64;
        let by_cluster = self.clusters / observations;
        let Some(place) = place else {
            let at_risk = self.observations.iter().filter(|o| o.distance_m >= distance_m).count();
            return (libm::floor(at_risk as f64 * by_cluster).max(1.0) as usize, 0);
        };
        let point = &self.points[place];
        if point.log_share == f64::NEG_INFINITY {
            let before = place.checked_sub(1).and_then(|k| self.worth(&self.points[k]));
            let n = before.unwrap_or(point.at_risk * by_cluster).max(1.0);
            return (libm::round(n) as usize, libm::round(n) as usize);
        }
        let n = self.worth(point).unwrap_or(1.0);
        let gone = libm::round(n * -libm::expm1(point.log_share));
        (libm::round(n) as usize, gone as usize)
    }

    /// Number of independent observations that would give the share behind a point its variance.
    fn worth(&self, point: &EventPoint) -> Option<f64> {
        let observations = self.observations.len() as f64;
        let error = self.standard_error(point.distance_m)?;
        let (gone, left) = (-libm::expm1(point.log_share), libm::exp(point.log_share));
        // of single observations Greenwood's sum is that of the binomial law
        let single = (observations - 1.0) / observations;
        let known = student_975(observations - 1.0) / student_975(self.clusters - 1.0);
        let worth = gone / (left * error * error * single) * known * known;
        Some(worth.clamp(1.0, observations))
    }

    /// Standard error of ln S.
    fn standard_error(&self, distance_m: f64) -> Option<f64> {
        let finite = self.point(distance_m).is_some_and(|point| point.log_share.is_finite());
        if !finite || self.clusters < 2.0 {
            return None;
        }
        let influence = |observation: &Observation| {
            let until_m = observation.distance_m.min(distance_m);
            let Some(point) = self.point(until_m) else { return 0.0 };
            let happened = observation.event && observation.distance_m <= distance_m;
            point.compensator - if happened { point.weight } else { 0.0 }
        };
        let clusters = self.observations.chunk_by(|a, b| a.cluster == b.cluster);
        let squares: f64 = clusters
            .map(|cluster| {
                let sum: f64 = cluster.iter().map(influence).sum();
                sum * sum
            })
            .sum();
        Some(libm::sqrt(squares * self.clusters / (self.clusters - 1.0)))
    }

    /// The distance, in m, up to which a share of all is left: the first at which no more are; none
    /// where more are left at the end of what is known.
    pub fn quantile(&self, share: f64) -> Option<f64> {
        self.first(|k, _| libm::exp(self.points[k].log_share) <= share + ROUNDING)
    }

    /// Its 95 % interval; either end is none where no observation bounds it.
    pub fn quantile_ci95(&self, share: f64) -> [Option<f64>; 2] {
        let few = |place: Option<usize>, distance_m: f64| {
            let (n, gone) = self.counted(place, distance_m);
            binomial_tails(n, 1.0 - share, gone).map(|tail| tail > TAIL)
        };
        let first_m = self.points.first().map_or(self.last_m, |point| point.distance_m);
        let is_open = few(None, first_m)[0];
        let low = if is_open { None } else { self.first(|k, at_m| few(Some(k), at_m)[0]) };
        [low, self.first(|k, at_m| !few(Some(k), at_m)[1])]
    }

    /// Distance of the first point from which on something holds, found by halving.
    fn first(&self, holds: impl Fn(usize, f64) -> bool) -> Option<f64> {
        let (mut low, mut high) = (0, self.points.len());
        while low < high {
            let middle = usize::midpoint(low, high);
            let point = &self.points[middle];
            if holds(middle, point.distance_m) { high = middle } else { low = middle + 1 }
        }
        self.points.get(low).map(|point| point.distance_m)
    }
}

/// Difference of shares that is rounding.
const ROUNDING: f64 = 1e-12;
/// Steps in which an end of an interval is found.
const HALVINGS: u32 = 50;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantile::interval;
    use ocmc_core::random::{Stream, Streams};

    fn observations(all: &[(f64, bool)]) -> Vec<Observation> {
        let observation = |(k, (distance_m, event)): (usize, &(f64, bool))| Observation {
            cluster: k as u64,
            distance_m: *distance_m,
            event: *event,
        };
        all.iter().enumerate().map(observation).collect()
    }

    #[test]
    fn a_textbook_case_by_hand() {
        // at risk 6, 4, 3, 1: S = 5/6, 5/6 × 3/4, × 2/3, 0
        let all = [(1.0, true), (2.0, false), (3.0, true), (4.0, true), (4.0, false), (5.0, true)];
        let survival = Survival::new(observations(&all)).expect("six");
        for (at, share) in [
            (0.5, 1.0),
            (1.0, 5.0 / 6.0),
            (2.9, 5.0 / 6.0),
            (3.0, 0.625),
            (4.5, 0.625 * 2.0 / 3.0),
            (5.0, 0.0),
        ] {
            assert!((survival.share(at).expect("known") - share).abs() < 1e-14, "{at}");
        }
        assert_eq!(survival.quantile(0.5), Some(4.0));
        assert_eq!(survival.quantile(0.0), Some(5.0));
        // Greenwood: 1/(6 × 5) + 1/(4 × 3) + 1/(3 × 2), with C/(C − 1)
        let greenwood = 1.0 / 30.0 + 1.0 / 12.0 + 1.0 / 6.0;
        let error = survival.standard_error(4.0).expect("events");
        assert!((error * error - greenwood * 6.0 / 5.0).abs() < 1e-14);
        // nothing gone of six, and all: 1 − 0.025^(1/6) may still be gone
        let bound = libm::pow(0.025, 1.0 / 6.0);
        let [before, behind] = [0.5, 5.0].map(|at| survival.ci95(at).expect("known"));
        assert!((before[0] - bound).abs() < 1e-9 && before[1] == 1.0, "{before:?}");
        assert!(behind[0] == 0.0 && behind[1] > 0.4, "{behind:?}");
        // whose trip ends at a distance was followed up to there
        let arrived = Survival::new(observations(&[(7.0, false); 6])).expect("six");
        assert!((arrived.ci95(7.0).expect("known")[0] - bound).abs() < 1e-9);
        assert_eq!(arrived.quantile_ci95(0.5), [None, None]);
        assert!(Survival::new(Vec::new()).is_none());
    }

    #[test]
    fn what_is_not_known_is_not_said() {
        let survival = Survival::new(observations(&[(1.0, true), (3.0, false), (3.0, false)]));
        let survival = survival.expect("three");
        assert!((survival.share(3.0).expect("known") - 2.0 / 3.0).abs() < 1e-14);
        assert_eq!((survival.share(3.1), survival.quantile(0.5)), (None, None));
        assert_eq!(survival.quantile_ci95(0.5)[1], None);
    }

    #[test]
    fn without_cutting_off_intervals_are_those_of_order_statistics_and_open_where_they_are() {
        for n in [1, 5, 20, 50, 72, 368, 1000] {
            let all: Vec<(f64, bool)> = (1..=n).map(|k| (f64::from(k), true)).collect();
            let sorted: Vec<f64> = all.iter().map(|(at, _)| *at).collect();
            let survival = Survival::new(observations(&all)).expect("some");
            for share in [0.99, 0.95, 0.5, 0.05] {
                let ci95 = survival.quantile_ci95(share);
                // ranks l and u of the binomial law, each on its own
                let count = n as usize;
                let ranks = 1..=count;
                let tails = |k: usize| binomial_tails(count, 1.0 - share, k);
                let low = ranks.clone().rev().find(|l| tails(l - 1)[0] <= TAIL);
                let high = ranks.clone().find(|u| tails(*u)[1] <= TAIL);
                let said = [low, high].map(|rank| rank.map(|rank| rank as f64));
                assert_eq!(ci95, said, "{n} {share}");
                if let Some([low, high]) = interval(&sorted, 1.0 - share) {
                    assert_eq!(ci95, [Some(low), Some(high)], "{n} {share}");
                }
            }
        }
    }

    /// Trips of lengths that have nothing to do with the range: 300 samples of each size.
    #[test]
    fn intervals_of_all_arriving_shares_cover_in_small_samples() {
        use crate::range::ARRIVING;
        let (runs, sizes) = (300, [20_u64, 50, 100, 200, 400, 1000]);
        let (mut covered, mut all_rows) = (0, 0);
        for (place, size) in sizes.into_iter().enumerate() {
            let mut rows = [0; ARRIVING.len()];
            for run in 0..runs {
                let draw = |k: u64| {
                    let streams = Streams::new(11 + place as u64, run * 1000 + k);
                    let mut draws = streams.open(Stream::Payload);
                    let range_m = 300.0 * libm::exp(0.15 * draws.normal());
                    let length_m = 350.0 + 400.0 * draws.uniform();
                    (range_m.min(length_m), range_m <= length_m)
                };
                let all: Vec<(f64, bool)> = (0..size).map(draw).collect();
                let survival = Survival::new(observations(&all)).expect("many");
                for (row, share) in rows.iter_mut().zip(ARRIVING) {
                    let truth_m = 300.0
                        * libm::exp(
                            0.15 * ocmc_core::special_functions::normal_quantile(1.0 - share),
                        );
                    let [low, high] = survival.quantile_ci95(share);
                    let holds =
                        low.is_none_or(|l| l <= truth_m) && high.is_none_or(|h| truth_m <= h);
                    *row += u32::from(holds);
                }
            }
            for (row, share) in rows.iter().zip(ARRIVING) {
                let covers = f64::from(*row) / runs as f64;
                assert!(covers >= 0.909, "{size} trips, {share}: {covers}");
            }
            covered += rows.iter().sum::<u32>();
            all_rows += runs as u32 * rows.len() as u32;
        }
        assert!(f64::from(covered) >= 0.94 * f64::from(all_rows), "{covered} of {all_rows}");
    }

    #[test]
    fn without_cutting_off_it_is_the_empirical_share() {
        let all: Vec<(f64, bool)> = (0..200).map(|k| (f64::from((k * 37) % 200), true)).collect();
        let survival = Survival::new(observations(&all)).expect("many");
        for at in [0.0, 49.5, 150.0, 198.0] {
            let share = all.iter().filter(|(d, _)| *d > at).count() as f64 / 200.0;
            assert!((survival.share(at).expect("known") - share).abs() < 1e-12, "{at}");
        }
    }

    /// 1000 runs of 60 clusters of 4 trips that share a part, cut off by trip lengths that have
    /// nothing to do with it: the intervals of shares and of the median cover.
    #[test]
    fn intervals_cover_with_clusters_and_with_trips_cut_off() {
        let (runs, trucks, trips) = (1000, 60, 4);
        let truth_m = 300.0;
        let (mut shares, mut medians, mut naive) = (0_usize, 0_usize, 0_usize);
        for run in 0..runs {
            let mut all = Vec::new();
            for truck in 0..trucks {
                let streams = Streams::new(7, run * trucks + truck);
                let mut draws = streams.open(Stream::Payload);
                let own = 0.15 * draws.normal();
                for _ in 0..trips {
                    let range_m = truth_m * libm::exp(own + 0.15 * draws.normal());
                    let length_m = 500.0 * draws.uniform() + 100.0;
                    all.push(Observation {
                        cluster: truck,
                        distance_m: range_m.min(length_m),
                        event: range_m <= length_m,
                    });
                }
            }
            let survival = Survival::new(all.clone()).expect("many");
            let holds = |survival: &Survival| {
                let [low, high] = survival.ci95(truth_m).expect("events");
                usize::from(low <= 0.5 && 0.5 <= high)
            };
            shares += holds(&survival);
            let [low, high] = survival.quantile_ci95(0.5);
            medians +=
                usize::from(low.is_none_or(|l| l <= truth_m) && high.is_none_or(|h| truth_m <= h));
            for (k, observation) in all.iter_mut().enumerate() {
                observation.cluster = k as u64;
            }
            naive += holds(&Survival::new(all).expect("many"));
        }
        assert!((930..=970).contains(&shares), "{shares} of 1000 cover the share");
        assert!((930..=970).contains(&medians), "{medians} of 1000 cover the median");
        assert!(naive < 920, "taken for independent, {naive} of 1000 cover");
    }
}

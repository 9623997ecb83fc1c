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
//! ψ_i² is Greenwood's sum Σ d_j / (Y_j (Y_j − d_j)). Intervals are those of ln(−ln S), so that
//! they stay within 0 and 1. A quantile's interval holds the distances at which that of S holds the
//! level. Sources: E. L. Kaplan, P. Meier, *Nonparametric Estimation from Incomplete Observations*,
//! J. Am. Stat. Assoc. 53 (1958); J. P. Klein, M. L. Moeschberger, *Survival Analysis*, 2nd ed.
//! (2003), sections 4.2, 4.3 and 4.5 \[PK\].

use super::ratio::student_975;

/// One observation: how far it was followed, and whether the event ended it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// Which observations belong together.
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
    /// Of at least one observation; none of none.
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
                points.push(EventPoint { distance_m, log_share, weight, compensator });
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

    /// Its 95 % interval; none where nothing has happened yet, or nothing is left.
    pub fn ci95(&self, distance_m: f64) -> Option<[f64; 2]> {
        self.share(distance_m)?;
        let log_share = self.point(distance_m)?.log_share;
        let error = self.standard_error(distance_m)?;
        let far = student_975(self.clusters - 1.0) * error / -log_share;
        Some([far, -far].map(|far| libm::exp(log_share * libm::exp(far))))
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
        self.first(|point| libm::exp(point.log_share) <= share + ROUNDING)
    }

    /// Its 95 % interval; either end is none where what is known ends before it.
    pub fn quantile_ci95(&self, share: f64) -> [Option<f64>; 2] {
        [1, 0].map(|end| {
            let beyond = |point: &EventPoint| match self.ci95(point.distance_m) {
                Some(interval) => interval[1 - end] <= share,
                None => point.log_share == f64::NEG_INFINITY,
            };
            self.first(beyond)
        })
    }

    /// Distance of the first point from which on something holds, found by halving.
    fn first(&self, holds: impl Fn(&EventPoint) -> bool) -> Option<f64> {
        let place = self.points.partition_point(|point| !holds(point));
        self.points.get(place).map(|point| point.distance_m)
    }
}

/// Difference of shares that is rounding.
const ROUNDING: f64 = 1e-12;

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Stream, Streams};

    fn observations(all: &[(f64, bool)]) -> Vec<Observation> {
        let of = |(k, (distance_m, event)): (usize, &(f64, bool))| Observation {
            cluster: k as u64,
            distance_m: *distance_m,
            event: *event,
        };
        all.iter().enumerate().map(of).collect()
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
        assert_eq!((survival.ci95(0.5), survival.ci95(5.0)), (None, None));
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

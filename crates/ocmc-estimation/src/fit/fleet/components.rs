//! The standard deviations between trucks, between drivers and between trips: where the restricted
//! likelihood is largest, their errors and intervals.
//!
//! Errors are those of the observed information of the logarithms of the SDs that are not 0. The
//! interval of an SD between levels is that of its profile likelihood, all others at their best
//! ([`sd_interval`]); where that has no upper end, or would take too long, it is the estimate times
//! exp(±1.96 of the logarithm's error). The interval of the trips' SD is that of χ².
//!
//! Source: S. R. Searle, G. Casella, C. E. McCulloch, Variance Components (1992), chapter 6 \[PK\].

use super::trips::{FleetDesign, Trips};
use crate::fit::descent::{descend, differences};
use crate::fit::p_value::{self, NORMAL_975};
use crate::fit::profile_interval::sd_interval;
use nalgebra::DMatrix;
use serde::Serialize;

/// Improvement that a search has to promise to go on, in −2 l.
const TOLERANCE: f64 = 1e-11;
/// As [`TOLERANCE`], for a point of a profile.
const PROFILE_TOLERANCE: f64 = 1e-6;
/// An effect that lowers −2 l by no more than this is none: what a sum of logarithms rounds off.
const NO_GAIN: f64 = 1e-8;
/// Distance of the differences of the information.
const STEP: f64 = 1e-3;
/// The ratio of a level that was at 0 where it begins to be searched anew.
const SMALL_RATIO: f64 = 0.1;
/// Most operations in dense matrices of one evaluation for intervals by profile and for a second
/// start: some milliseconds.
const MOST_PROFILE_WORK: f64 = 3e6;
/// A ratio above which trips do not differ but by rounding.
const MOST_RATIO: f64 = 1e5;

/// How an interval was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum IntervalKind {
    /// By the profile of the restricted likelihood.
    ProfileLikelihood,
    /// By the error of the logarithm.
    WaldOfLogarithm,
    /// By the χ² law of a sum of squares.
    ChiSquare,
}

/// The standard deviation of a level.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VarianceComponent {
    /// `truck`, `driver`, `truck_and_driver` or `trip`.
    pub level: &'static str,
    /// Trucks, drivers or trips.
    pub groups: usize,
    /// Standard deviation; 0 where the level's members differ by no more than by chance.
    pub sd: f64,
    /// Standard error of the SD; none where it is 0.
    pub standard_error: Option<f64>,
    /// 95 % interval; its upper end is infinite where nothing bounds it.
    pub ci95: Option<[f64; 2]>,
    /// How that was found.
    pub ci95_by: Option<IntervalKind>,
    /// The SD over the mean; none where the mean is 0.
    pub relative: Option<f64>,
    /// Share of the variance of a trip.
    pub share: f64,
}

/// The estimated SDs.
pub(crate) struct Components {
    /// SDs of trucks, drivers and trips; 0 for a level that there is not.
    pub(crate) sd: [f64; 3],
    /// Components that are estimated and not 0.
    pub(crate) free: Vec<usize>,
    /// Covariance of the logarithms of these; none where the likelihood does not bend.
    pub(crate) log_covariance: Option<DMatrix<f64>>,
    /// Minus twice the restricted log-likelihood.
    pub(crate) criterion: f64,
}

/// SDs with those named by `free` at `exp` of the given logarithms.
fn with(sd: [f64; 3], free: &[usize], logs: &[f64]) -> [f64; 3] {
    let mut sd = sd;
    for (place, log) in free.iter().zip(logs) {
        sd[*place] = libm::exp(*log);
    }
    sd
}

/// The best ratio of one family, the other one without effect; 0 where that is as good.
fn alone(trips: &Trips, family: usize) -> (f64, f64) {
    let theta = |log: f64| {
        let mut theta = [0.0; 2];
        theta[family] = log;
        theta
    };
    let at = |logs: &[f64]| trips.criterion(theta(libm::exp(logs[0])));
    let minima = [-2.5, 0.5].map(|start| descend(&at, &[start], TOLERANCE));
    let best = if minima[0].1 <= minima[1].1 { &minima[0] } else { &minima[1] };
    let none = trips.criterion([0.0; 2]);
    if none <= best.1 + NO_GAIN { (0.0, none) } else { (libm::exp(best.0[0]), best.1) }
}

/// The ratios with the largest likelihood, and −2 l there.
pub(crate) fn best_ratios(trips: &Trips) -> ([f64; 2], f64) {
    let (truck, by_truck) = alone(trips, 0);
    if trips.families[1].len() == 0 {
        return ([truck, 0.0], by_truck);
    }
    let (driver, by_driver) = alone(trips, 1);
    let at = |logs: &[f64]| trips.criterion([libm::exp(logs[0]), libm::exp(logs[1])]);
    let near = [truck, driver].map(|ratio| libm::log(0.8 * ratio.max(SMALL_RATIO)));
    let mut best = descend(&at, &near, TOLERANCE);
    // a second start, where it is not dear
    if trips.dense_work() <= MOST_PROFILE_WORK {
        let other = descend(&at, &[-1.5, -1.5], TOLERANCE);
        if other.1 < best.1 {
            best = other;
        }
    }
    let both = ([libm::exp(best.0[0]), libm::exp(best.0[1])], best.1);
    // with fewer effects where they say as much
    let candidates = [([truck, 0.0], by_truck), ([0.0, driver], by_driver)];
    let fewer = if by_truck <= by_driver { candidates[0] } else { candidates[1] };
    if fewer.1 <= both.1 + NO_GAIN { fewer } else { both }
}

/// The level's gain in −2 l over no effect of it, all else at its best, and the probability of as
/// much by chance: half of χ²₁ lies at 0, as an SD has no sign.
///
/// Source: S. G. Self, K.-Y. Liang, Journal of the American Statistical Association 82 (1987)
/// 605-610, case 5 \[PK\].
pub(crate) fn test_of(trips: &Trips, family: usize) -> (f64, f64) {
    let (_, with) = best_ratios(trips);
    let other = 1 - family;
    let without = match trips.families[other].len() {
        0 => trips.criterion([0.0; 2]),
        _ => alone(trips, other).1,
    };
    let gain = (without - with).max(0.0);
    let p = if gain > NO_GAIN { 1.0 - p_value::normal_probability(libm::sqrt(gain)) } else { 1.0 };
    (gain, p)
}

impl Components {
    /// By restricted maximum likelihood; none where a fixed effect is not determined, or where
    /// trucks and drivers leave nothing to the trips.
    pub(crate) fn estimate(trips: &Trips) -> Option<Self> {
        let (theta, criterion) = best_ratios(trips);
        let trip = trips.trip_sd(theta)?;
        if theta[0].max(theta[1]) > MOST_RATIO {
            return None;
        }
        let sd = [theta[0] * trip, theta[1] * trip, trip];
        let free: Vec<usize> = (0..3).filter(|place| sd[*place] > 0.0).collect();
        let logs: Vec<f64> = free.iter().map(|place| libm::log(sd[*place])).collect();
        let at = |logs: &[f64]| trips.deviance(with(sd, &free, logs));
        let (_, hessian) = differences(&at, &logs, at(&logs), STEP);
        // the information is half the Hessian of −2 l
        let covariance = hessian.cholesky().map(|factor| 2.0 * factor.inverse());
        criterion.is_finite().then_some(Self { sd, free, log_covariance: covariance, criterion })
    }

    /// Standard error of the logarithm of an SD.
    fn log_error(&self, place: usize) -> Option<f64> {
        let at = self.free.iter().position(|free| *free == place)?;
        Some(libm::sqrt(self.log_covariance.as_ref()?[(at, at)]))
    }

    /// The components as they are told; `mean` is that of the trips.
    pub(crate) fn told(&self, trips: &Trips, mean: f64) -> Vec<VarianceComponent> {
        let whole: f64 = self.sd.iter().map(|sd| sd * sd).sum();
        let together = trips.design == FleetDesign::TruckAndDriver;
        let places = if trips.families[1].len() == 0 { vec![0, 2] } else { vec![0, 1, 2] };
        let one = |place: usize| {
            let sd = self.sd[place];
            let log_error = self.log_error(place);
            let interval = match place {
                2 => {
                    let interval = p_value::sd_interval(sd, trips.residual_df as f64, 0.95);
                    interval.map(|interval| (interval, IntervalKind::ChiSquare))
                }
                _ => self.interval(trips, place, log_error),
            };
            VarianceComponent {
                level: match place {
                    0 if together => "truck_and_driver",
                    0 => "truck",
                    1 => "driver",
                    _ => "trip",
                },
                groups: if place == 2 { trips.n } else { trips.families[place].len() },
                sd,
                standard_error: log_error.map(|error| sd * error),
                ci95: interval.map(|(interval, _)| interval),
                ci95_by: interval.map(|(_, kind)| kind),
                relative: (mean != 0.0).then(|| sd / mean.abs()),
                share: sd * sd / whole,
            }
        };
        places.into_iter().map(one).collect()
    }

    /// The interval of the SD of a level.
    fn interval(
        &self,
        trips: &Trips,
        place: usize,
        log_error: Option<f64>,
    ) -> Option<([f64; 2], IntervalKind)> {
        let wald = log_error.map(|error| {
            let reach = libm::exp(NORMAL_975 * error);
            ([self.sd[place] / reach, self.sd[place] * reach], IntervalKind::WaldOfLogarithm)
        });
        if trips.dense_work() > MOST_PROFILE_WORK {
            return wald;
        }
        let others: Vec<usize> = (0..3)
            .filter(|other| *other != place && (*other == 2 || trips.families[*other].len() > 0))
            .collect();
        let start: Vec<f64> = others
            .iter()
            .map(|other| libm::log(self.sd[*other].max(SMALL_RATIO * self.sd[2])))
            .collect();
        let profile = |sd: f64| {
            let mut at = self.sd;
            at[place] = sd;
            descend(
                &|logs: &[f64]| trips.deviance(with(at, &others, logs)),
                &start,
                PROFILE_TOLERANCE,
            )
            .1
        };
        let limits = sd_interval(self.sd[place], trips.df_between(place) + 1, profile);
        match wald {
            Some(wald) if !limits[1].is_finite() => Some(wald),
            _ => Some((limits, IntervalKind::ProfileLikelihood)),
        }
    }
}

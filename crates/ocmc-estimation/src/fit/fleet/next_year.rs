//! Prediction of the need of the same trucks next year, given this year's records.
//!
//! The mean of m further trips of a truck, by the drivers it has and in their shares, is normal
//! with the truck's and the drivers' predictions as its mean; its variance is that of the error of
//! these plus σ²/m. The SDs are estimated, so the interval is that of Student's law with
//! Satterthwaite's degrees of freedom, 2 v²/(gᵀCg): v the variance, g its gradient by the
//! logarithms of the SDs and C their covariance. What the estimated SDs add to the predictions' own
//! errors is left out.
//!
//! Source: F. G. Giesbrecht, J. C. Burns, Two-stage analysis based on a mixed model: large-sample
//! asymptotic theory and small-sample simulation results, Biometrics 41 (1985), 477-486 \[PK\].

use super::FleetOptions;
use super::components::Components;
use super::likelihood::{Combination, Posterior};
use super::trips::Trips;
use crate::fit::p_value::{NORMAL_975, around, t_of_interval};
use serde::Serialize;

/// Distance of the differences of a variance by the logarithms of the SDs.
const STEP: f64 = 1e-3;
/// Degrees of freedom from which on Student's law is the normal one.
const NORMAL_DF: f64 = 1e4;

/// A mean that is expected, with its interval.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Expected {
    /// Name of the truck or driver; empty of the fleet and of a new truck.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub label: String,
    /// Trips of which it is the mean.
    pub trips: u64,
    /// The mean.
    pub mean: f64,
    /// SD of its error.
    pub sd: f64,
    /// Degrees of freedom of the interval; none where it is normal.
    pub df: Option<f64>,
    /// 95 % prediction interval.
    pub ci95: [f64; 2],
}

/// Expectation of the next year.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NextYear {
    /// The mean of all trips of these trucks.
    pub fleet: Expected,
    /// The mean of the trips of a truck that is not in the records, with a driver who is not.
    pub new_truck: Expected,
    /// Each truck of the records.
    pub trucks: Vec<Expected>,
}

/// A linear combination of effects, and the variance of what is to come on top of it.
struct Question {
    fixed: Vec<f64>,
    terms: Vec<(usize, usize, f64)>,
    /// Variance over σ² of the trips that are to come.
    trip: f64,
    /// Whether a new truck and a new driver are added.
    new: bool,
}

impl Question {
    fn answer(&self, posterior: &Posterior, sd: [f64; 3]) -> Combination {
        let known = posterior.combine(&self.fixed, &self.terms);
        let new = if self.new { sd[0] * sd[0] + sd[1] * sd[1] } else { 0.0 };
        let variance = known.variance + sd[2] * sd[2] * self.trip + new;
        Combination { variance, ..known }
    }
}

/// Posteriors at the estimate, and at either side of it by each SD that is not 0.
pub(crate) struct Around<'a> {
    components: &'a Components,
    pub(crate) centre: Posterior<'a>,
    sides: Vec<[([f64; 3], Posterior<'a>); 2]>,
}

impl<'a> Around<'a> {
    pub(crate) fn new(trips: &'a Trips, components: &'a Components) -> Option<Self> {
        let mut sides = Vec::new();
        if components.log_covariance.is_some() {
            for place in &components.free {
                let side = |by: f64| {
                    let mut sd = components.sd;
                    sd[*place] *= libm::exp(by);
                    Some((sd, Posterior::new(trips, sd)?))
                };
                sides.push([side(-STEP)?, side(STEP)?]);
            }
        }
        Some(Self { components, centre: Posterior::new(trips, components.sd)?, sides })
    }

    /// The answer with the degrees of freedom of its variance.
    fn answer(&self, question: &Question) -> (Combination, Option<f64>) {
        let combination = question.answer(&self.centre, self.components.sd);
        let Some(covariance) = &self.components.log_covariance else { return (combination, None) };
        let gradient: Vec<f64> = self
            .sides
            .iter()
            .map(|[low, high]| {
                let at = |(sd, posterior): &([f64; 3], Posterior)| {
                    question.answer(posterior, *sd).variance
                };
                (at(high) - at(low)) / (2.0 * STEP)
            })
            .collect();
        let mut spread = 0.0;
        for (i, a) in gradient.iter().enumerate() {
            for (j, b) in gradient.iter().enumerate() {
                spread += a * b * covariance[(i, j)];
            }
        }
        let df = 2.0 * combination.variance * combination.variance / spread;
        (combination, (df < NORMAL_DF).then(|| df.max(1.0)))
    }

    fn expected(&self, label: &str, trips: u64, question: &Question) -> Expected {
        let (combination, df) = self.answer(question);
        let sd = libm::sqrt(combination.variance);
        let t = df.map_or(NORMAL_975, |df| t_of_interval(0.95, df));
        let ci95 = around(combination.mean, sd, t);
        Expected { label: label.to_owned(), trips, mean: combination.mean, sd, df, ci95 }
    }

    /// The mean of the fleet's trips and its standard error, with the interval.
    pub(crate) fn fleet_mean(&self, trips: &Trips) -> Expected {
        let fixed = trips.mean_predictors();
        let question = Question { fixed, terms: Vec::new(), trip: 0.0, new: false };
        self.expected("", trips.n as u64, &question)
    }
}

/// Answers for the fleet and for each truck.
pub(crate) fn next_year(trips: &Trips, around: &Around, options: &FleetOptions) -> NextYear {
    let of_trucks = trips.drivers_of_trucks();
    let trucks = &trips.families[0];
    let mean_weight = |level: usize| trucks.weights[level] / trucks.trips[level] as f64;
    let count = |level: usize| options.next_trips.unwrap_or(trucks.trips[level] as u64);
    let mut whole =
        Question { fixed: vec![0.0; trips.width], terms: Vec::new(), trip: 0.0, new: false };
    let weight: f64 = (0..trucks.len()).map(|k| count(k) as f64 * mean_weight(k)).sum();
    let mut each = Vec::with_capacity(trucks.len());
    for level in 0..trucks.len() {
        let coming = count(level) as f64 * mean_weight(level);
        let mut terms = vec![(0, level, 1.0)];
        terms.extend(of_trucks[level].iter().map(|(driver, share)| (1, *driver, *share)));
        let fixed = trips.predictors(0, level);
        let part = coming / weight;
        whole.terms.extend(terms.iter().map(|(f, l, c)| (*f, *l, c * part)));
        whole.fixed.iter_mut().zip(&fixed).for_each(|(sum, x)| *sum += part * x);
        let question = Question { fixed, terms, trip: 1.0 / coming, new: false };
        each.push(around.expected(&trucks.labels[level], count(level), &question));
    }
    whole.trip = 1.0 / weight;
    let all = (0..trucks.len()).map(count).sum();
    let usual = options.next_trips.unwrap_or((trips.n as u64).div_ceil(trucks.len() as u64));
    let new = Question {
        fixed: trips.mean_predictors(),
        terms: Vec::new(),
        trip: 1.0 / usual as f64,
        new: true,
    };
    NextYear {
        fleet: around.expected("", all, &whole),
        new_truck: around.expected("", usual, &new),
        trucks: each,
    }
}

//! Slopes: their SD, and hill length by the share of steps at which the slope changes its sign, L_h
//! = 2 L_s / share.
//!
//! Slopes are those beside the road's mean slope, which takes a share d of their variance with it.
//! Of an autoregression of coefficient a over the n steps of a road of one type it is
//!
//! d = (1/n) [(1 + a)/(1 − a) − 2 a (1 − aⁿ)/(n (1 − a)²)],
//!
//! 2 % on 100 km of hills of 700 m. So the variance is σ² (1 − d), and the correlation over a step
//! (a − d)/(1 − d). Where road types take turns, d is that of the mean slope of the whole road.

use super::TypeRoads;
use crate::fit::p_value::NORMAL_975;
use crate::fit::study_parameter::Estimates;
use ocmc_core::operating_cycle::road::topography::TopographyModel;
use ocmc_fleet::ratio::Ratio;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Rounds in which the shares and the laws that they come from settle.
const ROUNDS: usize = 50;
/// Largest share that is made up for.
const MOST: f64 = 0.9;
/// Share from which on the roads are called short.
const SHORT: f64 = 0.3;

/// Slopes of one type by its roads.
struct Slopes {
    /// Sums of each road: squares, steps, changes of sign, pairs of steps.
    sums: Vec<[f64; 4]>,
    /// Mean square, and share of the steps at which the sign changes.
    mean_square: Option<Ratio>,
    changes: Option<Ratio>,
}

impl Slopes {
    fn of(roads: &TypeRoads) -> Self {
        let cycles = roads.slopes.iter().map(|(cycle, _)| cycle + 1).max().unwrap_or(0);
        let mut sums = vec![[0.0; 4]; cycles];
        for (cycle, slopes) in &roads.slopes {
            let squares: f64 = slopes.iter().map(|slope| slope * slope).sum();
            let changes = slopes.windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count();
            let pairs = slopes.len().saturating_sub(1);
            let parts = [squares, slopes.len() as f64, changes as f64, pairs as f64];
            for (sum, value) in sums[*cycle].iter_mut().zip(parts) {
                *sum += value;
            }
        }
        let ratio = |over: usize, under: usize| {
            let pairs = sums.iter().filter(|sums| sums[under] > 0.0).map(|s| (s[over], s[under]));
            Ratio::estimate(pairs)
        };
        let (mean_square, changes) = (ratio(0, 1), ratio(2, 3));
        Self { sums, mean_square, changes }
    }

    /// Steps of a road.
    fn steps(&self, road: usize) -> f64 {
        self.sums.get(road).map_or(0.0, |sums| sums[1])
    }

    /// Variance and coefficient of the autoregression, where the mean slope takes such a share.
    fn law(&self, share: f64) -> Option<(f64, f64)> {
        let (mean_square, changes) = (self.mean_square?.ratio, self.changes?.ratio);
        let seen = libm::cos(PI * changes);
        Some((mean_square / (1.0 - share), seen * (1.0 - share) + share))
    }
}

/// Variance of the mean of so many steps, as a share of that of one.
fn variance_of_mean(coefficient: f64, steps: f64) -> f64 {
    let rest = 1.0 - coefficient;
    if !(rest > 0.0 && steps > 0.0) {
        return 1.0;
    }
    let edge = 2.0 * coefficient * (1.0 - libm::pow(coefficient.max(0.0), steps));
    (((1.0 + coefficient) / rest) - edge / (steps * rest * rest)) / steps
}

/// The share of the variance of each type's slopes that the mean slope of their roads takes.
pub(super) fn shares_of_mean(roads: &BTreeMap<String, TypeRoads>) -> BTreeMap<String, f64> {
    let types: Vec<Slopes> = roads.values().map(Slopes::of).collect();
    let count = types.iter().map(|slopes| slopes.sums.len()).max().unwrap_or(0);
    let all: Vec<f64> =
        (0..count).map(|road| types.iter().map(|slopes| slopes.steps(road)).sum()).collect();
    let mut shares = vec![0.0; types.len()];
    for _ in 0..ROUNDS {
        let laws: Vec<_> = types.iter().zip(&shares).map(|(t, share)| t.law(*share)).collect();
        // of each road: the variance of its mean slope
        let of_road = |road: usize| {
            let parts = types.iter().zip(&laws).map(|(slopes, law)| {
                let (variance, coefficient) = law.unwrap_or((0.0, 0.0));
                slopes.steps(road) * variance * variance_of_mean(coefficient, all[road])
            });
            parts.sum::<f64>() / all[road]
        };
        let of_mean: Vec<f64> = (0..count).map(of_road).collect();
        for ((slopes, law), share) in types.iter().zip(&laws).zip(&mut shares) {
            let Some((variance, coefficient)) = *law else { continue };
            let (mut sum, mut steps) = (0.0, 0.0);
            for road in (0..count).filter(|road| slopes.steps(*road) > 0.0) {
                let with_own = variance_of_mean(coefficient, all[road]);
                sum += slopes.steps(road) * (2.0 * with_own - of_mean[road] / variance);
                steps += slopes.steps(road);
            }
            *share = if variance > 0.0 && steps > 0.0 { (sum / steps).min(MOST) } else { 0.0 };
        }
    }
    roads.keys().cloned().zip(shares).collect()
}

/// Steps whose slope is known.
pub(super) fn steps(roads: &TypeRoads) -> usize {
    roads.slopes.iter().map(|slopes| slopes.1.len()).sum()
}

/// SD of the slope and hill length of a type, of whose variance the mean slope takes a share. The
/// errors take roads as independent.
pub(super) fn fit_slopes(
    roads: &TypeRoads,
    step_m: f64,
    share: f64,
    model: &mut TopographyModel,
    estimates: &mut Estimates,
) {
    let slopes = Slopes::of(roads);
    let (Some(mean_square), Some(changes)) = (slopes.mean_square, slopes.changes) else {
        estimates.warn(
            "it is too short to tell about slopes, or none of them is known: they stay those of \
             the base study",
        );
        return;
    };
    let Some((variance, coefficient)) = slopes.law(share).filter(|law| law.0 > 0.0) else {
        return estimates.warn("it is flat: its slopes stay those of the base study");
    };
    let relative = |ratio: &Ratio| {
        let half = ratio.ci95.map(|[low, high]| 0.5 * (high - low));
        half.map(|half| half / NORMAL_975 / ratio.ratio)
    };
    let steps = steps(roads);
    let hill = 2.0 * PI * step_m / libm::acos(coefficient);
    let is_told = hill.is_finite() && hill > 4.0 * step_m;
    if !is_told && share > SHORT {
        // how much of the SD the mean slopes take follows from the hill length
        return estimates.warn(
            "its roads are too short for their hills: their slopes stay those of the base study",
        );
    }
    let sd = libm::sqrt(variance);
    let error = relative(&mean_square).map(|e| 0.5 * e * sd);
    estimates.set("topography.slope_sd", &mut model.slope_sd, sd, error, steps);
    if is_told {
        let error = relative(&changes).map(|e| e * hill);
        estimates.set("topography.hill_length_m", &mut model.hill_length_m, hill, error, steps);
    } else {
        estimates.warn(
            "the hill length of its slopes is below four steps, or endless: it stays that of the \
             base study",
        );
    }
    if share > SHORT {
        estimates.warn(format_args!(
            "its roads are short beside their hills: {:.0} % of the variance of slopes goes with \
             the mean slope of each road, and is made up for",
            100.0 * share
        ));
    }
}

//! The effect of numbers that nobody has measured on a fleet's answer: the same cycles are driven
//! with a number, or with several that belong together, at both ends of their plausible range.
//!
//! Of the fleet's mean R, and of the standard deviation s and the 95th percentile q over the
//! cycles, the change at each end is estimated: over the n cycles that count on all sides, moved
//! less unmoved. Its standard error, of the sampling of cycles, is that of a sum of influences,
//! paired as the cycles are and added up by batches of cycles that depend on one another:
//!
//! | | influence of cycle i |
//! |---|---|
//! | R | (y_i − R x_i)/Σ x |
//! | s | ((v_i − v̄)² − s²)/(2 s n) |
//! | q | (0.95 − 1{v_i ≤ q})/(f n), f the density at q by the distance of the quantiles 0.91 and 0.99 |
//!
//! With l and h the changes at the two ends, and s_l and s_h their standard errors, the numbers'
//! effect is the root of their mean square, less what sampling adds to it on average:
//!
//! - e² = (l² + h² − s_l² − s_h²)/2     (0 where it is negative)
//!
//! which is half their distance where they lie on both sides, equally far. Effects of numbers that
//! are judged one by one add up as squares, those below zero among them. The sum is no confidence
//! interval: the ranges are plausible, no more is known of them.
//!
//! Source: A. W. van der Vaart, *Asymptotic Statistics* (1998), chapters 20 and 21, for the
//! influences \[PK\].

use super::dependence::Dependence;
use super::pair::{Contribution, contribution};
use super::quantile::quantile;
use super::quantity::NamedQuantity;
use super::statistic::standard_deviation;
use ocmc_core::record::Record;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

const P95: f64 = 0.95;

/// Distance of the levels, on both sides, between which a density is known.
const AROUND: f64 = 0.04;

/// One fleet before and after numbers are moved, the same cycles in the same order.
#[derive(Clone, Copy, Debug)]
pub struct Moved<'a> {
    /// Weight of the change: 1, or −1 in a difference.
    pub sign: f64,
    /// The records of the study as it is.
    pub before: &'a [Record],
    /// The records with the numbers moved.
    pub after: &'a [Record],
}

/// A change, and how well it is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Change {
    /// Moved less unmoved.
    pub by: f64,
    /// Its standard error, of the sampling of cycles; none of fewer than two batches.
    pub standard_error: Option<f64>,
}

/// Changes by moved numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Changes {
    /// Change of the fleet's mean.
    pub mean: Change,
    /// Change of the standard deviation over the cycles.
    pub sd: Change,
    /// Change of the 95th percentile over the cycles.
    pub p95: Change,
    /// Cycles that count on all sides.
    pub cycles: u64,
}

/// Mean of a fleet, standard deviation and 95th percentile over its cycles; or changes of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Shape {
    /// Mean of the fleet.
    pub mean: f64,
    /// Standard deviation over the cycles.
    pub sd: f64,
    /// 95th percentile over the cycles.
    pub p95: f64,
}

impl Shape {
    /// The shape of the cycles that count; none of fewer than two.
    pub fn of(quantity: &NamedQuantity, records: &[Record]) -> Option<Self> {
        let contributions: Vec<Contribution> =
            records.iter().filter_map(|record| contribution(quantity, record)).collect();
        let ([mean, sd, p95], _) = shape(&contributions)?;
        Some(Self { mean, sd, p95 })
    }

    /// So many times it.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        let Self { mean, sd, p95 } = self;
        Self { mean: factor * mean, sd: factor * sd, p95: factor * p95 }
    }

    /// The sum of both.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        let Self { mean, sd, p95 } = self;
        Self { mean: mean + other.mean, sd: sd + other.sd, p95: p95 + other.p95 }
    }
}

impl Changes {
    /// Changes of a fleet, or of the difference of several; none where fewer than two cycles count
    /// on all sides.
    pub fn of(quantity: &NamedQuantity, dependence: Dependence, fleets: &[Moved]) -> Option<Self> {
        let sides: Vec<(f64, Vec<Option<Contribution>>)> = fleets
            .iter()
            .flat_map(|fleet| [(fleet.sign, fleet.after), (-fleet.sign, fleet.before)])
            .map(|(sign, records)| {
                (sign, records.iter().map(|record| contribution(quantity, record)).collect())
            })
            .collect();
        let all = sides.iter().map(|(_, contributions)| contributions.len()).min()?;
        let counts = |k: &usize| sides.iter().all(|(_, contributions)| contributions[*k].is_some());
        let kept: Vec<usize> = (0..all).filter(counts).collect();
        let batch = |k: &usize| {
            sides[0].1[*k].map(|contribution| dependence.group_of(contribution.cycle_id))
        };
        let batches: Vec<u64> = kept.iter().filter_map(batch).collect();
        let mut by = [0.0; 3];
        let mut influences = vec![[0.0; 3]; kept.len()];
        for (sign, contributions) in &sides {
            let contributions: Vec<Contribution> =
                kept.iter().filter_map(|&k| contributions[k]).collect();
            let (shape, of_cycles) = shape(&contributions)?;
            for m in 0..3 {
                by[m] += sign * shape[m];
            }
            for (sum, of_cycle) in influences.iter_mut().zip(of_cycles) {
                for m in 0..3 {
                    sum[m] += sign * of_cycle[m];
                }
            }
        }
        let error = |m: usize| {
            let mut totals = BTreeMap::<u64, f64>::new();
            for (batch, influence) in batches.iter().zip(&influences) {
                *totals.entry(*batch).or_default() += influence[m];
            }
            let g = totals.len() as f64;
            let squares: f64 = totals.values().map(|total| total * total).sum();
            (totals.len() > 1).then(|| libm::sqrt(g / (g - 1.0) * squares))
        };
        let [mean, sd, p95] = [0, 1, 2].map(|m| Change { by: by[m], standard_error: error(m) });
        Some(Self { mean, sd, p95, cycles: kept.len() as u64 })
    }
}

/// The mean square of the changes at both ends, less what sampling adds to it; below zero where it
/// happens to be smaller than that.
pub fn effect_square(low: Change, high: Change) -> f64 {
    let square = |change: Change| {
        let error = change.standard_error.unwrap_or(0.0);
        change.by * change.by - error * error
    };
    f64::midpoint(square(low), square(high))
}

/// The effect of numbers, or of several that are judged one by one: the root of the sum of their
/// [`effect_square`].
pub fn effect(squares: impl IntoIterator<Item = f64>) -> f64 {
    libm::sqrt(squares.into_iter().sum::<f64>().max(0.0))
}

/// Mean, standard deviation and 95th percentile, and the influence of each cycle on them.
fn shape(contributions: &[Contribution]) -> Option<([f64; 3], Vec<[f64; 3]>)> {
    let y: f64 = contributions.iter().map(|contribution| contribution.y).sum();
    let x: f64 = contributions.iter().map(|contribution| contribution.x).sum();
    let mut values: Vec<f64> =
        contributions.iter().filter_map(|contribution| contribution.value).collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let sd = standard_deviation(&values)?;
    values.sort_unstable_by(f64::total_cmp);
    let at = |level: f64| quantile(&values, level);
    let p95 = at(P95)?;
    // 0 where all of them are the same, which nothing moves
    let over_density = (at(P95 + AROUND)? - at(P95 - AROUND)?) / (2.0 * AROUND);
    let over_sd = if sd > 0.0 { 1.0 / sd } else { 0.0 };
    let influence = |contribution: &Contribution| {
        let of_mean = (contribution.y - y / x * contribution.x) / x;
        let Some(value) = contribution.value else { return [of_mean, 0.0, 0.0] };
        let of_sd = ((value - mean) * (value - mean) - sd * sd) * over_sd / 2.0;
        let below = f64::from(u8::from(value <= p95));
        [of_mean, of_sd / n, (P95 - below) * over_density / n]
    };
    (x > 0.0).then(|| ([y / x, sd, p95], contributions.iter().map(influence).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::quantity;
    use ocmc_core::energy::Carrier;
    use ocmc_core::random::{Stream, Streams};
    use ocmc_core::record::Outcome;

    fn record(cycle_id: u64, litres: f64) -> Record {
        Record { cycle_id, distance_m: 1.0, ..Record::default() }
            .with(Carrier::LiquidFuel, [None, Some(litres), None])
    }

    fn changes(fleets: &[Moved]) -> Option<Changes> {
        let litres = quantity("consumption_l_per_100km").expect("known");
        Changes::of(litres, Dependence::default(), fleets)
    }

    #[test]
    fn a_factor_on_all_cycles_is_a_factor_on_all_that_is_told() {
        let before: Vec<Record> = (0..101).map(|k| record(k, 20.0 + 0.2 * k as f64)).collect();
        let after: Vec<Record> = (0..101).map(|k| record(k, 22.0 + 0.22 * k as f64)).collect();
        let moved = Moved { sign: 1.0, before: &before, after: &after };
        let Changes { mean, sd, p95, cycles } = changes(&[moved]).expect("cycles");
        // 0 to 100: mean 50, variance with n − 1 858.5, 95th percentile 95
        assert!((mean.by - 3.0).abs() < 1e-12, "{mean:?}");
        assert!((sd.by - 0.02 * 858.5_f64.sqrt()).abs() < 1e-12, "{sd:?}");
        assert!((p95.by - 3.9).abs() < 1e-12, "{p95:?}");
        assert_eq!(cycles, 101);
        let other = Moved { sign: -1.0, ..moved };
        let none = changes(&[moved, other]).expect("cycles");
        assert_eq!((none.mean.by, none.mean.standard_error), (0.0, Some(0.0)));
    }

    #[test]
    fn only_cycles_that_count_on_all_sides_count() {
        let before: Vec<Record> = (0..4).map(|k| record(k, 20.0 + k as f64)).collect();
        let mut after: Vec<Record> = (0..4).map(|k| record(k, 21.0 + k as f64)).collect();
        after[3].outcome = Outcome::Stalled;
        let moved = Moved { sign: 1.0, before: &before, after: &after };
        let changed = changes(&[moved]).expect("cycles");
        assert_eq!((changed.mean.by, changed.cycles), (1.0, 3));
        assert!(changes(&[Moved { before: &before[..1], ..moved }]).is_none());
        assert!(changes(&[]).is_none());
    }

    /// A change, its truth, and the largest factor by which its variance is overestimated.
    type Part = (fn(&Changes) -> Change, f64, f64);

    #[test]
    fn the_errors_are_those_of_many_samples() {
        // before N(30, 3²); after, times 1.1 and noise of 1
        const RUNS: u64 = 400;
        let mut samples = Vec::new();
        for run in 0..RUNS {
            let mut draws = Streams::new(1, run).open(Stream::CurveResidual);
            let (before, after): (Vec<Record>, Vec<Record>) = (0..200)
                .map(|k| {
                    let litres = 30.0 + 3.0 * draws.normal();
                    (record(k, litres), record(k, 1.1 * litres + draws.normal()))
                })
                .unzip();
            samples.push(changes(&[Moved { sign: 1.0, before: &before, after: &after }]).unwrap());
        }
        let parts: [Part; 3] = [
            (|c| c.mean, 3.0, 1.25),
            // SD after: √(3.3² + 1) = 3.448
            (|c| c.sd, 0.448, 1.25),
            // densities of few values are rough, and that of either side on its own: the error is
            // overestimated
            (|c| c.p95, 3.0 + 1.645 * 0.448, 2.0),
        ];
        for (change, truth, most) in parts {
            let n = RUNS as f64;
            let mean = samples.iter().map(|c| change(c).by).sum::<f64>() / n;
            let spread = samples.iter().map(|c| (change(c).by - mean).powi(2)).sum::<f64>() / n;
            let estimated = samples.iter().map(|c| change(c).standard_error.unwrap().powi(2));
            let ratio = estimated.sum::<f64>() / n / spread;
            let error = (spread / n).sqrt();
            // percentiles of 200 values are biased
            assert!((mean - truth).abs() < 4.0 * error + 0.03, "{mean} {truth} {error}");
            assert!((0.8..most).contains(&ratio), "{ratio}");
        }
    }

    #[test]
    fn effects_are_free_of_the_noise_on_average() {
        let change = |by, error| Change { by, standard_error: Some(error) };
        let both = |low, high| effect_square(low, high);
        assert_eq!(effect([both(change(-2.0, 0.0), change(2.0, 0.0))]), 2.0);
        assert_eq!(effect([both(change(0.1, 0.2), change(0.1, 0.2))]), 0.0);
        // chance of both signs cancels
        let chance =
            [both(change(0.5, 0.4), change(0.5, 0.4)), both(change(0.3, 0.5), change(0.0, 0.1))];
        assert!((effect(chance) - libm::sqrt(0.09 - 0.085)).abs() < 1e-12);
        assert_eq!(effect([9.0, 16.0]), 5.0);
    }
}

//! Shapley effects: the variance between cycles shared out to the factors, joint effects included,
//! so that the shares add up to one.
//!
//! With c(u) = E\[Var(Y | all factors but u)\] the variance that would be gone if the factors u
//! were fixed, the share of factor i of d is
//!
//! φ_i = Σ over u without i of |u|! (d − 1 − |u|)!/d! (c(u ∪ i) − c(u)) / c(all)
//!
//! A row of the design drives one cycle for each subset of the factors: these from the second
//! sample, the others from the first. Two cycles of a row that differ in the factors u have E (f −
//! f')²/2 = c(u); all 2^(d − 1) such pairs of the row are averaged. The shares then add up to one
//! exactly, in each bootstrap sample, too.
//!
//! Sources: A. B. Owen, Sobol' indices and Shapley value, SIAM/ASA Journal on Uncertainty
//! Quantification 2 (2014) 245; E. Song, B. L. Nelson, J. Staum, Shapley effects for global
//! sensitivity analysis: theory and computation, the same 4 (2016) 1060 (this c(u); all subsets)
//! \[PK\]; that pairs of any two subsets serve \[D\].
//!
//! Checked: the effects of Ishigami's function are its first-order effects and half of its
//! interaction, within four standard errors for seeds 1, 2 and 3. They add up to one to 1e-12, and
//! intervals of 100 rows cover in 89 to 99 % of 200 simulated analyses.

use super::dependence::Dependence;
use super::quantity::{RecordQuantity, consumption};
use super::run::{RunPlan, records};
use super::sensitivity::{
    FactorGroup, LEAST_ROWS, Output, Over, SensitivityError, factor_groups, rows_of, values,
};
use super::variance_share::{BOOTSTRAP_SAMPLES, LEAST_GROUPS, drawn_again, percentiles};
use ocmc_core::random::{PickFreeze, StreamSet};
use ocmc_core::study::Study;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// Shares of the variance that add up to one.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ShapleyEffects {
    /// Rows of the design that count.
    pub rows: u64,
    /// Rows that were dropped: one of the cycles failed, or has no value.
    pub dropped_rows: u64,
    /// Cycles that were driven.
    pub cycles: u64,
    /// Variance that is shared out.
    pub variance: f64,
    /// The factors.
    pub factors: Vec<ShapleyShare>,
}

/// Share of one factor in the variance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ShapleyShare {
    /// Its name.
    pub factor: &'static str,
    /// Its share.
    pub share: f64,
    /// 95 % interval; none below [`LEAST_GROUPS`] independent groups of rows.
    pub ci95: Option<[f64; 2]>,
}

/// The factors: the groups that are no part of another one.
pub fn shapley_factors() -> Vec<FactorGroup> {
    factor_groups().into_iter().filter(|group| !group.name.contains('.')).collect()
}

/// Cycles of a row.
pub fn cycles_of_row() -> u64 {
    1 << shapley_factors().len()
}

/// Drives `plan.cycles` rows of the design, or so many trucks as these are, and shares out the
/// variance. Without a quantity that of the consumption.
///
/// `progress` receives the number of cycles driven so far, of `plan.cycles` × [`cycles_of_row`];
/// breaking ends the analysis.
pub fn shapley<B>(
    study: &Study,
    plan: &RunPlan,
    quantity: Option<&'static RecordQuantity>,
    over: Over,
    mut progress: impl FnMut(u64) -> ControlFlow<B>,
) -> ControlFlow<B, Result<ShapleyEffects, SensitivityError>> {
    let factors = shapley_factors();
    let dependence = Dependence::of(study.model(), plan.seed);
    let mut quantity = quantity;
    let mut designs: Vec<Vec<Output>> = Vec::new();
    for subset in 0..1_usize << factors.len() {
        let streams = factors.iter().enumerate().filter(|(i, _)| subset >> i & 1 == 1);
        let streams = streams.fold(StreamSet::NONE, |set, (_, factor)| set.with(factor.streams));
        let plan = RunPlan { pick_freeze: PickFreeze { streams, cycle_id: None }, ..*plan };
        let before = subset as u64 * plan.cycles;
        let driven = records(study, &plan, |cycles| progress(before + cycles))?;
        let quantity = *quantity.get_or_insert_with(|| consumption(&driven));
        designs.push(values(quantity, over, dependence.trips_per_truck, &driven));
    }
    let names: Vec<&'static str> = factors.iter().map(|factor| factor.name).collect();
    let column = quantity.map_or("", |quantity| quantity.column);
    let (rows, of_rows) = rows_of(plan, dependence, over);
    let effects = share_out(column, &rows, of_rows, &names, &designs);
    let cycles = plan.cycles * designs.len() as u64;
    ControlFlow::Continue(effects.map(|effects| ShapleyEffects { cycles, ..effects }))
}

/// Drops rows that are not complete, and estimates the shares.
fn share_out(
    column: &'static str,
    plan: &RunPlan,
    dependence: Dependence,
    names: &[&'static str],
    designs: &[Vec<Output>],
) -> Result<ShapleyEffects, SensitivityError> {
    let weights = weights(names.len());
    let mut groups: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    let mut rows = 0;
    for row in 0..plan.cycles {
        let outputs: Result<Vec<f64>, _> =
            designs.iter().map(|design| design[row as usize]).collect();
        let Ok(outputs) = outputs else { continue };
        rows += 1;
        let group = dependence.group_of(plan.first_cycle + row);
        let sums = groups.entry(group).or_insert_with(|| vec![0.0; names.len() + 1]);
        for (sum, term) in sums.iter_mut().zip(terms(&outputs, &weights)) {
            *sum += term;
        }
    }
    let dropped_rows = plan.cycles - rows;
    if rows < LEAST_ROWS {
        return Err(SensitivityError::TooFewRows { column, rows, dropped: dropped_rows });
    }
    let groups: Vec<Vec<f64>> = groups.into_values().collect();
    let (shares, whole) = shares(groups.iter(), names.len());
    if !(whole > 0.0) {
        return Err(SensitivityError::NoSpread { column });
    }
    let mut samples = vec![Vec::new(); names.len()];
    let bootstrap = if groups.len() < LEAST_GROUPS { 0 } else { BOOTSTRAP_SAMPLES };
    for number in 0..bootstrap {
        let drawn = drawn_again(plan.seed, number, groups.len());
        let (resampled, _) = self::shares(drawn.map(|group| &groups[group]), names.len());
        samples.iter_mut().zip(resampled).for_each(|(sample, share)| sample.push(share));
    }
    let factors = names.iter().zip(shares).zip(samples);
    let factors = factors.map(|((factor, share), sample)| ShapleyShare {
        factor,
        share,
        ci95: percentiles(sample),
    });
    let (cycles, variance) = (plan.cycles * designs.len() as u64, whole / rows as f64);
    Ok(ShapleyEffects { rows, dropped_rows, cycles, variance, factors: factors.collect() })
}

/// Shares of each factor from sums of terms, and the sum of the whole.
fn shares<'a>(groups: impl Iterator<Item = &'a Vec<f64>>, factors: usize) -> (Vec<f64>, f64) {
    let mut sums = vec![0.0; factors + 1];
    for group in groups {
        sums.iter_mut().zip(group).for_each(|(sum, term)| *sum += term);
    }
    let whole = sums[factors];
    (sums[..factors].iter().map(|sum| sum / whole).collect(), whole)
}

/// Weight of c(u) in the share of each factor, for every subset u.
fn weights(factors: usize) -> Vec<Vec<f64>> {
    let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
    let weight = |i: usize, subset: usize| {
        let size = subset.count_ones() as usize;
        if subset >> i & 1 == 1 {
            factorial(size - 1) * factorial(factors - size) / factorial(factors)
        } else {
            -factorial(size) * factorial(factors - 1 - size) / factorial(factors)
        }
    };
    (0..factors).map(|i| (0..1 << factors).map(|subset| weight(i, subset)).collect()).collect()
}

/// Contributions of a row to each factor's part of the variance, and of the whole; `outputs` are
/// its cycles by the subset that comes from the second sample.
fn terms(outputs: &[f64], weights: &[Vec<f64>]) -> Vec<f64> {
    let count = outputs.len();
    let gone: Vec<f64> = (0..count)
        .map(|differ| {
            let pairs = (0..count).map(|subset| {
                let difference = outputs[subset] - outputs[subset ^ differ];
                difference * difference
            });
            // each pair is met twice
            pairs.sum::<f64>() / (2.0 * count as f64)
        })
        .collect();
    let part = |weights: &Vec<f64>| weights.iter().zip(&gone).map(|(w, c)| w * c).sum::<f64>();
    weights.iter().map(part).chain([gone[count - 1]]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensitivity::Missing;
    use ocmc_core::random::{Draws, Stream};
    use std::f64::consts::PI;

    const NAMES: [&str; 4] = ["a", "b", "c", "d"];

    /// The design of a function of `D` uniform numbers.
    fn designs<const D: usize>(
        f: impl Fn([f64; D]) -> f64,
        rows: u64,
        seed: u64,
    ) -> Vec<Vec<Output>> {
        let mut first = Draws::new(seed, 0, Stream::Curve);
        let mut second = Draws::of_second_sample(seed, 0, Stream::Curve);
        let mut designs = vec![Vec::new(); 1 << D];
        for _ in 0..rows {
            let a: [f64; D] = std::array::from_fn(|_| first.uniform());
            let b: [f64; D] = std::array::from_fn(|_| second.uniform());
            for (subset, design) in designs.iter_mut().enumerate() {
                let x = std::array::from_fn(|i| if subset >> i & 1 == 1 { b[i] } else { a[i] });
                design.push(Ok(f(x)));
            }
        }
        designs
    }

    fn effects<const D: usize>(
        f: impl Fn([f64; D]) -> f64,
        rows: u64,
        seed: u64,
    ) -> ShapleyEffects {
        let plan = RunPlan::new(seed, 0, rows, Some(1), None);
        let designs = designs(f, rows, seed);
        share_out("x", &plan, Dependence::default(), &NAMES[..D], &designs).expect("it varies")
    }

    fn ishigami(u: [f64; 3]) -> f64 {
        let x = u.map(|u| PI * (2.0 * u - 1.0));
        x[0].sin() * (1.0 + 0.1 * x[2].powi(4)) + 7.0 * x[1].sin().powi(2)
    }

    #[test]
    fn ishigamis_shares_are_the_first_ones_and_half_of_the_joint_one() {
        // T. Ishigami, T. Homma (1990): V₁ = (1 + b π⁴/5)²/2, V₂ = a²/8, V₁₃ = b² π⁸ (1/18 − 1/50)
        let v1 = (1.0 + 0.1 * PI.powi(4) / 5.0).powi(2) / 2.0;
        let (v2, v13) = (49.0 / 8.0, 0.01 * PI.powi(8) * (1.0 / 18.0 - 1.0 / 50.0));
        let v = v1 + v2 + v13;
        let known = [(v1 + 0.5 * v13) / v, v2 / v, 0.5 * v13 / v];
        for seed in 1..=3 {
            let effects = effects(ishigami, 4000, seed);
            assert!((effects.variance / v - 1.0).abs() < 0.1, "{effects:?}");
            for (share, known) in effects.factors.iter().zip(known) {
                let [low, high] = share.ci95.expect("enough rows");
                let error = (high - low) / 3.92;
                assert!((share.share - known).abs() < 4.0 * error, "{share:?} {known}");
                assert!(error < 0.02, "{share:?}");
            }
        }
    }

    #[test]
    fn shares_add_up_to_one() {
        let product = |u: [f64; 4]| (1.0 + u[0]) * (2.0 + u[1] * u[2]) + (3.0 * u[3] + u[0]).sin();
        let effects = effects(product, 50, 7);
        let sum: f64 = effects.factors.iter().map(|share| share.share).sum();
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        assert_eq!((effects.rows, effects.cycles, effects.dropped_rows), (50, 800, 0));
        for row in weights(6) {
            // what a factor adds to any subset, weighted by orders in which it comes: in all one
            let added: f64 = row.iter().filter(|weight| **weight > 0.0).sum();
            assert!((added - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn symmetric_factors_share_alike_and_idle_ones_have_nothing() {
        // a product of two: all is joint, half for either, for any row alone
        let row: Vec<f64> = (0..8_usize)
            .map(|subset| {
                let x = |i: usize| if subset >> i & 1 == 1 { -1.0 } else { 2.0 };
                x(0) * x(1)
            })
            .collect();
        let terms = terms(&row, &weights(3));
        assert!((terms[0] - terms[1]).abs() < 1e-12 && terms[2].abs() < 1e-12, "{terms:?}");
        assert!((terms[0] + terms[1] - terms[3]).abs() < 1e-12);
    }

    #[test]
    fn rows_that_are_not_complete_are_dropped_whole() {
        let plan = RunPlan::new(1, 0, 12, Some(1), None);
        let mut designs = designs(|u: [f64; 2]| u[0] + u[1], 12, 1);
        designs[3][2] = Err(Missing::NotCompleted);
        designs[1][5] = Err(Missing::NoValue);
        let shared_out = |designs: &[Vec<Output>]| {
            share_out("x", &plan, Dependence::default(), &NAMES[..2], designs)
        };
        let effects = shared_out(&designs).expect("ten are left");
        assert_eq!((effects.rows, effects.dropped_rows, effects.cycles), (10, 2, 48));
        designs[0][0] = Err(Missing::NoValue);
        let error = shared_out(&designs).expect_err("nine are left");
        assert_eq!(error, SensitivityError::TooFewRows { column: "x", rows: 9, dropped: 3 });
        let same = vec![vec![Ok(1.0); 12]; 4];
        assert_eq!(shared_out(&same), Err(SensitivityError::NoSpread { column: "x" }));
    }

    #[test]
    fn intervals_cover() {
        // u₁ + u₂ + u₁ u₂: V₁ = V₂ = 1.5²/12, V₁₂ = 1/144: by symmetry a half each
        let mut covered = 0;
        for seed in 0..200 {
            let effects = effects(|u: [f64; 2]| u[0] + u[1] + u[0] * u[1], 100, 100 + seed);
            let [low, high] = effects.factors[0].ci95.expect("enough rows");
            covered += u32::from(low <= 0.5 && 0.5 <= high);
        }
        // percentile intervals of 100 rows cover a little less than 95 %
        assert!((178..=198).contains(&covered), "{covered}");
    }

    #[test]
    fn the_factors_are_the_six() {
        let names: Vec<&str> = shapley_factors().iter().map(|factor| factor.name).collect();
        assert_eq!(names, ["road", "weather", "traffic", "mission", "driver", "vehicle"]);
        assert_eq!(cycles_of_row(), 64);
    }
}

//! How sure a fleet's mean is when numbers of its study are estimates that have errors.
//!
//! The delta method on paired drives. For each uncertain number θ_j with standard error s_j the
//! same cycles are driven with θ_j − s_j and with θ_j + s_j. Half the difference of the two means R
//! is what one standard error does, e_j = s_j ∂R/∂θ_j to second order. With ρ the correlation of
//! the errors of the numbers and V the covariance of the sampling errors of the e_j, which follows
//! from the paired residuals (see [`super::comparison`]),
//!
//! - σ² = eᵀ ρ e − Σ ρ_ij V_ij     (0 where it is negative)
//! - interval R ± √(z₀.₉₇₅² σ² (1 + 1/G) + h²)
//!
//! with h the half width of the interval of sampling alone. Pairs that differ in one number vary
//! much less than cycles do, so that a thousand of them tell σ to a few percent. Where the cycles
//! of the run itself draw the law of curve speeds in G replicates, R is the mean over them;
//! otherwise 1/G is 0. More cycles shrink h, and leave σ: that needs more measurements behind the
//! numbers.
//!
//! Source: the delta method, A. W. van der Vaart, *Asymptotic Statistics* (1998), chapter 3 \[PK\].

use super::dependence::Dependence;
use super::pair::{Pair, contribution, side};
use super::quantity::NamedQuantity;
use super::ratio::NORMAL_975;
use super::run::RunPlan;
use nalgebra::{DMatrix, DVector};
use ocmc_core::record::Record;
use ocmc_core::study::Study;
use ocmc_core::study::uncertainty::{Sides, UncertainKey, Uncertainty};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// Most cycles that are driven on each side of a number.
pub const MOST_PAIRS: u64 = 1000;

/// Part of the uncertainty of a fleet's mean, or of the difference of two, that comes from
/// uncertain numbers of the study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ParameterUncertainty {
    /// Name of the quantity.
    pub column: String,
    /// Replicates that the cycles of the run draw the law of curve speeds in; none where they all
    /// have the same.
    pub replicates: Option<u64>,
    /// Cycles that were driven on each side of each number.
    pub cycles: u64,
    /// Standard deviation of the fleet's mean over the errors of the numbers.
    pub sd: f64,
    /// 95 % interval of the mean, sampling and parameters together.
    pub ci95: [f64; 2],
    /// The numbers, one by one.
    pub parameters: Vec<ParameterEffect>,
}

/// Effect of one number's error on the mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ParameterEffect {
    /// Path of the key.
    pub key: String,
    /// Standard error of the number, in its unit.
    pub standard_error: f64,
    /// Change of the mean by one standard error; none where no cycle is completed on both sides.
    pub effect: Option<f64>,
    /// Standard error of that change, from the sampling of cycles.
    pub effect_standard_error: Option<f64>,
    /// Share of eᵀ ρ e; negative where its error takes away from that of others. None where the
    /// errors do nothing that is more than noise.
    pub share: Option<f64>,
    /// Cycles that were completed on both sides.
    pub pairs: u64,
}

/// Effects of one standard error of each number.
#[derive(Clone, Debug)]
pub struct Effects {
    column: String,
    cycles: u64,
    correlation: DMatrix<f64>,
    numbers: Vec<Number>,
}

#[derive(Clone, Debug)]
struct Number {
    key: UncertainKey,
    effect: Option<f64>,
    pairs: u64,
    /// The mean's residuals, added up by batch of cycles.
    residuals: BTreeMap<u64, f64>,
}

impl Number {
    /// One that nothing is known of.
    fn unknown(key: &UncertainKey) -> Self {
        Self { key: key.clone(), effect: None, pairs: 0, residuals: BTreeMap::new() }
    }
}

impl Effects {
    /// Drives the study on both sides of its uncertain numbers: as many cycles as the plan has, at
    /// most [`MOST_PAIRS`]. None where it has no such numbers.
    pub fn drive<B>(
        study: &Study,
        plan: &RunPlan,
        quantity: &NamedQuantity,
        mut drive: impl FnMut(&Study, &RunPlan) -> ControlFlow<B, Vec<Record>>,
    ) -> ControlFlow<B, Option<Self>> {
        let Some(Uncertainty { keys, correlation }) = study.model().uncertain() else {
            return ControlFlow::Continue(None);
        };
        let plan = paired(plan);
        let dependence = Dependence::of(study.model(), plan.seed);
        let mut numbers = Vec::with_capacity(keys.len());
        for key in &keys {
            let mut number = Number::unknown(key);
            if key.standard_error == 0.0 {
                number.effect = Some(0.0);
            } else if let Ok(Sides { low, high, apart }) = study.sides(key) {
                let (low, high) = (drive(&low, &plan)?, drive(&high, &plan)?);
                number = half(quantity, dependence, &low, &high, apart, number);
            }
            numbers.push(number);
        }
        let (column, cycles) = (quantity.column.to_owned(), plan.cycles);
        ControlFlow::Continue(Some(Self { column, cycles, correlation, numbers }))
    }

    /// Effects in a study that takes all numbers for certain.
    pub fn nothing(quantity: &NamedQuantity) -> Self {
        let (correlation, numbers) = (DMatrix::zeros(0, 0), Vec::new());
        Self { column: quantity.column.to_owned(), cycles: 0, correlation, numbers }
    }

    /// Cycles that [`Effects::drive`] drives in all.
    pub fn cycles_of(study: &Study, plan: &RunPlan) -> u64 {
        let keys = study.model().uncertain().map_or(Vec::new(), |uncertain| uncertain.keys);
        let moved = keys.iter().filter(|key| key.standard_error > 0.0).count() as u64;
        2 * moved * paired(plan).cycles
    }

    /// The effects on the difference of two means, this one's less that of `other`: a key of both
    /// is one error that moves both at once. None where the two correlate their errors in ways that
    /// do not fit one another.
    pub fn less(mut self, other: &Self) -> Option<Self> {
        let own_keys = self.numbers.len();
        let mut places = Vec::with_capacity(other.numbers.len());
        for theirs in &other.numbers {
            let same = self.numbers.iter().position(|own| own.key.key == theirs.key.key);
            let k = same.unwrap_or_else(|| {
                let nothing = Number { effect: Some(0.0), ..Number::unknown(&theirs.key) };
                self.numbers.push(Number { pairs: theirs.pairs, ..nothing });
                self.numbers.len() - 1
            });
            let own = &mut self.numbers[k];
            own.effect = own.effect.zip(theirs.effect).map(|(own, theirs)| own - theirs);
            own.pairs = own.pairs.min(theirs.pairs);
            for (batch, residual) in &theirs.residuals {
                *own.residuals.entry(*batch).or_default() -= residual;
            }
            places.push(k);
        }
        let n = self.numbers.len();
        let mut correlation = DMatrix::identity(n, n);
        correlation.view_mut((0, 0), (own_keys, own_keys)).copy_from(&self.correlation);
        for (i, &a) in places.iter().enumerate() {
            for (j, &b) in places.iter().enumerate() {
                let theirs = other.correlation[(i, j)];
                if a < own_keys && b < own_keys && correlation[(a, b)] != theirs {
                    return None;
                }
                correlation[(a, b)] = theirs;
            }
        }
        let possible = correlation.clone().symmetric_eigenvalues().iter().all(|l| *l > -1e-9);
        let cycles = self.cycles.max(other.cycles);
        possible.then_some(Self { cycles, correlation, ..self })
    }

    /// The interval of a mean, or of a difference, whose sampling alone gives it the interval
    /// `ci95`, over cycles in so many replicates.
    pub fn around(
        &self,
        mean: f64,
        ci95: [f64; 2],
        replicates: Option<u64>,
    ) -> ParameterUncertainty {
        let known = self.numbers.iter().map(|number| number.effect.unwrap_or(0.0));
        let e = DVector::from_iterator(self.numbers.len(), known);
        let sampling = self.sampling();
        let together = &self.correlation * &e;
        let whole = e.dot(&together);
        let variance = (whole - self.correlation.dot(&sampling)).max(0.0);
        let more = 1.0 + replicates.map_or(0.0, |g| 1.0 / g as f64);
        let half_width = (ci95[1] - ci95[0]) / 2.0;
        let square = NORMAL_975 * NORMAL_975 * variance * more + half_width * half_width;
        let wide = libm::sqrt(square);
        let parameter = |(k, number): (usize, &Number)| ParameterEffect {
            key: number.key.key.clone(),
            standard_error: number.key.standard_error,
            effect: number.effect,
            effect_standard_error: (number.residuals.len() > 1)
                .then(|| libm::sqrt(sampling[(k, k)])),
            share: (variance > 0.0).then(|| e[k] * together[k] / whole),
            pairs: number.pairs,
        };
        ParameterUncertainty {
            column: self.column.clone(),
            replicates,
            cycles: self.cycles,
            sd: libm::sqrt(variance),
            ci95: [mean - wide, mean + wide],
            parameters: self.numbers.iter().enumerate().map(parameter).collect(),
        }
    }

    /// Covariance of the sampling errors of the effects.
    fn sampling(&self) -> DMatrix<f64> {
        let n = self.numbers.len();
        DMatrix::from_fn(n, n, |i, j| {
            let (a, b) = (&self.numbers[i].residuals, &self.numbers[j].residuals);
            let m = a.len() as f64;
            let product = a.iter().map(|(batch, u)| u * b.get(batch).unwrap_or(&0.0)).sum::<f64>();
            if m > 1.0 { m / (m - 1.0) * product } else { 0.0 }
        })
    }
}

/// The plan of one side.
fn paired(plan: &RunPlan) -> RunPlan {
    let RunPlan { seed, first_cycle, cycles, threads, level, .. } = *plan;
    let fewer = RunPlan::new(seed, first_cycle, cycles.min(MOST_PAIRS), Some(threads), None);
    RunPlan { level, ..fewer }
}

/// Effect of one standard error of a number, from fleets that are so many of them apart, and its
/// residuals by batch, which are of the mean: their sum is 0. Unknown as it was where no cycle was
/// completed on both sides.
fn half(
    quantity: &NamedQuantity,
    dependence: Dependence,
    low: &[Record],
    high: &[Record],
    apart: f64,
    unknown: Number,
) -> Number {
    let pair =
        |(a, b): (&Record, &Record)| Some((contribution(quantity, a)?, contribution(quantity, b)?));
    let pairs: Vec<Pair> = low.iter().zip(high).filter_map(pair).collect();
    let [low, high] =
        [side(pairs.iter().map(|pair| pair.0)), side(pairs.iter().map(|pair| pair.1))];
    let (Some((below, errors_below)), Some((above, errors_above))) = (low, high) else {
        return unknown;
    };
    let mut residuals = BTreeMap::new();
    for ((id, a), (_, b)) in errors_below.iter().zip(&errors_above) {
        let of_mean = (b - a) / apart / pairs.len() as f64;
        *residuals.entry(id / dependence.batch).or_default() += of_mean;
    }
    let effect = Some((above - below) / apart);
    Number { effect, pairs: pairs.len() as u64, residuals, ..unknown }
}

//! Comparison of two studies under common random numbers: both drive the same cycle ids under one
//! seed, so that whatever they do not differ in is the same, cycle by cycle, and falls out of the
//! difference.
//!
//! With R = Σ y / Σ x the fleet's mean on each side (see [`super::ratio`]), the difference is R_B −
//! R_A. Its linearised standard error is that of a mean of paired residuals:
//!
//! e_Aᵢ = (y_Aᵢ − R_A x_Aᵢ) / x̄_A,  e_B alike,  se² = Σ (e_Bᵢ − e_Aᵢ)² / (n (n − 1))
//!
//! Two independent runs of the same size would have se² = Σ (e_Aᵢ² + e_Bᵢ²) / (n (n − 1)); the
//! quotient of the two is the variance reduction. Where cycles depend on one another, the residuals
//! of a batch are added up first (see [`super::dependence`]). Where it is known what the cycles
//! have on average, the difference is adjusted by it, too (see [`super::adjustment`]). What
//! uncertain numbers of the studies add is told by drives on both sides of each number (see
//! [`super::uncertainty`]). Source: W. G. Cochran, *Sampling Techniques*, 3rd ed. (1977), section
//! 6.4, for the residuals; the rest is the variance of a difference.

use super::adjustment::{Adjusted, Adjuster, Adjustment};
use super::clustering::Clusters;
use super::dependence::Dependence;
use super::pair::{Cycle, Pair, contribution, cycles, side};
use super::quantity::{NamedQuantity, shared_consumption};
use super::ratio::student_975;
use super::run::{RunPlan, records};
use super::uncertainty::{Effects, ParameterUncertainty};
use ocmc_core::record::{Outcome, Record};
use ocmc_core::study::Study;
use schemars::JsonSchema;
use serde::Serialize;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Relative difference below which two values are the same. A cycle ends within half a metre of the
/// end of its road, so the same stops over 100 km differ by up to 5e-6 of them.
pub const ROUNDING: f64 = 1e-5;

/// How study B differs from study A.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Comparison {
    /// Name of the quantity.
    pub column: String,
    /// The fleet's mean of A, over the pairs.
    pub a: Option<f64>,
    /// The fleet's mean of B, over the pairs.
    pub b: Option<f64>,
    /// B less A.
    pub difference: Option<f64>,
    /// 95 % interval of the difference, of sampling alone; none from fewer than two pairs, or
    /// batches of pairs.
    pub ci95: Option<[f64; 2]>,
    /// The difference adjusted by what the cycles are known to have on average
    /// ([`super::adjustment`]); none where that is not known, or the pairs are too few.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adjusted: Option<AdjustedDifference>,
    /// Part of the difference's uncertainty that comes from uncertain numbers of the studies; none
    /// where both take theirs for certain, and where the two correlate the errors of the same
    /// numbers differently.
    pub parameter_uncertainty: Option<ParameterUncertainty>,
    /// Share of the pairs with values in which A is lower.
    pub share_a_lower: Option<f64>,
    /// Share of the pairs with values in which both are the same, to [`ROUNDING`].
    pub share_equal: Option<f64>,
    /// Variance of the difference of two independent runs over that of the pairs; none where the
    /// pairs do not differ by more than [`ROUNDING`].
    pub variance_reduction: Option<f64>,
    /// Cycles that were driven in each study.
    pub cycles: u64,
    /// Cycles that both completed and that count in both means: the pairs.
    pub pairs: u64,
    /// Pairs in which a cycle counts in the mean but has no value of its own, as an empty trip has
    /// no litres per 100 tkm.
    pub pairs_without_value: u64,
    /// Cycles that A completed and that have nothing of the quantity, as an electric truck has no
    /// litres.
    pub a_without_quantity: u64,
    /// Cycles that B completed and that have nothing of the quantity.
    pub b_without_quantity: u64,
    /// Cycles that A did not complete.
    pub a_failed: u64,
    /// Cycles that B did not complete.
    pub b_failed: u64,
}

/// A difference of adjusted means.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct AdjustedDifference {
    /// B less A.
    pub difference: f64,
    /// Its 95 % interval, of sampling alone.
    pub ci95: [f64; 2],
}

impl AdjustedDifference {
    /// Adjusted difference of the pairs of the same cycles in two studies. A cycle that is no pair
    /// adds nothing, in either study.
    fn of(adjusters: [&mut Adjuster; 2], cycles: [&[Cycle]; 2]) -> Option<Self> {
        let pairs = cycles[0].iter().zip(cycles[1]).map(|(a, b)| {
            let (a, b) = (a.contribution?, b.contribution?);
            Some([(a.y, a.x), (b.y, b.x)])
        });
        let pairs: Vec<[(f64, f64); 2]> = pairs.map(Option::unwrap_or_default).collect();
        Self::between(adjusters, &pairs)
    }

    /// Adjusted difference of the ratios of two totals, which each of these cycles adds to in both
    /// studies; 0 and 0 where it does not count.
    pub(super) fn of_totals(
        studies: [&Study; 2],
        seed: u64,
        ids: &[u64],
        pairs: &[[(f64, f64); 2]],
    ) -> Option<Self> {
        let [a, b] = studies.map(|study| adjuster(study, seed, ids.iter().copied()));
        Self::between([&mut a?, &mut b?], pairs)
    }

    fn between([a, b]: [&mut Adjuster; 2], pairs: &[[(f64, f64); 2]]) -> Option<Self> {
        let side = |adjuster: &mut Adjuster, k: usize| {
            let totals: Vec<(f64, f64)> = pairs.iter().map(|pair| pair[k]).collect();
            Some((adjuster.adjustment(&totals)?, totals))
        };
        let ((a, totals_a), (b, totals_b)) = (side(a, 0)?, side(b, 1)?);
        let Adjusted { value, ci95 } = Adjustment::difference([&a, &b], [&totals_a, &totals_b])?;
        Some(Self { difference: value, ci95 })
    }
}

/// Adjuster of the cycles of a study under a seed.
pub(super) fn adjuster(
    study: &Study,
    seed: u64,
    ids: impl Iterator<Item = u64>,
) -> Option<Adjuster> {
    let mut adjuster = Adjuster::new(Arc::new(study.clone()), seed)?;
    ids.for_each(|id| adjuster.add(id));
    Some(adjuster)
}

/// Whether two values are the same but for rounding.
fn same(a: f64, b: f64) -> bool {
    libm::fabs(a - b) <= ROUNDING * libm::fmax(libm::fabs(a), libm::fabs(b))
}

/// Completed cycles that have nothing of the quantity.
fn without(cycles: &[Cycle]) -> u64 {
    let completed = cycles.iter().filter(|cycle| cycle.outcome == Outcome::Completed);
    completed.filter(|cycle| cycle.contribution.is_none()).count() as u64
}

/// Cycles that were not completed.
pub(super) fn failed(cycles: &[Cycle]) -> u64 {
    cycles.iter().filter(|cycle| cycle.outcome != Outcome::Completed).count() as u64
}

/// The fleets' means over some pairs.
#[derive(Clone, Copy, Debug)]
struct Means {
    a: f64,
    b: f64,
    spread: Option<Spread>,
}

/// How the difference of the pairs is spread; not known of fewer than two batches.
#[derive(Clone, Copy, Debug)]
struct Spread {
    degrees: f64,
    standard_error: f64,
    variance_reduction: Option<f64>,
}

impl Means {
    /// None without pairs, and where they have nothing to divide by.
    fn of(pairs: &[Pair], dependence: Dependence) -> Option<Self> {
        let (a, errors_a) = side(pairs.iter().map(|pair| pair.0))?;
        let (b, errors_b) = side(pairs.iter().map(|pair| pair.1))?;
        let errors = errors_a.iter().zip(&errors_b).map(|((id, a), (_, b))| (*id, *a, *b));
        let rounding = ROUNDING * libm::fmax(libm::fabs(a), libm::fabs(b));
        let clusters = Clusters::of(dependence, errors.clone().map(|(id, ..)| id));
        let spread = if clusters.has_several_ways() {
            Spread::over(&clusters, &errors, pairs.len() as f64, rounding)
        } else {
            Spread::of(&dependence.batch_totals(errors), pairs.len() as f64, rounding)
        };
        Some(Self { a, b, spread })
    }

    fn difference(&self) -> f64 {
        self.b - self.a
    }
}

impl Spread {
    /// Spread of residuals of both sides, added up by batch, of so many pairs.
    fn of(errors: &[(f64, f64)], pairs: f64, rounding: f64) -> Option<Self> {
        if errors.len() < 2 {
            return None;
        }
        let m = errors.len() as f64;
        let paired: f64 = errors.iter().map(|(a, b)| (b - a) * (b - a)).sum();
        let independent: f64 = errors.iter().map(|(a, b)| a * a + b * b).sum();
        let standard_error = libm::sqrt(m / (m - 1.0) * paired) / pairs;
        let differs = paired > pairs * rounding * rounding;
        let variance_reduction = differs.then(|| independent / paired);
        Some(Self { degrees: m - 1.0, standard_error, variance_reduction })
    }

    /// Spread of residuals of both sides, each after its cycle's id, where cycles belong together
    /// in several ways.
    fn over(
        clusters: &Clusters,
        errors: &(impl Iterator<Item = (u64, f64, f64)> + Clone),
        pairs: f64,
        rounding: f64,
    ) -> Option<Self> {
        let spread_of = |error: &dyn Fn(f64, f64) -> f64| {
            clusters.spread(errors.clone().map(|(id, a, b)| (id, error(a, b) / pairs)))
        };
        let paired = spread_of(&|a, b| b - a)?;
        let independent = spread_of(&|a, _| a)?.variance + spread_of(&|_, b| b)?.variance;
        let differs = paired.variance * pairs > rounding * rounding;
        let variance_reduction = differs.then(|| independent / paired.variance);
        let standard_error = libm::sqrt(paired.variance);
        Some(Self { degrees: paired.degrees, standard_error, variance_reduction })
    }

    /// 95 % interval of the difference.
    fn ci95(&self, difference: f64) -> [f64; 2] {
        let half_width = student_975(self.degrees) * self.standard_error;
        [difference - half_width, difference + half_width]
    }
}

impl Comparison {
    /// Compares the records of the same cycles in two studies.
    pub fn of(
        quantity: &NamedQuantity,
        dependence: Dependence,
        a: &[Record],
        b: &[Record],
    ) -> Self {
        let (a, b) = (cycles(quantity, a), cycles(quantity, b));
        Self::of_cycles(quantity.column, dependence, &a, &b)
    }

    /// As [`Comparison::of`], of what is compared.
    fn of_cycles(column: &str, dependence: Dependence, a: &[Cycle], b: &[Cycle]) -> Self {
        let pair = |(a, b): (&Cycle, &Cycle)| Some((a.contribution?, b.contribution?));
        let pairs: Vec<Pair> = a.iter().zip(b).filter_map(pair).collect();
        let values: Vec<(f64, f64)> =
            pairs.iter().filter_map(|(a, b)| Some((a.value?, b.value?))).collect();
        let share = |holds: fn(f64, f64) -> bool| {
            let count = values.iter().filter(|(a, b)| holds(*a, *b)).count();
            (!values.is_empty()).then(|| count as f64 / values.len() as f64)
        };
        let means = Means::of(&pairs, dependence);
        let spread = means.and_then(|means| means.spread);
        let difference = means.map(|means| means.difference());
        Self {
            column: column.to_owned(),
            a: means.map(|means| means.a),
            b: means.map(|means| means.b),
            difference,
            ci95: difference.zip(spread).map(|(difference, spread)| spread.ci95(difference)),
            adjusted: None,
            parameter_uncertainty: None,
            share_a_lower: share(|a, b| a < b && !same(a, b)),
            share_equal: share(same),
            variance_reduction: spread.and_then(|spread| spread.variance_reduction),
            cycles: a.len() as u64,
            pairs: pairs.len() as u64,
            pairs_without_value: (pairs.len() - values.len()) as u64,
            a_without_quantity: without(a),
            b_without_quantity: without(b),
            a_failed: failed(a),
            b_failed: failed(b),
        }
    }

    /// How the second of two studies differs from the first one under a seed, adjusted where that
    /// can be. `first` adjusts the cycles of the first one.
    pub(super) fn of_studies(
        column: &str,
        studies: [&Study; 2],
        seed: u64,
        cycles: [&[Cycle]; 2],
        first: Option<&mut Adjuster>,
    ) -> Self {
        let [a, b] = studies.map(|study| Dependence::of(study.model(), seed));
        let adjusted = first.and_then(|first| {
            let mut other = adjuster(studies[1], seed, cycles[1].iter().map(|cycle| cycle.id))?;
            AdjustedDifference::of([first, &mut other], cycles)
        });
        Self { adjusted, ..Self::of_cycles(column, a.of_pairs(b), cycles[0], cycles[1]) }
    }
}

/// A cycle in both studies, by its own values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairOfValues {
    /// Id of the cycle.
    pub cycle_id: u64,
    /// Value in A.
    pub a: f64,
    /// Value in B.
    pub b: f64,
}

/// The values of the cycles that both studies completed, and of which both have one.
pub fn paired_values(quantity: &NamedQuantity, a: &[Record], b: &[Record]) -> Vec<PairOfValues> {
    let value = |record: &Record| contribution(quantity, record)?.value;
    let pair = |(a, b): (&Record, &Record)| {
        Some(PairOfValues { cycle_id: a.cycle_id, a: value(a)?, b: value(b)? })
    };
    a.iter().zip(b).filter_map(pair).collect()
}

/// Studies that were compared: how each but the first differs from it, and what each has driven.
pub struct Compared {
    /// One for each study but the baseline.
    pub comparisons: Vec<Comparison>,
    /// The records of each study, the baseline's first.
    pub fleets: Vec<Vec<Record>>,
}

/// Drives the plan in each study, and compares all of them with the first one, the baseline.
/// Without a quantity the first consumption that all of them have is compared: fuel, else
/// electricity, else the work at the wheels. Studies with uncertain numbers are driven on both
/// sides of them, too.
///
/// `progress` receives the number of cycles driven so far, over all studies, several times a
/// second, of those of [`cycles_of`]; breaking ends the comparison.
pub fn compare<B>(
    studies: &[&Study],
    plan: &RunPlan,
    quantity: Option<&NamedQuantity>,
    mut progress: impl FnMut(u64) -> ControlFlow<B>,
) -> ControlFlow<B, Compared> {
    let mut driven = Vec::with_capacity(studies.len());
    for (k, study) in (0..).zip(studies) {
        driven.push(records(study, plan, |cycles| progress(k * plan.cycles + cycles))?);
    }
    compare_driven(studies, plan, quantity, driven, progress)
}

/// As [`compare`], of studies that have driven the plan.
pub fn compare_driven<B>(
    studies: &[&Study],
    plan: &RunPlan,
    quantity: Option<&NamedQuantity>,
    driven: Vec<Vec<Record>>,
    mut progress: impl FnMut(u64) -> ControlFlow<B>,
) -> ControlFlow<B, Compared> {
    let mut before = plan.cycles * studies.len() as u64;
    let mut drive = |study: &Study, plan: &RunPlan| {
        let driven = records(study, plan, |cycles| progress(before + cycles))?;
        before += plan.cycles;
        ControlFlow::Continue(driven)
    };
    let fleets: Vec<&[Record]> = driven.iter().map(Vec::as_slice).collect();
    let quantity = quantity.unwrap_or_else(|| shared_consumption(&fleets));
    let mut effects = Vec::with_capacity(studies.len());
    for study in studies {
        effects.push(Effects::drive(study, plan, quantity, &mut drive)?);
    }
    let cycles: Vec<_> = fleets.iter().map(|records| cycles(quantity, records)).collect();
    let ids = || cycles[0].iter().map(|cycle| cycle.id);
    let mut first = studies.first().and_then(|study| adjuster(study, plan.seed, ids()));
    let mut compared = Vec::new();
    for k in 1..studies.len() {
        let (both, pairs) = ([studies[0], studies[k]], [&*cycles[0], &*cycles[k]]);
        let mut comparison =
            Comparison::of_studies(quantity.column, both, plan.seed, pairs, first.as_mut());
        let of_both = match (&effects[0], &effects[k]) {
            (Some(a), Some(b)) => b.clone().less(a),
            (Some(a), None) => Effects::nothing(quantity).less(a),
            (None, b) => b.clone(),
        };
        let [a, b] = both.map(|study| Dependence::of(study.model(), plan.seed));
        let replicates = a.of_pairs(b).replicates;
        let known = comparison.difference.zip(comparison.ci95).zip(of_both);
        comparison.parameter_uncertainty =
            known.map(|((mean, ci95), effects)| effects.around(mean, ci95, replicates));
        compared.push(comparison);
    }
    ControlFlow::Continue(Compared { comparisons: compared, fleets: driven })
}

/// Cycles that [`compare`] drives in all.
pub fn cycles_of(studies: &[&Study], plan: &RunPlan) -> u64 {
    let sides = studies.iter().map(|study| Effects::cycles_of(study, plan));
    plan.cycles.saturating_mul(studies.len() as u64).saturating_add(sides.sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::quantity;
    use crate::summary::SummaryBuilder;
    use ocmc_core::energy::Carrier;
    use ocmc_core::random::{Stream, Streams};

    const LITRES: &str = "consumption_l_per_100km";

    fn record(cycle_id: u64, distance_m: f64, litres: f64) -> Record {
        Record {
            cycle_id,
            distance_m,
            wheel_kwh_per_km: 1.0,
            ..Record::default().with(Carrier::LiquidFuel, [None, Some(litres), None])
        }
    }

    fn compared(a: &[Record], b: &[Record]) -> Comparison {
        Comparison::of(quantity(LITRES).expect("known"), Dependence::default(), a, b)
    }

    #[test]
    fn a_small_case_by_hand() {
        let a = [record(0, 1.0, 10.0), record(1, 1.0, 20.0), record(2, 2.0, 30.0)];
        let b = [record(0, 1.0, 12.0), record(1, 1.0, 20.0), record(2, 2.0, 33.0)];
        let c = compared(&a, &b);
        // 90/4 and 98/4
        assert_eq!((c.a, c.b, c.difference), (Some(22.5), Some(24.5), Some(2.0)));
        assert_eq!((c.share_a_lower, c.share_equal), (Some(2.0 / 3.0), Some(1.0 / 3.0)));
        // residuals over x̄ = 4/3: A −9.375, −1.875, 11.25; B −9.375, −3.375, 12.75; their
        // difference 0, −1.5, 1.5
        let half_width = 4.302652729749462 * (4.5_f64 / 6.0).sqrt();
        let [low, high] = c.ci95.expect("three pairs");
        assert!(
            (low - (2.0 - half_width)).abs() < 1e-12 && (high - 2.0 - half_width).abs() < 1e-12
        );
        let squares = |e: [f64; 3]| e.iter().map(|x| x * x).sum::<f64>();
        let independent = squares([-9.375, -1.875, 11.25]) + squares([-9.375, -3.375, 12.75]);
        let reduction = c.variance_reduction.expect("they differ");
        assert!((reduction - independent / 4.5).abs() < 1e-9, "{reduction}");
    }

    #[test]
    fn the_pairs_are_the_cycles_that_both_have() {
        let good: Vec<Record> = (0..3).map(|id| record(id, 1.0, 10.0 + id as f64)).collect();
        let (mut a, mut b) = (good.clone(), good);
        a[0].outcome = Outcome::Stalled;
        b[1].of_carrier_mut(Carrier::LiquidFuel)[1] = Some(14.0);
        b[2].of_carrier_mut(Carrier::LiquidFuel)[1] = None;
        let pairs = paired_values(quantity(LITRES).expect("known"), &a, &b);
        assert_eq!(pairs, [PairOfValues { cycle_id: 1, a: 11.0, b: 14.0 }]);
    }

    #[test]
    fn only_cycles_that_both_completed_are_compared_and_the_others_are_counted() {
        let good: Vec<Record> = (0..4).map(|id| record(id, 1.0, 10.0 + id as f64)).collect();
        let (mut a, mut b) = (good.clone(), good);
        a[1].outcome = Outcome::Stalled;
        b[1].outcome = Outcome::Stalled;
        b[2].outcome = Outcome::TimedOut;
        b[2].of_carrier_mut(Carrier::LiquidFuel)[1] = Some(900.0);
        let c = compared(&a, &b);
        assert_eq!((c.cycles, c.pairs, c.a_failed, c.b_failed), (4, 2, 1, 2));
        assert_eq!((c.difference, c.ci95), (Some(0.0), Some([0.0, 0.0])));
        assert_eq!((c.variance_reduction, c.share_equal), (None, Some(1.0)));
    }

    const PER_TONNE: &str = "consumption_l_per_100tkm";

    /// A cycle of 10 km: 10 t, or an empty trip.
    fn trip(cycle_id: u64, litres: f64, loaded: bool) -> Record {
        let payload_kg = if loaded { 10_000.0 } else { 0.0 };
        Record {
            payload_kg,
            mean_payload_kg: payload_kg,
            ..record(cycle_id, 10_000.0, litres)
                .with(Carrier::LiquidFuel, [None, Some(litres), loaded.then_some(litres / 10.0)])
        }
    }

    #[test]
    fn empty_trips_count_in_the_means_and_are_no_failures() {
        let trips = |factor: f64| -> Vec<Record> {
            (0..9).map(|id| trip(id, factor * (20.0 + id as f64), id % 3 > 0)).collect()
        };
        let (a, mut b) = (trips(1.0), trips(0.9));
        let per_tonne = quantity(PER_TONNE).expect("known");
        let c = Comparison::of(per_tonne, Dependence::default(), &a, &b);
        // 216 l per 100 km of nine cycles over six loads of 10 t
        let mut run = SummaryBuilder::default();
        run.add(&a);
        let mean = run.finish().statistic(PER_TONNE).expect("reported").mean;
        assert!((c.a.expect("pairs") - 3.6).abs() < 1e-12, "{c:?}");
        assert!((mean.expect("cycles") - 3.6).abs() < 1e-12, "a run says the same");
        assert!((c.b.expect("pairs") - 3.24).abs() < 1e-12, "{c:?}");
        assert_eq!((c.pairs, c.pairs_without_value, c.a_failed, c.b_failed), (9, 3, 0, 0));
        assert_eq!((c.share_a_lower, c.share_equal), (Some(0.0), Some(0.0)));
        b[0].outcome = Outcome::Stalled;
        let c = Comparison::of(per_tonne, Dependence::default(), &a, &b);
        assert_eq!((c.pairs, c.pairs_without_value, c.a_failed, c.b_failed), (8, 2, 0, 1));
    }

    #[test]
    fn what_differs_by_rounding_is_the_same() {
        let a: Vec<Record> = (0..9).map(|id| record(id, 1.0, 20.0 + id as f64)).collect();
        let times = |factor: f64| -> Vec<Record> {
            let litres = |k: usize| if k.is_multiple_of(2) { factor } else { 1.0 / factor };
            (0..9).map(|k| record(k as u64, 1.0, (20.0 + k as f64) * litres(k))).collect()
        };
        let rounded = compared(&a, &times(1.0 + 5e-6));
        assert_eq!((rounded.share_a_lower, rounded.share_equal), (Some(0.0), Some(1.0)));
        assert_eq!(rounded.variance_reduction, None);
        let other = compared(&a, &times(1.0 + 1e-4));
        assert_eq!((other.share_a_lower, other.share_equal), (Some(5.0 / 9.0), Some(0.0)));
        assert!(other.variance_reduction.is_some());
    }

    #[test]
    fn nothing_and_one_pair() {
        let none = compared(&[], &[]);
        assert_eq!((none.a, none.difference, none.share_a_lower), (None, None, None));
        let one = compared(&[record(0, 1.0, 10.0)], &[record(0, 1.0, 12.0)]);
        assert_eq!((one.difference, one.ci95), (Some(2.0), None));
    }

    #[test]
    fn the_interval_covers_the_difference_of_a_known_population_95_times_in_100() {
        // distances log-normal; A = 30 + road, B = A + 1 + a little of its own: the difference of
        // the means is 1
        const RUNS: u32 = 1000;
        let mut covered = 0;
        let mut reductions = 0.0;
        for run in 0..RUNS {
            let mut draws = Streams::new(1, u64::from(run)).open(Stream::CurveResidual);
            let (a, b): (Vec<_>, Vec<_>) = (0..200)
                .map(|id| {
                    let distance_m = libm::exp(0.5 * draws.normal());
                    let litres = 30.0 + 3.0 * draws.normal();
                    let other = litres + 1.0 + 0.5 * draws.normal();
                    (record(id, distance_m, litres), record(id, distance_m, other))
                })
                .unzip();
            let c = compared(&a, &b);
            let [low, high] = c.ci95.expect("200 pairs");
            covered += u32::from(low <= 1.0 && 1.0 <= high);
            reductions += c.variance_reduction.expect("they differ") / f64::from(RUNS);
        }
        let share = f64::from(covered) / f64::from(RUNS);
        let standard_error = libm::sqrt(0.95 * 0.05 / f64::from(RUNS));
        assert!((share - 0.95).abs() < 4.0 * standard_error, "{share}");
        // (9 + 9.25) / 0.25. A mean of quotients lies 2/m too high, where distances as spread as
        // these leave m = 200/e of 200 degrees of freedom: 2.8 %
        assert!((reductions / (73.0 * 1.028) - 1.0).abs() < 0.02, "{reductions}");
    }
}

//! Comparison of two studies under common random numbers: both drive the same cycle ids under one seed, so that
//! whatever they do not differ in is the same, cycle by cycle, and falls out of the difference.
//!
//! With R = Σ y / Σ x the fleet's mean on each side (see [`super::ratio`]), the difference is R_B − R_A. Its linearised
//! standard error is that of a mean of paired residuals:
//!
//! e_Aᵢ = (y_Aᵢ − R_A x_Aᵢ) / x̄_A,  e_B alike,  se² = Σ (e_Bᵢ − e_Aᵢ)² / (n (n − 1))
//!
//! Two independent runs of the same size would have se² = Σ (e_Aᵢ² + e_Bᵢ²) / (n (n − 1)); the quotient of the two is
//! the variance reduction. Where cycles depend on one another, the residuals of a batch are added up first (see
//! [`super::dependence`]). Source: W. G. Cochran, *Sampling Techniques*, 3rd ed. (1977), section 6.4, for the residuals;
//! the rest is the variance of a difference.

use super::dependence::Dependence;
use super::quantity::{Quantity, consumption};
use super::ratio::student_975;
use super::run::{RunPlan, records};
use crate::simulation::record::Record;
use crate::study::Study;
use serde::Serialize;
use std::ops::ControlFlow;

/// How study B differs from study A.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Name of the quantity.
    pub column: &'static str,
    /// The fleet's mean of A, over the pairs.
    pub a: Option<f64>,
    /// The fleet's mean of B, over the pairs.
    pub b: Option<f64>,
    /// B less A.
    pub difference: Option<f64>,
    /// 95 % interval of the difference; none from fewer than two pairs, or batches of pairs.
    pub ci95: Option<[f64; 2]>,
    /// Share of the pairs in which A is lower.
    pub share_a_lower: Option<f64>,
    /// Share of the pairs in which both are the same.
    pub share_equal: Option<f64>,
    /// Variance of the difference of two independent runs over that of the pairs; none where the pairs do not differ.
    pub variance_reduction: Option<f64>,
    /// Cycles that were driven in each study.
    pub cycles: u64,
    /// Cycles that both completed and that have the quantity in both: the pairs.
    pub pairs: u64,
    /// Cycles that A did not complete, or where A does not have the quantity.
    pub a_failed: u64,
    /// Cycles that B did not complete, or where B does not have the quantity.
    pub b_failed: u64,
}

/// One cycle in one study: its own value, and what it adds to the two totals y and x of the mean.
#[derive(Clone, Copy, Debug)]
struct Row {
    cycle_id: u64,
    value: f64,
    y: f64,
    x: f64,
}

fn rows(quantity: &Quantity, records: &[Record]) -> Vec<Option<Row>> {
    let row = |record: &Record| {
        let (y, x) = quantity.totals(record)?;
        Some(Row { cycle_id: record.cycle_id, value: quantity.of_cycle(record)?, y, x })
    };
    records.iter().map(row).collect()
}

/// One side of the pairs: the fleet's mean, and each pair's residual after its cycle's id.
fn side(rows: impl Iterator<Item = Row> + Clone) -> Option<(f64, Vec<(u64, f64)>)> {
    let n = rows.clone().count() as f64;
    let y: f64 = rows.clone().map(|row| row.y).sum();
    let x: f64 = rows.clone().map(|row| row.x).sum();
    let ratio = y / x;
    let residual = |row: Row| (row.cycle_id, (row.y - ratio * row.x) / (x / n));
    let residuals = rows.map(residual).collect();
    (x > 0.0).then_some((ratio, residuals))
}

impl Comparison {
    /// Compares the records of the same cycles in two studies.
    pub fn of(quantity: &Quantity, dependence: Dependence, a: &[Record], b: &[Record]) -> Self {
        Self::of_rows(quantity.column, dependence, &rows(quantity, a), &rows(quantity, b))
    }

    fn of_rows(
        column: &'static str,
        dependence: Dependence,
        a: &[Option<Row>],
        b: &[Option<Row>],
    ) -> Self {
        let failed = |rows: &[Option<Row>]| rows.iter().filter(|row| row.is_none()).count() as u64;
        let pairs: Vec<(Row, Row)> =
            a.iter().zip(b).filter_map(|(a, b)| Some(((*a)?, (*b)?))).collect();
        let n = pairs.len() as f64;
        let share = |holds: fn(&(Row, Row)) -> bool| {
            let count = pairs.iter().filter(|pair| holds(pair)).count();
            (n > 0.0).then(|| count as f64 / n)
        };
        let mut comparison = Self {
            column,
            a: None,
            b: None,
            difference: None,
            ci95: None,
            share_a_lower: share(|(a, b)| a.value < b.value),
            share_equal: share(|(a, b)| a.value == b.value),
            variance_reduction: None,
            cycles: a.len() as u64,
            pairs: pairs.len() as u64,
            a_failed: failed(a),
            b_failed: failed(b),
        };
        let sides = (side(pairs.iter().map(|pair| pair.0)), side(pairs.iter().map(|pair| pair.1)));
        let (Some((mean_a, errors_a)), Some((mean_b, errors_b))) = sides else {
            return comparison;
        };
        let difference = mean_b - mean_a;
        comparison.a = Some(mean_a);
        comparison.b = Some(mean_b);
        comparison.difference = Some(difference);
        let errors = errors_a.iter().zip(&errors_b);
        let errors = dependence.batch_totals(errors.map(|((id, a), (_, b))| (*id, *a, *b)));
        if errors.len() < 2 {
            return comparison;
        }
        let m = errors.len() as f64;
        let paired: f64 = errors.iter().map(|(a, b)| (b - a) * (b - a)).sum();
        let independent: f64 = errors.iter().map(|(a, b)| a * a + b * b).sum();
        let standard_error = libm::sqrt(m / (m - 1.0) * paired) / n;
        let half_width = student_975(m - 1.0) * standard_error;
        comparison.ci95 = Some([difference - half_width, difference + half_width]);
        comparison.variance_reduction = (paired > 0.0).then(|| independent / paired);
        comparison
    }
}

/// Drives the plan in each study, and compares all of them with the first one, the baseline. Without a quantity the
/// consumption of the baseline is compared.
///
/// `progress` receives the number of cycles driven so far, over all studies, several times a second; breaking ends the
/// comparison.
pub fn compare<B>(
    studies: &[&Study],
    plan: &RunPlan,
    quantity: Option<&'static Quantity>,
    mut progress: impl FnMut(u64) -> ControlFlow<B>,
) -> ControlFlow<B, Vec<Comparison>> {
    let mut driven = Vec::with_capacity(studies.len());
    for (k, study) in studies.iter().enumerate() {
        let before = k as u64 * plan.cycles;
        driven.push(records(study, plan, |cycles| progress(before + cycles))?);
    }
    let Some((baseline, others)) = driven.split_first() else {
        return ControlFlow::Continue(Vec::new());
    };
    let quantity = quantity.unwrap_or_else(|| consumption(baseline));
    // pairs depend on one another where the cycles of either study do
    let of = |study: &Study| Dependence::of(study.model()).batch;
    let compare = |(other, study): (&Vec<Record>, &&Study)| {
        let batch = of(studies[0]).max(of(study));
        let dependence = Dependence { batch, replicates: None };
        Comparison::of(quantity, dependence, baseline, other)
    };
    ControlFlow::Continue(others.iter().zip(&studies[1..]).map(compare).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fleet::quantity::quantity;
    use crate::random::{Stream, Streams};
    use crate::simulation::record::Outcome;

    const LITRES: &str = "consumption_l_per_100km";

    fn record(cycle_id: u64, distance_m: f64, litres: f64) -> Record {
        Record {
            cycle_id,
            distance_m,
            consumption_l_per_100km: Some(litres),
            wheel_kwh_per_km: 1.0,
            ..Record::default()
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
        // residuals over x̄ = 4/3: A −9.375, −1.875, 11.25; B −9.375, −3.375, 12.75; their difference 0, −1.5, 1.5
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
    fn only_cycles_that_both_completed_are_compared_and_the_others_are_counted() {
        let good: Vec<Record> = (0..4).map(|id| record(id, 1.0, 10.0 + id as f64)).collect();
        let (mut a, mut b) = (good.clone(), good);
        a[1].outcome = Outcome::Stalled;
        b[1].outcome = Outcome::Stalled;
        b[2].outcome = Outcome::TimedOut;
        b[2].consumption_l_per_100km = Some(900.0);
        let c = compared(&a, &b);
        assert_eq!((c.cycles, c.pairs, c.a_failed, c.b_failed), (4, 2, 1, 2));
        assert_eq!((c.difference, c.ci95), (Some(0.0), Some([0.0, 0.0])));
        assert_eq!((c.variance_reduction, c.share_equal), (None, Some(1.0)));
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
        // distances log-normal; A = 30 + road, B = A + 1 + a little of its own: the difference of the means is 1
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
        // (9 + 9.25) / 0.25. A mean of quotients lies 2/m too high, where distances as spread as these leave m = 200/e of
        // 200 degrees of freedom: 2.8 %
        assert!((reductions / (73.0 * 1.028) - 1.0).abs() < 0.02, "{reductions}");
    }
}

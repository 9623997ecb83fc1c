//! Pairs of the same cycle in two studies, and what each side adds to the fleet's mean.

use super::quantity::NamedQuantity;
use ocmc_core::record::{Outcome, Record};

/// One cycle in one study: its own value, where it has one, and what it adds to the two totals y
/// and x of the mean.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contribution {
    pub cycle_id: u64,
    pub value: Option<f64>,
    pub y: f64,
    pub x: f64,
}

/// One cycle of a study, as far as a quantity of it is compared.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cycle {
    pub id: u64,
    pub outcome: Outcome,
    pub contribution: Option<Contribution>,
}

/// The cycles of a study, as far as a quantity of them is compared.
pub(crate) fn cycles(quantity: &NamedQuantity, records: &[Record]) -> Vec<Cycle> {
    let cycle = |record: &Record| {
        let Record { cycle_id: id, outcome, .. } = *record;
        Cycle { id, outcome, contribution: contribution(quantity, record) }
    };
    records.iter().map(cycle).collect()
}

/// One cycle in both studies.
pub(crate) type Pair = (Contribution, Contribution);

/// Contribution of a cycle to the fleet's mean; none where it was not completed, or has nothing of
/// the quantity.
pub(crate) fn contribution(quantity: &NamedQuantity, record: &Record) -> Option<Contribution> {
    let (y, x) = quantity.totals(record)?;
    Some(Contribution { cycle_id: record.cycle_id, value: quantity.of_cycle(record), y, x })
}

/// One side of the pairs: the fleet's mean, and each pair's residual after its cycle's id.
pub(crate) fn side(
    contributions: impl Iterator<Item = Contribution> + Clone,
) -> Option<(f64, Vec<(u64, f64)>)> {
    let n = contributions.clone().count() as f64;
    let y: f64 = contributions.clone().map(|contribution| contribution.y).sum();
    let x: f64 = contributions.clone().map(|contribution| contribution.x).sum();
    let ratio = y / x;
    let residual = |contribution: Contribution| {
        (contribution.cycle_id, (contribution.y - ratio * contribution.x) / (x / n))
    };
    let residuals = contributions.map(residual).collect();
    (x > 0.0).then_some((ratio, residuals))
}

//! A sweep: many studies on the same cycles, each compared with the first one as
//! [`super::comparison`] does. Of their cycles no more is kept than what the comparison takes.

use super::clustering::Clusters;
use super::comparison::{Comparison, adjuster, failed};
use super::dependence::Dependence;
use super::pair::{Cycle, cycles};
use super::quantity::{Consumed, NamedQuantity, QUANTITIES};
use super::ratio::Ratio;
use super::run::{RunPlan, records};
use ocmc_core::study::Study;
use std::ops::ControlFlow;

/// One of the studies.
#[derive(Clone, Debug)]
pub struct SweptStudy {
    /// The fleet's mean over all of its own cycles, and its interval.
    pub mean: Option<Ratio>,
    /// Cycles that were not completed.
    pub failed: u64,
    /// How it differs from the first one; none of that one itself.
    pub comparison: Option<Comparison>,
}

/// Quantity by which studies were compared, and each of them.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// Name of the quantity.
    pub column: String,
    /// Whether it is another one than the first study alone is judged by.
    pub is_common: bool,
    /// The studies, in their order.
    pub studies: Vec<SweptStudy>,
}

/// Drives the plan in each study, and compares all of them with the first one: by a quantity, or
/// else by the first consumption that all of them have.
///
/// `progress` receives the number of cycles driven so far, over all studies, several times a
/// second; breaking ends the sweep.
pub fn sweep<B>(
    studies: &[&Study],
    plan: &RunPlan,
    asked: Option<&NamedQuantity>,
    mut progress: impl FnMut(u64) -> ControlFlow<B>,
) -> ControlFlow<B, Sweep> {
    let mut candidates: Vec<&NamedQuantity> = asked.into_iter().collect();
    let mut consumed = Vec::with_capacity(studies.len());
    let mut kept: Vec<Vec<Vec<Cycle>>> = Vec::with_capacity(studies.len());
    for (k, study) in studies.iter().enumerate() {
        let before = plan.cycles * k as u64;
        let records = records(study, plan, |cycles| progress(before + cycles))?;
        consumed.push(Consumed::of(&records));
        if candidates.is_empty() {
            // what all have the first one has, too
            candidates.extend(consumed[0].has.iter().copied());
            candidates.extend(consumed[0].has.is_empty().then_some(&QUANTITIES[0]));
        }
        kept.push(candidates.iter().map(|quantity| cycles(quantity, &records)).collect());
    }
    let shared = Consumed::shared(&consumed);
    let place = candidates.iter().position(|quantity| quantity.column == shared.column);
    let place = if asked.is_some() { 0 } else { place.unwrap_or_default() };
    let quantity = candidates.get(place).copied().unwrap_or(shared);
    let of_first = consumed.get(..1).map_or(quantity.column, |own| Consumed::shared(own).column);
    let is_common = asked.is_none() && quantity.column != of_first;
    let cycles_of = |k: usize| kept[k][place].as_slice();
    let ids = || cycles_of(0).iter().map(|cycle| cycle.id);
    let mut first = studies.first().and_then(|study| adjuster(study, plan.seed, ids()));
    let mut swept = Vec::with_capacity(studies.len());
    for (k, study) in studies.iter().enumerate() {
        let own = cycles_of(k);
        let compared = |first| {
            let (both, pairs) = ([studies[0], study], [cycles_of(0), own]);
            Comparison::of_studies(quantity.column, both, plan.seed, pairs, first)
        };
        swept.push(SweptStudy {
            mean: mean(quantity, study, plan.seed, own),
            failed: failed(own),
            comparison: (k > 0).then(|| compared(first.as_mut())),
        });
        // the adjustment of many studies takes its time, too
        progress(plan.cycles * studies.len() as u64)?;
    }
    ControlFlow::Continue(Sweep { column: quantity.column.to_owned(), is_common, studies: swept })
}

/// The mean of a fleet, as a run has it.
fn mean(quantity: &NamedQuantity, study: &Study, seed: u64, cycles: &[Cycle]) -> Option<Ratio> {
    let contributions = cycles.iter().filter_map(|cycle| cycle.contribution);
    let totals = contributions.map(|cycle| (cycle.cycle_id, cycle.y, cycle.x));
    let dependence = Dependence::of(study.model(), seed);
    let mean = Clusters::of(dependence, totals.clone().map(|(id, ..)| id)).ratio(totals)?;
    let ci95 = mean.ci95.map(|[low, high]| [low.max(quantity.least()), high]);
    Some(Ratio { ci95, ..mean })
}

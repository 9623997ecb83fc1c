//! One trip, step by step, thinned for a picture of it.

use super::thinned::thinned;
use crate::study::LoadedStudy;
use crate::trace::trace;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// Most steps of an answer.
const MOST_STEPS: usize = 2000;

/// Course of a trip.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct TripAnswer {
    /// Id of the cycle.
    pub cycle: u64,
    /// Columns as of `ocmc trace`, at most 2000 steps evenly apart, and what the steps between two
    /// of them add; null for what is not finite.
    pub columns: BTreeMap<&'static str, Vec<Option<f64>>>,
}

/// Prefix of the columns that count additions of a step.
const ADDED: &str = "_added_";

/// Drives one cycle.
pub(super) fn trip(study: &LoadedStudy, seed: u64, cycle: u64) -> TripAnswer {
    let columns = trace(study, seed, cycle).columns.into_iter().map(|column| {
        let values = if column.name.contains(ADDED) {
            sums(&column.values, MOST_STEPS)
        } else {
            thinned(&column.values, MOST_STEPS)
        };
        let finite = |value: f64| Some(value).filter(|value| value.is_finite());
        (column.name, values.into_iter().map(finite).collect())
    });
    TripAnswer { cycle, columns: columns.collect() }
}

/// Sums of the additions of steps from one of the rows that [`thinned`] leaves to the next.
fn sums(values: &[f64], most: usize) -> Vec<f64> {
    let mut total = 0.0;
    let so_far: Vec<f64> = values
        .iter()
        .map(|value| {
            total += value;
            total
        })
        .collect();
    let mut before = 0.0;
    let since = |so_far| so_far - std::mem::replace(&mut before, so_far);
    thinned(&so_far, most).into_iter().map(since).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_steps_add_stays_when_rows_are_left_out() {
        assert_eq!(sums(&[1.0, 2.0, 3.0, 4.0, 5.0], 3), [1.0, 5.0, 9.0]);
        assert_eq!(sums(&[1.0, 2.0], 3), [1.0, 2.0]);
    }
}

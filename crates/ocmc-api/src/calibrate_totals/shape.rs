//! Mean and quantiles of a fleet's consumption, of a table, of a study, and of both together.

use ocmc_core::record::Record;
use ocmc_fleet::quantity::NamedQuantity;
use schemars::JsonSchema;
use serde::Serialize;

/// SD of the error of a calibrated study's quantiles, as a share: 2 to 4 % of invented fleets
/// (`scripts/totals_check.py`).
const STUDY_SD: f64 = 0.03;
/// Half the width, in probability, over which a quantile's density is taken.
const WIDTH: f64 = 0.025;

/// Mean, and quantiles over the trips.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Shape {
    /// Amount over distance of all.
    pub mean: f64,
    /// 5th percentile.
    pub p5: f64,
    /// 95th percentile.
    pub p95: f64,
}

impl Shape {
    /// Shape of trips, and their consumptions in order.
    pub(super) fn of(quantity: &NamedQuantity, records: &[Record]) -> (Self, Vec<f64>) {
        let totals = records.iter().filter_map(|record| quantity.totals(record));
        let sums = totals.fold([0.0; 2], |sum, (a, d)| [sum[0] + a, sum[1] + d]);
        let values = records.iter().filter_map(|record| quantity.of_cycle(record));
        Self::with(sums[0] / sums[1], values.collect())
    }

    /// Shape of trips of these lengths and consumptions.
    pub(super) fn of_each(lengths: &[f64], each: Vec<f64>) -> Self {
        let amount: f64 = lengths.iter().zip(&each).map(|(length, each)| length * each).sum();
        Self::with(amount / lengths.iter().sum::<f64>(), each).0
    }

    /// The table's mean, and the quantiles of its `n` rows and of a calibrated study, weighed by
    /// their errors: that of rows is √(p (1 − p)/n)/f, with the density f of the study's trips.
    pub(super) fn together(&self, study: &Self, trips: &[f64], n: f64) -> Self {
        let middle = quantile(trips, 0.5);
        let weighed = |p: f64, of_rows: f64, of_study: f64| {
            let [below, above] = [p - WIDTH, p + WIDTH].map(|p| quantile(trips, p));
            let per_probability = (above - below) / (2.0 * WIDTH) / middle;
            let rows_sd = libm::sqrt(p * (1.0 - p) / n) * per_probability;
            let [rows, study] = [rows_sd, STUDY_SD].map(|sd| 1.0 / (sd * sd).max(1e-12));
            (rows * of_rows + study * of_study) / (rows + study)
        };
        let (p5, p95) = (weighed(0.05, self.p5, study.p5), weighed(0.95, self.p95, study.p95));
        Self { mean: self.mean, p5, p95 }
    }

    fn with(mean: f64, mut values: Vec<f64>) -> (Self, Vec<f64>) {
        values.sort_by(f64::total_cmp);
        let [p5, p95] = [0.05, 0.95].map(|p| quantile(&values, p));
        (Self { mean, p5, p95 }, values)
    }

    pub(super) fn times(self, factor: f64) -> Self {
        Self { mean: factor * self.mean, p5: factor * self.p5, p95: factor * self.p95 }
    }
}

/// A quantile of values in order, linear between them.
pub(super) fn quantile(values: &[f64], p: f64) -> f64 {
    let Some(last) = values.len().checked_sub(1) else { return f64::NAN };
    let place = p * last as f64;
    let below = libm::floor(place);
    let k = below as usize;
    values[k] + (place - below) * (values[(k + 1).min(last)] - values[k])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_rows_leave_the_study_and_many_replace_it() {
        // a uniform law from 0.5 to 1.5: its density is 1
        let trips: Vec<f64> = (0..=1000).map(|k| 0.5 + f64::from(k) / 1000.0).collect();
        let shape = |p5: f64, p95: f64| Shape { mean: 1.0, p5, p95 };
        let (rows, study) = (shape(0.6, 1.5), shape(0.5, 1.4));
        let together = |n| rows.together(&study, &trips, n);
        assert!(together(2.0).p5 < 0.52 && together(1e5).p5 > 0.599);
        // by hand: 0.05 × 0.95/53 = 0.03²: both count the same
        let same = together(53.0);
        assert!((same.p5 - 0.55).abs() < 1e-3 && (same.p95 - 1.45).abs() < 1e-3, "{same:?}");
    }
}

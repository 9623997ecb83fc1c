//! Means and quantiles that are adjusted by what the cycles are known to have on average.
//!
//! A run happens to draw heavier trips than the study says, or more of the motorway; what its trips
//! were expected to have is known (`outline_sample`). With z_i the terms of cycle i, each
//! less its expectation, and β the coefficients of a regression of the quantity on them,
//!
//! θ = ȳ − βᵀ z̄ = Σ c_i y_i,   c_i = 1/n − w_i x_iᵀ A⁻¹ (0, z̄),   x_i = (1, z_i),   A = Σ w_i x_i
//! x_iᵀ
//!
//! is the regression estimator of the mean. Weights c_i make Σ c_i = 1 and Σ c_i z_i = 0; a ratio
//! is Σ c_i y_i / Σ c_i x_i. Cycles that do not count have y = x = 0 and stay in the sums, since
//! what was expected was expected of them, too. The weights w_i are Huber's on the residuals of the
//! fleet's consumption, so that few strange cycles do not decide β.
//!
//! The error of θ is Σ c_i r_i, with r the residuals as they are where the cycle's truck (batch) is
//! left out, r_g = (I − H_gg)⁻¹ e_g: the jackknife over trucks, which knows how many terms were
//! fitted to how few of them. Clusters are counted as for the plain mean ([`super::clustering`]),
//! and the error of the expectations, βᵀ Cov β, is added. Where there are fewer than five clusters
//! for a term, the last terms are left out; below five there is the plain mean alone.
//!
//! A quantile: with v̂ what the regression says of a cycle's own value and σ the spread of its
//! residuals, m = Φ((q − v̂)/σ) is about the probability of a value below q. The share below q is
//! then that of the cycles less b times what the mean of m over the cycles lies above its mean over
//! the drawn outlines; b by regression. The quantile is the order statistic at the level that takes
//! this difference away, its interval that of Woodruff.
//!
//! Sources: C.-E. Särndal, B. Swensson, J. Wretman, *Model Assisted Survey Sampling* (1992),
//! sections 6.4 and 5.11 \[PK\]; J.-C. Deville, C.-E. Särndal, *Journal of the American Statistical
//! Association* 87 (1992) 376, for the weights \[PK\]; R. M. Bell, D. F. McCaffrey, *Survey
//! Methodology* 28 (2002) 169, for the residuals \[PK\].

use super::clustering::Clusters;
use super::dependence::Dependence;
use super::outline_sample::{OutlineSample, Terms, outlines_for};
use super::quantile::{LEVELS, quantile};
use super::ratio::student_975;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use ocmc_core::study::Study;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Clusters for each term.
const CLUSTERS_A_TERM: usize = 5;

/// Cycles beyond which nothing is adjusted: what sampling leaves open is small then, and the terms
/// of all cycles would take much memory.
pub const MOST_CYCLES: usize = 1 << 18;

/// Residuals in units of their spread from which a cycle counts less.
const HUBER: f64 = 2.5;
/// Rounds of the robust fit.
const ROUNDS: usize = 3;
/// Standard deviation over the median of the absolute values, of a normal law.
const OVER_MEDIAN: f64 = 1.4826;

/// An adjusted value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Adjusted {
    /// The value.
    pub value: f64,
    /// 95 % interval, the error of the expectations included.
    pub ci95: [f64; 2],
}

/// The adjusted values of a quantity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AdjustedStatistic {
    /// Mean of the fleet.
    pub mean: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
    /// Quantiles over the cycles, by their names; those that have an interval.
    #[serde(default)]
    pub quantiles: BTreeMap<String, Adjusted>,
}

/// Collects the cycles of a run, and draws what they were expected to have.
#[derive(Clone, Debug)]
pub struct Adjuster {
    study: Arc<Study>,
    seed: u64,
    dependence: Dependence,
    ids: Vec<u64>,
    outlines: Vec<Vec<f64>>,
    sample: Option<Arc<OutlineSample>>,
}

impl Adjuster {
    /// For the cycles of a study under a seed; none where trips of trucks take factors from the
    /// first of them, whose expectation no other sample knows.
    pub fn new(study: Arc<Study>, seed: u64) -> Option<Self> {
        let frozen = !study.model().simulation.frozen.is_empty();
        let dependence = Dependence::of(study.model(), seed);
        let known = !(frozen && dependence.has_trucks()) && dependence.replicates.is_none();
        let (ids, outlines) = (Vec::new(), Vec::new());
        known.then_some(Self { study, seed, dependence, ids, outlines, sample: None })
    }

    /// Adds the next cycle.
    pub(super) fn add(&mut self, cycle_id: u64) {
        if self.ids.len() <= MOST_CYCLES {
            self.ids.push(cycle_id);
        }
    }

    /// The adjustment of the cycles so far. `totals`: of each of them, in their order, what it adds
    /// to the two totals of the consumption by which unusual cycles are recognised.
    pub(super) fn adjustment(&mut self, totals: &[(f64, f64)]) -> Option<Adjustment> {
        let cycles = self.ids.len();
        if cycles > MOST_CYCLES || totals.len() != cycles || cycles < CLUSTERS_A_TERM {
            return None;
        }
        let (study, seed) = (&self.study, self.seed);
        let known = self.outlines.len();
        let new = self.ids[known..].par_iter().map(|id| study.outline(seed, *id));
        self.outlines.extend(new.collect::<Vec<_>>());
        let count = outlines_for(cycles as u64);
        if self.sample.as_ref().is_none_or(|sample| sample.len() < count) {
            self.sample = Some(Arc::new(OutlineSample::draw(study, seed, count)));
        }
        let sample = self.sample.clone()?;
        Adjustment::of(
            self.dependence,
            &study.outline_names(),
            &self.ids,
            &self.outlines,
            sample,
            totals,
        )
    }
}

/// The adjustment of the cycles of a run.
#[derive(Clone, Debug)]
pub struct Adjustment {
    ids: Vec<u64>,
    clusters: Clusters,
    /// Rows (1, z_i).
    rows: DMatrix<f64>,
    /// Weights of the fit.
    weights: Vec<f64>,
    normal: Cholesky<f64, Dyn>,
    /// A itself, for the residuals without a cluster.
    gram: DMatrix<f64>,
    /// c_i.
    calibrated: Vec<f64>,
    /// Cycles of the same cluster, one behind the other.
    blocks: Vec<std::ops::Range<usize>>,
    terms: Terms,
    sample: Arc<OutlineSample>,
    /// Covariance of the errors of the expectations, the constant first.
    error: DMatrix<f64>,
}

impl Adjustment {
    fn of(
        dependence: Dependence,
        names: &[String],
        ids: &[u64],
        outlines: &[Vec<f64>],
        sample: Arc<OutlineSample>,
        totals: &[(f64, f64)],
    ) -> Option<Self> {
        let blocks = blocks(ids, dependence.batch);
        let terms = sample.terms(names, outlines, blocks.len() / CLUSTERS_A_TERM)?;
        let p = terms.len() + 1;
        let mut rows = DMatrix::zeros(p, ids.len());
        for (k, outline) in outlines.iter().enumerate() {
            rows[(0, k)] = 1.0;
            rows.view_mut((1, k), (p - 1, 1)).copy_from_slice(&terms.of(outline));
        }
        let mut error = DMatrix::zeros(p, p);
        error.view_mut((1, 1), (p - 1, p - 1)).copy_from(&sample.error(&terms));
        let weights = vec![1.0; ids.len()];
        let gram = gram(&rows, &weights);
        let normal = Cholesky::new(gram.clone())?;
        let (ids, calibrated) = (ids.to_vec(), Vec::new());
        let clusters = Clusters::of(dependence, ids.iter().copied());
        let mut own = Self {
            ids,
            clusters,
            rows,
            weights,
            normal,
            gram,
            calibrated,
            blocks,
            terms,
            sample,
            error,
        };
        own.weigh(totals)?;
        own.calibrate();
        Some(own)
    }

    /// Huber's weights on the residuals of a ratio.
    fn weigh(&mut self, totals: &[(f64, f64)]) -> Option<()> {
        let sums = totals.iter().fold((0.0, 0.0), |sum, pair| (sum.0 + pair.0, sum.1 + pair.1));
        let ratio = sums.0 / sums.1;
        if !ratio.is_finite() {
            return None;
        }
        let residuals: Vec<f64> = totals.iter().map(|(y, x)| y - ratio * x).collect();
        for _ in 0..ROUNDS {
            let errors = self.errors(&residuals, &self.coefficients(&residuals));
            let mut sizes: Vec<f64> = errors.iter().map(|e| libm::fabs(*e)).collect();
            sizes.sort_unstable_by(f64::total_cmp);
            let far = HUBER * OVER_MEDIAN * quantile(&sizes, 0.5)?;
            if far <= 0.0 {
                return Some(());
            }
            self.weights = errors.iter().map(|e| (far / libm::fabs(*e)).min(1.0)).collect();
            self.gram = gram(&self.rows, &self.weights);
            self.normal = Cholesky::new(self.gram.clone())?;
        }
        Some(())
    }

    fn calibrate(&mut self) {
        let n = self.ids.len() as f64;
        let mut lack = -self.rows.column_mean();
        lack[0] = 0.0;
        let solved = self.normal.solve(&lack);
        let columns = self.rows.column_iter().zip(&self.weights);
        self.calibrated = columns.map(|(x, w)| 1.0 / n + w * x.dot(&solved)).collect();
    }

    fn coefficients(&self, values: &[f64]) -> DVector<f64> {
        let mut right = DVector::zeros(self.rows.nrows());
        for ((x, w), value) in self.rows.column_iter().zip(&self.weights).zip(values) {
            right.axpy(w * value, &x, 1.0);
        }
        self.normal.solve(&right)
    }

    fn errors(&self, values: &[f64], beta: &DVector<f64>) -> Vec<f64> {
        self.rows.column_iter().zip(values).map(|(x, value)| value - x.dot(beta)).collect()
    }

    /// Σ c_i v_i.
    fn total(&self, values: impl Iterator<Item = f64>) -> f64 {
        self.calibrated.iter().zip(values).map(|(c, value)| c * value).sum()
    }

    /// The ratio of two totals; `totals` of each cycle, 0 and 0 where it does not count.
    pub(super) fn ratio(&self, totals: &[(f64, f64)]) -> Option<Adjusted> {
        let (value, influences) = self.influences(totals)?;
        Some(Adjusted { value, ci95: self.interval(value, &influences)? })
    }

    /// The ratio of two totals, and what each cycle has to do with its error.
    fn influences(&self, totals: &[(f64, f64)]) -> Option<(f64, Vec<f64>)> {
        let y = self.total(totals.iter().map(|pair| pair.0));
        let x = self.total(totals.iter().map(|pair| pair.1));
        if x.is_nan() || x <= 0.0 {
            return None;
        }
        let value = y / x;
        Some((value, totals.iter().map(|(y, x_i)| (y - value * x_i) / x).collect()))
    }

    /// The mean and the quantiles of a quantity: of each cycle what it adds to the two totals, and
    /// its own value, NaN where it has none.
    pub(super) fn statistic(
        &self,
        totals: &[(f64, f64)],
        values: Vec<f64>,
    ) -> Option<AdjustedStatistic> {
        let Adjusted { value: mean, ci95 } = self.ratio(totals)?;
        let own = self.own_values(values);
        let of_level = |(level, name): (f64, &str)| {
            Some((name.to_owned(), self.quantile(own.as_ref()?, level)?))
        };
        let quantiles = LEVELS.into_iter().filter_map(of_level).collect();
        Some(AdjustedStatistic { mean, ci95, quantiles })
    }

    /// The 95 % interval of an estimate whose error is the weighted sum of these influences.
    fn interval(&self, value: f64, influences: &[f64]) -> Option<[f64; 2]> {
        let (errors, beta) = self.weighted_errors(influences);
        let of_expectations = beta.dot(&(&self.error * &beta));
        let half_width = self.half_width(&errors, of_expectations)?;
        Some([value - half_width, value + half_width])
    }

    /// The part of each cycle in the error of an estimate of these influences, and the coefficients
    /// of the regression.
    fn weighted_errors(&self, influences: &[f64]) -> (Vec<f64>, DVector<f64>) {
        let beta = self.coefficients(influences);
        let mut errors = self.without_own_cluster(self.errors(influences, &beta));
        for (error, c) in errors.iter_mut().zip(&self.calibrated) {
            *error *= c;
        }
        (errors, beta)
    }

    /// The difference of two ratios of the same cycles in two studies, B less A. The
    /// expectations of both are from the same draws, so that their errors largely fall out.
    pub(super) fn difference([a, b]: [&Self; 2], totals: [&[(f64, f64)]; 2]) -> Option<Adjusted> {
        let (of_a, influences_a) = a.influences(totals[0])?;
        let (of_b, influences_b) = b.influences(totals[1])?;
        let value = of_b - of_a;
        let (errors_a, beta_a) = a.weighted_errors(&influences_a);
        let (errors_b, beta_b) = b.weighted_errors(&influences_b);
        let errors: Vec<f64> = errors_b.iter().zip(&errors_a).map(|(b, a)| b - a).collect();
        let [of_a, of_b] = [(a, beta_a), (b, beta_b)]
            .map(|(own, beta)| own.sample.means_of_batches(&own.terms, &beta));
        let apart = of_b.iter().zip(&of_a).map(|(b, a)| (b - a) * (b - a)).sum::<f64>();
        let batches = of_b.len().min(of_a.len()) as f64;
        let of_expectations = apart / (batches * (batches - 1.0));
        let half_width = b.half_width(&errors, of_expectations)?;
        Some(Adjusted { value, ci95: [value - half_width, value + half_width] })
    }

    /// Half of the 95 % interval of an estimate whose error is the sum of these, one of each cycle,
    /// and the error of the expectations of this variance.
    fn half_width(&self, errors: &[f64], of_expectations: f64) -> Option<f64> {
        let (variance, degrees) = if self.clusters.has_several_ways() {
            let spread =
                self.clusters.spread(self.ids.iter().copied().zip(errors.iter().copied()))?;
            (spread.variance, spread.degrees)
        } else {
            let m = self.blocks.len() as f64;
            let sums = self.blocks.iter().map(|block| errors[block.clone()].iter().sum::<f64>());
            (m / (m - 1.0) * sums.map(|sum| sum * sum).sum::<f64>(), m - 1.0)
        };
        let half_width = student_975(degrees) * libm::sqrt(variance + of_expectations);
        half_width.is_finite().then_some(half_width)
    }

    /// Residuals as they are where the cycle's cluster is left out of the fit.
    fn without_own_cluster(&self, mut errors: Vec<f64>) -> Vec<f64> {
        for block in &self.blocks {
            if block.len() == 1 {
                let x = self.rows.column(block.start);
                let leverage = self.weights[block.start] * x.dot(&self.normal.solve(&x));
                errors[block.start] /= (1.0 - leverage).max(LEAST_LEFT);
                continue;
            }
            // sums row by row, and no product of matrices, whose bits depend on the processor
            let mut others = self.gram.clone();
            let mut right = DVector::zeros(self.rows.nrows());
            for k in block.clone() {
                let (x, w) = (self.rows.column(k), self.weights[k]);
                others.syger(-w, &x, &x, 1.0);
                right.axpy(w * errors[k], &x, 1.0);
            }
            // a cluster without which nothing can be fitted keeps its residuals
            if let Some(others) = Cholesky::new(others) {
                let moved = others.solve(&right);
                for k in block.clone() {
                    errors[k] += self.rows.column(k).dot(&moved);
                }
            }
        }
        errors
    }

    /// The quantile of a level of values, one of each cycle that has one (NaN otherwise), by their
    /// order.
    pub(super) fn quantile(&self, own: &OwnValues, level: f64) -> Option<Adjusted> {
        let n = own.sorted.len() as f64;
        let (mut at, mut half_width) = (level, 0.0);
        // the share below is compared at the quantile that is found
        for _ in 0..2 {
            let q = quantile(&own.sorted, at)?;
            let (lack, far) = self.share_below(own, q)?;
            at = (level - lack).clamp(0.0, 1.0);
            half_width = far;
        }
        let low = libm::floor(n * (at - half_width));
        let high = libm::ceil(n * (at + half_width)) + 1.0;
        if low < 1.0 || high > n {
            return None;
        }
        let ci95 = [own.sorted[low as usize - 1], own.sorted[high as usize - 1]];
        Some(Adjusted { value: quantile(&own.sorted, at)?, ci95 })
    }

    /// How far the share of values below `q` lies from that of the cycles, and half of its
    /// interval.
    fn share_below(&self, own: &OwnValues, q: f64) -> Option<(f64, f64)> {
        let below = |predicted: f64| normal_share((q - predicted) / own.spread);
        let model: Vec<f64> = own.predicted.iter().map(|value| below(*value)).collect();
        let counted = |k: &usize| !own.values[*k].is_nan();
        let places: Vec<usize> = (0..self.ids.len()).filter(counted).collect();
        let n = places.len() as f64;
        let share = places.iter().filter(|k| own.values[**k] <= q).count() as f64 / n;
        let mean = places.iter().map(|k| model[*k]).sum::<f64>() / n;
        let is_below = |k: usize| f64::from(own.values[k] <= q) - share;
        let products = places.iter().map(|k| is_below(*k) * (model[*k] - mean)).sum::<f64>();
        let squares = places.iter().map(|k| (model[*k] - mean) * (model[*k] - mean)).sum::<f64>();
        let slope = if squares > 0.0 { products / squares } else { 0.0 };
        let batch = ocmc_core::random::sampling::BATCH as usize;
        let means: Vec<f64> = own
            .predicted_of_sample
            .par_chunks(batch)
            .map(|batch| batch.iter().map(|value| below(*value)).sum::<f64>() / batch.len() as f64)
            .collect();
        let count = means.len() as f64;
        let expected = means.iter().sum::<f64>() / count;
        let of_batches = means.iter().map(|m| (m - expected) * (m - expected)).sum::<f64>();
        let of_expectations = slope * slope * of_batches / (count * (count - 1.0));
        let mut errors = vec![0.0; self.ids.len()];
        for k in &places {
            errors[*k] = (is_below(*k) - slope * (model[*k] - mean)) / n;
        }
        let half_width = self.half_width(&errors, of_expectations)?;
        Some((-slope * (mean - expected), half_width))
    }

    /// Predictions of the cycles' own values by the regression; none where a cycle has no value, as
    /// nothing is expected of those that have one alone.
    pub(super) fn own_values(&self, values: Vec<f64>) -> Option<OwnValues> {
        let known: Vec<usize> = (0..values.len()).filter(|k| !values[*k].is_nan()).collect();
        let p = self.rows.nrows();
        if known.len() < values.len() || known.len() < CLUSTERS_A_TERM * p {
            return None;
        }
        let (mut gram, mut right) = (DMatrix::zeros(p, p), DVector::zeros(p));
        for k in &known {
            let (x, w) = (self.rows.column(*k), self.weights[*k]);
            gram.syger(w, &x, &x, 1.0);
            right.axpy(w * values[*k], &x, 1.0);
        }
        gram.fill_upper_triangle_with_lower_triangle();
        let beta = Cholesky::new(gram)?.solve(&right);
        let predicted: Vec<f64> = self.rows.column_iter().map(|x| x.dot(&beta)).collect();
        let squares =
            known.iter().map(|k| (values[*k] - predicted[*k]) * (values[*k] - predicted[*k]));
        let spread = libm::sqrt(squares.sum::<f64>() / (known.len() - p) as f64);
        if spread.is_nan() || spread <= 0.0 {
            return None;
        }
        let predict = |outline: &Vec<f64>| {
            let terms = self.terms.of(outline);
            beta[0] + terms.iter().zip(beta.iter().skip(1)).map(|(z, b)| z * b).sum::<f64>()
        };
        let predicted_of_sample = self.sample.drawn.par_iter().map(predict).collect();
        let mut sorted: Vec<f64> = known.iter().map(|k| values[*k]).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        Some(OwnValues { values, sorted, predicted, predicted_of_sample, spread })
    }
}

/// The least of a residual's share that is its own.
const LEAST_LEFT: f64 = 1e-3;

/// The cycles' own values of a quantity, and what the regression says of them.
#[derive(Clone, Debug)]
pub(super) struct OwnValues {
    values: Vec<f64>,
    sorted: Vec<f64>,
    predicted: Vec<f64>,
    predicted_of_sample: Vec<f64>,
    spread: f64,
}

/// Share of the standard normal law below a value.
fn normal_share(z: f64) -> f64 {
    0.5 * libm::erfc(-z / std::f64::consts::SQRT_2)
}

/// Σ w x xᵀ over columns.
fn gram(rows: &DMatrix<f64>, weights: &[f64]) -> DMatrix<f64> {
    let p = rows.nrows();
    let mut gram = DMatrix::zeros(p, p);
    for (x, w) in rows.column_iter().zip(weights) {
        gram.syger(*w, &x, &x, 1.0);
    }
    gram.fill_upper_triangle_with_lower_triangle();
    gram
}

/// Ranges of cycles of the same batch or truck.
fn blocks(ids: &[u64], batch: u64) -> Vec<std::ops::Range<usize>> {
    let mut start = 0;
    let chunks = ids.chunk_by(|a, b| a / batch == b / batch);
    chunks
        .map(|chunk| {
            let range = start..start + chunk.len();
            start = range.end;
            range
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLES: u64 = 200;

    /// A payload, and one of two kinds.
    fn outline(payload: u64, is_first: bool) -> Vec<f64> {
        vec![1000.0 * payload as f64, f64::from(is_first)]
    }

    /// 200 cycles, of which 2 in 5 are of the first kind, where 1 in 4 is expected to be.
    fn adjustment() -> (Adjustment, Vec<bool>) {
        let first: Vec<bool> = (0..CYCLES).map(|k| k % 5 < 2).collect();
        let outlines: Vec<_> = (0..CYCLES).map(|k| outline(k * k % 7, first[k as usize])).collect();
        let sample = OutlineSample::of((0..64).map(|k| outline(k * k % 11, k % 4 == 0)).collect());
        let names = ["payload_kg", "is_first"].map(str::to_owned);
        let ids: Vec<u64> = (0..CYCLES).collect();
        let totals: Vec<(f64, f64)> = ids.iter().map(|k| (20.0 + (k % 3) as f64, 1.0)).collect();
        let sample = Arc::new(sample);
        let own = Adjustment::of(Dependence::default(), &names, &ids, &outlines, sample, &totals);
        (own.expect("two terms"), first)
    }

    #[test]
    fn the_difference_to_what_is_nothing_is_the_quantity_with_its_interval() {
        let (own, first) = adjustment();
        let of = |(k, is_first): (usize, &bool)| (5.0 * f64::from(*is_first) + (k % 9) as f64, 1.0);
        let totals: Vec<(f64, f64)> = first.iter().enumerate().map(of).collect();
        let nothing = vec![(0.0, 1.0); totals.len()];
        let alone = own.ratio(&totals).expect("known");
        let found = Adjustment::difference([&own; 2], [&nothing, &totals]).expect("known");
        assert!((found.value - alone.value).abs() < 1e-12, "{found:?} {alone:?}");
        for (end, expected) in found.ci95.into_iter().zip(alone.ci95) {
            assert!((end - expected).abs() < 1e-12, "{found:?} {alone:?}");
        }
    }

    #[test]
    fn where_the_kind_decides_the_share_below_is_what_is_expected_of_the_kind() {
        let (own, first) = adjustment();
        let by_kind = |first: bool| if first { 10.0 } else { 20.0 };
        let values: Vec<f64> =
            first.iter().enumerate().map(|(k, f)| by_kind(*f) + (k % 5) as f64).collect();
        let of = OwnValues {
            sorted: values.clone(),
            values,
            predicted: first.iter().map(|first| by_kind(*first)).collect(),
            predicted_of_sample: own.sample.drawn.iter().map(|o| by_kind(o[1] > 0.0)).collect(),
            spread: 5.0,
        };
        let (lack, _) = own.share_below(&of, 15.0).expect("known");
        assert!((lack - (0.25 - 0.4)).abs() < 1e-12, "{lack}");
    }

    #[test]
    fn what_is_nothing_in_all_cycles_has_no_quantiles() {
        let (own, first) = adjustment();
        assert!(own.own_values(vec![0.0; first.len()]).is_none());
    }

    #[test]
    fn an_interval_reaches_from_the_least_to_the_greatest_value() {
        let (own, first) = adjustment();
        let values: Vec<f64> = (0..first.len()).map(|k| k as f64).collect();
        let of = OwnValues {
            sorted: values.clone(),
            predicted: vec![0.0; values.len()],
            predicted_of_sample: vec![0.0; 64],
            spread: 1.0,
            values,
        };
        let levels = (1..1000).map(|k| f64::from(k) / 1000.0);
        let found: Vec<[f64; 2]> =
            levels.filter_map(|level| Some(own.quantile(&of, level)?.ci95)).collect();
        let last = of.sorted.len() as f64 - 1.0;
        assert_eq!((found[0][0], found[found.len() - 1][1]), (0.0, last));
    }
}

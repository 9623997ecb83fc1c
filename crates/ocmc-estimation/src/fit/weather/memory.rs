//! How much of an hour the next one remembers, from records of hours or of several hours.

use super::{FEWEST, HOUR_S, HourlyRecord, Hours};
use crate::moments::correlation;

/// How far a step may be off, in s.
const OFF_S: f64 = 1.0;
/// Longest step over which a correlation still tells that over an hour.
const LONGEST_STEP_S: f64 = 12.0 * HOUR_S;

/// Pairs of records that a step parts, and the step in s: an hour, or more where records are
/// farther apart.
pub(super) fn pairs(records: &[HourlyRecord]) -> (Vec<[usize; 2]>, f64) {
    let apart_s = |k: usize| records[k].time_s - records[k - 1].time_s;
    let mut steps_s: Vec<f64> = (1..records.len()).map(apart_s).collect();
    steps_s.sort_by(f64::total_cmp);
    let step_s = steps_s.get(steps_s.len() / 2).map_or(HOUR_S, |step_s| step_s.max(HOUR_S));
    // what follows over a day or more says nothing of an hour
    let step_s =
        if (step_s - HOUR_S).abs() <= OFF_S || step_s > LONGEST_STEP_S { HOUR_S } else { step_s };
    let pairs = (1..records.len())
        .filter(|k| (apart_s(*k) - step_s).abs() <= OFF_S)
        .map(|k| [k - 1, k])
        .collect();
    (pairs, step_s)
}

impl Hours<'_> {
    /// The correlation of values over an hour, and from how many pairs; none where they do not
    /// vary. Of longer steps it is the root: the deviations are autoregressive.
    pub(super) fn hourly_correlation(&self, values: &[f64]) -> Option<(f64, usize)> {
        let pairs = self.pairs.iter().map(|[a, b]| (values[*a], values[*b]));
        let correlation = correlation(pairs.filter(|(x, y)| x.is_finite() && y.is_finite()));
        let (phi, n) = correlation.filter(|(_, n)| *n >= FEWEST)?;
        let is_root = self.step_h > 1.0 && phi > 0.0;
        Some((if is_root { libm::pow(phi, 1.0 / self.step_h) } else { phi }, n))
    }

    /// The correlation over a step, of that over an hour.
    pub(super) fn over_step(&self, phi: f64) -> f64 {
        if self.step_h > 1.0 { libm::pow(phi.max(0.0), self.step_h) } else { phi }
    }

    /// Pairs of records that an hour parts.
    pub(super) fn hour_pairs(&self) -> &[[usize; 2]] {
        if self.step_h > 1.0 { &[] } else { &self.pairs }
    }

    /// Estimates a correlation over an hour, and returns it; that of the base study where it cannot
    /// be estimated.
    pub(super) fn correlate(&mut self, key: &'static str, values: &[f64], into: &mut f64) -> f64 {
        self.estimates.name = key;
        let Some((phi, n)) = self.hourly_correlation(values) else {
            let few = self.pairs.len() < FEWEST;
            let reason = if few { "too few records are an hour apart" } else { "they do not vary" };
            self.estimates.stays(reason);
            return *into;
        };
        let phi = self.remembered(phi);
        let step = self.over_step(phi);
        // of the root: its slope by that over the step
        let slope = if self.step_h > 1.0 { phi / (self.step_h * step) } else { 1.0 };
        let error = slope * ((1.0 - step * step).max(0.0) / n as f64).sqrt();
        self.estimates.set(key, into, phi, Some(error), n);
        phi
    }

    /// A correlation that is not negative.
    pub(super) fn remembered(&mut self, phi: f64) -> f64 {
        if phi < 0.0 {
            self.estimates.warn(format_args!(
                "an hour is forgotten by the next; the estimate {phi:.3} is taken as 0"
            ));
        }
        phi.max(0.0)
    }
}

//! Whether a fit explains its pedals: intervals rest on residuals that are the noise of sensors.
//!
//! Four tests at levels of 0.1 and 1 % [EJ]: that the residuals do not scatter more than the
//! sensors (from [second differences](super::noise)), that they have no slow part (means of blocks
//! of one second against the scatter within: an F test), and that neither a driver who sees the
//! speed late nor a truck of another mass explains more (score tests after Rao, 1948: derivatives
//! of the residuals by the missing parameter, less what the others explain of it). A driver who
//! sees late moves the gains before he shows in the residuals: a fit has no intervals, too, where
//! the step towards a delay is above zero by 1.96 standard errors, or where half a second of it
//! cannot be excluded (1.645 standard errors) [EJ]. Rows in which a pedal rests at a stop in log
//! and simulation tell nothing and are left out. A score is taken of what is not estimated, and not
//! of a switched driver, whose residuals jump. Three times the noise is no misfit but a fit that
//! has failed: where a step from there leads says nothing of delay or mass, and is not said [EJ].
//!
//! C. R. Rao, "Large sample tests of statistical hypotheses concerning several parameters with
//! applications to problems of estimation", Mathematical Proceedings of the Cambridge Philosophical
//! Society 44 (1948) 50-57.

use crate::fit::p_value::ln_f_tail;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// Level of the F test.
const LEVEL: f64 = 1e-2;
/// Normal quantile of half the level of the score tests, 0.1 %.
const NORMAL_LEVEL: f64 = 3.290527;
/// Scatter above that of the sensors, as a ratio, that is misfit; ± 4 standard errors of the ratio
/// for the rows of an event of Table I lie within.
const LARGEST_RATIO: f64 = 1.25;
/// Scatter from which on the fit has failed: what a step away from it asks for means nothing [EJ].
const FAILED_RATIO: f64 = 3.0;
/// Length of a block in s, and its fewest rows.
const BLOCK_S: f64 = 1.0;
const BLOCK_ROWS: f64 = 5.0;
/// Fewest rows that can be tested.
const FEWEST_ROWS: usize = 30;
/// A pedal rests at a stop where the simulated one and the mean of the measured one over a block
/// around are this close to it, in standard deviations of the noise.
const AT_STOP: f64 = 2.5;
/// A delay in s that has to be excluded, and the standard errors by which it is; those by which a
/// delay is above zero [EJ].
const EXCLUDED_S: f64 = 0.5;
const EXCLUDED_ERRORS: f64 = 1.645;
const LATE_ERRORS: f64 = 1.96;

/// Both pedals in one row of a log: accelerator and brake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ComparedRow {
    pub(super) time_s: f64,
    pub(super) measured: [f64; 2],
    pub(super) simulated: [f64; 2],
}

/// Results of the tests of a fit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FitTest {
    /// Noise of the sensors of accelerator and brake, standard deviation, at least their
    /// resolution.
    pub pedal_noise: [f64; 2],
    /// Pedals that were compared away from their stops.
    pub compared: usize,
    /// Scatter of the residuals over that noise.
    pub noise_ratio: f64,
    /// F of the slow part of the residuals, and ln P of a larger one.
    pub slow_f: f64,
    /// Natural logarithm of the probability of a larger F.
    pub slow_ln_p: f64,
    /// The delay in s that one step from the fit asks for, and its standard error; none where it is
    /// estimated or not determined.
    pub delay_s: Option<[f64; 2]>,
    /// The change of the mass, as a share of it, that one step asks for, and its standard error.
    pub mass_share: Option<[f64; 2]>,
}

/// Residuals away from the stops, in units of the noise, with their time and pedal.
fn informative(rows: &[ComparedRow], noise: [f64; 2]) -> Vec<(usize, f64, f64)> {
    let mut differences = Vec::new();
    for pedal in 0..2 {
        let sd = noise[pedal];
        let (mut first, mut end, mut sum) = (0, 0, 0.0);
        for row in rows {
            while end < rows.len() && rows[end].time_s <= row.time_s + 0.5 * BLOCK_S {
                sum += rows[end].measured[pedal];
                end += 1;
            }
            while rows[first].time_s < row.time_s - 0.5 * BLOCK_S {
                sum -= rows[first].measured[pedal];
                first += 1;
            }
            let (measured, simulated) = (row.measured[pedal], row.simulated[pedal]);
            let (mean, close) = (sum / (end - first) as f64, AT_STOP * sd);
            let released = mean < close && simulated < close;
            let pressed = 1.0 - mean < close && 1.0 - simulated < close;
            if !(released || pressed) {
                differences.push((pedal, row.time_s, (measured - simulated) / sd));
            }
        }
    }
    differences
}

impl FitTest {
    /// Tests a fit: the compared rows, the noise of the pedals and what counts as none, how many
    /// parameters were fitted; `scores` of the delay and of the mass where they were not.
    pub(super) fn of(
        rows: &[ComparedRow],
        noise: [f64; 2],
        least_noise: f64,
        parameters: usize,
        scores: [Option<[f64; 2]>; 2],
    ) -> Self {
        let residuals = informative(rows, noise);
        let compared = residuals.len();
        let freedom = compared.saturating_sub(parameters).max(1) as f64;
        let squares: f64 = residuals.iter().map(|(_, _, r)| r * r).sum();
        let span_s =
            rows.last().map_or(0.0, |row| row.time_s) - rows.first().map_or(0.0, |row| row.time_s);
        let block_s = BLOCK_S.max(BLOCK_ROWS * span_s / rows.len().max(1) as f64);
        let block = |&(pedal, time_s, _): &(usize, f64, f64)| (pedal, (time_s / block_s).floor());
        let (mut blocks, mut between, mut within) = (0usize, 0.0, 0.0);
        for part in residuals.chunk_by(|a, b| block(a) == block(b)) {
            let n = part.len() as f64;
            let mean = part.iter().map(|(_, _, r)| r).sum::<f64>() / n;
            blocks += 1;
            between += n * mean * mean;
            within += part.iter().map(|(_, _, r)| (r - mean) * (r - mean)).sum::<f64>();
        }
        let between_freedom = blocks.saturating_sub(parameters).max(1) as f64;
        let within_freedom = compared.saturating_sub(blocks).max(1) as f64;
        // what a sensor does not resolve is no misfit
        let least = least_noise / noise[0].max(noise[1]);
        let least = least * least;
        let slow_f = (between / between_freedom) / (within / within_freedom).max(least);
        let [delay_s, mass_share] = scores;
        Self {
            pedal_noise: noise,
            compared,
            noise_ratio: (squares / freedom).sqrt(),
            slow_f,
            slow_ln_p: ln_f_tail(slow_f, between_freedom, within_freedom),
            delay_s,
            mass_share,
        }
    }

    /// Why the residuals are no noise of sensors; nothing where they may be.
    pub(super) fn misfits(&self) -> Vec<String> {
        let mut misfits = Vec::new();
        if self.compared < FEWEST_ROWS {
            misfits.push(format!(
                "the pedals rest at their stops but for {} rows, {FEWEST_ROWS} are needed",
                self.compared
            ));
            return misfits;
        }
        if self.noise_ratio > FAILED_RATIO {
            misfits.push(format!(
                "the fit fails, the pedals are off by {:.1} times the noise of their sensors \
                 ({:.4}): the driver may have wanted another speed, for a limit, a curve, a stop \
                 or traffic, or truck and slope are not those of study and log",
                self.noise_ratio, self.pedal_noise[0]
            ));
            return misfits;
        }
        if self.noise_ratio > LARGEST_RATIO {
            misfits.push(format!(
                "the pedals are off by {:.1} times the noise of their sensors ({:.4})",
                self.noise_ratio, self.pedal_noise[0]
            ));
        }
        if self.slow_ln_p < libm::log(LEVEL) {
            misfits.push(format!(
                "the residuals are autocorrelated: their means over a second scatter {:.1} times \
                 as much as those of noise",
                self.slow_f.sqrt()
            ));
        }
        let significant = |score: &[f64; 2]| score[0].abs() > NORMAL_LEVEL * score[1];
        let late = |score: &[f64; 2]| significant(score) || score[0] > LATE_ERRORS * score[1];
        let open = |score: &[f64; 2]| score[0] + EXCLUDED_ERRORS * score[1] > EXCLUDED_S;
        if let Some([delay_s, error_s]) = self.delay_s.filter(late) {
            misfits.push(format!(
                "the driver seems to react {delay_s:+.2} ± {error_s:.2} s later than the model: \
                 try the unknown `delay`"
            ));
        } else if let Some([_, error_s]) = self.delay_s.filter(open) {
            misfits.push(format!(
                "the event does not tell whether the driver reacts late (± {error_s:.2} s): try \
                 the unknown `delay`"
            ));
        }
        if let Some([share, error]) = self.mass_share.filter(significant) {
            misfits.push(format!(
                "the truck seems to be {:.1} ± {:.1} % {} than the study's: try the unknown `mass`",
                100.0 * share.abs(),
                100.0 * error,
                if share > 0.0 { "heavier" } else { "lighter" }
            ));
        }
        misfits
    }

    /// Root of the mean square of the residuals in units of the noise, at least what counts as
    /// none.
    pub(super) fn deviation(&self, least_noise: f64) -> f64 {
        self.noise_ratio.max(least_noise / self.pedal_noise[0].max(self.pedal_noise[1]))
    }
}

/// One step of a missing parameter from a fit, and its standard error: `extra` are the derivatives
/// of the residuals by it, `columns` those by the fitted parameters; none where these explain
/// `extra`.
pub(super) fn score(residuals: &[f64], columns: &[Vec<f64>], extra: &[f64]) -> Option<[f64; 2]> {
    let rows = residuals.len();
    let whole = DVector::from_column_slice(extra);
    let mut own = whole.clone();
    if !columns.is_empty() {
        let scaled = DMatrix::from_fn(rows, columns.len(), |row, k| columns[k][row]);
        let q = scaled.qr().q();
        own -= &q * (q.transpose() * &whole);
    }
    let square = own.norm_squared();
    if !(square > 1e-12 * whole.norm_squared()) || !square.is_finite() {
        return None;
    }
    let product: f64 = own.iter().zip(residuals).map(|(own, r)| own * r).sum();
    Some([-product / square, 1.0 / square.sqrt()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    fn rows(seed: u64, misfit: impl Fn(f64) -> f64) -> Vec<ComparedRow> {
        let mut draws = Draws::new(seed, 0, Stream::Pedals);
        let row = |k: usize| {
            let time_s = 0.05 * k as f64;
            // the brake rests
            let measured = [0.5 + misfit(time_s) + 0.02 * draws.normal(), 0.02 * draws.normal()];
            ComparedRow { time_s, measured, simulated: [0.5, 0.0] }
        };
        (0..800).map(row).collect()
    }

    #[test]
    fn noise_passes_and_misfit_does_not() {
        let test = |seed, misfit: &dyn Fn(f64) -> f64| {
            // nothing was fitted to these rows: all of their freedom is left
            FitTest::of(&rows(seed, misfit), [0.02; 2], 0.0029, 0, [None; 2])
        };
        let mut refused = 0;
        for seed in 1..=300 {
            let tested = test(seed, &|_| 0.0);
            assert_eq!(tested.compared, 800);
            refused += usize::from(!tested.misfits().is_empty());
        }
        // a level of 1 %: more than 9 come once in a thousand times
        assert!(refused <= 9, "{refused} of 300");
        for seed in 1..=20 {
            assert!(!test(seed, &|t| 0.012 * libm::sin(0.5 * t)).misfits().is_empty());
        }
    }

    #[test]
    fn a_score_is_the_step_of_a_linear_problem() {
        // r = 3 − 2 a − x b with a fitted: the step of b solves the problem of both
        let columns = vec![vec![1.0, 1.0, 1.0, 1.0]];
        let extra = [0.0, 1.0, 2.0, 3.0];
        // residuals about the mean of y = 0.5 x
        let residuals: Vec<f64> = extra.iter().map(|x| 0.5 * (x - 1.5)).collect();
        let [step, error] = score(&residuals, &columns, &extra).expect("it is determined");
        assert!((step + 0.5).abs() < 1e-12 && (error - 1.0 / 5.0f64.sqrt()).abs() < 1e-12);
        assert_eq!(score(&residuals, &columns, &[2.0; 4]), None);
    }
}

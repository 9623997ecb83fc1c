//! The scores of judged numbers that are most probable with the rows of a table.
//!
//! θ = (z, δ): scores z ~ N(0, 1), and a shift δ_j ~ N(0, d_j²) of each response that all rows
//! share. −ln p = ½ |θ|² + w Σ_rows Σ_j ( ρ(r_j/σ_j) + ½ ln σ²_j ), with Huber's ρ of 2.5 SDs and w
//! the share of the rows that count; by Fisher scoring, and its information is the inverse
//! covariance.

use super::emulator::Emulator;
use super::{MemberEmulator, TotalsRow};
use nalgebra::{DMatrix, DVector};

/// Residual, in SDs, from which on one counts less (P. J. Huber, 1964; 2.5 a judgement).
const HUBER: f64 = 2.5;
/// Most steps of the search.
const MOST_STEPS: usize = 50;
/// Change of θ that is none.
const TOLERANCE: f64 = 1e-6;
/// How often a step is halved.
const MOST_HALVINGS: usize = 20;

/// Quantities that all rows share beside the scores.
#[derive(Clone, Debug, PartialEq)]
pub struct Shared {
    /// SD of the shift of each response, of ln.
    pub discrepancies: Vec<f64>,
    /// Share of the rows that counts: rows that go together tell less.
    pub weight: f64,
}

/// The most probable scores, and their errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Posterior {
    /// Scores.
    pub scores: Vec<f64>,
    /// Covariance of their errors.
    pub covariance: DMatrix<f64>,
    /// Shifts of the responses, of ln.
    pub shifts: Vec<f64>,
    /// Residuals of the rows in SDs, a list of the responses for each row.
    pub residuals: Vec<Vec<f64>>,
}

impl Posterior {
    /// The SD of a number with these derivatives by the scores.
    pub fn sd(&self, slopes: &DVector<f64>) -> f64 {
        libm::sqrt((slopes.transpose() * &self.covariance * slopes)[(0, 0)].max(0.0))
    }

    /// The most probable scores of those at which numbers are larger by `by` than at `from`:
    /// C Hᵀ (H C Hᵀ + R)⁻¹ by away from there, with their derivatives H and the squares R of what
    /// each may be off. Scores that do not take part stay.
    pub fn moved(
        &self,
        from: &[f64],
        numbers: &[MemberEmulator],
        by: &[f64],
        tolerances: &[f64],
        takes_part: impl Fn(usize) -> bool,
    ) -> Vec<f64> {
        let size = from.len();
        let covariance = DMatrix::from_fn(size, size, |j, k| {
            if takes_part(j) && takes_part(k) { self.covariance[(j, k)] } else { 0.0 }
        });
        let slopes: Vec<DVector<f64>> = numbers.iter().map(|number| number.at(from).1).collect();
        let slopes = DMatrix::from_columns(&slopes);
        let gain = &covariance * &slopes;
        let mut spread = slopes.transpose() * &gain;
        for (k, tolerance) in tolerances.iter().enumerate() {
            spread[(k, k)] += tolerance * tolerance;
        }
        let Some(cholesky) = spread.cholesky() else { return from.to_vec() };
        let step = gain * cholesky.solve(&DVector::from_row_slice(by));
        from.iter().zip(step.iter()).map(|(score, step)| score + step).collect()
    }
}

struct Problem<'a> {
    emulator: &'a Emulator,
    rows: &'a [TotalsRow],
    shared: &'a Shared,
    scores: usize,
}

impl Problem<'_> {
    fn parts<'t>(&self, theta: &'t DVector<f64>) -> (&'t [f64], Vec<f64>) {
        let (scores, shifts) = theta.as_slice().split_at(self.scores);
        let shifts = shifts.iter().zip(&self.shared.discrepancies).map(|(t, d)| t * d).collect();
        (scores, shifts)
    }

    fn objective(&self, theta: &DVector<f64>) -> f64 {
        let (scores, shifts) = self.parts(theta);
        let of_row = |row: &TotalsRow| {
            let at = self.emulator.at(row, scores, &shifts);
            let term = |(r, variance): (&f64, &f64)| {
                huber(r / libm::sqrt(*variance)) + 0.5 * libm::log(*variance)
            };
            at.residuals.iter().zip(&at.variances).map(term).sum::<f64>()
        };
        let rows: f64 = self.rows.iter().map(of_row).sum();
        0.5 * theta.norm_squared() + self.shared.weight * rows
    }

    /// Minus the gradient, and the information.
    fn step(&self, theta: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let (scores, shifts) = self.parts(theta);
        let mut ascent = -theta.clone();
        let mut information = DMatrix::identity(theta.len(), theta.len());
        let w = self.shared.weight;
        for row in self.rows {
            let at = self.emulator.at(row, scores, &shifts);
            let slopes = self.emulator.slopes(row, &self.shared.discrepancies);
            for j in 0..at.residuals.len() {
                let sd = libm::sqrt(at.variances[j]);
                let t = at.residuals[j] / sd;
                let psi = t.clamp(-HUBER, HUBER);
                let (mean, log_variance) = (&slopes.means[j], &slopes.log_variances[j]);
                ascent += (w * psi / sd) * mean + (0.5 * w * (psi * t - 1.0)) * log_variance;
                information.ger(w / at.variances[j], mean, mean, 1.0);
                information.ger(0.5 * w, log_variance, log_variance, 1.0);
            }
        }
        (ascent, information)
    }
}

fn huber(t: f64) -> f64 {
    let size = t.abs();
    if size <= HUBER { 0.5 * t * t } else { HUBER * (size - 0.5 * HUBER) }
}

/// Finds them; `scores` is how many there are.
pub fn posterior(
    emulator: &Emulator,
    rows: &[TotalsRow],
    shared: &Shared,
    scores: usize,
) -> Posterior {
    let problem = Problem { emulator, rows, shared, scores };
    let mut theta = DVector::zeros(scores + shared.discrepancies.len());
    let mut value = problem.objective(&theta);
    for _ in 0..MOST_STEPS {
        let (ascent, information) = problem.step(&theta);
        let Some(cholesky) = information.cholesky() else { break };
        let mut step = cholesky.solve(&ascent);
        let mut better = false;
        for _ in 0..MOST_HALVINGS {
            let next = &theta + &step;
            let there = problem.objective(&next);
            if there <= value {
                (theta, value, better) = (next, there, true);
                break;
            }
            step *= 0.5;
        }
        if !better || step.norm() < TOLERANCE {
            break;
        }
    }
    let (_, information) = problem.step(&theta);
    let covariance = inverse(information).view((0, 0), (scores, scores)).into_owned();
    let (estimates, shifts) = problem.parts(&theta);
    let standardised = |row: &TotalsRow| {
        let at = emulator.at(row, estimates, &shifts);
        at.residuals.iter().zip(&at.variances).map(|(r, v)| r / libm::sqrt(*v)).collect()
    };
    let residuals = rows.iter().map(standardised).collect();
    Posterior { scores: estimates.to_vec(), covariance, shifts, residuals }
}

/// The posterior to be expected of rows like these, at scores: their errors, without residuals.
pub fn expected(
    emulator: &Emulator,
    rows: &[TotalsRow],
    shared: &Shared,
    scores: &[f64],
) -> Posterior {
    let count = scores.len();
    let problem = Problem { emulator, rows, shared, scores: count };
    let shifts = shared.discrepancies.len();
    let theta = DVector::from_vec(scores.to_vec()).resize_vertically(count + shifts, 0.0);
    let (_, information) = problem.step(&theta);
    let covariance = inverse(information).view((0, 0), (count, count)).into_owned();
    let shifts = vec![0.0; shifts];
    Posterior { scores: scores.to_vec(), covariance, shifts, residuals: Vec::new() }
}

fn inverse(information: DMatrix<f64>) -> DMatrix<f64> {
    let size = information.nrows();
    information.cholesky().map_or_else(|| DMatrix::identity(size, size), |c| c.inverse())
}

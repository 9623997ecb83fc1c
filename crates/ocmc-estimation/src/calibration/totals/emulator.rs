//! The emulator of simulated fleets: means and variances of a trip's responses by what is known of
//! it and by the scores of judged numbers.
//!
//! ln y_j ≈ xᵀ C_j (1, z) + Σ_{i<j} b_ji e_i,   ln σ²_j ≈ xᵀ D_j (1, z),   x = (1, g, g², ln L)
//!
//! with g the gross weight and L the length, both over the spread that they have in the design, and
//! e_i the residuals of the responses before. What is not known is not in x.

use super::ridge::{MemberRows, Surface, surfaces};
use super::{Member, Response, TotalsRow};
use nalgebra::{DMatrix, DVector};

/// E ln χ²₁: what the logarithm of a squared residual is below that of its variance.
const LOG_SQUARE_BIAS: f64 = -1.270_362_845_461_478;
/// Least squared residual of which a logarithm is taken, as a share of the mean square.
const LEAST_SQUARE: f64 = 1e-4;
/// Least SD of ln L of a design whose lengths differ.
const LEAST_LENGTH_SD: f64 = 1e-3;

/// The columns of a table that explain its trips.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Known {
    /// Whether their gross weights are.
    pub gross: bool,
    /// The responses, in their order.
    pub responses: Vec<Response>,
}

/// An emulator.
#[derive(Clone, Debug, PartialEq)]
pub struct Emulator {
    known: Known,
    /// Mean and SD of the gross weight, and of ln L, over the design.
    gross: [f64; 2],
    length: Option<[f64; 2]>,
    means: Vec<Surface>,
    /// A row a response: what one of the residual of an earlier one adds to it.
    given: DMatrix<f64>,
    log_variances: Vec<Surface>,
}

fn mean_sd(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    let square = values.map(|x| (x - mean) * (x - mean)).sum::<f64>() / n;
    [mean, libm::sqrt(square)]
}

impl Emulator {
    /// Fits the trips of members; none where there are no members with trips.
    pub fn fit(members: &[Member], known: &Known) -> Option<Self> {
        let trips = || members.iter().flat_map(|member| &member.trips);
        trips().next()?;
        let members: Vec<&Member> = members.iter().filter(|m| m.trips.len() > 1).collect();
        let gross = mean_sd(trips().map(|trip| trip.gross_kg));
        let length = mean_sd(trips().map(|trip| libm::log(trip.length_m)));
        let length = (length[1] > LEAST_LENGTH_SD).then_some(length);
        let responses = known.responses.len();
        let mut emulator = Self {
            known: known.clone(),
            gross,
            length,
            means: Vec::new(),
            given: DMatrix::zeros(responses, responses),
            log_variances: Vec::new(),
        };
        let mut rows: Vec<MemberRows> = (members.iter())
            .map(|member| MemberRows {
                scores: &member.scores,
                x: member.trips.iter().map(|trip| emulator.x(trip)).collect(),
                y: member.trips.iter().map(|trip| emulator.y(trip)).collect(),
            })
            .collect();
        emulator.means = surfaces(&rows, responses);
        let residuals = |rows: &[MemberRows], means: &[Surface]| -> Vec<Vec<f64>> {
            let residuals_of = |member: &MemberRows| -> Vec<Vec<f64>> {
                let each = member.x.iter().zip(&member.y);
                let one = |(x, y): (&Vec<f64>, &Vec<f64>)| {
                    let less = |(mean, y): (&Surface, &f64)| y - mean.at(x, member.scores);
                    means.iter().zip(y).map(less).collect()
                };
                each.map(one).collect()
            };
            rows.iter().flat_map(residuals_of).collect()
        };
        let residuals = residuals(&rows, &emulator.means);
        for j in 1..responses {
            let gram = DMatrix::from_fn(j, j, |a, b| residuals.iter().map(|e| e[a] * e[b]).sum());
            let products = DVector::from_fn(j, |a, _| residuals.iter().map(|e| e[a] * e[j]).sum());
            if let Some(solved) =
                gram.cholesky().map(|c: nalgebra::Cholesky<f64, _>| c.solve(&products))
            {
                for a in 0..j {
                    emulator.given[(j, a)] = solved[a];
                }
            }
        }
        let squares: Vec<Vec<f64>> = (residuals.iter())
            .map(|e| emulator.less_given(e).into_iter().map(|r| r * r).collect())
            .collect();
        let mean_square =
            |j: usize| squares.iter().map(|s| s[j]).sum::<f64>() / squares.len() as f64;
        let least: Vec<f64> = (0..responses).map(|j| LEAST_SQUARE * mean_square(j)).collect();
        let mut place = squares.iter();
        for member in &mut rows {
            for y in &mut member.y {
                let square = place.next().expect("one of each trip");
                for (j, y) in y.iter_mut().enumerate() {
                    *y =
                        libm::log(square[j].max(least[j]).max(f64::MIN_POSITIVE)) - LOG_SQUARE_BIAS;
                }
            }
        }
        emulator.log_variances = surfaces(&rows, responses);
        // the mean of what is over what was fitted is 1
        for (j, variance) in emulator.log_variances.iter_mut().enumerate() {
            let mut place = squares.iter();
            let mut sum = 0.0;
            for member in &rows {
                for x in &member.x {
                    let square = place.next().expect("one of each trip");
                    sum += square[j] / libm::exp(variance.at(x, member.scores));
                }
            }
            variance.coefficients[(0, 0)] += libm::log(sum / squares.len() as f64);
        }
        Some(emulator)
    }

    /// The columns of a table that explain its trips.
    pub fn known(&self) -> &Known {
        &self.known
    }

    /// Regressors of a trip; of several trips together those of one.
    fn x(&self, row: &TotalsRow) -> Vec<f64> {
        let mut x = vec![1.0];
        if self.known.gross {
            let g = (row.gross_kg - self.gross[0]) / self.gross[1].max(1.0);
            x.extend([g, g * g]);
        }
        if let Some([mean, sd]) = self.length {
            let length_m = row.length_m / row.trips;
            x.push((libm::log(length_m) - mean) / sd);
        }
        x
    }

    fn y(&self, row: &TotalsRow) -> Vec<f64> {
        self.known.responses.iter().map(|response| row.responses[*response as usize]).collect()
    }

    /// Residuals, less what those before explain of each.
    fn less_given(&self, residuals: &[f64]) -> Vec<f64> {
        let explained = |j: usize| (0..j).map(|i| self.given[(j, i)] * residuals[i]).sum::<f64>();
        residuals.iter().enumerate().map(|(j, r)| r - explained(j)).collect()
    }

    /// Discrepancy of each response between a study of the design and a real fleet, SD of ln: what
    /// the scores leave between members, or the least.
    pub fn discrepancies(&self) -> Vec<f64> {
        let discrepancy = |(mean, response): (&Surface, &Response)| {
            libm::sqrt(mean.lack_of_fit).max(response.least_discrepancy())
        };
        self.means.iter().zip(&self.known.responses).map(discrepancy).collect()
    }

    /// ln consumption of a row less its expectation, where no score moves it, and the SD of a trip.
    /// The consumption is the only response.
    pub fn consumption(&self, row: &TotalsRow) -> (f64, f64) {
        let x = self.x(row);
        let (scores, place) = (&[][..], Response::Consumption as usize);
        let residual = row.responses[place] - self.means[0].at(&x, scores);
        (residual, libm::exp(0.5 * self.log_variances[0].at(&x, scores)))
    }

    /// The responses of a row at scores: what it differs by from its expectation, each given those
    /// before, and the variances.
    pub(super) fn at(&self, row: &TotalsRow, scores: &[f64], shifts: &[f64]) -> Residuals {
        let x = self.x(row);
        let y = self.y(row);
        let raw: Vec<f64> = (self.means.iter().zip(&y).zip(shifts))
            .map(|((mean, y), shift)| y - mean.at(&x, scores) - shift)
            .collect();
        let variances = self.log_variances.iter();
        let variances = variances.map(|v| libm::exp(v.at(&x, scores)) / row.trips).collect();
        Residuals { residuals: self.less_given(&raw), variances }
    }

    /// Derivatives of the expectations by the scores and by the shifts, and of the logarithms of
    /// the variances.
    pub(super) fn slopes(&self, row: &TotalsRow, discrepancies: &[f64]) -> Slopes {
        let x = self.x(row);
        let responses = self.means.len();
        let raw: Vec<DVector<f64>> = (self.means.iter().enumerate())
            .map(|(j, mean)| {
                let scores = mean.gradient(&x);
                let shift = |k: usize| if k == j { discrepancies[j] } else { 0.0 };
                let all = scores.iter().copied().chain((0..responses).map(shift));
                DVector::from_iterator(scores.len() + responses, all)
            })
            .collect();
        let means = (0..responses)
            .map(|j| (0..j).fold(raw[j].clone(), |sum, i| sum - self.given[(j, i)] * &raw[i]))
            .collect();
        let log_variances = (self.log_variances.iter())
            .map(|v| v.gradient(&x).resize_vertically(raw[0].len(), 0.0))
            .collect();
        Slopes { means, log_variances }
    }
}

/// Residuals of a row and their variances.
pub(super) struct Residuals {
    pub(super) residuals: Vec<f64>,
    pub(super) variances: Vec<f64>,
}

/// Derivatives of a row.
pub(super) struct Slopes {
    pub(super) means: Vec<DVector<f64>>,
    pub(super) log_variances: Vec<DVector<f64>>,
}

//! The restricted likelihood of trucks and drivers as random effects, and what follows of them.
//!
//! y = X β + Z Λ u + e with u ~ N(0, σ² I), Λ the diagonal of the ratios θ = SD of a level over
//! that of a trip, e ~ N(0, σ²/w). With W the weights and A = I + Λ ZᵀWZ Λ
//!
//! −2 l(θ) = ln|A| + ln|XᵀV⁻¹X| + (n − p) (1 + ln(2π s²/(n − p))) − Σ ln w, V = W⁻¹ + Z Λ Λ Zᵀ,
//!
//! s² the least weighted sum of squares. Rows appear only as sums by truck and driver.
//!
//! Source: D. Bates, M. Mächler, B. Bolker, S. Walker, Fitting linear mixed-effects models using
//! lme4, Journal of Statistical Software 67 (2015), sections 3.3 to 3.5 (the same criterion and
//! parametrisation).

use super::trips::{Block, Trips};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use ocmc_core::random::Draws;
use std::f64::consts::PI;

/// Rest of the rows after the ratios θ.
pub(crate) struct Profile {
    /// ln|A| + ln|XᵀV⁻¹X|.
    log_determinant: f64,
    /// s².
    sum_sq: f64,
    /// Cholesky factor of \[X y\]ᵀV⁻¹\[X y\].
    factor: Cholesky<f64, Dyn>,
}

/// The matrix of a block's smaller side, factored.
enum Dense {
    /// Diagonal: one level is kept, or the other side has no effect.
    Diagonal(Vec<f64>),
    Full(Cholesky<f64, Dyn>),
}

impl Dense {
    fn log_determinant(&self) -> f64 {
        match self {
            Self::Diagonal(pivots) => pivots.iter().map(|pivot| libm::log(*pivot)).sum(),
            Self::Full(factor) => {
                let diagonal = factor.l_dirty().diagonal();
                2.0 * diagonal.iter().map(|pivot| libm::log(*pivot)).sum::<f64>()
            }
        }
    }
}

/// A block with one side eliminated.
struct Eliminated {
    pivots: Vec<f64>,
    dense: Dense,
    /// Right-hand sides of the kept levels.
    rhs: DMatrix<f64>,
}

impl Trips {
    /// Eliminates the larger side of a block; `gram` loses what it explains.
    fn eliminate(
        &self,
        block: &Block,
        theta: [f64; 2],
        gram: &mut DMatrix<f64>,
    ) -> Option<Eliminated> {
        let q = self.width + 1;
        let m = block.kept.len();
        let (kept, gone) =
            (&self.families[block.kept_family], &self.families[1 - block.kept_family]);
        let (tk, te) = (theta[block.kept_family], theta[1 - block.kept_family]);
        let coupled = tk > 0.0 && te > 0.0 && m > 1;
        let mut diagonal = Vec::with_capacity(m);
        let mut rhs = DMatrix::zeros(m, q);
        for (a, level) in block.kept.iter().enumerate() {
            diagonal.push(1.0 + tk * tk * kept.weights[*level]);
            for j in 0..q {
                rhs[(a, j)] = tk * kept.sums[level * q + j];
            }
        }
        let mut schur = if coupled { DMatrix::zeros(m, m) } else { DMatrix::zeros(0, 0) };
        let mut pivots = Vec::with_capacity(block.eliminated.len());
        for (level, cells) in block.eliminated.iter().zip(&block.cells) {
            let pivot = 1.0 + te * te * gone.weights[*level];
            pivots.push(pivot);
            let sums = &gone.sums[level * q..][..q];
            for i in 0..q {
                for j in 0..q {
                    gram[(i, j)] -= te * te * sums[i] * sums[j] / pivot;
                }
            }
            for (a, weight) in cells {
                let coupling = tk * te * weight;
                for j in 0..q {
                    rhs[(*a, j)] -= coupling * te * sums[j] / pivot;
                }
                if coupled {
                    for (b, other) in cells.iter().take_while(|(b, _)| b <= a) {
                        schur[(*a, *b)] -= coupling * tk * te * other / pivot;
                    }
                } else {
                    diagonal[*a] -= coupling * coupling / pivot;
                }
            }
        }
        let dense = if coupled {
            for (a, pivot) in diagonal.iter().enumerate() {
                schur[(a, a)] += pivot;
            }
            Dense::Full(Cholesky::new(schur)?)
        } else {
            Dense::Diagonal(diagonal)
        };
        Some(Eliminated { pivots, dense, rhs })
    }

    /// Profile at the ratios; none where a fixed effect is not determined.
    pub(crate) fn profile(&self, theta: [f64; 2]) -> Option<Profile> {
        let p = self.width;
        let mut gram = self.gram.clone();
        let mut log_determinant = 0.0;
        for block in &self.blocks {
            let Eliminated { pivots, dense, mut rhs } = self.eliminate(block, theta, &mut gram)?;
            log_determinant += pivots.iter().map(|pivot| libm::log(*pivot)).sum::<f64>();
            log_determinant += dense.log_determinant();
            match &dense {
                Dense::Diagonal(pivots) => {
                    for (a, pivot) in pivots.iter().enumerate() {
                        for i in 0..=p {
                            for j in 0..=p {
                                gram[(i, j)] -= rhs[(a, i)] * rhs[(a, j)] / pivot;
                            }
                        }
                    }
                }
                Dense::Full(factor) => {
                    factor.l_dirty().solve_lower_triangular_mut(&mut rhs);
                    gram -= rhs.tr_mul(&rhs);
                }
            }
        }
        let factor = Cholesky::new(gram)?;
        let diagonal = factor.l_dirty().diagonal();
        log_determinant += 2.0 * diagonal.iter().take(p).map(|l| libm::log(*l)).sum::<f64>();
        let sum_sq = diagonal[p] * diagonal[p];
        Some(Profile { log_determinant, sum_sq, factor })
    }

    /// Rows less fixed effects.
    pub(crate) fn df(&self) -> f64 {
        (self.n - self.width) as f64
    }

    /// Minus twice the restricted log-likelihood, σ at its best.
    pub(crate) fn criterion(&self, theta: [f64; 2]) -> f64 {
        let criterion = self.profile(theta).map(|Profile { log_determinant, sum_sq, .. }| {
            let df = self.df();
            log_determinant + df * (1.0 + libm::log(2.0 * PI * sum_sq / df)) - self.log_weights
        });
        criterion.filter(|criterion| criterion.is_finite()).unwrap_or(f64::INFINITY)
    }

    /// Minus twice the restricted log-likelihood of the SDs of trucks, drivers and trips, less what
    /// does not depend on them.
    pub(crate) fn deviance(&self, [truck, driver, trip]: [f64; 3]) -> f64 {
        if !(trip > 0.0) {
            return f64::INFINITY;
        }
        let profile = self.profile([truck / trip, driver / trip]);
        let deviance = profile.map(|Profile { log_determinant, sum_sq, .. }| {
            log_determinant + self.df() * libm::log(trip * trip) + sum_sq / (trip * trip)
        });
        deviance.filter(|deviance| deviance.is_finite()).unwrap_or(f64::INFINITY)
    }

    /// The SD of a trip that is best with these ratios.
    pub(crate) fn trip_sd(&self, theta: [f64; 2]) -> Option<f64> {
        Some(libm::sqrt(self.profile(theta)?.sum_sq / self.df()))
    }

    /// Operations of one evaluation that go into dense matrices.
    pub(crate) fn dense_work(&self) -> f64 {
        let sizes = self.blocks.iter().map(|block| block.kept.len() as f64);
        sizes.map(|m| if m > 1.0 { m * m * m / 3.0 } else { 0.0 }).sum()
    }
}

/// A block, solved.
struct Solved {
    pivots: Vec<f64>,
    dense: Dense,
    inverse: DMatrix<f64>,
}

/// A linear combination: its mean and its variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Combination {
    pub(crate) mean: f64,
    pub(crate) variance: f64,
}

/// Distribution of the effects of trucks and drivers once the SDs are taken as given: jointly
/// normal, with the best linear unbiased predictions as means and the variances of their errors.
///
/// Source: G. K. Robinson, That BLUP is a good thing: the estimation of random effects, Statistical
/// Science 6 (1991), 15-32 \[PK\].
pub(crate) struct Posterior<'a> {
    trips: &'a Trips,
    theta: [f64; 2],
    /// SD of a trip.
    sigma: f64,
    beta: DVector<f64>,
    /// (XᵀV⁻¹X)⁻¹, and a root of it.
    beta_covariance: DMatrix<f64>,
    beta_root: DMatrix<f64>,
    /// Predictions of the effects.
    pub(crate) effects: [Vec<f64>; 2],
    /// Λ A⁻¹ Λ ZᵀWX, row by row: how the predictions follow the fixed effects.
    response: [Vec<f64>; 2],
    blocks: Vec<Solved>,
    /// Block and place of each level, and whether it is of the kept side.
    places: [Vec<(usize, usize, bool)>; 2],
}

impl<'a> Posterior<'a> {
    /// Given the SDs of trucks, drivers and trips; none where a fixed effect is not determined.
    pub(crate) fn new(trips: &'a Trips, [truck, driver, sigma]: [f64; 3]) -> Option<Self> {
        let theta = [truck / sigma, driver / sigma];
        let (p, q) = (trips.width, trips.width + 1);
        let profile = trips.profile(theta)?;
        let l = profile.factor.l();
        let root = l.view((0, 0), (p, p)).into_owned();
        let y = l.view((p, 0), (1, p)).transpose();
        let beta = root.tr_solve_lower_triangular(&y)?.column(0).into_owned();
        let inverse = root.solve_lower_triangular(&DMatrix::identity(p, p))?;
        let beta_root = inverse.transpose();
        let mut posterior = Self {
            trips,
            theta,
            sigma,
            beta,
            beta_covariance: &beta_root * &inverse,
            beta_root,
            effects: [0, 1].map(|family| vec![0.0; trips.families[family].len()]),
            response: [0, 1].map(|family| vec![0.0; p * trips.families[family].len()]),
            blocks: Vec::with_capacity(trips.blocks.len()),
            places: [0, 1].map(|family| vec![(0, 0, true); trips.families[family].len()]),
        };
        let mut unused = trips.gram.clone();
        for (number, block) in trips.blocks.iter().enumerate() {
            let Eliminated { pivots, dense, rhs } = trips.eliminate(block, theta, &mut unused)?;
            let m = block.kept.len();
            let inverse = match &dense {
                Dense::Diagonal(pivots) => {
                    DMatrix::from_diagonal(&DVector::from_fn(m, |a, _| 1.0 / pivots[a]))
                }
                Dense::Full(factor) => factor.inverse(),
            };
            let kept = &inverse * &rhs;
            let families = [block.kept_family, 1 - block.kept_family];
            let [tk, te] = families.map(|family| theta[family]);
            for (a, level) in block.kept.iter().enumerate() {
                posterior.places[families[0]][*level] = (number, a, true);
                posterior.set(families[0], *level, tk, kept.row(a).iter().copied());
            }
            for (e, (level, cells)) in block.eliminated.iter().zip(&block.cells).enumerate() {
                posterior.places[families[1]][*level] = (number, e, false);
                let sums = &trips.families[families[1]].sums[level * q..][..q];
                let solved: Vec<f64> = (0..q)
                    .map(|j| {
                        let coupled = cells.iter().map(|(a, w)| tk * te * w * kept[(*a, j)]);
                        (te * sums[j] - coupled.sum::<f64>()) / pivots[e]
                    })
                    .collect();
                posterior.set(families[1], *level, te, solved.into_iter());
            }
            posterior.blocks.push(Solved { pivots, dense, inverse });
        }
        Some(posterior)
    }

    /// Keeps the solution of a level, the columns of \[X y\].
    fn set(&mut self, family: usize, level: usize, theta: f64, solved: impl Iterator<Item = f64>) {
        let p = self.trips.width;
        let solved: Vec<f64> = solved.map(|value| theta * value).collect();
        let fitted: f64 = (0..p).map(|j| solved[j] * self.beta[j]).sum();
        self.effects[family][level] = solved[p] - fitted;
        self.response[family][level * p..][..p].copy_from_slice(&solved[..p]);
    }

    /// Distribution of `fixed`ᵀβ + Σ cᵢ bᵢ; each term has its family, level and c.
    pub(crate) fn combine(&self, fixed: &[f64], terms: &[(usize, usize, f64)]) -> Combination {
        let p = self.trips.width;
        let mut mean = self.trips.shift * fixed[0];
        let mut rest = DVector::from_column_slice(fixed);
        mean += rest.dot(&self.beta);
        let mut by_block: Vec<(usize, usize, bool, f64)> = Vec::with_capacity(terms.len());
        for (family, level, c) in terms {
            mean += c * self.effects[*family][*level];
            for j in 0..p {
                rest[j] -= c * self.response[*family][level * p + j];
            }
            let (block, place, kept) = self.places[*family][*level];
            by_block.push((block, place, kept, c * self.theta[*family]));
        }
        by_block.sort_by_key(|(block, place, kept, _)| (*block, *kept, *place));
        let mut variance = rest.dot(&(&self.beta_covariance * &rest));
        for terms in by_block.chunk_by(|a, b| a.0 == b.0) {
            variance += self.quadratic(terms[0].0, terms);
        }
        Combination { mean, variance: self.sigma * self.sigma * variance }
    }

    /// cᵀA⁻¹c in one block.
    fn quadratic(&self, number: usize, terms: &[(usize, usize, bool, f64)]) -> f64 {
        let (block, solved) = (&self.trips.blocks[number], &self.blocks[number]);
        let coupling = self.theta[0] * self.theta[1];
        let mut kept = vec![0.0; block.kept.len()];
        let mut touched = Vec::new();
        let mut sum = 0.0;
        for (_, place, is_kept, c) in terms {
            if *is_kept {
                kept[*place] += c;
                touched.push(*place);
                continue;
            }
            sum += c * c / solved.pivots[*place];
            for (a, weight) in &block.cells[*place] {
                kept[*a] -= coupling * weight * c / solved.pivots[*place];
                touched.push(*a);
            }
        }
        touched.sort_unstable();
        touched.dedup();
        for a in &touched {
            let row = touched.iter().map(|b| solved.inverse[(*a, *b)] * kept[*b]);
            sum += kept[*a] * row.sum::<f64>();
        }
        sum
    }

    /// One draw of all effects.
    pub(crate) fn draw(&self, draws: &mut Draws, effects: &mut [Vec<f64>; 2]) {
        let p = self.trips.width;
        let mut numbers = vec![0.0; p];
        draws.normals(&mut numbers);
        let beta = &self.beta_root * DVector::from_vec(numbers) * self.sigma;
        for family in 0..2 {
            for (level, effect) in effects[family].iter_mut().enumerate() {
                let follows: f64 =
                    (0..p).map(|j| self.response[family][level * p + j] * beta[j]).sum();
                *effect = self.effects[family][level] - follows;
            }
        }
        let coupling = self.theta[0] * self.theta[1];
        let mut numbers = Vec::new();
        for (block, solved) in self.trips.blocks.iter().zip(&self.blocks) {
            let (m, families) = (block.kept.len(), [block.kept_family, 1 - block.kept_family]);
            numbers.resize(m + block.eliminated.len(), 0.0);
            draws.normals(&mut numbers);
            match &solved.dense {
                Dense::Diagonal(pivots) => {
                    for (number, pivot) in numbers.iter_mut().zip(pivots) {
                        *number /= libm::sqrt(*pivot);
                    }
                }
                Dense::Full(factor) => {
                    let mut kept = DVector::from_column_slice(&numbers[..m]);
                    factor.l_dirty().tr_solve_lower_triangular_mut(&mut kept);
                    numbers[..m].copy_from_slice(kept.as_slice());
                }
            }
            let scale = families.map(|family| self.sigma * self.theta[family]);
            for (a, level) in block.kept.iter().enumerate() {
                effects[families[0]][*level] += scale[0] * numbers[a];
            }
            for (e, (level, cells)) in block.eliminated.iter().zip(&block.cells).enumerate() {
                let coupled: f64 = cells.iter().map(|(a, w)| coupling * w * numbers[*a]).sum();
                let pivot = solved.pivots[e];
                let number = numbers[m + e] / libm::sqrt(pivot) - coupled / pivot;
                effects[families[1]][*level] += scale[1] * number;
            }
        }
    }
}

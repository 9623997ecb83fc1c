//! Linear model whose first coefficients vary over groups: restricted maximum likelihood (REML).
//!
//! y = X β + Z b + e with Z the first q columns of X, b ~ N(0, σ² Λ Λᵀ) in each group and e ~ N(0,
//! σ²). With W = (I + Z Λ Λᵀ Zᵀ)⁻¹ the criterion, β and σ² profiled out, is
//!
//! −2 l(Λ) = ln|I + Z Λ Λᵀ Zᵀ| + ln|XᵀWX| + (n − p) (1 + ln(2π s²/(n − p))), s² = min over β of (y
//! − Xβ)ᵀW(y − Xβ).
//!
//! Each group's rows are first reduced to the triangle of \[X y\], which leaves every term as it
//! is; an evaluation then costs a few hundred operations a group.
//!
//! Source: D. Bates, M. Mächler, B. Bolker, S. Walker, Fitting linear mixed-effects models using
//! lme4, Journal of Statistical Software 67 (2015), sections 3.3 to 3.5 (the same criterion and
//! parametrisation).

use super::least_squares::Triangle;
use super::nelder_mead::minimise;
use super::profile_interval::sd_interval;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

/// A fitted mixed model.
#[derive(Clone, Debug, PartialEq)]
pub struct MixedFit {
    /// Fixed effects.
    pub coefficients: DVector<f64>,
    /// Covariance of the fixed effects.
    pub covariance: DMatrix<f64>,
    /// Covariance of the effects of a group.
    pub group_covariance: DMatrix<f64>,
    /// Residual standard deviation.
    pub residual_sd: f64,
    /// Minus twice the restricted log-likelihood.
    pub criterion: f64,
    /// Whether an effect has no variance of its own over the groups: it comes out as 0, or as
    /// following wholly from another one.
    pub singular: bool,
}

/// An entry of Λ's diagonal below this counts as 0: the fit is singular (lme4's tolerance).
const SINGULAR: f64 = 1e-4;

/// The grouped data of a mixed model.
pub struct GroupedRows {
    /// Triangle of \[X y\] of each group, row by row, one behind the other.
    triangles: Vec<f64>,
    groups: usize,
    n: usize,
    width: usize,
}

/// Rest of the rows after Λ.
struct Profile {
    /// Triangle of the whitened \[X y\].
    triangle: DMatrix<f64>,
    /// ln|I + Z Λ Λᵀ Zᵀ| + ln|XᵀWX|.
    log_determinant: f64,
    /// s².
    sum_sq: f64,
}

impl GroupedRows {
    /// Reduces `n` rows of `width` predictors; `row` writes a row's predictors into its argument
    /// and returns its group and the response.
    pub fn reduce(
        n: usize,
        width: usize,
        groups: usize,
        row: impl Fn(usize, &mut [f64]) -> (usize, f64),
    ) -> Self {
        let mut triangles = vec![Triangle::new(width + 1); groups];
        let mut values = vec![0.0; width + 1];
        for k in 0..n {
            let (group, response) = row(k, &mut values[..width]);
            values[width] = response;
            triangles[group].push(&values);
        }
        let rows = triangles.iter().flat_map(|triangle| {
            triangle.reduced().transpose().iter().copied().collect::<Vec<f64>>()
        });
        Self { triangles: rows.collect(), groups, n, width }
    }

    /// Fits a random intercept: column 0 varies over the groups.
    ///
    /// None where there are too few rows or a fixed effect is not determined.
    pub fn random_intercept(&self) -> Option<MixedFit> {
        self.fit([1.0], |theta| DMatrix::from_element(1, 1, theta[0]))
    }

    /// Fits a random intercept and slope: columns 0 and 1 vary over the groups, correlated.
    ///
    /// None where there are too few rows or a fixed effect is not determined.
    pub fn random_slope(&self) -> Option<MixedFit> {
        self.fit([1.0, 0.0, 1.0], |theta| {
            DMatrix::from_row_slice(2, 2, &[theta[0], 0.0, theta[1], theta[2]])
        })
    }

    /// The 95 % interval of the SD of the groups' intercepts, by its profile likelihood; none with
    /// fewer than two groups.
    pub fn intercept_sd_interval(&self, fit: &MixedFit) -> Option<[f64; 2]> {
        if self.groups < 2 || !(fit.residual_sd > 0.0) {
            return None;
        }
        let df = (self.n - self.width) as f64;
        // at a residual SD of σ, given by ln(σ/σ̂)
        let at = |tau: f64, log_ratio: f64| {
            let sigma = fit.residual_sd * libm::exp(log_ratio);
            let profile = self.profile(&DMatrix::from_element(1, 1, tau / sigma));
            profile.map_or(f64::INFINITY, |profile| {
                let variance = sigma * sigma;
                profile.log_determinant + df * libm::log(variance) + profile.sum_sq / variance
            })
        };
        // the best σ of a τ by parabolas, which the likelihood of σ is but for a few percent
        let deviance = |tau: f64| {
            let (mut centre, mut reach) = (0.0, 0.05);
            for _ in 0..4 {
                let [low, middle, high] = [-reach, 0.0, reach].map(|off| at(tau, centre + off));
                let bend = low - 2.0 * middle + high;
                if bend > 0.0 {
                    centre += (0.5 * reach * (low - high) / bend).clamp(-0.5, 0.5);
                }
                reach *= 0.2;
            }
            at(tau, centre)
        };
        let best = libm::sqrt(fit.group_covariance[(0, 0)]);
        let best = if fit.singular { 0.0 } else { best };
        Some(sd_interval(best, self.groups, deviance))
    }

    fn fit<const D: usize>(
        &self,
        start: [f64; D],
        factor: impl Fn(&[f64; D]) -> DMatrix<f64>,
    ) -> Option<MixedFit> {
        if self.n <= self.width {
            return None;
        }
        let criterion = |theta: &[f64; D]| {
            let profile = self.profile(&factor(theta));
            let criterion = profile.map(|profile| self.criterion(&profile));
            criterion.filter(|criterion| criterion.is_finite()).unwrap_or(f64::INFINITY)
        };
        // effects a tenth or as large as the residual: the search meets either from its own side
        let small = start.map(|theta| 0.1 * theta);
        let (a, b) = (minimise(criterion, start, 0.5), minimise(criterion, small, 0.05));
        let theta = if a.1 <= b.1 { a.0 } else { b.0 };
        let lambda = factor(&theta);
        self.fitted(&lambda, &self.profile(&lambda)?)
    }

    fn criterion(&self, profile: &Profile) -> f64 {
        let df = (self.n - self.width) as f64;
        profile.log_determinant + df * (1.0 + libm::log(2.0 * PI * profile.sum_sq / df))
    }

    /// Profile at Λ.
    fn profile(&self, lambda: &DMatrix<f64>) -> Option<Profile> {
        let (p, q, m) = (self.width, lambda.nrows(), self.width + 1);
        let mut stacked = Triangle::new(m);
        let mut log_determinant = 0.0;
        // Z Λ, and the Cholesky factor of I + Z Λ Λᵀ Zᵀ, row by row
        let (mut z, mut l) = (vec![0.0; m * q], vec![0.0; m * m]);
        let mut whitened = vec![0.0; m * m];
        for rows in self.triangles.chunks_exact(m * m) {
            for i in 0..m {
                for j in 0..q {
                    z[i * q + j] = (0..q).map(|k| rows[i * m + k] * lambda[(k, j)]).sum();
                }
            }
            let mut determinant = 1.0;
            for i in 0..m {
                for j in 0..=i {
                    let mut entry: f64 = (0..q).map(|k| z[i * q + k] * z[j * q + k]).sum();
                    entry += f64::from(i == j);
                    for k in 0..j {
                        entry -= l[i * m + k] * l[j * m + k];
                    }
                    l[i * m + j] = if i == j { libm::sqrt(entry) } else { entry / l[j * m + j] };
                }
                determinant *= l[i * m + i];
            }
            if !(determinant > 0.0) {
                return None;
            }
            log_determinant += 2.0 * libm::log(determinant);
            // rows with unit variance
            for i in 0..m {
                for j in 0..m {
                    let mut entry = rows[i * m + j];
                    for k in 0..i {
                        entry -= l[i * m + k] * whitened[k * m + j];
                    }
                    whitened[i * m + j] = entry / l[i * m + i];
                }
            }
            whitened.chunks_exact(m).for_each(|row| stacked.push(row));
        }
        let triangle = stacked.reduced();
        for j in 0..p {
            let diagonal = triangle[(j, j)].abs();
            if !(diagonal > 1e-12 * triangle.column(j).norm()) {
                return None;
            }
            log_determinant += 2.0 * libm::log(diagonal);
        }
        let last = triangle[(p, p)];
        Some(Profile { triangle, log_determinant, sum_sq: last * last })
    }

    /// The fit of a Λ.
    fn fitted(&self, lambda: &DMatrix<f64>, profile: &Profile) -> Option<MixedFit> {
        let (p, triangle) = (self.width, &profile.triangle);
        let r = triangle.view((0, 0), (p, p)).into_owned();
        let coefficients =
            r.solve_upper_triangular(&triangle.view((0, p), (p, 1)).column(0).into_owned())?;
        let inverse = r.solve_upper_triangular(&DMatrix::identity(p, p))?;
        let criterion = self.criterion(profile);
        let variance = profile.sum_sq / (self.n - p) as f64;
        criterion.is_finite().then(|| MixedFit {
            coefficients,
            covariance: &inverse * inverse.transpose() * variance,
            group_covariance: lambda * lambda.transpose() * variance,
            residual_sd: libm::sqrt(variance),
            criterion,
            singular: (0..lambda.nrows()).any(|j| !(lambda[(j, j)].abs() >= SINGULAR)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    #[test]
    fn balanced_one_way_data_have_the_closed_form() {
        // REML of balanced one-way data is the analysis-of-variance estimate: (MS_between -
        // MS_within) / k
        let (groups, k) = (8, 6);
        let mut draws = Draws::new(2, 0, Stream::Vehicle);
        let y: Vec<Vec<f64>> = (0..groups)
            .map(|_| {
                let level = 2.0 * draws.normal();
                (0..k).map(|_| 10.0 + level + draws.normal()).collect()
            })
            .collect();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let levels: Vec<f64> = y.iter().map(|group| mean(group)).collect();
        let grand = mean(&levels);
        let between = levels.iter().map(|m| (m - grand).powi(2)).sum::<f64>() * k as f64
            / (groups - 1) as f64;
        let within = y
            .iter()
            .zip(&levels)
            .flat_map(|(group, m)| group.iter().map(move |y| (y - m).powi(2)))
            .sum::<f64>()
            / (groups * (k - 1)) as f64;
        let rows = GroupedRows::reduce(groups * k, 1, groups, |i, x| {
            x[0] = 1.0;
            (i / k, y[i / k][i % k])
        });
        let fit = rows.random_intercept().unwrap();
        assert!((fit.residual_sd.powi(2) - within).abs() < 1e-6 * within);
        let wanted = (between - within) / k as f64;
        assert!((fit.group_covariance[(0, 0)] - wanted).abs() < 1e-5 * wanted);
        assert!((fit.coefficients[0] - grand).abs() < 1e-10);
        let error = between / (groups * k) as f64;
        assert!((fit.covariance[(0, 0)] - error).abs() < 1e-5 * error);
    }

    /// `groups` levels with the SD `tau` and six values each around them, with an SD of 1.
    fn levels(seed: u64, groups: usize, tau: f64) -> GroupedRows {
        let mut draws = Draws::new(seed, 1, Stream::Vehicle);
        let levels: Vec<f64> = (0..groups).map(|_| 3.0 + tau * draws.normal()).collect();
        let y: Vec<f64> = (0..6 * groups).map(|k| levels[k / 6] + draws.normal()).collect();
        GroupedRows::reduce(6 * groups, 1, groups, |k, x| {
            x[0] = 1.0;
            (k / 6, y[k])
        })
    }

    #[test]
    fn the_interval_of_the_spread_covers() {
        let mut covered = 0;
        for seed in 0..400 {
            let rows = levels(seed, 10, 0.8);
            let fit = rows.random_intercept().unwrap();
            let [low, high] = rows.intercept_sd_interval(&fit).unwrap();
            covered += usize::from(low <= 0.8 && 0.8 <= high);
        }
        // 95 % of 400 with three binomial errors
        assert!((367..=393).contains(&covered), "{covered}");
    }

    #[test]
    fn groups_that_do_not_differ_are_singular() {
        let fits: Vec<MixedFit> =
            (0..40).map(|seed| levels(seed, 8, 0.0).random_intercept().unwrap()).collect();
        let singular = fits.iter().filter(|fit| fit.singular).count();
        // the mean square between is below that within in somewhat more than half of the cases
        assert!((12..=32).contains(&singular), "{singular}");
        for fit in fits.iter().filter(|fit| fit.singular) {
            assert!(fit.group_covariance[(0, 0)] < 1e-6, "{fit:?}");
        }
        assert!(!levels(1, 8, 2.0).random_intercept().unwrap().singular);
    }
}

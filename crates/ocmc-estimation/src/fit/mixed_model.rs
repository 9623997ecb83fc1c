//! Linear model whose first coefficients vary over groups: restricted maximum likelihood (REML).
//!
//! y = X β + Z b + e with Z the first q columns of X, b ~ N(0, σ² Λ Λᵀ) in each group and e ~ N(0,
//! σ²). With W = (I + Z Λ Λᵀ Zᵀ)⁻¹ the criterion, β and σ² profiled out, is
//!
//! −2 l(Λ) = ln|I + Z Λ Λᵀ Zᵀ| + ln|XᵀWX| + (n − p) (1 + ln(2π s²/(n − p))), s² = min over β of (y
//! − Xβ)ᵀW(y − Xβ).
//!
//! Each group's rows are first reduced to the triangle of \[X y\], which leaves every term as it
//! is; an evaluation then costs a few small matrices a group.
//!
//! Source: D. Bates, M. Mächler, B. Bolker, S. Walker, Fitting linear mixed-effects models using
//! lme4, Journal of Statistical Software 67 (2015), sections 3.3 to 3.5 (the same criterion and
//! parametrisation).

use super::least_squares::Triangle;
use super::nelder_mead::minimise;
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
}

/// The grouped data of a mixed model.
pub struct GroupedRows {
    /// Triangle of \[X y\] of each group.
    groups: Vec<DMatrix<f64>>,
    n: usize,
    width: usize,
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
        Self { groups: triangles.iter().map(Triangle::reduced).collect(), n, width }
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

    fn fit<const D: usize>(
        &self,
        start: [f64; D],
        factor: impl Fn(&[f64; D]) -> DMatrix<f64>,
    ) -> Option<MixedFit> {
        if self.n <= self.width {
            return None;
        }
        let criterion = |theta: &[f64; D]| {
            self.profile(&factor(theta)).map_or(f64::INFINITY, |fit| fit.criterion)
        };
        // effects a tenth or as large as the residual: the search meets either from its own side
        let small = start.map(|theta| 0.1 * theta);
        let (a, b) = (minimise(criterion, start, 0.5), minimise(criterion, small, 0.05));
        let theta = if a.1 <= b.1 { a.0 } else { b.0 };
        self.profile(&factor(&theta))
    }

    /// What follows from Λ.
    fn profile(&self, lambda: &DMatrix<f64>) -> Option<MixedFit> {
        let (p, q) = (self.width, lambda.nrows());
        let mut stacked = Triangle::new(p + 1);
        let mut log_determinant = 0.0;
        for rows in &self.groups {
            let z = rows.columns(0, q) * lambda;
            let spread = DMatrix::identity(p + 1, p + 1) + &z * z.transpose();
            let root = spread.cholesky()?;
            let l = root.l();
            log_determinant += 2.0 * (0..=p).map(|j| libm::log(l[(j, j)])).sum::<f64>();
            // rows with unit variance
            let whitened = l.solve_lower_triangular(rows)?;
            for row in whitened.row_iter() {
                stacked.push(&row.iter().copied().collect::<Vec<f64>>());
            }
        }
        let triangle = stacked.reduced();
        let r = triangle.view((0, 0), (p, p)).into_owned();
        for j in 0..p {
            let diagonal = r[(j, j)].abs();
            if !(diagonal > 1e-12 * r.column(j).norm()) {
                return None;
            }
            log_determinant += 2.0 * libm::log(diagonal);
        }
        let coefficients =
            r.solve_upper_triangular(&triangle.view((0, p), (p, 1)).column(0).into_owned())?;
        let inverse = r.solve_upper_triangular(&DMatrix::identity(p, p))?;
        let last = triangle[(p, p)];
        let (sum_sq, df) = (last * last, (self.n - p) as f64);
        let criterion = log_determinant + df * (1.0 + libm::log(2.0 * PI * sum_sq / df));
        let variance = sum_sq / df;
        criterion.is_finite().then(|| MixedFit {
            coefficients,
            covariance: &inverse * inverse.transpose() * variance,
            group_covariance: lambda * lambda.transpose() * variance,
            residual_sd: libm::sqrt(variance),
            criterion,
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
}

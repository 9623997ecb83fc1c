//! Linear least squares with a level for each group, absorbed: no column of a matrix belongs to a
//! group, so that thousands of them cost no more than a few.
//!
//! y = level_g + z b + e. By the theorem of Frisch, Waugh and Lovell b is that of the deviations
//! from the groups' means, and level_g = ȳ_g − z̄_g b. What the columns explain within groups is
//! the triangle W of those deviations; what they explain over all rows is that of W and of √n_g
//! times the means of the groups, less the mean over all. Sums of squares never come from a
//! difference: the groups explain, beside the columns z,
//!
//! Σ n_g (ȳ_g − ȳ − (z̄_g − z̄) b_T)² + |W (b_W − b_T)|²
//!
//! with b_T over all rows and b_W within groups.
//!
//! Source: R. Frisch, F. V. Waugh, Econometrica 1 (1933); M. C. Lovell, Journal of the American
//! Statistical Association 58 (1963). Equal to the dense regression in `tests`.

use super::least_squares::{Collinear, Part, Triangle, check_collinear};
use nalgebra::{DMatrix, DVector};

/// A least-squares problem with a level for each group.
#[derive(Clone, Debug, PartialEq)]
pub struct Absorbed {
    /// Within groups: triangle of the columns, and how far they reach in y.
    within: Part,
    /// Over all rows, with one level.
    total: Part,
    /// Rows of each group.
    counts: Vec<f64>,
    /// Means of the columns in each group, a row a group.
    means: DMatrix<f64>,
    /// Mean of y in each group.
    y_means: DVector<f64>,
    /// Rest of y after columns and groups, as sum of squares.
    pub residual_sum_sq: f64,
    /// Number of rows.
    pub rows: usize,
}

/// A linear combination of levels and coefficients: the sum over groups of (`every` + its part of
/// `groups`) times the level, and of `columns` times the coefficient.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Combination {
    /// Weight of every level.
    pub every: f64,
    /// Groups with a weight beside it; each group once.
    pub groups: Vec<(usize, f64)>,
    /// Weights of the coefficients.
    pub columns: Vec<f64>,
}

impl Absorbed {
    /// Reduces `n` rows of `width` columns in `groups` groups.
    ///
    /// `row` writes the columns of a row into its argument and returns its group and the response.
    /// Every group has a row.
    ///
    /// # Errors
    /// [`Collinear`] names the first column that the groups and the columns before it determine.
    pub fn reduce(
        n: usize,
        width: usize,
        groups: usize,
        row: impl Fn(usize, &mut [f64]) -> (usize, f64),
    ) -> Result<Self, Collinear> {
        let mut values = vec![0.0; width + 1];
        let mut counts = vec![0.0; groups];
        let mut means = vec![0.0; groups * (width + 1)];
        let mut grand = vec![0.0; width + 1];
        for k in 0..n {
            let (group, y) = row(k, &mut values[..width]);
            values[width] = y;
            counts[group] += 1.0;
            let of_group = &mut means[group * (width + 1)..(group + 1) * (width + 1)];
            for (j, value) in values.iter().enumerate() {
                of_group[j] += (value - of_group[j]) / counts[group];
                grand[j] += (value - grand[j]) / (k + 1) as f64;
            }
        }
        let mut within = Triangle::new(width + 1);
        let mut lengths = vec![0.0; width];
        for k in 0..n {
            let (group, y) = row(k, &mut values[..width]);
            values[width] = y;
            for j in 0..width {
                lengths[j] += (values[j] - grand[j]) * (values[j] - grand[j]);
            }
            for (j, value) in values.iter_mut().enumerate() {
                *value -= means[group * (width + 1) + j];
            }
            within.push(&values);
        }
        let inner = within.reduced();
        check_collinear(&inner, &lengths)?;
        let mut total = Triangle::new(width + 1);
        for row in inner.row_iter() {
            total.push(&row.iter().copied().collect::<Vec<f64>>());
        }
        for (group, count) in counts.iter().enumerate() {
            for (j, value) in values.iter_mut().enumerate() {
                *value = libm::sqrt(*count) * (means[group * (width + 1) + j] - grand[j]);
            }
            total.push(&values);
        }
        let (within, residual_sum_sq) = Part::of(&inner);
        let (total, _) = Part::of(&total.reduced());
        let means = DMatrix::from_row_slice(groups, width + 1, &means);
        let y_means = means.column(width).into_owned();
        let means = means.columns(0, width).into_owned();
        Ok(Self { within, total, counts, means, y_means, residual_sum_sq, rows: n })
    }

    /// The same rows with these columns in this order; the others are left out.
    #[must_use]
    pub fn with_columns(&self, order: &[usize]) -> Self {
        let (within, more) = self.within.with_columns(order);
        let (total, _) = self.total.with_columns(order);
        let mut means = DMatrix::zeros(self.means.nrows(), order.len());
        for (to, &from) in order.iter().enumerate() {
            means.set_column(to, &self.means.column(from));
        }
        let residual_sum_sq = self.residual_sum_sq + more;
        Self { within, total, means, residual_sum_sq, ..self.clone() }
    }

    /// The same rows with the coefficient of a column fixed, which leaves the problem.
    #[must_use]
    pub fn with_fixed(&self, column: usize, value: f64) -> Self {
        let mut offset = self.clone();
        offset.within.effects -= value * self.within.r.column(column);
        offset.total.effects -= value * self.total.r.column(column);
        offset.y_means -= value * self.means.column(column);
        let others: Vec<usize> = (0..self.width()).filter(|&other| other != column).collect();
        offset.with_columns(&others)
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.within.r.ncols()
    }

    /// Number of groups.
    pub fn groups(&self) -> usize {
        self.counts.len()
    }

    /// Rows less levels and columns; 0 where there are no more rows than these.
    pub fn residual_df(&self) -> usize {
        self.rows.saturating_sub(self.groups() + self.width())
    }

    /// Residual standard deviation; NaN without a degree of freedom.
    pub fn residual_sd(&self) -> f64 {
        libm::sqrt(self.residual_sum_sq / self.residual_df() as f64)
    }

    /// The coefficients.
    pub fn coefficients(&self) -> DVector<f64> {
        self.within.coefficients()
    }

    /// The level of each group.
    pub fn levels(&self) -> DVector<f64> {
        &self.y_means - &self.means * self.coefficients()
    }

    /// The part of (XᵀX)⁻¹ that belongs to the coefficients.
    pub fn inverse_gram(&self) -> DMatrix<f64> {
        self.within.inverse_gram()
    }

    /// Means of the columns in a group.
    pub fn group_mean(&self, group: usize) -> Vec<f64> {
        self.means.row(group).iter().copied().collect()
    }

    /// Sum of squares that a column explains of what the groups and the columns before it leave.
    pub fn sum_sq_beside_groups(&self, column: usize) -> f64 {
        self.within.effects[column] * self.within.effects[column]
    }

    /// Sum of squares that a column explains of what one level and the columns before it leave.
    pub fn sum_sq_without_groups(&self, column: usize) -> f64 {
        self.total.effects[column] * self.total.effects[column]
    }

    /// Sum of squares that the groups explain of what one level and these columns leave.
    pub fn sum_sq_of_groups(&self, columns: &[usize]) -> f64 {
        let some = self.with_columns(columns);
        let (total, within) = (some.total.coefficients(), some.within.coefficients());
        let off = &some.y_means - &some.means * &total;
        let rows = self.rows as f64;
        let mean = off.iter().zip(&self.counts).map(|(off, n)| off * n).sum::<f64>() / rows;
        let between: f64 =
            off.iter().zip(&self.counts).map(|(off, n)| n * (off - mean) * (off - mean)).sum();
        between + (&some.within.r * (within - total)).norm_squared()
    }

    /// The value of linear combinations of levels and coefficients, and their standard errors.
    pub fn combine<'a>(
        &'a self,
        combinations: impl IntoIterator<Item = Combination> + 'a,
    ) -> impl Iterator<Item = (f64, f64)> + 'a {
        let (levels, coefficients) = (self.levels(), self.coefficients());
        let (gram, sd) = (self.inverse_gram(), self.residual_sd());
        let sum_of_levels: f64 = levels.iter().sum();
        let sum_of_means = self.means.row_sum().transpose();
        let sum_of_reciprocals: f64 = self.counts.iter().map(|n| 1.0 / n).sum();
        combinations.into_iter().map(move |Combination { every, groups, columns }| {
            let columns = DVector::from_vec(columns);
            let mut value = every * sum_of_levels + columns.dot(&coefficients);
            let mut spread = every * every * sum_of_reciprocals;
            let mut reach = columns - every * &sum_of_means;
            for (group, weight) in groups {
                value += weight * levels[group];
                spread += weight * (2.0 * every + weight) / self.counts[group];
                reach -= weight * self.means.row(group).transpose();
            }
            let variance = spread + (&gram * &reach).dot(&reach);
            (value, sd * libm::sqrt(variance))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::least_squares::LeastSquares;
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    const GROUPS: usize = 5;

    /// Group, two columns, response; groups of unequal size whose means differ.
    fn rows() -> Vec<(usize, [f64; 2], f64)> {
        let mut draws = Draws::new(1, 0, Stream::Vehicle);
        (0..600)
            .map(|k| {
                let group = if k % 3 == 0 { 0 } else { k % GROUPS };
                let z = [0.3 * group as f64 + draws.normal(), f64::from(draws.uniform() < 0.4)];
                let y = 2.0 + 0.2 * group as f64 + 0.5 * z[0] - 0.1 * z[1] + 0.3 * draws.normal();
                (group, z, y)
            })
            .collect()
    }

    fn absorbed(rows: &[(usize, [f64; 2], f64)]) -> Absorbed {
        Absorbed::reduce(rows.len(), 2, GROUPS, |k, z| {
            z.copy_from_slice(&rows[k].1);
            (rows[k].0, rows[k].2)
        })
        .unwrap()
    }

    /// Columns: 1, both columns, contrasts to the first group.
    fn dense(rows: &[(usize, [f64; 2], f64)]) -> LeastSquares {
        LeastSquares::reduce(rows.len(), GROUPS + 2, |k, x| {
            let (group, z, y) = rows[k];
            x.fill(0.0);
            x[..3].copy_from_slice(&[1.0, z[0], z[1]]);
            if group > 0 {
                x[2 + group] = 1.0;
            }
            y
        })
        .unwrap()
    }

    #[track_caller]
    fn same(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-12 * b.abs().max(1e-3), "{a} {b}");
    }

    #[test]
    fn coefficients_errors_and_sums_of_squares_are_those_of_the_dense_regression() {
        let rows = rows();
        let (fit, all) = (absorbed(&rows), dense(&rows));
        assert_eq!(fit.residual_df(), all.residual_df());
        same(fit.residual_sum_sq, all.residual_sum_sq);
        let (b, gram, sd) = (all.coefficients(), all.inverse_gram(), all.residual_sd());
        for j in 0..2 {
            same(fit.coefficients()[j], b[1 + j]);
            same(fit.inverse_gram()[(j, j)], gram[(1 + j, 1 + j)]);
        }
        same(fit.levels()[0], b[0]);
        same(fit.levels()[3], b[0] + b[5]);
        // sequential: both columns, then the groups; and the groups beside the first column alone
        same(fit.sum_sq_without_groups(0), all.sequential_sum_sq(1));
        same(fit.sum_sq_without_groups(1), all.sequential_sum_sq(2));
        let sum = |fit: &LeastSquares, columns: std::ops::Range<usize>| {
            columns.map(|column| fit.sequential_sum_sq(column)).sum::<f64>()
        };
        same(fit.sum_sq_of_groups(&[0, 1]), sum(&all, 3..GROUPS + 2));
        let order = [0, 1, 3, 4, 5, 6, 2];
        let turned = all.with_columns(&order);
        same(fit.sum_sq_of_groups(&[0]), sum(&turned, 2..GROUPS + 1));
        same(fit.sum_sq_beside_groups(1), turned.sequential_sum_sq(GROUPS + 1));
        // a difference of levels plus a coefficient
        let combination =
            Combination { every: 0.0, groups: vec![(2, 1.0), (0, -1.0)], columns: vec![0.0, 3.0] };
        let (value, error) = fit.combine([combination]).next().unwrap();
        same(value, b[4] + 3.0 * b[2]);
        let variance = gram[(4, 4)] + 9.0 * gram[(2, 2)] + 6.0 * gram[(2, 4)];
        same(error, sd * variance.sqrt());
        // the mean level
        let every = Combination { every: 0.2, groups: vec![], columns: vec![0.0, 0.0] };
        let (value, error) = fit.combine([every]).next().unwrap();
        let weights = DVector::from_vec(vec![1.0, 0.0, 0.0, 0.2, 0.2, 0.2, 0.2]);
        same(value, weights.dot(&b));
        same(error, sd * (&gram * &weights).dot(&weights).sqrt());
    }

    #[test]
    fn sub_models_are_those_of_the_rows() {
        let rows = rows();
        let (fit, all) = (absorbed(&rows), dense(&rows));
        let (one, wanted) = (fit.with_columns(&[0]), all.with_columns(&[0, 1, 3, 4, 5, 6]));
        same(one.coefficients()[0], wanted.coefficients()[1]);
        same(one.residual_sum_sq, wanted.residual_sum_sq);
        same(one.levels()[0], wanted.coefficients()[0]);
        let (fixed, wanted) = (fit.with_fixed(0, 0.7), all.with_fixed(1, 0.7));
        same(fixed.coefficients()[0], wanted.coefficients()[1]);
        same(fixed.residual_sum_sq, wanted.residual_sum_sq);
        same(fixed.levels()[0], wanted.coefficients()[0]);
    }

    #[test]
    fn a_column_of_the_groups_is_named() {
        let rows = rows();
        let fit = Absorbed::reduce(rows.len(), 2, GROUPS, |k, z| {
            let (group, [x, _], y) = rows[k];
            z.copy_from_slice(&[x, group as f64]);
            (group, y)
        });
        assert_eq!(fit, Err(Collinear { column: 1 }));
    }
}

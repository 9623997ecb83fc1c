//! Linear least squares by Householder QR: one reduction of the rows, from which every sub-model
//! follows.
//!
//! The rows (x, y) are reduced to the triangle R of \[X y\] block by block, so memory does not grow
//! with their number, and normal equations are never formed. Dropping, reordering or fixing
//! coefficients then works on the triangle alone: its QR is that of the whole data.
//!
//! Predictors and response are taken relative to their means while they are reduced, and the
//! triangle is set back afterwards. This keeps the digits of data with a large common part.

use nalgebra::{DMatrix, DVector};
use thiserror::Error;

/// Rows that are reduced at a time.
const BLOCK: usize = 256;

/// Share of a column's length that has to be left of it beside the columns before it.
const COLLINEAR: f64 = 1e-11;

/// A least-squares problem, reduced: the intercept is column 0.
#[derive(Clone, Debug, PartialEq)]
pub struct LeastSquares {
    part: Part,
    /// Rest of y after the columns, as sum of squares.
    pub residual_sum_sq: f64,
    /// Number of rows.
    pub rows: usize,
}

/// Upper triangle R of columns X = Q R, and Qᵀ y: what they explain of y.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Part {
    pub(super) r: DMatrix<f64>,
    pub(super) effects: DVector<f64>,
}

impl Part {
    /// Part of a triangle of \[Z y\], and the rest of y, as sum of squares.
    pub(super) fn of(triangle: &DMatrix<f64>) -> (Self, f64) {
        let width = triangle.ncols() - 1;
        let r = triangle.view((0, 0), (width, width)).into_owned();
        let effects = triangle.view((0, width), (width, 1)).column(0).into_owned();
        let last = triangle[(width, width)];
        (Self { r, effects }, last * last)
    }

    /// These columns in this order; what the others explained of y, as sum of squares.
    pub(super) fn with_columns(&self, order: &[usize]) -> (Self, f64) {
        let width = order.len();
        let mut columns = DMatrix::zeros(self.r.nrows(), width + 1);
        for (to, &from) in order.iter().enumerate() {
            columns.set_column(to, &self.r.column(from));
        }
        columns.set_column(width, &self.effects);
        // where no column is left out, the triangle has one row less than the response reaches
        Self::of(&columns.qr().r().resize_vertically(width + 1, 0.0))
    }

    pub(super) fn coefficients(&self) -> DVector<f64> {
        let solved = self.r.solve_upper_triangular(&self.effects);
        solved.expect("no diagonal is zero: collinear columns were refused")
    }

    pub(super) fn inverse_gram(&self) -> DMatrix<f64> {
        let width = self.r.ncols();
        let inverse = self.r.solve_upper_triangular(&DMatrix::identity(width, width));
        let inverse = inverse.expect("no diagonal is zero: collinear columns were refused");
        &inverse * inverse.transpose()
    }
}

/// Refuses columns of which the triangle leaves next to nothing of their `lengths` squared.
pub(super) fn check_collinear(triangle: &DMatrix<f64>, lengths: &[f64]) -> Result<(), Collinear> {
    for (column, length) in lengths.iter().enumerate() {
        let left = triangle[(column, column)].abs();
        if !(left > COLLINEAR * libm::sqrt(*length)) {
            return Err(Collinear { column });
        }
    }
    Ok(())
}

/// A column that the columns before it determine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("column {column} is determined by the columns before it")]
pub struct Collinear {
    /// The column, from 0.
    pub column: usize,
}

/// The triangle of rows that come one after the other.
#[derive(Clone, Debug)]
pub(crate) struct Triangle {
    width: usize,
    rows: Vec<f64>,
}

impl Triangle {
    pub(crate) fn new(width: usize) -> Self {
        Self { width, rows: Vec::with_capacity((BLOCK + width) * width) }
    }

    pub(crate) fn push(&mut self, row: &[f64]) {
        self.rows.extend_from_slice(row);
        if self.rows.len() >= (BLOCK + self.width) * self.width {
            let triangle = self.reduced();
            self.rows.clear();
            self.rows.extend(triangle.transpose().iter());
        }
    }

    /// The triangle, `width` by `width`, with rows of zeros where there are fewer rows.
    pub(crate) fn reduced(&self) -> DMatrix<f64> {
        let height = self.rows.len() / self.width;
        let rows = DMatrix::from_row_slice(height, self.width, &self.rows);
        rows.qr().r().resize_vertically(self.width, 0.0)
    }
}

impl LeastSquares {
    /// Reduces `n` rows of `width` predictors, of which the first one is the constant 1.
    ///
    /// `row` writes the predictors of a row into its argument and returns the response.
    ///
    /// # Errors
    /// [`Collinear`] names the first column that those before it determine, which is always the
    /// case with fewer rows than columns.
    pub fn reduce(
        n: usize,
        width: usize,
        row: impl Fn(usize, &mut [f64]) -> f64,
    ) -> Result<Self, Collinear> {
        let mut values = vec![0.0; width + 1];
        let mut means = vec![0.0; width + 1];
        for k in 0..n {
            values[width] = row(k, &mut values[..width]);
            for (mean, value) in means.iter_mut().zip(&values) {
                *mean += (value - *mean) / (k + 1) as f64;
            }
        }
        means[0] = 0.0;
        let mut triangle = Triangle::new(width + 1);
        let mut lengths = vec![0.0; width];
        for k in 0..n {
            values[width] = row(k, &mut values[..width]);
            for (value, mean) in values.iter_mut().zip(&means) {
                *value -= mean;
            }
            for (length, value) in lengths.iter_mut().zip(&values) {
                *length += value * value;
            }
            triangle.push(&values);
        }
        let triangle = triangle.reduced();
        check_collinear(&triangle, &lengths)?;
        let (mut part, residual_sum_sq) = Part::of(&triangle);
        for column in 1..width {
            part.r[(0, column)] += part.r[(0, 0)] * means[column];
        }
        part.effects[0] += part.r[(0, 0)] * means[width];
        Ok(Self { part, residual_sum_sq, rows: n })
    }

    /// The same rows with these columns in this order; the others are left out. Column 0 has to
    /// stay first.
    ///
    /// # Panics
    /// Where column 0 is not first or a column does not exist.
    #[must_use]
    pub fn with_columns(&self, order: &[usize]) -> Self {
        assert_eq!(order.first(), Some(&0), "the intercept stays first");
        let (part, more) = self.part.with_columns(order);
        Self { part, residual_sum_sq: self.residual_sum_sq + more, rows: self.rows }
    }

    /// The same rows with the coefficient of a column fixed, which leaves the problem.
    ///
    /// # Panics
    /// Where it is column 0 or does not exist.
    #[must_use]
    pub fn with_fixed(&self, column: usize, value: f64) -> Self {
        let mut offset = self.clone();
        offset.part.effects -= value * self.part.r.column(column);
        let others: Vec<usize> = (0..self.width()).filter(|&other| other != column).collect();
        offset.with_columns(&others)
    }

    /// The coefficients.
    pub fn coefficients(&self) -> DVector<f64> {
        self.part.coefficients()
    }

    /// (XᵀX)⁻¹ = R⁻¹R⁻ᵀ, whose product with the residual variance is the covariance of the
    /// coefficients.
    pub fn inverse_gram(&self) -> DMatrix<f64> {
        self.part.inverse_gram()
    }

    /// Sum of squares that each column explains of what those before it leave.
    pub fn sequential_sum_sq(&self, column: usize) -> f64 {
        self.part.effects[column] * self.part.effects[column]
    }

    /// Rows less columns.
    pub fn residual_df(&self) -> usize {
        self.rows - self.width()
    }

    /// Residual standard deviation; NaN without a degree of freedom.
    pub fn residual_sd(&self) -> f64 {
        libm::sqrt(self.residual_sum_sq / self.residual_df() as f64)
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.part.r.ncols()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    /// A noisy plane over more rows than a block.
    fn plane(n: usize) -> (Vec<[f64; 3]>, Vec<f64>) {
        let mut draws = Draws::new(1, 0, Stream::Vehicle);
        let rows: Vec<[f64; 3]> = (0..n).map(|_| [1.0, draws.normal(), draws.normal()]).collect();
        let y = rows.iter().map(|x| 3.0 + 2.0 * x[1] - x[2] + draws.normal()).collect();
        (rows, y)
    }

    fn reduce(rows: &[[f64; 3]], y: &[f64]) -> LeastSquares {
        LeastSquares::reduce(rows.len(), 3, |k, x| {
            x.copy_from_slice(&rows[k]);
            y[k]
        })
        .unwrap()
    }

    #[test]
    fn residuals_are_orthogonal_to_the_columns() {
        let (rows, y) = plane(1000);
        let fit = reduce(&rows, &y);
        let b = fit.coefficients();
        let residuals: Vec<f64> =
            rows.iter().zip(&y).map(|(x, y)| y - b[0] - b[1] * x[1] - b[2] * x[2]).collect();
        for j in 0..3 {
            let product: f64 = rows.iter().zip(&residuals).map(|(x, e)| x[j] * e).sum();
            assert!(product.abs() < 1e-10, "{j}: {product}");
        }
        let squares: f64 = residuals.iter().map(|e| e * e).sum();
        assert!((fit.residual_sum_sq - squares).abs() < 1e-10 * squares);
        assert_eq!(fit.residual_df(), 997);
    }

    #[test]
    fn sub_models_are_those_of_the_rows() {
        let (rows, y) = plane(700);
        let fit = reduce(&rows, &y);
        let one = LeastSquares::reduce(700, 2, |k, x| {
            x.copy_from_slice(&[1.0, rows[k][2]]);
            y[k]
        })
        .unwrap();
        let dropped = fit.with_columns(&[0, 2]);
        assert!((dropped.coefficients() - one.coefficients()).norm() < 1e-13);
        assert!((dropped.residual_sum_sq - one.residual_sum_sq).abs() < 1e-9);
        assert_eq!(dropped.residual_df(), 698);
        let fixed = LeastSquares::reduce(700, 2, |k, x| {
            x.copy_from_slice(&[1.0, rows[k][2]]);
            y[k] - 0.5 * rows[k][1]
        })
        .unwrap();
        let other = fit.with_fixed(1, 0.5);
        assert!((other.coefficients() - fixed.coefficients()).norm() < 1e-13);
        assert!((other.residual_sum_sq - fixed.residual_sum_sq).abs() < 1e-9);
        // reordered: the same fit, and the same sum of squares in another order
        let turned = fit.with_columns(&[0, 2, 1]);
        assert!((turned.coefficients()[2] - fit.coefficients()[1]).abs() < 1e-13);
        assert!((turned.residual_sum_sq - fit.residual_sum_sq).abs() < 1e-9);
        let explained = |fit: &LeastSquares| fit.sequential_sum_sq(1) + fit.sequential_sum_sq(2);
        assert!((explained(&turned) - explained(&fit)).abs() < 1e-9);
        assert!(
            (dropped.residual_sum_sq - fit.residual_sum_sq - turned.sequential_sum_sq(2)).abs()
                < 1e-9
        );
    }

    #[test]
    fn determined_columns_are_named() {
        let (rows, y) = plane(50);
        let fit = |third: fn(&[f64; 3]) -> f64, n| {
            LeastSquares::reduce(n, 3, |k, x| {
                x.copy_from_slice(&[1.0, rows[k][1], third(&rows[k])]);
                y[k]
            })
        };
        assert_eq!(fit(|x| 4.0 - 2.0 * x[1], 50), Err(Collinear { column: 2 }));
        assert_eq!(fit(|_| 7.0, 50), Err(Collinear { column: 2 }));
        assert_eq!(fit(|x| x[2], 2), Err(Collinear { column: 2 }));
        assert!(fit(|x| x[2], 3).is_ok());
    }
}

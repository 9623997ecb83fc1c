//! Analysis of variance of a linear model: how much of the sum of squares each term explains.
//!
//! Sequential sums of squares credit a term with what it explains of what the terms before it leave
//! (type I, the paper's table); marginal ones with what it explains of what all the others leave
//! (type III with sum-to-zero coding, which without interactions is type II). F =
//! (SS/df)/(RSS/df_e) follows the F law under a term without effect.

use super::least_squares::LeastSquares;
use super::p_value::ln_f_tail;
use serde::Serialize;
use std::ops::Range;

/// A term of the model: its name and its columns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Term {
    /// Name for people.
    pub name: &'static str,
    /// Columns of the design.
    pub columns: Range<usize>,
}

/// One row of the table; the last one is the residuals', without F and p.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VarianceRow {
    /// Name of the term.
    pub term: &'static str,
    /// Degrees of freedom.
    pub df: usize,
    /// Sum of squares.
    pub sum_sq: f64,
    /// Sum of squares over degrees of freedom.
    pub mean_sq: f64,
    /// F, none for the residuals.
    pub f: Option<f64>,
    /// P(F > f), 0 where it is below the smallest number.
    pub p: Option<f64>,
    /// ln p, which never underflows.
    pub ln_p: Option<f64>,
}

/// The table with sequential sums of squares, in the order of the columns.
pub fn sequential(fit: &LeastSquares, terms: &[Term]) -> Vec<VarianceRow> {
    let sum = |term: &Term| term.columns.clone().map(|column| fit.sequential_sum_sq(column)).sum();
    table(fit, terms, terms.iter().map(sum))
}

/// The table with marginal sums of squares.
pub fn marginal(fit: &LeastSquares, terms: &[Term]) -> Vec<VarianceRow> {
    let sums = terms.iter().map(|term| {
        let others = (0..fit.width()).filter(|column| !term.columns.contains(column));
        let order: Vec<usize> = others.chain(term.columns.clone()).collect();
        let last = fit.with_columns(&order);
        let first = fit.width() - term.columns.len();
        (first..fit.width()).map(|column| last.sequential_sum_sq(column)).sum()
    });
    table(fit, terms, sums)
}

fn table(fit: &LeastSquares, terms: &[Term], sums: impl Iterator<Item = f64>) -> Vec<VarianceRow> {
    let terms =
        terms.iter().zip(sums).map(|(term, sum_sq)| (term.name, term.columns.len(), sum_sq));
    rows(terms, fit.residual_df(), fit.residual_sum_sq)
}

/// The table of terms (name, degrees of freedom, sum of squares) and of what they leave.
pub fn rows(
    terms: impl IntoIterator<Item = (&'static str, usize, f64)>,
    df: usize,
    sum_sq: f64,
) -> Vec<VarianceRow> {
    let mean_sq = sum_sq / df as f64;
    let term = "residuals";
    let residuals = VarianceRow { term, df, sum_sq, mean_sq, f: None, p: None, ln_p: None };
    let of_term = |(term, columns, sum_sq): (&'static str, usize, f64)| {
        let mean_sq = sum_sq / columns as f64;
        let f = mean_sq / residuals.mean_sq;
        let ln_p = ln_f_tail(f, columns as f64, df as f64);
        let p = Some(libm::exp(ln_p));
        VarianceRow { term, df: columns, sum_sq, mean_sq, f: Some(f), p, ln_p: Some(ln_p) }
    };
    let mut rows: Vec<VarianceRow> = terms.into_iter().map(of_term).collect();
    rows.push(residuals);
    rows
}

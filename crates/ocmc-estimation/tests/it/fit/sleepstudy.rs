//! The sleep study beside its published mixed model.
//!
//! Belenky and others (2003), as fitted in D. Bates, M. Mächler, B. Bolker, S. Walker, Fitting
//! linear mixed-effects models using lme4, Journal of Statistical Software 67 (2015), section 5:
//! `Reaction ~ Days + (Days | Subject)`.

use super::{assert_prints, shared};
use ocmc_estimation::fit::mixed_model::GroupedRows;

#[test]
fn random_slope_and_intercept() {
    let Some(text) = shared("stats/mixed/sleepstudy.csv") else { return };
    let mut subjects: Vec<String> = Vec::new();
    let rows: Vec<(usize, f64, f64)> = text
        .lines()
        .skip(1)
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let subject = subjects.iter().position(|s| s == cells[0]).unwrap_or_else(|| {
                subjects.push(cells[0].to_owned());
                subjects.len() - 1
            });
            (subject, cells[1].parse().unwrap(), cells[2].parse().unwrap())
        })
        .collect();
    assert_eq!((rows.len(), subjects.len()), (180, 18));
    let grouped = GroupedRows::reduce(180, 2, 18, |k, x| {
        x.copy_from_slice(&[1.0, rows[k].1]);
        (rows[k].0, rows[k].2)
    });
    let fit = grouped.random_slope().unwrap();
    assert_prints("REML criterion", fit.criterion, "1743.6");
    assert_prints("intercept", fit.coefficients[0], "251.405");
    assert_prints("slope", fit.coefficients[1], "10.467");
    assert_prints("its error", fit.covariance[(0, 0)].sqrt(), "6.825");
    assert_prints("its error", fit.covariance[(1, 1)].sqrt(), "1.546");
    assert_prints("residual variance", fit.residual_sd.powi(2), "654.94");
    let covariance = &fit.group_covariance;
    assert_prints("SD of levels", covariance[(0, 0)].sqrt(), "24.74");
    assert_prints("SD of slopes", covariance[(1, 1)].sqrt(), "5.922");
    let correlation = covariance[(0, 1)] / (covariance[(0, 0)] * covariance[(1, 1)]).sqrt();
    assert_prints("correlation", correlation, "0.07");
    // a random intercept alone: 37.12 between, 30.99 within subjects
    let fit = grouped.random_intercept().unwrap();
    assert_prints("levels", fit.group_covariance[(0, 0)].sqrt(), "37.12");
    assert_prints("residual", fit.residual_sd, "30.99");
    assert_prints("REML criterion", fit.criterion, "1786.5");
}

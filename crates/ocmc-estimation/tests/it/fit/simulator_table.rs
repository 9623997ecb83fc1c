//! The paper's simulator tables from a data set with their moments.
//!
//! The set has the printed sums of squares. The paper prints F with more digits than those
//! determine (87.6916 beside 0.205265/0.00234079 = 87.6905), so F is compared to the digits that
//! they do.

use super::assert_prints;
use ocmc_estimation::fit::curve_speed::{CurveSpeedFit, CurveSpeedOptions, CurveTable, fit};
use ocmc_estimation::fit::p_value::p_text;
use std::path::Path;

fn table() -> CurveTable {
    let file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/data/simulator_curves.csv");
    let text = std::fs::read_to_string(file).unwrap();
    let mut table = CurveTable { left: Some(Vec::new()), ..CurveTable::default() };
    for line in text.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        table.driver.push(cells[0].to_owned());
        table.radius_m.push(cells[1].parse().unwrap());
        table.left.as_mut().unwrap().push(cells[2] == "left");
        table.speed_mps.push(cells[3].parse().unwrap());
    }
    table
}

fn fitted() -> CurveSpeedFit {
    fit(&table(), &CurveSpeedOptions::default()).unwrap()
}

#[test]
fn analysis_of_variance() {
    let fit = fitted();
    for (row, df, sum_sq, mean_sq, f, p) in [
        (0, 1, "0.20526", "0.205265", "87.69", "2.05e-11"),
        (1, 7, "1.07727", "0.153896", "65.75", ""),
        (2, 1, "0.00021", "0.000207", "0.088", "0.768"),
    ] {
        let row = &fit.anova[row];
        assert_eq!(row.df, df);
        assert_prints(row.term, row.sum_sq, sum_sq);
        assert_prints(row.term, row.mean_sq, mean_sq);
        assert_prints(row.term, row.f.unwrap(), f);
        match p {
            "" => assert!(row.p.unwrap() < 2.2e-16),
            "0.768" => assert_prints(row.term, row.p.unwrap(), p),
            _ => assert_eq!(p_text(row.ln_p.unwrap()), p),
        }
    }
    let residuals = fit.anova.last().unwrap();
    assert_eq!(residuals.df, 38);
    assert_prints("residuals", residuals.sum_sq, "0.08895");
    assert_prints("residuals", residuals.mean_sq, "0.002341");
    // balanced data: the order of the terms does not matter
    for (a, b) in fit.anova.iter().zip(&fit.anova_marginal) {
        assert!((a.sum_sq - b.sum_sq).abs() < 1e-12);
    }
}

#[test]
fn parameters() {
    let fit = fitted();
    assert!(fit.warnings.is_empty() && fit.dropped.is_empty(), "{:?}", fit.warnings);
    let estimated = &fit.estimated;
    assert_eq!(estimated.direction_effect, None);
    assert_prints("exponent", estimated.exponent, "0.23");
    let [low, high] = estimated.exponent_ci95.unwrap();
    assert_prints("low", low, "0.18");
    assert_prints("high", high, "0.28");
    assert_prints("reference speed", 3.6 * estimated.reference_speed_mps, "60");
    assert_prints("drivers", 100.0 * estimated.driver_sd.unwrap(), "16");
    assert_prints("residual", 100.0 * estimated.residual_sd, "4.8");
    // 92 % of the variance lies between drivers
    assert_prints("share", 100.0 * estimated.driver_share.unwrap(), "92");
    let fixed = &fit.fixed;
    assert!(fixed.exponent == 0.5 && fixed.exponent_ci95.is_none());
    assert_prints("reference speed", 3.6 * fixed.reference_speed_mps, "66");
    assert_prints("drivers", 100.0 * fixed.driver_sd.unwrap(), "16");
    assert_prints("residual", 100.0 * fixed.residual_sd, "9.6");
    assert!(fit.exponent_test.p < 1e-9 && fit.exponent_test.t < 0.0);
}

#[test]
fn coefficients_in_both_codings_are_one_model() {
    let other = CurveSpeedOptions {
        coding: ocmc_estimation::fit::curve_speed::Coding::Treatment,
        significance: 1.0,
        ..CurveSpeedOptions::default()
    };
    let treated = fit(&table(), &other).unwrap();
    let zero =
        fit(&table(), &CurveSpeedOptions { significance: 1.0, ..Default::default() }).unwrap();
    let of = |fit: &CurveSpeedFit, name: &str| {
        fit.coefficients.iter().find(|coefficient| coefficient.name == name).unwrap().clone()
    };
    let (a, b) = (of(&zero, "driver driver 5"), of(&zero, "driver driver 1"));
    let difference = of(&treated, "driver driver 5");
    assert!((difference.estimate - (a.estimate - b.estimate)).abs() < 1e-12);
    let sides = (of(&zero, "direction left"), of(&treated, "direction right"));
    assert!((sides.1.estimate + 2.0 * sides.0.estimate).abs() < 1e-12);
    assert!((sides.1.ln_p - sides.0.ln_p).abs() < 1e-9);
    let level = of(&zero, "ln reference speed").estimate + b.estimate + sides.0.estimate;
    assert!((of(&treated, "ln reference speed").estimate - level).abs() < 1e-12);
    // balanced: a difference of two drivers with six curves each has the error s √(1/6 + 1/6)
    let wanted = zero.estimated.residual_sd * (2.0f64 / 6.0).sqrt();
    assert!((difference.standard_error - wanted).abs() < 1e-12);
}

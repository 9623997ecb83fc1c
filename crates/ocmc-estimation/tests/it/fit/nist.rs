//! Certified values of NIST's Statistical Reference Datasets: linear regression and one-way
//! analysis of variance.

use super::shared;
use ocmc_estimation::fit::analysis_of_variance::{Term, sequential};
use ocmc_estimation::fit::least_squares::LeastSquares;

/// Digits that two numbers share, as NIST counts them: −log₁₀ of the relative difference, at most
/// 15.
fn digits(value: f64, certified: f64) -> f64 {
    let difference = ((value - certified) / certified).abs();
    if difference == 0.0 { 15.0 } else { (-difference.log10()).min(15.0) }
}

#[track_caller]
fn assert_digits(what: &str, value: f64, certified: f64, wanted: f64) {
    let digits = digits(value, certified);
    assert!(digits >= wanted, "{what}: {value} beside {certified}, {digits:.1} digits");
}

fn numbers(line: &str) -> Vec<f64> {
    line.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}

/// Between, within and F of a one-way file beside the certified ones: digits of F.
fn one_way(name: &str) -> Option<f64> {
    let text = shared(&format!("stats/nist_anova/{name}.dat"))?;
    let lines: Vec<&str> = text.lines().collect();
    let certified = |start: &str| {
        let line = lines.iter().find(|line| line.starts_with(start)).unwrap();
        numbers(line.split_at(18).1)
    };
    let (between, within) = (certified("Between"), certified("Within"));
    let rows: Vec<Vec<f64>> =
        lines[60..].iter().map(|line| numbers(line)).filter(|row| row.len() == 2).collect();
    let groups = rows.iter().map(|row| row[0] as usize).max().unwrap();
    let fit = LeastSquares::reduce(rows.len(), groups, |k, x| {
        x.fill(0.0);
        let group = rows[k][0] as usize - 1;
        x[0] = 1.0;
        if group > 0 {
            x[group] = 1.0;
        }
        rows[k][1]
    })
    .unwrap();
    let table = sequential(&fit, &[Term { name: "between", columns: 1..groups }]);
    assert_eq!((table[0].df, table[1].df), (between[0] as usize, within[0] as usize));
    let all = [
        digits(table[0].sum_sq, between[1]),
        digits(table[1].sum_sq, within[1]),
        digits(table[0].f.unwrap(), between[3]),
    ];
    println!(
        "{name}: digits of SS between {:.1}, SS within {:.1}, F {:.1}",
        all[0], all[1], all[2]
    );
    Some(all.into_iter().fold(15.0, f64::min))
}

#[test]
fn analysis_of_variance() {
    // SmLs04 and 06 have 7 constant leading digits, which cost the data themselves that many of
    // their 16; the others have none
    for (name, wanted) in
        [("SiRstv", 12.0), ("SmLs01", 13.0), ("SmLs03", 12.0), ("SmLs04", 9.0), ("SmLs06", 9.0)]
    {
        if let Some(digits) = one_way(name) {
            assert!(digits >= wanted, "{name}: {digits:.1} digits, wanted {wanted}");
        }
    }
}

#[test]
fn analysis_of_variance_at_the_end_of_double_precision() {
    // 13 constant leading digits: 0.1 beside 1e12 is stored to 1.2e-4, so the data hold three
    // digits. Exact arithmetic on the stored numbers gives no more; ours has to give the same.
    for (name, wanted) in [("SmLs07", 2.0), ("SmLs08", 2.0)] {
        if let Some(digits) = one_way(name) {
            assert!(digits >= wanted, "{name}: {digits:.1} digits, wanted {wanted}");
        }
    }
}

#[test]
fn norris() {
    let Some(text) = shared("stats/nist_linear/Norris.dat") else { return };
    let rows: Vec<Vec<f64>> =
        text.lines().skip(60).map(numbers).filter(|row| row.len() == 2).collect();
    assert_eq!(rows.len(), 36);
    let fit = LeastSquares::reduce(36, 2, |k, x| {
        x.copy_from_slice(&[1.0, rows[k][1]]);
        rows[k][0]
    })
    .unwrap();
    let (b, gram, sd) = (fit.coefficients(), fit.inverse_gram(), fit.residual_sd());
    assert_digits("B0", b[0], -0.262323073774029, 11.0);
    assert_digits("B1", b[1], 1.00211681802045, 13.0);
    assert_digits("SD of B0", sd * gram[(0, 0)].sqrt(), 0.232818234301152, 12.0);
    assert_digits("SD of B1", sd * gram[(1, 1)].sqrt(), 0.429796848199937e-3, 12.0);
    assert_digits("residual SD", sd, 0.884796396144373, 12.0);
    let table = sequential(&fit, &[Term { name: "x", columns: 1..2 }]);
    assert_digits("SS", table[0].sum_sq, 4255954.13232369, 13.0);
    assert_digits("F", table[0].f.unwrap(), 5436385.54079785, 12.0);
}

#[test]
fn longley() {
    let Some(text) = shared("stats/nist_linear/longley.csv") else { return };
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
        .collect();
    let fit = LeastSquares::reduce(rows.len(), 7, |k, x| {
        x[0] = 1.0;
        x[1..].copy_from_slice(&rows[k][2..]);
        rows[k][1]
    })
    .unwrap();
    let (b, gram, sd) = (fit.coefficients(), fit.inverse_gram(), fit.residual_sd());
    // certified: https://www.itl.nist.gov/div898/strd/lls/data/LINKS/v-Longley.shtml
    let certified = [
        (-3482258.63459582, 890420.383607373),
        (15.0618722713733, 84.9149257747669),
        (-0.358191792925910e-1, 0.334910077722432e-1),
        (-2.02022980381683, 0.488399681651699),
        (-1.03322686717359, 0.214274163161675),
        (-0.511041056535807e-1, 0.226073200069370),
        (1829.15146461355, 455.478499142212),
    ];
    for (j, (estimate, error)) in certified.into_iter().enumerate() {
        assert_digits("estimate", b[j], estimate, 9.0);
        assert_digits("error", sd * gram[(j, j)].sqrt(), error, 9.0);
    }
    assert_digits("residual SD", sd, 304.854073561965, 11.0);
}

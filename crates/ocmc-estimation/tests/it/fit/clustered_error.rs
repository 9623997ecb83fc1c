//! The clustered standard error of the curve-speed exponent beside another implementation.
//!
//! Reference values: numpy 2 and scipy 1, on matrices of all rows with a column for each driver:
//! residuals e = (I − H) y, A_g = (I − H_gg)^(−1/2) by its eigenvalues, Σ (cᵀ(XᵀX)⁻¹ X_gᵀ A_g
//! e_g)²; the 97.5 % quantile of the ratio by Imhof's integral over the eigenvalues of the
//! quadratic form, and the degrees of freedom of Student's law that has it. The columns of X:
//! ln(R/250) and the drivers; with the direction ±1 for left and right.

use super::coverage::assert_covers;
use crate::common::field_truck_model;
use ocmc_core::random::{Draws, Stream};
use ocmc_estimation::fit::curve_speed::{CurveSpeedFit, CurveSpeedOptions, CurveTable, fit};

/// Driver, radius in m, speed in m/s, whether the curve turns left.
const CURVES: [(&str, f64, f64, bool); 12] = [
    ("a", 30.0, 7.5, true),
    ("a", 60.0, 9.0, false),
    ("a", 120.0, 12.5, true),
    ("a", 250.0, 16.0, false),
    ("a", 400.0, 19.0, true),
    ("b", 45.0, 8.0, false),
    ("b", 90.0, 11.5, true),
    ("b", 300.0, 17.0, false),
    ("c", 35.0, 6.5, true),
    ("c", 80.0, 9.5, true),
    ("c", 160.0, 11.0, false),
    ("c", 450.0, 18.5, false),
];

#[test]
fn the_error_by_drivers_is_that_of_matrices_of_all_rows() {
    let table = CurveTable {
        driver: CURVES.iter().map(|curve| curve.0.to_owned()).collect(),
        radius_m: CURVES.iter().map(|curve| curve.1).collect(),
        speed_mps: CURVES.iter().map(|curve| curve.2).collect(),
        left: Some(CURVES.iter().map(|curve| curve.3).collect()),
        ..CurveTable::default()
    };
    let fitted = fit(&table, &CurveSpeedOptions::default()).unwrap();
    let with_direction = fitted.with_direction.unwrap();
    for (estimate, exponent, independent, clustered, degrees, t) in [
        (
            &fitted.estimated,
            0.3826178236179034,
            0.015954881223956805,
            0.010814630789604127,
            1.9312642656339012,
            4.452785341635038,
        ),
        (
            &with_direction,
            0.3927264112344083,
            0.01482167338691097,
            0.02444419991781165,
            1.9553328582249778,
            4.398228204451707,
        ),
    ] {
        let found = [
            estimate.exponent,
            estimate.exponent_standard_error.unwrap(),
            estimate.exponent_clustered_standard_error.unwrap(),
            estimate.exponent_clustered_degrees.unwrap(),
        ];
        for (found, wanted) in found.into_iter().zip([exponent, independent, clustered, degrees]) {
            assert!((found / wanted - 1.0).abs() < 1e-7, "{found} {wanted}");
        }
        let [low, high] = estimate.exponent_clustered_ci95.unwrap();
        let reach = t * clustered;
        // the integral of the quantile is good to seven digits
        assert!((high - low - 2.0 * reach).abs() < 1e-6 * reach, "{low} {high} {reach}");
    }
}

const EXPONENT: f64 = 0.46;

/// Curves of drivers who have so many each, by the law of the paper's field trucks.
fn drawn(counts: &[usize], draws: &mut Draws) -> CurveSpeedFit {
    let mut table = CurveTable::default();
    for (driver, count) in counts.iter().enumerate() {
        let (level, around) = (0.056 * draws.normal(), 0.3 * draws.normal());
        for _ in 0..*count {
            let radius_m = (150.0 * (around + 0.6 * draws.normal()).exp()).clamp(21.0, 499.0);
            let log = EXPONENT * (radius_m / 250.0).ln() + level + 0.177 * draws.normal();
            table.driver.push(format!("driver {driver}"));
            table.radius_m.push(radius_m);
            table.speed_mps.push(15.14 * log.exp());
        }
    }
    fit(&table, &CurveSpeedOptions::default()).unwrap()
}

/// With unequal numbers of curves (log-SD 1.1, as the paper's trucks) one driver may have half of
/// them. As written into the study: ± 1.96 of the error there, too.
#[test]
fn intervals_by_drivers_cover_with_equal_and_unequal_numbers_of_curves() {
    let runs = 80;
    let (mut covered, mut cells) = (0, 0);
    for (cell, (drivers, log_sd)) in
        [5, 10, 25, 40].into_iter().flat_map(|n| [(n, 0.0), (n, 1.1)]).enumerate()
    {
        let mut draws = Draws::new(11, cell as u64, Stream::Curve);
        let (mut own, mut written) = (0, 0);
        for _ in 0..runs {
            let count = |_| (20.0 * (log_sd * draws.normal()).exp()).ceil() as usize;
            let counts: Vec<usize> = (0..drivers).map(count).collect();
            let found = drawn(&counts, &mut draws);
            let [low, high] = found.estimated.exponent_clustered_ci95.unwrap();
            own += usize::from(low <= EXPONENT && EXPONENT <= high);
            let model = found.population(None, &field_truck_model().driver.curve_speed);
            let reach = 1.96 * model.exponent_standard_error;
            written += usize::from((model.exponent - EXPONENT).abs() <= reach);
        }
        let what = format!("{drivers} drivers, log-SD {log_sd}");
        assert_covers(&what, own, runs);
        assert_eq!(own, written, "{what}");
        covered += own;
        cells += runs;
    }
    assert_covers("all", covered, cells);
}

#[test]
fn a_driver_who_alone_tells_the_exponent_is_no_sample_of_drivers() {
    let mut counts = vec![1; 13];
    counts[4] = 300;
    let found = drawn(&counts, &mut Draws::new(3, 0, Stream::Curve));
    let mixed = found.random_intercept.unwrap();
    let error = found.estimated.exponent_clustered_standard_error.unwrap();
    assert_eq!(error, mixed.exponent_standard_error);
    // 0.177 over the spread of ln R (0.6) and the root of 300, and the singles that say little
    assert!((0.7..1.05).contains(&(error / (0.177 / 0.6 / 300_f64.sqrt()))), "{error}");
    let message = "fewer than three drivers";
    assert!(found.warnings.iter().any(|text| text.contains(message)), "{:?}", found.warnings);
}

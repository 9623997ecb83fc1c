//! The clustered standard error of the curve-speed exponent beside another implementation.
//!
//! Reference values: statsmodels 0.15.0,
//! `sm.OLS(y, X).fit(cov_type="cluster", cov_kwds={"groups": driver})` with y = ln v and the
//! columns of X: 1, ln(R/250), sum-to-zero contrasts of the drivers, and ±1 for left and right. Its
//! correction for a small sample, `use_correction=True`, is the default: G/(G − 1) (n − 1)/(n − p),
//! which is 2.0625 for twelve curves, three drivers and four columns.

use ocmc_estimation::fit::curve_speed::{CurveSpeedOptions, CurveTable, fit};

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
fn the_sandwich_of_drivers_is_that_of_statsmodels() {
    let table = CurveTable {
        driver: CURVES.iter().map(|curve| curve.0.to_owned()).collect(),
        radius_m: CURVES.iter().map(|curve| curve.1).collect(),
        speed_mps: CURVES.iter().map(|curve| curve.2).collect(),
        left: Some(CURVES.iter().map(|curve| curve.3).collect()),
        ..CurveTable::default()
    };
    let fitted = fit(&table, &CurveSpeedOptions::default()).unwrap();
    let with_direction = fitted.with_direction.unwrap();
    for (estimate, exponent, independent, clustered) in [
        (&fitted.estimated, 0.3826178236179034, 0.015954881223956805, 0.011884710407262605),
        (&with_direction, 0.3927264112344083, 0.01482167338691097, 0.026007123998299728),
    ] {
        let found = [
            estimate.exponent,
            estimate.exponent_standard_error.unwrap(),
            estimate.exponent_clustered_standard_error.unwrap(),
        ];
        for (found, wanted) in found.into_iter().zip([exponent, independent, clustered]) {
            assert!((found / wanted - 1.0).abs() < 1e-9, "{found} {wanted}");
        }
        // Student's t with two degrees of freedom, one less than drivers: 4.302652729911275
        let [low, high] = estimate.exponent_clustered_ci95.unwrap();
        let reach = 4.302652729911275 * clustered;
        assert!((high - low - 2.0 * reach).abs() < 1e-9 * reach, "{low} {high} {reach}");
    }
}

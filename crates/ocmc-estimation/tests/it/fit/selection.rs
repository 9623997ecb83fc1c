//! Selection of the curves for the regression of curve speeds.

use ocmc_estimation::fit::curve_speed::{CurveSpeedFitError, CurveSpeedOptions, CurveTable, fit};

/// Driver, radius in m, speed in m/s: the third turns with 0.25, the last with 0.4 m/s².
const CURVES: [(&str, f64, f64); 7] = [
    ("a", 30.0, 7.5),
    ("a", 120.0, 12.5),
    ("a", 25.0, 2.5),
    ("a", 400.0, 19.0),
    ("b", 45.0, 8.0),
    ("b", 300.0, 17.0),
    ("b", 40.0, 4.0),
];

fn table(curves: &[(&str, f64, f64)]) -> CurveTable {
    CurveTable {
        driver: curves.iter().map(|curve| curve.0.to_owned()).collect(),
        radius_m: curves.iter().map(|curve| curve.1).collect(),
        speed_mps: curves.iter().map(|curve| curve.2).collect(),
        ..CurveTable::default()
    }
}

#[test]
fn slow_turns_are_left_out_where_it_is_asked_for() {
    let options = |least_lateral_mps2| CurveSpeedOptions {
        least_lateral_mps2,
        ..CurveSpeedOptions::default()
    };
    let all = fit(&table(&CURVES), &options(0.0)).unwrap();
    assert!(all.n == 7 && all.dropped.is_empty(), "{:?}", all.dropped);
    // a curve at the bound takes part
    let fast = fit(&table(&CURVES), &options(0.4)).unwrap();
    let reason = "lateral_acceleration_too_small";
    assert_eq!(fast.dropped.iter().collect::<Vec<_>>(), [(&reason, &1)]);
    let without: Vec<_> = CURVES.iter().copied().filter(|curve| curve.1 != 25.0).collect();
    assert_eq!(fast.estimated, fit(&table(&without), &options(0.0)).unwrap().estimated);
    assert!(fast.estimated.residual_sd < all.estimated.residual_sd);
    for wrong in [-0.1, f64::NAN] {
        let found = fit(&table(&CURVES), &options(wrong));
        assert!(matches!(found, Err(CurveSpeedFitError::Option(_))), "{found:?}");
    }
}

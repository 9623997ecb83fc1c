//! The paper's field tables from drawn sets with their moments: 25 trucks, 49,310 curves, three
//! seeds.
//!
//! What is made: counts that are small for trucks far from the mean, so that both SS 60.1 and SD(α)
//! 5.6 % come out; radii whose truck means go with the effects, so that a fixed exponent moves v₀
//! and SD(α) as printed; directions whose radii differ, so that β moves; a residual without a share
//! in any column, of the printed sum of squares. What is tested: all that follows from these by the
//! fit.

use super::assert_prints;
use ocmc_core::random::{Draws, Stream};
use ocmc_estimation::fit::curve_speed::{CurveSpeedOptions, CurveTable, fit};
use ocmc_estimation::fit::least_squares::LeastSquares;

const TRUCKS: usize = 25;
const CURVES: usize = 49_310;

/// Printed values, chosen within their rounding so that they fit together.
const EXPONENT: f64 = 0.46;
const REFERENCE_KMH: f64 = 54.5;
const TRUCK_SD: f64 = 0.056;
const DIRECTION: f64 = 0.002;
const RADIUS_SUM_SQ: f64 = 9867.8;
const TRUCK_SUM_SQ: f64 = 60.14;
const RESIDUAL_SUM_SQ: f64 = 1540.1;

struct Set {
    truck: Vec<usize>,
    /// ln R - ln 250 m
    x: Vec<f64>,
    left: Vec<bool>,
    /// ln v without residual
    y: Vec<f64>,
}

/// Sequential sums of squares of radius and trucks of a set without residual.
fn sums(set: &Set) -> (f64, f64) {
    let fit = reduce(set, &set.y);
    (fit.sequential_sum_sq(1), (2..=TRUCKS).map(|j| fit.sequential_sum_sq(j)).sum())
}

fn reduce(set: &Set, y: &[f64]) -> LeastSquares {
    LeastSquares::reduce(CURVES, TRUCKS + 2, |k, row| {
        row.fill(0.0);
        (row[0], row[1]) = (1.0, set.x[k]);
        if set.truck[k] > 0 {
            row[1 + set.truck[k]] = 1.0;
        }
        row[TRUCKS + 1] = if set.left[k] { 1.0 } else { -1.0 };
        y[k]
    })
    .unwrap()
}

/// Numbers with mean 0 and sample SD 1.
fn standardised(mut values: Vec<f64>) -> Vec<f64> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let sd = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    for value in &mut values {
        *value = (*value - mean) / sd;
    }
    values
}

/// A set in which a truck with effect α has exp(−shrink (α/SD)²) times as many curves, and radii
/// spread by `spread`.
fn set(seed: u64, shrink: f64, spread: f64) -> Set {
    let mut draws = Draws::new(seed, 0, Stream::Vehicle);
    let effects = standardised((0..TRUCKS).map(|_| draws.normal()).collect());
    let effects: Vec<f64> = effects.iter().map(|e| TRUCK_SD * e).collect();
    let weights: Vec<f64> =
        effects.iter().map(|e| (-shrink * (e / TRUCK_SD).powi(2)).exp()).collect();
    let total: f64 = weights.iter().sum();
    let mut counts: Vec<usize> = weights
        .iter()
        .map(|w| (40.0 + (CURVES - 40 * TRUCKS) as f64 * w / total) as usize)
        .collect();
    let largest = (0..TRUCKS).max_by_key(|&t| counts[t]).unwrap();
    counts[largest] += CURVES - counts.iter().sum::<usize>();
    // unweighted mean of the trucks' ln R, which moves v0 from 54.5 to 56.2 km/h when the exponent
    // is fixed
    let centre = -(56.2f64 / 54.5).ln() / 0.04;
    // the trucks' own means go with their effects: 5.6 % become 4.5 %
    let slope = (TRUCK_SD - 0.045) / (0.04 * TRUCK_SD);
    let mut set = Set { truck: vec![], x: vec![], left: vec![], y: vec![] };
    for (truck, &count) in counts.iter().enumerate() {
        // within a truck: mean 0, so that its mean is what was chosen
        let within = standardised((0..count).map(|_| draws.normal()).collect());
        for (k, deviation) in within.into_iter().enumerate() {
            let left = k % 2 == 0;
            let side = if left { -0.026 } else { 0.026 };
            let x = centre + slope * effects[truck] + side + spread * deviation;
            let y = (REFERENCE_KMH / 3.6).ln()
                + EXPONENT * x
                + effects[truck]
                + if left { DIRECTION } else { -DIRECTION };
            set.truck.push(truck);
            set.x.push(x);
            set.left.push(left);
            set.y.push(y);
        }
    }
    set
}

/// The parameter at which a smooth function has a value, by the secant through two guesses.
fn solve(mut a: f64, mut b: f64, wanted: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut at_a, mut at_b) = (f(a) - wanted, f(b) - wanted);
    while at_b.abs() > 1e-4 * wanted {
        (a, b) = (b, b - at_b * (b - a) / (at_b - at_a));
        (at_a, at_b) = (at_b, f(b) - wanted);
    }
    b
}

fn table(seed: u64) -> CurveTable {
    let mut spread = 0.97;
    let mut shrink = 0.0;
    for _ in 0..2 {
        shrink = solve(0.4, 0.5, TRUCK_SUM_SQ, |shrink| sums(&set(seed, shrink, spread)).1);
        spread = solve(0.95, 0.97, RADIUS_SUM_SQ, |spread| sums(&set(seed, shrink, spread)).0);
    }
    let mut set = set(seed, shrink, spread);
    // noise without a share in any column, of the printed size
    let mut draws = Draws::new(seed, 1, Stream::Vehicle);
    let noise: Vec<f64> = (0..CURVES).map(|_| draws.normal()).collect();
    let fit = reduce(&set, &noise);
    let (b, scale) = (fit.coefficients(), (RESIDUAL_SUM_SQ / fit.residual_sum_sq).sqrt());
    for k in 0..CURVES {
        let truck = if set.truck[k] > 0 { b[1 + set.truck[k]] } else { 0.0 };
        let side = if set.left[k] { b[TRUCKS + 1] } else { -b[TRUCKS + 1] };
        set.y[k] += scale * (noise[k] - b[0] - b[1] * set.x[k] - truck - side);
    }
    CurveTable {
        driver: set.truck.iter().map(|truck| format!("truck {truck}")).collect(),
        radius_m: set.x.iter().map(|x| 250.0 * x.exp()).collect(),
        speed_mps: set.y.iter().map(|y| y.exp()).collect(),
        left: Some(set.left),
        ..CurveTable::default()
    }
}

/// The radii of the drawn sets are normal in ln R and reach beyond 20 to 500 m; all belong to the
/// set.
fn options() -> CurveSpeedOptions {
    CurveSpeedOptions { radius_range_m: [0.0, f64::INFINITY], ..CurveSpeedOptions::default() }
}

#[test]
fn tables_of_the_field_data() {
    for seed in 1..=3 {
        let fit = fit(&table(seed), &options()).unwrap();
        assert_eq!((fit.n, fit.drivers), (CURVES, TRUCKS));
        let [radius, truck, direction, residuals] = fit.anova.as_slice() else {
            panic!("four rows")
        };
        assert_eq!((radius.df, truck.df, direction.df, residuals.df), (1, 24, 1, 49_283));
        assert_prints("radius", radius.sum_sq, "9867.8");
        assert_prints("radius", radius.mean_sq, "9867.8");
        assert_eq!(format!("{:.2e}", radius.f.unwrap()), "3.16e5");
        assert_prints("truck", truck.sum_sq, "60.1");
        assert_prints("truck", truck.mean_sq, "2.5");
        assert_prints("truck", truck.f.unwrap(), "80.2");
        assert_prints("direction", direction.sum_sq, "0.2");
        assert!((direction.f.unwrap() - 6.27).abs() < 0.1, "{direction:?}");
        assert!((direction.p.unwrap() - 0.0123).abs() < 0.001, "{direction:?}");
        assert_prints("residuals", residuals.sum_sq, "1540.1");
        assert_eq!(format!("{:.3}", 10.0 * residuals.mean_sq), "0.313");
        // far below the smallest number: ln p = -(df/2) ln(1 + F/df) and a little more
        assert_eq!(radius.p, Some(0.0));
        let leading = -0.5 * 49_283.0 * (radius.f.unwrap() / 49_283.0).ln_1p();
        assert!((radius.ln_p.unwrap() / leading - 1.0).abs() < 1e-3, "{:?}", radius.ln_p);

        let estimated = &fit.estimated;
        assert_prints("exponent", estimated.exponent, "0.460");
        let [low, high] = estimated.exponent_ci95.unwrap();
        assert_prints("low", low, "0.458");
        assert_prints("high", high, "0.462");
        assert_prints("v0", 3.6 * estimated.reference_speed_mps, "54.5");
        assert_prints("trucks", 100.0 * estimated.driver_sd.unwrap(), "5.6");
        assert_prints("direction", 100.0 * estimated.direction_effect.unwrap(), "0.2");
        assert_prints("residual", 100.0 * estimated.residual_sd, "17.7");
        // the paper's own numbers: 9 % between trucks; its SS 60.1 is a curve-weighted SD of 3.5 %
        assert_prints("share", 100.0 * estimated.driver_share.unwrap(), "9");
        let weighted = estimated.driver_sd_weighted.unwrap();
        assert!((weighted - (60.1f64 / 49_310.0).sqrt()).abs() < 0.001, "{weighted}");

        let fixed = &fit.fixed;
        assert_prints("v0", 3.6 * fixed.reference_speed_mps, "56.2");
        assert_prints("trucks", 100.0 * fixed.driver_sd.unwrap(), "4.5");
        assert_prints("direction", 100.0 * fixed.direction_effect.unwrap(), "0.3");
        assert_prints("residual", 100.0 * fixed.residual_sd, "18.1");
    }
}

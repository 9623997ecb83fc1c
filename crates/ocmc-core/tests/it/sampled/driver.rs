//! Speed changes and compliance of the drivers, and the spread of the trucks.

use super::cycles;
use crate::common::statistics::{SEEDS, assert_follows, assert_mean};
use crate::common::{field_truck, field_truck_model};
use statrs::distribution::{ContinuousCDF, LogNormal, Normal};

/// Distribution function of a log-normal law by its median.
fn log_normal(median: f64, log_sd: f64) -> impl Fn(f64) -> f64 {
    let law = LogNormal::new(median.ln(), log_sd).unwrap();
    move |x| law.cdf(x)
}

#[test]
fn accelerations_are_log_normal_and_independent() {
    let model = field_truck_model().driver.speed_change;
    for seed in SEEDS {
        let drawn: Vec<_> = cycles(seed).map(|s| model.sample(&s, true)).collect();
        let down = drawn.iter().map(|d| d.deceleration_mps2).collect();
        let up = drawn.iter().map(|d| d.acceleration_mps2).collect();
        assert_follows("deceleration", down, log_normal(0.6, 0.25));
        assert_follows("acceleration", up, log_normal(0.5, 0.25));
        let products: Vec<f64> = drawn
            .iter()
            .map(|d| (d.deceleration_mps2 / 0.6).ln() * (d.acceleration_mps2 / 0.5).ln())
            .collect();
        assert_mean("both", &products, 0.0);
        assert!(drawn.iter().all(|d| d.launch_speed_mps == 2.0));
    }
}

#[test]
fn compliance_is_truncated_and_comfort_at_bumps_log_normal() {
    let model = field_truck_model().driver.speed_limit;
    let law = Normal::new(1.0, 0.03).unwrap();
    let (a, b) = (law.cdf(0.92), law.cdf(1.05));
    for seed in SEEDS {
        let drawn: Vec<_> = cycles(seed).map(|s| model.sample(&s, true)).collect();
        let compliance = drawn.iter().map(|d| d.compliance).collect();
        assert_follows("compliance", compliance, |x| (law.cdf(x) - a) / (b - a));
        let comfort = drawn.iter().map(|d| d.bump_acceleration_mps2).collect();
        assert_follows("comfort", comfort, log_normal(2.0, 0.15));
    }
}

#[test]
fn residuals_of_curves_are_standard_normal_and_independent() {
    let study = field_truck(|_| ());
    let law = Normal::new(0.0, 1.0).unwrap();
    for seed in SEEDS {
        let (mut residuals, mut products) = (Vec::new(), Vec::new());
        for cycle_id in 0..300 {
            let scenario = study.sample(seed, cycle_id);
            assert_eq!(scenario.curve_residuals.len(), scenario.cycle.road.curves.len());
            products.extend(scenario.curve_residuals.windows(2).map(|pair| pair[0] * pair[1]));
            residuals.extend(scenario.curve_residuals);
        }
        assert_follows("residual", residuals, |z| law.cdf(z));
        assert_mean("neighbours", &products, 0.0);
    }
}

#[test]
fn trucks_differ_as_the_vehicle_file_says() {
    let model = field_truck_model().vehicle;
    let typical = model.clone();
    for seed in SEEDS {
        let drawn: Vec<_> = cycles(seed).map(|s| model.sample(10_000.0, &s, &[])).collect();
        assert!(drawn.iter().all(|v| v.mass_kg == typical.curb_mass_kg + 10_000.0));
        let column = |value: fn(&ocmc_core::vehicle::Vehicle) -> f64| -> Vec<f64> {
            drawn.iter().map(value).collect()
        };
        assert_follows("drag area", column(|v| v.drag_area_m2), log_normal(5.3, 0.04));
        assert_follows("auxiliaries", column(|v| v.auxiliary_power_w), log_normal(4700.0, 0.1));
        let fuel = Normal::new(1.0, 0.01).unwrap();
        assert_follows("fuel factor", column(|v| v.fuel_factor), |x| fuel.cdf(x));
        let streams = cycles(seed).next().unwrap();
        let centre =
            model.sample(10_000.0, &streams, &[ocmc_core::switch::ModelSwitch::VehicleSpread]);
        let base = centre.rolling_coefficient;
        let factor = column(|v| v.rolling_coefficient).iter().map(|c| c / base).collect();
        assert_follows("rolling factor", factor, log_normal(1.0, 0.05));
    }
}

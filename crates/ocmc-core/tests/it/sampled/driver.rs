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
        assert_follows("deceleration", down, log_normal(0.85, 0.25));
        assert_follows("acceleration", up, log_normal(0.8, 0.2));
        let products: Vec<f64> = drawn
            .iter()
            .map(|d| (d.deceleration_mps2 / 0.85).ln() * (d.acceleration_mps2 / 0.8).ln())
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
        let drawn: Vec<_> = cycles(seed).map(|s| model.sample(&s, true, f64::INFINITY)).collect();
        let compliance = drawn.iter().map(|d| d.compliance).collect();
        assert_follows("compliance", compliance, |x| (law.cdf(x) - a) / (b - a));
        let comfort = drawn.iter().map(|d| d.bump_acceleration_mps2).collect();
        assert_follows("comfort", comfort, log_normal(2.0, 0.15));
    }
}

#[test]
fn a_proportional_gain_outside_its_bounds_is_drawn_again_and_not_clipped() {
    // bounds that a third of the draws miss; the smaller of the two upper bounds holds
    let mut model = field_truck_model().driver.pedals;
    model.pid_share = 1.0;
    (model.pid.proportional_median, model.pid.proportional_log_sd) = (0.5, 0.4);
    (model.pid.proportional_minimum, model.pid.proportional_maximum) = (0.35, 0.8);
    model.pid.correlation = [0.3, 0.0, -0.2];
    let [median_s, log_sd] = [model.pid.integral_time_median_s, model.pid.integral_time_log_sd];
    let law = log_normal(0.5, 0.4);
    for (maximum, stability_limit) in [(0.8, f64::INFINITY), (0.7, 0.7)] {
        let (a, b) = (law(0.35), law(maximum));
        for seed in SEEDS {
            let drawn: Vec<_> =
                cycles(seed).map(|s| model.sample(&s, true, stability_limit)).collect();
            let gains: Vec<f64> = drawn.iter().map(|pedals| pedals.proportional).collect();
            assert_follows("K_P", gains, |x| ((law(x) - a) / (b - a)).clamp(0.0, 1.0));
            // the whole driver is drawn again: ln T_i given ln K_P keeps its mean and variance
            let rest: Vec<f64> = drawn
                .iter()
                .map(|pedals| {
                    let z = (pedals.proportional / 0.5).ln() / 0.4;
                    let time_s = pedals.proportional / pedals.integral;
                    ((time_s / median_s).ln() / log_sd - 0.3 * z) / (1.0f64 - 0.09).sqrt()
                })
                .collect();
            let normal = Normal::new(0.0, 1.0).unwrap();
            assert_follows("T_i beside K_P", rest, |z| normal.cdf(z));
            // the number of draws before one that fits is geometric
            let redraws: Vec<f64> = drawn.iter().map(|pedals| f64::from(pedals.redraws)).collect();
            assert_mean("redraws", &redraws, 1.0 / (b - a) - 1.0);
        }
    }
}

#[test]
fn rolling_resistance_is_that_of_the_loaded_truck() {
    // VECTO user manual: an axle with the share s of the weight has RRC (s m g / (tyres F))^(beta -
    // 1), m with the payload
    let mut model = field_truck_model().vehicle;
    model.curb_mass_kg = 15_700.0;
    model.rolling_load_exponent = 0.9;
    model.axles.truncate(2);
    for (axle, load_share, coefficient, load_n, tyres) in
        [(0, 0.3, 0.0055, 33_350.0, 2.0), (1, 0.7, 0.0065, 37_500.0, 6.0)]
    {
        let axle = &mut model.axles[axle];
        (axle.load_share, axle.iso_rolling_coefficient) = (load_share, coefficient);
        axle.empty_load_share = None;
        (axle.iso_load_n, axle.tyres) = (load_n, tyres);
    }
    let streams = cycles(1).next().unwrap();
    let typical = [ocmc_core::switch::ModelSwitch::VehicleSpread];
    // 0.3 x 0.0055 (0.3 m g / 66700)^-0.1 + 0.7 x 0.0065 (0.7 m g / 225000)^-0.1
    for (payload_kg, wanted) in
        [(0.0, 0.006609296), (10_000.0, 0.006291466), (24_300.0, 0.006019205)]
    {
        let found = model.sample(payload_kg, &streams, &typical).rolling_coefficient;
        assert!((found / wanted - 1.0).abs() < 1e-6, "{payload_kg} kg: {found}");
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
        assert_follows("auxiliaries", column(|v| v.auxiliary_power_w), log_normal(4443.0, 0.1));
        let fuel = Normal::new(1.0, 0.01).unwrap();
        assert_follows("fuel factor", column(|v| v.map_factor), |x| fuel.cdf(x));
        let streams = cycles(seed).next().unwrap();
        let centre =
            model.sample(10_000.0, &streams, &[ocmc_core::switch::ModelSwitch::VehicleSpread]);
        let base = centre.rolling_coefficient;
        let factor = column(|v| v.rolling_coefficient).iter().map(|c| c / base).collect();
        assert_follows("rolling factor", factor, log_normal(1.0, 0.05));
    }
}

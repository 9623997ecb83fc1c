//! The battery-electric truck in the exact prescribed-speed mode: consumption, the limits of what
//! comes back, and the balance.

use crate::common::electric_balance;
use crate::others_data::shared;
use ocmc_core::energy::Carrier;
use ocmc_core::energy::ledger::Term;
use ocmc_core::kernel::drive::scheduler::drive_scenario;
use ocmc_core::prescribed::{DriveCycle, FollowedCycle, follow_planned, follow_study};
use ocmc_core::record::{Outcome, Record};
use ocmc_core::study::Study;
use ocmc_io::given_cycle::RouteOptions;
use ocmc_io::study::load;

const CASE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/cases/battery.toml");

fn study(sets: &[&str]) -> Study {
    load(CASE, sets).unwrap().study
}

/// A road of 2 km up and 2 km down at one speed, from rest to rest.
fn hill(slope: f64, speed_mps: f64) -> DriveCycle {
    let (mut time, mut speed, mut grade) = (vec![0.0], vec![0.0], vec![0.0]);
    let mut way_m = 0.0;
    let mut push = |now: f64, slope: f64| {
        time.push(time[time.len() - 1] + 1.0);
        speed.push(now);
        grade.push(slope);
    };
    let ramp = 40;
    for k in 1..=ramp {
        push(speed_mps * f64::from(k) / f64::from(ramp), 0.0);
    }
    while way_m < 4000.0 {
        push(speed_mps, if way_m < 2000.0 { slope } else { -slope });
        way_m += speed_mps;
    }
    for k in (0..ramp).rev() {
        push(speed_mps * f64::from(k) / f64::from(ramp), 0.0);
    }
    DriveCycle::new(time, speed, grade).unwrap()
}

/// Energy that leaves the store less all its uses, over what leaves it.
fn open_share(record: &Record, sum: &FollowedCycle) -> f64 {
    let store_j = record.amount(Carrier::Electricity).unwrap();
    let spent = record.battery_loss_j.unwrap()
        + record.motor_loss_j.unwrap()
        + record.auxiliary_energy_j
        + record.transmission_loss_j
        + record.drag_energy_j
        + record.rolling_energy_j
        + record.potential_change_j
        + record.kinetic_change_j
        + record.service_brake_energy_j
        - sum.ledger[Term::Missing];
    (store_j - spent) / store_j
}

#[test]
fn forty_tonnes_on_long_haul_between_1_1_and_1_5_kwh_per_km() {
    let Some(file) = shared("vecto/cycles/LongHaul.vdri") else { return };
    let loaded = load(CASE, &[] as &[&str]).unwrap();
    let given = loaded.on_routes(&[file], &[], RouteOptions::default()).unwrap();
    let (record, sum) = follow_planned(&given.study, 1, 0);
    let kwh = record.consumption(Carrier::Electricity).unwrap();
    println!(
        "LongHaul 40 t: {kwh:.3} kWh/km, wheel {:.3}, back {:.3} kWh/km, charge {:.2} at the end, \
         {:.0} s at the limit",
        record.wheel_kwh_per_km,
        record.regenerated_energy_j.unwrap() / record.distance_m / 3600.0,
        record.final_charge.unwrap(),
        sum.ledger[Term::Limited]
    );
    assert!((1.1..=1.5).contains(&kwh), "{kwh}");
    assert_eq!(record.outcome, Outcome::Completed);
    assert!(open_share(&record, &sum).abs() < 1e-9, "{}", open_share(&record, &sum));
    assert!(record.amount(Carrier::LiquidFuel).is_none() && record.co2_g_per_km.is_none());
}

#[test]
fn a_driver_takes_the_same_truck_over_long_haul() {
    let Some(file) = shared("vecto/cycles/LongHaul.vdri") else { return };
    for area_m2 in ["5.0", "5.3", "5.8"] {
        let drag = format!("vehicle.drag_area_m2={area_m2}");
        let given = load(CASE, &[drag])
            .unwrap()
            .on_routes(std::slice::from_ref(&file), &[], RouteOptions::default())
            .unwrap();
        let driven = drive_scenario(&given.study, given.study.sample(1, 0));
        let followed = follow_planned(&given.study, 1, 0).0;
        let kwh = |record: &Record| record.consumption(Carrier::Electricity).unwrap();
        println!(
            "LongHaul 40 t, CdA {area_m2} m²: {:.3} kWh/km driven at {:.1} km/h, {:.3} followed at \
             {:.1} km/h, {:.3} brought back, {} shifts",
            kwh(&driven),
            3.6 * driven.mean_speed_mps,
            kwh(&followed),
            3.6 * followed.mean_speed_mps,
            driven.regenerated_energy_j.unwrap() / driven.distance_m / 3600.0,
            driven.n_gear_shifts
        );
        assert_eq!(driven.outcome, Outcome::Completed);
        assert!(electric_balance(&driven).abs() < 1e-9);
        // the named assumptions: the drag area of the diesel tractor
        if area_m2 == "5.3" {
            assert!((1.1..=1.5).contains(&kwh(&driven)), "{}", kwh(&driven));
        }
    }
}

#[test]
fn up_and_down_is_never_below_flat() {
    let study = study(&[]);
    let flat = follow_study(&study, 1, 0, &hill(0.0, 20.0)).0;
    let mut before = flat.amount(Carrier::Electricity).unwrap();
    for slope in [0.005, 0.01, 0.02, 0.03, 0.04] {
        let (record, sum) = follow_study(&study, 1, 0, &hill(slope, 20.0));
        let store = record.amount(Carrier::Electricity).unwrap();
        assert!(store >= before * (1.0 - 1e-9), "{slope}: {store} {before}");
        assert!(open_share(&record, &sum).abs() < 1e-9);
        before = store;
    }
}

#[test]
fn what_comes_back_is_limited_by_power_and_by_a_full_battery() {
    let steep = hill(0.05, 20.0);
    let back = |sets: &[&str]| {
        let (record, sum) = follow_study(&study(sets), 1, 0, &steep);
        assert!(open_share(&record, &sum).abs() < 1e-9);
        (record.regenerated_energy_j.unwrap(), record.service_brake_energy_j)
    };
    let (free, little) = back(&[]);
    let (half, more) = back(&["vehicle.powertrain.battery_electric.motor.brake_power_w=100e3"]);
    let (weak, most) = back(&["vehicle.powertrain.battery_electric.battery.charge_power_w=50e3"]);
    assert!(free > half && half > weak, "{free} {half} {weak}");
    assert!(little < more && more < most);
    // at most 145 s of braking at the charge limit, with what the auxiliaries take on the way
    assert!(weak <= (50e3 + 4e3) * 145.0, "{weak}");
    // a battery that is full on the top takes nothing, and the service brakes do it all; the climb
    // comes after in this cycle
    let down =
        DriveCycle::new((0..100).map(f64::from).collect(), vec![20.0; 100], vec![-0.05; 100])
            .unwrap();
    let full = study(&["vehicle.powertrain.battery_electric.battery.initial_charge=0.9"]);
    let record = follow_study(&full, 1, 0, &down).0;
    // what the auxiliaries draw makes a little room
    let back_j = record.regenerated_energy_j.unwrap();
    assert!(back_j < 0.02 * record.service_brake_energy_j, "{record:?}");
    assert!(record.final_charge.unwrap() <= 0.9 && record.service_brake_energy_j > 0.0);
}

#[test]
fn an_empty_battery_is_an_outcome() {
    let empty = study(&["vehicle.powertrain.battery_electric.battery.initial_charge=0.1005"]);
    let (record, sum) = follow_study(&empty, 1, 0, &hill(0.03, 20.0));
    assert_eq!(record.outcome, Outcome::Depleted);
    assert!(sum.ledger[Term::Missing] > 0.0);
}

#[test]
fn cold_air_costs_and_no_corner_breaks() {
    let cold = study(&["weather.temperature.mean_k=253.15"]);
    let a = follow_study(&study(&[]), 1, 0, &hill(0.0, 20.0)).0.auxiliary_energy_j;
    let b = follow_study(&cold, 1, 0, &hill(0.0, 20.0)).0.auxiliary_energy_j;
    assert!((b / a - (4000.0 + 5000.0) / 4000.0).abs() < 1e-9, "{a} {b}");
    for (speed, slope) in [(69.0, 0.5), (69.0, -0.5), (0.5, 0.5), (0.5, -0.5)] {
        let cycle = DriveCycle::new(
            vec![0.0, 1.0, 2.0, 3.0],
            vec![speed, speed, 0.0, speed],
            vec![slope; 4],
        );
        let (record, sum) = follow_study(&study(&[]), 1, 0, &cycle.unwrap());
        assert!(
            record.amount(Carrier::Electricity).unwrap().is_finite()
                && sum.ledger[Term::Missing].is_finite()
        );
        assert!(record.final_charge.unwrap().is_finite());
    }
}

//! The best that is possible: closed forms, never above a driver, convergence, balance.

use crate::common::{balance, diesel, study, typical};
use crate::program::ocmc;
use ocmc_core::energy::ledger::Term;
use ocmc_core::powertrain::efficiency::{EfficiencyCurve, EfficiencyDriveline};
use ocmc_core::powertrain::{Powertrain, ShiftConvention};
use ocmc_core::prescribed::{Body, follow_scenario};
use ocmc_core::study::Study;
use ocmc_fleet::bound::{Bound, Fineness, TripBound, bound, bound_scenario, bounds, level_road};
use ocmc_fleet::run::RunPlan;
use std::ops::ControlFlow;

const SHORT: &[&str] = &["mission.length_m=15000"];

fn halved() -> Fineness {
    let Fineness { piece_m, speed_mps } = Fineness::default();
    Fineness { piece_m: 0.5 * piece_m, speed_mps: 0.5 * speed_mps }
}

fn body(study: &Study) -> Body {
    Body::of(study, &study.sample(1, 0))
}

/// The typical truck with an engine whose fuel is affine in its power, down to the overrun.
fn affine() -> Study {
    let (heating_jpkg, none_w, per_w) = (42.7e6, 12e3, 2.3);
    let mut sets = vec!["vehicle.powertrain.combustion.engine.fuel_factor=1.0".to_owned()];
    let speeds = [50.0, 100.0, 150.0, 200.0, 250.0];
    let drag = speeds.map(|speed| -none_w / (per_w * speed));
    let torques = [0.0, 1500.0, 3000.0];
    let row = |speed: f64| {
        torques.map(|torque| (none_w + per_w * speed * torque) / heating_jpkg).to_vec()
    };
    let map: Vec<Vec<f64>> = speeds.map(row).to_vec();
    for (key, value) in [
        ("map_speed_radps", format!("{speeds:?}")),
        ("drag_torque_nm", format!("{drag:?}")),
        ("map_torque_nm", format!("{torques:?}")),
        ("map_fuel_kgps", format!("{map:?}")),
        ("fuel.heating_value_jpkg", format!("{heating_jpkg:?}")),
    ] {
        sets.push(format!("vehicle.powertrain.combustion.engine.{key}={value}"));
    }
    typical(&sets.iter().map(String::as_str).collect::<Vec<_>>())
}

#[test]
fn an_engine_whose_fuel_is_affine_in_power_does_best_at_constant_speed() {
    // an engine of constant efficiency behind nothing that shifts: the closed form itself
    let study = typical(&[]);
    let (length_m, speed_mps) = (10e3, 20.0);
    let powertrain = EfficiencyDriveline {
        transmission_efficiency: 0.92,
        engine: EfficiencyCurve {
            rated_power_w: 350e3,
            power_share: vec![0.0, 1.0],
            efficiency: vec![0.4, 0.4],
        },
        auxiliary_power_w: 3e3,
    };
    let body_of = body(&study);
    let fineness = Fineness::default();
    let found = level_road(body_of, &powertrain, length_m, [speed_mps, 25.0], fineness).unwrap();
    let force_n = body_of.road_forces(speed_mps, 0.0).sum_n();
    let closed_j = (force_n / 0.92 + 3e3 / speed_mps) / 0.4 * length_m;
    assert!((found.constant_j / closed_j - 1.0).abs() < 1e-12);
    println!("constant efficiency: {:.6} of the closed form", found.least_j / closed_j);
    assert!((found.least_j / closed_j - 1.0).abs() < 2e-3, "{found:?}");
    assert!(found.time_s <= length_m / speed_mps * (1.0 + 1e-9));

    // the same of a diesel engine behind a gearbox
    let study = affine();
    let truck = study.sample(1, 0).vehicle.powertrain_inputs(0.0);
    let inverse = diesel(&study).inverse(&truck);
    let found = level_road(body(&study), &*inverse, length_m, [speed_mps, 25.0], fineness).unwrap();
    println!("affine fuel: {:.6} of constant speed", found.least_j / found.constant_j);
    assert!((found.least_j / found.constant_j - 1.0).abs() < 2e-3, "{found:?}");
}

#[test]
fn on_a_level_road_the_least_is_never_above_constant_speed() {
    let study = typical(&[]);
    let truck = study.sample(1, 0).vehicle.powertrain_inputs(0.0);
    for speed_mps in [9.0, 14.0, 20.0] {
        let inverse = diesel(&study).inverse(&truck);
        let speeds = [speed_mps, speed_mps + 4.0];
        let found = level_road(body(&study), &*inverse, 8e3, speeds, Fineness::default()).unwrap();
        // pulse and glide may win
        println!("{speed_mps} m/s: {:.4} of constant speed", found.least_j / found.constant_j);
        assert!(found.least_j <= found.constant_j * (1.0 + 1e-4), "{speed_mps}: {found:?}");
        assert!(found.time_s <= 8e3 / speed_mps * (1.0 + 1e-9));
    }
}

#[test]
fn the_bound_is_never_above_a_driver_and_its_balance_closes() {
    for (name, cycles) in [("field-truck", 0..6), ("battery-truck", 0..2)] {
        let study = study(name, SHORT);
        for cycle_id in cycles {
            let scenario = study.sample(1, cycle_id);
            let Bound { driver, optimum, is_better, cycle, .. } =
                bound_scenario(&study, &scenario, Fineness::default()).unwrap();
            assert!(is_better, "{name} {cycle_id}: {driver:?} {optimum:?}");
            assert!(optimum.energy_j < driver.energy_j, "{name} {cycle_id}");
            assert!(optimum.duration_s <= driver.duration_s * (1.0 + 1e-9), "{name} {cycle_id}");
            assert!((optimum.distance_m / driver.distance_m - 1.0).abs() < 1e-9);
            assert!(optimum.missing_j < 1e-3 * optimum.source_j, "{name} {cycle_id}");
            let lost = ShiftConvention::Lost;
            let (record, sum) = follow_scenario(&study, &scenario, &cycle, lost);
            assert_eq!(sum.ledger, optimum.ledger, "driven again it is the same");
            if let Some(crankshaft_j) = record.crankshaft_work_j.filter(|_| name == "field-truck") {
                let open = balance(&record) + sum.ledger[Term::Missing] / crankshaft_j;
                assert!(open.abs() < 1e-9, "{cycle_id}: {open}");
            }
        }
    }
}

#[test]
fn a_grid_twice_as_fine_says_the_same() {
    let study = study("field-truck", SHORT);
    for cycle_id in [0, 4] {
        let [coarse, fine] = [Fineness::default(), halved()]
            .map(|fineness| bound(&study, 1, cycle_id, fineness).unwrap().optimum.energy_j);
        println!("{cycle_id}: {:+.3} %", 100.0 * (fine / coarse - 1.0));
        assert!((fine / coarse - 1.0).abs() < 2e-3, "{cycle_id}: {coarse} {fine}");
    }
}

#[test]
fn threads_change_nothing() {
    let study = study("field-truck", &["mission.length_m=5000"]);
    let of = |found: TripBound| found.unwrap();
    let [one, two] = [1, 2].map(|threads| {
        let plan = RunPlan::new(1, 0, 3, Some(threads), Some(1));
        let go_on = |_| ControlFlow::<()>::Continue(());
        match bounds(&study, &plan, Fineness::default(), &of, go_on) {
            ControlFlow::Continue(found) => found,
            ControlFlow::Break(()) => unreachable!(),
        }
    });
    for ((a, parts), (b, other)) in one.iter().zip(&two) {
        assert_eq!((&a.optimum, &a.driver, parts), (&b.optimum, &b.driver, other));
        let parts = parts.as_ref().unwrap();
        let sum = parts.gears_j + parts.by_kind_j.iter().sum::<f64>() + parts.remainder_j;
        assert!((sum - parts.total_j).abs() < 1e-6 * a.driver.energy_j);
    }
}

#[test]
fn the_command_prints_the_potential_and_writes_the_optimum() {
    let folder = tempfile::tempdir().expect("a directory");
    let file = folder.path().join("least.csv");
    let set = "mission.length_m=3000";
    let arguments = ["bound", "--set", set, "--cycle-id", "1", "--quiet", "--out"];
    let output = ocmc(&arguments).arg(&file).output().expect("it starts");
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for word in ["least", "potential", "gears", "remainder", "by road type"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    let table = std::fs::read_to_string(file).expect("written");
    assert!(table.starts_with("time_s,position_m,speed_mps,grade,gear\n"), "{table}");
    // wrong usage: a file is for one cycle
    ocmc(&["bound", "--cycles", "2", "--out", "a.csv"]).assert().code(2);
}

//! Looking ahead: each switch saves, does what it says where it says it, and nothing is lost.

use crate::common::{GivenRoad, balance, column, diesel, run, study, unassisted};
use ocmc_core::energy::Carrier;
use ocmc_core::kernel::drive::scheduler::drive_scenario;
use ocmc_core::kernel::drive::trace::{Trace, trace_scenario};
use ocmc_core::record::{Outcome, Record};
use ocmc_core::study::Study;

const SWITCHES: [&str; 4] = ["coasting", "eco_roll", "predictive_cruise", "engine_stop"];

fn setting(switch: &str) -> String {
    format!("driver.look_ahead.{switch}=true")
}

/// The typical truck with one switch on.
fn with(switch: &str) -> Study {
    unassisted(&[&setting(switch)])
}

fn fuel_kg(study: &Study, road: &GivenRoad) -> f64 {
    let record = drive_scenario(study, road.scenario(study));
    assert_eq!(record.outcome, Outcome::Completed);
    record.amount(Carrier::LiquidFuel).unwrap()
}

fn traced(study: &Study, road: &GivenRoad) -> Trace {
    trace_scenario(study, road.scenario(study))
}

#[test]
fn each_switch_saves_on_the_default_fleet_and_energies_balance() {
    let cycles = 60;
    let off = SWITCHES.map(|switch| format!("driver.look_ahead.{switch}=false"));
    let off: Vec<&str> = off.iter().map(String::as_str).collect();
    let without = run(&study("field-truck", &off), cycles);
    for switch in SWITCHES {
        let on = setting(switch);
        let sets = [&off[..], &[on.as_str()]].concat();
        let with: Vec<Record> = run(&study("field-truck", &sets), cycles);
        let differences: Vec<f64> = with
            .iter()
            .zip(&without)
            .map(|(a, b)| {
                a.amount(Carrier::LiquidFuel).unwrap() / b.amount(Carrier::LiquidFuel).unwrap()
                    - 1.0
            })
            .collect();
        let n = differences.len() as f64;
        let mean = differences.iter().sum::<f64>() / n;
        let squares = differences.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>();
        let error = (squares / (n - 1.0) / n).sqrt();
        println!("{switch}: {:+.2} ± {:.2} %", 100.0 * mean, 196.0 * error);
        assert!(mean + 3.0 * error < 0.0, "{switch}: {mean} {error}");
        assert!(mean > -0.05, "{switch}: {mean}");
        for record in &with {
            assert!(balance(record).abs() < 1e-9, "{switch} {}", record.cycle_id);
            assert_eq!(record.outcome, Outcome::Completed, "{switch} {}", record.cycle_id);
        }
    }
}

#[test]
fn a_truck_coasts_to_a_stop() {
    let road = GivenRoad::flat(4000.0, 22.0).stop(3000.0, 10.0);
    let coasted_m = |study: &Study| {
        let trace = traced(study, &road);
        let [position, accelerator, brake, way] =
            ["position_m", "accelerator", "brake", "distance_added_m"].map(|n| column(&trace, n));
        let before = |k: &usize| position[*k] > 1500.0 && position[*k] < 3000.0;
        let rows = (0..position.len()).filter(before);
        rows.filter(|&k| accelerator[k] == 0.0 && brake[k] == 0.0).map(|k| way[k]).sum::<f64>()
    };
    let (without, with) = (unassisted(&[]), with("coasting"));
    let (less_m, more_m) = (coasted_m(&without), coasted_m(&with));
    assert!(more_m > less_m + 200.0, "{less_m} {more_m}");
    assert!(fuel_kg(&with, &road) < fuel_kg(&without, &road));
    // not from farther than it is seen, 36 s
    assert!(more_m < 800.0, "{more_m}");
}

#[test]
fn the_clutch_opens_only_where_gravity_keeps_the_speed() {
    let road = |slope: f64| {
        // level, a descent of 3 km, level
        let slopes = [vec![0.0; 80], vec![slope; 120], vec![0.0; 1]].concat();
        GivenRoad { slopes, ..GivenRoad::flat(7000.0, 22.0) }
    };
    let (without, with) = (unassisted(&[]), with("eco_roll"));
    for (slope, opens) in [(0.0, false), (-0.006, false), (-0.0125, true)] {
        let trace = traced(&with, &road(slope));
        let [position, closed, accelerator, engine, speed] =
            ["position_m", "clutch_closed", "accelerator", "engine_speed_radps", "speed_mps"]
                .map(|n| column(&trace, n));
        let open: Vec<usize> = (1..speed.len())
            .filter(|&k| closed[k] == 0.0 && speed[k] > 14.0 && speed[k - 1] > 14.0)
            .collect();
        assert_eq!(open.len() > 20, opens, "{slope}: {} rows", open.len());
        for k in open {
            assert!(accelerator[k] == 0.0 && (engine[k] - 62.83).abs() < 1e-9, "{slope} {k}");
            assert!(position[k] > 1990.0 && position[k] < 5800.0, "{slope} {}", position[k]);
        }
        let saved = fuel_kg(&without, &road(slope)) - fuel_kg(&with, &road(slope));
        assert_eq!(saved > 0.01, opens, "{slope}: {saved} kg");
    }
}

#[test]
fn a_crest_is_passed_so_slowly_that_the_descent_gives_the_speed_back() {
    let road = |slope: f64| {
        let slopes = [vec![0.0; 120], vec![slope; 48], vec![0.0; 1]].concat();
        GivenRoad { slopes, ..GivenRoad::flat(7000.0, 22.0) }
    };
    let (without, with) = (unassisted(&[]), with("predictive_cruise"));
    let at_crest = |study: &Study, slope: f64| {
        let trace = traced(study, &road(slope));
        let [position, speed] = ["position_m", "speed_mps"].map(|n| column(&trace, n));
        speed[position.partition_point(|x| *x < 3000.0)]
    };
    for (slope, slower) in [(-0.04, true), (-0.011, false)] {
        let below_mps = at_crest(&without, slope) - at_crest(&with, slope);
        // 1.4 m/s is the edge of the band
        assert_eq!(below_mps > 0.7, slower, "{slope}: {below_mps}");
        assert!(below_mps < 1.6, "{slope}: {below_mps}");
        let saved = fuel_kg(&without, &road(slope)) - fuel_kg(&with, &road(slope));
        assert_eq!(saved > 0.01, slower, "{slope}: {saved} kg");
    }
}

#[test]
fn an_engine_that_stops_saves_what_idling_costs_less_what_it_gives_back() {
    let road = GivenRoad::flat(4000.0, 22.0).stop(2000.0, 60.0);
    let (without, with) = (unassisted(&[]), with("engine_stop"));
    let model = &without.model().driver.look_ahead;
    let stopped_s = 60.0 - model.engine_stop_delay_s;
    let engine = &diesel(&without).engine;
    let idle_radps = diesel(&without).engine_model.idle_speed_radps;
    let power_w = road.scenario(&without).vehicle.auxiliary_power_w;
    let rate = |torque_nm| engine.fuel_kgps(idle_radps, torque_nm);
    let torque_nm = power_w / idle_radps;
    let per_j = (rate(torque_nm + 1.0) - rate(torque_nm)) / idle_radps;
    let idle_kgps = rate(torque_nm);
    let expected_kg = stopped_s * (idle_kgps - per_j * model.engine_stop_power_w);
    let saved_kg = fuel_kg(&without, &road) - fuel_kg(&with, &road);
    assert!((saved_kg / expected_kg - 1.0).abs() < 1e-9, "{saved_kg} {expected_kg}");
    // nothing else is driven otherwise
    let [a, b] = [&without, &with].map(|study| drive_scenario(study, road.scenario(study)));
    assert!(a.duration_s == b.duration_s && a.wheel_energy_j == b.wheel_energy_j);
}

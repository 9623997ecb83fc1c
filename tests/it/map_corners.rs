//! Beyond the points of the maps: held or continued, counted, reported, and never "not a number",
//! in the closed loop and at a followed speed.

use crate::common::{GivenRoad, column, diesel, run, start_speeds_radps, study};
use crate::program::ocmc;
use ocmc_core::kernel::drive::trace::{trace, trace_scenario};
use ocmc_core::prescribed::{DriveCycle, follow_study};
use ocmc_core::record::{COLUMNS, Cell, Record};
use ocmc_core::study::Study;

const SHORT: &str = "mission.length_m=4000";

/// A map with points at two speeds and two torques only, in the middle of where the engine works.
const NARROW: [&str; 4] = [
    "vehicle.powertrain.combustion.engine.map_speed_radps=[110.0, 120.0]",
    "vehicle.powertrain.combustion.engine.drag_torque_nm=[-150.0, -160.0]",
    "vehicle.powertrain.combustion.engine.map_torque_nm=[0.0, 600.0]",
    "vehicle.powertrain.combustion.engine.map_fuel_kgps=[[0.0006, 0.0034], [0.0007, 0.0038]]",
];

/// The same plane far beyond everything that the engine can do.
const WIDE: [&str; 4] = [
    "vehicle.powertrain.combustion.engine.map_speed_radps=[10.0, 1024.0]",
    "vehicle.powertrain.combustion.engine.drag_torque_nm=[-150.0, -160.0]",
    "vehicle.powertrain.combustion.engine.map_torque_nm=[0.0, 4096.0]",
    "vehicle.powertrain.combustion.engine.map_fuel_kgps=[[0.0006, 0.02], [0.007, 0.9]]",
];

fn loaded(name: &str, sets: &[&str]) -> Study {
    study(name, &[&[SHORT], sets].concat())
}

fn assert_finite(records: &[Record], what: &str) {
    for record in records {
        for column in COLUMNS {
            if let Cell::Number(Some(value)) = column.get(record) {
                assert!(value.is_finite(), "{what}: {} {value}", column.name);
            }
        }
        let outside_j = record.outside_map_energy_j.unwrap();
        assert!(outside_j >= 0.0, "{what}: {outside_j}");
    }
}

/// From rest to 30 m/s and back on slopes that no truck climbs.
fn wild() -> DriveCycle {
    let speed: Vec<f64> = (0..600).map(|k| [0.0, 30.0, 69.0, 0.0, 4.0][k % 5]).collect();
    let slope = (0..600).map(|k| [0.5, -0.5, 0.0, 0.3][k % 4]).collect();
    DriveCycle::new((0..600).map(f64::from).collect(), speed, slope).unwrap()
}

#[test]
fn whatever_the_map_and_the_truck_every_column_is_a_number() {
    let heavy = [
        "mission.payload_kg=100000",
        "vehicle.gross_mass_limit_kg=200000",
        "vehicle.auxiliary_power_w=100000",
    ];
    let weak = [
        "vehicle.powertrain.combustion.engine.full_load_torque_nm=[1, 1, 1, 1, 1, 1, 1, 1, 1, 1, \
         1, 1]",
    ];
    let ends_early = [
        "vehicle.powertrain.combustion.engine.full_load_speed_radps=[63.0, 90.0]",
        "vehicle.powertrain.combustion.engine.full_load_torque_nm=[1200.0, 900.0]",
    ];
    // drag that would be a drive beyond the map's last speed
    let rising_drag = ["vehicle.powertrain.combustion.engine.drag_torque_nm=[-150.0, -0.1]"];
    let hasty = [
        "vehicle.powertrain.combustion.gearbox.axle_ratio=20.0",
        "vehicle.powertrain.combustion.gearbox.shift.duration_s=0.0",
    ];
    let tall = ["vehicle.powertrain.combustion.gearbox.axle_ratio=0.5"];
    let diesel: [(&str, Vec<&str>); 8] = [
        ("narrow", NARROW.to_vec()),
        ("wide", WIDE.to_vec()),
        ("heavy", heavy.to_vec()),
        ("weak", weak.to_vec()),
        ("a full-load curve that ends early", ends_early.to_vec()),
        ("narrow, rising drag", [&NARROW[..], &rising_drag].concat()),
        ("narrow, hasty", [&NARROW[..], &hasty].concat()),
        ("narrow, tall, heavy", [&NARROW[..], &tall, &heavy].concat()),
    ];
    let spot = [
        "vehicle.powertrain.battery_electric.motor.map_speed_radps=[50.0, 60.0]",
        "vehicle.powertrain.battery_electric.motor.map_torque_nm=[10.0, 20.0]",
        "vehicle.powertrain.battery_electric.motor.map_loss_w=[[100.0, 200.0], [150.0, 300.0]]",
    ];
    let poor = [
        "vehicle.powertrain.battery_electric.battery.resistance_ohm=10.0",
        "vehicle.powertrain.battery_electric.battery.discharge_power_w=1000.0",
        "vehicle.powertrain.battery_electric.battery.charge_power_w=0.0",
    ];
    let full = ["vehicle.powertrain.battery_electric.battery.initial_charge=1.0"];
    let empty = ["vehicle.powertrain.battery_electric.battery.initial_charge=0.1001"];
    let electric: [(&str, Vec<&str>); 6] = [
        ("spot", spot.to_vec()),
        ("poor", poor.to_vec()),
        ("poor, heavy", [&poor[..], &heavy].concat()),
        ("full", full.to_vec()),
        ("empty", empty.to_vec()),
        (
            "spot, full, slow",
            [
                &spot[..],
                &full,
                &["vehicle.powertrain.battery_electric.motor.maximum_speed_radps=60.0"],
            ]
            .concat(),
        ),
    ];
    let diesel = diesel.iter().map(|(what, sets)| ("field-truck", *what, sets));
    let electric = electric.iter().map(|(what, sets)| ("battery-truck", *what, sets));
    for (name, what, sets) in diesel.chain(electric) {
        let study = loaded(name, sets);
        assert_finite(&run(&study, 16), &format!("{name}, {what}"));
        let followed: Vec<Record> =
            (0..4).map(|cycle_id| follow_study(&study, 1, cycle_id, &wild()).0).collect();
        assert_finite(&followed, &format!("{name}, {what}, followed"));
    }
}

#[test]
fn fuel_beyond_the_map_is_counted_and_none_within() {
    let all = |sets: &[&str]| run(&loaded("field-truck", sets), 8);
    let outside = |records: &[Record]| -> f64 {
        records.iter().map(|r| r.outside_map_energy_j.unwrap()).sum()
    };
    assert_eq!(outside(&all(&WIDE)), 0.0);
    let narrow = all(&NARROW);
    // an idling engine, and every gear but those that happen to turn so
    let taken: f64 = narrow.iter().map(|record| record.stored_energy_j().unwrap()).sum();
    let share = outside(&narrow) / taken;
    assert!((0.5..=1.0).contains(&share), "{share}");
}

#[test]
fn the_count_is_what_the_trace_shows() {
    let wider =
        [&NARROW[..], &["vehicle.powertrain.combustion.engine.map_speed_radps=[85.0, 125.0]"]]
            .concat();
    let study = loaded("field-truck", &wider);
    let model = &diesel(&study).engine_model;
    for cycle_id in 0..4 {
        let trace = trace(&study, 1, cycle_id);
        let [torque, fuel, added] =
            ["engine_torque_nm", "fuel_added_kg", "outside_map_energy_added_j"]
                .map(|name| column(&trace, name));
        let mut sum_j = 0.0;
        let (mut beyond, mut within) = (0, 0);
        let start = start_speeds_radps(&study, &trace);
        for k in 0..fuel.len() {
            // the piece of the map is that of the step's start
            let covers = model.map_covers(start[k], torque[k]);
            let expected = if covers { 0.0 } else { fuel[k] * model.fuel.heating_value_jpkg };
            assert!(
                (added[k] - expected).abs() <= 1e-12 * expected,
                "{cycle_id}, row {k}: {} {}",
                start[k],
                torque[k]
            );
            *(if covers { &mut within } else { &mut beyond }) += 1;
        }
        assert!(beyond > 100 && within > 100, "{cycle_id}: {beyond} and {within} rows");
        for part in added {
            sum_j += part;
        }
        assert_eq!(sum_j, trace.record.outside_map_energy_j.unwrap());
    }
}

#[test]
fn a_motor_beyond_its_map_and_a_battery_beyond_its_power_are_counted() {
    let road = GivenRoad::flat(3000.0, 20.0);
    let outside = |sets: &[&str]| {
        let study = study("battery-truck", sets);
        let record = trace_scenario(&study, road.scenario(&study)).record;
        assert_finite(std::slice::from_ref(&record), "electric");
        record.outside_map_energy_j.unwrap() / record.stored_energy_j().unwrap()
    };
    assert_eq!(outside(&[]), 0.0);
    let short =
        ["vehicle.powertrain.battery_electric.motor.map_speed_radps=[0.0, 10.0, 20.0, 30.0, 40.0]"];
    let share = outside(&short);
    assert!(share > 0.3, "{share}");
    // U²/4R at 600 V and more is 9 kW and more, and the auxiliaries alone want 50
    let poor = [
        "vehicle.powertrain.battery_electric.battery.resistance_ohm=10.0",
        "vehicle.auxiliary_power_w=50000",
    ];
    assert!(outside(&poor) > 0.99);
}

#[test]
fn the_answer_says_it() {
    let run = |sets: &[&str], more: &[&str]| {
        let sets = sets.iter().flat_map(|set| ["--set", set]);
        let arguments: Vec<&str> =
            ["--cycles", "4", "--quiet", "--set", SHORT].into_iter().chain(sets).collect();
        let printed = ocmc(&arguments).args(more).assert().success();
        String::from_utf8(printed.get_output().stdout.clone()).unwrap()
    };
    let text = run(&NARROW, &[]);
    assert!(text.contains("Beyond the points of the powertrain's maps: "), "{text}");
    assert!(text.contains("in 4 of 4 cycles"), "{text}");
    assert!(!run(&WIDE, &[]).contains("Beyond the points"));
    let json: serde_json::Value = serde_json::from_str(&run(&NARROW, &["--json"])).unwrap();
    assert!(json["saturation"]["outside_map_energy_j"].as_f64().unwrap() > 0.0, "{json}");
    assert!(json["saturation"]["limited_s"].is_null());
}

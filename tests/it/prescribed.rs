//! The exact prescribed-speed mode: closed forms, the energy balance, limits, and FASTSim's
//! figures.

use crate::common::{balance, electric_balance, typical};
use crate::others_data::{shared, skipped};
use ocmc_core::energy::Carrier;
use ocmc_core::energy::ledger::Term;
use ocmc_core::powertrain::efficiency::{EfficiencyCurve, EfficiencyDriveline};
use ocmc_core::powertrain::{GearOrder, ShiftConvention};
use ocmc_core::prescribed::{
    Body, DriveCycle, FollowedCycle, follow, follow_scenario, follow_study,
};
use ocmc_core::record::{COLUMNS, Cell, Outcome, Record};
use ocmc_core::vehicle::resistance::{DragBySpeed, GRAVITY_MPS2};
use std::process::Command;

/// A cycle at one speed and slope, 1 s a step.
fn steady(speed_mps: f64, slope: f64, seconds: usize) -> DriveCycle {
    let n = seconds + 1;
    let time = (0..n).map(|k| k as f64).collect();
    DriveCycle::new(time, vec![speed_mps; n], vec![slope; n]).unwrap()
}

/// Starts, hills and stops: two hours.
fn busy() -> DriveCycle {
    let (mut time, mut speed, mut slope) = (vec![0.0], vec![0.0], vec![0.0]);
    for k in 1..7200 {
        let t = f64::from(k);
        let wave = 12.0 + 9.0 * (t / 90.0).sin() + 3.0 * (t / 17.0).sin();
        let rests = k % 600 < 40 || k > 7150;
        let goal: f64 = if rests { 0.0 } else { wave.max(0.0) };
        let last: f64 = speed[speed.len() - 1];
        time.push(t);
        speed.push(goal.clamp(last - 1.2, last + 0.5).max(0.0));
        slope.push(0.04 * (t / 200.0).sin());
    }
    DriveCycle::new(time, speed, slope).unwrap()
}

/// The busy cycle on hills so steep that no truck keeps its speed.
fn steep() -> DriveCycle {
    let points: Vec<[f64; 3]> = busy().points().collect();
    let column = |k: usize, factor: f64| -> Vec<f64> {
        points.iter().map(|point| factor * point[k]).collect()
    };
    DriveCycle::new(column(0, 1.0), column(1, 1.0), column(2, 2.5)).unwrap()
}

#[test]
fn steady_driving_is_the_closed_form() {
    let study =
        typical(&["simulation.without=[\"driver_spread\", \"vehicle_spread\", \"weather\"]"]);
    let scenario = study.sample(1, 0);
    for (speed_mps, slope) in [(85.0 / 3.6, 0.0), (12.0, 0.03), (22.0, -0.002)] {
        let (record, sum) = follow_study(&study, 1, 0, &steady(speed_mps, slope, 600));
        let vehicle = scenario.vehicle;
        let temperature = ocmc_core::vehicle::resistance::rolling_temperature_factor(288.15, 0.006);
        let air = ocmc_core::operating_cycle::weather::STANDARD_WEATHER.air_density_kgpm3(0.0);
        let cosine = (1.0f64 - slope * slope).sqrt();
        let rolling = vehicle.rolling_coefficient * temperature * cosine;
        let wanted = vehicle.mass_kg * GRAVITY_MPS2 * (rolling + slope)
            + 0.5 * air * vehicle.drag_area_m2 * speed_mps * speed_mps;
        let force = record.wheel_energy_j / record.distance_m;
        assert!((force / wanted - 1.0).abs() < 1e-12, "{speed_mps} {slope}: {force} {wanted}");
        assert_eq!(sum.ledger[Term::Limited], 0.0);
    }
}

#[test]
fn the_balance_closes() {
    let study = typical(&[]);
    let cycle = busy();
    for cycle_id in 0..8 {
        let (record, sum) = follow_study(&study, 1, cycle_id, &cycle);
        let missing = sum.ledger[Term::Missing] / record.crankshaft_work_j.unwrap();
        assert!((balance(&record) + missing).abs() < 1e-9, "{cycle_id} {}", balance(&record));
        assert!(record.n_stops >= 10 && record.n_gear_shifts > 50);
        assert!(record.consumption(Carrier::LiquidFuel).unwrap() > 10.0);
    }
}

#[test]
fn the_balance_in_the_records_closes_where_the_powertrain_is_saturated() {
    let cycle = steep();
    for study in [&typical(&[]), &crate::common::study("battery-truck", &[])] {
        for cycle_id in 0..8 {
            let record = follow_study(study, 1, cycle_id, &cycle).0;
            let missing_j = record.missing_energy_j.unwrap();
            let (open, of_j) = match record.amount(Carrier::Electricity) {
                Some(store_j) => {
                    (electric_balance(&record), store_j.abs().max(record.wheel_energy_j))
                }
                None => (balance(&record), record.crankshaft_work_j.unwrap().abs()),
            };
            assert!(missing_j > 1e-3 * of_j, "{cycle_id}: {missing_j} of {of_j}");
            // what was missing is a source
            let open = open + missing_j / of_j;
            assert!(open.abs() < 1e-9, "{cycle_id}: {open}");
        }
    }
}

/// From rest through the gears and, the clutch open, back to rest.
fn through_the_gears() -> DriveCycle {
    let (mut speed, mut gears) = (vec![0.0], vec![GearOrder::Open]);
    for k in 1..=45 {
        speed.push((0.4 * f64::from(k)).min(16.0));
        // a second of gap before each gear but the first
        let gear = 2 + (k / 6) as usize;
        let gap = k % 6 == 0;
        gears.push(if gap { GearOrder::Open } else { GearOrder::Engaged(gear) });
    }
    while speed[speed.len() - 1] > 0.0 {
        speed.push((speed[speed.len() - 1] - 0.5).max(0.0));
        gears.push(GearOrder::Open);
    }
    let time = (0..speed.len()).map(|k| k as f64).collect();
    let flat = vec![0.0; speed.len()];
    DriveCycle::new(time, speed, flat).unwrap().with_gears(gears)
}

#[test]
fn ordered_gears_are_driven_and_both_conventions_balance() {
    let study = typical(&["simulation.without=[\"weather\"]"]);
    let (cycle, scenario) = (through_the_gears(), study.sample(1, 0));
    let [lost, returned] = [ShiftConvention::Lost, ShiftConvention::Returned].map(|convention| {
        let (record, sum) = follow_scenario(&study, &scenario, &cycle, convention);
        let missing = sum.ledger[Term::Missing] / record.crankshaft_work_j.unwrap();
        assert!((balance(&record) + missing).abs() < 1e-9, "{convention:?} {}", balance(&record));
        assert_eq!(record.n_gear_shifts, 7);
        (record, sum)
    });
    let [lost_j, returned_j] = [&lost, &returned]
        .map(|(_, sum)| [Term::Shift, Term::Clutch, Term::Wheel].map(|term| sum.ledger[term]));
    // a clutch that slips while the engine turns at 84 rad/s, and engine speeds that jump
    assert!(lost_j[0].abs() > 10e3 && lost_j[1] > 10e3, "{lost_j:?}");
    assert!(returned_j[0].abs() < 1e-3 && returned_j[1].abs() < 1e-3, "{returned_j:?}");
    // the wheels are none of the convention's business
    assert!((lost_j[2] / returned_j[2] - 1.0).abs() < 1e-3);
    // an engine that is let go burns nothing until it idles: then the gaps that VECTO counts cost
    assert!(returned.0.amount(Carrier::LiquidFuel) != lost.0.amount(Carrier::LiquidFuel));
}

#[test]
fn what_no_engine_can_do_is_counted_and_nothing_breaks() {
    let study = typical(&[]);
    let jumps: Vec<f64> = (0..400).map(|k| if k % 7 < 3 { 0.0 } else { 69.0 }).collect();
    let slopes: Vec<f64> = (0..400).map(|k| [0.5, -0.5, 0.0, 0.3][k % 4]).collect();
    let time: Vec<f64> = (0..400).map(|k| 0.01 * k as f64).collect();
    let cycle = DriveCycle::new(time, jumps, slopes).unwrap();
    let (record, sum) = follow_study(&study, 1, 0, &cycle);
    assert!(sum.ledger[Term::Limited] > 0.0 && sum.ledger[Term::Missing] > 0.0);
    for column in COLUMNS {
        if let Cell::Number(Some(value)) = column.get(&record) {
            assert!(value.is_finite(), "{}", column.name);
        }
    }
    // the balance closes relative to what was turned over: the engine's own work is little of it
    let open_j =
        balance(&record) * record.crankshaft_work_j.unwrap().abs() + sum.ledger[Term::Missing];
    let turned_over_j = sum.ledger[Term::Missing] + sum.ledger[Term::ServiceBrake];
    assert!((open_j / turned_over_j).abs() < 1e-9, "{open_j} of {turned_over_j}");
}

/// Result of FASTSim for a vehicle on a cycle; none, with a message, where there is no FASTSim.
fn fastsim(vehicle: &str, cycle: &str) -> Option<serde_json::Value> {
    let in_shared = || shared(&format!("vehicles/fastsim/{vehicle}.yaml"));
    // a name with an ending is one of FASTSim's own
    let file = if vehicle.contains('.') { vehicle.into() } else { in_shared()? };
    let python = std::env::var("OCMC_FASTSIM_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/fastsim/achieved_speed.py");
    let output = Command::new(&python).arg(script).arg(file).arg(cycle).output().ok();
    let Some(output) = output.filter(|output| output.status.success()) else {
        skipped(&format!("{python} has no fastsim (`pip install fastsim==3.1.0`)"));
        return None;
    };
    Some(serde_json::from_slice(&output.stdout).unwrap())
}

/// The same vehicle here; FASTSim takes 9.80 m/s² and, as its figures say, 1.1729 kg/m³.
fn ours(answer: &serde_json::Value, text: &str) -> FollowedCycle {
    let list = |key: &str| -> Vec<f64> { serde_json::from_value(answer[key].clone()).unwrap() };
    let number = |key: &str| answer[key].as_f64().unwrap();
    let value = |key: &str| -> f64 {
        let line = text.lines().find(|line| line.starts_with(&format!("{key}:"))).unwrap();
        line.split(':').nth(1).unwrap().trim().parse().unwrap()
    };
    let time = list("time_s");
    let cycle = DriveCycle::new(time.clone(), list("speed_mps"), vec![0.0; time.len()]).unwrap();
    let radius_m = value("wheel_radius_m");
    let body = Body {
        mass_kg: number("mass_kg"),
        wheel_mass_kg: value("wheel_inertia_kg_m2") * value("num_wheels") / (radius_m * radius_m),
        drag_area_m2: value("drag_coef") * value("frontal_area_m2"),
        drag_by_speed: DragBySpeed::NONE,
        rolling_coefficient: value("wheel_rr_coef") * 9.80 / GRAVITY_MPS2,
        air_density_kgpm3: 1.1729,
    };
    let engine = EfficiencyCurve {
        rated_power_w: number("rated_w"),
        power_share: list("share"),
        efficiency: list("efficiency"),
    };
    let mut driveline = EfficiencyDriveline {
        transmission_efficiency: value("trans_eff"),
        engine,
        auxiliary_power_w: number("auxiliary_w"),
    };
    follow(&cycle, &body, &mut driveline)
}

#[test]
fn fastsim_says_the_same() {
    // FASTSim 3.1.0, Line_Haul_Conv: positive wheel work, drag, rolling and fuel, in MJ, as it
    // printed them when this was written
    let printed = [
        ("Line_Haul_Conv", "hwfet", Some([81.048, 28.293, 31.477, 233.157])),
        ("Line_Haul_Conv", "udds", Some([87.525, 8.508, 22.661, 262.314])),
        ("Class_4_Box_Truck", "hwfet", None),
        ("Class_4_Box_Truck", "udds", None),
        ("Regional_Delivery_Class_8_Truck", "hwfet", None),
        ("Regional_Delivery_Class_8_Truck", "udds", None),
    ];
    for (vehicle, cycle, printed) in printed {
        let Some(answer) = fastsim(vehicle, cycle) else { return };
        let file = shared(&format!("vehicles/fastsim/{vehicle}.yaml")).unwrap();
        let sum = ours(&answer, &std::fs::read_to_string(file).unwrap());
        let keys = ["wheel_j", "drag_j", "rolling_j", "fuel_j"];
        let theirs = keys.map(|key| answer[key].as_f64().unwrap());
        let here =
            [Term::Wheel, Term::Drag, Term::Rolling, Term::FuelEnergy].map(|term| sum.ledger[term]);
        let mega = |values: [f64; 4]| values.map(|joule| format!("{:.3}", joule / 1e6)).join(" / ");
        println!("{vehicle} {cycle}: here {}, FASTSim {} MJ", mega(here), mega(theirs));
        for ((key, here), there) in keys.into_iter().zip(here).zip(theirs) {
            assert!((here / there - 1.0).abs() < 1e-3, "{vehicle} {cycle} {key}: {here} {there}");
        }
        for (here, there) in here.into_iter().zip(printed.into_iter().flatten()) {
            assert!((here / 1e6 / there - 1.0).abs() < 1e-3, "{vehicle} {cycle}: {here} {there}");
        }
    }
}

#[test]
fn the_petrol_car_burns_what_fastsim_says() {
    // its body and its engine's efficiency are those of FASTSim's car; the air here is 4 % denser,
    // and gears, axle and idling are its own
    let sets = [
        "simulation.without=[\"driver_spread\", \"vehicle_spread\", \"weather\", \"traffic\"]",
        "mission.payload_kg=136",
        "vehicle.rolling_temperature_coefficient_per_k=0",
    ];
    let study = crate::common::study("passenger-car", &sets);
    for cycle in ["hwfet", "udds"] {
        let Some(answer) = fastsim("2012_Ford_Fusion.yaml", cycle) else { return };
        let list = |key: &str| -> Vec<f64> { serde_json::from_value(answer[key].clone()).unwrap() };
        let time = list("time_s");
        let flat = vec![0.0; time.len()];
        let given = DriveCycle::new(time, list("speed_mps"), flat).unwrap();
        let (record, sum) = follow_study(&study, 1, 0, &given);
        let theirs = |key: &str| answer[key].as_f64().unwrap();
        println!(
            "{cycle}: here {:.3} MJ at the wheels, {:.3} of fuel, {:.2} L/100 km; FASTSim {:.3} \
             and {:.3}",
            sum.ledger[Term::Wheel] / 1e6,
            sum.ledger[Term::FuelEnergy] / 1e6,
            record.consumption(Carrier::LiquidFuel).unwrap(),
            theirs("wheel_j") / 1e6,
            theirs("fuel_j") / 1e6
        );
        assert!(
            (sum.ledger[Term::Wheel] / theirs("wheel_j") - 1.0).abs() < 0.04,
            "{cycle}: wheels"
        );
        assert!(
            (sum.ledger[Term::FuelEnergy] / theirs("fuel_j") - 1.0).abs() < 0.10,
            "{cycle}: fuel"
        );
        assert_eq!(
            (sum.ledger[Term::Limited], sum.ledger[Term::OutsideMap]),
            (0.0, 0.0),
            "{cycle}"
        );
    }
}

#[test]
fn a_fleet_of_petrol_cars_burns_what_the_car_does_in_town_and_on_highways() {
    // FASTSim 3.1.0, the same car, warm: 26.488 MJ over the 16.507 km of HWFET, 26.292 MJ over the
    // 11.990 km of UDDS. The label of its model year, 7.1 to 10.2 L/100 km, contains cold starts
    // and air conditioning, which are not modelled here
    let [highway, town] =
        [26.488 / 16.507, 26.292 / 11.990].map(|mj_per_km: f64| mj_per_km / 43.2 / 0.745 * 100.0);
    let study = crate::common::study("passenger-car", &[]);
    let records = crate::common::run(&study, 100);
    let completed: Vec<&Record> =
        records.iter().filter(|record| record.outcome == Outcome::Completed).collect();
    assert!(completed.len() >= 99, "{}", completed.len());
    let sum = |of: fn(&Record) -> f64| completed.iter().map(|record| of(record)).sum::<f64>();
    let km = sum(|record| record.distance_m) / 1000.0;
    let mean = sum(|record| record.amount(Carrier::LiquidFuel).unwrap()) / 0.745 / km * 100.0;
    let speed_kmh = 3600.0 * km / sum(|record| record.duration_s);
    let outside = sum(|record| record.outside_map_energy_j.unwrap())
        / sum(|record| record.stored_energy_j().unwrap());
    println!("{mean:.2} L/100 km at {speed_kmh:.1} km/h, {outside:.5} beyond the map");
    assert!((highway..town).contains(&mean), "{mean}: {highway} to {town}");
    for record in completed {
        assert!(balance(record).abs() < 1e-9, "{}", balance(record));
    }
}

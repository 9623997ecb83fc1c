//! The forward simulation on VECTO's cycles beside quasi-static runs of the same truck; prints the
//! tables of `docs/src/vecto-comparison.md`: `cargo test -p ocmc --test it vecto -- --nocapture`.

use crate::others_data::shared;
use ocmc_core::energy::Carrier;
use ocmc_core::energy::ledger::Term;
use ocmc_core::kernel::drive::scheduler::drive_scenario;
use ocmc_core::prescribed::{DriveCycle, follow_study};
use ocmc_core::record::{Outcome, Record};
use ocmc_io::given_cycle::RouteOptions;
use ocmc_io::study::{LoadedStudy, load};
use std::fmt::Write as _;
use std::path::Path;

/// Cycles, and l/100 km of a quasi-static run of this truck over them, by gross mass.
const CYCLES: [(&str, [f64; 4]); 2] =
    [("LongHaul", [23.5, 30.1, 34.3, 37.6]), ("RegionalDelivery", [25.6, 35.0, 40.9, 45.4])];
/// Payloads, in kg: 17.6, 28.3, 34.9 and 40 t.
const PAYLOADS_KG: [f64; 4] = [1900.0, 12_600.0, 19_200.0, 24_300.0];
/// An engine with nearly twice the torque, which can follow VECTO's target speeds everywhere; its
/// map goes on with its last slopes.
const STRONG: &str = "vehicle.powertrain.combustion.engine.full_load_torque_nm=\
     [2257, 3156, 4055, 4055, 4055, 3882, 3648, 3272, 2381, 1954, 1859, 2]";
/// VECTO's driver [F: Truck.vacc]: accelerations, in m/s², at speeds in km/h; the decelerations are
/// 1 up to 50 km/h, 0.5 from 60 on.
const ACCELERATION: [(f64, f64); 4] = [(25.0, 1.0), (50.0, 0.642857), (60.0, 0.5), (120.0, 0.5)];
const DECELERATION: [(f64, f64); 4] = [(25.0, 1.0), (50.0, 1.0), (60.0, 0.5), (120.0, 0.5)];

fn study(sets: &[&str]) -> LoadedStudy {
    load(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/cases/vecto.toml"), sets).unwrap()
}

fn driven(file: &Path, sets: &[&str]) -> Record {
    let given = study(sets).on_routes(&[file.to_owned()], &[], RouteOptions::default()).unwrap();
    let record = drive_scenario(&given.study, given.study.sample(1, 0));
    assert_eq!(record.outcome, Outcome::Completed);
    record
}

fn litres(record: &Record) -> f64 {
    record.consumption(Carrier::LiquidFuel).unwrap()
}

fn held(table: &[(f64, f64); 4], speed_mps: f64) -> f64 {
    let kmh = 3.6 * speed_mps;
    let k = table.partition_point(|point| point.0 <= kmh);
    if k == 0 || k == table.len() {
        return table[k.min(table.len() - 1)].1;
    }
    let ((x0, y0), (x1, y1)) = (table[k - 1], table[k]);
    y0 + (y1 - y0) * (kmh - x0) / (x1 - x0)
}

/// The speed of a perfect follower: VECTO's target speeds, reached and left with VECTO's
/// accelerations, whatever the truck can do.
fn perfect_follower(file: &Path) -> DriveCycle {
    let cycle = ocmc_io::given_cycle::read(file, &[]).unwrap();
    let step_m = 1.0;
    let n = cycle.length_m as usize;
    let mut limit = vec![0.0f64; n + 1];
    for (k, v) in limit.iter_mut().enumerate() {
        let at = cycle.limits.partition_point(|limit| limit.0 <= k as f64).max(1) - 1;
        *v = cycle.limits[at].1;
    }
    // a lower limit holds from its place on: also at the node before
    for event in &cycle.events {
        limit[event.position_m.round() as usize] = 0.0;
    }
    (limit[0], limit[n]) = (0.0, 0.0);
    for k in (0..n).rev() {
        let v: f64 = limit[k + 1];
        limit[k] = limit[k].min((v * v + 2.0 * step_m * held(&DECELERATION, v)).sqrt());
    }
    for k in 1..=n {
        let v: f64 = limit[k - 1];
        limit[k] = limit[k].min((v * v + 2.0 * step_m * held(&ACCELERATION, v)).sqrt());
    }
    let (mut time, mut speed, mut slope) = (vec![0.0], vec![0.0], vec![0.0]);
    for k in 1..=n {
        let mean = 0.5 * (limit[k] + limit[k - 1]);
        let x = k as f64;
        time.push(time[time.len() - 1] + step_m / mean);
        speed.push(limit[k]);
        slope.push(cycle.altitude_m(x) - cycle.altitude_m(x - 1.0));
        if let Some(event) = cycle.events.iter().find(|e| e.position_m.round() as usize == k) {
            time.push(time[time.len() - 1] + event.kind.standstill_s().unwrap());
            speed.push(0.0);
            slope.push(0.0);
        }
    }
    DriveCycle::new(time, speed, slope).unwrap()
}

#[test]
fn quasi_static_figures_on_vecto_cycles() {
    println!(
        "| cycle | t | quasi-static | forward | difference | perfect follower here | forward km/h \
         | follower km/h |"
    );
    for (name, figures) in CYCLES {
        let Some(file) = shared(&format!("vecto/cycles/{name}.vdri")) else { return };
        let perfect = perfect_follower(&file);
        for (payload_kg, figure) in PAYLOADS_KG.into_iter().zip(figures) {
            let payload = format!("mission.payload_kg={payload_kg}");
            let record = driven(&file, &[&payload]);
            let strong = study(&[&payload, STRONG]);
            let (followed, sum) = follow_study(&strong.study, 1, 0, &perfect);
            let limited_s = sum.ledger[Term::Limited];
            assert!(limited_s < 0.01 * sum.duration_s, "{name} {limited_s}");
            let difference = litres(&record) / figure - 1.0;
            println!(
                "| {name} | {:.1} | {figure:.1} | {:.2} | {:+.1} % | {:.2} | {:.1} | {:.1} |",
                15.7 + payload_kg / 1000.0,
                litres(&record),
                100.0 * difference,
                litres(&followed),
                3.6 * record.mean_speed_mps,
                3.6 * followed.mean_speed_mps
            );
            let bound = if name == "LongHaul" && payload_kg > 19_000.0 { 0.03 } else { 0.08 };
            assert!(difference.abs() < bound, "{name} {payload_kg}: {difference}");
        }
    }
}

#[test]
fn each_difference_has_its_switch() {
    let switches: [(&str, &[&str]); 8] = [
        ("as compared", &[]),
        ("auxiliaries 4.7 kW", &["vehicle.auxiliary_power_w=4700"]),
        ("overspeed band 5 km/h", &["driver.pedals.overspeed_band_mps=1.38889"]),
        ("acceleration 1.0 m/s² wanted", &["driver.speed_change.acceleration_mps2=1.0"]),
        ("deceleration 1.0 m/s²", &["driver.speed_change.deceleration_mps2=1.0"]),
        ("no shift time", &["vehicle.powertrain.combustion.gearbox.shift.duration_s=0.0"]),
        ("air of 1.225 kg/m³", &["weather.temperature.mean_k=288.15", "weather.altitude_m=0"]),
        ("slope on steps of 5 m", &["road.slope_step_m=5"]),
    ];
    println!("| switch | LongHaul | RegionalDelivery |");
    let mut found = Vec::new();
    for (name, sets) in switches {
        let mut line = format!("| {name} |");
        let mut row = Vec::new();
        for (cycle, _) in CYCLES {
            let Some(file) = shared(&format!("vecto/cycles/{cycle}.vdri")) else { return };
            row.push(litres(&driven(&file, sets)));
            write!(line, " {:.2} |", row[row.len() - 1]).unwrap();
        }
        println!("{line}");
        found.push(row);
    }
    let change = |switch: usize, cycle: usize| found[switch][cycle] - found[0][cycle];
    for cycle in 0..2 {
        // auxiliaries cost, the band saves, quick braking costs, dense air costs: the signs that
        // the guide explains
        assert!(change(1, cycle) > 0.5 && change(2, cycle) < -0.3);
        assert!(change(4, cycle) > 0.0 && change(6, cycle) > 0.0);
        assert!(change(7, cycle).abs() < 0.1, "the slope's step does not matter");
    }
}

#[test]
fn the_truck_of_vectos_own_files() {
    let Some(folder) = shared("vecto/40t_tractor") else { return };
    let scratch = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.join(name).canonicalize().unwrap().display().to_string();
    let base = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/cases/vecto.toml");
    let text = format!(
        "[study]\nname = \"vecto-files\"\ndescription = \"VECTO's 40 t truck from its files\"\n\
         base = \"{base}\"\n\
         [vehicle]\ndrag_area_m2 = 6.2985\ntyre_code = \"315/70R22.5\"\n\
         [vehicle.powertrain.combustion.engine]\ninertia_kgm2 = 5.1471\nidle_speed_radps = 58.64\n\
         full_load_file = \"{}\"\nmap_file = \"{}\"\n\
         [vehicle.powertrain.combustion.gearbox]\n\
         ratio = [14.93, 11.64, 9.02, 7.04, 5.64, 4.40, 3.39, 2.65, 2.05, 1.60, 1.28, 1.00]\n\
         axle_ratio = 2.59\ndirect_loss_file = \"{}\"\nindirect_loss_file = \"{}\"\n\
         axle_loss_file = \"{}\"\n\
         retarder_loss_file = \"{}\"\n",
        path("40t_Long_Haul_Truck.vfld"),
        path("40t_Long_Haul_Truck.vmap"),
        path("Direct_Gear.vtlm"),
        path("Indirect_Gear.vtlm"),
        path("Axle.vtlm"),
        path("Retarder.vrlm")
    );
    let file = scratch.path().join("truck.toml");
    std::fs::write(&file, text).unwrap();
    let none: &[&str] = &[];
    let loaded = load(file.to_str().unwrap(), none).unwrap();
    let (model, drive) = (&loaded.model.vehicle, crate::common::diesel(&loaded.study));
    assert!((model.wheel_radius_m - 0.4915).abs() < 1e-4);
    // points of the files: 1200 rpm, 2300 Nm full load, −179 Nm drag; 1000 rpm and 1000 Nm, as the
    // map says; the axle's line
    let w = 1200.0 * std::f64::consts::PI / 30.0;
    assert!((drive.engine.full_load_nm(w) - 2300.0).abs() < 0.5);
    assert!((drive.engine.drag_nm(w) + 179.0).abs() < 0.5);
    let axle = &drive.gearbox;
    assert!(
        (axle.axle_loss_torque_nm - 40.0).abs() < 1e-6
            && (axle.axle_loss_share - 0.015).abs() < 1e-9
    );
    println!("| cycle | 17.6 t | 28.3 t | 34.9 t | 40.0 t |");
    for (cycle, _) in CYCLES {
        let Some(route) = shared(&format!("vecto/cycles/{cycle}.vdri")) else { return };
        let mut line = format!("| {cycle} |");
        for payload_kg in PAYLOADS_KG {
            let payload = format!("mission.payload_kg={payload_kg}");
            let given = load(file.to_str().unwrap(), &[&payload]).unwrap();
            let given = given
                .on_routes(std::slice::from_ref(&route), &[], RouteOptions::default())
                .unwrap();
            let record = drive_scenario(&given.study, given.study.sample(1, 0));
            assert_eq!(record.outcome, Outcome::Completed);
            write!(line, " {:.2} |", litres(&record)).unwrap();
        }
        println!("{line}");
    }
    // what is wrong names the study's line and the file
    let text = "[study]\nname = \"a\"\ndescription = \"b\"\nbase = \"field-truck\"\n\
                [vehicle.powertrain.combustion.engine]\nmap_file = \"no.vmap\"\n";
    let error = ocmc_io::study::load_text("a.toml", text, none).unwrap_err().to_string();
    assert!(error.contains("a.toml:6:") && error.contains("no.vmap"), "{error}");
    let error = load("field-truck", &["vehicle.tyre_code=round"]).unwrap_err().to_string();
    assert!(error.contains("315/70R22.5"), "{error}");
}

//! Given operating cycles: what a drawn one is written as drives the same again; routes mix by
//! weight; VECTO's cycles can be driven.

use crate::common::run;
use crate::others_data::shared;
use ocmc_core::energy::Carrier;
use ocmc_core::kernel::drive::scheduler::drive_scenario;
use ocmc_core::operating_cycle::route::Keep;
use ocmc_core::record::{COLUMNS, Cell, Outcome};
use ocmc_fleet::summary::SummaryBuilder;
use ocmc_io::given_cycle::RouteOptions;
use ocmc_io::operating_cycle::RealisedCycle;
use ocmc_io::study as studies;

/// A folder for this test's files.
fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

#[test]
fn a_written_cycle_drives_again_to_the_same_record() {
    let folder = folder();
    let loaded = studies::load("field-truck", &[] as &[&str]).unwrap();
    let mut same = 0;
    for cycle_id in [3, 17, 18, 19, 20] {
        let scenario = loaded.study.sample(1, cycle_id);
        let cycle = RealisedCycle::new(&loaded, 1, cycle_id);
        let json = serde_json::to_string(&cycle).unwrap();
        let as_json = folder.path().join("cycle.json");
        std::fs::write(&as_json, json).unwrap();
        let as_csv = folder.path().join("cycle.csv");
        let mut bytes = Vec::new();
        cycle.write_csv(&mut bytes).unwrap();
        std::fs::write(&as_csv, bytes).unwrap();
        let record = drive_scenario(&loaded.study, scenario);
        for file in [as_json, as_csv] {
            let given =
                loaded.clone().on_routes(&[file], &Keep::ALL, RouteOptions::default()).unwrap();
            let again = drive_scenario(&given.study, given.study.sample(1, cycle_id));
            // radii go through 1/R and slopes through altitudes: the last bits differ, and a truck
            // that just misses a shifting line in one of them may cross it in the other
            if again.n_gear_shifts != record.n_gear_shifts {
                let part = again.wheel_energy_j / record.wheel_energy_j;
                assert!((part - 1.0).abs() < 1e-3, "{cycle_id}: {part}");
                continue;
            }
            same += 1;
            for column in COLUMNS {
                // the CSV form has no departure, and a drawn road is no route
                if ["departure_s_of_year", "route_id"].contains(&column.name) {
                    continue;
                }
                match (column.get(&record), column.get(&again)) {
                    (Cell::Number(Some(a)), Cell::Number(Some(b))) => {
                        let error = (a - b).abs() / a.abs().max(1.0);
                        assert!(error < 1e-6, "{cycle_id} {}: {a} {b}", column.name);
                    }
                    (a, b) => assert_eq!(a, b, "{cycle_id} {}", column.name),
                }
            }
        }
    }
    assert!(same >= 8, "only {same} of 10 files gave the same shifts");
}

#[test]
fn routes_mix_by_weight_and_the_population_drives_them() {
    let folder = folder();
    let row = |x: f64, kmh: f64| format!("{x},{kmh},0,0\n");
    let file = |name: &str, length_m: f64| {
        let text = format!("<s>,<v>,<grad>,<stop>\n{}{}", row(0.0, 50.0), row(length_m, 0.0));
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    file("short.vdri", 300.0);
    file("long.vdri", 900.0);
    let text = "[study]\nname = \"mix\"\ndescription = \"two routes\"\nbase = \"field-truck\"\n\
                [mission]\nroutes = [{ file = \"short.vdri\", weight = 3.0 }, { file = \
                \"long.vdri\", weight = 1.0 }]\n";
    let study_file = folder.path().join("mix.toml");
    std::fs::write(&study_file, text).unwrap();
    let loaded = studies::load(study_file.to_str().unwrap(), &[] as &[&str]).unwrap();
    let n = 600;
    let records = run(&loaded.study, n);
    let short = records.iter().filter(|r| r.distance_m < 500.0).count() as f64;
    let share = short / n as f64;
    assert!((share - 0.75).abs() < 4.0 * (0.75 * 0.25 / n as f64).sqrt(), "{share}");
    assert!(records.iter().any(|r| r.payload_kg == 0.0 && r.outcome == Outcome::Completed));
    let mut temperatures: Vec<f64> = records.iter().map(|r| r.air_temperature_k).collect();
    temperatures.dedup();
    assert_eq!(temperatures.len(), n as usize, "each trip has its own weather");

    // the resolved study repeats the run, and notices that a file is another one
    let resolved = studies::resolved_toml(&loaded.model);
    let again = studies::load_text("resolved.toml", &resolved, &[] as &[&str]).unwrap();
    assert_eq!(run(&again.study, 8), records[..8]);
    file("short.vdri", 301.0);
    let fault = studies::load_text("resolved.toml", &resolved, &[] as &[&str]).unwrap_err();
    assert!(fault.to_string().contains("SHA-256"), "{fault}");
}

#[test]
fn a_wrong_route_says_where_it_is_written() {
    let folder = folder();
    let study_file = folder.path().join("s.toml");
    let text = "[study]\nname = \"s\"\ndescription = \"d\"\nbase = \"field-truck\"\n\
                [mission]\nroutes = [{ file = \"absent.vdri\", weight = 1.0 }]\n";
    std::fs::write(&study_file, text).unwrap();
    let fault = studies::load(study_file.to_str().unwrap(), &[] as &[&str]).unwrap_err();
    let text = fault.to_string();
    assert!(text.contains("s.toml:6:") && text.contains("absent.vdri"), "{text}");
    let fault = studies::load("field-truck", &["mission.routes=[{file=\"a.csv\", weight=-1}]"]);
    assert!(fault.unwrap_err().to_string().contains("mission.routes"), "bounds hold");
}

/// Field-truck on a route that is written as CSV.
fn on_csv(text: &str, sets: &[&str], keep: &[Keep]) -> Result<ocmc_core::study::Study, String> {
    let folder = folder();
    let file = folder.path().join("route.csv");
    std::fs::write(&file, text).unwrap();
    let loaded = studies::load("field-truck", sets).unwrap();
    loaded
        .on_routes(&[file], keep, RouteOptions::default())
        .map(|loaded| loaded.study)
        .map_err(|fault| fault.to_string())
}

#[test]
fn an_altitude_that_no_road_climbs_is_refused() {
    // one row of a receiver that had lost its satellites
    let text = "position_m,speed_limit_kmh,altitude_m\n0,80,0\n500,80,500\n520,80,60\n1000,80,60\n";
    let fault = on_csv(text, &[], &[]).unwrap_err();
    assert!(fault.contains("altitude_m") && fault.contains("-0.5 to 0.5"), "{fault}");
}

#[test]
fn a_driver_who_has_come_to_rest_goes_on_however_slowly() {
    // 4 km/h is less than a switched driver's threshold may be
    let text = "position_m,speed_limit_kmh\n0,50\n400,4\n500,50\n1000,50\n";
    let all_switched = "driver.pedals.pid_share=0";
    let study = on_csv(text, &[all_switched, "driver.pedals.switched.threshold_mps=1.2"], &[]);
    for record in run(&study.unwrap(), 32) {
        assert_eq!(record.outcome, Outcome::Completed, "{record:?}");
    }
}

#[test]
fn what_is_turned_off_is_off_on_a_route_that_keeps_it() {
    let loaded = studies::load("field-truck", &[] as &[&str]).unwrap();
    let mut bytes = Vec::new();
    RealisedCycle::new(&loaded, 1, 17).write_csv(&mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let litres = |without: &str| {
        let sets = [format!("simulation.without=[{without}]")];
        let study = on_csv(&text, &[&sets[0]], &Keep::ALL).unwrap();
        drive_scenario(&study, study.sample(1, 17)).amount(Carrier::LiquidFuel).unwrap()
    };
    let all = litres("");
    for part in ["\"weather\"", "\"traffic\""] {
        let without = litres(part);
        assert!((without / all - 1.0).abs() > 1e-3, "{part}: {without} kg of {all} kg");
    }
}

#[test]
fn vecto_cycles_are_driven_to_their_ends() {
    let quiet = [
        "simulation.without=[\"weather\", \"traffic\", \"driver_spread\", \"vehicle_spread\"]",
        "mission.payload_kg=19200",
    ];
    for (name, length_m, climb, stops) in
        [("LongHaul", 108_191.0, 0.0, 4), ("RegionalDelivery", 25_836.0, 0.0, 4)]
    {
        let Some(file) = shared(&format!("vecto/cycles/{name}.vdri")) else { return };
        let loaded = studies::load("field-truck", &quiet).unwrap();
        let given = loaded.on_routes(&[file], &[], RouteOptions::default()).unwrap();
        let record = drive_scenario(&given.study, given.study.sample(1, 0));
        assert_eq!(record.outcome, Outcome::Completed, "{name}");
        assert!((record.distance_m - length_m).abs() < 1.0, "{name} {}", record.distance_m);
        assert_eq!(record.n_stops, stops, "{name}");
        // VECTO's cycles: the mean slope is 0.00 %
        let mean = record.potential_change_j / (9.80665 * 34_900.0 * length_m);
        assert!((mean - climb).abs() < 5e-5, "{name} {mean}");
    }
}

#[test]
fn every_built_in_vehicle_drives_the_default_roads() {
    for vehicle in studies::builtin::VEHICLES {
        let text = format!(
            "[study]\nname = \"v\"\ndescription = \"d\"\nbase = \"field-truck\"\n\
             [mission]\npayload_kg = 1000.0\n[vehicle]\nbase = \"{}\"\n",
            vehicle.name
        );
        let loaded = studies::load_text("v.toml", &text, &[] as &[&str]).unwrap();
        for record in run(&loaded.study, 8) {
            assert_eq!(record.outcome, Outcome::Completed, "{} {}", vehicle.name, record.cycle_id);
            // of what the store gives, and of what braking brings back, a fifth at least comes to
            // the wheels and not more than all
            let store = record.stored_energy_j().unwrap();
            let given = store + record.regenerated_energy_j.unwrap_or(0.0);
            let share = record.wheel_energy_j / given;
            assert!((0.2..1.0).contains(&share), "{} {share} {given}", vehicle.name);
            let stores = record.carriers().map(|declared| declared.carrier);
            let declared = loaded.study.vehicle().powertrain.carriers();
            assert_eq!(stores.collect::<Vec<_>>(), declared, "{}", vehicle.name);
        }
    }
}

#[test]
fn records_say_their_route_and_the_answer_has_each() {
    let text = |km: u32| format!("position_m,speed_limit_kmh\n0,80\n{},80\n", 1000 * km);
    let folder = folder();
    let files: Vec<_> = [2, 4, 3]
        .iter()
        .map(|km| {
            let file = folder.path().join(format!("of-{km}.csv"));
            std::fs::write(&file, text(*km)).unwrap();
            file
        })
        .collect();
    let loaded = studies::load("field-truck", &[] as &[&str]).unwrap();
    let drawn = run(&loaded.study, 2);
    assert!(drawn.iter().all(|record| record.route_id.is_none()));
    let study = loaded.on_routes(&files, &[], RouteOptions::default()).unwrap().study;
    let records = run(&study, 60);
    for record in &records {
        let km = [2.0, 4.0, 3.0][record.route_id.unwrap() as usize];
        assert!((record.distance_m / 1000.0 - km).abs() < 0.01, "{record:?}");
    }
    let mut fleet = SummaryBuilder::default();
    fleet.add(&records);
    let routes = fleet.finish().routes;
    let trips: Vec<u64> = (0..3)
        .map(|id| records.iter().filter(|record| record.route_id == Some(id)).count() as u64)
        .collect();
    assert_eq!(routes.iter().map(|route| route.cycles).collect::<Vec<_>>(), trips);
}

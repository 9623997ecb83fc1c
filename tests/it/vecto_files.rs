//! `ocmc vecto`: the truck of VECTO's own files on VECTO's own speed, and driven by VECTO's driver.

use crate::others_data::shared;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn vecto(arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_ocmc");
    Command::new(program).arg("vecto").args(arguments).output().unwrap()
}

fn answer(arguments: &[&str]) -> Value {
    let output = vecto(&[arguments, &["--json"]].concat());
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{complaint}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn number(value: &Value, path: &str) -> f64 {
    value.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}: {value}"))
}

#[test]
fn on_vectos_speed_wheel_work_and_fuel_are_vectos() {
    let Some(job) = shared("vecto/results/declaration_40t/40t_Long_Haul_Truck.vecto") else {
        return;
    };
    let answer = answer(&[job.to_str().unwrap()]);
    let comparisons = answer["comparisons"].as_array().unwrap();
    let masses: Vec<f64> = comparisons.iter().map(|c| number(c, "/gross_mass_kg")).collect();
    assert_eq!(masses, [40_000.0, 33_900.0, 14_600.0, 27_500.0]);
    for compared in comparisons {
        let apart = |term: &str| {
            let ours = number(compared, &format!("/runs/0/terms/{term}"));
            (ours / number(compared, &format!("/vecto/{term}")) - 1.0).abs()
        };
        let name = &compared["mission"];
        assert!(apart("wheel_j") < 0.003 && apart("fuel_kg") < 0.01, "{name}");
        assert!(apart("air_j") < 0.003 && apart("rolling_j") < 0.003, "{name}");
        // VECTO counts no loss behind the gearbox while it shifts: here axle and retarder turn on
        assert!(apart("transmission_j") < 0.06, "{name}: {}", apart("transmission_j"));
        assert_eq!(apart("shifts"), 0.0, "{name}");
        // the causes are the whole difference
        let named = ["air", "rolling", "transmission", "auxiliaries", "brakes", "engine_map"];
        let cause = |name: &str| number(compared, &format!("/attribution/{name}"));
        let named: f64 = named.into_iter().map(cause).sum();
        assert!((named + cause("rest") - cause("with_its_gears")).abs() < 1e-12);
        assert!(cause("rest").abs() < 0.01 && cause("engine_map").abs() < 0.003, "{name}");
    }
}

#[test]
fn what_is_no_job_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.vecto");
    let said = |text: &str| {
        std::fs::write(&file, text).unwrap();
        let output = vecto(&[file.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(1));
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(said("{").contains("a.vecto"));
    let lacking = said("{\"Body\": {}}");
    assert!(lacking.contains("VehicleFile"), "{lacking}");
    let lac = "\"LAC\": {\"Enabled\": false}, \"OverSpeedEcoRoll\": {\"Mode\": \"Off\"}";
    let names = "\"VehicleFile\": \"no.vveh\", \"EngineFile\": \"b\", \"GearboxFile\": \"c\"";
    let text = said(&format!("{{\"Body\": {{{names}, {lac}}}}}"));
    assert!(text.contains("no.vveh"), "{text}");
    let output = vecto(&["tractor-40t-vecto"]);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(text.contains("--result"), "{text}");
}

#[test]
fn a_mission_without_a_row_in_the_sums_is_named_with_those_that_have_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let sums = "Job [-],Cycle [-],Mass [kg],Loading [kg],time [s],distance [km],FC-Map [g/h],E_air \
                [kWh],\
                E_roll [kWh],E_brake [kWh],E_aux_sum [kWh],E_gbx_axl_loss [kWh],E_ret_loss \
                [kWh],E_fcmap_pos [kWh]\n\
                1-1,Long Haul.vdri,15729,19300,4600,100.2,22960,80,90,5,6,10,1,200\n";
    std::fs::write(path("found.vsum"), sums).unwrap();
    std::fs::write(path("LongHall.vdri"), "<s>,<v>,<grad>,<stop>\n0,80,0,0\n").unwrap();
    let output =
        vecto(&["tractor-40t-vecto", &path("LongHall.vdri"), "--result", &path("found.vsum")]);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(text.contains("LongHall.vdri") && text.contains("it has `Long Haul.vdri`"), "{text}");
}

/// The missions of these names, as arguments.
fn with_missions(job: &Path, missions: &[PathBuf]) -> Value {
    let texts: Vec<&str> =
        std::iter::once(job).chain(missions.iter().map(PathBuf::as_path)).map(text_of).collect();
    answer(&texts)
}

fn text_of(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// The run of VECTO's driver.
fn by_its_driver(compared: &Value) -> &Value {
    let runs = compared["runs"].as_array().unwrap();
    let found = runs.iter().find(|run| run["driven"] == "its driver");
    found.unwrap_or_else(|| panic!("{}", compared["mission"]))
}

#[test]
fn vectos_driver_drives_vectos_missions() {
    let Some(job) = shared("vecto/results/declaration_40t/40t_Long_Haul_Truck.vecto") else {
        return;
    };
    let missions = ["LongHaul", "RegionalDelivery"]
        .map(|name| shared(&format!("vecto/cycles/{name}.vdri")).unwrap());
    let answer = with_missions(&job, &missions);
    let comparisons = answer["comparisons"].as_array().unwrap();
    assert_eq!(comparisons.len(), 4);
    for compared in comparisons {
        let (name, run) = (&compared["mission"], by_its_driver(compared));
        let apart = |term: &str| {
            let theirs = number(compared, &format!("/vecto/{term}"));
            (number(run, &format!("/terms/{term}")) / theirs - 1.0).abs()
        };
        assert!(apart("fuel_kg") < 0.006 && apart("duration_s") < 0.002, "{name}");
        // over the same distance shifts are as many as shifts per km
        assert!(apart("distance_m") < 0.001 && apart("shifts") < 0.02, "{name}");
        // coasting before stops and on bumps of overspeed is VECTO's
        assert!(number(run, "/speed/rms_kmh") < 0.25 && run["speed"]["covers"] == true, "{name}");
    }
    // our own driver stands beside it
    assert!(comparisons.iter().all(|c| c["runs"][3]["driven"] == "our driver"));
}

#[test]
fn vectos_driver_drives_vectos_manoeuvres() {
    let Some(cycles) = shared("vecto/results/manoeuvre_cycles") else { return };
    let files = std::fs::read_dir(cycles).unwrap().map(|entry| entry.unwrap().path());
    let missions: Vec<PathBuf> = files.collect();
    let (mut far, mut all) = (Vec::new(), 0);
    for folder in ["manoeuvres_40t", "manoeuvres_40t_overspeed"] {
        let job = shared(&format!("vecto/results/{folder}/40t_Long_Haul_Truck.vecto")).unwrap();
        let answer = with_missions(&job, &missions);
        for compared in answer["comparisons"].as_array().unwrap() {
            let speed = &by_its_driver(compared)["speed"];
            all += 1;
            if !(number(speed, "/rms_kmh") < 0.3 && speed["covers"] == true) {
                far.push(compared["mission"].clone());
            }
        }
    }
    assert!(all == 35 && far.is_empty(), "{all}: {far:?}");
}

#[test]
fn the_default_truck_takes_what_vecto_3_says() {
    let Some(sums) = shared("vecto/class5_tractor/Class5_Tractor_DECL.vsum") else { return };
    let missions = ["class5_tractor/LongHaul.vdri.gz", "cycles/RegionalDelivery.vdri"]
        .map(|name| shared(&format!("vecto/{name}")).unwrap());
    let [long_haul, regional] = &missions;
    let answer = answer(&[
        "tractor-40t-vecto",
        text_of(long_haul),
        text_of(regional),
        "--result",
        text_of(&sums),
    ]);
    let comparisons = answer["comparisons"].as_array().unwrap();
    assert_eq!(comparisons.len(), 3);
    for compared in comparisons {
        let (name, run) = (&compared["mission"], by_its_driver(compared));
        let of = |terms: &Value, term: &str| match term {
            "gearbox_axle_j" => number(terms, "/transmission_j") - number(terms, "/retarder_j"),
            term => number(terms, &format!("/{term}")),
        };
        let apart = |term: &str| of(&run["terms"], term) / of(&compared["vecto"], term) - 1.0;
        for term in [
            "air_j",
            "rolling_j",
            "brake_j",
            "auxiliary_j",
            "gearbox_axle_j",
            "retarder_j",
            "engine_j",
        ] {
            assert!(apart(term).abs() < 0.05, "{name} {term}: {}", apart(term));
        }
        assert!(apart("fuel_kg").abs() < 0.03 && apart("duration_s").abs() < 0.01, "{name}");
    }
}

/// The generic delivery truck as it was published: shares of axles that the declaration mode knows,
/// maps with fewer cells than names, names with `in Nm`, sums of VECTO 2.2, a gap of 2 s.
#[test]
fn the_unchanged_delivery_truck_is_driven_as_vecto_drove_it() {
    let Some(job) = shared("vecto/results/vehicle_12t/12t_Delivery_Truck.vecto") else { return };
    let sums = shared("vecto/results/vehicle_12t/12t_Delivery_Truck.vsum").unwrap();
    let missions = ["LongHaul", "RegionalDelivery"]
        .map(|name| shared(&format!("vecto/cycles/{name}.vdri")).unwrap());
    let [long, regional] = missions.each_ref().map(|mission| text_of(mission));
    let answer = answer(&[text_of(&job), long, regional, "--result", text_of(&sums)]);
    let comparisons = answer["comparisons"].as_array().unwrap();
    assert_eq!(comparisons.len(), 6);
    for compared in comparisons {
        let run = by_its_driver(compared);
        let apart = |term: &str| {
            let theirs = number(compared, &format!("/vecto/{term}"));
            (number(run, &format!("/terms/{term}")) / theirs - 1.0).abs()
        };
        let name = &compared["mission"];
        assert!(apart("fuel_kg") < 0.015 && apart("duration_s") < 0.01, "{name}");
        assert!(apart("air_j") < 0.01 && apart("rolling_j") < 0.015, "{name}");
    }
}

/// A job with the files beside it, one of which is changed.
fn changed_job(folder: &Path, change: impl Fn(&str, String) -> String) -> Option<PathBuf> {
    let job = shared("vecto/40t_tractor/40t_Long_Haul_Truck.vecto")?;
    for entry in std::fs::read_dir(job.parent().unwrap()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(folder.join(&name), change(&name, text)).unwrap();
    }
    Some(folder.join(job.file_name().unwrap()))
}

/// The vehicle that a job is.
fn vehicle_of(job: &Path) -> ocmc_core::vehicle::VehicleModel {
    let set = format!("vehicle.base={}", text_of(job));
    ocmc_api::study::load("field-truck", &[set]).unwrap().model.vehicle
}

#[test]
fn a_drag_area_over_speed_is_that_of_its_table() {
    let folder = tempfile::tempdir().unwrap();
    let changed = changed_job(folder.path(), |name, text| {
        if name != "40t_Long_Haul_Truck.vveh" {
            return text;
        }
        let text = text.replace("\"CdOfVdecl\"", "\"CdOfVeng\"").replace("<NOFILE>", "truck.vcdv");
        // declaration mode has no such table
        let text = text.replace("\"SavedInDeclMode\": true", "\"SavedInDeclMode\": false");
        text.replace("\"AxleWeightShare\": 0.0", "\"AxleWeightShare\": 0.5")
    });
    let Some(job) = changed else { return };
    // factors as VECTO's manual has them: one up to 60 km/h, falling above
    let rows = [(0, 1.173), (30, 1.173), (60, 1.173), (65, 1.153), (70, 1.136), (80, 1.109)];
    let rows = rows.iter().chain(&[(90, 1.09), (100, 1.075)]);
    let lines = rows.clone().map(|(speed, factor)| format!("{speed},{factor}"));
    let lines: Vec<String> = lines.collect();
    let write = |names: &str| {
        let table = format!("{names}\n{}", lines.join("\n"));
        std::fs::write(folder.path().join("truck.vcdv"), table).unwrap();
    };
    write("v_veh [km/h],Cd [-]");
    let vehicle = vehicle_of(&job);
    // VECTO 2.2 goes by the places of the columns
    write("v_veh [km/h],cdx_rel (v_veh) [-]");
    assert_eq!(vehicle_of(&job), vehicle);
    let by_speed = vehicle.drag_by_speed.unwrap();
    let serde_json::Value::Number(drag) = serde_json::to_value(&vehicle.drag_area_m2).unwrap()
    else {
        panic!("a number");
    };
    for (kmh, factor) in rows {
        let speed_mps = f64::from(*kmh) / 3.6;
        let found = drag.as_f64().unwrap() / 6.2985 * by_speed.prepare().factor(speed_mps);
        assert!((found / factor - 1.0).abs() < 0.005, "{kmh}: {found} {factor}");
    }
}

#[test]
fn a_job_of_vecto_3_opens_and_what_it_does_not_say_follows() {
    let folder = tempfile::tempdir().unwrap();
    let changed = changed_job(folder.path(), |name, text| match name.rsplit('.').next() {
        Some("vgbx") => text.replace("\"SkipGears\"", "\"Skip\"").replace("EaryShiftUp", "Early"),
        Some("vecto") => {
            text.replace("\"Dec\"", "\"DF_offset\"").replace("\"MinSpeed\"", "\"Min\"")
        }
        _ => text,
    });
    let Some(job) = changed else { return };
    let original = shared("vecto/40t_tractor/40t_Long_Haul_Truck.vecto").unwrap();
    assert_eq!(vehicle_of(&job), vehicle_of(&original));
    let mission = shared("vecto/cycles/RegionalDelivery.vdri").unwrap();
    let folder = shared("vecto/results/declaration_40t").unwrap();
    let result = folder.join("40t_Long_Haul_Truck_Regional_Delivery_Reference_Loading.vmod.gz");
    let asked = [text_of(&job), text_of(&mission), "--result", text_of(&result)];
    let compared = answer(&asked);
    let run = by_its_driver(&compared["comparisons"][0]);
    assert!(number(run, "/terms/fuel_kg") > 3.0);
}

//! The built-in studies: that they are valid, and that nothing in them is out of the tables.

use ocmc_core::distribution::{Law, Quantity};
use ocmc_core::study::keys::{Key, declarations};
use ocmc_core::study::{Study, StudyModel};
use ocmc_core::vehicle::VehicleModel;
use ocmc_io::study::{self, LoadedStudy, Origin};
use serde_json::Value;

fn load(name: &str) -> LoadedStudy {
    study::load::<&str>(name, &[]).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn model(name: &str) -> StudyModel {
    load(name).model
}

/// Calls `visit` with the path, without indices, of every number; a law counts as one.
fn numbers(path: &str, value: &Value, visit: &mut impl FnMut(&str)) {
    match value {
        Value::Object(table) if table.contains_key("distribution") => visit(path),
        Value::Object(table) => {
            for (key, value) in table {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                numbers(&path, value, visit);
            }
        }
        Value::Array(items) => items.iter().for_each(|item| numbers(path, item, visit)),
        Value::Number(_) => visit(path),
        Value::Null => panic!("`{path}` is null"),
        Value::Bool(_) | Value::String(_) => {}
    }
}

#[test]
fn every_built_in_study_is_valid_and_described() {
    for built_in in study::list() {
        let loaded = load(built_in.name);
        assert_eq!(loaded.model.study.name, built_in.name);
        assert_eq!(loaded.model.study.description, built_in.description());
        assert_eq!(loaded.origin, Origin::BuiltIn(built_in.name.to_owned()));
        assert!(!loaded.model.study.sources.is_empty(), "{}", built_in.name);
        assert_eq!(study::show(built_in.name).expect("a built-in name"), built_in.text);
    }
}

#[test]
fn every_number_has_a_bound() {
    let declared = declarations();
    for built_in in study::list() {
        let tree = serde_json::to_value(model(built_in.name)).expect("a study");
        let mut count = 0;
        numbers("", &tree, &mut |path| {
            count += 1;
            let bounds = Key(declared).at(path).and_then(Key::bounds);
            assert!(bounds.is_some(), "{}: `{path}` has no bound", built_in.name);
        });
        assert!(count > 200, "{count}");
    }
}

/// The truck of the driving-simulator studies.
fn simulated() -> VehicleModel {
    let text = "study = { name = \"v\", description = \"d\", base = \"field-truck\" }\n\
                vehicle.base = \"tractor-40t-vecto\"\n";
    study::load_text("v.toml", text, &[] as &[&str]).expect("built in").model.vehicle
}

#[test]
fn built_in_powertrains_of_a_tractor_have_one_body() {
    let vehicle = |base: &str| {
        let text = format!(
            "study = {{ name = \"v\", description = \"d\", base = \"field-truck\" }}\n\
             vehicle.base = \"{base}\"\n"
        );
        study::load_text("v.toml", &text, &[] as &[&str]).expect("built in").model.vehicle
    };
    let diesel = vehicle("tractor-40t");
    for base in ["tractor-electric-40t", "tractor-fuel-cell-40t"] {
        let other = vehicle(base);
        assert_eq!(other.drag_area_m2, diesel.drag_area_m2, "{base}");
        assert_eq!(other.cross_wind, diesel.cross_wind, "{base}");
        assert_eq!(other.rolling_factor, diesel.rolling_factor, "{base}");
        let tyres = |vehicle: &VehicleModel| -> Vec<(f64, f64, f64)> {
            let axles = vehicle.axles.iter();
            axles.map(|a| (a.load_share, a.iso_rolling_coefficient, a.iso_load_n)).collect()
        };
        assert_eq!(tyres(&other), tyres(&diesel), "{base}");
    }
}

#[test]
fn studies_differ_from_the_default_one_only_where_they_say_so() {
    let default = model("field-truck");
    for built_in in study::list() {
        let model = model(built_in.name);
        if ["battery-truck", "electric-regional", "electric-long-haul"].contains(&built_in.name) {
            assert!(model.vehicle.powertrain.battery_electric().is_some());
        } else if built_in.name == "fuel-cell-truck" {
            assert_eq!(model.vehicle.powertrain.carriers().len(), 2);
        } else if built_in.name == "passenger-car" {
            assert!(
                model.vehicle.curb_mass_kg < 3500.0
                    && model.vehicle.powertrain.combustion().is_some()
            );
        } else if built_in.name == "simulator-study" {
            // no retarder, and the engine that the paper's accelerations ask for
            assert_eq!(model.vehicle.brakes.engine_brake_power_w, 0.0);
            assert_ne!(model.vehicle.powertrain, simulated().powertrain);
        } else if built_in.name.starts_with("simulator-") {
            let mut vehicle = model.vehicle.clone();
            assert_eq!(vehicle.brakes.engine_brake_power_w, 0.0);
            vehicle.brakes = simulated().brakes;
            assert_eq!(vehicle, simulated(), "{}", built_in.name);
        } else {
            assert_eq!(model.vehicle, default.vehicle, "{}", built_in.name);
        }
        assert_eq!(model.weather, default.weather, "{}", built_in.name);
        // the virtual simulator has finer steps, still air and an empty road
        if !["simulator-slopes", "simulator-study"].contains(&built_in.name) {
            assert_eq!(model.simulation, default.simulation, "{}", built_in.name);
        }
    }
    assert_eq!(model("field-truck-loaded").road, default.road);
    assert_eq!(model("regional").driver, default.driver);
    assert_ne!(model("long-haul").road, default.road);
    let urban = model("urban-delivery");
    assert_eq!(urban.road.types.keys().collect::<Vec<_>>(), ["urban"]);
    assert!(urban.mission.stops.is_some());
    assert!(model("simulator-truck").driver.curve_speed.table.is_none());
}

#[test]
fn a_dictionary_has_the_same_shape_as_a_file() {
    let dictionary = serde_json::json!({
        "study": { "base": "field-truck", "name": "mine" },
        "mission": { "length_m": 50_000 },
        "vehicle": { "drag_area_m2": { "median": 4.6 } },
    });
    let loaded = study::load_json::<&str>(&dictionary, &[]).expect("a study");
    let text = "study = { base = \"field-truck\", name = \"mine\" }\nmission.length_m = 50_000\n\
                vehicle.drag_area_m2.median = 4.6\n";
    assert_eq!(loaded.model, study::load_text::<&str>("a.toml", text, &[]).expect("a study").model);
    assert_eq!(loaded.origin, Origin::Dictionary);
    let whole = serde_json::to_value(&loaded.model).expect("a study");
    assert_eq!(study::load_json::<&str>(&whole, &[]).expect("a study").model, loaded.model);
}

#[test]
fn settings_win_over_the_file_and_later_ones_over_earlier_ones() {
    let text = "study.base = \"field-truck\"\nmission.length_m = 50e3\n";
    let load = |sets: &[&str]| study::load_text("a.toml", text, sets).expect("a study").model;
    assert_eq!(load(&[]).mission.length_m, 50e3.into());
    assert_eq!(load(&["mission.length_m=60e3"]).mission.length_m, 60e3.into());
    let sets = ["mission.length_m=60e3", "mission.length_m=70000"];
    assert_eq!(load(&sets).mission.length_m, 70e3.into());
    let stops = load(&["mission.stops.spacing_m=5e3", "mission.stops.dwell_s=60"]).mission.stops;
    assert_eq!(stops.expect("stops").dwell_s, 60.0.into());
    let axles = load(&["vehicle.axles.1.tyres=2"]).vehicle.axles;
    assert_eq!(axles.iter().map(|axle| axle.tyres).collect::<Vec<_>>(), [2.0; 5]);
    assert_eq!(load(&["study.base=long-haul"]).mission.length_m, 50e3.into());
}

#[test]
fn bases_are_files_beside_the_study_or_built_in() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("a file");
        path.display().to_string()
    };
    write("truck.toml", study::show("tractor-40t").expect("built in"));
    let ours =
        "study.base = \"regional\"\nvehicle = { base = \"truck.toml\", curb_mass_kg = 15000 }\n";
    write("ours.toml", ours);
    let mine = |road_type: &str| {
        let drop = format!("[\"road.types.{road_type}.truck_limit_mps\"]");
        let path =
            write("mine.toml", &format!("study = {{ base = \"ours.toml\", drop = {drop} }}\n"));
        study::load::<&str>(&path, &[])
    };
    let error = mine("urban").expect_err("nothing to drop").to_string();
    assert!(error.contains("`study.drop` names `road.types.urban.truck_limit_mps`"), "{error}");
    let mine = mine("rural").unwrap_or_else(|error| panic!("{error}")).model;
    assert!((mine.vehicle.curb_mass_kg - 15_000.0).abs() < 1e-9);
    assert_eq!(mine.mission, model("regional").mission);
    assert_eq!(mine.road.types["rural"].truck_limit_mps, None);
}

#[test]
fn every_built_in_study_uses_only_keys_of_the_schema() {
    fn check(path: &str, file: &toml::Table, schema: &Value) {
        for (key, value) in file {
            let path = format!("{path}.{key}");
            let below = match &schema["properties"][key] {
                Value::Null => &schema["additionalProperties"],
                property => property,
            };
            assert!(below.is_object(), "{path}");
            if let (toml::Value::Table(table), Some("object")) = (value, below["type"].as_str()) {
                check(&path, table, below);
            }
        }
    }
    let schema = study::schema();
    for built_in in study::list() {
        check("", &built_in.text.parse().expect("TOML"), &schema);
    }
    for vehicle in study::builtin::VEHICLES {
        let table: toml::Table = vehicle.text.parse().expect("TOML");
        check("vehicle", &table, &schema["properties"]["vehicle"]);
    }
    // what may be absent is described, too
    let vehicle = &schema["properties"]["vehicle"]["properties"];
    let powertrain = &vehicle["powertrain"]["properties"];
    let motor = &powertrain["battery_electric"]["properties"]["motor"]["properties"];
    assert_eq!(motor["brake_share"]["maximum"], 1.0);
    let engine = &powertrain["combustion"]["properties"]["engine"]["properties"];
    assert_eq!(engine["torque_lag_s"]["minimum"], 0.2);
}

#[test]
fn the_core_refuses_an_optional_end_that_is_no_number() {
    let mut model = model("field-truck");
    let (mean, sd, lower, upper) = (1.0, 0.1, Some(f64::NAN), None);
    model.driver.speed_limit.compliance = Quantity::Law(Law::Normal { mean, sd, lower, upper });
    let error = Study::new(model).expect_err("nan").to_string();
    assert!(error.contains("driver.speed_limit.compliance"), "{error}");
}

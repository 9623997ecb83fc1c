//! Jobs of VECTO as they were published: what opens by VECTO's own rules, what is refused and why,
//! and what is said of values that are not used.

use crate::others_data::shared;
use ocmc_core::vehicle::VehicleModel;
use ocmc_io::study::{Files, Given, LoadedStudy, StudyFileError, open};
use ocmc_vecto::driver::LookAhead;
use ocmc_vecto::file::{Job, VEHICLES};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// VECTO's generic 40 t truck in a folder of its own, the files of which can be changed.
struct Tree {
    folder: TempDir,
}

impl Tree {
    /// None where the files are not there.
    fn new() -> Option<Self> {
        let job = shared("vecto/40t_tractor/40t_Long_Haul_Truck.vecto")?;
        let folder = tempfile::tempdir().unwrap();
        for entry in std::fs::read_dir(job.parent().unwrap()).unwrap() {
            let path = entry.unwrap().path();
            let bytes = std::fs::read(&path).unwrap();
            std::fs::write(folder.path().join(path.file_name().unwrap()), bytes).unwrap();
        }
        Some(Self { folder })
    }

    fn path(&self, ending: &str) -> PathBuf {
        self.folder.path().join(format!("40t_Long_Haul_Truck.{ending}"))
    }

    /// The same with one of its files changed: `change` gets its header and its body.
    fn with(self, ending: &str, change: impl Fn(&mut Value, &mut Value)) -> Self {
        let path = self.path(ending);
        let text = std::fs::read_to_string(&path).unwrap();
        let mut file: Value = serde_json::from_str(text.trim_start_matches('\u{feff}')).unwrap();
        let (mut header, mut body) = (file["Header"].take(), file["Body"].take());
        change(&mut header, &mut body);
        let file = json!({ "Header": header, "Body": body });
        std::fs::write(path, file.to_string()).unwrap();
        self
    }

    fn job(&self) -> Job {
        Job::read(&self.path("vecto")).unwrap()
    }

    fn refused(&self) -> String {
        Job::read(&self.path("vecto")).unwrap_err().to_string()
    }

    fn vehicle(&self) -> VehicleModel {
        study(&self.path("vecto")).unwrap().model.vehicle
    }
}

/// A study with the truck of a job.
fn study(job: &Path) -> Result<LoadedStudy, StudyFileError> {
    let set = format!("vehicle.base={}", job.display());
    let files = Files::here().reading(VEHICLES);
    open(&Given::Named(Path::new("field-truck")), &files, &[set])
}

fn remove(of: &mut Value, key: &str) {
    of.as_object_mut().unwrap().remove(key);
}

/// Makes a vehicle one of the engineering mode, with shares of its axles.
fn engineering(_: &mut Value, vehicle: &mut Value) {
    vehicle["SavedInDeclMode"] = false.into();
    for axle in vehicle["AxleConfig"]["Axles"].as_array_mut().unwrap() {
        axle["AxleWeightShare"] = 0.5.into();
    }
}

#[test]
fn a_declared_job_of_vecto_3_has_vectos_own_driver_and_radius() {
    let Some(tree) = Tree::new() else { return };
    let unchanged = tree.vehicle();
    let tree = tree
        .with("vecto", |_, job| {
            remove(job, "LAC");
            remove(job, "VACC");
        })
        .with("vveh", |_, vehicle| vehicle["rdyn"] = 0.0.into());
    let driver = tree.job().driver().clone();
    let minimum_speed_mps = 50.0 / 3.6;
    assert_eq!(driver.look_ahead, Some(LookAhead::DecisionFactor { minimum_speed_mps }));
    assert_eq!(driver.opposite_shift_time_s, 10.0);
    let vehicle = tree.vehicle();
    // 315/70 R22.5 in VECTO's table
    assert!((vehicle.wheel_radius_m - 0.4922).abs() < 5e-5, "{}", vehicle.wheel_radius_m);
    assert_eq!(VehicleModel { wheel_radius_m: unchanged.wheel_radius_m, ..vehicle }, unchanged);
    assert!(tree.job().notes().is_empty(), "{:?}", tree.job().notes());
    // the radius of a size that is not in the table, and in engineering mode, is not guessed
    let odd = tree.with("vveh", |_, vehicle| {
        vehicle["AxleConfig"]["Axles"][1]["Wheels"] = "1/2 R3".into();
    });
    assert!(odd.refused().contains("`rdyn` is missing"), "{}", odd.refused());
    let engineering = odd.with("vveh", |header, vehicle| {
        engineering(header, vehicle);
        vehicle["AxleConfig"]["Axles"][1]["Wheels"] = "315/70 R22.5".into();
    });
    assert!(engineering.refused().contains("`rdyn` is missing"), "{}", engineering.refused());
}

#[test]
fn vecto_2_keeps_its_window_and_waits_with_no_shift() {
    let Some(tree) = Tree::new() else { return };
    let driver = tree.job().driver().clone();
    assert!(matches!(driver.look_ahead, Some(LookAhead::Window { .. })), "{driver:?}");
    assert_eq!(driver.opposite_shift_time_s, 0.0);
    // factors beside it mean VECTO 3, and other ones than its own are said not to be used
    let three = tree.with("vecto", |_, job| {
        job["LAC"]["DF_offset"] = 4.0.into();
        job["LAC"]["DF_scaling"] = 1.5.into();
    });
    let job = three.job();
    assert!(matches!(job.driver().look_ahead, Some(LookAhead::DecisionFactor { .. })));
    assert_eq!(job.notes().len(), 1);
    assert!(job.notes()[0].contains("`DF_offset` 4"), "{:?}", job.notes());
    // what the gearbox says wins, in the spelling of VECTO 3's own files too
    let said = three.with("vgbx", |_, gearbox| gearbox["DownshiftAferUpshiftDelay"] = 6.0.into());
    assert_eq!(said.job().driver().opposite_shift_time_s, 6.0);
}

#[test]
fn an_efficiency_stands_for_a_loss_map_and_a_number_for_a_type() {
    let Some(tree) = Tree::new() else { return };
    let tree = tree.with("vgbx", |_, gearbox| {
        gearbox["GearboxType"] = 1.into();
        for (k, gear) in gearbox["Gears"].as_array_mut().unwrap().iter_mut().enumerate() {
            remove(gear, "LossMap");
            // as a number and as a text
            gear["Efficiency"] = if k == 0 { 0.95.into() } else { "0.98".into() };
        }
    });
    let vehicle = serde_json::to_value(tree.vehicle()).unwrap();
    let gearbox = &vehicle["powertrain"]["combustion"]["gearbox"];
    let number = |key: &str| gearbox[key].as_f64().unwrap();
    assert!((number("axle_loss_share") - 0.05).abs() < 1e-9, "{gearbox}");
    assert!((number("indirect_loss_share") - 0.02).abs() < 1e-9, "{gearbox}");
    assert!(number("loss_torque_nm") == 0.0 && number("axle_loss_torque_nm") == 0.0);
    let none = tree.with("vgbx", |_, gearbox| remove(&mut gearbox["Gears"][3], "Efficiency"));
    assert!(none.refused().contains("`LossMap` or `Efficiency` is missing"), "{}", none.refused());
    // a torque converter is named, whatever its gears lack
    for (kind, name) in [(json!(2), "`AT`"), (json!("ATPowerSplit"), "`ATPOWERSPLIT`")] {
        let converter = Tree::new().unwrap().with("vgbx", |_, gearbox| {
            gearbox["GearboxType"] = kind.clone();
            remove(&mut gearbox["Gears"][1], "LossMap");
        });
        let text = converter.refused();
        assert!(text.contains(name) && text.contains("torque converter"), "{text}");
    }
}

#[test]
fn a_gearbox_of_one_gear_starts_in_it() {
    let Some(tree) = Tree::new() else { return };
    let tree = tree.with("vgbx", |_, gearbox| {
        gearbox["Gears"].as_array_mut().unwrap().truncate(2);
    });
    let vehicle = serde_json::to_value(tree.vehicle()).unwrap();
    let gearbox = &vehicle["powertrain"]["combustion"]["gearbox"];
    assert_eq!(gearbox["ratio"].as_array().unwrap().len(), 1);
}

#[test]
fn declaration_mode_needs_no_table_of_drag_and_may_be_unsaid() {
    let Some(tree) = Tree::new() else { return };
    let unchanged = tree.vehicle();
    let tree = tree.with("vveh", |_, vehicle| {
        vehicle["CdCorrMode"] = "CdOfV".into();
        vehicle["CdCorrFile"] = "not there.vcdv".into();
        // files until 2.0.1 do not say it; their shares are 0
        remove(vehicle, "SavedInDeclMode");
    });
    assert_eq!(tree.vehicle(), unchanged);
    let warnings = study(&tree.path("vecto")).unwrap().warnings();
    assert!(warnings.iter().any(|text| text.contains("`CdCorrMode` `CdOfV`")), "{warnings:?}");
    // in engineering mode the table is asked for
    let engineered = tree.with("vveh", engineering);
    let text = study(&engineered.path("vecto")).unwrap_err().to_string();
    assert!(text.contains("not there.vcdv"), "{text}");
}

#[test]
fn an_engine_of_vecto_2_0_has_its_curve_and_other_fuels_are_refused() {
    let Some(tree) = Tree::new() else { return };
    let unchanged = tree.vehicle();
    let tree = tree.with("veng", |_, engine| {
        let path = engine["FullLoadCurve"].take();
        remove(engine, "FullLoadCurve");
        engine["FullLoadCurves"] = json!([{ "Path": path, "Gears": "0 - 99" }]);
    });
    assert_eq!(tree.vehicle(), unchanged);
    let two = tree.with("veng", |_, engine| {
        let curve = engine["FullLoadCurves"][0].clone();
        engine["FullLoadCurves"].as_array_mut().unwrap().push(curve);
    });
    assert!(two.refused().contains("the number of `FullLoadCurves`"), "{}", two.refused());
    for fuel in [json!(3), json!("NG CI")] {
        let other = Tree::new().unwrap().with("veng", |_, e| e["FuelType"] = fuel.clone());
        assert!(other.refused().contains("`FuelType` is"), "{}", other.refused());
    }
    // a list of one fuel is that of newer files
    let listed = Tree::new().unwrap().with("veng", |_, engine| {
        let map = engine["FuelMap"].take();
        remove(engine, "FuelMap");
        engine["Fuels"] = json!([{ "FuelType": "Diesel CI", "FuelMap": map }]);
        engine["WHRType"] = "MechanicalOutputDrivetrain".into();
    });
    assert_eq!(listed.vehicle(), unchanged);
    assert!(listed.job().notes()[0].contains("no waste heat"), "{:?}", listed.job().notes());
    let hydrogen = listed.with("veng", |_, e| e["Fuels"][0]["FuelType"] = "H2 PI".into());
    assert!(hydrogen.refused().contains("H2 PI"), "{}", hydrogen.refused());
}

#[test]
fn the_auxiliaries_of_the_engineering_mode_are_taken() {
    let Some(tree) = Tree::new() else { return };
    let declared = tree.vehicle();
    let padded = tree.with("vecto", |_, job| job["Padd"] = 5000.0.into());
    assert_eq!(padded.vehicle(), declared, "declaration mode has them by technology");
    let padded = padded.with("vveh", engineering);
    let vehicle = serde_json::to_value(padded.vehicle()).unwrap();
    assert_eq!(vehicle["auxiliary_power_w"], 5000.0);
    let said = |tree: &Tree, what: &str| {
        let warnings = study(&tree.path("vecto")).unwrap().warnings();
        // what is compared with a result has the auxiliaries of the result
        assert!(tree.job().notes().is_empty(), "{:?}", tree.job().notes());
        warnings.iter().any(|text| text.contains(what))
    };
    assert!(!said(&padded, "auxiliary_power_w` is set"));
    let none = padded.with("vecto", |_, job| remove(job, "Padd"));
    assert!(said(&none, "no `Padd`"));
    let bus = none.with("vecto", |_, job| job["AuxiliaryAssembly"] = "BusAuxiliaries".into());
    assert!(said(&bus, "`BusAuxiliaries`"));
}

#[test]
fn what_is_not_used_is_said_and_what_would_be_wrong_is_refused() {
    let Some(tree) = Tree::new() else { return };
    let tree = tree
        .with("vveh", |_, vehicle| {
            vehicle["PTO"] = json!({ "Type": "only one engaged gearwheel above oil level" });
            vehicle["TorqueLimits"] = json!({ "12": 1900.0 });
            vehicle["Angledrive"] = json!({ "Type": "None" });
        })
        .with("vgbx", |_, gearbox| {
            gearbox["TracInt"] = 10.0.into();
            gearbox["Gears"][3]["MaxTorque"] = "2500".into();
            gearbox["Gears"][4]["MaxSpeed"] = "".into();
        });
    let notes = tree.job().notes().join("\n");
    for said in
        ["`PTO`", "`TorqueLimits`", "`TracInt` 10", "`MaxTorque`", "40t_Long_Haul_Truck.vgbx"]
    {
        assert!(notes.contains(said), "{said}: {notes}");
    }
    assert_eq!(tree.job().driver().gap_s, 5);
    let angled = tree.with("vveh", |_, vehicle| {
        vehicle["Angledrive"] = json!({ "Type": "Separate Angledrive" });
    });
    assert!(angled.refused().contains("`Angledrive` is `Separate"), "{}", angled.refused());
    let staged = angled.with("vveh", |_, vehicle| {
        vehicle["VehCat"] = "HeavyBusPrimaryVehicle".into();
    });
    assert!(staged.refused().contains("`VehCat` is `HeavyBusPrimary"), "{}", staged.refused());
    // losses that the gearbox's maps include are not counted twice
    let apart = Tree::new().unwrap().vehicle();
    let included = Tree::new().unwrap().with("vveh", |_, vehicle| {
        vehicle["Retarder"]["Type"] = "LossesIncludedInTransmission".into();
    });
    let retarder = |vehicle: VehicleModel| {
        let vehicle = serde_json::to_value(vehicle).unwrap();
        vehicle["powertrain"]["combustion"]["gearbox"]["retarder_torque_nm"].as_f64().unwrap()
    };
    assert!(retarder(apart) > 0.0 && retarder(included.vehicle()) == 0.0);
}

#[test]
fn the_driven_axle_is_the_one_that_says_so() {
    let Some(tree) = Tree::new() else { return };
    let tree = tree.with("vveh", |_, vehicle| {
        vehicle["AxleConfig"]["Axles"][0]["Type"] = "VehicleDriven".into();
        vehicle["AxleConfig"]["Axles"][1]["Type"] = "VehicleNonDriven".into();
    });
    let vehicle = serde_json::to_value(tree.vehicle()).unwrap();
    assert_eq!(vehicle["axles"][0]["driven"], true);
    assert_ne!(vehicle["axles"][1]["driven"], true);
}

#[test]
fn accelerations_that_vecto_3_has_itself_need_no_file() {
    let Some(tree) = Tree::new() else { return };
    let own = tree.with("vecto", |_, job| job["VACC"] = "Truck.vacc".into());
    let declared = Tree::new().unwrap().job().driver().acceleration.clone();
    if !own.folder.path().join("Truck.vacc").exists() {
        assert_eq!(own.job().driver().acceleration, declared);
    }
    let other = own.with("vecto", |_, job| job["VACC"] = "Coach.vacc".into());
    assert!(other.refused().contains("Coach.vacc"), "{}", other.refused());
}

/// Jobs of other kinds are refused by the name of their kind, not by the first key that they lack.
#[test]
fn other_kinds_of_jobs_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.vecto");
    let said = |text: &str| {
        std::fs::write(&file, text).unwrap();
        Job::read(&file).unwrap_err().to_string()
    };
    let kinds: [(u32, Value, &str); 13] = [
        (2, json!({ "EngineOnlyMode": true, "VehicleFile": "<NOFILE>" }), "an engine alone"),
        (4, json!({ "DeclarationVehicle": "a.xml" }), "(VTP)"),
        (6, json!({}), "a single bus"),
        (7, json!({}), "a completed bus"),
        (10, json!({ "PrimaryVehicle": "a.xml" }), "a bus in stages"),
        (8, json!({}), "a parallel hybrid"),
        (11, json!({}), "a serial hybrid"),
        (13, json!({}), "(IHPC)"),
        (9, json!({}), "battery-electric"),
        (12, json!({}), "(IEPC)"),
        (14, json!({}), "a fuel-cell hybrid"),
        (16, json!({}), "several powertrains"),
        (17, json!({}), "`FileVersion` is 17"),
    ];
    for (version, body, kind) in kinds {
        let text = said(&json!({ "Header": { "FileVersion": version }, "Body": body }).to_string());
        assert!(text.contains("a.vecto") && text.contains(kind), "{kind}: {text}");
        assert!(text.contains("; allowed "), "{text}");
    }
    // by a key alone, too
    let text = said(&json!({ "Body": { "HybridStrategyParams": "a" } }).to_string());
    assert!(text.contains("a hybrid"), "{text}");
    // VECTO 1 wrote lines of text
    let text = said("\u{feff}V1.2\r\nveh.vveh\r\n");
    assert!(text.contains("no JSON, as of VECTO 1"), "{text}");
}

#[test]
fn vehicles_of_old_versions_are_refused_by_their_version() {
    for version in [json!(1), json!("1.0"), json!(2)] {
        let Some(tree) = Tree::new() else { return };
        let tree = tree.with("vveh", |header, _| header["FileVersion"] = version.clone());
        assert!(tree.refused().contains("`FileVersion` is"), "{}", tree.refused());
    }
}

//! `ocmc vecto`: the truck of VECTO's own files on VECTO's own speed.

use crate::common::shared;
use serde_json::Value;
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
    let output = vecto(&["tractor-40t"]);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(text.contains("--result"), "{text}");
}

//! Uncertain numbers of a study: what their errors do to the mean, by drives on both sides of them.

use crate::common::study;
use crate::program::{ocmc, run_into};
use ocmc_core::record::Record;
use ocmc_core::study::Study;
use ocmc_fleet::comparison::compare;
use ocmc_fleet::dependence::Dependence;
use ocmc_fleet::run::{RunPlan, records};
use ocmc_fleet::summary::{Summary, SummaryBuilder};
use ocmc_fleet::uncertainty::ParameterUncertainty;
use serde_json::Value;
use std::convert::Infallible;
use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::Path;

const ROAD: &str = "mission.length_m=6000";
const LAW: &str = "driver.curve_speed.parameter_uncertainty=true";

fn all(study: &Study, plan: &RunPlan) -> ControlFlow<Infallible, Vec<Record>> {
    records(study, plan, |_| ControlFlow::Continue(()))
}

#[test]
fn a_share_moves_along_the_simplex() {
    let cases: [(&str, &str, usize, &[f64]); 3] = [
        ("payload_kg", "", 0, &[0.2, 0.8]),
        ("payload_kg", ".1", 1, &[0.2, 0.8]),
        ("departure_s_of_day", ".0", 0, &[0.6, 0.3, 0.1]),
    ];
    for (law, place, moved, shares) in cases {
        let key = format!("mission.{law}.weights{place}");
        let set = format!("uncertainty.a={{ keys = [\"{key}\"], standard_errors = [0.05] }}");
        let study = study("field-truck", &[&set]);
        let keys = study.model().uncertain().expect("one number").keys;
        let sides = study.sides(&keys[0]).expect("both are allowed");
        assert_eq!(sides.apart, 2.0);
        for (side, by) in [(&sides.low, -0.05), (&sides.high, 0.05)] {
            let tree = side.model().to_tree();
            for (k, share) in shares.iter().enumerate() {
                let found = tree["mission"][law]["weights"][k].as_f64().expect("a number");
                let less = -by * share / (1.0 - shares[moved]);
                let wanted = share + if k == moved { by } else { less };
                assert!((found - wanted).abs() < 1e-12, "{key}: {found} for {wanted}");
            }
        }
    }
}

/// The summary of a run of short trips.
fn summary(sets: &[&str], cycles: u64) -> Summary {
    let study = study("field-truck", &[&[ROAD], sets].concat());
    let plan = RunPlan::new(1, 0, cycles, None, None);
    let mut fleet = SummaryBuilder::new(Dependence::of(study.model(), 1));
    let ControlFlow::Continue(driven) = all(&study, &plan);
    fleet.add(&driven);
    let mut summary = fleet.finish();
    let ControlFlow::Continue(()) = summary.add_uncertainty(&study, &plan, all);
    summary
}

fn uncertain(sets: &[&str], cycles: u64) -> ParameterUncertainty {
    summary(sets, cycles).parameter_uncertainty.expect("uncertain numbers")
}

fn half_width([low, high]: [f64; 2]) -> f64 {
    (high - low) / 2.0
}

/// Excess of the mean of a setting over that of another one, over the same cycles.
fn above(low: &str, high: &str, cycles: u64) -> f64 {
    let [low, high] = [low, high].map(|set| study("field-truck", &[ROAD, set]));
    let plan = RunPlan::new(1, 0, cycles, None, None);
    let compared =
        compare::<Infallible>(&[&low, &high], &plan, None, |_| ControlFlow::Continue(()));
    let ControlFlow::Continue(compared) = compared;
    compared.comparisons[0].difference.expect("pairs")
}

#[test]
fn an_effect_is_half_of_what_two_studies_differ_by() {
    let summary = summary(&[LAW], 200);
    let found = summary.parameter_uncertainty.clone().expect("the law is uncertain");
    let law = |value: &str| format!("driver.curve_speed.{value}");
    let sides = [
        // 0.540 ± 0.012, and 17.96 (1 ± 0.026) m/s
        ["exponent=0.528", "exponent=0.552"],
        ["reference_speed_mps=17.49304", "reference_speed_mps=18.42696"],
    ];
    let mut squares = 0.0;
    for (parameter, [low, high]) in found.parameters.iter().zip(sides) {
        let effect = above(&law(low), &law(high), 200) / 2.0;
        let found = parameter.effect.expect("pairs");
        assert!((found - effect).abs() < 1e-6 * effect.abs(), "{parameter:?} {effect}");
        squares += effect * effect - parameter.effect_standard_error.expect("pairs").powf(2.0);
    }
    assert!((found.sd * found.sd - squares).abs() < 1e-5 * squares, "{found:?} {squares}");
    // the run's own cycles draw the law in 100 replicates
    let sampling = half_width(summary.consumption().and_then(|own| own.ci95).expect("200 cycles"));
    let wide = (1.959964 * found.sd).powf(2.0) * 1.01 + sampling * sampling;
    assert!((half_width(found.ci95) - wide.sqrt()).abs() < 1e-6, "{found:?}");
}

#[test]
fn errors_that_go_together_add_up_and_cancel() {
    // whether the truck or its load is heavier is the same to the mean
    let of = |correlation: &str| {
        let keys = "uncertainty.masses.keys=[\"vehicle.curb_mass_kg\", \"mission.payload_kg\"]";
        let errors = "uncertainty.masses.standard_errors=[300.0, 300.0]";
        let sets = ["mission.payload_kg=10000.0", keys, errors];
        uncertain(&[&sets[..], &[correlation]].concat(), 100)
    };
    let correlated =
        |r: &str| of(&format!("uncertainty.masses.correlation=[[1.0, {r}], [{r}, 1.0]]"));
    let (together, against) = (correlated("1.0"), correlated("-1.0"));
    let alone = of("mission.payload_kg=10000.0");
    let [a, b] = [0, 1].map(|k| together.parameters[k].effect.expect("pairs"));
    assert!(a > 0.05 && (a / b - 1.0).abs() < 0.03, "{a} {b}");
    assert!((together.sd / (a + b) - 1.0).abs() < 0.01, "{together:?}");
    assert!(against.sd < 0.05 * a, "{against:?}");
    assert!((alone.sd / a.hypot(b) - 1.0).abs() < 0.01, "{alone:?}");
    let shares: f64 = alone.parameters.iter().filter_map(|parameter| parameter.share).sum();
    assert!((shares - 1.0).abs() < 1e-12, "{shares}");
}

#[test]
fn a_number_near_its_bound_is_moved_as_far_as_it_may_be() {
    let sets = [
        "uncertainty.fit.keys=[\"driver.curve_speed.driver_sd\", \"driver.curve_speed.exponent\"]",
        "uncertainty.fit.standard_errors=[0.2, 0.0]",
    ];
    let found = uncertain(&sets, 50);
    assert!(found.parameters[0].effect.is_some_and(f64::is_finite), "{found:?}");
    assert_eq!((found.parameters[1].effect, found.parameters[1].pairs), (Some(0.0), 0));
}

#[test]
fn the_table_of_trucks_is_as_uncertain_as_its_trucks_are_few() {
    let found = uncertain(&[LAW, "driver.curve_speed.form=table"], 100);
    // 25 trucks with SDs of 0.0235 and 3.94 km/h
    let [exponent, speed] = [0, 1].map(|k| found.parameters[k].standard_error);
    assert!((exponent - 0.0235 / 5.0).abs() < 5e-5, "{found:?}");
    assert!((speed - 3.93785 / 3.6 / 5.0).abs() < 1e-4, "{found:?}");
    assert!(found.sd > 0.0, "{found:?}");
}

#[test]
fn a_run_its_parts_and_what_is_read_back_say_the_same() {
    let parent = tempfile::tempdir().expect("a directory");
    let part = |name: &str, first: &str, cycles: &str| {
        let out = parent.path().join(name);
        run_into(&out, &["--set", LAW, "--first-cycle", first, "--cycles", cycles]);
        out
    };
    let (whole, a, b) = (part("whole", "7", "60"), part("a", "7", "20"), part("b", "27", "40"));
    let merged = parent.path().join("merged");
    let mut command = ocmc(&["merge", "--quiet", "--out"]);
    let output = command.arg(&merged).args([&a, &b]).output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let kept = |directory: &Path| -> Value {
        let text = std::fs::read_to_string(directory.join("summary.json")).expect("written");
        serde_json::from_str::<Value>(&text).expect("JSON")["parameter_uncertainty"].clone()
    };
    assert!(kept(&whole)["sd"].as_f64() > Some(0.0), "{}", kept(&whole));
    assert_eq!(kept(&whole), kept(&merged));
    let read = ocmc_io::run_directory::read(&merged).expect("a run").summary.summary;
    let read = serde_json::to_value(read.parameter_uncertainty).expect("JSON");
    assert_eq!(read, kept(&whole));
}

#[test]
fn a_difference_does_not_depend_on_which_study_comes_first() {
    let of = |errors: &str, correlation: &str| {
        let keys = "uncertainty.m.keys=[\"vehicle.curb_mass_kg\", \"mission.payload_kg\"]";
        let [errors, correlation] = [("standard_errors", errors), ("correlation", correlation)]
            .map(|(key, value)| format!("uncertainty.m.{key}={value}"));
        study("field-truck", &[ROAD, "mission.payload_kg=10000.0", keys, &errors, &correlation])
    };
    let a = of("[500.0, 500.0]", "[[1.0, 0.5], [0.5, 1.0]]");
    let b = of("[1500.0, 900.0]", "[[1.0, 0.5], [0.5, 1.0]]");
    let against = of("[500.0, 500.0]", "[[1.0, -0.5], [-0.5, 1.0]]");
    let plan = RunPlan::new(1, 0, 60, None, None);
    let sd = |studies: [&Study; 2]| {
        let compared: ControlFlow<Infallible, _> =
            compare(&studies, &plan, None, |_| ControlFlow::Continue(()));
        let ControlFlow::Continue(compared) = compared;
        compared.comparisons[0].parameter_uncertainty.as_ref().map(|found| found.sd)
    };
    let (one, other) = (sd([&a, &b]).expect("known"), sd([&b, &a]).expect("known"));
    assert!(one > 0.05 && (one - other).abs() < 1e-9 * one, "{one} {other}");
    // one error cannot go with another one in two ways
    assert_eq!((sd([&a, &against]), sd([&against, &a])), (None, None));
}

#[test]
fn a_number_without_pairs_is_said_and_does_not_hide_the_others() {
    // a battery that moves nothing on its low side
    let study = study(
        "battery-truck",
        &[
            ROAD,
            "uncertainty.a.keys=[\
             \"vehicle.powertrain.battery_electric.battery.discharge_power_w\", \
             \"vehicle.curb_mass_kg\"]",
            "uncertainty.a.standard_errors=[5.17e5, 300.0]",
        ],
    );
    let plan = RunPlan::new(1, 0, 20, None, None);
    let mut fleet = SummaryBuilder::default();
    let ControlFlow::Continue(driven) = all(&study, &plan);
    fleet.add(&driven);
    let mut summary = fleet.finish();
    let ControlFlow::Continue(()) = summary.add_uncertainty(&study, &plan, all);
    let found = summary.parameter_uncertainty.expect("uncertain numbers");
    let [battery, mass] = [0, 1].map(|k| &found.parameters[k]);
    assert_eq!((battery.effect, battery.pairs), (None, 0), "{found:?}");
    assert!(mass.pairs > 0 && mass.effect > Some(0.0), "{found:?}");
    assert!(found.sd > 0.0, "{found:?}");
}

/// Curves of eight drivers, and changes of speed of five, with some scatter of their own.
fn measurements(folder: &Path) -> [String; 2] {
    let scatter = |k: u32| f64::from(k * 7919 % 97) / 97.0 - 0.5;
    let mut curves = "driver,radius_m,speed_mps\n".to_owned();
    for driver in 0..8 {
        for k in 0..12 {
            let radius_m = 40.0 + 25.0 * f64::from(k);
            let log = 0.1 * scatter(driver * 3 + 1) + 0.1 * scatter(driver * 12 + k);
            let speed = 18.0 * (radius_m / 250.0).powf(0.5) * log.exp();
            writeln!(curves, "d{driver},{radius_m},{speed:.4}").expect("memory");
        }
    }
    let mut changes = "driver,acceleration_mps2\n".to_owned();
    for driver in 0..5 {
        for k in 0..10 {
            let log = 0.3 * scatter(driver * 5 + 2) + 0.3 * scatter(driver * 10 + k);
            for mean in [0.6, -0.8] {
                writeln!(changes, "d{driver},{:.4}", mean * log.exp()).expect("memory");
            }
        }
    }
    [("curves.csv", curves), ("changes.csv", changes)].map(|(name, text)| {
        let path = folder.join(name);
        std::fs::write(&path, text).expect("space");
        path.display().to_string()
    })
}

#[test]
fn a_fit_writes_its_errors_and_a_run_of_its_study_says_what_they_do() {
    let folder = tempfile::tempdir().expect("a directory");
    let [curves, changes] = measurements(folder.path());
    let mine = folder.path().join("mine.toml").display().to_string();
    for (arguments, expected) in [
        (
            ["fit", "curve-speed", &curves],
            vec![
                "driver.curve_speed.exponent",
                "driver.curve_speed.reference_speed_mps",
                "driver.curve_speed.driver_sd",
                "driver.curve_speed.residual_sd",
            ],
        ),
        (
            ["fit", "speed-change", &changes],
            vec![
                "driver.speed_change.deceleration_mps2.median",
                "driver.speed_change.deceleration_mps2.log_sd",
                "driver.speed_change.acceleration_mps2.median",
                "driver.speed_change.acceleration_mps2.log_sd",
            ],
        ),
    ] {
        let _ = std::fs::remove_file(&mine);
        let output = ocmc(&arguments).args(["--study-out", &mine, "--json"]).output().expect("it");
        let fit: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let written = &fit["study"]["uncertainty"];
        let run = ["--study", &mine, "--set", ROAD, "--cycles", "40", "--quiet", "--json"];
        // the law of curve speeds has a switch of its own
        let law = if arguments[1] == "curve-speed" { LAW } else { ROAD };
        let output = ocmc(&run).args(["--set", law]).output().expect("it");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let run: Value = serde_json::from_slice(&output.stdout).expect(&said);
        let found = &run["parameter_uncertainty"];
        let parameters = found["parameters"].as_array().expect("uncertain numbers");
        for key in expected {
            let parameter = parameters.iter().find(|parameter| parameter["key"] == key);
            let parameter = parameter.unwrap_or_else(|| panic!("{key}: {found}, {written}"));
            assert!(parameter["standard_error"].as_f64() > Some(0.0), "{parameter}");
            assert!(parameter["effect"].is_f64(), "{parameter}");
        }
        let consumption = &run["statistics"]["consumption_l_per_100km"];
        let width = |interval: &Value| {
            interval[1].as_f64().expect("a number") - interval[0].as_f64().expect("a number")
        };
        assert!(width(&found["ci95"]) > width(&consumption["ci95"]), "{found}");
    }
}

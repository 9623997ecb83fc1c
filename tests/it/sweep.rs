//! Sweeps: what a comparison of two studies says, of many points at once.

use crate::program::{SHORT, ocmc};
use ocmc_api::{
    Against, Answer, CompareRequest, RunPlan, SweepAnswer, SweepPoints, SweepRequest, compare,
    go_on, study, sweep,
};
use serde_json::{Value, json};
use std::fs;

const DRAG: &str = "vehicle.drag_area_m2.median";

fn swept(sets: &[&str], against: Against, cycles: u64, threads: usize) -> SweepAnswer {
    let base = study::load("field-truck", &[SHORT]).expect("a study");
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let (fixed, points) = SweepPoints::of_settings(&sets).expect("points");
    let base = base.set(&fixed).expect("a study");
    let plan = RunPlan::new(3, 5, cycles, Some(threads), None);
    let study = ("mine".to_owned(), &base);
    let request = SweepRequest { study, points, against, plan, column: None };
    sweep(&request, &mut go_on).expect("a sweep")
}

fn text(arguments: &[&str]) -> String {
    let output = ocmc(arguments).assert().success().get_output().clone();
    String::from_utf8(output.stdout).expect("UTF-8")
}

fn answer(arguments: &[&str]) -> Value {
    serde_json::from_str(&text(&[arguments, &["--json", "--quiet"]].concat())).expect("JSON")
}

#[test]
fn two_points_are_a_comparison_to_the_bit() {
    let vehicles = "vehicle.base=tractor-40t,rigid-12t,tractor-electric-40t";
    for (sets, other) in [
        (&["vehicle.drag_area_m2.median=5,4.5"][..], 1),
        // diesel and electric: by the work at the wheels, all of them
        (&[vehicles], 1),
        (&[vehicles], 2),
    ] {
        let answer = swept(sets, Against::First, 100, 2);
        let load = |point: usize| {
            let value = answer.points[point].values.iter().next().expect("a key");
            study::load("field-truck", &[SHORT, &format!("{}={}", value.0, value.1)]).expect("one")
        };
        let (a, b) = (load(0), load(other));
        let request = CompareRequest {
            studies: vec![("a".to_owned(), &a), ("b".to_owned(), &b)],
            plan: RunPlan::new(3, 5, 100, Some(1), None),
            column: Some(answer.column.clone()),
            keep: false,
        };
        let compared = compare(&request, &mut go_on).expect("two studies");
        let (found, point) = (&compared.comparisons[0], &answer.points[other]);
        assert_eq!(point.study_hash, found.study_hash_b);
        let found = &found.comparison;
        assert!(found.difference.is_some_and(|change| change != 0.0) && found.adjusted.is_some());
        assert_eq!(point.difference, found.difference);
        assert_eq!(point.difference_ci95, found.ci95);
        assert_eq!(point.adjusted, found.adjusted);
        assert_eq!((point.pairs, point.not_completed), (Some(found.pairs), found.b_failed));
        assert_eq!((answer.points[0].mean, point.mean), (found.a, found.b));
        assert_eq!(point.relative_difference, Some(found.difference.unwrap() / found.a.unwrap()));
        let is_common = answer.text().contains("the first that all points have");
        assert_eq!(is_common, answer.column == "wheel_kwh_per_km", "{}", answer.text());
        assert_eq!(is_common, sets == [vehicles]);
        assert!(!answer.text().contains("A mean is -"));
    }
}

#[test]
fn a_quantity_that_a_point_lacks_has_no_mean_there() {
    let set = "vehicle.base=tractor-40t,tractor-electric-40t";
    let asked =
        ["sweep", "--set", set, "--set", SHORT, "--cycles", "5", "--column", "co2_g_per_km"];
    let points = &answer(&asked)["points"];
    assert!(points[0]["mean"].is_number() && points[1]["mean"].is_null(), "{points}");
    assert!(points[1]["difference"].is_null() && points[1]["pairs"] == 0, "{points}");
    assert!(text(&asked).contains("A mean is - where no completed cycle has co2_g_per_km."));
}

#[test]
fn a_mean_is_that_of_a_run_and_failures_are_its_outcomes() {
    let limit = "simulation.longest_duration_s";
    let cycles = ["--set", SHORT, "--cycles", "60"];
    let set = format!("{limit}=10000,420");
    let found = answer(&[&["sweep", "--set", &set][..], &cycles].concat());
    let mut not_completed = Vec::new();
    for (point, seconds) in [10_000, 420].into_iter().enumerate() {
        let set = format!("{limit}={seconds}");
        let run = answer(&[&["--set", &set][..], &cycles].concat());
        let mean = &run["statistics"]["consumption_l_per_100km"];
        let point = &found["points"][point];
        assert_eq!((&point["mean"], &point["ci95"]), (&mean["mean"], &mean["ci95"]));
        let completed = run["outcomes"]["completed"].as_u64().expect("a number");
        assert_eq!(point["not_completed"], 60 - completed);
        assert_eq!(point["share_not_completed"], (60 - completed) as f64 / 60.0);
        not_completed.push(60 - completed);
    }
    assert!(not_completed[0] == 0 && not_completed[1] > 0, "{not_completed:?}");
    // what both completed is the same drive
    assert_eq!(found["points"][1]["difference"], 0.0);
    assert_eq!(found["points"][1]["pairs"], 60 - not_completed[1]);
}

#[test]
fn what_has_no_effect_makes_no_difference() {
    let answer = swept(&["study.name=a,b,c"], Against::Base, 20, 1);
    assert!(answer.base.is_some_and(|base| base.difference.is_none() && base.pairs.is_none()));
    assert_eq!(answer.points.len(), 3);
    for point in answer.points {
        assert_eq!((point.difference, point.difference_ci95), (Some(0.0), Some([0.0, 0.0])));
        assert_eq!((point.relative_difference, point.pairs), (Some(0.0), Some(20)));
    }
}

#[test]
fn a_grid_goes_through_the_values_of_its_last_key_first_on_any_threads() {
    let sets = [&format!("{DRAG}=5,4.5"), "mission.payload_kg=0,9000", "study.name=fixed"];
    let by_one = swept(&sets, Against::First, 40, 1);
    let values: Vec<Value> =
        by_one.points.iter().map(|point| Value::Object(point.values.clone())).collect();
    let point = |drag: Value, payload: u64| json!({ DRAG: drag, "mission.payload_kg": payload });
    let wanted = [(json!(5), 0), (json!(5), 9000), (json!(4.5), 0), (json!(4.5), 9000)];
    assert_eq!(values, wanted.map(|(drag, payload)| point(drag, payload)));
    assert_eq!(by_one.keys, [DRAG, "mission.payload_kg"]);
    for threads in [2, 3] {
        let again = swept(&sets, Against::First, 40, threads);
        assert_eq!(again.to_json(), by_one.to_json(), "{threads} threads");
    }
    let text = by_one.text();
    assert!(
        text.contains("key 2: mission.payload_kg\n") && text.contains("\nkey 1  key 2  "),
        "{text}"
    );
}

#[test]
fn a_list_has_the_points_of_a_grid_and_leaves_out_what_is_empty() {
    let folder = tempfile::tempdir().expect("a directory");
    let (list, table) = (folder.path().join("points.csv"), folder.path().join("table.csv"));
    let law = "{ distribution = \"uniform\", lower = 0, upper = 9000 }";
    let quoted = law.replace('"', "\"\"");
    let rows = format!("{DRAG},mission.payload_kg\n5,9000\n4.5,\"{quoted}\"\n5,\n");
    fs::write(&list, rows).expect("space");
    let [list, table] = [&list, &table].map(|path| path.to_str().expect("UTF-8"));
    let cycles = ["--set", SHORT, "--cycles", "20"];
    let out = ["--out", table];
    let listed = answer(&[&["sweep", "--list", list][..], &cycles, &out].concat());
    let payload = format!("mission.payload_kg=9000,{law}");
    let drag = format!("{DRAG}=5,4.5");
    let grid = answer(&[&["sweep", "--set", &drag, "--set", &payload][..], &cycles].concat());
    let (listed, grid) = (&listed["points"], &grid["points"]);
    assert_eq!((&listed[0], &listed[1]), (&grid[0], &grid[3]));
    assert_eq!(listed[2]["values"], json!({ DRAG: 5, "mission.payload_kg": null }));
    let mut reader = csv::Reader::from_path(table).expect("written");
    let names = reader.headers().expect("a header").clone();
    let written: Vec<csv::StringRecord> = reader.records().map(|row| row.expect("one")).collect();
    let of = |row: usize, name: &str| {
        let place = names.iter().position(|known| known == name).expect("a column");
        written[row][place].to_owned()
    };
    assert_eq!((of(0, DRAG), of(2, "mission.payload_kg")), ("5".to_owned(), String::new()));
    assert_eq!(of(0, "difference"), "");
    for (name, number) in [
        ("mean", &listed[1]["mean"]),
        ("difference_low", &listed[1]["difference_ci95"][0]),
        ("adjusted_difference", &listed[1]["adjusted"]["difference"]),
        ("share_not_completed", &listed[1]["share_not_completed"]),
    ] {
        assert_eq!(of(1, name).parse::<f64>().ok(), number.as_f64(), "{name}");
    }
    assert_eq!(of(1, "column"), "consumption_l_per_100km");
}

#[test]
fn what_cannot_be_swept_is_said_before_anything_is_driven() {
    let folder = tempfile::tempdir().expect("a directory");
    let list = folder.path().join("points.csv");
    fs::write(&list, format!("{DRAG},study.name\n5,a\n4.5\n")).expect("space");
    let list = list.to_str().expect("UTF-8");
    let drag = format!("{DRAG}=5,4.5");
    let many: Vec<String> = (0..1001).map(|k| (5000 + k).to_string()).collect();
    let many = format!("mission.length_m={}", many.join(","));
    let million = ["--cycles", "1000000000", "--quiet"];
    for (arguments, status, parts) in [
        (&[][..], 2, &["give a key several values"][..]),
        (&["--set", "mission.payload_kg=5"], 2, &["give a key several values", "--against"]),
        (&["--set", "mission.payload_kg=1,,2"], 1, &["has no value"]),
        (&["--set", "mission.payload_kg"], 1, &["has no `=`"]),
        (&["--set", "vehicle.mas=1,2"], 1, &["point 1 of 2 (vehicle.mas=1)", "is not a key"]),
        (
            &["--set", &drag, "--set", "mission.length_m=5e3,1"],
            1,
            &["point 2 of 4", "mission.length_m=1", "allowed is 200 to"],
        ),
        (&["--set", &drag, "--set", &drag], 2, &[DRAG, "given twice"]),
        (
            &["--set", "mission.length_m=5e3,5000"],
            2,
            &["point 2 of 2", "the same study as point 1"],
        ),
        (&["--set", &many], 2, &["1001 points", "at most 1000"]),
        (&["--set", &drag, "--column", "fuel_kk"], 2, &["did you mean"]),
        (&["--set", &drag, "--out", "a.txt"], 2, &["`.csv` or `.json`"]),
        (&["--list", list], 1, &["line 3", "1 cells, allowed are 2"]),
        (&["--list", list, "--set", &drag], 2, &["--list gives the points"]),
        (&["--list", "nowhere.csv"], 1, &["nowhere.csv"]),
        (&["--set", &drag, "--against", "second"], 2, &["first", "base"]),
    ] {
        let arguments = [&["sweep"], arguments, &million].concat();
        let output = ocmc(&arguments).output().expect("it starts");
        let said = String::from_utf8(output.stderr).expect("UTF-8");
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {said}");
        for part in parts {
            assert!(said.contains(part), "{arguments:?}: {said}");
        }
    }
}

#[test]
fn the_table_is_no_wider_than_a_terminal() {
    let loss = "vehicle.powertrain.combustion.gearbox.indirect_loss_share=0.03,0.04";
    let long =
        [loss, "driver.curve_speed.residual_sd=0.04,0.05", "vehicle.base=tractor-40t,rigid-12t"];
    let of = |sets: &[&str]| swept(sets, Against::First, 20, 2).text();
    let is_narrow = |text: &str| text.lines().all(|line| line.chars().count() <= 80);
    let short = of(&["vehicle.drag_area_m2.median=5,4.5"]);
    assert!(is_narrow(&short) && short.contains("\ndrag_area_m2.median  mean  "), "{short}");
    for count in 2..=3 {
        let text = of(&long[..count]);
        assert!(is_narrow(&text), "{text}");
        // the head has numbers, and above it stands what they mean
        assert!(text.contains("key 1: vehicle.powertrain.combustion.gearbox.ind"), "{text}");
        assert!(text.contains("key 2: driver.curve_speed.residual_sd"), "{text}");
        assert!(text.lines().any(|line| line.starts_with("key 1  key 2")), "{text}");
    }
}

//! Comparison, sensitivity and precision, as a user of the command meets them.

use crate::program::{SHORT, ocmc, records, run_into};
use ocmc_core::energy::Carrier;
use ocmc_core::random::LAST_CYCLE_ID;
use ocmc_core::record::{Outcome, Record};
use serde_json::Value;
use std::fs;
use std::path::Path;

fn text(arguments: &[&str]) -> String {
    let output = ocmc(arguments).assert().success().get_output().clone();
    String::from_utf8(output.stdout).expect("UTF-8")
}

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&text(&[arguments, &["--json"]].concat())).expect("JSON")
}

fn assert_fits(text: &str) {
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    assert!(!text.contains("NaN") && !text.contains('\u{1b}'), "{text}");
}

#[test]
fn a_study_compared_with_itself_is_the_same() {
    let arguments = ["compare", "field-truck", "field-truck", "--cycles", "50", "--set", SHORT];
    let answer = json(&arguments);
    assert_eq!((&answer["difference"], &answer["share_equal"]), (&0.0.into(), &1.0.into()));
    assert_eq!(answer["ci95"], serde_json::json!([0.0, 0.0]));
    assert!(answer["variance_reduction"].is_null());
    let found = text(&arguments);
    assert!(found.contains("the same in 100.0 %"), "{found}");
    assert_fits(&found);
}

#[test]
fn common_random_numbers_show_a_small_difference() {
    let drag = "vehicle.drag_area_m2=4.2";
    let study = tempfile::NamedTempFile::with_suffix(".toml").expect("a file");
    let path = study.path().to_str().expect("UTF-8");
    fs::write(path, "[study]\nbase = \"field-truck\"\n[mission]\nlength_m = 5000\n")
        .expect("space");
    let arguments = ["compare", path, "--set", drag, "--cycles", "200"];
    let answer = json(&arguments);
    for key in ["column", "a", "b", "difference", "ci95", "share_a_lower", "variance_reduction"] {
        assert!(!answer[key].is_null(), "{key}");
    }
    assert_eq!(answer["column"], "consumption_l_per_100km");
    let number = |value: &Value| value.as_f64().expect("a number");
    // less drag, less fuel, in nearly every cycle; the difference is known far better than either
    // mean
    assert!(number(&answer["ci95"][1]) < 0.0, "{answer}");
    assert!(number(&answer["share_a_lower"]) < 0.2, "{answer}");
    assert!(number(&answer["variance_reduction"]) > 20.0, "{answer}");
    let found = text(&arguments);
    assert!(found.contains("\n  with vehicle.drag_area_m2=4.2\n"), "{found}");
    assert_fits(&found);

    let speed = json(&[&arguments[..], &["--column", "mean_speed_mps"]].concat());
    assert_eq!(speed["column"], "mean_speed_mps");
    let several =
        ["compare", "field-truck", "long-haul", "regional", "--cycles", "20", "--set", SHORT];
    let answers = json(&several);
    assert_eq!(answers.as_array().map(Vec::len), Some(2), "{answers}");
    assert_eq!(answers[1]["study_b"], "regional");
    assert_fits(&text(&several));
}

#[test]
fn a_comparison_has_the_mean_of_a_run_and_empty_trips_are_no_failures() {
    let column = "consumption_l_per_100tkm";
    let fleet = ["--cycles", "60", "--set", SHORT];
    let run = json(&fleet);
    let studies = ["compare", "field-truck", "field-truck", "--column", column];
    let answer = [&studies[..], &fleet[..]].concat();
    let found = json(&answer);
    let number = |value: &Value| value.as_f64().expect("a number");
    let mean = number(&run["statistics"][column]["mean"]);
    assert!((number(&found["a"]) / mean - 1.0).abs() < 1e-12, "{found}, a run says {mean}");
    assert_eq!(
        (&found["a_failed"], &found["b_failed"], &found["pairs"]),
        (&0.into(), &0.into(), &60.into())
    );
    let without = found["pairs_without_value"].as_u64().expect("a number");
    assert!(without > 0, "the study has empty trips: {found}");
    let words = text(&answer);
    assert!(words.contains(&format!("{without} pairs, counted in the means alone")), "{words}");
    assert!(!words.contains("not completed"), "{words}");
    assert_fits(&words);

    // single cycles: an empty trip has no value, and that is no failure either
    let analysis =
        ["sensitivity", "--cycles", "60", "--set", SHORT, "--factor", "road", "--column", column];
    let found = json(&analysis);
    assert_eq!(found["failed_rows"], 0);
    assert_eq!(found["dropped_rows"], found["rows_without_value"]);
    let words = text(&analysis);
    assert!(words.contains("dropped because a cycle had no value"), "{words}");
    assert_fits(&words);
}

#[test]
fn stops_of_the_same_cycle_are_the_same() {
    let drag = "vehicle.drag_area_m2=4.6";
    let arguments =
        ["compare", "field-truck", "--set", drag, "--cycles", "20", "--column", "stops_per_km"];
    let answer = json(&arguments);
    assert_eq!((&answer["share_a_lower"], &answer["share_equal"]), (&0.0.into(), &1.0.into()));
    assert!(answer["variance_reduction"].is_null(), "{answer}");
    assert!(!text(&arguments).contains("variance"));
}

#[test]
fn a_difference_tells_what_it_owes_to_uncertain_parameters() {
    let sets = ["driver.curve_speed.parameter_uncertainty=true", "driver.curve_speed.replicates=8"];
    let arguments = ["compare", "field-truck", "long-haul", "--cycles", "64", "--set", SHORT];
    let arguments = [&arguments[..], &["--set", sets[0], "--set", sets[1]]].concat();
    let uncertain = &json(&arguments)["parameter_uncertainty"];
    assert_eq!((&uncertain["replicates"], &uncertain["cycles"]), (&8.into(), &64.into()));
    let words = text(&arguments);
    assert!(words.contains("with the errors of the uncertain numbers"), "{words}");
    assert!(words.contains("driver.curve_speed.exponent ± 0.012"), "{words}");
    assert_fits(&words);
    assert!(json(&arguments[..7])["parameter_uncertainty"].is_null());
}

#[test]
fn the_worst_case_is_no_better_than_what_the_failed_cycles_show() {
    let parent = tempfile::tempdir().expect("a directory");
    let out = parent.path().join("run");
    let (road, short) = ("mission.length_m=40000", "simulation.longest_duration_s=1900");
    let path = out.to_str().expect("UTF-8");
    let run = ["--cycles", "60", "--set", road, "--set", short, "--quiet", "--out", path];
    let answer = json(&run);
    let records = crate::program::records(&out.join("records.parquet"));
    let failed: Vec<f64> = records
        .iter()
        .filter(|record| record.outcome != Outcome::Completed)
        .filter_map(|record| record.consumption(Carrier::LiquidFuel))
        .collect();
    assert_eq!(answer["worst_case"]["cycles"], failed.len());
    assert!(failed.len() > 20, "most are timed out: {}", failed.len());
    let number = |value: &Value| value.as_f64().expect("a number");
    let fleet = number(&answer["statistics"]["consumption_l_per_100km"]["mean"]);
    let completed = (records.len() - failed.len()) as f64;
    let least = (completed * fleet + failed.iter().sum::<f64>()) / records.len() as f64;
    let worst = number(&answer["worst_case"]["mean"]);
    assert!(worst >= least - 1e-12 && least > fleet, "{worst}, {least}, {fleet}");
}

#[test]
fn shares_of_the_variance() {
    let arguments = ["sensitivity", "--cycles", "60", "--set", SHORT, "--factor", "mission,driver"];
    let mut one = json(&[&arguments[..], &["--threads", "1"]].concat());
    let mut two = json(&[&arguments[..], &["--threads", "2"]].concat());
    for answer in [&mut one, &mut two] {
        answer["wall_s"].take();
        answer["threads"].take();
    }
    assert_eq!(one, two, "the answer does not depend on threads");
    assert_eq!((&one["rows"], &one["cycles"]), (&60.into(), &240.into()));
    let factors = one["factors"].as_array().expect("a list");
    let names: Vec<&Value> = factors.iter().map(|factor| &factor["factor"]).collect();
    assert_eq!(names, ["mission", "driver"]);
    for factor in factors {
        for key in ["first", "total"] {
            assert!(factor[key].is_number(), "{factor}");
            assert_eq!(factor[format!("{key}_ci95")].as_array().map(Vec::len), Some(2));
        }
    }
    assert_fits(&text(&[&arguments[..], &["--crossed", "10"]].concat()));
}

#[test]
fn shapley_effects_stand_beside_the_shares_and_add_up_to_one() {
    let arguments = ["sensitivity", "--set", SHORT, "--cycles", "12", "--quiet", "--shapley"];
    let told = ocmc(&arguments).output().expect("the program starts");
    let told = String::from_utf8(told.stdout).expect("UTF-8");
    assert!(told.contains("Shapley effects") && told.contains("together"), "{told}");
    let found = ocmc(&arguments).args(["--json", "--threads", "1"]).output().expect("it starts");
    let found: Value = serde_json::from_slice(&found.stdout).expect("JSON");
    let effects = &found["shapley"];
    assert_eq!(effects["cycles"], 12 * 64);
    let factors = effects["factors"].as_array().expect("a list");
    assert_eq!(factors.len(), 6);
    let share = |factor: &Value| factor["share"].as_f64().expect("a number");
    let sum: f64 = factors.iter().map(share).sum();
    assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    // the payload is most of the spread: so is the mission's share, alone and shared out
    let mission = factors.iter().find(|factor| factor["factor"] == "mission").expect("there");
    let first = &found["factors"];
    assert!(share(mission) > 0.0, "{mission}");
    assert_eq!(first.as_array().map(Vec::len), Some(11), "the other shares are still there");
}

#[test]
fn what_cannot_be_analysed_is_said() {
    for (arguments, status, part) in [
        (&["compare", "field-truck"][..], 2, "--set"),
        (&["compare"], 2, "NAME|FILE"),
        (&["compare", "field-truck", "nowhere"], 1, "nowhere"),
        (&["compare", "field-truck", "regional", "--column", "x"], 2, "columns of the records"),
        (&["compare", "field-truck", "regional", "--column", "fuel_kk"], 2, "did you mean"),
        (&["sensitivity", "--factor", "moon"], 2, "driver.curve_speed"),
        (&["sensitivity", "--cycles", "9", "--set", SHORT, "--factor", "road"], 1, "at least 10"),
        (
            &[
                "sensitivity",
                "--cycles",
                "10",
                "--set",
                SHORT,
                "--column",
                "consumption_kwh_per_km",
            ],
            1,
            "0 cycles with",
        ),
        (&["--precision", "0%"], 2, "p95:1%"),
        (&["--precision", "p96:1%"], 2, "p95:1%"),
    ] {
        let output = ocmc(arguments).output().expect("the program starts");
        let found = String::from_utf8(output.stderr).expect("UTF-8");
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {found}");
        assert!(output.stdout.is_empty());
        assert!(found.contains(part) && !found.contains("panicked"), "{arguments:?}: {found}");
    }
}

fn bytes(directory: &Path) -> (Vec<u8>, Vec<u8>) {
    let read = |file: &str| fs::read(directory.join(file)).expect("written");
    (read("records.parquet"), read("manifest.json"))
}

#[test]
fn a_run_ends_when_it_is_precise_enough_whatever_the_threads() {
    let parent = tempfile::tempdir().expect("a directory");
    let run = |name: &str, arguments: &[&str]| {
        let out = parent.path().join(name);
        run_into(&out, arguments);
        out
    };
    let one = run("one", &["--precision", "1.2%", "--threads", "1"]);
    let manifest: Value = serde_json::from_slice(&bytes(&one).1).expect("JSON");
    let cycles = manifest["cycles"].as_u64().expect("a number");
    let looks = [313, 392, 490, 613, 767, 959, 1199, 1499, 1874];
    assert!(looks.contains(&cycles), "a look after the first one: {cycles}");
    assert_eq!(manifest["status"], "complete");
    for (name, options) in [("two", ["--threads", "2"]), ("chunk", ["--chunk", "7"])] {
        let other = run(name, &[&["--precision", "1.2%"], &options[..]].concat());
        assert!(bytes(&other) == bytes(&one), "{name}");
    }
    let plain = run("plain", &["--cycles", &cycles.to_string()]);
    assert!(bytes(&plain) == bytes(&one), "a run of so many cycles is the same");

    let summary: Value =
        serde_json::from_str(&fs::read_to_string(one.join("summary.json")).expect("written"))
            .expect("JSON");
    let precision = &summary["precision"];
    assert_eq!((&precision["of"], &precision["met"]), (&"mean".into(), &true.into()));
    assert!(precision["reached"].as_f64().is_some_and(|reached| reached <= 0.012), "{precision}");
    let litres = &summary["statistics"]["consumption_l_per_100km"]["adjusted"];
    let [mean, low, high] =
        [&litres["mean"], &litres["ci95"][0], &litres["ci95"][1]].map(|x| x.as_f64().expect("one"));
    assert!(
        ((high - low) / 2.0 / mean - precision["reached"].as_f64().expect("one")).abs() < 1e-12
    );

    let short = text(&["--precision", "p95:0.01%", "--cycles", "1100", "--set", SHORT]);
    assert!(short.contains("more --cycles are needed"), "{short}");
    assert_fits(&short);
}

#[test]
fn the_birds_eye_view_of_a_study() {
    let seen = |study: &str| {
        let view = &json(&["study", "birds-eye", study, "--cycles", "20"])["birds_eye"];
        ["hilliness", "transport_cycle", "stop_density"].map(|key| view[key].clone())
    };
    assert_eq!(seen("long-haul")[1], "long_distance");
    assert_eq!(seen("urban-delivery")[1], "local");
    assert_eq!(seen("urban-delivery")[2], "high");
    let flat = ["study", "birds-eye", "field-truck", "--set", "simulation.without=[\"slope\"]"];
    let words = text(&[&flat[..], &["--cycles", "3"]].concat());
    assert!(
        words.starts_with("field-truck: 3 operating cycles, 300.0 km\nhilliness        flat:"),
        "{words}"
    );
    assert_fits(&words);
    let refused = ocmc(&[&flat[..], &["--first-cycle", &u64::MAX.to_string()]].concat());
    let output = { refused }.output().expect("the program starts");
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn the_birds_eye_view_of_laws_is_that_of_many_roads() {
    // which types a road has differs most from road to road
    for (study, near) in [("field-truck", 0.05), ("urban-delivery", 0.01), ("long-haul", 0.05)] {
        let drawn = json(&["study", "birds-eye", study, "--cycles", "1000"]);
        let laws = json(&["study", "birds-eye", study, "--laws"]);
        assert!(laws["seed"].is_null() && laws["cycles"].is_null(), "{laws}");
        let (drawn, laws) = (&drawn["birds_eye"], &laws["birds_eye"]);
        for class in ["hilliness", "transport_cycle", "stop_density"] {
            assert_eq!(laws[class], drawn[class], "{study} {class}");
        }
        let number = |view: &serde_json::Value, key: &str| view[key].as_f64().expect("a number");
        for key in ["stops_per_km", "curves_per_km"] {
            let (law, seen) = (number(laws, key), number(drawn, key));
            assert!((law / seen - 1.0).abs() < near, "{study} {key}: {law} for {seen}");
        }
        for (place, near) in [0.006, 0.001, 0.0001].into_iter().enumerate() {
            let of = |view: &serde_json::Value| view["share_below"][place].as_f64().unwrap();
            let (law, seen) = (of(laws), of(drawn));
            assert!((law - seen).abs() < near, "{study} slopes {place}: {law} for {seen}");
        }
        let types = drawn["road_type_share"].as_object().unwrap();
        assert_eq!(laws["road_type_share"].as_object().unwrap().len(), types.len());
        for (name, seen) in types {
            let (law, seen) = (number(&laws["road_type_share"], name), seen.as_f64().unwrap());
            assert!((law - seen).abs() < 0.02, "{study} {name}: {law} for {seen}");
        }
    }
    let flat = "simulation.without=[\"slope\", \"curves\", \"traffic_lights\"]";
    let all = json(&["study", "birds-eye", "urban-delivery", "--laws"]);
    let less = json(&["study", "birds-eye", "urban-delivery", "--laws", "--set", flat]);
    let less = &less["birds_eye"];
    assert_eq!((&less["hilliness"], less["curves_per_km"].as_f64()), (&"flat".into(), Some(0.0)));
    assert!(less["stops_per_km"].as_f64() < all["birds_eye"]["stops_per_km"].as_f64());
    let words = text(&["study", "birds-eye", "long-haul", "--laws"]);
    assert!(words.starts_with("long-haul: by its laws, 300.0 km a cycle\nhilliness"), "{words}");
    assert_fits(&words);
    let output = ocmc(&["study", "birds-eye", "simulator-study", "--laws"]).output().unwrap();
    assert!(String::from_utf8_lossy(&output.stderr).contains("drives given routes"), "{output:?}");
    // a number of cycles says that roads are to be drawn
    let mut refused = ocmc(&["study", "birds-eye", "long-haul", "--laws", "--cycles", "5"]);
    assert_eq!(refused.output().expect("the program starts").status.code(), Some(2));
}

#[test]
fn studies_of_two_powertrains_are_compared_by_the_work_at_the_wheels() {
    let arguments = ["compare", "field-truck", "battery-truck", "--cycles", "20", "--set", SHORT];
    let answer = json(&arguments);
    assert_eq!(answer["column"], "wheel_kwh_per_km");
    assert!(answer["pairs"].as_u64() > Some(0) && !answer["difference"].is_null(), "{answer}");
    let why = "battery-truck burns no fuel: compared by work at the wheels";
    let found = text(&arguments);
    assert!(found.contains(why), "{found}");
    assert_fits(&found);
    // a quantity that is named: the message says which study lacks it
    let asked = |column: &str| text(&[&arguments[..], &["--column", column]].concat());
    for column in ["consumption_l_per_100km", "co2_g_per_km"] {
        let found = asked(column);
        assert!(found.contains(&format!("battery-truck has no {column}")), "{found}");
        assert_fits(&found);
    }
    assert!(asked("consumption_kwh_per_km").contains("field-truck has no consumption_kwh_per_km"));
    assert!(!asked("wheel_kwh_per_km").contains("burns no fuel"));
    let neither = ["compare", "battery-truck", "battery-truck", "--cycles", "1", "--set", SHORT];
    let found = text(&[&neither[..], &["--column", "co2_g_per_km"]].concat());
    assert!(found.contains("neither study has co2_g_per_km"), "{found}");
    let found = text(&neither);
    assert!(found.contains("of 1 pair\n") && !found.contains("burn"), "{found}");
}

#[test]
fn the_help_of_an_analysis_says_what_its_cycles_are() {
    assert!(text(&["compare", "--help"]).contains("Number of cycles in each study"));
    let found = text(&["sensitivity", "--help"]);
    assert!(found.contains("Number of rows of the design"), "{found}");
}

#[test]
fn a_second_opinion_that_cannot_be_is_refused_before_anything_is_driven() {
    let found = |more: &[&str], status: i32| {
        // so many cycles would take for ever
        let run = ["sensitivity", "--cycles", "100000", "--quiet", "--first-cycle"];
        let output = ocmc(&[&run[..], more].concat()).output().expect("the program starts");
        assert_eq!(output.status.code(), Some(status), "{more:?}");
        String::from_utf8(output.stderr).expect("UTF-8")
    };
    for number in ["1", "99999999999999"] {
        let text = found(&["0", "--crossed", number], 2);
        assert!(text.contains("--crossed") && text.contains("2 to 1000000"), "{text}");
    }
    let sobol = ["0", "--crossed", "50", "--set", "simulation.sampling=sobol"];
    assert!(found(&sobol, 1).contains("independent draws"));
    // room for the rows of the design, not for the crossed cycles
    let last = (LAST_CYCLE_ID - 100_000).to_string();
    let text = found(&[&last, "--crossed", "1000000"], 2);
    assert!(text.contains("--first-cycle with --crossed"), "{text}");
}

#[test]
fn studies_are_compared_by_any_number_of_their_records() {
    let folder = tempfile::tempdir().expect("a folder");
    let (a, b) = ("mission.payload_kg=1000", "mission.payload_kg=20000");
    let mut files = Vec::new();
    for set in [a, b] {
        let out = folder.path().join(set);
        run_into(&out, &["--cycles", "12", "--set", set]);
        files.push(records(&out.join("records.parquet")));
    }
    let plain = |value: &dyn Fn(&Record) -> f64| -> f64 {
        let mean = |records: &[Record]| records.iter().map(value).sum::<f64>() / 12.0;
        mean(&files[1]) - mean(&files[0])
    };
    let urban = |record: &Record| {
        let names = record.breakdown.names();
        let place = names.iter().position(|name| name == "fuel_kg_urban").expect("a column");
        record.breakdown.value(place).expect("driven")
    };
    let study = |name: &str, set: &str| {
        let file = folder.path().join(name);
        let text =
            format!("study.name = \"{name}\"\nstudy.base = \"field-truck\"\n{SHORT}\n{set}\n");
        fs::write(&file, text).expect("space");
        file.display().to_string()
    };
    let (a, b) = (study("a.toml", a), study("b.toml", b));
    let asked = |column: &str| json(&["compare", &a, &b, "--cycles", "12", "--column", column]);
    let expected: [(&str, f64); 3] = [
        ("n_gear_shifts", plain(&|record| f64::from(record.n_gear_shifts))),
        ("rolling_energy_j", plain(&|record| record.rolling_energy_j)),
        ("fuel_kg_urban", plain(&urban)),
    ];
    for (column, difference) in expected {
        let answer = asked(column);
        let found = answer["difference"].as_f64().expect("pairs");
        assert!((found - difference).abs() <= 1e-9 * difference.abs(), "{column}: {found}");
        assert_eq!(answer["column"], column);
    }
    // a mean of nothing has no share
    let nothing = ["compare", &a, &b, "--cycles", "5", "--column", "payload_cut_kg"];
    let found = text(&nothing);
    assert!(found.contains("mean of the cycles"), "{found}");
    assert!(found.contains("+0.000 ± 0.000\n") && !found.contains("NaN"), "{found}");
    let out = folder.path().join("page");
    let saved = ["--column", "n_gear_shifts", "--out", out.to_str().expect("UTF-8")];
    text(&[&["compare", &a, &b, "--cycles", "12"], &saved[..]].concat());
    let page = fs::read_to_string(out.join("report.html")).expect("a page");
    assert!(page.contains("n_gear_shifts is ") && page.contains("--column n_gear_shifts"));
    assert!(fs::read_to_string(out.join("pairs.csv")).expect("pairs").lines().count() == 13);
}

//! How large a battery has to be, as a user of the command meets it.

use crate::program::ocmc;
use serde_json::Value;

/// Trips of 40 km with a small battery: some 50 kWh.
const SHORT: &str = "mission.length_m=40000";

fn json(arguments: &[&str]) -> Value {
    let all = [&["size", "--quiet", "--json"], arguments].concat();
    let output = ocmc(&all).assert().success().get_output().clone();
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn size_j(answer: &Value) -> f64 {
    answer["sizes"][0]["capacity_j"].as_f64().expect("a battery is enough")
}

#[test]
fn other_trips_arrive_with_the_answer() {
    let answer = json(&["--set", SHORT, "--cycles", "4000", "--arrive", "95%"]);
    let size_j = size_j(&answer);
    let ends = answer["sizes"][0]["ci95_j"].as_array().expect("two ends");
    let [low_j, high_j] = [0, 1].map(|k| ends[k].as_f64().expect("an end"));
    assert!(low_j < size_j && size_j < high_j && high_j < 1.1 * low_j, "{answer}");
    let battery = format!("vehicle.powertrain.battery_electric.battery.capacity_j={size_j}");
    let run = ["--study", "battery-truck", "--set", SHORT, "--set", &battery, "--cycles", "4000"];
    let mut program = ocmc(&[&run[..], &["--seed", "77", "--quiet", "--json"]].concat());
    let output = program.assert().success().get_output().clone();
    let run: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let count = |name: &str| run["outcomes"][name].as_f64().expect("a count");
    let share = count("completed") / (count("completed") + count("depleted"));
    // two samples of 4000, each with a standard error of 0.0034
    assert!((share - 0.95).abs() < 4.0 * 0.0034 * 2.0f64.sqrt(), "{share}");
}

#[test]
fn heavier_colder_and_surer_trips_need_more() {
    let with = |sets: &[&str], arrive: &str| {
        let mut arguments = vec!["--set", SHORT, "--cycles", "100", "--arrive", arrive];
        for set in sets {
            arguments.extend(["--set", set]);
        }
        size_j(&json(&arguments))
    };
    let own = with(&["mission.payload_kg=10000"], "90%");
    assert!(with(&["mission.payload_kg=20000"], "90%") > 1.1 * own);
    assert!(with(&["mission.payload_kg=10000"], "98%") > own);
    let cold = ["mission.payload_kg=10000", "weather.temperature.mean_k=263.15"];
    assert!(with(&cold, "90%") > 1.03 * own);
    let mass = |kg: &str| {
        let arguments = ["--set", "mission.length_m=100000", "--cycles", "60", "--arrive", "90%"];
        size_j(&json(&[&arguments[..], &["--kg-per-kwh", kg]].concat()))
    };
    // the battery of the study is larger: with its mass goes some of what it has to give
    assert!(mass("6") < mass("0"));
}

#[test]
fn the_answer_fits_does_not_depend_on_threads_and_counts_chargers() {
    let arguments = ["--set", SHORT, "--cycles", "60", "--seed", "4", "--arrive", "50%"];
    let on = |threads: &str| json(&[&arguments[..], &["--threads", threads]].concat());
    assert_eq!(on("1"), on("2"));
    let output = ocmc(&[&["size", "--quiet"], &arguments[..]].concat()).assert().success();
    let text = String::from_utf8(output.get_output().stdout.clone()).expect("UTF-8");
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    assert!(text.contains("kWh") && text.contains("50.0 %") && !text.contains("NaN"), "{text}");
    let charging = "charging={ reserve = 0.1, forecast = { consumption_j_per_m = 4500, margin = \
                    0.1 }, efficiency = 0.95, public = { spacing_m = 10000, power_w = 150000, \
                    end_at = 0.9 } }";
    let charged = size_j(&json(&[&arguments[..], &["--set", charging]].concat()));
    assert!(charged < 0.7 * size_j(&on("1")), "{charged}");
}

#[test]
fn diesel_trucks_and_shares_beyond_one_are_refused() {
    let refused = |arguments: &[&str]| {
        let output = ocmc(&[&["size"], arguments].concat()).assert().failure();
        String::from_utf8(output.get_output().stderr.clone()).expect("UTF-8")
    };
    assert!(refused(&["--study", "field-truck"]).contains("battery-truck"));
    assert!(refused(&["--arrive", "120%"]).contains("below 100%"));
    assert!(refused(&["--arrive", "0.95"]).contains("0.95%"));
    assert!(refused(&["--kg-per-kwh", "-1"]).contains("kg_per_kwh"));
}

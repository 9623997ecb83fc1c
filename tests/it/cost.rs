//! Cost of trips and trucks, as a user of the command meets it.

use crate::program::{SHORT, ocmc};
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

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

fn assert_fits(text: &str) {
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    assert!(!text.contains("NaN"), "{text}");
}

#[test]
fn only_energy_that_is_used_asks_for_its_price() {
    let warned = |more: &[&str]| {
        let prices = ["cost.currency=EUR", "cost.depot_charging_per_kwh=0.2"];
        let trips = ["cost.charging_efficiency=0.9", "mission.length_m=60000"];
        let set = prices.iter().chain(&trips).chain(more).flat_map(|value| ["--set", value]);
        let mut command = ocmc(&["cost", "--study", "electric-regional", "--cycles", "10"]);
        let output = command.args(set).assert().success().get_output().clone();
        String::from_utf8(output.stderr).expect("UTF-8").contains("public_charging_per_kwh")
    };
    // its depot charges, and nobody on the way
    assert!(!warned(&[]));
    let ramp = "charging.stop={power_w=150e3, begin_below=1.0, end_at=1.0, shortest_s=0.0}";
    assert!(warned(&[ramp]));
}

#[test]
fn a_comparison_of_studies_with_prices_says_which_is_cheaper() {
    let folder = tempfile::tempdir().expect("a directory");
    let of = |name: &str, price: &str, currency: &str| {
        let file = folder.path().join(name);
        let text = format!(
            "study.name = \"{name}\"\nstudy.base = \"field-truck\"\nmission.length_m = 3000.0\n\
             cost.currency = \"{currency}\"\ncost.fuel_per_l = {price}\n"
        );
        fs::write(&file, text).expect("space");
        file.display().to_string()
    };
    let (a, b) = (of("a.toml", "1.5", "EUR"), of("b.toml", "1.2", "EUR"));
    let compared = ["compare", &a, &b, "--cycles", "40"];
    let said = text(&compared);
    assert!(said.contains("EUR/km") && said.contains("P(A cheaper) 0.0 %"), "{said}");
    assert!(said.contains("ocmc cost --against"), "{said}");
    // the same numbers as of `cost --against`
    let costed = json(&["cost", "--study", &a, "--against", &b, "--cycles", "40"]);
    assert_eq!(json(&compared)["cost"], costed["difference"]);
    let dollars = of("c.toml", "1.5", "USD");
    assert_eq!(json(&["compare", &a, &dollars, "--cycles", "10"]).get("cost"), None);
    let without = json(&["compare", &a, "field-truck", "--cycles", "10"]);
    assert_eq!(without.get("cost"), None);
}

#[test]
fn costs_of_fuel_alone_are_adjusted_as_the_fuel_is() {
    let folder = tempfile::tempdir().expect("a directory");
    let of = |name: &str, price: &str| {
        let file = folder.path().join(name);
        let text = format!(
            "[study]\nbase = \"field-truck\"\nname = \"{name}\"\n[mission]\nlength_m = 5000.0\n\
             [cost]\ncurrency = \"EUR\"\nfuel_per_l = {price}\n"
        );
        fs::write(&file, text).expect("space");
        file.display().to_string()
    };
    let (a, b) = (of("a.toml", "1.5"), of("b.toml", "1.2"));
    let costed = json(&["cost", "--study", &a, "--against", &b, "--cycles", "250"]);
    let own = json(&["--study", &a, "--cycles", "250"]);
    let litres = &own["statistics"]["consumption_l_per_100km"]["adjusted"]["mean"];
    let expected = -0.3 * litres.as_f64().expect("enough trips") / 100.0;
    let side = &costed["difference"]["per_km"];
    let adjusted = side["adjusted"]["difference"].as_f64().expect("enough trips");
    assert!((adjusted / expected - 1.0).abs() < 1e-6, "{adjusted} {expected}");
    let width =
        |ci95: &Value| ci95[1].as_f64().expect("an end") - ci95[0].as_f64().expect("an end");
    assert!(width(&side["adjusted"]["ci95"]) < width(&side["difference_ci95"]));
}

/// The study files that the guide shows, by their names, written to a folder.
fn files_of_the_guide(folder: &Path) -> Vec<String> {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/src/how-to/cost.md");
    let page = fs::read_to_string(page).expect("the page");
    let mut names = Vec::new();
    for block in page.split("```toml\n").skip(1) {
        let (text, _) = block.split_once("```").expect("a block ends");
        let name = text.strip_prefix("# ").and_then(|rest| rest.split(['\n', ':']).next());
        let name = name.expect("a block begins with the name of its file");
        fs::write(folder.join(name), text).expect("space");
        names.push(name.to_owned());
    }
    names
}

#[test]
fn the_studies_of_the_guide_are_costed_against_each_other() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = files_of_the_guide(folder.path());
    assert_eq!(names, ["diesel.toml", "electric.toml"]);
    let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let (diesel, electric) = (path("diesel.toml"), path("electric.toml"));
    let arguments =
        ["cost", "--study", &diesel, "--against", &electric, "--cycles", "40", "--quiet"];
    let arguments = [&arguments[..], &["--set", SHORT]].concat();
    let answer = json(&arguments);
    let items = |side: &str| -> Vec<String> {
        let items = answer[side]["items"].as_array().expect("items");
        items.iter().map(|item| item["item"].as_str().expect("a name").to_owned()).collect()
    };
    assert!(items("a").contains(&"fuel".to_owned()), "{:?}", items("a"));
    assert!(items("b").contains(&"battery".to_owned()), "{:?}", items("b"));
    assert!(!items("b").contains(&"engine".to_owned()), "{:?}", items("b"));
    for side in ["a", "b"] {
        let cost = &answer[side];
        let sum: f64 =
            cost["items"].as_array().expect("items").iter().map(|i| number(&i["whole_life"])).sum();
        assert!((sum / number(&cost["total"]["whole_life"]) - 1.0).abs() < 1e-9, "{cost}");
        let well = number(&cost["emissions"]["well_to_wheel_kg_per_km"]);
        assert!(well > number(&cost["emissions"]["tank_to_wheel_kg_per_km"]), "{cost}");
    }
    let difference = &answer["difference"];
    let [a, b] = ["a", "b"].map(|side| number(&answer[side]["total"]["per_km"]));
    assert!((number(&difference["per_km"]["difference"]) - (b - a)).abs() < 1e-9, "{difference}");
    let probability = number(&difference["per_km"]["probability_a_cheaper"]);
    assert!((0.0..=1.0).contains(&probability), "{probability}");
    let found = text(&arguments);
    assert!(found.contains("P(A cheaper)") && found.contains("distance, km per year"), "{found}");
    assert_fits(&found);
}

const PRICES: [&str; 6] =
    ["--set", "cost.currency=EUR", "--set", "cost.fuel_per_l=1.5", "--set", SHORT];

#[test]
fn the_cost_of_fuel_is_its_price_times_what_a_run_says() {
    let run = json(&["--cycles", "60", "--seed", "3", "--quiet", "--set", SHORT]);
    let litres = number(&run["statistics"]["consumption_l_per_100km"]["mean"]) / 100.0;
    let arguments = [&["cost", "--cycles", "60", "--seed", "3", "--quiet"][..], &PRICES].concat();
    let answer = json(&arguments);
    let per_km = number(&answer["items"][0]["per_km"]);
    assert!((per_km / (1.5 * litres) - 1.0).abs() < 1e-12, "{per_km} {litres}");
    let ci95 = |value: &Value| [0, 1].map(|k| number(&value[k]));
    let of_run = ci95(&run["statistics"]["consumption_l_per_100km"]["ci95"]);
    for (cost, litres) in ci95(&answer["total"]["per_km_ci95"]).into_iter().zip(of_run) {
        assert!((cost / (0.015 * litres) - 1.0).abs() < 1e-9, "{cost} {litres}");
    }
    assert!(answer["spread"].is_null() && answer["total"]["per_a"].is_null(), "{answer}");
    assert_fits(&text(&arguments));
}

#[test]
fn the_same_seed_costs_the_same_on_any_number_of_threads() {
    let law = "cost.driver_per_h={ distribution = \"uniform\", lower = 20.0, upper = 40.0 }";
    let of = |threads: &str| {
        let arguments = ["cost", "--cycles", "40", "--quiet", "--threads", threads, "--set", law];
        let mut answer = json(&[&arguments[..], &PRICES].concat());
        for key in ["wall_s", "threads"] {
            answer.as_object_mut().expect("a table").remove(key);
        }
        answer
    };
    assert_eq!(of("1"), of("3"));
}

#[test]
fn prices_do_not_change_a_record() {
    let of = |more: &[&str]| {
        let arguments = ["--cycles", "20", "--quiet", "--set", SHORT, "--json"];
        let output = ocmc(&[&arguments[..], more].concat()).assert().success();
        let answer: Value = serde_json::from_slice(&output.get_output().stdout).expect("JSON");
        answer["statistics"].clone()
    };
    assert_eq!(of(&[]), of(&PRICES));
}

#[test]
fn what_cannot_be_costed_is_said() {
    for (arguments, code, piece) in [
        (&["cost", "--cycles", "2"][..], 1, "has no prices: give it a table `[cost]`"),
        (
            &["cost", "--set", "cost.currency=EUR", "--set", "cost.fuel_per_l=-1"],
            1,
            "cost.fuel_per_l",
        ),
        (&["cost", "--set", "cost.fuel_per_l=1.5"], 1, "currency"),
        (&["cost", "--set", "cost.currency=EUR", "--set", "cost.diesel=1.5"], 1, "`fuel_per_l`"),
        (&["cost", "--against", "nowhere"], 1, "nowhere"),
        (&["cost", "--study", "/etc/passwd", "--no-files"], 1, "no file may be read here"),
    ] {
        let output = ocmc(arguments).output().expect("it starts");
        let said = String::from_utf8(output.stderr).expect("UTF-8");
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
        assert!(said.contains(piece), "{arguments:?}: {said}");
    }
}

#[test]
fn two_currencies_are_not_compared() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |currency: &str| {
        let path = folder.path().join(format!("{currency}.toml"));
        let text = format!(
            "study.base = \"field-truck\"\ncost = {{ currency = \"{currency}\", driver_per_h = 1.0 \
             }}\n"
        );
        fs::write(&path, text).expect("space");
        path.to_str().expect("UTF-8").to_owned()
    };
    let (a, b) = (path("EUR"), path("USD"));
    let output = ocmc(&["cost", "--study", &a, "--against", &b, "--cycles", "2"]).output();
    let said = String::from_utf8(output.expect("it starts").stderr).expect("UTF-8");
    assert!(said.contains("`cost.currency` is EUR and USD"), "{said}");
}

#[test]
fn what_is_priced_on_one_side_alone_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("b.toml");
    fs::write(
        &path,
        "study.base = \"field-truck\"\ncost = { currency = \"EUR\", driver_per_h = 30.0 }\n",
    )
    .expect("space");
    let mut arguments = vec!["cost", "--against", path.to_str().expect("UTF-8"), "--cycles", "10"];
    arguments.extend(PRICES);
    let output = ocmc(&arguments).assert().success().get_output().clone();
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(said.contains("driver has a price in") && said.contains("alone"), "{said}");
}

#[test]
fn a_run_emits_from_the_well_what_its_cost_says_and_its_tonnes_share() {
    for study in ["field-truck", "battery-truck", "electric-regional"] {
        let asked = ["--study", study, "--cycles", "30", "--quiet", "--set", SHORT];
        let run = json(&asked);
        let mean = |column: &str| number(&run["statistics"][column]["mean"]);
        let well = mean("well_to_wheel_g_per_km");
        let cost = json(
            &[
                &["cost", "--set", "cost.currency=EUR"][..],
                &["--set", "cost.driver_per_h=1"],
                &asked,
            ]
            .concat(),
        );
        let found = number(&cost["emissions"]["well_to_wheel_kg_per_km"]) * 1000.0;
        assert!((well / found - 1.0).abs() < 1e-9, "{study}: {well} and {found}");
        // total over total: both means have the same tonnes
        let tonnes = well / mean("well_to_wheel_g_per_tkm");
        let (electric, per) = match study {
            "field-truck" => (false, ["consumption_l_per_100km", "consumption_l_per_100tkm"]),
            _ => (true, ["consumption_kwh_per_km", "consumption_kwh_per_tkm"]),
        };
        let [whole, by_tonne] = per.map(mean);
        assert!((tonnes * by_tonne / whole - 1.0).abs() < 1e-9, "{study}: {tonnes} t");
        let [whole, by_tonne] = ["per_km", "per_tkm"].map(|over| number(&cost["total"][over]));
        assert!((tonnes * by_tonne / whole - 1.0).abs() < 1e-9, "{study}: {tonnes} t");
        assert_eq!(run["statistics"]["grid_co2_g_per_km"]["mean"].is_f64(), electric, "{study}");
        if electric {
            // the two factors of the default study
            assert!((mean("grid_co2_g_per_km") / well - 0.214 / 0.291).abs() < 1e-9, "{study}");
        }
    }
    let other = [
        "--cycles",
        "5",
        "--quiet",
        "--set",
        SHORT,
        "--set",
        "emissions.fuel_well_to_wheel_kg_per_l=6.76",
    ];
    let [own, twice] = [&other[..5], &other]
        .map(|asked| number(&json(asked)["statistics"]["well_to_wheel_g_per_km"]["mean"]));
    assert!((twice / own - 2.0).abs() < 1e-12, "{own} and {twice}");
}

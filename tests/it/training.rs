//! Worth of a driver's training, as a user of the command meets it.

use crate::program::ocmc;
use serde_json::Value;

const FLEET: [&str; 9] =
    ["training", "--trucks", "20", "--trips", "6", "--set", "mission.length_m=4000", "--seed", "1"];

fn text(arguments: &[&str]) -> String {
    let output = ocmc(&[&FLEET[..], arguments].concat()).assert().success().get_output().clone();
    String::from_utf8(output.stdout).expect("UTF-8")
}

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&text(&[arguments, &["--json"]].concat())).expect("JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

#[test]
fn the_answer_fits_and_says_what_records_promise_and_training_gives() {
    let prices = ["--set", "cost.currency=EUR", "--set", "cost.fuel_per_l=1.5"];
    let shown = text(&prices);
    assert!(shown.lines().all(|line| line.chars().count() <= 80), "{shown}");
    for part in ["the records show", "the training gives", "EUR per year", "trips recorded"] {
        assert!(shown.contains(part), "{part}: {shown}");
    }
    let answer = json(&prices);
    assert_eq!((&answer["drivers"], &answer["chosen"]), (&20.into(), &4.into()));
    assert_eq!(&answer["pairs"], 120);
    // 1.5 EUR for each litre, and nothing else has a price
    let litres = number(&answer["amount_per_a"]);
    let euros = number(&answer["money_per_a"]);
    assert!((euros - 1.5 * litres).abs() < 0.02 * litres.abs(), "{euros} {litres}");
    // six trips of 4 km
    assert!((number(&answer["distance_m_per_a"]) - 24_000.0).abs() < 30.0);
    // as seen in the test of the estimator, the records promise more
    assert!(number(&answer["shown"]) > number(&answer["gain"]["of_quantity"]));
    assert_eq!(json(&["--threads", "1"])["gain"], json(&["--threads", "2"])["gain"]);
}

#[test]
fn training_that_changes_nothing_gives_nothing() {
    let same = ["--coached", "study.name=coached"];
    let answer = json(&same);
    assert!(number(&answer["gain"]["of_quantity"]).abs() < 1e-12, "{answer}");
    // no auxiliaries at all are seen
    let less = json(&["--coached", "vehicle.auxiliary_power_w=0"]);
    assert!(number(&less["gain"]["of_quantity"]) > 0.1, "{less}");
}

#[test]
fn bad_input_is_refused_by_name() {
    for (arguments, status, part) in [
        (&["--share", "20"][..], 2, "type 20%"),
        (&["--share", "0%"], 2, "above 0%"),
        (&["--trucks", "1"], 2, "--trucks"),
        (&["--coached", "driver.nothing=1"], 1, "driver.nothing"),
    ] {
        let refused = ocmc(&["training"]).args(arguments).assert().code(status);
        let said = String::from_utf8(refused.get_output().stderr.clone()).expect("UTF-8");
        assert!(said.contains(part), "{arguments:?}: {said}");
    }
}

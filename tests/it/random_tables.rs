//! Random studies over all tables: numbers of built-in studies moved within what is allowed, and
//! tables added. Whatever a study asks for: no panic, no number missing or endless, no charge
//! outside [0, 1], energy adds up, no interval without its estimate; and the same of what nine
//! questions answer. `OCMC_RANDOM_TABLES=0..20000` tries these, and holds them to 20 s and 1 GB.

use crate::common::{balance, electric_balance, electric_open_j};
use crate::random_studies::{Chance, check_intervals, check_numbers};
use ocmc_api::ask::{Ask, ask};
use ocmc_api::go_on;
use ocmc_core::energy::Carrier;
use ocmc_core::random::{Draws, Stream};
use ocmc_core::record::Outcome;
use ocmc_fleet::run::{RunPlan, records};
use ocmc_io::study::{self, Files, LoadedStudy, load_json};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// Tables that are laid over a study.
const TABLES: [(&str, &[&str]); 13] = [
    ("/rest", &[r#"{"law": "eu_561"}"#, r#"{"law": "us_395_3", "drivers": 2}"#]),
    ("/mission/stops", &[r#"{"spacing_m": 15e3, "dwell_s": 900}"#]),
    ("/driver/look_ahead/coasting", &["true"]),
    ("/simulation/sampling", &[r#""sobol""#]),
    ("/simulation/without", &[r#"["slope"]"#, r#"["traffic", "weather"]"#, r#"["curves"]"#]),
    ("/simulation/frozen", &[r#"["driver"]"#, r#"["road"]"#, r#"["vehicle", "weather"]"#]),
    ("/fleet", &[r#"{"trips_per_truck": 2}"#, r#"{"trips_per_truck": 4, "drivers_per_truck": 2}"#]),
    (
        "/fleet",
        &[r#"{"trips_per_truck": 4, "calendar": {"operating_days_per_week": 5, "trips_per_day": 2,
            "departure_interval_s": 20e3}}"#],
    ),
    ("/emissions/electricity_well_to_wheel_kg_per_kwh", &["0", "0.9"]),
    (
        "/cost",
        &[r#"{"currency": "EUR", "fuel_per_l": 1.2, "hydrogen_per_kg": 9, "driver_per_h": 30,
            "depot_charging_per_kwh": 0.2, "public_charging_per_kwh": 0.5, "charging_efficiency": 0.9,
            "purchase_per_truck": 1e5, "life_a": 8, "distance_km_per_a": 1e5, "residual_share": 0.2,
            "discount_rate_per_a": 0.05}"#],
    ),
    ("/weather/temperature/truck_sd_k", &["2"]),
    (
        "/charging",
        &[r#"{"reserve": 0.15, "efficiency": 0.9, "depot": {"power_w": 5e4, "parked_s": 3e4}}"#],
    ),
    (
        "/charging",
        &[r#"{"reserve": 0.2, "efficiency": 0.94, "public": {"spacing_m": 30e3, "power_w": 3e5,
            "end_at": 0.8}, "forecast": {"consumption_j_per_m": 5e3, "margin": 0.1}}"#],
    ),
];

/// Seeds from one study of which all questions are asked to the next.
const ASKED_EACH: u64 = 350;

/// Longest time of one processor that a study or an answer may take, in s.
const MOST_S: f64 = 20.0;

/// Places of the numbers of a study, as JSON pointers.
fn numbers(value: &Value, at: &str, places: &mut Vec<String>) {
    match value {
        // not the step: trips by half a millisecond take minutes, as asked for
        Value::Number(_) if at != "/simulation/step_s" => places.push(at.to_owned()),
        Value::Array(items) => {
            for (k, item) in items.iter().enumerate() {
                numbers(item, &format!("{at}/{k}"), places);
            }
        }
        Value::Object(items) => {
            for (name, item) in items {
                numbers(
                    item,
                    &format!("{at}/{}", name.replace('~', "~0").replace('/', "~1")),
                    places,
                );
            }
        }
        _ => {}
    }
}

/// Ends of what the schema allows at a place, where it names both.
fn allowed(schema: &Value, place: &str) -> Option<[f64; 2]> {
    let mut node = schema;
    for step in place.split('/').skip(1) {
        let mut options = node["anyOf"].as_array().into_iter().flatten().chain([node]);
        // the parts of laws have no ends of their own
        node = options.find_map(|option| {
            let named = option["properties"].get(step);
            let any = option.get("additionalProperties").filter(|any| any.is_object());
            named.or(any).or(option.get("items"))
        })?;
    }
    let mut options = node["anyOf"].as_array().into_iter().flatten().chain([node]);
    options.find_map(|option| Some([option["minimum"].as_f64()?, option["maximum"].as_f64()?]))
}

/// Another number in place of one.
fn moved(number: f64, ends: Option<[f64; 2]>, chance: &mut Chance) -> f64 {
    let near = number * chance.size(0.25, 4.0);
    let Some([low, high]) = ends else { return near };
    match chance.between(0.0, 1.0) {
        x if x < 0.1 => low,
        x if x < 0.2 => high,
        x if x < 0.4 => chance.between(low, high),
        _ => near.clamp(low, high),
    }
}

/// Puts a value at a place, with the tables around it where they are not there.
fn put(keys: &mut Value, place: &str, value: Value) {
    let mut node = keys;
    for step in place.split('/').skip(1) {
        node = &mut node[step];
    }
    *node = value;
}

/// The place of the list that a place lies in, or the place itself: lists are given whole.
fn given_whole(place: &str) -> String {
    let is_index = |step: &str| step.parse::<usize>().is_ok();
    let steps: Vec<&str> = place.split('/').collect();
    let end = steps.iter().position(|step| is_index(step)).unwrap_or(steps.len());
    steps[..end].join("/")
}

/// A study that differs from a built-in one in some of its numbers and tables.
fn keys(bases: &[(String, Value)], schema: &Value, chance: &mut Chance) -> Value {
    let (name, base) = &bases[chance.below(bases.len())];
    let mut keys = json!({"study": {"name": "r", "description": "d", "base": name}});
    let mut whole = base.clone();
    let mut places = Vec::new();
    numbers(&whole, "", &mut places);
    for _ in 0..chance.below(7) {
        let place = &places[chance.below(places.len())];
        let value = whole.pointer_mut(place).expect("it was found there");
        let number = moved(value.as_f64().expect("a number"), allowed(schema, place), chance);
        *value = if value.is_f64() { json!(number) } else { json!(number.round() as i64) };
        let given = given_whole(place);
        put(&mut keys, &given, whole.pointer(&given).expect("around it").clone());
    }
    for _ in 0..chance.below(4) {
        let (place, values) = TABLES[chance.below(TABLES.len())];
        put(&mut keys, place, serde_json::from_str(chance.one(values)).expect("JSON"));
    }
    keys
}

/// Answers have numbers only where there are numbers, and no interval without its estimate.
fn check_answer(value: &Value) {
    check_intervals(value);
    if let Some(ci95) = value.get("ci95").and_then(Value::as_array) {
        assert!(ci95.iter().all(Value::is_number), "{value}");
    }
    match value {
        Value::Number(number) => assert!(number.as_f64().is_none_or(f64::is_finite)),
        Value::Object(items) => items.values().for_each(check_answer),
        Value::Array(items) => items.iter().for_each(check_answer),
        _ => {}
    }
}

/// Nine questions about a study.
fn questions(keys: &Value) -> [Value; 9] {
    let plan = json!({"cycles": 6, "threads": 1});
    let study = json!({"study": keys});
    let other = json!({"study": keys, "set": ["mission.payload_kg=5000"], "name": "other"});
    let prices = ["cost.currency=\"EUR\"", "cost.driver_per_h=30"];
    let priced = json!({"study": keys, "set": prices});
    [
        json!({"ask": "run", "study": study, "plan": plan}),
        json!({"ask": "compare", "studies": [study, other], "plan": plan}),
        json!({"ask": "sweep", "study": study, "plan": plan,
            "points": ["mission.payload_kg=1000,9000"]}),
        json!({"ask": "sensitivity", "study": study, "plan": {"cycles": 12, "threads": 1}}),
        json!({"ask": "doubt", "study": study, "plan": plan}),
        json!({"ask": "cost", "study": priced, "plan": plan}),
        json!({"ask": "range", "study": study, "plan": plan}),
        json!({"ask": "bound", "study": study, "plan": {"cycles": 1, "threads": 1}}),
        json!({"ask": "trip", "study": study, "cycle": 3}),
    ]
}

/// Drives a study and checks its records; returns the number of those whose energy adds up, and of
/// those whose battery was overdrawn.
fn drive(study: &LoadedStudy, seed: u64) -> [u64; 2] {
    let plan = RunPlan::new(seed, 0, 4, Some(1), None);
    let ControlFlow::Continue(records) =
        records(&study.study, &plan, |_| ControlFlow::<Infallible>::Continue(()));
    let mut counts = [0; 2];
    for record in &records {
        check_numbers(record);
        if matches!(record.outcome, Outcome::Completed | Outcome::Depleted) {
            let is_electric = record.amount(Carrier::Electricity).is_some();
            let open = if is_electric { electric_balance(record) } else { balance(record) };
            // what an overdrawn battery has not comes from nowhere, and the record says how much at
            // most
            let is_overdrawn = open.abs() >= 1e-9;
            let said_j = record.outside_map_energy_j.unwrap_or(0.0);
            let is_said = is_electric && electric_open_j(record)[0].abs() <= said_j;
            assert!(!is_overdrawn || is_said, "{open}, {said_j} J are said: {record:?}");
            if is_overdrawn {
                println!("{seed}: a battery is overdrawn, {open} of its energy");
            }
            counts[usize::from(is_overdrawn)] += 1;
        }
    }
    counts
}

/// Time of the processors that this process has taken so far, in s, where the system tells it; the
/// time of the clock otherwise.
fn taken_s(since: Instant) -> f64 {
    let ticks = || -> Option<u64> {
        let text = std::fs::read_to_string("/proc/self/stat").ok()?;
        // behind the name, which may have spaces
        let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
        Some(fields.get(11)?.parse::<u64>().ok()? + fields.get(12)?.parse::<u64>().ok()?)
    };
    ticks().map_or(since.elapsed().as_secs_f64(), |ticks| ticks as f64 / 100.0)
}

/// Largest memory of this process so far, where the system tells it.
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse::<u64>().ok().map(|kib| 1024 * kib)
}

#[test]
fn random_studies_over_all_tables_are_answered_or_refused_in_words() {
    let asked = std::env::var("OCMC_RANDOM_TABLES").ok();
    let (is_alone, begun) = (asked.is_some(), Instant::now());
    let seeds = asked.as_deref().unwrap_or("0..500").split_once("..").expect("two numbers");
    let [first, end]: [u64; 2] = [seeds.0, seeds.1].map(|seed| seed.parse().expect("a number"));
    let bases: Vec<(String, Value)> = study::list()
        .iter()
        .map(|built_in| {
            let loaded = study::load::<&str>(built_in.name, &[]).expect("built in");
            (built_in.name.to_owned(), serde_json::to_value(&loaded.model).expect("keys"))
        })
        .collect();
    let schema = study::schema();
    let (mut driven, mut slowest) = (0, (0.0, 0));
    let mut replies: BTreeMap<String, [u64; 2]> = BTreeMap::new();
    let (mut faults, mut balances) = (Vec::new(), [0; 2]);
    for seed in first..end {
        let mut chance = Chance(Draws::new(seed, 1, Stream::Vehicle));
        let keys = keys(&bases, &schema, &mut chance);
        let mut timed = |work: &mut dyn FnMut()| {
            let before_s = taken_s(begun);
            let tried = catch_unwind(AssertUnwindSafe(work));
            let took_s = taken_s(begun) - before_s;
            if took_s > slowest.0 {
                slowest = (took_s, seed);
            }
            if tried.is_err() || is_alone && took_s > MOST_S {
                faults.push(seed);
                println!("{seed}: {took_s} s: {keys}");
            }
        };
        let mut is_study = false;
        timed(&mut || match load_json::<&str>(&keys, &[]) {
            Ok(loaded) => {
                is_study = true;
                let counts = drive(&loaded, seed);
                balances = [balances[0] + counts[0], balances[1] + counts[1]];
            }
            Err(error) => assert!(error.to_string().len() > 20, "{error}"),
        });
        driven += u64::from(is_study);
        if !is_study || seed % ASKED_EACH != 0 {
            continue;
        }
        for question in questions(&keys) {
            let kind = question["ask"].as_str().expect("a word").to_owned();
            let question: Ask = serde_json::from_value(question).expect("a question");
            let counts = replies.entry(kind).or_default();
            timed(&mut || match ask(&question, &Files::here(), &mut go_on) {
                Ok(reply) => {
                    counts[0] += 1;
                    check_answer(&serde_json::to_value(&reply).expect("numbers and words"));
                }
                Err(error) => {
                    counts[1] += 1;
                    assert!(error.to_string().len() > 20, "{error}");
                }
            });
        }
    }
    let peak = peak_bytes();
    let tried = end - first;
    println!("{driven} of {tried} driven; slowest (s, seed) {slowest:?}; at most {peak:?} bytes");
    println!("answered, refused: {replies:?}; balances closed, overdrawn: {balances:?}");
    assert!(faults.is_empty(), "seeds {faults:?}");
    assert!(!is_alone || peak.is_none_or(|bytes| bytes < 1_000_000_000), "{peak:?} bytes");
    // most are studies, and each question was asked
    assert!(tried < 100 || 10 * driven >= 5 * tried, "{driven} of {tried}");
    let answered = replies.iter().filter(|(kind, [answered, _])| *answered > 0 || *kind == "range");
    assert!(is_alone || answered.count() == 9, "{replies:?}");
    // overdrawn batteries are rare: they do not hide an open balance
    assert!(100 * balances[1] <= balances[0], "{balances:?}");
}

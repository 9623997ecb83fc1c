//! Effect of judged numbers on an answer: the same as two runs that are laid side by side by hand;
//! and a run says it without driving.

use crate::program::ocmc;
use ocmc_api::{
    Answer, CompareRequest, DoubtRequest, GivenDrive, RunPlan, RunRequest, compare, doubt, go_on,
    run, study,
};
use ocmc_io::study::{End, LoadedStudy};
use serde_json::Value;

const SHORT: &str = "mission.length_m=4000";
const LITRES: &str = "consumption_l_per_100km";

fn loaded(sets: &[&str]) -> LoadedStudy {
    study::load("field-truck", sets).expect("a study")
}

fn asked(a: &LoadedStudy, b: Option<&LoadedStudy>, cycles: u64, threads: usize) -> Value {
    let request = DoubtRequest {
        study: ("a".to_owned(), a),
        against: b.map(|b| ("b".to_owned(), b)),
        plan: RunPlan::new(3, 0, cycles, Some(threads), None),
        column: None,
    };
    let answer = doubt(&request, &mut go_on).expect("judged numbers");
    assert!(answer.text().lines().all(|line| line.chars().count() <= 80), "{}", answer.text());
    serde_json::from_str(&answer.to_json()).expect("JSON")
}

fn entry<'a>(answer: &'a Value, name: &str) -> &'a Value {
    let numbers = answer["numbers"].as_array().expect("a list");
    numbers.iter().find(|entry| entry["name"] == name).unwrap_or_else(|| panic!("{name}"))
}

/// B less A, by a comparison.
fn difference(a: &LoadedStudy, b: &LoadedStudy, cycles: u64) -> f64 {
    let request = CompareRequest {
        studies: vec![("a".to_owned(), a), ("b".to_owned(), b)],
        plan: RunPlan::new(3, 0, cycles, Some(2), None),
        column: Some(LITRES.to_owned()),
        keep: false,
    };
    let answer = compare(&request, &mut go_on).expect("two studies");
    answer.comparisons[0].comparison.difference.expect("pairs")
}

#[test]
fn the_changes_are_those_of_a_comparison_with_the_ends_typed() {
    let own = loaded(&[SHORT]);
    let answer = asked(&own, None, 100, 2);
    let typed = [
        ("motorway_truck_limit", "low", "road.types.motorway.truck_limit_mps=22.22222"),
        ("urban_length", "high", "road.types.urban.mean_length_m=8000"),
        ("speed_limiter", "low", ""),
    ];
    for (name, end, set) in typed {
        let told = entry(&answer, name)[end]["mean"]["by"].as_f64().expect("cycles");
        let other = if set.is_empty() {
            let numbers = own.judged().iter().find(|numbers| numbers.name == name).expect("judged");
            own.at_end(numbers, End::Low).expect("a study")
        } else {
            loaded(&[SHORT, set])
        };
        let by_hand = difference(&own, &other, 100);
        assert!((told - by_hand).abs() < 1e-9, "{name}: {told} {by_hand}");
    }
    let squares = answer["numbers"].as_array().expect("a list").iter();
    let shares: f64 = squares.map(|entry| entry["share"].as_f64().expect("a share")).sum();
    assert!((shares - 1.0).abs() < 1e-9, "{shares}");
    // whoever drives them
    let alone = asked(&own, None, 100, 1);
    assert_eq!(answer["numbers"], alone["numbers"]);
}

#[test]
fn a_difference_moves_both_studies_where_both_have_the_number() {
    let a = loaded(&[SHORT]);
    // B has typed its urban stretches: that number is judged in A alone
    let b = loaded(&[SHORT, "road.types.urban.mean_length_m=5000", "vehicle.curb_mass_kg=14000"]);
    let answer = asked(&a, Some(&b), 100, 2);
    let unmoved = difference(&a, &b, 100);
    assert!((answer["mean"].as_f64().expect("pairs") - unmoved).abs() < 1e-9);
    let limit = "road.types.motorway.truck_limit_mps=22.22222";
    let (low_a, low_b) = (a.set(&[limit]).expect("one"), b.set(&[limit]).expect("one"));
    let told = entry(&answer, "motorway_truck_limit")["low"]["mean"]["by"].as_f64();
    let by_hand = difference(&low_a, &low_b, 100) - unmoved;
    assert!((told.expect("cycles") - by_hand).abs() < 1e-9, "{told:?} {by_hand}");
    let high_a = a.set(&["road.types.urban.mean_length_m=8000"]).expect("one");
    let told = entry(&answer, "urban_length")["high"]["mean"]["by"].as_f64();
    let by_hand = difference(&high_a, &b, 100) - unmoved;
    assert!((told.expect("cycles") - by_hand).abs() < 1e-9, "{told:?} {by_hand}");
    // a study against itself: nothing is left of it
    let same = asked(&a, Some(&a), 100, 2);
    assert_eq!(same["together"]["mean"], 0.0);
}

#[test]
fn a_run_says_what_hangs_on_judged_numbers_and_keeps_it() {
    let folder = tempfile::tempdir().expect("a directory");
    let answer = |name: &str, sets: &[&str]| {
        let directory = folder.path().join(name);
        let own = loaded(sets);
        let request = RunRequest {
            study: &own,
            given: &GivenDrive::nothing(),
            plan: RunPlan::new(1, 0, 20, None, None),
            precision: None,
            out: Some((directory.clone(), ocmc_api::RecordFormat::Csv)),
        };
        let text = run(&request, &mut |_| (), &mut go_on).expect("space").text();
        let stored = ocmc_api::load(directory, |_| ()).expect("a run");
        let line =
            |text: &str| text.lines().find(|line| line.contains("judged")).map(str::to_owned);
        assert_eq!(line(&text), line(&stored.text()));
        (text, serde_json::to_value(&stored.summary).expect("JSON"))
    };
    let (text, summary) = answer("about", &[SHORT]);
    let mean = summary["statistics"][LITRES]["mean"].as_f64().expect("cycles");
    let plus_minus = summary["judged"]["plus_minus"].as_f64().expect("stored");
    let share = summary["judged"]["stored"]["share_of_mean"].as_f64().expect("stored");
    assert!((plus_minus - share * mean).abs() < 1e-9 && share > 0.05);
    assert!(text.contains("about ± ") && text.contains("see ocmc doubt"), "{text}");
    assert!(!text.lines().any(|line| line.contains("judged") && line.contains("95 %")), "{text}");
    let (text, _) = answer("other-truck", &[SHORT, "vehicle.base=rigid-12t"]);
    assert!(text.contains("± unknown from judged numbers"), "{text}");
}

#[test]
fn a_comparison_says_how_little_hangs_on_judged_numbers() {
    let a = loaded(&[SHORT]);
    let b = a.set(&["vehicle.drag_area_m2=4.5"]).expect("a study");
    let request = CompareRequest {
        studies: vec![("a".to_owned(), &a), ("b".to_owned(), &b)],
        plan: RunPlan::new(3, 0, 400, Some(2), None),
        column: None,
        keep: false,
    };
    let answer = compare(&request, &mut go_on).expect("two studies");
    let judged = answer.comparisons[0].judged.as_ref().expect("judged numbers");
    let of_mean = 0.1 * answer.comparisons[0].comparison.a.expect("pairs");
    assert_eq!((judged.cycles, judged.moved.len()), (20, 5));
    assert!(judged.plus_minus.is_some_and(|plus_minus| plus_minus < of_mean), "{judged:?}");
    assert!(answer.text().contains("judged             ± "), "{}", answer.text());
}

#[test]
fn what_is_fitted_or_typed_says_where_it_is_from() {
    let folder = tempfile::tempdir().expect("a directory");
    let weather = folder.path().join("weather.csv");
    let rows = (0..9000).map(|hour| {
        let phase = f64::from(hour % 24) / 24.0 * std::f64::consts::TAU;
        let noise = f64::from((hour * 7919) % 101) / 25.0;
        format!("{},{}\n", 3600 * hour, 8.0 - 4.0 * phase.cos() + noise)
    });
    let text = rows.fold("time_s,temperature_c\n".to_owned(), |text, row| text + &row);
    std::fs::write(&weather, text).expect("space");
    let study = folder.path().join("mine.toml");
    let fit = ["fit", "weather", weather.to_str().expect("letters"), "--study-out"];
    let fitted = ocmc(&fit).arg(&study).output().expect("it starts");
    assert!(fitted.status.success(), "{}", String::from_utf8_lossy(&fitted.stderr));
    let own = study::load(study.to_str().expect("letters"), &[SHORT]).expect("a study");
    let standing = |key: &str| {
        let replaced = own.replaced().iter().find(|number| number.key == key);
        replaced.unwrap_or_else(|| panic!("{key}")).standing.clone()
    };
    let from = standing("weather.temperature.mean_k");
    assert!(
        from.starts_with("fitted from 9,000 rows of `") && from.contains("weather.csv"),
        "{from}"
    );
    assert_eq!(standing("mission.length_m"), "typed in --set");
    assert!(own.judged().iter().all(|numbers| numbers.name != "air_temperature"));
}

#[test]
fn the_command_writes_table_json_and_page() {
    let folder = tempfile::tempdir().expect("a directory");
    let out = folder.path().join("d");
    let sets = ["--set", "mission.length_m=3000", "--cycles", "20", "--quiet"];
    let directory = out.to_str().expect("letters");
    let told = |more: &[&str]| {
        let output = ocmc(&[&["doubt"], &sets[..], more].concat()).output().expect("it starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    let text = told(&["--out", directory]);
    assert!(text.contains("No confidence interval") && text.contains("payload"), "{text}");
    let answer: Value = serde_json::from_str(&told(&["--json"])).expect("JSON");
    assert_eq!(answer["numbers"][0]["standing"], "judged");
    for file in ["doubt.json", "doubt.csv", "report.html", "study.toml"] {
        assert!(out.join(file).is_file(), "{file}");
    }
}

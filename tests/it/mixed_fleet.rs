//! A fleet of groups of trucks: what it adds up to, and that a group is its study alone.

use crate::program::ocmc;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

const FLEET: &str = r#"
study = { base = "field-truck", name = "ours" }
mission = { length_m = 5000.0 }
[cost]
currency = "EUR"
fuel_per_l = 1.5
depot_charging_per_kwh = 0.2
charging_efficiency = 0.9
[fleet]
trips_per_truck = 6
[[fleet.group]]
name = "near"
trucks = 7
[[fleet.group]]
name = "far"
trucks = 3
study = "long-haul"
fleet = { trips_per_truck = 4 }
[[fleet.group]]
name = "electric"
trucks = 2
vehicle = { base = "tractor-electric-40t" }
"#;

fn written(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    fs::write(&path, text).expect("space");
    path.display().to_string()
}

fn json(arguments: &[&str]) -> Value {
    let output = ocmc(&[arguments, &["--json", "--quiet"]].concat()).assert().success();
    serde_json::from_slice(&output.get_output().stdout).expect("JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

/// The total of that name, and half of its interval.
fn total(of: &Value, name: &str) -> Option<(f64, f64)> {
    let totals = of["totals"].as_array().expect("a list");
    let total = totals.iter().find(|total| total["name"] == name)?;
    let [low, high] = [0, 1].map(|k| number(&total["prediction95"][k]));
    Some((number(&total["total"]), (high - low) / 2.0))
}

fn records(directory: &Path) -> Vec<u8> {
    fs::read(directory.join("records.csv")).expect("written")
}

#[test]
fn groups_add_up_to_the_whole() {
    let folder = tempfile::tempdir().expect("a directory");
    let study = written(folder.path(), "fleet.toml", FLEET);
    let answer = json(&["--study", &study, "--seed", "4"]);
    let groups = answer["groups"].as_array().expect("three groups");
    let names = ["fuel", "electricity", "CO2", "WTW CO2e", "cost", "distance", "time"];
    let order = answer["totals"].as_array().expect("a list").iter();
    assert_eq!(order.map(|total| total["name"].clone()).collect::<Vec<_>>(), names);
    for name in names {
        let (whole, half) = total(&answer, name).expect("a total");
        let parts: Vec<_> = groups.iter().filter_map(|group| total(group, name)).collect();
        let sum: f64 = parts.iter().map(|(part, _)| part).sum();
        assert!((whole / sum - 1.0).abs() < 1e-12, "{name}: {whole} {sum}");
        // groups drive apart from one another: their variances add up
        let squares: f64 = parts.iter().map(|(_, half)| half * half).sum();
        assert!((half / squares.sqrt() - 1.0).abs() < 1e-9, "{name}: {half}");
    }
    // the records of a group know the same litres
    let fuel = groups[1]["run"]["trucks"]["fleet_year"]["fuel_l"]["total"].clone();
    assert_eq!(total(&groups[1], "fuel").expect("diesel").0, number(&fuel));
    // the cost of a group is what `cost` says of it
    let own = ["--set", "fleet.group=near", "--trucks", "7", "--seed", "4"];
    let cost = json(&[&["cost", "--study", &study][..], &own].concat());
    let (near, _) = total(&groups[0], "cost").expect("prices");
    assert!((number(&cost["fleet"]["cost"]["total"]) / near - 1.0).abs() < 1e-12, "{cost}");
    assert!((number(&cost["total"]["all_trips"]) / near - 1.0).abs() < 1e-12, "{cost}");
    let fuel = total(&groups[0], "fuel").expect("diesel").0;
    assert!((near / (1.5 * fuel) - 1.0).abs() < 1e-9, "{near} {fuel}");
}

#[test]
fn shared_days_widen_the_whole_to_the_sum_of_its_groups() {
    let folder = tempfile::tempdir().expect("a directory");
    let shared = FLEET
        .replace("trips_per_truck = 6", "trips_per_truck = 6\nlevels = { temperature = \"day\" }");
    let study = written(folder.path(), "fleet.toml", &shared);
    let answer = json(&["--study", &study]);
    let groups = answer["groups"].as_array().expect("three groups");
    let (_, half) = total(&answer, "time").expect("a total");
    let sum: f64 = groups.iter().map(|group| total(group, "time").expect("time").1).sum();
    assert!((half / sum - 1.0).abs() < 1e-9, "{half} {sum}");
}

#[test]
fn a_group_has_the_bytes_of_its_study_alone() {
    let folder = tempfile::tempdir().expect("a directory");
    let at = |name: &str| -> (PathBuf, String) {
        let path = folder.path().join(name);
        (path.clone(), path.display().to_string())
    };
    let study = written(folder.path(), "fleet.toml", FLEET);
    let (whole, out) = at("whole");
    let csv = ["--format", "csv", "--seed", "9", "--quiet"];
    ocmc(&[&["--study", &study, "--out", &out][..], &csv].concat()).assert().success();
    let answer: Value =
        serde_json::from_slice(&fs::read(whole.join("fleet.json")).expect("written"))
            .expect("JSON");
    let page = fs::read_to_string(whole.join("report.html")).expect("written");
    assert!(page.contains("in 3 groups, ") && page.contains("How many can be electric"), "{page}");
    // trucks are numbered through, and so are trips: 42 of the first group, so the second, with 4
    // a truck, begins with its truck 11
    let firsts: Vec<u64> = answer["groups"]
        .as_array()
        .expect("groups")
        .iter()
        .map(|group| group["first_truck"].as_u64().expect("a truck"))
        .collect();
    assert_eq!(firsts, [0, 11, 14]);
    let other = "study = { base = \"field-truck\", name = \"alone\" }\n\
                 mission = { length_m = 5000.0 }\n\
                 fleet = { trips_per_truck = 6 }\nvehicle = { base = \"tractor-electric-40t\" }\n\
                 cost = { currency = \"EUR\", depot_charging_per_kwh = 0.3, charging_efficiency = \
                 0.9 }";
    let alone = written(folder.path(), "alone.toml", other);
    let chosen = ["--set", "fleet.group=far"];
    for (name, study, set, trips, trucks, first) in
        [("far", &study, &chosen[..], 4, "3", 11), ("electric", &alone, &[], 6, "2", 14)]
    {
        let (directory, out) = at(&format!("{name}-alone"));
        let first = (trips * first).to_string();
        let range = ["--trucks", trucks, "--first-cycle", &first, "--out", &out];
        let all = [&["--study", study][..], &range, set, &csv].concat();
        ocmc(&all).assert().success();
        assert_eq!(records(&directory), records(&whole.join(name)), "{name}");
    }
    // a fleet that was ended goes on, group by group
    let far = records(&whole.join("far"));
    fs::remove_dir_all(whole.join("far")).expect("a run");
    ocmc(&[&["--study", &study, "--out", &out, "--resume"][..], &csv].concat()).assert().success();
    assert_eq!(records(&whole.join("far")), far);
}

#[test]
fn it_is_said_how_many_trucks_could_be_electric() {
    let folder = tempfile::tempdir().expect("a directory");
    let study = written(folder.path(), "fleet.toml", FLEET);
    let answer = json(&["--study", &study]);
    let found = answer["replaceable"].as_array().expect("a list");
    assert_eq!(found.len(), 2, "{found:?}");
    // trips of 5 km arrive with any battery
    assert_eq!(found[0]["group"], "near");
    assert_eq!(
        (&found[0]["arrivals"][0]["trucks"], &found[0]["arrivals"][0]["of"]),
        (&7.into(), &7.into())
    );
    let output = ocmc(&["--study", &study, "--quiet"]).assert().success();
    let text = String::from_utf8(output.get_output().stdout.clone()).expect("UTF-8");
    assert!(
        text.contains("How many can be electric") && text.contains("12 trucks in 3 groups"),
        "{text}"
    );
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
}

#[test]
fn wrong_groups_are_refused_with_their_place() {
    let folder = tempfile::tempdir().expect("a directory");
    for (from, to, piece) in [
        ("trucks = 7", "trucks = 0", "a whole number from 1"),
        ("trucks = 7", "", "`fleet.group.0.trucks` is missing"),
        ("name = \"far\"", "name = \"near\"", "that no other group has"),
        ("name = \"far\"", "name = \"../x\"", "a name of letters"),
        ("name = \"far\"", "nam = \"far\"", "`fleet.group.1.name` is missing"),
        ("study = \"long-haul\"", "study = \"long-hall\"", "`long-haul`"),
        ("study = \"long-haul\"", "study = 3", "the name of a study"),
        ("trips_per_truck = 4", "trips_per_truck = 1", "group `far` make one trip each"),
        ("vehicle = { base", "vehikel = { base", "vehikel"),
    ] {
        let study = written(folder.path(), "wrong.toml", &FLEET.replace(from, to));
        let output = ocmc(&["--study", &study]).assert().code(1).get_output().clone();
        let text = String::from_utf8(output.stderr).expect("UTF-8");
        assert!(text.contains(piece), "{piece}: {text}");
    }
    let study = written(folder.path(), "fleet.toml", FLEET);
    for (arguments, code, piece) in [
        (&["compare", &study, "field-truck"][..], 1, "--set fleet.group=near"),
        (&["--study", &study, "--set", "fleet.group=elektric"], 1, "did you mean `electric`"),
        (&["--study", "field-truck", "--set", "fleet.group=near"], 1, "no `[[fleet.group]]`"),
        (&["--study", &study, "--cycles", "5"], 2, "--cycles does not go"),
    ] {
        let output = ocmc(arguments).assert().code(code).get_output().clone();
        let text = String::from_utf8(output.stderr).expect("UTF-8");
        assert!(text.contains(piece), "{piece}: {text}");
    }
}

#[test]
fn all_runs_of_a_fleet_are_checked_and_get_a_report() {
    let folder = tempfile::tempdir().expect("a directory");
    let study = written(folder.path(), "fleet.toml", FLEET);
    let whole = folder.path().join("whole");
    let out = whole.display().to_string();
    let told = |arguments: &[&str], code: i32| {
        let output = ocmc(arguments).assert().code(code).get_output().clone();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
        (text(output.stdout), text(output.stderr))
    };
    let hint = told(&["--study", &study, "--out", &out], 0).1;
    assert!(hint.contains("`ocmc report "), "{hint}");
    // reports of all groups, in the order of the file
    let (_, hint) = told(&["report", &out], 0);
    let reports = ["near", "far", "electric"].map(|group| whole.join(group).join("report.html"));
    assert!(reports.iter().all(|report| report.exists()), "{hint}");
    let named = reports.map(|report| format!("`{}`", report.display())).join(", ");
    assert!(hint.contains(&format!("Written: {named}. Any browser opens them.")), "{hint}");
    let page = folder.path().join("page.html").display().to_string();
    let (_, refused) = told(&["report", &out, "--out", &page], 2);
    assert!(refused.contains("holds 3 runs") && refused.contains("/near`"), "{refused}");
    assert_eq!(told(&["report", &out, "--quiet"], 0).1, "");
    // checks of all groups: one that is damaged, then one that is missing
    let (text, _) = told(&["verify", &out], 0);
    assert!(text.contains("whole    far/manifest.json") && !text.contains("damaged"), "{text}");
    let (text, error) = told(&["range", &out], 1);
    assert!(
        error.contains(&format!("but runs: `{}`", whole.join("near").display())),
        "{text}{error}"
    );
    fs::write(whole.join("far").join("summary.json"), "{}").expect("space");
    let (text, error) = told(&["verify", &out], 1);
    assert!(text.contains("damaged  far/summary.json") && error.contains("is not whole"), "{text}");
    fs::remove_dir_all(whole.join("far")).expect("a run");
    let (text, _) = told(&["verify", &out], 1);
    assert!(text.contains("damaged  far/manifest.json"), "{text}");
}

#[test]
fn a_folder_in_which_any_group_has_a_run_is_refused_before_the_first_is_driven() {
    let folder = tempfile::tempdir().expect("a directory");
    let study = written(folder.path(), "fleet.toml", FLEET);
    let whole = folder.path().join("whole");
    let out = whole.display().to_string();
    let refused = |piece: &str| {
        let output = ocmc(&["--study", &study, "--out", &out]).assert().code(1);
        let text = String::from_utf8(output.get_output().stderr.clone()).expect("UTF-8");
        assert!(text.contains(piece) && text.contains("already holds a run"), "{text}");
        assert!(!whole.join("near").exists());
    };
    let last = whole.join("electric");
    let one = ["--cycles", "3", "--set", "mission.length_m=3000", "--quiet", "--out"];
    ocmc(&[&one[..], &[&last.display().to_string()]].concat()).assert().success();
    refused(&last.display().to_string());
    fs::remove_dir_all(&last).expect("a run");
    fs::write(whole.join("fleet.json"), "{}").expect("space");
    refused("the answer of a fleet");
    fs::rename(whole.join("fleet.json"), whole.join("report.html")).expect("space");
    refused("`report.html`, a report");
    fs::remove_dir_all(&whole).expect("a folder");
    ocmc(&[&one[..], &[&out]].concat()).assert().success();
    refused(&out);
}

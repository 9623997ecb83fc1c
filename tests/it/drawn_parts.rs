//! Parts that a route lacks and has drawn: on the command line, in studies and in reports.

use crate::program::ocmc;
use std::fs;
use std::path::Path;
use std::process::Output;

fn driven(folder: &Path, text: &str, words: &[&str]) -> Output {
    let file = folder.join("plan.csv");
    fs::write(&file, text).unwrap();
    let file = file.to_str().unwrap();
    ocmc(&[&["drive", file], words].concat()).output().unwrap()
}

fn errors(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// The rows of records without their route, and the routes.
fn without_route(text: &str) -> (Vec<String>, Vec<String>) {
    let place = text.lines().next().unwrap().split(',').position(|name| name == "route_id");
    let row = |line: &str| {
        let mut cells: Vec<&str> = line.split(',').collect();
        let route = cells.remove(place.unwrap()).to_owned();
        (cells.join(","), route)
    };
    text.lines().skip(1).map(row).unzip()
}

#[test]
fn a_plan_of_places_and_kilometres_is_the_study_on_roads_of_that_length() {
    let folder = tempfile::tempdir().unwrap();
    let [own, plan] = ["own", "plan"].map(|name| folder.path().join(name));
    let [own_out, plan_out] = [&own, &plan].map(|path| path.to_str().unwrap());
    let run = ["--cycles", "20", "--seed", "7", "--format", "csv", "--quiet", "--out"];
    let length = ["--set", "mission.length_m=62000"];
    ocmc(&[&length[..], &run, &[own_out]].concat()).assert().success();
    let draw = ["--draw", "stops,limits", "--draw", "hills,curves"];
    let output =
        driven(folder.path(), "position_m\n0\n62000\n", &[&draw[..], &run, &[plan_out]].concat());
    assert!(output.status.success(), "{}", errors(&output));
    let records = [&own, &plan].map(|path| fs::read_to_string(path.join("records.csv")).unwrap());
    assert_eq!(records[0].lines().count(), 21);
    // but for the route, which a drawn road is none of
    let [(own, roads), (planned, routes)] = records.each_ref().map(|text| without_route(text));
    assert_eq!(own, planned);
    assert!(roads.iter().all(String::is_empty) && routes.iter().all(|route| route == "0"));
    // the report names what was drawn
    ocmc(&["report", plan_out]).assert().success();
    let report = fs::read_to_string(plan.join("report.html")).unwrap();
    assert!(report.contains("where it lacks them with drawn stops and limits and hills"));
    // the run goes on with the same parts, in any order, and with no others
    let resume = ["--resume", "--cycles", "20", "--seed", "7", "--out", plan_out];
    let turned = ["--draw", "curves,hills,limits,stops"];
    let again = driven(folder.path(), "position_m\n0\n62000\n", &[&turned[..], &resume].concat());
    assert!(again.status.success(), "{}", errors(&again));
    let other = ["--draw", "limits"];
    let other = driven(folder.path(), "position_m\n0\n62000\n", &[&other[..], &resume].concat());
    assert!(!other.status.success());
}

#[test]
fn the_account_says_what_is_drawn_and_the_command_repeats_it() {
    let folder = tempfile::tempdir().unwrap();
    let text = "position_m,speed_limit_kmh\n0,50\n3000,80\n9000,80\n";
    let output = driven(folder.path(), text, &["--cycles", "4", "--draw", "stops,hills,curves"]);
    let message = errors(&output);
    assert!(output.status.success(), "{message}");
    for words in [
        "stops, hills, curves: drawn from the study's laws of each road type",
        "its road types are drawn, too, given its limits",
        "draw = [\\\"stops\\\", \\\"hills\\\", \\\"curves\\\"]",
    ] {
        assert!(message.contains(words) || message.contains(&words.replace('\\', "")), "{message}");
    }
    assert!(!message.contains("[lacks]"), "{message}");
    let output = driven(folder.path(), text, &["--cycles", "4", "--draw", "hills"]);
    let message = errors(&output);
    assert!(message.contains("it has no curves, no stops"), "{message}");
    assert!(message.contains("`--draw stops,curves`"), "{message}");
}

#[test]
fn what_cannot_be_drawn_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let no_limits = "position_m,altitude_m\n0,0\n3000,10\n";
    let lights = "position_m,speed_limit_kmh,map_object\n0,50,\n900,50,traffic_light\n2000,50,\n";
    for (text, draw, words) in [
        (no_limits, "hills", "--draw limits"),
        (lights, "hills", "`traffic_light` at 900 m"),
        (no_limits, "lights", "stops, limits, hills, curves"),
    ] {
        let output = driven(folder.path(), text, &["--cycles", "2", "--draw", draw]);
        let message = errors(&output);
        assert!(!output.status.success() && message.contains(words), "{message}");
    }
    let output = driven(folder.path(), lights, &["--cycles", "2", "--draw", "stops"]);
    assert!(output.status.success(), "{}", errors(&output));
    let speed = "time_s,speed_mps\n0,0\n10,10\n60,10\n70,0\n";
    let follow = ["--follow-speed", "exact", "--draw", "stops", "--cycles", "1"];
    let output = driven(folder.path(), speed, &follow);
    assert_eq!(output.status.code(), Some(2));
    assert!(errors(&output).contains("--draw: `"), "{}", errors(&output));
}

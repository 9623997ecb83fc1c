//! `ocmc fit fleet` as a user meets it: tables, run directories, and failures that say what to do.

use crate::program::{ocmc, run_into};
use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::Path;

fn run(arguments: &[&str]) -> (i32, String, String) {
    let output = ocmc(&["fit", "fleet"]).args(arguments).output().expect("the program starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    let (stdout, stderr) = (text(output.stdout), text(output.stderr));
    assert!(!stderr.contains("panicked"), "{arguments:?}: {stderr}");
    (output.status.code().unwrap_or(-1), stdout, stderr)
}

fn answer(arguments: &[&str]) -> String {
    let (status, stdout, stderr) = run(arguments);
    assert_eq!(status, 0, "{arguments:?}: {stderr}");
    stdout
}

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&answer(&[arguments, &["--json"]].concat())).expect("JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("no number: {value}"))
}

/// Six trucks with two drivers each and five trips of each pair; the levels of trucks are 0, 5, 4,
/// … 1, those of drivers ±0.5, those of trips -1 to 1.
fn table() -> String {
    let mut text = String::from("truck_id,driver_id,consumption_l_per_100km,size\n");
    for truck in 0..6 {
        for driver in 0..2 {
            for trip in 0..5 {
                let level = 30.0 + f64::from((truck * 5) % 6) + f64::from(driver) - 0.5;
                let value = level + 0.5 * f64::from((trip * 2 + truck) % 5 - 2);
                let km = 100 + 20 * trip;
                writeln!(text, "{truck},{truck}{driver},{value},{km}").expect("memory");
            }
        }
    }
    text
}

fn written(directory: &Path, name: &str, text: &str) -> String {
    let path = directory.join(name);
    fs::write(&path, text).expect("a file");
    path.to_str().expect("UTF-8").to_owned()
}

#[test]
fn a_table_is_answered_in_text_and_json() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = &written(directory.path(), "records.csv", &table());
    let text = answer(&[path]);
    for part in [
        "60 trips of 6 trucks by 12 drivers, each in one truck; L/100 km",
        "between trucks",
        "between drivers",
        "differ by 1 % (0.3",
        "two trucks, each with 2 drivers of its own",
        "League of trucks, the lowest first",
        "P(the first three are truly the first three)",
        "a new truck",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let fit = json(&[path]);
    // analysis of variance: trips within drivers have a mean square of 0.25 · 10/4
    let trip = number(&fit["components"][2]["sd"]);
    assert!((trip * trip - 0.625).abs() < 1e-6, "{trip}");
    // drivers: 5 · 0.5 = (mean square), so (2.5 - 0.625)/5; trucks: variance of 0…5 is 3.5
    let driver = number(&fit["components"][1]["sd"]);
    assert!((driver * driver - 0.375).abs() < 1e-5, "{driver}");
    let truck = number(&fit["components"][0]["sd"]);
    assert!((truck * truck - (3.5 - 0.25)).abs() < 1e-5, "{truck}");
    assert_eq!(fit["leagues"][0]["members"][0]["label"], "0");
    let highest = json(&[path, "--best", "highest"]);
    assert_eq!(highest["leagues"][0]["members"][0]["label"], "1");
    // separators and names of columns
    let other = table().replace(',', ";").replace("truck_id", "plate");
    let other = written(directory.path(), "other.csv", &other);
    let without_inputs = |mut fit: Value| {
        fit.as_object_mut().expect("a table").remove("inputs").expect("what was read");
        fit
    };
    let of_other = json(&[&other, "--map", "truck=plate"]);
    assert_eq!(without_inputs(of_other), without_inputs(fit.clone()));
    // options
    let wide = json(&[path, "--differ", "10%"]);
    let difference = number(&wide["telling_apart"][0]["difference"]);
    assert!((difference - 3.25).abs() < 1e-9, "{difference}");
    assert_eq!(json(&[path, "--weight", "size"])["weight"], "size");
    assert_eq!(json(&[path, "--next-trips", "7"])["next_year"]["fleet"]["trips"], 42);
    let alone = json(&[path, "--column", "size"]);
    assert_eq!(alone["components"][0]["sd"], 0.0);
    assert!(alone["components"][0]["standard_error"].is_null());
}

#[test]
fn the_records_of_a_run_are_read_from_its_directory() {
    let directory = tempfile::tempdir().expect("a directory");
    for format in ["parquet", "csv"] {
        let out = directory.path().join(format);
        run_into(&out, &["--cycles", "60", "--format", format]);
        let out = out.to_str().expect("UTF-8");
        // whatever repeats will do for a truck: here the number of stops
        let fit = json(&[out, "--map", "truck=n_stops", "--column", "wheel_kwh_per_km"]);
        assert_eq!(fit["n"], 60, "{fit}");
        let manifest = format!("{out}/manifest.json");
        let same = json(&[&manifest, "--map", "truck=n_stops", "--column", "wheel_kwh_per_km"]);
        assert_eq!(same, fit);
        let (status, _, message) = run(&[out, "--map", "truck=outcome"]);
        assert_eq!(status, 1);
        assert!(message.contains("60 trips of 1 trucks"), "{message}");
        // trips that did not arrive do not count
        let (status, _, message) =
            run(&[out, "--map", "truck=n_stops", "--map", "outcome=distance_m"]);
        assert_eq!(status, 1);
        assert!(message.contains("60 not completed"), "{message}");
    }
}

#[test]
fn what_cannot_be_answered_says_why() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = &written(directory.path(), "records.csv", &table());
    for (options, status, words) in [
        (&["--column", "consumption"][..], 1, "did you mean `consumption_l_per_100km`"),
        (&["--month"], 1, "no column for the departure"),
        (&["--weight", "miles"], 1, "no column `miles`"),
        (&["--differ", "0.01"], 2, "type 0.01%"),
        (&["--differ", "0%"], 2, "above 0% and below 100%"),
        (&["--power", "100%"], 2, "above 0% and below 100%"),
        (&["--draws", "0"], 2, "from 1 to 1000000"),
        (&["--best", "fastest"], 2, "lowest"),
        (&["--map", "truck=driver_id", "--map", "driver=size"], 0, ""),
    ] {
        let (found, _, message) = run(&[&[path.as_str()], options].concat());
        assert_eq!(found, status, "{options:?}: {message}");
        assert!(message.contains(words), "{options:?}: {message}");
    }
    let (status, _, message) = run(&[directory.path().to_str().expect("UTF-8")]);
    assert_eq!(status, 1);
    assert!(message.contains("manifest"), "{message}");
    let once = written(directory.path(), "once.csv", "truck,consumption_l_per_100km\na,30\nb,31\n");
    let (status, _, message) = run(&[&once]);
    assert_eq!(status, 1);
    assert!(message.contains("do not repeat") && message.contains("once.csv"), "{message}");
}

#[test]
fn electric_trucks_are_compared_by_their_electricity() {
    let directory = tempfile::tempdir().expect("a directory");
    let fuel = json(&[&written(directory.path(), "fuel.csv", &table())]);
    assert_eq!(fuel["column"], "consumption_l_per_100km");
    // a column of fuel without a number, as in a run of electric trucks
    let empty = "truck_id,driver_id,consumption_kwh_per_km,size,consumption_l_per_100km";
    let electric: String = (table().lines().enumerate())
        .map(|(k, line)| if k == 0 { format!("{empty}\n") } else { format!("{line},\n") })
        .collect();
    let electric = written(directory.path(), "electric.csv", &electric);
    let fit = json(&[&electric]);
    assert_eq!(fit["column"], "consumption_kwh_per_km");
    assert_eq!(fit["components"], fuel["components"]);
    // one that is named is taken as it is
    let (status, _, stderr) = run(&[&electric, "--column", "consumption_l_per_100km"]);
    assert!(status == 1 && stderr.contains("60 no value"), "{stderr}");
    // where there is neither, the fuel is missed by name
    let neither = table().replace("consumption_l_per_100km", "litres");
    let (status, _, stderr) = run(&[&written(directory.path(), "neither.csv", &neither)]);
    assert!(status == 1 && stderr.contains("no column `consumption_l_per_100km`"), "{stderr}");
}

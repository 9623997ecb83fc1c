//! Typical mistakes: each is answered with its place and a remedy.

use crate::program::message;
use std::fs;

/// Files that some of them name.
const FILES: [(&str, &str); 5] = [
    ("empty.csv", ""),
    ("log.csv", "time,speed\n0,10\n1,11\n2,12\n"),
    ("route.csv", "distance_km,altitude_m\n0,10\n5,20\n"),
    ("few.csv", "date,truck,km,litres\n2024-01-01,A,100,30\n"),
    ("base.yaml", "a: 1\n"),
];

/// Command line, exit status, and words of the answer.
const TYPED: [(&str, i32, &[&str]); 42] = [
    ("run", 2, &["--study NAME --cycles 1000"]),
    ("simulate", 2, &["--study NAME --cycles 1000"]),
    ("my.toml", 2, &["ocmc --study my.toml"]),
    ("long-haul", 2, &["ocmc --study long-haul"]),
    ("a = 5", 2, &["--set KEY=5"]),
    ("vehicle.curb_mass_kg=9000", 2, &["--set KEY=5"]),
    ("comprae a b", 2, &["compare"]),
    ("--cycle 10", 2, &["--cycles"]),
    ("--cycles 0", 2, &["from 1 to"]),
    ("--cycles 1e4", 2, &["type 10000"]),
    ("--cycles 10.000", 2, &["type 10 or 10000"]),
    ("--cycles 10k", 2, &["type 10000"]),
    ("--precision 0.2", 2, &["type 0.2%"]),
    ("--seed abc", 2, &["whole number"]),
    ("--threads 0", 2, &["from 1 to"]),
    ("--trucks 10 --cycles 5", 2, &["cannot be used with"]),
    ("--trips 5 --cycles 7", 2, &["multiples of 5, such as 10"]),
    ("--study long_haul", 1, &["`long-haul`"]),
    ("--study nofile.toml", 1, &["neither a built-in study nor a file", "`regional`"]),
    ("--set vehicle.mass=20000", 1, &["did you mean `curb_mass_kg`"]),
    ("--set vehicle.mass_kg=20000", 1, &["did you mean `curb_mass_kg`"]),
    ("--set vehicle.cd=0.5", 1, &["did you mean `drag_area_m2`"]),
    ("--set vehicle.crr=0.005", 1, &["did you mean `rolling_factor`"]),
    ("--set vehicle.curb_mass_kg=20t", 1, &["without their unit"]),
    ("--set vehicle.curb_mass_kg=20", 1, &["500 to 100000"]),
    ("--set vehicle.curb_mass_kg=8000,5", 1, &["decimal point"]),
    ("--set vehicle.limiter_speed_kmh=85", 1, &["did you mean `limiter_speed_mps`"]),
    ("--set mission.length_km=80", 1, &["did you mean `length_m`"]),
    ("--set mission.payload=10", 1, &["did you mean `payload_kg`"]),
    ("--set mission.distance=10", 1, &["did you mean `length_m`"]),
    ("--set cost.fuel_per_l=1.5", 1, &["cost.currency = \"EUR\""]),
    ("--set cost.diesel=1.5", 1, &["`fuel_per_l`"]),
    ("--set a", 1, &["KEY=VALUE"]),
    ("compare field-truck", 2, &["a second study, or --set KEY=VALUE"]),
    ("sensitivity --cycles 5", 1, &["5 cycles", "at least 10", "more --cycles"]),
    ("cost", 1, &["no prices", "cost.currency=EUR"]),
    ("report nowhere", 1, &["no run directory", "`ocmc --out DIR` makes one"]),
    ("drive empty.csv", 1, &["is empty", "a line of column names"]),
    ("drive log.csv", 1, &["a speed over time", "--follow-speed"]),
    ("drive route.csv", 1, &["speed limit", "--draw limits"]),
    ("calibrate totals few.csv --study field-truck --out x.toml", 1, &["at least 5"]),
    ("trace --cycle-id 3 --out x.xlsx", 2, &["`.csv` or `.json`"]),
];

/// Lines of a study file behind its base, and words of the answer.
const WRITTEN: [(&str, &[&str]); 20] = [
    ("vehicle = { base = \"tractor40\" }", &[":2:20", "did you mean `tractor-40t`"]),
    ("vehicle = { base = \"base.yaml\" }", &[":2:20", "base.yaml"]),
    ("[vehicle]\ncurb_mass_kg = \"8000\"", &[":3:16", "500 to 100000"]),
    ("[vehicle]\ncurb_mass_kg = 8000,5", &[":3:20", "decimal point"]),
    ("[vehicle]\ncurb_mass_kg = 8 t", &[":3:16", "without their unit"]),
    ("[vehicel]\ncurb_mass_kg = 8000", &[":2:2", "did you mean `vehicle`"]),
    (
        "[mission]\nlength_m = { distribution = \"lognormal\", median = 8e4, log_sd = 0.3 }",
        &[":3:29", "did you mean `log_normal`"],
    ),
    (
        "[mission]\nlength_m = { distribution = \"log_normal\", median = 8e4 }",
        &[":3:1", "`mission.length_m.log_sd` is missing"],
    ),
    (
        "[mission]\nlength_m = { distribution = \"normal\", mean = 8e4, sd = -1 }",
        &[":3:56", "above 0"],
    ),
    ("[[fleet.group]]\nname = \"a\"", &["`fleet.group.0.trucks` is missing"]),
    ("[fleet]\ngroup = 3", &["[[fleet.group]]"]),
    (
        "[charging]",
        &[":2:2", "charging.reserve", "all that is missing there: `reserve`, `efficiency`"],
    ),
    ("[cost]\nfuel_per_l = 1.5", &[":2:2", "cost.currency = \"EUR\""]),
    ("[weather]\ntemperature_k = 20", &[":3:1", "did you mean `temperature`"]),
    ("[road.types.urban]\nmean_length = 3", &[":3:1", "did you mean `mean_length_m`"]),
    (
        "[fleet]\ntrips_per_truck = 3\nlevels = { temprature = \"day\" }",
        &[":4:12", "is not a key of a study", "did you mean `temperature`? There are: `road_type`"],
    ),
    (
        "[fleet]\ntrips_per_truck = 3\nlevels = { temperature = \"dya\" }",
        &[":4:26", "not one of its values", "did you mean `day`"],
    ),
    ("[fleet]\ntrips = 3", &[":3:1", "did you mean `trips_per_truck`"]),
    ("vehicle = { powertrain = { type = \"electric\" } }", &["battery_electric"]),
    ("[vehicle]\ncurb_mass_kg = 8000\ncurb_mass_kg = 9000", &[":4:1", "duplicate"]),
];

#[test]
fn typical_mistakes_are_answered_with_place_and_remedy() {
    let folder = tempfile::tempdir().expect("a directory");
    for (name, text) in FILES {
        fs::write(folder.path().join(name), text).expect("space");
    }
    for (typed, status, words) in TYPED {
        let arguments: Vec<&str> = typed.split(' ').collect();
        let message = message(folder.path(), &arguments, status);
        for word in words {
            assert!(message.contains(word), "{typed}: no {word:?} in {message}");
        }
    }
    for (text, words) in WRITTEN {
        let study = format!("study = {{ base = \"field-truck\", name = \"t\" }}\n{text}\n");
        fs::write(folder.path().join("s.toml"), study).expect("space");
        let message = message(folder.path(), &["--study", "s.toml", "--cycles", "2"], 1);
        for word in words {
            assert!(message.contains(word), "{text}: no {word:?} in {message}");
        }
    }
}

#[test]
fn the_study_that_nobody_asked_for_is_what_is_said_of_it() {
    let folder = tempfile::tempdir().expect("a directory");
    let arguments = ["--cycles", "3200", "--out", "a", "--format", "csv"];
    let message = message(folder.path(), &arguments, 0);
    assert!(message.contains("28 t in the mean"), "{message}");
    let mut records = csv::Reader::from_path(folder.path().join("a/records.csv")).expect("records");
    let head = records.headers().expect("a head").clone();
    let place = head.iter().position(|name| name == "payload_kg").expect("a column");
    let payloads: Vec<f64> = records
        .records()
        .map(|row| row.expect("a row")[place].parse().expect("a number"))
        .collect();
    // 15.25 t empty, `configs/vehicles/tractor-40t.toml`
    let gross_t = 15.25 + payloads.iter().sum::<f64>() / payloads.len() as f64 / 1000.0;
    assert!((27.5..28.5).contains(&gross_t), "{gross_t}");
    let other = self::message(folder.path(), &["--study", "field-truck", "--cycles", "2"], 0);
    assert!(!other.contains("28 t"), "{other}");
}

//! Bad input to every command that reads measurements: a clear error, or a warning with counts.

use crate::program::ocmc;
use crate::tables::{
    Table, curves, densities, hours, log, one_hour, own_direction, own_radius, speed_changes,
};
use std::fs;
use std::path::Path;

/// Runs a command on a table; its status, and what it says in all.
fn message(command: &[&str], text: &str) -> (i32, String) {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path().join("bad.csv");
    fs::write(&path, text).expect("a file");
    run(command, &path)
}

fn run(command: &[&str], path: &Path) -> (i32, String) {
    let path = path.to_str().expect("UTF-8");
    let output = ocmc(command).arg(path).output().expect("the program starts");
    let all = [output.stderr, output.stdout].concat();
    (output.status.code().unwrap_or(-1), String::from_utf8(all).expect("UTF-8"))
}

/// A command, what is wrong, the status, and what has to be said.
type Case<'a> = (&'a [&'a str], Table, i32, &'a [&'a str]);

fn check(cases: &[Case]) {
    for (command, table, status, parts) in cases {
        let (found, text) = message(command, &table.text());
        assert_eq!(found, *status, "{command:?}: {text}");
        assert!(!text.contains("panicked"), "{command:?}: {text}");
        for part in *parts {
            assert!(text.contains(part), "{command:?}: no `{part}` in: {text}");
        }
    }
}

const CURVE_SPEED: &[&str] = &["fit", "curve-speed"];
const SPEED_CHANGE: &[&str] = &["fit", "speed-change"];
const OPERATING_CYCLE: &[&str] = &["fit", "operating-cycle"];
const WEATHER: &[&str] = &["fit", "weather"];
const TRAFFIC: &[&str] = &["fit", "traffic"];
const CURVES: &[&str] = &["curves"];
const IDENTIFY: &[&str] = &["identify", "--no-intervals", "--starts", "1"];

#[test]
fn files_without_rows() {
    let tables = [
        (CURVE_SPEED, curves()),
        (SPEED_CHANGE, speed_changes()),
        (SPEED_CHANGE, log()),
        (OPERATING_CYCLE, log()),
        (WEATHER, hours()),
        (TRAFFIC, densities()),
        (CURVES, log()),
        (IDENTIFY, log()),
    ];
    for (command, table) in tables {
        let (status, text) = message(command, &table.rows(0).text());
        assert!(
            status == 1 && text.contains("no rows") && text.contains("bad.csv"),
            "{command:?}: {text}"
        );
        let (status, text) = message(command, "");
        let empty = text.contains("is empty") || text.contains("no rows");
        assert!(status == 1 && empty && text.contains("bad.csv"), "{command:?}: {text}");
        let (status, text) = run(command, Path::new("there-is-no-such.csv"));
        assert!(status == 1 && text.contains("there-is-no-such.csv"), "{command:?}: {text}");
    }
}

#[test]
fn missing_columns_and_unknown_units() {
    check(&[
        (
            CURVE_SPEED,
            curves().without("speed_mps"),
            1,
            &["no column for the speed", "`speed_mps`", "driver, radius_m"],
        ),
        (
            CURVE_SPEED,
            curves().renamed("speed_mps", "speed_furlongs"),
            1,
            &["`speed_furlongs` has no known unit", "`speed_mps`"],
        ),
        (
            SPEED_CHANGE,
            speed_changes().without("acceleration_mps2"),
            1,
            &["neither a table", "acceleration_mps2", "category"],
        ),
        (
            SPEED_CHANGE,
            speed_changes().renamed("acceleration_mps2", "acceleration_kmh"),
            1,
            &["`acceleration_kmh`", "unit"],
        ),
        (
            SPEED_CHANGE,
            log().without("limit_mps"),
            1,
            &["no column for the speed limit", "limit_kmh"],
        ),
        (
            SPEED_CHANGE,
            log().renamed("speed_mps", "speed_furlongs"),
            1,
            &["`speed_furlongs` has no known unit", "speed_kmh"],
        ),
        (OPERATING_CYCLE, log().without("speed_mps"), 1, &["no column for the speed"]),
        (OPERATING_CYCLE, log().without("time_s"), 1, &["no column for the time"]),
        (OPERATING_CYCLE, log().renamed("speed_mps", "speed"), 1, &["`speed` has no known unit"]),
        (OPERATING_CYCLE, log().without("limit_mps"), 1, &["no road type is known"]),
        (OPERATING_CYCLE, log().without("grade"), 0, &["no slope or altitude is known"]),
        (
            OPERATING_CYCLE,
            log().without("yaw_rate_radps"),
            0,
            &["nothing tells how the vehicle turned"],
        ),
        (
            WEATHER,
            hours().without("time_s"),
            1,
            &["no column for the time", "`time`, `date`, `time_s`"],
        ),
        (
            WEATHER,
            hours().renamed("temperature_c", "temperature_bar"),
            1,
            &["`temperature_bar`", "unit", "`temperature_c`"],
        ),
        (
            WEATHER,
            hours().renamed("wind_speed_mps", "wind_speed_fps"),
            1,
            &["`wind_speed_fps`", "unit"],
        ),
        (
            WEATHER,
            hours().without("pressure_hpa"),
            0,
            &["pressure: 0 values", "stays that of the base study"],
        ),
        (
            TRAFFIC,
            densities().without("density_share"),
            1,
            &["no column for the traffic", "`density_share`", "`speed_ratio`"],
        ),
        (
            TRAFFIC,
            densities().renamed("density_share", "density_per_km"),
            1,
            &["`density_per_km`", "unit", "`density_per_m`"],
        ),
        (TRAFFIC, densities().without("road_type"), 1, &["no column for the road type"]),
        (CURVES, log().without("yaw_rate_radps"), 1, &["no column for the yaw rate", "--map"]),
        (
            CURVES,
            log().renamed("yaw_rate_radps", "yaw_rate"),
            1,
            &["`yaw_rate` has no known unit", "yaw_rate_degps"],
        ),
        (IDENTIFY, log().without("brake"), 1, &["no column for the brake pedal"]),
        (
            IDENTIFY,
            log().renamed("accelerator", "accelerator_volt"),
            1,
            &["`accelerator_volt` has no known unit"],
        ),
    ]);
}

#[test]
fn time_that_runs_backwards() {
    let backwards = log().swapped(1000, 2000);
    let place = &["backwards 2 times", "after row 1001", "bad.csv"];
    check(&[
        (SPEED_CHANGE, backwards.clone(), 1, place),
        (OPERATING_CYCLE, backwards.clone(), 1, place),
        (CURVES, backwards.clone(), 1, place),
        (IDENTIFY, backwards, 1, place),
        (
            WEATHER,
            hours().swapped(100, 200),
            1,
            &["line 103", "`time_s`", "after that of the row before"],
        ),
        (TRAFFIC, densities().swapped(10, 20), 1, &["line 13", "`time_s`"]),
        (
            OPERATING_CYCLE,
            log().with("time_s", 7, 8, "0.6"),
            0,
            &["1 row with the time of the row before"],
        ),
        (
            IDENTIFY,
            log().with("time_s", 7, 8, "0.6"),
            0,
            &["1 row with the time of the row before"],
        ),
    ]);
}

#[test]
fn runs_of_missing_numbers() {
    let holes = log()
        .with("speed_mps", 500, 600, "NaN")
        .with("limit_mps", 2500, 2540, "")
        .with("grade", 3000, 3007, "NA");
    check(&[
        (
            CURVE_SPEED,
            curves().with("speed_mps", 30, 60, "NaN"),
            0,
            &["70 of 100 curves", "30 rows, missing value"],
        ),
        (CURVE_SPEED, curves().with("radius_m", 0, 10, "inf"), 0, &["10 rows, radius too large"]),
        (
            CURVE_SPEED,
            curves().with("speed_mps", 0, 100, ""),
            1,
            &["no curve is left of 100 rows", "100 missing_value"],
        ),
        (
            SPEED_CHANGE,
            speed_changes().with("acceleration_mps2", 0, 20, "NaN"),
            0,
            &["20 speed changes, missing value"],
        ),
        (
            SPEED_CHANGE,
            speed_changes().with("acceleration_mps2", 0, 60, "NaN"),
            1,
            &["60 have no value"],
        ),
        (
            SPEED_CHANGE,
            holes.clone(),
            0,
            &["100 rows without speed", "1 gap in time", "40 rows without a possible speed limit"],
        ),
        (
            OPERATING_CYCLE,
            holes.clone(),
            0,
            &[
                "100 rows without speed",
                "40 rows without a possible speed limit",
                "7 rows without slope",
            ],
        ),
        (
            CURVES,
            holes.clone(),
            0,
            &["3,900 of 4,000 rows used", "rows without speed: 100", "gaps in time: 1"],
        ),
        (
            IDENTIFY,
            holes,
            0,
            &["100 rows without speed: not used", "7 rows without slope: not used"],
        ),
        (
            WEATHER,
            hours().with("temperature_c", 1000, 2000, "NaN"),
            0,
            &["temperature: 1000 records have none"],
        ),
        (
            TRAFFIC,
            densities().with("density_share", 100, 200, ""),
            0,
            &["100 records have no density"],
        ),
        (
            TRAFFIC,
            densities().with("road_type", 100, 150, ""),
            0,
            &["50 records have no road type"],
        ),
    ]);
    for command in [SPEED_CHANGE, OPERATING_CYCLE, CURVES, IDENTIFY] {
        let table = log().with("speed_mps", 0, 4000, "NaN");
        check(&[(command, table, 1, &["`speed_mps`", "no number in any of its 4000 rows"])]);
        // a unit may be there, a number not: said with the first place
        let table = log().with("speed_mps", 9, 10, "fast");
        check(&[(
            command,
            table,
            0,
            &["1 cells of `speed_mps`", "no numbers, first `fast` in line 11"],
        )]);
    }
    for (command, table) in [
        (WEATHER, hours().with("temperature_c", 9, 10, "warm")),
        (TRAFFIC, densities().with("density_share", 9, 10, "dense")),
        (CURVE_SPEED, curves().with("radius_m", 9, 10, "tight")),
        (SPEED_CHANGE, speed_changes().with("acceleration_mps2", 9, 10, "hard")),
    ] {
        check(&[(command, table, 1, &["line 11", "allowed is a number"])]);
    }
}

#[test]
fn too_little_to_tell_anything() {
    check(&[
        (CURVE_SPEED, curves().rows(3), 1, &["3 curves of 3 drivers are too few", "6 or more"]),
        (CURVE_SPEED, curves().with("driver", 0, 100, "one"), 0, &["one driver only"]),
        (CURVE_SPEED, curves().with("radius_m", 0, 100, "100"), 1, &["the same radius"]),
        (CURVE_SPEED, own_radius(), 1, &["cannot be separated"]),
        (CURVE_SPEED, own_direction(), 0, &["one direction only"]),
        (
            SPEED_CHANGE,
            speed_changes().rows(3),
            0,
            &["3 speed changes", "no acceleration was measured"],
        ),
        (SPEED_CHANGE, speed_changes().with("driver", 0, 60, "one"), 0, &["one driver only"]),
        (
            SPEED_CHANGE,
            log().with("limit_mps", 0, 4000, "20"),
            1,
            &["no speed change: no limit changes"],
        ),
        (WEATHER, hours().rows(3), 1, &["3 hourly records", "temperature: 3 values, at least 48"]),
        (
            WEATHER,
            hours().rows(1000),
            0,
            &["temperature: the records lack winter or summer", "0.1 years"],
        ),
        (TRAFFIC, densities().rows(3), 1, &["3 records", "rural: 3 densities, at least 48"]),
        (TRAFFIC, one_hour(), 1, &["do not tell peak and off peak apart"]),
        (
            IDENTIFY,
            log().with("grade", 0, 4000, "0"),
            1,
            &["no event in the rows that can be used"],
        ),
        (IDENTIFY, log().rows(3), 1, &["no event in the rows"]),
    ]);
    for command in [SPEED_CHANGE, OPERATING_CYCLE, CURVES] {
        check(&[(command, log().rows(3), 1, &["3 of 3 rows", "at least 10 are needed"])]);
    }
}

#[test]
fn corrections_that_no_sensor_needs() {
    for (option, value, words) in [
        ("--speed-lag-s", "1e9", &["the lag of the speed, in s, is 1000000000", "-60 to 60"][..]),
        ("--speed-lag-s", "inf", &["is inf", "-60 to 60"]),
        ("--speed-lag-s", "nan", &["is NaN", "-60 to 60"]),
        ("--gyro-bias-radps", "inf", &["the bias of the yaw rate, in rad/s, is inf", "-1 to 1"]),
        ("--gyro-bias-radps", "nan", &["is NaN", "-1 to 1"]),
        ("--gyro-bias-radps", "-2", &["is -2", "-1 to 1"]),
    ] {
        check(&[(&["curves", option, value], log(), 1, words)]);
    }
    for (ratio, wheelbase_m, words) in [
        ("nan", "3", &["--steering-ratio", "is NaN", "1 to 100"]),
        ("0", "3", &["--steering-ratio", "is 0", "1 to 100"]),
        ("inf", "3", &["--steering-ratio", "is inf", "1 to 100"]),
        ("15", "nan", &["--wheelbase-m", "is NaN", "0.5 to 20"]),
    ] {
        let steering = ["--steering-ratio", ratio, "--wheelbase-m", wheelbase_m];
        for command in [CURVES, OPERATING_CYCLE] {
            check(&[(&[command, &steering[..]].concat(), log(), 1, words)]);
        }
    }
}

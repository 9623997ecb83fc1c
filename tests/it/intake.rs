//! Small inputs of others with a known truth: each gives its right value within 2 %, or is refused,
//! or is warned of by words that name the cause.

use crate::others_data::shared;
use crate::program::ocmc;
use serde_json::Value;
use std::fmt::Write;
use std::path::Path;
use std::process::Output;

/// Right form of an input.
enum Right {
    /// Litres per 100 km.
    Litres(f64),
    /// The file is refused, with these words.
    Refused(&'static str),
    /// The answer is there, and a warning has these words.
    Warned(&'static str),
    /// The answer is there, without a warning of a check, and has these words.
    Says(&'static str),
}
use Right::{Litres, Refused, Says, Warned};

/// The truths are those of the truck of 2016.
const EXACT: [&str; 8] = [
    "--follow-speed",
    "exact",
    "--study",
    "field-truck-loaded",
    "--set",
    "vehicle.base=tractor-40t-vecto",
    "--cycles",
    "20",
];
const ROUTE: [&str; 4] = ["--study", "field-truck-loaded", "--cycles", "20"];

fn judged(folder: &Path, command: &[&str], file: &str, options: &[&str], right: &Right) {
    let path = folder.join(file).display().to_string();
    let arguments: Vec<&str> =
        command.iter().copied().chain([path.as_str()]).chain(options.iter().copied()).collect();
    let Output { status, stdout, stderr } = ocmc(&arguments).output().unwrap();
    let [out, err] = [stdout, stderr].map(|text| String::from_utf8(text).unwrap());
    match right {
        Refused(words) => {
            assert!(!status.success() && err.contains(words), "{file}: {err}");
        }
        Warned(words) => {
            let named = err.lines().any(|line| line.starts_with("warning") && line.contains(words));
            assert!(status.success() && named, "{file}: {err}");
        }
        Says(words) => {
            assert!(status.success() && (out + &err).contains(words), "{file}: {err}");
        }
        Litres(wanted) => {
            assert!(status.success(), "{file}: {err}");
            let answer: Value = serde_json::from_str(&out).unwrap();
            let litres = answer["statistics"]["consumption_l_per_100km"]["mean"].as_f64().unwrap();
            assert!((litres / wanted - 1.0).abs() < 0.02, "{file}: {litres}, wanted {wanted}");
        }
    }
}

#[test]
fn drive_cycles() {
    let Some(folder) = shared("cases") else { return };
    let options: Vec<&str> = EXACT.into_iter().chain(["--json", "--quiet"]).collect();
    for (file, right) in [
        ("c01_ratio.csv", Litres(107.4)),
        ("c01_grad.csv", Litres(107.4)),
        ("c01_slope.csv", Litres(107.4)),
        ("c01_header_bracket.csv", Litres(107.4)),
        ("c01_header_deg.csv", Litres(107.4)),
        ("c01_percent_in_grade.csv", Refused("`grade_percent`")),
        ("c01_small_percent_in_grade.csv", Refused("`grade_percent`")),
        ("c06_t1.csv", Litres(30.3)),
        ("c36_t_v_in_mps.csv", Refused("--map speed_mps=v")),
        ("c41_epa_style.csv", Litres(30.3)),
        ("c41_paren.csv", Litres(43.7)),
        ("c41_german.csv", Litres(110.2)),
        ("c35_too_fast.csv", Says("\"saturation\": {")),
    ] {
        judged(&folder, &["drive"], file, &options, &right);
    }
}

#[test]
fn routes_and_tracks() {
    let Some(folder) = shared("cases") else { return };
    for (file, right) in [
        ("c01_route_alt_and_grade.csv", Refused("its altitudes climb by 3.000 %")),
        ("c18_pass.csv", Warned("high-altitude")),
        ("c19_whole_metres.csv", Says("its altitudes scatter by")),
        ("c33_antimeridian.csv", Says("21.16 km")),
        ("c19_tunnel.csv", Refused("the value at 8000 m")),
        ("c19_zero_spike.csv", Refused("the value at 9975 m")),
        ("c11_route_thousand_points.csv", Refused("the road is 20 m long")),
        ("c34_track.gpx", Refused("no column for the speed limit")),
        ("c34_track.geojson", Refused("no column for the speed limit")),
    ] {
        judged(&folder, &["drive"], file, &ROUTE, &right);
    }
    let draw = ["--draw", "limits,stops", "--study", "field-truck-loaded", "--cycles", "20"];
    judged(&folder, &["drive"], "c34_track.gpx", &draw, &Says("5.98"));
    judged(&folder, &["drive"], "c34_track.geojson", &draw, &Says("5.98"));
    let follow = ["--follow-speed", "exact", "--study", "field-truck-loaded", "--cycles", "2"];
    judged(&folder, &["drive"], "c34_track.gpx", &follow, &Says("implied-speed"));
    let fit = ["fit", "operating-cycle"];
    judged(&folder, &fit, "c34_track.gpx", &["--road-type", "rural"], &Says("1 track, 300 points"));
}

/// Consumption of a file in the unit of a column.
fn consumption(folder: &Path, file: &str, column: &str, options: &[&str]) -> f64 {
    let path = folder.join(file).display().to_string();
    let arguments: Vec<&str> =
        ["drive", &path, "--json", "--quiet"].iter().chain(options).copied().collect();
    let answer: Value = serde_json::from_slice(&ocmc(&arguments).output().unwrap().stdout).unwrap();
    answer["statistics"][column]["mean"].as_f64().unwrap()
}

#[test]
fn hills_give_back_no_more_than_they_take() {
    let Some(folder) = shared("cases") else { return };
    for (study, column) in [
        ("field-truck-loaded", "consumption_l_per_100km"),
        ("battery-truck", "consumption_kwh_per_km"),
    ] {
        let options = ["--follow-speed", "exact", "--study", study, "--cycles", "20"];
        let [up, down, level] = ["c02_up4.csv", "c02_down4.csv", "c06_t1.csv"]
            .map(|file| consumption(&folder, file, column, &options));
        assert!(up + down > 2.0 * level && down < level, "{study}: {up} {down} {level}");
    }
    // a battery that is nearly full takes 10.8 kWh on 25 km down
    let options = ["--study", "battery-truck", "--cycles", "5"];
    let per_km = consumption(&folder, "c03_down.csv", "consumption_kwh_per_km", &options);
    assert!((25.0 * per_km / -10.8 - 1.0).abs() < 0.02, "{per_km}");
    // an hour at rest counts once: the engine idles for it, and the way is that of the rest
    let at_rest = consumption(&folder, "c05_stand_long.csv", "consumption_l_per_100km", &EXACT);
    let litres = at_rest * 0.1667 / 100.0;
    assert!((1.5..4.5).contains(&litres), "{litres} litres an hour");
}

#[test]
fn times_of_logs() {
    let Some(folder) = shared("cases") else { return };
    for (file, right) in [
        ("c08_whole_seconds.csv.gz", Says("5 curves")),
        ("c08_back.csv", Refused("row 1500")),
        ("c09_iso_z.csv.gz", Says("5 curves")),
        ("c09_local_autumn.csv.gz", Says("5 curves")),
        ("c10_units_row_suffix.csv", Says("5 curves")),
        ("c11_semicolon_comma.csv.gz", Says("5 curves")),
    ] {
        judged(&folder, &["curves"], file, &[], &right);
    }
}

#[test]
fn weather_of_services() {
    let Some(folder) = shared("cases") else { return };
    for (file, right) in [
        ("c12_wind_99_0.csv.gz", Refused("stands for a missing value")),
        ("c12_missing999.csv.gz", Refused("line 102")),
        ("c12_made_up.epw.gz", Says("wind.mean_speed_mps                           3.9")),
        ("c12_dwd_like.csv.gz", Says("temperature.mean_k                             281.")),
        ("c12_hour24.csv.gz", Says("8760 hours over 1.0 years")),
        ("c12_local_dst.csv.gz", Says("summer and standard time")),
    ] {
        judged(&folder, &["fit", "weather"], file, &[], &right);
    }
}

#[test]
fn points_of_fuel_maps() {
    let Some(folder) = shared("cases") else { return };
    let scratch = tempfile::tempdir().unwrap();
    // the tables of a truck have moved into that of its powertrain since these were written
    let study = |text: &str| {
        let text = text.replace("[vehicle.engine]", "[vehicle.powertrain.combustion.engine]");
        text.replace("\"c28", &format!("\"{}/c28", folder.display()))
    };
    let whole = std::fs::read_to_string(folder.join("s_c28_map.toml")).unwrap();
    for (name, map, right) in [
        ("whole", "c28_map.csv", Says("a valid study")),
        ("negative", "c28_map_negative.csv", Refused("-24,957 g/h, below 0")),
        ("twice", "c28_map_dup.csv", Refused("there twice, with 24,957 and 9,999 g/h")),
        ("zero", "c28_map_one_point_zero.csv", Refused("no fuel under load")),
        ("gap", "c28_map_row_gone.csv", Says("a valid study")),
    ] {
        let file = format!("{name}.toml");
        let text = study(&whole.replace("c28_map.csv", map));
        std::fs::write(scratch.path().join(&file), text).unwrap();
        judged(scratch.path(), &["study", "check"], &file, &[], &right);
    }
}

/// A file of a minute at a speed on 3 %, under these names.
fn written(folder: &Path, name: &str, text: &str) -> String {
    std::fs::write(folder.join(name), text).unwrap();
    name.to_owned()
}

#[test]
fn columns_under_other_names_are_read_or_named() {
    let scratch = tempfile::tempdir().unwrap();
    let options: Vec<&str> = EXACT.into_iter().chain(["--json", "--quiet"]).collect();
    let rows = |names: &str, speed: f64, slope: f64| {
        let mut text = format!("{names}\n");
        for second in 0..=600 {
            let share = f64::from(second.min(40)) / 40.0;
            _ = writeln!(text, "{second},{},{slope}", 20.0 * share * speed);
        }
        text
    };
    let name = written(scratch.path(), "own.csv", &rows("time_s,speed_mps,grade", 1.0, 0.03));
    let path = scratch.path().join(name).display().to_string();
    let arguments: Vec<&str> = ["drive", &path].into_iter().chain(options.clone()).collect();
    let answer: Value = serde_json::from_slice(&ocmc(&arguments).output().unwrap().stdout).unwrap();
    let litres = answer["statistics"]["consumption_l_per_100km"]["mean"].as_f64().unwrap();
    let degrees = 0.03_f64.atan().to_degrees();
    for (k, (names, speed, slope, right)) in [
        ("time_s,speed_mps,slope_percent", 1.0, 3.0, Litres(litres)),
        ("time_s,speed_mps,grade_deg", 1.0, degrees, Litres(litres)),
        ("time_s,speed_mps,road_grade [%]", 1.0, 3.0, Litres(litres)),
        ("Time (s),Speed (km/h),Grade (%)", 3.6, 3.0, Litres(litres)),
        ("time / s,speed / km/h,grade / %", 3.6, 3.0, Litres(litres)),
        ("Temps (s),Vitesse (km/h),Pente (%)", 3.6, 3.0, Litres(litres)),
        ("Tid [s],Hastighet [km/h],Lutning [%]", 3.6, 3.0, Litres(litres)),
        ("Tiempo [s],Velocidad [km/h],Pendiente [%]", 3.6, 3.0, Litres(litres)),
        ("time_s,speed_mps,uphill", 1.0, 0.03, Warned("unused-column")),
        ("time_s,speed_mph,grade", 1.0, 3.0, Refused("slope-scale")),
        ("time_s,speed,grade", 1.0, 0.03, Refused("`speed` has no known unit")),
    ]
    .into_iter()
    .enumerate()
    {
        let file = written(scratch.path(), &format!("{k}.csv"), &rows(names, speed, slope));
        judged(scratch.path(), &["drive"], &file, &options, &right);
    }
    // altitudes instead of a slope
    let mut text = "time_s,speed_mps,altitude_m\n".to_owned();
    let mut way_m = 0.0;
    for second in 0..=600 {
        let speed = 20.0 * f64::from(second.min(40)) / 40.0;
        _ = writeln!(text, "{second},{speed},{:.3}", 100.0 + way_m * 0.03 / 1.0009_f64.sqrt());
        way_m += 0.5 * (speed + 20.0 * f64::from((second + 1).min(40)) / 40.0);
    }
    let file = written(scratch.path(), "altitude.csv", &text);
    judged(scratch.path(), &["drive"], &file, &options, &Litres(litres));
}

#[test]
fn settings_without_an_effect_and_unusual_numbers_are_named() {
    let Some(folder) = shared("cases") else { return };
    let with = |set: &'static str| EXACT.into_iter().chain(["--set", set]).collect::<Vec<_>>();
    let file = "c01_ratio.csv";
    let without = Warned("setting-without-effect");
    judged(&folder, &["drive"], file, &with("driver.speed_limit.compliance=0.9"), &without);
    judged(&folder, &["drive"], file, &with("mission.payload_kg=12"), &Warned("In t it would be"));
}

#[test]
fn cycles_by_corners_are_driven_between_them() {
    let Some(folder) = shared("cases") else { return };
    for (study, follow, files, within) in [
        ("regional", "exact", ["c07_cbd_breakpoints.csv", "c07_cbd_tenth.csv"], 0.005),
        ("field-truck-loaded", "exact", ["c07_cbd_breakpoints.csv", "c07_cbd_tenth.csv"], 0.005),
        ("field-truck-loaded", "exact", ["c07_saw10.csv", "c07_saw1.csv"], 0.01),
        ("field-truck-loaded", "driver", ["c07_saw10.csv", "c07_saw1.csv"], 0.01),
    ] {
        let [corners, rows] = files.map(|file| {
            let path = folder.join(file).display().to_string();
            let drive = ["drive", &path, "--follow-speed", follow, "--study", study];
            let output =
                ocmc(&drive).args(["--cycles", "20", "--json", "--quiet"]).output().unwrap();
            let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
            answer["statistics"]["consumption_l_per_100km"]["mean"].as_f64().unwrap()
        });
        assert!((corners / rows - 1.0).abs() < within, "{study} {follow}: {corners} {rows}");
    }
}

#[test]
fn trips_and_curves_that_cannot_be_are_left_out_and_named() {
    let Some(folder) = shared("cases") else { return };
    for (file, right) in [
        ("c14_outlier.csv", Warned("first 3000 in line 162")),
        ("c14_outlier.csv", Says("mean over trucks and drivers 31.87")),
        ("c14_negative.csv", Warned("first -30 in line 162")),
        ("c14_negative.csv", Says("mean over trucks and drivers 31.78")),
        ("c14_one_truck.csv", Refused("allowed are two trucks or more")),
        ("c14_singletons.csv", Refused("do not repeat")),
        ("c14_zero_between.csv", Says("mean over trucks and drivers 30.00")),
        ("c14_all_equal.csv", Refused("they have to differ")),
    ] {
        judged(&folder, &["fit", "fleet"], file, &[], &right);
    }
    for file in ["c42_dates.csv", "c42_leap_month.csv"] {
        let mean = Says("mean over trucks and drivers 31.78");
        judged(&folder, &["fit", "fleet"], file, &["--month"], &mean);
    }
    for (file, right) in [
        ("c15_outlier_kmh_as_mps.csv", Warned("first 625.0 m/s² in line 202")),
        ("c15_outlier_kmh_as_mps.csv", Says("200 of 201 curves")),
        ("c15_singletons.csv", Refused("one curve a driver")),
        ("c15_one_radius.csv", Refused("the same radius")),
        ("c15_radius_by_driver.csv", Refused("the same in all curves of a driver")),
    ] {
        judged(&folder, &["fit", "curve-speed"], file, &[], &right);
    }
}

#[test]
fn long_trips_count_more_where_their_length_is_known() {
    let scratch = tempfile::tempdir().unwrap();
    // truck a is thirsty on short trips alone: by distance it is the better one
    let mut text = "truck_id,consumption_l_per_100km,distance_km\n".to_owned();
    for k in 0..12 {
        let noise = f64::from(k % 3) * 0.1;
        _ = writeln!(text, "a,{},2\na,{},200", 40.0 + noise, 29.0 + noise);
        _ = writeln!(text, "b,{},2\nb,{},200", 31.0 + noise, 32.0 + noise);
    }
    let file = written(scratch.path(), "trips.csv", &text);
    let path = scratch.path().join(&file).display().to_string();
    let first = |options: &[&str]| {
        let output = ocmc(&["fit", "fleet", &path, "--json"]).args(options).output().unwrap();
        let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
        answer["leagues"][0]["members"][0]["label"].as_str().unwrap().to_owned()
    };
    assert_eq!([first(&[]), first(&["--weight", "none"])], ["a", "b"]);
    let said = Says("Trips count by distance_km");
    judged(scratch.path(), &["fit", "fleet"], &file, &[], &said);
    judged(scratch.path(), &["fit", "fleet"], &file, &["--weight", "none"], &Says("counts once"));
}

//! Messages to a user when a study is wrong: the place, the key, the value, the allowed values, the
//! nearest name.

use ocmc_io::study::{self, Cause, StudyFileError};

fn error_of(text: &str) -> StudyFileError {
    match study::load_text::<&str>("mine.toml", text, &[]) {
        Ok(_) => panic!("loads: {text}"),
        Err(error) => error,
    }
}

/// Asserts that the message about a study, which derives from the default one, has each of the
/// pieces.
fn assert_says(line: &str, pieces: &[&str]) {
    let error = error_of(&format!("study.base = \"field-truck\"\n{line}\n")).to_string();
    for piece in pieces {
        assert!(error.contains(piece), "`{piece}` is not in:\n{error}");
    }
}

#[test]
fn an_unknown_key_names_the_nearest() {
    assert_says(
        "vehicle.curb_mas_kg = 3",
        &[
            "mine.toml:2:9: `vehicle.curb_mas_kg` is not a key",
            "  2 | vehicle.curb_mas_kg = 3\n    |         ^^^^^^^^^^^\n",
            "did you mean `curb_mass_kg`?",
        ],
    );
    assert_says("motion.length_m = 3", &["mine.toml:2:1", "`motion`", "did you mean `mission`?"]);
    let ground = "road.types.urban.ground = { ice = 1.0 }";
    assert_says(ground, &["`road.types.urban.ground.ice`", "`gravel`"]);
    assert_says("vehicle.axles = [{ tyre = 2 }]", &["`vehicle.axles[0].tyre`", "mean `tyres`?"]);
    assert_says("vehicle.\"a b\" = 2", &["`vehicle.\"a b\"` is not a key"]);
}

#[test]
fn a_key_that_moved_says_where_to() {
    let text = "study.base = \"battery-truck\"\nvehicle.electric.charging.power_w = 3e5\n";
    let error = error_of(text).to_string();
    assert!(error.contains("it has moved to `vehicle.powertrain.battery_electric`"), "{error}");
    let text = text.replace("electric.charging", "powertrain.battery_electric.charging");
    let error = error_of(&text).to_string();
    assert!(
        error.contains("`vehicle.powertrain.battery_electric.charging` is not a key"),
        "{error}"
    );
    assert!(error.contains("it has moved to `charging.stop`"), "{error}");
}

#[test]
fn a_motor_that_its_battery_cannot_turn_is_refused() {
    // a little less than U²/4R of 401 V; without a torque the motor takes 7.3 kW at most
    let weak = |resistance_ohm: f64| {
        let battery = "[vehicle.powertrain.battery_electric.battery]";
        let voltages = "empty_voltage_v = 400.0\nfull_voltage_v = 410.0";
        format!(
            "study.base = \"battery-truck\"\n{battery}\n{voltages}\n\
             resistance_ohm = {resistance_ohm:?}\n"
        )
    };
    let error = error_of(&weak(10.0)).to_string();
    let place = "`vehicle.powertrain.battery_electric.motor.map_loss_w[4][0]` is 7300";
    assert!(error.contains(place) && error.contains("below 4004 without a torque"), "{error}");
    assert!(study::load_text::<&str>("mine.toml", &weak(5.0), &[]).is_ok());
}

#[test]
fn losses_beyond_the_power_of_a_motor_are_refused() {
    let text = |watts: &str| {
        let motor = "[vehicle.powertrain.battery_electric.motor]\npower_w = 490e3\n";
        let map = "map_speed_radps = [0.0, 480.0]\nmap_torque_nm = [0.0, 2400.0]\n";
        let losses = format!("map_loss_w = [[2500.0, 94660.0], [7300.0, {watts}]]\n");
        format!("study.base = \"battery-truck\"\n{motor}{map}{losses}")
    };
    let error = error_of(&text("9.9e6")).to_string();
    assert!(error.contains("map_loss_w[1][1]` is 9900000, allowed is at most twice"), "{error}");
    assert!(study::load_text::<&str>("mine.toml", &text("9.9e4"), &[]).is_ok());
}

#[test]
fn an_error_of_a_number_names_a_number_that_can_have_one() {
    let estimates = |keys: &str, errors: &str, more: &str| {
        format!("[uncertainty.fit]\nkeys = [{keys}]\nstandard_errors = [{errors}]\n{more}")
    };
    let mass = "\"vehicle.curb_mass_kg\"";
    let both = "\"vehicle.curb_mass_kg\", \"driver.curve_speed.exponent\"";
    for (text, piece) in [
        (
            estimates("\"vehicle.curb_mas_kg\"", "1.0", ""),
            "`uncertainty.fit.keys` is `vehicle.curb_mas_kg`",
        ),
        (estimates("\"mission.payload_kg\"", "1.0", ""), "such as `mission.payload_kg.mean`"),
        (estimates("\"driver.curve_speed.form\"", "1.0", ""), "a path to a number of the study"),
        (estimates("\"vehicle/curb_mass_kg\"", "1.0", ""), "a path to a number of the study"),
        (estimates("\"simulation.step_s\"", "0.1", ""), "a path to a number of the study"),
        (estimates("\"driver.curve_speed.replicates\"", "1.0", ""), "a path to a number"),
        (estimates(mass, "1.0, 2.0", ""), "is 2 numbers, allowed is one of each key: 1"),
        (estimates(mass, "-1.0", ""), "is -1, allowed is 0 to"),
        (estimates("", "", ""), "at least one key"),
        (
            estimates("\"vehicle.curb_mass_kg\", \"vehicle.curb_mass_kg\"", "1.0, 1.0", ""),
            "each key once",
        ),
        (estimates(both, "1.0, 0.01", "correlation = [[1.0, 0.5]]"), "2 rows of 2 numbers"),
        (
            estimates(both, "1.0, 0.01", "correlation = [[1.0, 0.5], [0.4, 1.0]]"),
            "the same on both sides",
        ),
        (
            estimates(both, "1.0, 0.01", "correlation = [[1.0, 1.5], [1.5, 1.0]]"),
            "1.5, allowed is -1 to 1",
        ),
    ] {
        assert_says(&text, &[piece]);
    }
    // a share that has to add up to one with others moves them, too
    let share = estimates("\"road.types.urban.next.rural\"", "0.01", "");
    let text = format!("study.base = \"field-truck\"\n{share}");
    assert!(study::load_text::<&str>("mine.toml", &text, &[]).is_ok());
    // the law of curve speeds says its errors itself
    let law = "driver.curve_speed.parameter_uncertainty = true\n";
    let again = estimates("\"driver.curve_speed.exponent\"", "0.01", "");
    assert_says(&format!("{law}{again}"), &["its standard error is given elsewhere"]);
}

#[test]
fn an_unknown_word_names_the_nearest() {
    assert_says(
        "driver.curve_speed.form = \"tabel\"",
        &[
            "mine.toml:2:27: `driver.curve_speed.form` is \"tabel\"",
            "did you mean `table`?",
            "`bivariate`",
        ],
    );
    assert_says("driver.curve_speed.form = 3", &["`driver.curve_speed.form` is 3", "`pooled`"]);
    let without = "simulation.without = [\"trafic\"]";
    assert_says(without, &["`simulation.without[0]`", "did you mean `traffic`?"]);
}

#[test]
fn a_wrong_type_names_the_right_one() {
    for (line, message) in [
        ("mission = 3", "`mission` is 3, allowed is a table"),
        ("vehicle.axles = 3", "`vehicle.axles` is 3, allowed is a list"),
        ("vehicle.curb_mass_kg = \"heavy\"", "is \"heavy\", allowed is a number, 500 to 100000"),
        ("driver.curve_speed.replicates = 2.5", "is 2.5, allowed is a whole number, 1 to 1e6"),
        ("driver.curve_speed.replicates = -2", "is -2, allowed is a whole number, 1 to 1e6"),
        ("driver.pedals.pid.correlation = [0.1]", "a list of length 3, each -0.99 to 0.99"),
        ("driver.curve_speed.parameter_uncertainty = 1", "is 1, allowed is true or false"),
        ("mission.length_m = 1979-05-27", "is 1979-05-27, allowed is a number, or a table such as"),
        (
            "study.name = 1979-05-27",
            "`study.name` is 1979-05-27, allowed is a text in quotation marks",
        ),
        (
            "vehicle.powertrain.combustion.engine = 1979-05-27",
            "`vehicle.powertrain.combustion.engine` is 1979-05-27, allowed is a table",
        ),
        ("study.name = 3", "`study.name` is 3, allowed is a text in quotation marks"),
        (
            "cost.fuel_per_l = \"dear\"",
            "`cost.fuel_per_l` is \"dear\", allowed is a number, a list",
        ),
    ] {
        assert_says(line, &["mine.toml:2:", message]);
    }
}

#[test]
fn a_number_out_of_its_bounds_names_them() {
    assert_says(
        "vehicle.curb_mass_kg = -3",
        &[
            "mine.toml:2:24: `vehicle.curb_mass_kg` is -3, allowed is 500 to 100000",
            "  2 | vehicle.curb_mass_kg = -3\n    |                        ^^",
        ],
    );
    let red = "road.types.urban.traffic_lights.red_probability = 1.5";
    assert_says(red, &["red_probability` is 1.5, allowed is 0 to 1"]);
    let signs = "road.types.urban.speed_signs.speed_kmh = [50.0, 900.0]";
    assert_says(signs, &["mine.toml:2:49", "speed_kmh[1]` is 900, allowed is 5 to 200"]);
    // numbers that may be left out have bounds, too
    let offset = "driver.speed_limit.sign_offset_m = 900.0";
    assert_says(offset, &["sign_offset_m` is 900, allowed is -500 to 500"]);
    let price = "cost = { currency = \"EUR\", fuel_per_l = -1.5 }";
    assert_says(price, &["mine.toml:2:41: `cost.fuel_per_l` is -1.5, allowed is 0 to 1000000"]);
    let by_year = "cost = { currency = \"EUR\", driver_per_h = [30.0, -1.0] }";
    assert_says(by_year, &["`cost.driver_per_h[1]` is -1, allowed is 0 to 1000000"]);
}

#[test]
fn numbers_that_are_none_are_refused() {
    let mass = "vehicle.curb_mass_kg = nan";
    assert_says(mass, &["is nan, allowed is a finite number, 500 to 100000"]);
    assert_says("mission.length_m = -inf", &["is -inf"]);
    assert_says("mission.length_m = 1e400", &["is 1e400, allowed is a finite number"]);
    let law = "mission.length_m = { distribution = \"normal\", mean = 1e5, sd = 1.0, lower = nan }";
    assert_says(law, &["`mission.length_m.lower` is nan"]);
}

#[test]
fn several_faults_are_told_at_once() {
    let text = "study.base = \"field-truck\"\nvehicle.curb_mass_kg = -3\nmission.length_m = 2\n";
    let error = error_of(text);
    let keys: Vec<_> = error.faults.iter().filter_map(|fault| fault.key()).collect();
    assert_eq!(keys, ["mission.length_m", "vehicle.curb_mass_kg"]);
    let place = error.faults[1].place.as_ref().expect("a place");
    assert_eq!(&place.source.text[place.span.clone()], "-3");
}

#[test]
fn numbers_that_do_not_fit_say_what_is_inherited() {
    assert_says(
        "road.types.urban.speed_signs.speed_kmh = []",
        &[
            "`road.types.urban.speed_signs.speed_kmh` is empty, allowed is at least one sign",
            "built-in field-truck:",
            "`road.types.urban.speed_signs.share` is 5 numbers",
            "inherited from built-in field-truck; mine.toml does not say it",
        ],
    );
}

#[test]
fn keys_that_do_not_fit_together_say_what_would() {
    for (line, message) in [
        ("road.types.urban.minimum_length_m = 90000", "below mean_length_m"),
        ("road.types.urban.next = { rural = 0.5 }", "a sum of 1 over the other road types"),
        ("road.types.urban.next = { rural = 0.5, forest = 0.5 }", "another road type"),
        ("road.types.urban.speed_signs.share = [1.0]", "one share for each sign"),
        ("road.types.urban.ground = { gravel = 0.5 }", "a sum of 1"),
        ("road.types.urban.topography.hill_length_m = 60", "above 4 times road.slope_step_m"),
        ("traffic.types.forest = { off_peak_share = 0.1, peak_share = 0.1 }", "a road type of"),
        ("mission.stops = { spacing_m = 20, dwell_s = 5 }", "50 to 5000000"),
        ("road.net_climb_m = 4900\nmission.length_m = 20000", "at most the largest slope_limit"),
        (
            "driver.curve_speed.form = \"table\"\ndriver.curve_speed.table.exponent = [0.4]",
            "trucks",
        ),
        ("driver.speed_limit.bump_minimum_mps = 15", "at most bump_maximum_mps"),
        ("driver.pedals.pid.proportional_minimum = 3", "at most proportional_maximum"),
        ("driver.pedals.pid.correlation = [0.9, 0.9, -0.9]", "a positive definite"),
        ("vehicle.axles = []", "load shares with a sum of 1"),
        (
            "study.drop = [\"vehicle.powertrain.combustion.engine\"]",
            "`vehicle.powertrain.combustion.engine` is missing",
        ),
        ("study.drop = [\"vehicle.powertrain\"]", "`vehicle.powertrain` is missing"),
        ("study.drop = [\"vehicle.powertrain.combustion\"]", "one of the tables combustion"),
        ("vehicle.powertrain.combustion.gearbox.ratio = [1, 2]", "falling ratios"),
        (
            "vehicle.powertrain.combustion.gearbox.shift.start_gear = 13",
            "at most the number of gears",
        ),
        (
            "vehicle.powertrain.combustion.gearbox.shift.launch_gears = 1",
            "only there the clutch slips",
        ),
        (
            "vehicle.powertrain.combustion.gearbox.shift.launch_speed_radps = 50",
            "open_share times the idle speed",
        ),
        (
            "vehicle.powertrain.combustion.engine.drag_torque_nm = [-10]",
            "as many as map_speed_radps",
        ),
        (
            "vehicle.powertrain.combustion.engine.full_load_torque_nm = [10]",
            "as many as full_load_speed_radps",
        ),
    ] {
        assert_says(line, &[message]);
    }
    // a law draws some stops nearer than that: they are put there, and the study is none the worse
    let stops = "mission.stops = { spacing_m = { distribution = \"exponential\", mean = 2000 }, \
                 dwell_s = 5 }";
    let text = format!("study.base = \"field-truck\"\n{stops}\n");
    assert!(study::load_text::<&str>("mine.toml", &text, &[]).is_ok());
    // a road that goes up to where it may
    let uphill = "study.base = \"field-truck\"\nroad.net_climb_m = 500\n";
    assert!(study::load_text::<&str>("mine.toml", uphill, &[]).is_ok());
}

#[test]
fn faults_within_laws_are_placed() {
    for (keys, message) in [
        ("mean = 1e5, s = 3", "`mission.length_m.s` is not a key"),
        ("mean = 1e5, sd = \"3\"", "`mission.length_m.sd` is \"3\", allowed is a number"),
        ("mean = 1e5", "`mission.length_m.sd` is missing"),
        ("mean = 1e5, sd = -3", "`mission.length_m.sd` is -3, allowed is above 0"),
    ] {
        assert_says(
            &format!("mission.length_m = {{ distribution = \"normal\", {keys} }}"),
            &["mine.toml:2:", message],
        );
    }
    assert_says("mission.length_m = { distribution = \"normel\" }", &["did you mean `normal`?"]);
    // one key of a law beside the others of the law that is inherited
    assert_says(
        "mission.payload_kg = { mean = 10000.0, sd = 4.0 }",
        &["the law there is inherited, a `mixture`", "begins with `distribution`"],
    );
    assert_says("mission.length_m = {}", &["`mission.length_m.distribution` is missing"]);
    // a law is replaced, never left as it was
    assert_says("mission.payload_kg = {}", &["`mission.payload_kg.distribution` is missing"]);
    let part = "{ distribution = \"normal\", mean = 1.0, ad = 1.0 }";
    let mixture = format!("{{ distribution = \"mixture\", weights = [1], components = [{part}] }}");
    assert_says(
        &format!("mission.payload_kg = {mixture}"),
        &["`mission.payload_kg.components[0].ad`", "did you mean `sd`?"],
    );
}

#[test]
fn a_missing_key_is_named_with_its_table() {
    let error = error_of("study = { name = \"a\", description = \"b\" }\n").to_string();
    assert!(error.contains("mine.toml:1:1: `mission` is missing"), "{error}");
    assert!(error.contains("study.base"), "{error}");
    let part = "study = { name = \"a\", description = \"b\" }\nmission = { length_m = 1e5 }\n";
    let error = error_of(part).to_string();
    assert!(error.contains("a study without a base has to say everything"), "{error}");
    let whole = study::init_text().replace("curb_mass_kg = ", "# ");
    let error = error_of(&whole).to_string();
    let message = "`vehicle.curb_mass_kg` is missing, allowed is 500 to 100000";
    assert!(error.contains(message) && error.contains("| [vehicle]"), "{error}");
}

#[test]
fn a_text_that_is_not_toml_is_placed() {
    let error = error_of("[study]\nname = \n").to_string();
    assert!(error.contains("mine.toml:2:8: not valid TOML"), "{error}");
    let comma = &["not valid TOML", "numbers take a decimal point: 2.5, not 2,5"];
    assert_says("mission.length_m = 2500,5", comma);
    let unit = "numbers stand without their unit";
    assert_says("mission.length_m = 250m", &["not valid TOML", unit]);
    assert_says("mission.length_m = \"250 m\"", &["within 200 to 5e6", unit]);
    assert_says("study.base = \"regional\"", &["mine.toml:2:7: not valid TOML: duplicate key"]);
    let error = error_of(&format!("a = [{}", "1, ".repeat(5000))).to_string();
    assert!(error.lines().all(|line| line.chars().count() < 140), "{error}");
    let deep = format!("a = {}1{}", "[".repeat(5000), "]".repeat(5000));
    assert!(error_of(&deep).to_string().contains("mine.toml:1"));
    let error = error_of("a = \"\u{1b}[31m\"\n").to_string();
    assert!(!error.contains('\u{1b}'), "{error:?}");
}

#[test]
fn a_base_that_is_not_there_or_leads_back_is_refused() {
    let error = error_of("study.base = \"field-truk\"\n").to_string();
    let message = "mine.toml:1:14: `field-truk` is neither a built-in study nor a file";
    assert!(error.contains(message) && error.contains("did you mean `field-truck`?"), "{error}");
    for (line, message) in [
        ("vehicle.base = \"tractor\"", "neither a built-in vehicle nor a file"),
        ("vehicle.base = \"tractor-40\"", "did you mean `tractor-40t`?"),
        ("vehicle.base = 3", "`vehicle.base` is 3, allowed is a name or a file"),
        ("study.drop = [\"road.types.urbn\"]", "`study.drop` names `road.types.urbn`"),
        ("study.drop = [\"road.types.urbn\"]", "did you mean `urban`?"),
        ("study.drop = \"road\"", "`study.drop` is \"road\", allowed is a list"),
    ] {
        assert_says(line, &[message]);
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("loop.toml");
    std::fs::write(&path, "study.base = \"loop.toml\"\n").expect("a file");
    let error = study::load::<&str>(&path.display().to_string(), &[]).expect_err("a loop");
    assert!(error.to_string().contains("makes a study derive from itself"), "{error}");
}

#[test]
fn files_that_cannot_be_a_study_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let error_of = |bytes: &[u8]| {
        let path = folder.path().join("a.toml");
        std::fs::write(&path, bytes).expect("a file");
        study::load::<&str>(&path.display().to_string(), &[]).expect_err("not a study")
    };
    assert!(matches!(error_of(b" \n").faults[0].cause, Cause::Empty { .. }));
    assert!(error_of(b"# nothing\n").to_string().contains("is missing"));
    let noise = |length: u32| -> Vec<u8> {
        (0..length).map(|k| (k.wrapping_mul(2_654_435_761) >> 13) as u8).collect()
    };
    assert!(error_of(&noise(10_000_000)).to_string().contains("has more than 4194304 bytes"));
    assert!(matches!(error_of(&noise(3_000_000)).faults[0].cause, Cause::NotText { .. }));
    let letters: Vec<u8> = noise(3_000_000).iter().map(|byte| 32 + byte % 90).collect();
    assert!(error_of(&letters).to_string().len() < 1000);
    let error = error_of(b"a = 1\nb = \"\xff\"\n").to_string();
    assert!(error.contains("a.toml` is not UTF-8 text: line 2, byte 11"), "{error}");

    let folder = folder.path().display().to_string();
    let error = study::load::<&str>(&folder, &[]).expect_err("a folder").to_string();
    assert!(error.contains("is a directory"), "{error}");
}

#[test]
fn a_wrong_name_is_told_the_nearest() {
    let error = study::load::<&str>("field-trucks", &[]).expect_err("no file").to_string();
    assert!(error.contains("`field-trucks` is neither a built-in study nor a file"), "{error}");
    assert!(
        error.contains("did you mean `field-truck`?") && error.contains("`long-haul`"),
        "{error}"
    );
    let error = study::show("tractor-40").expect_err("not built in").to_string();
    assert!(error.contains("did you mean `tractor-40t`?"), "{error}");
    let error =
        study::text("tractor-40".as_ref(), &study::Files::here()).expect_err("no file").to_string();
    let message = "`tractor-40` is neither a built-in study or vehicle nor a file";
    assert!(error.contains(message) && error.contains("did you mean `tractor-40t`?"), "{error}");
}

#[test]
fn a_wrong_setting_is_shown_as_it_was_typed() {
    let assert_says = |set: &str, message: &str| {
        let error = study::load("field-truck", &[set]).expect_err(set).to_string();
        assert!(error.contains(message), "`{message}` is not in:\n{error}");
    };
    let far = "mission.length_m=far";
    assert_says(
        far,
        "--set mission.length_m=far: `mission.length_m` is \"far\", allowed is a number",
    );
    assert_says(far, "  1 | mission.length_m=far\n    |                  ^^^");
    assert_says(
        "vehicle.curb_mass_kg=-3",
        "`vehicle.curb_mass_kg` is -3, allowed is 500 to 100000",
    );
    let key = "driver.curve_sped.exponent=0.5";
    assert_says(key, "`driver.curve_sped` is not a key");
    assert_says(key, "did you mean `curve_speed`?");
    assert_says(
        "vehicle.axles.9.tyres=2",
        "`vehicle.axles` has 5 entries, allowed is an index of 0 to 4, not `9`",
    );
    assert_says(
        "vehicle.axles.9.tyres=2",
        "  1 | vehicle.axles.9.tyres=2\n    | ^^^^^^^^^^^^^^^^^^^^^",
    );
    assert_says("vehicle.axles.tyres=2", "allowed is an index of 0 to 4, not `tyres`");
    assert_says("vehicle.axles=3", "`vehicle.axles` is 3, allowed is a list");
    let component = "mission.payload_kg.components.2=5000";
    let list =
        "`mission.payload_kg.components` has 2 entries, allowed is an index of 0 to 1, not `2`";
    assert_says(component, &format!("--set {component}: {list}"));
    let law = "mission.payload_kg.distribution=0";
    assert_says(law, "`mission.payload_kg.distribution` is 0, which is not one of its values");
    assert_says(law, "`normal`");
    let part = "mission.payload_kg.components.1.distribution=true";
    assert_says(part, "`mission.payload_kg.components[1].distribution` is true");
    assert_says(part, "`normal`");
    assert_says("mission.payload_kg={}", "has no key in its table");
    assert_says("nonsense", "`--set nonsense` has no `=`");
}

#[test]
fn probabilities_replace_what_was_inherited() {
    let text = r#"
[study]
name = "two types"
description = "no motorways"
base = "field-truck"
drop = ["road.types.motorway", "traffic.types.motorway"]

[road.types.urban]
next = { rural = 1.0 }

[road.types.rural]
next = { urban = 1.0 }
ground = { gravel = 1.0 }
"#;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.toml");
    std::fs::write(&path, text).unwrap();
    let load = |sets: &[&str]| ocmc_io::study::load(path.to_str().unwrap(), sets);
    let rural = load(&[]).unwrap().model.road.types["rural"].clone();
    assert_eq!((rural.next.len(), rural.ground.len()), (1, 1));
    // the steps of a setting change one of them, a table in a setting all
    let one = load(&["road.types.rural.ground.asphalt=0.0"]).unwrap();
    assert_eq!(one.model.road.types["rural"].ground.len(), 2);
    let all = load(&["road.types.rural.ground={asphalt=1.0}"]).unwrap();
    assert_eq!(all.model.road.types["rural"].ground.len(), 1);
}

#[test]
fn a_wrong_dictionary_names_the_key() {
    let assert_says = |dictionary: serde_json::Value, message: &str| {
        let error = study::load_json::<&str>(&dictionary, &[]).expect_err(message).to_string();
        assert!(error.contains(message), "`{message}` is not in:\n{error}");
    };
    let mission = |mission: serde_json::Value| {
        let study = serde_json::json!({ "base": "field-truck" });
        serde_json::json!({ "study": study, "mission": mission })
    };
    assert_says(
        mission(serde_json::json!({ "length_m": null })),
        "`mission.length_m` is null or nan",
    );
    assert_says(mission(serde_json::json!({ "lenght_m": 1.0 })), "did you mean `length_m`?");
    assert_says(
        mission(serde_json::json!({ "length_m": -1 })),
        "`mission.length_m` is -1, allowed is 200",
    );
    assert_says(serde_json::json!([1]), "`a study` is a list, allowed is a table");
    let mut deep = serde_json::json!(1);
    for _ in 0..100 {
        deep = serde_json::json!({ "a": deep });
    }
    assert_says(deep, "nested more than 64 deep");
}

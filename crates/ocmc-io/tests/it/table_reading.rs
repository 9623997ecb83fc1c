//! How tables are read: what is a missing number, and what is said of what is wrong.

use ocmc_io::table::formats::{CURVES, ENGINE_CURVES, LOG};
use ocmc_io::table::{Mapping, Quantity, Schema, Source, Table};
use ocmc_io::{curve_table, drive_cycle, log};
use std::fs;
use std::path::Path;

fn open(schema: &'static Schema, text: &str, mappings: &[Mapping]) -> Result<Table, String> {
    let source = Source::Text(Path::new("t.csv"), text);
    Table::open(source, schema, mappings).map_err(|error| error.to_string())
}

/// The speeds of a table of curves, or what is wrong with it.
fn speeds(text: &str) -> Result<Vec<f64>, String> {
    let table = open(&CURVES, text, &[])?;
    table.numbers([Quantity::Speed]).map(|[speeds]| speeds).map_err(|error| error.to_string())
}

#[test]
fn numbers_and_gaps() {
    let found = speeds("\u{feff}speed_mps, b\n1,2\n,NaN\n1e3 , 4\nN/A,\ninf,-\n").unwrap();
    assert!(found[0] == 1.0 && found[1].is_nan() && found[2] == 1000.0 && found[3].is_nan());
    assert_eq!(found[4], f64::INFINITY);
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    for (text, parts) in [
        ("", &["is empty"][..]),
        ("\n\n", &["is empty"]),
        (
            "b,sped_mps\n1,2\n",
            &["no column for the speed", "b, sped_mps (did you mean `sped_mps`?)"],
        ),
        ("b,speed_furlongs\n1,2\n", &["(`speed_furlongs` has no known unit)", "`speed_kmh`"]),
        ("speed_mps,b\n", &["no rows"]),
        ("b;speed_mps\n1;2.5\n1;2,5\n", &["line 3", "`2,5`", "a number with a decimal point"]),
        ("speed_mps\nfast\n", &["line 2", "speed_mps", "`fast`", "a number"]),
        ("speed_mps,b\n1,2\n3\n", &["line 3 has 1 cells", "2"]),
        ("speed_mps,speed_mps\n1,2\n", &["`speed_mps` and `speed_mps`", "both the speed"]),
        ("# one\n\nspeed_mps\n# two\n\n1\nfast\n", &["line 7"]),
        ("# one\r\n\r\nspeed_mps\r\n# two\r\n\r\n1\r\nfast", &["line 7"]),
        ("b,speed_mps\n\"x\ny\",1\nz,fast\n", &["line 4"]),
    ] {
        let message = speeds(text).expect_err(text);
        for part in parts {
            assert!(message.contains(part) && message.contains("t.csv"), "{text:?}: {message}");
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.csv");
    fs::write(&path, b"driver,radius_m,speed_mps\na,1,1\n\xff,1,1\n").unwrap();
    let message = curve_table::read(Source::File(&path), &[]).unwrap_err().to_string();
    assert!(message.contains("line 3") && message.contains("UTF-8"), "{message}");
    // as a shell or a spreadsheet writes it, with its mark and without
    for mark in ["\u{feff}", ""] {
        let text = format!("{mark}position_m,speed_limit_kmh\n0,50\n300,50\n");
        let bytes: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        fs::write(&path, &bytes).unwrap();
        let message = curve_table::read(Source::File(&path), &[]).unwrap_err().to_string();
        assert!(message.contains("is in UTF-16; save it in UTF-8"), "{message}");
    }
}

/// Reading ends at first rows that are no drive: a fault further down is not met.
#[test]
fn what_stands_still_is_not_read_to_its_end() {
    let path = Path::new("t.csv");
    let cycle = "time_s,speed_mps\n0,1\n0,1\n1,1\n2,never\n";
    let error = drive_cycle::read(Source::Text(path, cycle), &[]).unwrap_err().to_string();
    assert!(error.contains("at point 2, `time since the point before` is 0"), "{error}");
    let rows = "0,10,0\n".repeat(100_000);
    let log = format!("time_s,speed_mps,yaw_rate_radps\n{rows}");
    let needs: [log::Need; 1] = [&[Quantity::Time]];
    let error = log::read(Source::Text(path, &log), &[], &needs).unwrap_err().to_string();
    assert!(error.contains("of its first 100000 rows 99999 repeat the time"), "{error}");
    // a clock of whole seconds over a log of 50 Hz goes on
    let rows: Vec<String> = (0..110_000).map(|k| format!("{},10,0\n", k / 50)).collect();
    let log = format!("time_s,speed_mps,yaw_rate_radps\n{}", rows.concat());
    assert_eq!(log::read(Source::Text(path, &log), &[], &needs).unwrap().rows, 110_000);
}

#[test]
fn descriptions_of_others_are_understood() {
    let text = "  # made by hand\n n [U/min];Mfull [Nm];<PT1> [s];Mdrag\n560;1180;0.6;-1\n \n # x\n\
                600; 1282 ;0.6;-2\n";
    let table = open(&ENGINE_CURVES, text, &[]).unwrap();
    let mut places = Vec::new();
    table
        .for_each(|row| {
            places.push((row.place().to_string(), row.number(Quantity::FullLoadTorque)?));
            Ok(())
        })
        .unwrap();
    assert_eq!(places, [("line 3".to_owned(), 1180.0), ("line 6".to_owned(), 1282.0)]);
    let message = open(&ENGINE_CURVES, "n,Mfull [kNm]\n1,2\n", &[]).err().unwrap();
    assert!(message.contains("`Mfull [kNm]` is read in Nm, not in kNm"), "{message}");
    // Latin-1, as old files are
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cycle.csv");
    fs::write(&path, b"time_s,speed_kmh,stra\xdfe\n0,0,a\n1,36,b\n2,0,c\n").unwrap();
    let cycle = drive_cycle::read(Source::File(&path), &[]).unwrap();
    assert_eq!(cycle.points().nth(1).unwrap()[1], 10.0);
}

#[test]
fn assigned_columns_come_before_named_ones() {
    let mappings: Vec<Mapping> = ["speed_mph=gps_speed", "yaw_rate_degps=-gyro", "driver=who"]
        .iter()
        .map(|text| Mapping::parse(text).unwrap())
        .collect();
    let header = "time_s,speed_mps,gps_speed,gyro,who\n0,1,2,3,a\n";
    let table = open(&LOG, header, &mappings).unwrap();
    let place = |quantity| table.column(quantity).map(|column| column.place);
    assert_eq!(place(Quantity::Speed), Some(2));
    assert_eq!((place(Quantity::YawRate), place(Quantity::Driver)), (Some(3), Some(4)));
    assert_eq!(table.column(Quantity::YawRate).unwrap().sign, -1.0);
}

#[test]
fn a_name_of_the_format_comes_before_others() {
    let place = |schema, header: &str, quantity| {
        let table = open(schema, &format!("{header}\n1,1\n"), &[]).unwrap();
        table.column(quantity).map(|column| column.place)
    };
    assert_eq!(place(&LOG, "speed_limit_kmh,limit_kmh", Quantity::Limit), Some(1));
    assert_eq!(place(&LOG, "Speed_mps,speed_mps", Quantity::Speed), Some(1));
    assert_eq!(place(&CURVES, "speed_kmh,speed_mps", Quantity::Speed), Some(1));
    assert_eq!(place(&CURVES, "truck,driver", Quantity::Driver), Some(1));
    let message = open(&LOG, "speed_kmh,speed_mps\n1,1\n", &[]).err().unwrap();
    assert!(
        message.contains("`speed_kmh` and `speed_mps`") && message.contains("--map"),
        "{message}"
    );
    let message = open(&CURVES, "limit_mps,speed_limit_mps\n1,1\n", &[]).err().unwrap();
    assert!(message.contains("both the speed limit"), "{message}");
}

#[test]
fn wrong_assignments_are_said() {
    let message = |text: &str| Mapping::parse(text).unwrap_err().to_string();
    assert!(message("speed_furlongs=v").contains("speed_mps, speed_kmh, speed_mph"));
    assert!(message("sped_mps=v").contains("did you mean `speed_mps`?"));
    assert!(message("speed_mps").contains("NAME=COLUMN"));
    let mapping = [Mapping::parse("yaw_rate_degps=speed_mp").unwrap()];
    let message = open(&LOG, "time_s,speed_mps\n0,1\n", &mapping).err().unwrap();
    assert!(message.contains("no column `speed_mp` (did you mean `speed_mps`?)"), "{message}");
    let message = Mapping::parse("limit=speed_mps").unwrap_err().to_string();
    assert!(message.contains("`limit` has no known unit: allowed are limit_mps"), "{message}");
}

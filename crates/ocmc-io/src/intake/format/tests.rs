//! Tests of what each format gives, and of what is refused.

use super::*;
use crate::intake::table::given::Cells;
use std::io::{Cursor, Write};

fn content(bytes: &[u8]) -> Result<Content, String> {
    recognise(bytes).expect("a format").read(Path::new("a"), bytes)
}

fn columns(text: &str) -> GivenTable {
    match content(text.as_bytes()) {
        Ok(Content::Columns(table, _)) => table,
        Ok(Content::Cells(..)) => panic!("no columns"),
        Err(reason) => panic!("{reason}"),
    }
}

fn names(table: &GivenTable) -> Vec<&str> {
    table.names().iter().map(String::as_str).collect()
}

fn numbers(table: &GivenTable, name: &str) -> Vec<f64> {
    let place = names(table).iter().position(|known| *known == name).expect("a column");
    match table.cells(place) {
        Ok(Cells::Numbers(numbers)) => numbers.values().to_vec(),
        other => panic!("{other:?}"),
    }
}

fn words(table: &GivenTable, name: &str) -> Vec<String> {
    let place = names(table).iter().position(|known| *known == name).expect("a column");
    let words = table.words(place).expect("words");
    words.iter().map(|word| word.unwrap_or("").to_owned()).collect()
}

#[test]
fn tracks_of_gpx_are_drives_and_their_segments_are_not() {
    let point = |k: u32| {
        format!(
            "<trkpt lat='5{k}' \
             lon='9'><ele>{k}</ele><time>2024-03-04T06:00:0{k}Z</time><extensions>\
             <x:TrackPointExtension><x:speed>1{k}.5</x:speed><x:course>90</x:course>\
             </x:TrackPointExtension></extensions></trkpt>"
        )
    };
    let text = format!(
        "<?xml version='1.0'?><gpx><wpt lat='1' lon='1'><name>w</name></wpt><trk><name>a &amp; \
         b</name>\
         <trkseg>{}</trkseg><trkseg>{}</trkseg></trk><trk><trkseg>{}</trkseg></trk></gpx>",
        point(1),
        point(2),
        point(3)
    );
    let table = columns(&text);
    assert_eq!(words(&table, "drive"), ["a & b", "a & b", "track 2"]);
    assert_eq!(numbers(&table, "latitude_deg"), [51.0, 52.0, 53.0]);
    assert_eq!(numbers(&table, "altitude_m"), [1.0, 2.0, 3.0]);
    assert_eq!(numbers(&table, "speed_mps"), [11.5, 12.5, 13.5]);
    assert_eq!(numbers(&table, "course_deg"), [90.0; 3]);
    assert_eq!(words(&table, "time")[2], "2024-03-04T06:00:03Z");
    // of a file without tracks the routes are taken
    let route = "<gpx><rte><rtept lat='50' lon='9'/><rtept lat='51' lon='9'/></rte></gpx>";
    assert_eq!(names(&columns(route)), ["latitude_deg", "longitude_deg"]);
}

#[test]
fn kml_and_geojson_tell_the_same_line() {
    let kml = "<kml xmlns:gx='g'><Placemark><name>a</name><LineString><coordinates>9,50,7 \
               9.1,50.1,8\
               </coordinates></LineString></Placemark></kml>";
    let geojson = r#"{"type":"Feature","properties":{"name":"a"},
                      "geometry":{"type":"LineString","coordinates":[[9,50,7],[9.1,50.1,8]]}}"#;
    for text in [kml, geojson] {
        let table = columns(text);
        assert_eq!(names(&table), ["latitude_deg", "longitude_deg", "altitude_m"]);
        assert_eq!(numbers(&table, "longitude_deg"), [9.0, 9.1]);
        assert_eq!(numbers(&table, "altitude_m"), [7.0, 8.0]);
    }
    let timed = "<kml xmlns:gx='g'><Placemark><gx:Track><when>2024-01-01T00:00:00Z</when>\
                 <when>2024-01-01T00:00:01Z</when><gx:coord>9 50 7</gx:coord><gx:coord>9 51 \
                 7</gx:coord>\
                 </gx:Track></Placemark></kml>";
    assert_eq!(words(&columns(timed), "time")[1], "2024-01-01T00:00:01Z");
    let times = r#"{"type":"Feature","properties":{"coordTimes":[1704067200000, "2024-01-01T00:00:01Z"]},
                    "geometry":{"type":"LineString","coordinates":[[9,50],[9.1,50.1]]}}"#;
    assert_eq!(words(&columns(times), "time"), ["2024-01-01T00:00:00Z", "2024-01-01T00:00:01Z"]);
    let places = r#"{"type":"FeatureCollection","features":[
        {"type":"Feature","properties":{"speed_kmh":50,"stop":"x"},
         "geometry":{"type":"Point","coordinates":[9,50]}},
        {"type":"Feature","properties":{"speed_kmh":null},
         "geometry":{"type":"Point","coordinates":[9,51]}}]}"#;
    let table = columns(places);
    assert_eq!(names(&table), ["speed_kmh", "stop", "latitude_deg", "longitude_deg"]);
    assert!(numbers(&table, "speed_kmh")[1].is_nan());
}

#[test]
fn messages_of_rfms_stand_by_vehicle_and_time() {
    let status = |vin: &str, second: u32, trigger: &str| {
        format!(
            r#"{{"vin":"{vin}","createdDateTime":"2024-03-04T06:00:0{second}Z",
                "triggerType":{{"triggerType":"{trigger}"}},"engineTotalFuelUsed":{second}500,
                "grossCombinationVehicleWeight":30000,"hrTotalVehicleDistance":{second},
                "driver1Id":{{"tachoDriverIdentification":{{"driverIdentification":"d"}}}},
                "snapshotData":{{"wheelBasedSpeed":72.5,"ambientAirTemperature":-3.5,
                "gnssPosition":{{"latitude":50,"longitude":9,"heading":90}}}}}}"#
        )
    };
    let all = [status("B", 1, "TIMER"), status("A", 2, "ENGINE_OFF"), status("A", 1, "ENGINE_ON")];
    let text = format!(r#"{{"vehicleStatusResponse":{{"vehicleStatuses":[{}]}}}}"#, all.join(","));
    let table = columns(&text);
    assert_eq!(words(&table, "truck"), ["A", "A", "B"]);
    assert_eq!(words(&table, "ignition"), ["on", "off", ""]);
    assert_eq!(words(&table, "driver"), ["d"; 3]);
    assert_eq!(numbers(&table, "fuel_used_l"), [1.5, 2.5, 1.5]);
    assert_eq!(numbers(&table, "speed_kmh"), [72.5; 3]);
    assert_eq!(numbers(&table, "ambient_temperature_c"), [-3.5; 3]);
    assert_eq!(numbers(&table, "position_m"), [1.0, 2.0, 1.0]);
    let positions = r#"[{"vehiclePositionResponse":{"vehiclePositions":[{"vin":"A",
        "gnssPosition":{"latitude":50,"longitude":9,"positionDateTime":"2024-03-04T06:00:00Z"}}]}}]"#;
    assert_eq!(words(&columns(positions), "time"), ["2024-03-04T06:00:00Z"]);
}

#[test]
fn a_schedule_of_the_epa_keeps_its_lines() {
    let text = "UDDS.TXT\tUrban Dynamometer Driving Schedule\nTest Time, secs Target Speed, mph\n\
                0\t0\n1\t3.5\n";
    let Ok(Content::Cells(cells, findings)) = content(text.as_bytes()) else { panic!("no cells") };
    assert_eq!(cells, "\ntime_s,speed_mph\n0,0\n1,3.5\n");
    assert!(findings[0].text.contains("Urban Dynamometer"));
}

#[test]
fn bombs_and_broken_files_are_refused() {
    let entities =
        "<?xml version='1.0'?><!DOCTYPE gpx [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;'>]><gpx/>";
    let deep = format!("<gpx>{}", "<a>".repeat(100_000));
    for (text, words) in [
        (entities, "document type"),
        (deep.as_str(), "within each other"),
        ("<gpx><trk><trkseg><trkpt lat='50' lon='9'>", "ends within"),
        ("<gpx><trk></trkseg></gpx>", "not well formed"),
        ("<gpx><trk><trkseg><trkpt lat='95' lon='9'/></trkseg></trk></gpx>", "latitude 95"),
        ("<gpx></gpx>", "no track"),
        (r#"{"type":"FeatureCollection","features":[]}"#, "no track"),
        (r#"{"type":"FeatureCollection","features":["#, "has a fault"),
        (r#"{"vehicleStatusResponse":{"vehicleStatuses":[]}}"#, "no message"),
    ] {
        let reason = content(text.as_bytes()).err().unwrap_or_default();
        assert!(reason.contains(words), "{text:.60}: {reason}");
    }
    // 400 MiB of zeros are 400 kB in an archive
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    archive
        .start_file("xl/workbook.xml", zip::write::SimpleFileOptions::default())
        .expect("memory");
    let zeros = vec![0; 1 << 20];
    for _ in 0..400 {
        archive.write_all(&zeros).expect("memory");
    }
    let bytes = archive.finish().expect("memory").into_inner();
    let reason = content(&bytes).err().unwrap_or_default();
    assert!(bytes.len() < 1 << 20 && reason.contains("expands to more than"), "{reason}");
}

/// An archive of these parts.
fn archive(parts: &[(&str, &str)]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, text) in parts {
        archive.start_file(*name, zip::write::SimpleFileOptions::default()).expect("a part");
        archive.write_all(text.as_bytes()).expect("space");
    }
    archive.finish().expect("an archive").into_inner()
}

#[test]
fn weather_is_read_out_of_the_archive_in_which_it_is_published() {
    let series = "STATIONS_ID;MESS_DATUM;QN_3;   F;   D;eor\n433;2023010100;3;4.2;180;eor\n";
    let about = ("Metadaten_Geographie_00433.txt", "Stations_id;Stationshoehe\n433;48\n");
    let part = ("produkt_ff_stunde_20230101_20231231_00433.txt", series);
    match content(&archive(&[about, part])) {
        Ok(Content::Cells(text, findings)) => {
            assert_eq!(text, series);
            assert!(findings[0].text.contains(part.0), "{}", findings[0]);
        }
        _ => panic!("no cells"),
    }
    let heading = "LOCATION,x\nDESIGN CONDITIONS,0\n".to_owned() + &"y\n".repeat(6);
    match content(&archive(&[("a.ddy", "x"), ("a.EPW", &heading)])) {
        Ok(Content::Cells(text, _)) => assert!(text.contains("time_h,temperature_c"), "{text}"),
        _ => panic!("no cells"),
    }
    let reason = content(&archive(&[part, ("produkt_tu_stunde_1.txt", series)])).err();
    assert!(reason.is_some_and(|reason| reason.contains("expand it, and name one")));
    assert!(content(&archive(&[about])).is_err());
}

#[test]
fn rows_of_a_sheet_have_the_cells_of_its_names() {
    let cell =
        |at: &str, text: &str| format!("<c r=\"{at}\" t=\"inlineStr\"><is><t>{text}</t></is></c>");
    // a title, and a last row whose last cell is not there
    let rows = [
        format!("<row r=\"1\">{}</row>", cell("A1", "tour")),
        format!("<row r=\"3\">{}{}</row>", cell("A3", "place"), cell("B3", "km")),
        format!("<row r=\"4\">{}<c r=\"B4\"><v>0</v></c></row>", cell("A4", "a")),
        format!("<row r=\"5\">{}</row>", cell("A5", "b")),
    ]
    .concat();
    let space = "http://schemas.openxmlformats.org/";
    let relation = |kind: &str, target: &str| {
        format!(
            "<Relationships xmlns=\"{space}package/2006/relationships\"><Relationship Id=\"rId1\" \
             Type=\"{space}officeDocument/2006/relationships/{kind}\" Target=\"{target}\"/>\
             </Relationships>"
        )
    };
    let book = format!(
        "<workbook xmlns=\"{space}spreadsheetml/2006/main\" xmlns:r=\"{space}officeDocument/2006/\
         relationships\"><sheets><sheet name=\"a\" sheetId=\"1\" \
         r:id=\"rId1\"/></sheets></workbook>"
    );
    let sheet = format!(
        "<worksheet xmlns=\"{space}spreadsheetml/2006/main\"><sheetData>{rows}</sheetData>\
         </worksheet>"
    );
    let bytes = archive(&[
        ("xl/workbook.xml", &book),
        ("_rels/.rels", &relation("officeDocument", "xl/workbook.xml")),
        ("xl/_rels/workbook.xml.rels", &relation("worksheet", "worksheets/sheet1.xml")),
        ("xl/worksheets/sheet1.xml", &sheet),
    ]);
    match content(&bytes) {
        Ok(Content::Cells(text, _)) => assert_eq!(text, "tour\n\nplace,km\na,0\nb,\n"),
        _ => panic!("no cells"),
    }
}

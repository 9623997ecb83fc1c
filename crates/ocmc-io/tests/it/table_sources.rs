//! One table, however it is written and packed, gives the same values to every command that takes
//! it.

use arrow_array::{ArrayRef, Float64Array, RecordBatch, StringArray};
use flate2::Compression;
use flate2::write::GzEncoder;
use ocmc_estimation::fit::speed_change::{SpeedChangeOptions, SpeedChangeTable};
use ocmc_io::table::{Mapping, Source};
use ocmc_io::{
    curve_table, drive_cycle, given_cycle, log, speed_change_table, study, traffic_table,
    weather_table,
};
use parquet::arrow::ArrowWriter;
use std::fmt::{Debug, Write as _};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tempfile::TempDir;

/// Ways to write the same table.
const WAYS: [&str; 7] = ["plain", "semicolons", "tabulators", "quoted", "gzip", "zstd", "parquet"];

/// Writes a table with commas under this name in its own folder in each way.
fn written(folder: &TempDir, name: &str, text: &str) -> Vec<PathBuf> {
    let write = |way: &str| {
        let (bytes, ending) = match way {
            "semicolons" => (text.replace(',', ";").into_bytes(), ""),
            "tabulators" => (text.replace(',', "\t").into_bytes(), ""),
            "quoted" => (quoted(text).into_bytes(), ""),
            "gzip" => {
                let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
                packed.write_all(text.as_bytes()).unwrap();
                (packed.finish().unwrap(), ".gz")
            }
            "zstd" => (zstd::encode_all(text.as_bytes(), 1).unwrap(), ".zst"),
            "parquet" => (parquet(text), ""),
            _ => (text.as_bytes().to_vec(), ""),
        };
        let path = folder.path().join(way);
        fs::create_dir_all(&path).unwrap();
        let path = path.join(format!("{name}{ending}"));
        fs::write(&path, bytes).unwrap();
        path
    };
    WAYS.into_iter().map(write).collect()
}

/// Every cell in quotation marks.
fn quoted(text: &str) -> String {
    let mut quoted = String::new();
    for line in text.lines() {
        let cells: Vec<String> = line.split(',').map(|cell| format!("\"{cell}\"")).collect();
        writeln!(quoted, "{}", cells.join(",")).unwrap();
    }
    quoted
}

/// Columns of numbers where every cell is one or empty, otherwise of texts.
fn parquet(text: &str) -> Vec<u8> {
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let columns = rows[0].iter().enumerate().map(|(k, name)| {
        let cells: Vec<&str> = rows[1..].iter().map(|row| row[k]).collect();
        let numbers = cells.iter().map(|cell| match *cell {
            "" => Some(None),
            cell => cell.parse::<f64>().ok().map(Some),
        });
        let column: ArrayRef = match numbers.collect::<Option<Vec<Option<f64>>>>() {
            Some(numbers) => Arc::new(Float64Array::from(numbers)),
            None => Arc::new(StringArray::from(cells)),
        };
        (*name, column)
    });
    let batch = RecordBatch::try_from_iter(columns).unwrap();
    let mut writer = ArrowWriter::try_new(Vec::new(), batch.schema(), None).unwrap();
    writer.write(&batch).unwrap();
    writer.into_inner().unwrap()
}

/// Reads a table in each way, and compares what is read.
fn same<T: Debug>(name: &str, text: &str, read: impl Fn(&Path) -> T) {
    let folder = tempfile::tempdir().unwrap();
    let mut first: Option<String> = None;
    for (path, way) in written(&folder, name, text).iter().zip(WAYS) {
        let found = format!("{:?}", read(path));
        assert_eq!(first.get_or_insert_with(|| found.clone()), &found, "{name} {way}");
    }
}

#[test]
fn measurements() {
    let curves = "driver,radius_m,direction,speed_kmh,limit_kmh\na,100,left,36.5,50\n\
                  b,,right,40,\na,250.25,left,52,70\n";
    same("curves.csv", curves, |path| curve_table::read(Source::File(path), &[]).unwrap().0);
    let changes = "driver,category,acceleration_mps2\na,70-to-40,-0.75\nb,x,0.5\na,x,\n";
    same("changes.csv", changes, |path| {
        let mut table = SpeedChangeTable::default();
        let options = SpeedChangeOptions::default();
        speed_change_table::append(&mut table, Source::File(path), &[], &options).unwrap();
        table
    });
    let weather = "time,temperature_c,relative_humidity_percent,wind_speed_kmh\n\
                   2024-02-29T23:00,-3.5,80,18\n2024-03-01T00:00,,85.5,7\n";
    same("weather.csv", weather, |path| {
        weather_table::read(&[Source::File(path)], &[], None).unwrap().0
    });
    let model = study::load("field-truck", &[] as &[&str]).unwrap().model.traffic;
    let traffic = "time_s,road_type,density_share\n0,urban,0.25\n300,urban,\n600,rural,0.125\n";
    same("traffic.csv", traffic, |path| {
        traffic_table::read(Source::File(path), &[], &model, None).unwrap()
    });
}

#[test]
fn logs() {
    let text = "time_s,speed_kmh,speed_limit_mph,driver,road_type\n0,36,30,a,rural\n\
                1,37.5,30,a,rural\n0,20,,b,urban\n1,-,50,b,urban\n";
    same("log.csv", text, |path| {
        let file = log::read(Source::File(path), &[], &[]).unwrap();
        (file.drives, file.rows, file.ragged_rows, file.unreadable)
    });
}

#[test]
fn routes_and_cycles() {
    let read = |path: &Path| given_cycle::read(path, &[]).unwrap();
    let route = "position_m,speed_limit_kmh,altitude_m,stop_s,road_type\n0,50,10,0,urban\n\
                 100,50,12.5,20,urban\n600,70,3,,rural\n";
    same("route.csv", route, read);
    let vecto = "<s>,<v> [km/h],<grad> [%],<stop>\n0,0,3,2\n9,60,3,0\n100,60,0,0\n150,0,0,25\n\
                 155,30,-3,0\n400,0,0,2\n";
    same("cycle.vdri", vecto, read);
    let tracks = "track,rule,position_m,value\nspeed_limit_mps,constant,0.0,13.9\n\
                  speed_limit_mps,constant,500.0,22.2\nroad_type,constant,0.0,rural\n";
    same("tracks.csv", tracks, read);
    let cycle = "time_s,speed_kmh,grade\n0,0,0\n10,36,0.01\n20,36,0.02\n30.5,0,0\n";
    same("speed.csv", cycle, |path| {
        assert!(drive_cycle::is_one(Source::File(path), &[]));
        drive_cycle::read(Source::File(path), &[]).unwrap()
    });
}

#[test]
fn maps_of_engines() {
    let mut map = "engine speed [rpm],torque [Nm],fuel consumption [g/h]\n".to_owned();
    for speed in [500, 1000, 1500, 2000, 2500] {
        for torque in [-200, 0, 500, 1000, 1500, 2000, 2500] {
            let fuel = (f64::from(speed) * f64::from(torque + 220) / 45.0).max(0.0);
            writeln!(map, "{speed},{torque},{fuel}").unwrap();
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let full_load = "n,Mfull,Mdrag\n600,1200,-60\n1000,2300,-80\n1400,2300,-110\n\
                     1800,2000,-150\n2100,1400,-180\n";
    let full_load = written(&folder, "engine.vfld", full_load);
    let engine = |k: usize, map: String| {
        let full_load =
            format!("vehicle.powertrain.combustion.engine.full_load_file={:?}", full_load[k]);
        let study = study::load("field-truck", &[full_load, map]).unwrap();
        study.model.vehicle.powertrain.combustion().unwrap().engine.clone()
    };
    same("engine.vmap", &map, |path| {
        let k = WAYS.iter().position(|way| path.parent().unwrap().ends_with(way)).unwrap();
        engine(k, format!("vehicle.powertrain.combustion.engine.map_file={path:?}"))
    });
    let path = folder.path().join("mine.csv");
    fs::write(&path, map.replace("torque [Nm]", "load")).unwrap();
    let columns = "columns = { torque_nm = 'load' }";
    let mine = engine(
        0,
        format!("vehicle.powertrain.combustion.engine.map_file={{ file = {path:?}, {columns} }}"),
    );
    // from 0 Nm on
    assert_eq!(mine.map_torque_nm.len(), 6);
}

#[test]
fn a_cell_in_quotation_marks_may_hold_the_separator() {
    let path = Path::new("speed.csv");
    let text = "note,time_s,speed_mps\n\"a, b\",0,0\n\"c\",1,\"5.5\"\n\"d, \"\"e\"\"\",2,0\n";
    let cycle = drive_cycle::read(Source::Text(path, text), &[]).unwrap();
    assert_eq!(cycle.points().map(|point| point[1]).collect::<Vec<_>>(), [0.0, 5.5, 0.0]);
}

#[test]
fn assigned_columns_are_read_in_every_format() {
    let mapped = |texts: &[&str]| -> Vec<Mapping> {
        texts.iter().map(|text| Mapping::parse(text).unwrap()).collect()
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("route.csv");
    fs::write(&path, "way,vmax\n0,50\n600,70\n").unwrap();
    let route = given_cycle::read(&path, &mapped(&["position_m=way", "limit_mph=vmax"])).unwrap();
    assert_eq!(route.limits, [(0.0, 50.0 * 0.44704), (600.0, 70.0 * 0.44704)]);
    let text = "stamp,warm\n0,5\n3600,6\n";
    let source = Source::Text(Path::new("weather.csv"), text);
    let mappings = mapped(&["time_s=stamp", "temperature_c=warm"]);
    let weather = weather_table::read(&[source], &mappings, None).unwrap().0;
    assert_eq!(weather[1].weather.temperature_k, 279.15);
    let source = Source::Text(Path::new("speed.csv"), "stamp,back\n0,0\n1,-5\n2,0\n");
    let cycle = drive_cycle::read(source, &mapped(&["t=stamp", "speed_kn=-back"])).unwrap();
    assert_eq!(cycle.points().nth(1).unwrap()[1], 5.0 * (1852.0 / 3600.0));
    // what a format does not have is said
    let fault = drive_cycle::read(source, &mapped(&["gear=back"])).unwrap_err().to_string();
    assert!(fault.contains("nothing of a drive cycle"), "{fault}");
    let fault = drive_cycle::read(source, &mapped(&["time_s=stemp"])).unwrap_err().to_string();
    assert!(fault.contains("did you mean `stamp`?"), "{fault}");
}

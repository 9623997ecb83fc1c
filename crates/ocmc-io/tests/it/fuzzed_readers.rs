//! Whatever is done to a file, each reader ends with an answer or an error: within a gigabyte of
//! address space, within seconds, without a panic. `OCMC_FUZZ_INPUTS=10000` reads so many a reader.
#![cfg(target_os = "linux")]

use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use ocmc_core::operating_cycle::drawn_part::Draw;
use ocmc_core::operating_cycle::traffic::TrafficModel;
use ocmc_estimation::fit::speed_change::{SpeedChangeOptions, SpeedChangeTable};
use ocmc_fleet::run::{RunPlan, records as drive};
use ocmc_fleet::summary::SummaryBuilder;
use ocmc_io::given_cycle::RouteOptions;
use ocmc_io::given_drive::GivenDrive;
use ocmc_io::operating_cycle::RealisedCycle;
use ocmc_io::records::{self, RecordFormat};
use ocmc_io::run_directory::{self, CHUNK_ROWS, Manifest, RunDirectory, RunSummary};
use ocmc_io::study::{self, Files};
use ocmc_io::table::Source;
use ocmc_io::{curve_table, drive_cycle, given_cycle, log, speed_change_table};
use ocmc_io::{fleet_table, traffic_table, trip_totals, weather_table};
use parquet::arrow::ArrowWriter;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Address space of the process that reads, in KiB.
const MOST_KIB: u64 = 1 << 20;
/// Longest that a file may take.
const LONGEST: Duration = Duration::from_secs(20);
/// Files that one process reads.
const BATCH: u64 = 1000;

const NO_SETS: &[&str] = &[];

const FASTSIM: &str = "---\nveh_pt_type: Conv\ndrag_coef: 0.5\nfrontal_area_m2: 10.0\n\
                       cargo_kg: 1000.0\nveh_override_kg: \nveh_kg: 11000.0\n\
                       drive_axle_weight_frac: 0.6\nfc_max_kw: 200.0\nfc_pwr_out_perc:\n  v: 1\n  \
                       dim:\n    - 3\n  data:\n    - 0.0\n    - 0.5\n    - 1.0\n\
                       fc_eff_map: [0.36, 0.4, 0.38]\nwheel_inertia_kg_m2: 5.0\nnum_wheels: 6.0\n\
                       wheel_rr_coef: 0.007\nwheel_radius_m: 0.45\nalt_eff: 0.5\naux_kw: 2.0\n\
                       trans_eff: 0.9\n";

const STOP_PLAN: &str = "order;place;km;dwell_min;load_kg;unload_kg;departure\n\
                         1;a;0;;900;;2024-03-04 06:30\n2;b;8,5;20;;300;\n3;c;17,25;15;50;600;\n\
                         4;d;30;;;50;\n";

/// Numbers without a pattern: splitmix64.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }
}

/// Replacements for a piece of text.
const PIECES: [&str; 28] = [
    "",
    "0",
    "-1",
    "nan",
    "inf",
    "-inf",
    "1e308",
    "-1e308",
    "1e-308",
    "99999999999999999999",
    "1e9",
    "'",
    "\"",
    ",",
    ";",
    "\t",
    "\n",
    "\r",
    "\r\n",
    "#",
    "=",
    "[",
    "]",
    "{",
    "}",
    "\u{0}",
    "\u{feff}",
    "\u{1b}[2J",
];

/// One to six changes of a file.
fn changed(seed: &[u8], numbers: &mut Numbers) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..=numbers.below(6) {
        let length = bytes.len();
        let at = numbers.below(length + 1);
        let end = (at + 1 + numbers.below(40)).min(length).max(at);
        match numbers.below(9) {
            0 if length > 0 => bytes[at.min(length - 1)] ^= 1 << numbers.below(8),
            1 => bytes.truncate(at),
            2 => drop(bytes.drain(at..end)),
            3 => {
                let piece = bytes[at..end].repeat(1 + numbers.below(2000));
                bytes.splice(at..at, piece);
            }
            4 => {
                let random: Vec<u8> =
                    (0..=numbers.below(16)).map(|_| numbers.next() as u8).collect();
                bytes.splice(at..at, random);
            }
            5 if length > 0 => bytes[at.min(length - 1)] = [0, 0xff, 0x7f, 0x80][numbers.below(4)],
            _ => replace_number(&mut bytes, at, PIECES[numbers.below(PIECES.len())].as_bytes()),
        }
    }
    bytes
}

/// Puts a piece in the place of the first number behind a place.
fn replace_number(bytes: &mut Vec<u8>, at: usize, piece: &[u8]) {
    let is_of_number = |byte: &u8| byte.is_ascii_digit() || b".-+eE".contains(byte);
    let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit).map(|k| at + k) else {
        return;
    };
    let length = bytes[start..].iter().take_while(|byte| is_of_number(byte)).count();
    bytes.splice(start..start + length, piece.iter().copied());
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut writer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    writer.write_all(bytes).unwrap();
    writer.finish().unwrap()
}

/// A table of numbers.
fn table(names: &str, rows: usize, cell: impl Fn(usize, usize) -> f64) -> String {
    let columns = names.split(',').count();
    let mut text = format!("{names}\n");
    for row in 0..rows {
        let cells: Vec<String> = (0..columns).map(|k| cell(row, k).to_string()).collect();
        writeln!(text, "{}", cells.join(",")).unwrap();
    }
    text
}

const LOG: &str = "time_s,speed_mps,yaw_rate_radps,limit_mps,accelerator,brake,grade";

fn log_cell(row: usize, column: usize) -> f64 {
    let t = row as f64 / 10.0;
    let speed = t.min(20.0);
    [t, speed, (t * 0.1).sin() * 0.1, 20.0, 0.3, 0.0, 0.01][column]
}

/// A log as Parquet.
fn parquet_log() -> Vec<u8> {
    let column = |k: usize| -> ArrayRef {
        Arc::new(Float64Array::from_iter_values((0..300).map(|row| log_cell(row, k))))
    };
    let columns = LOG.split(',').enumerate().map(|(k, name)| (name, column(k)));
    let batch = RecordBatch::try_from_iter(columns).unwrap();
    let mut writer = ArrowWriter::try_new(Vec::new(), batch.schema(), None).unwrap();
    writer.write(&batch).unwrap();
    writer.into_inner().unwrap()
}

/// A run of a few cycles in a directory.
fn run(directory: &Path, format: RecordFormat, is_whole: bool) {
    let loaded = study::load("field-truck", &["mission.length_m=200"]).unwrap();
    // a chunk is kept when it is full
    let cycles = if is_whole { 12 } else { CHUNK_ROWS as u64 + 6 };
    let plan = RunPlan::new(1, 0, cycles, Some(1), None);
    let manifest = Manifest::new(&loaded, &plan, &GivenDrive::nothing());
    let driven: ControlFlow<(), _> = drive(&loaded.study, &plan, |_| ControlFlow::Continue(()));
    let ControlFlow::Continue(records) = driven else { panic!("nobody breaks") };
    let mut writer = RunDirectory::create(directory, format, manifest.clone()).unwrap();
    writer.add(&records).unwrap();
    writer.settle().unwrap();
    if is_whole {
        let mut fleet = SummaryBuilder::default();
        fleet.add(&records);
        let mut summary = RunSummary::new(&manifest, fleet.finish(), 1.0, 1);
        // seeds of two runs have to fit each other
        "2026-11-27T18:00:00Z".clone_into(&mut summary.ended_at);
        writer.finish(&summary).unwrap();
    }
}

/// Seeds of a reader: valid files, each with its name.
type Seeds = Vec<(&'static str, Vec<u8>)>;

/// Whether the name of a file says that it is compressed so.
fn is_packed(name: &str, by: &str) -> bool {
    name.rsplit('.').next() == Some(by)
}

fn named(names: &[&'static str], text: &str) -> Seeds {
    let compressed = |name: &&'static str| match *name {
        name if is_packed(name, "gz") => (name, gzip(text.as_bytes())),
        name if is_packed(name, "zst") => (name, zstd::encode_all(text.as_bytes(), 1).unwrap()),
        name => (name, text.as_bytes().to_vec()),
    };
    names.iter().map(compressed).collect()
}

fn cycle() -> RealisedCycle {
    let loaded = study::load("field-truck", &["mission.length_m=2000"]).unwrap();
    RealisedCycle::new(&loaded, 1, 0)
}

fn tracks() -> String {
    let mut text = Vec::new();
    cycle().write_csv(&mut text).unwrap();
    String::from_utf8(text).unwrap()
}

/// A reader: its name, its seeds, and what it does with a file. It says whether it read something.
type Reader = (&'static str, fn() -> Seeds, fn(&Path) -> bool);

const READERS: [Reader; 16] = [
    (
        "study",
        || {
            let base = "study.base = \"field-truck\"\nmission.length_m = 3000\n";
            let mut seeds = named(&["a.toml"], base);
            seeds.extend(named(&["b.toml"], study::show("field-truck").unwrap()));
            seeds.extend(named(&["c.toml"], &study::init_text()));
            seeds
        },
        |path| study::load(path.to_str().unwrap(), NO_SETS).is_ok(),
    ),
    (
        "vehicle files",
        || {
            let map = "engine speed [rpm],torque [Nm],fuel consumption [g/h]\n";
            let map = (0..54).fold(map.to_owned(), |text, k| {
                let (speed, torque) = (600 + 200 * (k / 6), 400 * (k % 6));
                format!("{text}{speed},{torque},{}\n", 2000 + speed * torque / 50)
            });
            let curve = "engine speed [rpm],full load torque [Nm],motoring torque [Nm]\n\
                         600,1000,-100\n1000,2100,-120\n1400,2100,-150\n2000,1500,-200\n";
            let loss = "Input Speed [rpm],Input Torque [Nm],Torque Loss [Nm]\n\
                        0,0,10\n0,1000,20\n1000,0,15\n1000,1000,30\n";
            [
                named(&["a.vmap"], &map),
                named(&["a.vfld"], curve),
                named(&["a.vtlm"], loss),
                named(&["a.yaml"], FASTSIM),
            ]
            .concat()
        },
        |path| {
            let key = match path.extension().unwrap().to_str().unwrap() {
                "yaml" => {
                    let study = format!(
                        "study.name = \"a\"\nstudy.base = \"field-truck\"\nvehicle.base = '{}'\n",
                        path.display()
                    );
                    return study::load_text("a.toml", &study, NO_SETS).is_ok();
                }
                "vmap" => "engine.map_file",
                "vfld" => "engine.full_load_file",
                _ => "gearbox.direct_loss_file",
            };
            study::load(
                "field-truck",
                &[format!("vehicle.powertrain.combustion.{key}='{}'", path.display())],
            )
            .is_ok()
        },
    ),
    (
        "routes",
        || {
            let route = table("position_m,speed_limit_kmh,grade,stop_s", 60, |row, column| {
                [50.0 * row as f64, 70.0, 0.01, 0.0][column]
            });
            let places =
                table("latitude_deg,longitude_deg,altitude_m,speed_limit_kmh", 60, |row, k| {
                    [57.7 + 0.001 * row as f64, 11.9, 10.0, 70.0][k]
                });
            let vdri = "<s>,<v>,<grad>,<stop>\n0,0,0,5\n10,50,1,0\n500,50,-1,0\n1000,0,0,3\n";
            let json = serde_json::to_string(&cycle()).unwrap();
            [
                named(&["a.csv", "a.csv.gz", "a.csv.zst"], &route),
                named(&["b.csv"], &places),
                named(&["a.vdri", "a.vdri.gz"], vdri),
                named(&["a.json", "a.json.gz"], &json),
                named(&["c.csv"], &tracks()),
                named(&["d.csv"], STOP_PLAN),
                vec![("a.parquet", parquet_log())],
            ]
            .concat()
        },
        |path| {
            let options = RouteOptions { draw: &Draw::ALL, ..RouteOptions::default() };
            given_cycle::read_route(path, options).is_ok()
        },
    ),
    (
        "drive cycles",
        || {
            let cycle = table("time_s,speed_kmh,grade", 300, |row, k| log_cell(row, [0, 1, 6][k]));
            let names = ["a.csv", "a.csv.gz", "a.csv.zst"];
            [named(&names, &cycle), vec![("a.parquet", parquet_log())]].concat()
        },
        |path| drive_cycle::read(Source::File(path), &[]).is_ok(),
    ),
    (
        "logs",
        || {
            let text = table(LOG, 300, log_cell);
            let names = ["a.csv", "a.csv.gz", "a.csv.zst"];
            [named(&names, &text), vec![("a.parquet", parquet_log())]].concat()
        },
        |path| {
            let needs: [&[log::Need]; 2] = [&log::pedals::NEEDS, &log::roads::NEEDS];
            let read = |needs: &&[log::Need]| log::read(Source::File(path), &[], needs).is_ok();
            needs.iter().filter(|needs| read(needs)).count() > 0
        },
    ),
    (
        "tracks",
        || {
            let place = |k: usize| (52.0 + 1e-4 * k as f64, 9.0, 50.0 + (k % 9) as f64);
            let stamp = |k: usize| format!("2024-03-04T06:{:02}:{:02}Z", k / 60, k % 60);
            let points = (0..120).map(|k| {
                let (lat, lon, ele) = place(k);
                format!(
                    "<trkpt lat=\"{lat}\" lon=\"{lon}\"><ele>{ele}</ele><time>{}</time></trkpt>",
                    stamp(k)
                )
            });
            let points: String = points.collect();
            let gpx = format!("<gpx><trk><name>a</name><trkseg>{points}</trkseg></trk></gpx>");
            let coords = (0..120).map(|k| {
                let (lat, lon, ele) = place(k);
                format!("<when>{}</when><gx:coord>{lon} {lat} {ele}</gx:coord>", stamp(k))
            });
            let coords: String = coords.collect();
            let kml = format!("<kml><Placemark><gx:Track>{coords}</gx:Track></Placemark></kml>");
            let line: Vec<_> = (0..120).map(|k| [place(k).1, place(k).0, place(k).2]).collect();
            let times: Vec<String> = (0..120).map(stamp).collect();
            let line = serde_json::json!({"type": "FeatureCollection", "features": [{
                "type": "Feature", "properties": {"name": "a", "coordTimes": times},
                "geometry": {"type": "LineString", "coordinates": line}}]});
            let status = |k: usize| {
                serde_json::json!({"vin": "A", "createdDateTime": stamp(k),
                    "triggerType": {"triggerType": "TIMER"}, "hrTotalVehicleDistance": 20 * k,
                    "engineTotalFuelUsed": 9 * k, "snapshotData": {"wheelBasedSpeed": 72.0,
                    "gnssPosition": {"latitude": place(k).0, "longitude": place(k).1}}})
            };
            let statuses: Vec<_> = (0..120).map(status).collect();
            let rfms = serde_json::json!({"vehicleStatusResponse": {"vehicleStatuses": statuses}});
            [
                named(&["a.gpx", "a.gpx.gz"], &gpx),
                named(&["a.kml"], &kml),
                named(&["a.geojson", "b.geojson.zst"], &line.to_string()),
                named(&["a.json"], &rfms.to_string()),
            ]
            .concat()
        },
        read_track,
    ),
    ("workbooks", || vec![("a.xlsx", workbook()), ("b.xlsx", workbook())], read_track),
    (
        "weather",
        || {
            let names =
                "time_s,temperature_c,pressure_hpa,relative_humidity_percent,wind_speed_mps";
            let text =
                table(names, 200, |row, k| [3600.0 * row as f64, 10.0, 1010.0, 75.0, 4.0][k]);
            let mut seeds = named(&["a.csv", "a.csv.gz"], &text);
            // dates in two columns, and a file of EnergyPlus
            let rows = (0..200).map(|k| format!("{:02}.01.2024,{:02}:00,5\n", 1 + k / 24, k % 24));
            let dated = format!("Datum,Uhrzeit,temperature_c\n{}", rows.collect::<String>());
            seeds.extend(named(&["b.csv"], &dated));
            let cells = ",0,?,-5,0,80,101000".to_owned() + &",0".repeat(25);
            let rows = (0..48).map(|k| format!("2001,1,{},{}{cells}\n", 1 + k / 24, 1 + k % 24));
            let heading = "LOCATION,x\nDESIGN CONDITIONS\n".to_owned() + &"y\n".repeat(6);
            seeds.extend(named(&["c.epw"], &(heading + &rows.collect::<String>())));
            let rows = (0..48).map(|k| {
                format!("44;202401{:02}{:02};10;   4.{};180;eor\n", 1 + k / 24, k % 24, k % 10)
            });
            let names = "STATIONS_ID;MESS_DATUM;QN_3;   F;   D;eor\n".to_owned();
            seeds.extend(named(&["d.txt"], &(names + &rows.collect::<String>())));
            seeds
        },
        |path| weather_table::read(&[Source::File(path)], &[], None).is_ok(),
    ),
    (
        "traffic",
        || {
            let rows = (0..200).map(|k| format!("{},rural,0.1{k}\n", 900 * k));
            let text = format!("time_s,road_type,density_share\n{}", rows.collect::<String>());
            named(&["a.csv", "a.csv.zst"], &text)
        },
        |path| {
            let model: TrafficModel = study::load("field-truck", NO_SETS).unwrap().model.traffic;
            traffic_table::read(Source::File(path), &[], &model, None).is_ok()
        },
    ),
    (
        "records of a fleet",
        || {
            let rows = (0..60).map(|k| format!("t{},{},{},{}\n", k % 6, 30 + k % 5, 20 + k, 9 * k));
            let names = "truck_id,consumption_l_per_100km,distance_km,departure_s_of_year";
            named(&["a.csv", "a.csv.gz"], &format!("{names}\n{}", rows.collect::<String>()))
        },
        |path| {
            let column = "consumption_l_per_100km";
            fleet_table::read(Source::File(path), &[], column, Some("distance_km"), true).is_ok()
        },
    ),
    (
        "trips and fills",
        || {
            let rows =
                (0..60).map(|k| format!("t{},{},{},{}\n", k % 6, 90 + k, 30 + k % 7, 20 + k));
            let trips = format!("truck,km,litres,gross_weight_t\n{}", rows.collect::<String>());
            let rows = (0..60).map(|k| format!("t{},{},{},{}\n", k % 6, 900 * k, 200 + k, k % 2));
            let fills = format!("truck,odometer_km,litres,full\n{}", rows.collect::<String>());
            [named(&["a.csv", "a.csv.gz"], &trips), named(&["b.csv"], &fills)].concat()
        },
        |path| trip_totals::read(Source::File(path), &[]).is_ok(),
    ),
    (
        "curves",
        || {
            let rows = (0..100).map(|k| format!("d{},{},left,{}\n", k % 5, 30 + k, 8 + k % 9));
            let text = format!("driver,radius_m,direction,speed_mps\n{}", rows.collect::<String>());
            named(&["a.csv", "a.csv.gz"], &text)
        },
        |path| curve_table::read(Source::File(path), &[]).is_ok(),
    ),
    (
        "speed changes",
        || {
            let rows = (0..60).map(|k| format!("d{},70-to-40,-0.{k}\n", k % 5));
            let text = format!("driver,category,acceleration_mps2\n{}", rows.collect::<String>());
            let log = table(LOG, 300, log_cell);
            [named(&["a.csv"], &text), named(&["b.csv", "b.csv.gz"], &log)].concat()
        },
        |path| {
            let (mut table, options) = (SpeedChangeTable::default(), SpeedChangeOptions::default());
            speed_change_table::append(&mut table, Source::File(path), &[], &options).is_ok()
        },
    ),
    (
        "records",
        || {
            let folder = tempfile::tempdir().unwrap();
            RecordFormat::ALL
                .map(|format| {
                    let out = folder.path().join(format.name());
                    run(&out, format, true);
                    (format.file_name(), fs::read(out.join(format.file_name())).unwrap())
                })
                .to_vec()
        },
        |path| records::read(path, |_| ()).is_ok(),
    ),
    ("whole run directories", || seeds_of_run(true), |path| read_run(path)),
    ("unfinished run directories", || seeds_of_run(false), |path| read_run(path)),
];

/// Reads a track in every way.
fn read_track(path: &Path) -> bool {
    let as_log = log::read(Source::File(path), &[], &log::roads::NEEDS)
        .map_err(|e| eprintln!("{e}"))
        .is_ok();
    let as_route = given_cycle::read(path, &[]).is_ok();
    let as_cycle = drive_cycle::read(Source::File(path), &[]).is_ok();
    as_log || as_route || as_cycle
}

/// A workbook with a sheet of a log.
fn workbook() -> Vec<u8> {
    let cell =
        |at: &str, text: &str| format!("<c r=\"{at}\" t=\"inlineStr\"><is><t>{text}</t></is></c>");
    let mut rows =
        format!("<row r=\"1\">{}{}</row>", cell("A1", "time_s"), cell("B1", "speed_kmh"));
    for k in 2..200 {
        let number =
            |column: &str, value: usize| format!("<c r=\"{column}{k}\"><v>{value}</v></c>");
        let cells = number("A", k - 2) + &number("B", 50 + k % 7);
        write!(rows, "<row r=\"{k}\">{cells}</row>").unwrap();
    }
    let space = "http://schemas.openxmlformats.org/";
    let relation = |kind: &str, target: &str| {
        format!(
            "<Relationships xmlns=\"{space}package/2006/relationships\"><Relationship Id=\"rId1\" \
             Type=\"{space}officeDocument/2006/relationships/{kind}\" Target=\"{target}\"/>\
             </Relationships>"
        )
    };
    let parts = [
        (
            "xl/workbook.xml",
            format!(
                "<workbook xmlns=\"{space}spreadsheetml/2006/main\" \
                 xmlns:r=\"{space}officeDocument/\
                 2006/relationships\"><sheets><sheet name=\"log\" sheetId=\"1\" \
                 r:id=\"rId1\"/></sheets>\
                 </workbook>"
            ),
        ),
        ("_rels/.rels", relation("officeDocument", "xl/workbook.xml")),
        ("xl/_rels/workbook.xml.rels", relation("worksheet", "worksheets/sheet1.xml")),
        (
            "xl/worksheets/sheet1.xml",
            format!(
                "<worksheet xmlns=\"{space}spreadsheetml/2006/main\"><sheetData>{rows}</sheetData>\
                 </worksheet>"
            ),
        ),
    ];
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, text) in parts {
        archive.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        archive.write_all(text.as_bytes()).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// The files of run directories in both formats; the name says which file is changed.
fn seeds_of_run(is_whole: bool) -> Seeds {
    let files: &[&'static str] = if is_whole {
        &[
            "csv/manifest.json",
            "csv/summary.json",
            "csv/checksums.sha256",
            "csv/records.csv",
            "parquet/manifest.json",
            "parquet/records.parquet",
        ]
    } else {
        &[
            "csv/manifest.json",
            "csv/checksums.sha256",
            "csv/chunks/00000000.csv",
            "parquet/manifest.json",
            "parquet/chunks/00000000.parquet",
        ]
    };
    let folder = tempfile::tempdir().unwrap();
    for format in RecordFormat::ALL {
        run(&folder.path().join(format.name()), format, is_whole);
    }
    files.iter().map(|name| (*name, fs::read(folder.path().join(name)).unwrap())).collect()
}

/// Reads a run directory in every way; `path` is the file in it that was changed.
fn read_run(path: &Path) -> bool {
    let above = path.parent().unwrap();
    let directory = if above.ends_with("chunks") { above.parent().unwrap() } else { above };
    let _ = run_directory::verify(directory);
    let _ = run_directory::unfinished(directory, &Files::here());
    run_directory::read(directory).is_ok()
}

/// Where the file of a seed is put, and everything beside it that its reader needs.
fn place(folder: &Path, reader: &str, name: &str) -> PathBuf {
    if reader.contains("run directories") {
        for format in RecordFormat::ALL {
            let directory = folder.join(format.name());
            if !directory.exists() {
                run(&directory, format, reader.starts_with("whole"));
            }
        }
    }
    folder.join(name)
}

/// The process that reads, a part of the next test: `OCMC_FUZZ_CHILD` is the reader, the first
/// input and how many. Without it there is nothing to read.
#[test]
fn child() {
    let Ok(asked) = std::env::var("OCMC_FUZZ_CHILD") else { return };
    let numbers: Vec<u64> = asked.split(':').map(|number| number.parse().unwrap()).collect();
    let (name, seeds, read) = READERS[numbers[0] as usize];
    let seeds = seeds();
    let folder = PathBuf::from(std::env::var("OCMC_FUZZ_FOLDER").unwrap());
    let (mut slowest, mut understood) = (Duration::ZERO, 0);
    for input in numbers[1]..numbers[1] + numbers[2] {
        let mut numbers = Numbers(input.wrapping_mul(0x0123_4567_89ab_cdef) ^ name.len() as u64);
        let (file, seed) = &seeds[numbers.below(seeds.len())];
        let path = place(&folder, name, file);
        let good = fs::read(&path).ok();
        // of what is compressed sometimes the text is changed, and sometimes the file
        let bytes = match zstd_or_gzip(file, seed) {
            Some(text) if numbers.below(2) == 0 => pack(file, &changed(&text, &mut numbers)),
            _ => changed(seed, &mut numbers),
        };
        fs::write(&path, &bytes).unwrap();
        let begun = Instant::now();
        let read = std::panic::catch_unwind(|| read(&path));
        let took = begun.elapsed();
        let read = read.unwrap_or_else(|_| panic!("{name}, input {input}: a panic"));
        assert!(took < LONGEST, "{name}, input {input}: {took:?}");
        slowest = slowest.max(took);
        understood += u64::from(read);
        match good {
            Some(good) => fs::write(&path, good).unwrap(),
            None => fs::remove_file(&path).unwrap(),
        }
    }
    println!("READ {understood} of {} in at most {} ms", numbers[2], slowest.as_millis());
}

fn zstd_or_gzip(name: &str, bytes: &[u8]) -> Option<Vec<u8>> {
    if is_packed(name, "zst") {
        return zstd::decode_all(bytes).ok();
    }
    let mut text = Vec::new();
    let mut reader = flate2::read::GzDecoder::new(bytes);
    let read = is_packed(name, "gz").then(|| std::io::copy(&mut reader, &mut text));
    read.and_then(Result::ok).map(|_| text)
}

fn pack(name: &str, text: &[u8]) -> Vec<u8> {
    if is_packed(name, "zst") { zstd::encode_all(text, 1).unwrap() } else { gzip(text) }
}

#[test]
fn no_reader_aborts_or_hangs_with_a_gigabyte() {
    let inputs = std::env::var("OCMC_FUZZ_INPUTS").map_or(200, |inputs| inputs.parse().unwrap());
    let program = std::env::current_exe().unwrap();
    for (k, (name, seeds, _)) in READERS.iter().enumerate() {
        assert!(!seeds().is_empty(), "{name}");
        let mut said = String::new();
        for first in (0..inputs).step_by(BATCH as usize) {
            let folder = tempfile::tempdir().unwrap();
            let count = BATCH.min(inputs - first);
            let output = Command::new("timeout")
                .args(["900", "sh", "-c", &format!("ulimit -v {MOST_KIB}; exec \"$@\""), "sh"])
                .arg(&program)
                .args(["--exact", "fuzzed_readers::child", "--nocapture"])
                .args(["--test-threads", "1"])
                .env("OCMC_FUZZ_CHILD", format!("{k}:{first}:{count}"))
                .env("OCMC_FUZZ_FOLDER", folder.path())
                .output()
                .unwrap();
            let text = String::from_utf8_lossy(&output.stdout);
            let error = String::from_utf8_lossy(&output.stderr);
            let end: String =
                error.chars().rev().take(2000).collect::<Vec<_>>().into_iter().rev().collect();
            assert!(
                output.status.success(),
                "{name}, inputs from {first}: {} {end}",
                output.status
            );
            said.extend(text.lines().filter_map(|line| line.split_once("READ ")).map(|l| l.1));
            said.push_str("; ");
        }
        println!("{name}: {said}");
    }
}

#[test]
fn every_seed_is_read() {
    for (name, seeds, read) in READERS {
        let folder = tempfile::tempdir().unwrap();
        for (file, seed) in seeds() {
            let path = place(folder.path(), name, file);
            fs::write(&path, &seed).unwrap();
            // a log is no route, and a run that is under way is not read as a whole
            let other = file == "a.parquet" && name == "routes";
            let is_whole = !name.starts_with("unfinished");
            assert_eq!(read(&path), is_whole && !other, "{name}: {file}");
        }
    }
}

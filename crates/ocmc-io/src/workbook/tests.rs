use super::*;
use crate::given_drive::GivenDrive;
use crate::records::{RecordFormat, arrow::record_batch, examples};
use crate::run_directory::{RunDirectory, RunStatus};
use crate::study;
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, UInt64Type};
use arrow_array::{Array, ArrayRef};
use calamine::{Data, DataType, Range, Reader, Xlsx, open_workbook_from_rs};
use ocmc_core::record::{Outcome, Record};
use ocmc_fleet::dependence::Dependence;
use ocmc_fleet::run::RunPlan;
use ocmc_fleet::summary::SummaryBuilder;
use std::collections::BTreeSet;
use std::io::{Cursor, Read};

/// A run whose study is called so, of these records, where a truck makes so many trips.
fn run(name: &str, records: &[Record], trips_per_truck: u64) -> (Manifest, RunSummary) {
    let loaded = study::load("field-truck", &["mission.length_m=2000"]).expect("built in");
    let plan = RunPlan::new(u64::MAX, 0, records.len() as u64, Some(2), None);
    let mut manifest = Manifest::new(&loaded, &plan, &GivenDrive::nothing());
    name.clone_into(&mut manifest.study);
    manifest.status = RunStatus::Complete;
    manifest.completed = records.len() as u64;
    let dependence = Dependence { trips_per_truck, ..Dependence::default() };
    let mut fleet = SummaryBuilder::new(dependence);
    fleet.add(records);
    let summary = RunSummary::new(&manifest, fleet.finish(), 1.0, 2);
    (manifest, summary)
}

/// Bytes of the workbook of a run.
fn bytes(run: &(Manifest, RunSummary), records: &[Record]) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a directory");
    let file = folder.path().join("a.xlsx");
    let batches: Vec<RecordBatch> = records.chunks(7).map(record_batch).collect();
    write((&run.0, &run.1), &batches, &file).expect("space");
    assert_eq!(fs::read_dir(folder.path()).expect("there").count(), 1, "nothing beside it");
    fs::read(&file).expect("written")
}

fn sheet(bytes: &[u8], name: &str) -> Range<Data> {
    let mut book: Xlsx<_> = open_workbook_from_rs(Cursor::new(bytes)).expect("a workbook");
    book.worksheet_range(name).expect("a sheet")
}

fn sheet_names(bytes: &[u8]) -> Vec<String> {
    let book: Xlsx<_> = open_workbook_from_rs(Cursor::new(bytes)).expect("a workbook");
    book.sheet_names()
}

/// The cell of a table as a spreadsheet has to show it.
fn expected(column: &ArrayRef, row: usize) -> Data {
    if column.is_null(row) {
        return Data::Empty;
    }
    if let Some(numbers) = column.as_primitive_opt::<Float64Type>() {
        return Data::Float(numbers.value(row));
    }
    match column.as_primitive_opt::<UInt64Type>() {
        Some(numbers) => Data::Float(numbers.value(row) as f64),
        None => Data::String(column.as_string::<i32>().value(row).to_owned()),
    }
}

/// Checks that a sheet has exactly what a table has.
fn assert_same(sheet: &Range<Data>, table: &RecordBatch) {
    assert_eq!(sheet.get_size().0, 1 + table.num_rows());
    for (k, field) in table.schema().fields().iter().enumerate() {
        let k32 = k as u32;
        assert_eq!(sheet.get_value((0, k32)), Some(&Data::String(field.name().clone())));
        for row in 0..table.num_rows() {
            let cell = sheet.get_value((row as u32 + 1, k32)).unwrap_or(&Data::Empty);
            assert_eq!(*cell, expected(table.column(k), row), "row {row}, {}", field.name());
        }
    }
}

#[test]
fn every_value_of_the_records_is_in_its_cell() {
    // the first one of a group without chargings, numbers of all sizes, missing ones
    for records in [examples::records(40), examples::charged(40), Vec::new()] {
        let run = run("my fleet", &records, 1);
        let bytes = bytes(&run, &records);
        assert_same(&sheet(&bytes, RECORDS), &record_batch(&records));
        assert_eq!(sheet_names(&bytes), [ANSWER, RECORDS, STUDY]);
    }
}

#[test]
fn numbers_that_are_none_are_empty_cells() {
    let mut records = examples::records(3);
    (records[0].duration_s, records[1].duration_s) = (f64::NAN, f64::INFINITY);
    let bytes = bytes(&run("my fleet", &records, 1), &records);
    let sheet = sheet(&bytes, RECORDS);
    let column = (0..200).find(|k| sheet.get_value((0, *k)) == Some(&"duration_s".into()));
    let column = column.expect("a column");
    let cells: Vec<_> = (1..4).map(|row| sheet.get_value((row, column)).cloned()).collect();
    assert_eq!(cells[..2], [Some(Data::Empty), Some(Data::Empty)]);
    assert!(matches!(cells[2], Some(Data::Float(_))), "{cells:?}");
}

#[test]
fn the_answer_has_each_quantity_and_what_the_run_is() {
    let mut records = examples::records(60);
    for record in &mut records {
        record.outcome = Outcome::Completed;
        (record.mean_speed_mps, record.duration_s) = (20.0, 3600.0);
    }
    records[3].outcome = Outcome::Stalled;
    let run = run("=HYPERLINK(\"x\") & <b>\u{1}", &records, 1);
    let bytes = bytes(&run, &records);
    let sheet = sheet(&bytes, ANSWER);
    let row = |name: &str| {
        let mut rows = sheet.rows();
        rows.find(|row| row[0].as_string().as_deref() == Some(name)).expect("a row").to_owned()
    };
    let head = sheet.rows().next().expect("a header");
    assert!(["P5", "P50", "P99"].into_iter().all(|name| head.contains(&name.into())));
    let speed = row("speed");
    let mean = run.1.summary.statistic("mean_speed_mps").and_then(|statistic| statistic.mean);
    assert_eq!(speed[1], Data::from("km/h"));
    assert_eq!(Some(speed[2].clone()), mean.map(|mean| Data::Float(3.6 * mean)));
    assert_eq!(row("duration")[1..3], [Data::from("h"), Data::Float(1.0)]);
    // what looks like a formula is a text, and letters that XML lacks are spelled out
    assert_eq!(row("study")[2], Data::from("=HYPERLINK(\"x\") & <b>\u{1}"));
    // a number of more digits than a spreadsheet has
    assert_eq!(row("seed")[2], Data::from(u64::MAX.to_string().as_str()));
    assert_eq!(row("cycles that are stalled")[2], Data::Float(1.0));
    assert_eq!(row("cycles that are completed")[2], Data::Float(59.0));
    let judged = row("judged numbers: the mean of the consumption ±");
    assert!(judged[1] != Data::Empty, "{judged:?}");
    let mut archive = zip::ZipArchive::new(Cursor::new(&bytes)).expect("an archive");
    for k in 0..archive.len() {
        let mut text = String::new();
        archive.by_index(k).expect("a part").read_to_string(&mut text).expect("text");
        assert!(!text.contains("<f>") && !text.contains("<f "), "no formula");
    }
}

#[test]
fn routes_and_trucks_have_sheets_of_their_own() {
    let mut records = examples::records(40);
    for (k, record) in records.iter_mut().enumerate() {
        record.outcome = Outcome::Completed;
        record.route_id = Some(k as u32 % 2);
    }
    let mut run = run("my fleet", &records, 4);
    for (route, file) in run.1.summary.routes.iter_mut().zip(["a/=one.csv", "b/two.csv"]) {
        route.file = Some(file.to_owned());
    }
    let bytes = bytes(&run, &records);
    assert_eq!(sheet_names(&bytes), SHEETS);
    let trucks = run.1.summary.trucks.as_ref().expect("trucks");
    assert_eq!(trucks.rows.len(), 10);
    assert_same(&sheet(&bytes, TRUCKS), &trucks::record_batch(&trucks.rows));
    let routes = sheet(&bytes, ROUTES);
    let named: BTreeSet<(String, String)> =
        routes.rows().skip(1).map(|row| (row[1].to_string(), row[2].to_string())).collect();
    let pair = |name: &str, file: &str| (name.to_owned(), file.to_owned());
    let both = [pair("=one.csv", "a/=one.csv"), pair("two.csv", "b/two.csv")];
    assert_eq!(named, both.into());
    for row in routes.rows().skip(1) {
        let id = row[0].get_float().expect("a number") as usize;
        let name = row.last().map(ToString::to_string).expect("a cell");
        let statistic = run.1.summary.routes[id].statistic(&name).expect("a quantity");
        let (words, unit, factor) = crate::label::measured(&name);
        assert_eq!(row[4..6], [Data::String(words), Data::from(unit)]);
        assert_eq!(row[6].get_float(), statistic.mean.map(|mean| factor * mean), "{name}");
    }
}

#[test]
fn the_study_stands_key_by_key() {
    let records = examples::records(2);
    let bytes = bytes(&run("my fleet", &records, 1), &records);
    let sheet = sheet(&bytes, STUDY);
    let row = |key: &str| {
        let mut rows = sheet.rows();
        rows.find(|row| row[0].as_string().as_deref() == Some(key)).expect("a key").to_owned()
    };
    assert_eq!(row("mission.length_m")[1], Data::Float(2000.0));
    assert!(
        row("mission.length_m")[2].to_string().contains(", in m"),
        "{:?}",
        row("mission.length_m")
    );
    assert!(row("mission.payload_kg")[1].to_string().starts_with("{ distribution = "));
}

#[test]
fn the_same_run_gives_the_same_bytes_whenever_it_ended_and_wherever_it_lies() {
    let mut records = examples::records(30);
    for record in &mut records {
        // as what is read back has to be: consecutive ids
        record.outcome = Outcome::Completed;
    }
    let loaded = study::load("field-truck", &["mission.length_m=2000"]).expect("built in");
    let plan = RunPlan::new(1, 0, 30, Some(2), None);
    let manifest = Manifest::new(&loaded, &plan, &GivenDrive::nothing());
    let mut fleet = SummaryBuilder::new(manifest.dependence());
    fleet.add(&records);
    let summary = RunSummary::new(&manifest, fleet.finish(), 1.0, 2);
    let folder = tempfile::tempdir().expect("a directory");
    let mut all = Vec::new();
    for (k, format) in RecordFormat::ALL.into_iter().enumerate() {
        let directory = folder.path().join(format.name());
        let mut stored = RunDirectory::create(&directory, format, manifest.clone()).expect("space");
        stored.add(&records).expect("space");
        let mut summary = summary.clone();
        (summary.wall_s, summary.ended_at) = (k as f64, format!("then {k}"));
        let manifest = stored.finish(&summary).expect("space");
        all.push(bytes(&(manifest, summary), &records));
        let file = directory.join(WORKBOOK);
        fs::write(&file, "an older one").expect("space");
        write_stored(&directory, &file).expect("a run");
        all.push(fs::read(&file).expect("written"));
        // and it does not stand in the way of reading the run
        write_stored(&directory, &folder.path().join("again.xlsx")).expect("a run");
    }
    assert!(all.windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn what_no_sheet_holds_is_refused_before_anything_is_written() {
    let records = examples::charged(5);
    let (manifest, mut summary) = run("my fleet", &records, 1);
    let folder = tempfile::tempdir().expect("a directory");
    let file = folder.path().join("a.xlsx");
    summary.summary.cycles = MOST_RECORDS + 1;
    let refused = |summary: &RunSummary, batch: RecordBatch| {
        let error = write((&manifest, summary), [&batch], &file).expect_err("too much");
        assert_eq!(fs::read_dir(folder.path()).expect("there").count(), 0);
        error.to_string()
    };
    let error = refused(&summary, record_batch(&records));
    assert!(error.contains("at most 1048575 records") && error.contains("has 1048576"), "{error}");
    assert!(error.contains("--format csv"), "{error}");
    assert!(check_cycles(MOST_RECORDS).is_ok());

    summary.summary.cycles = 5;
    let mut records = records;
    let events = records[2].charging_events.as_mut().expect("charged");
    *events = vec![events[0].clone(); 200];
    let error = refused(&summary, record_batch(&records));
    assert!(error.contains("cycle 2: `charging_events` has "), "{error}");
}

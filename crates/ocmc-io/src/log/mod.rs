//! Measured logs: columns found by name and unit, rows split into drives.

mod account;
mod completion;
pub mod curves;
pub mod driven;
pub mod identification;
mod motion;
mod noise;
pub mod pedals;
pub mod roads;
pub mod totals;
mod trip_end;

pub(crate) use account::{counted, row_notes};

use crate::intake::drift::{standing_speed, standing_speeds};
use crate::intake::table::clock::{LogClock, dated};
use crate::intake::table::error::Fault;
use crate::intake::table::formats::LOG;
use crate::intake::table::given::{GivenTable, RowPlace};
use crate::intake::table::{self, Column, Mapping, Quantity, Source, Style, Table, TableError};
use crate::intake::values::Watched;
use crate::intake::{FileAccount, Finding};
use crate::sha256;
use arrow_array::Float64Array;
use completion::Completion;
use ocmc_core::operating_cycle::road::route_geometry::Path2d;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Quantities that tell rows of different drives apart.
const LABELS: [Quantity; 4] = [Quantity::Truck, Quantity::Driver, Quantity::Drive, Quantity::Event];

/// Quantities that tell a date.
const CALENDAR: [Quantity; 2] = [Quantity::Date, Quantity::Day];

/// Digits of a fingerprint.
const FINGERPRINT: usize = 16;

/// Rows after which a log is not read on whose time mostly stands still.
const LOOKED_AT: usize = 100_000;
/// Rows of these that may repeat the time of the row before them or go back, in %.
const MOST_STILL: usize = 99;

/// Need of a command in a log: one of these quantities.
pub type Need = &'static [Quantity];

/// The rows of one drive (and event).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoggedTrip {
    /// The driver, or the truck: the label, or the name of the file.
    pub driver: String,
    /// The truck, where there is a label.
    pub truck: Option<String>,
    /// The drive: the label, or the name of the file.
    pub drive: String,
    /// The event, where there is a label.
    pub event: Option<String>,
    /// Values in SI, NaN where missing.
    columns: BTreeMap<Quantity, Float64Array>,
    /// Words of each row.
    words: BTreeMap<Quantity, Words>,
    /// Median time between the rows that were measured, in s, where others were put in.
    measured_each_s: Option<f64>,
}

impl LoggedTrip {
    /// Trip of columns in SI.
    pub fn new<const N: usize>(
        driver: &str,
        drive: &str,
        columns: [(Quantity, Vec<f64>); N],
    ) -> Self {
        let (driver, drive) = (driver.to_owned(), drive.to_owned());
        let columns = columns.into_iter().map(|(quantity, values)| (quantity, values.into()));
        Self { driver, drive, columns: columns.collect(), ..Self::default() }
    }

    /// The words of a column.
    pub fn words(&self, word: Quantity) -> Option<&Words> {
        self.words.get(&word)
    }

    /// The values of a quantity.
    pub fn column(&self, quantity: Quantity) -> Option<&[f64]> {
        self.columns.get(&quantity).map(|column| column.values().as_ref())
    }

    /// The mean ambient temperature, in K, where there is one.
    pub fn ambient_k(&self) -> Option<f64> {
        let known = self.column(Quantity::AmbientTemperature)?.iter().filter(|k| k.is_finite());
        let count = known.clone().count();
        (count > 0).then(|| known.sum::<f64>() / count as f64)
    }

    /// Takes speeds of a receiver at standstill for 0, and says so.
    fn stand(&mut self) -> Vec<Finding> {
        let columns = self.column(Quantity::Time).zip(self.column(Quantity::Speed));
        let Some((time_s, speed_mps)) = columns else { return Vec::new() };
        let path = self.column(Quantity::Latitude).zip(self.column(Quantity::Longitude));
        let apart_m = |a: usize, b: usize| {
            path.map_or(f64::NAN, |(latitude, longitude)| {
                Path2d::new(&[latitude[a], latitude[b]], &[longitude[a], longitude[b]]).position_m
                    [1]
            })
        };
        let rows = standing_speeds(time_s, speed_mps, apart_m);
        let Some(finding) = standing_speed(&rows, speed_mps) else { return Vec::new() };
        let mut standing = speed_mps.to_vec();
        for rows in rows {
            standing[rows].fill(0.0);
        }
        self.columns.insert(Quantity::Speed, standing.into());
        vec![finding]
    }

    /// Makes the rate of the fuel from its counter, where that alone is there: the mean since the
    /// row with the count before.
    fn count_fuel(&mut self) {
        let column = |quantity| self.column(quantity);
        let (Some(time_s), Some(count_kg), None) =
            (column(Quantity::Time), column(Quantity::FuelUsed), column(Quantity::FuelRate))
        else {
            return;
        };
        let mut rate_kgps = vec![f64::NAN; time_s.len()];
        let mut before: Option<usize> = None;
        for row in (0..time_s.len()).filter(|row| count_kg[*row].is_finite()) {
            if let Some(before) = before {
                let rate = (count_kg[row] - count_kg[before]) / (time_s[row] - time_s[before]);
                // a counter that falls was set back, and tells nothing there
                let rate = if rate >= 0.0 { rate } else { f64::NAN };
                rate_kgps[before + 1..=row].fill(rate);
            }
            before = Some(row);
        }
        self.columns.insert(Quantity::FuelRate, rate_kgps.into());
    }

    /// A name for what was driven, whatever the file is called: of time and speed alone.
    pub fn fingerprint(&self) -> String {
        let columns = [Quantity::Time, Quantity::Speed];
        let values = columns.into_iter().filter_map(|quantity| self.column(quantity));
        let bytes: Vec<u8> = values.flatten().flat_map(|value| value.to_le_bytes()).collect();
        let digits = sha256::of_bytes(&bytes);
        format!("log-{}", &digits[..FINGERPRINT])
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.values().next().map_or(0, |column| column.values().len())
    }
}

/// Cells of a column that hold something else than a number.
#[derive(Clone, Debug, PartialEq)]
pub struct Unreadable {
    /// Name of the column.
    pub column: String,
    /// How many cells.
    pub cells: usize,
    /// Where the first one is.
    pub place: RowPlace,
    /// Text that stands there.
    pub text: String,
}

/// A log file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LogFile {
    /// Where it was read.
    pub path: PathBuf,
    /// The drives, in the order in which they begin.
    pub drives: Vec<LoggedTrip>,
    /// The columns that are understood, with their names.
    pub columns: Vec<(Column, String)>,
    /// Account of the file.
    pub read: FileAccount,
    /// Rows.
    pub rows: usize,
    /// Rows with too few or too many cells; what is there was used.
    pub ragged_rows: usize,
    /// Cells that are no numbers.
    pub unreadable: Vec<Unreadable>,
    /// Whether it has only some of the drives of the file.
    pub is_part: bool,
}

/// Reads a log. A column of a given table in SI units that [`GivenTable`] does not copy is not
/// copied here either, as long as the table holds a single drive and no infinite number.
///
/// # Errors
/// [`TableError`] where the file cannot be read, columns are missing or unclear, or there are no
/// rows.
pub fn read(source: Source, mappings: &[Mapping], needs: &[Need]) -> Result<LogFile, TableError> {
    read_in_parts(source, mappings, needs, usize::MAX, &mut |_| ())
}

/// As [`read`], of a log whose drives have labels and follow each other: drives that are complete
/// are given away as a part of the file, without an account, as soon as there are `most_rows` rows.
/// The rest of them is returned, with the account of all.
///
/// # Errors
/// As [`read`], and [`Fault::Mixed`] where a drive goes on that was given away.
pub fn read_in_parts(
    source: Source,
    mappings: &[Mapping],
    needs: &[Need],
    most_rows: usize,
    use_part: &mut dyn FnMut(LogFile),
) -> Result<LogFile, TableError> {
    let table = Table::open(source, &LOG, mappings)?;
    let by_date = table.column(Quantity::Time).is_none();
    let days = || table.column(Quantity::Date).or_else(|| table.column(Quantity::Day));
    let date = days().filter(|_| by_date);
    let is_implied = motion::is_implied(|quantity| table.column(quantity).is_some());
    for need in needs {
        let is_dated = date.is_some() && need.contains(&Quantity::Time);
        if !(is_dated || is_implied && need.contains(&Quantity::Speed)) {
            table.need_any(need[0].noun(), need)?;
        }
    }
    let named = table.columns().iter().map(|column| {
        let name = table.names()[column.place].clone();
        match column.quantity {
            Quantity::Date | Quantity::Day if date == Some(*column) => {
                (Column { quantity: Quantity::Time, ..*column }, name)
            }
            _ => (*column, name),
        }
    });
    let mut file = LogFile {
        path: source.path().to_owned(),
        drives: Vec::new(),
        columns: named.collect(),
        read: FileAccount::default(),
        rows: 0,
        ragged_rows: 0,
        unreadable: Vec::new(),
        is_part: false,
    };
    let labels = LABELS.map(|label| table.column(label));
    let (texts, mut numbers): (Vec<Column>, Vec<Column>) = table
        .columns()
        .iter()
        .filter(|column| !LABELS.contains(&column.quantity) && !CALENDAR.contains(&column.quantity))
        .partition(|column| column.quantity.is_text());
    // a date is a time since some midnight
    numbers.extend(date.map(|column| Column { quantity: Quantity::Time, ..column }));
    let mut clock = LogClock::default();
    let whole: Vec<Option<Float64Array>> = match table.given().filter(|t| is_one_drive(t, labels)) {
        Some(given) => numbers.iter().map(|column| table::unchanged(given, column)).collect(),
        None => vec![None; numbers.len()],
    };
    let mut drives = Trips::new(source.path());
    let is_labelled = labels[2].is_some();
    let mut completion = Completion::new(source.path(), is_labelled, Mapping::pause_s(mappings)?);
    let (mut is_part, may_part) = (false, is_labelled && table.given().is_none());
    let time = numbers.iter().position(|column| column.quantity == Quantity::Time);
    let mut still = 0;
    let mut account = table.for_each(|row| {
        file.rows += 1;
        file.ragged_rows += usize::from(row.is_ragged());
        let labels = LABELS.map(|label| row.text(label));
        if may_part && drives.rows >= most_rows && drives.is_new(labels) {
            is_part = true;
            let complete = drives.give_away().finish(&numbers, &whole);
            let (path, columns) = (file.path.clone(), file.columns.clone());
            let drives = completion.complete(complete, is_part)?;
            use_part(LogFile { path, drives, columns, is_part, ..LogFile::default() });
        }
        let drive = drives.place(labels, numbers.len());
        if drives.is_mixed {
            return Err(TableError::of(source.path(), Fault::Mixed));
        }
        for (k, column) in numbers.iter().enumerate().filter(|(k, _)| whole[*k].is_none()) {
            let read = if date.is_some() && column.quantity == Quantity::Time {
                clock.time_s(&dated(row))
            } else {
                row.logged(column)
            };
            let value = read.unwrap_or_else(|text| {
                let name = &file.columns.iter().find(|(known, _)| known.place == column.place);
                let name = name.map_or("", |(_, name)| name);
                count(&mut file.unreadable, name, text, row.place());
                f64::NAN
            });
            let values = &mut drives.values[drive][k];
            still +=
                usize::from(time == Some(k) && values.last().is_some_and(|last| value <= *last));
            values.push(value);
        }
        if file.rows == LOOKED_AT && still > LOOKED_AT * MOST_STILL / 100 {
            let fault = Fault::Still { still, rows: file.rows };
            return Err(TableError::of(source.path(), fault));
        }
        for column in &texts {
            let words = drives.logged[drive].words.entry(column.quantity).or_default();
            words.push(row.text(column.quantity));
        }
        Ok(())
    })?;
    account.findings.extend(clock.finding());
    account.findings.extend(judged_whole(&numbers, &whole, &file.columns));
    file.read = account;
    file.read.findings.extend(account::cells_left_out(&file));
    file.drives = completion.complete(drives.finish(&numbers, &whole), is_part)?;
    file.is_part = is_part;
    completion.finish(&mut file, needs)?;
    Ok(file)
}

/// Looks at the values of columns that are not read row by row.
fn judged_whole(
    numbers: &[Column],
    whole: &[Option<Float64Array>],
    names: &[(Column, String)],
) -> Vec<Finding> {
    let judged = numbers.iter().zip(whole).filter_map(|(column, whole)| {
        let mut watched = Watched::default();
        for (row, value) in whole.as_ref()?.values().iter().enumerate() {
            watched.look(RowPlace::Row(row as u64 + 1), column, *value, *value);
        }
        let name = names.iter().find(|(known, _)| known.place == column.place);
        watched.judge(name.map_or("", |(_, name)| name), column, Style::Log)
    });
    judged.collect()
}

/// Whether all rows of a given table have the same labels.
fn is_one_drive(table: &GivenTable, labels: [Option<Column>; 4]) -> bool {
    labels.into_iter().flatten().all(|column| {
        let words = table.words(column.place);
        words.is_ok_and(|words| {
            let first = words.iter().next().flatten();
            words.iter().all(|word| word == first)
        })
    })
}

/// Counts a cell that is no number.
fn count(unreadable: &mut Vec<Unreadable>, column: &str, text: String, place: RowPlace) {
    if let Some(cells) = unreadable.iter_mut().find(|cells| cells.column == column) {
        cells.cells += 1;
    } else {
        unreadable.push(Unreadable { column: column.to_owned(), cells: 1, place, text });
    }
}

/// Drives whose rows are being read.
struct Trips {
    /// Name that stands for a label that is not there.
    name: String,
    /// Places of the drives; none of those that were given away.
    known: BTreeMap<[String; 4], Option<usize>>,
    /// Rows of the drives that were not given away.
    rows: usize,
    /// Whether a drive went on that was given away.
    is_mixed: bool,
    /// Labels of the row before, and the place of their drive.
    last: Option<([String; 4], usize)>,
    logged: Vec<LoggedTrip>,
    /// Values of each drive, in the order of their columns.
    values: Vec<Vec<Vec<f64>>>,
}

impl Trips {
    /// No drives yet, of a file that lends them its name.
    fn new(path: &Path) -> Self {
        Self {
            name: stem(path),
            known: BTreeMap::new(),
            rows: 0,
            is_mixed: false,
            last: None,
            logged: Vec::new(),
            values: Vec::new(),
        }
    }

    /// Whether no row had these labels yet.
    fn is_new(&self, labels: [&str; 4]) -> bool {
        let is = |(last, _): &([String; 4], usize)| last.iter().zip(labels).all(|(a, b)| a == b);
        !self.last.as_ref().is_some_and(is) && !self.known.contains_key(&labels.map(str::to_owned))
    }

    /// All drives so far; they are not kept.
    fn give_away(&mut self) -> Self {
        self.known.values_mut().for_each(|place| *place = None);
        let empty = Self { name: self.name.clone(), ..Self::new(Path::new("")) };
        let known = std::mem::take(&mut self.known);
        let given = std::mem::replace(self, empty);
        self.known = known;
        given
    }

    /// Place of the drive with these labels (truck, driver, drive, event), which has so many
    /// columns.
    fn place(&mut self, labels: [&str; 4], columns: usize) -> usize {
        self.rows += 1;
        // labels hold for many rows
        match &self.last {
            Some((last, place)) if last.iter().zip(labels).all(|(last, label)| last == label) => {
                *place
            }
            _ => {
                let labels = labels.map(str::to_owned);
                let place = self.place_of(labels.clone(), columns);
                self.last = Some((labels, place));
                place
            }
        }
    }

    fn place_of(&mut self, labels: [String; 4], columns: usize) -> usize {
        let place = *self.known.entry(labels).or_insert_with_key(|labels| {
            let [truck, driver, drive, event] =
                labels.each_ref().map(|text| (!text.is_empty()).then(|| text.clone()));
            let name = || truck.clone().unwrap_or_else(|| self.name.clone());
            self.logged.push(LoggedTrip {
                driver: driver.unwrap_or_else(name),
                drive: drive.unwrap_or_else(name),
                truck,
                event,
                columns: BTreeMap::new(),
                words: BTreeMap::new(),
                measured_each_s: None,
            });
            // drives mostly follow each other: the one before is complete
            self.values.iter_mut().rev().take(1).flatten().for_each(Vec::shrink_to_fit);
            self.values.push(vec![Vec::new(); columns]);
            Some(self.logged.len() - 1)
        });
        self.is_mixed |= place.is_none();
        place.unwrap_or(0)
    }

    /// The drives with the values that were added, or with whole columns that stand for them.
    fn finish(self, columns: &[Column], whole: &[Option<Float64Array>]) -> Vec<LoggedTrip> {
        let mut drives = self.logged;
        for (drive, values) in drives.iter_mut().zip(self.values) {
            let arrays = values.into_iter().zip(whole);
            let arrays = arrays.map(|(mut values, whole)| {
                values.shrink_to_fit();
                whole.clone().unwrap_or_else(|| values.into())
            });
            drive.columns = columns.iter().map(|column| column.quantity).zip(arrays).collect();
        }
        drives
    }
}

/// The words of a column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Words {
    names: Vec<String>,
    of_row: Vec<u32>,
}

impl Words {
    /// Adds a row.
    fn push(&mut self, word: &str) {
        // a word holds for many rows: the last one is the likeliest
        let last = self.of_row.last().filter(|&&place| self.names[place as usize] == word);
        let place = last.copied().unwrap_or_else(|| {
            let known = self.names.iter().position(|name| name == word);
            known.unwrap_or_else(|| {
                self.names.push(word.to_owned());
                self.names.len() - 1
            }) as u32
        });
        self.of_row.push(place);
    }

    /// The word of each row, empty where there is none.
    pub fn rows(&self) -> impl Iterator<Item = &str> {
        self.of_row.iter().map(|&place| self.names[place as usize].as_str())
    }
}

/// The name of a file without its extensions.
pub fn stem(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let name = name.trim_end_matches(".gz").trim_end_matches(".zst");
    name.trim_end_matches(".parquet").trim_end_matches(".csv").to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use arrow_array::{Array, ArrayRef, StringArray};
    use std::sync::Arc;

    fn table(columns: &[(&str, ArrayRef)]) -> GivenTable {
        let (names, arrays): (Vec<_>, Vec<_>) =
            columns.iter().map(|(name, array)| ((*name).to_owned(), Arc::clone(array))).unzip();
        GivenTable::new("log", names, vec![arrays])
    }

    fn numbers(values: &[f64]) -> ArrayRef {
        Arc::new(Float64Array::from(values.to_vec()))
    }

    fn words(values: &[&str]) -> ArrayRef {
        Arc::new(StringArray::from(values.to_vec()))
    }

    #[test]
    fn si_columns_of_one_drive_are_not_copied() {
        let (time, speed) = (numbers(&[0.0, 1.0]), numbers(&[36.0, f64::NAN]));
        let table = table(&[("time_s", Arc::clone(&time)), ("speed_kmh", Arc::clone(&speed))]);
        let file = read(Source::Given(&table), &[], &[]).expect("a log");
        let column = |quantity| file.drives[0].column(quantity).expect("is there");
        let place = |array: &ArrayRef| array.to_data().buffers()[0].as_ptr();
        assert_eq!(column(Quantity::Time).as_ptr().cast(), place(&time));
        assert_ne!(column(Quantity::Speed).as_ptr().cast(), place(&speed), "another unit");
        assert_eq!(column(Quantity::Speed)[0], 10.0);
        assert!(column(Quantity::Speed)[1].is_nan());
    }

    #[test]
    fn a_table_is_read_as_the_same_file() {
        let text = "driver,event,time_s,speed_kmh\nx,,0,36\ny,up,0,inf\nx,,1,fast\ny,up,1,-\n";
        let columns = [
            ("driver", words(&["x", "y", "x", "y"])),
            ("event", words(&["", "up", "", "up"])),
            ("time_s", numbers(&[0.0, 0.0, 1.0, 1.0])),
            ("speed_kmh", words(&["36", "inf", "fast", "-"])),
        ];
        let by_table = read(Source::Given(&table(&columns)), &[], &[]).expect("a log");
        let by_text = read(Source::Text(Path::new("log"), text), &[], &[]).expect("a log");
        let shown = |drives: &[LoggedTrip]| format!("{drives:?}");
        assert_eq!(shown(&by_table.drives), shown(&by_text.drives));
        assert_eq!((by_table.rows, by_table.drives.len()), (4, 2));
        let unreadable = &by_table.unreadable[0];
        assert_eq!((unreadable.cells, unreadable.text.as_str()), (2, "inf"));
        assert_eq!(unreadable.place, RowPlace::Row(2));
        assert_eq!(by_text.unreadable[0].place, RowPlace::Line(3));
    }

    #[test]
    fn a_log_in_parts_has_the_same_drives_and_account() {
        let drive = |name: &str| -> String {
            let row = |k: usize| format!("{name},{k},{},0.01\n", 36 + k);
            (0..9).map(row).collect::<Vec<String>>().concat()
        };
        let header = "drive,time_s,speed_kmh,grade\n";
        let text = header.to_owned() + &["a", "b", "c", "d"].map(drive).concat();
        let source = |text| Source::Text(Path::new("log"), text);
        let whole = read(source(&text), &[], &[]).expect("a log");
        for most_rows in [1, 10, 18, 30] {
            let mut parts = Vec::new();
            let mut rest =
                read_in_parts(source(&text), &[], &[], most_rows, &mut |part| parts.push(part))
                    .expect("a log");
            assert!(parts.iter().all(|part| part.is_part && part.columns == whole.columns));
            let rows = |part: &LogFile| part.drives.iter().map(LoggedTrip::rows).sum::<usize>();
            assert!(parts.iter().all(|part| rows(part) < most_rows + 9), "{most_rows}");
            let given = parts.into_iter().flat_map(|part| part.drives);
            let drives: Vec<LoggedTrip> = given.chain(std::mem::take(&mut rest.drives)).collect();
            assert_eq!(format!("{drives:?}"), format!("{:?}", whole.drives));
            assert_eq!((rest.rows, &rest.read), (whole.rows, &whole.read));
        }
        let mixed = header.to_owned() + &["a", "b", "a"].map(drive).concat();
        let fault = read_in_parts(source(&mixed), &[], &[], 9, &mut |_| ()).expect_err("mixed");
        assert!(fault.is_mixed());
        assert_eq!(read(source(&mixed), &[], &[]).expect("a log").drives.len(), 2);
    }

    #[test]
    fn values_of_columns_that_are_not_copied_are_looked_at() {
        let speed = numbers(&[0.0, 90.0, 95.0, 80.0]);
        let table = table(&[("time_s", numbers(&[0.0, 1.0, 2.0, 3.0])), ("speed_mps", speed)]);
        let file = read(Source::Given(&table), &[], &[]).expect("a log");
        let finding = &file.read.findings[0];
        assert!(
            finding.check == "unusual-value" && finding.remedy.contains("speed_kmh"),
            "{finding}"
        );
    }

    #[test]
    fn what_is_wrong_is_said() {
        let error = |columns: &[(&str, ArrayRef)]| {
            read(Source::Given(&table(columns)), &[], &[]).expect_err("wrong").to_string()
        };
        assert!(error(&[]).contains("`log` is empty"));
        assert!(error(&[("time_s", numbers(&[]))]).contains("no rows"));
    }
}

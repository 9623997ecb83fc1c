//! Measured logs as CSV, plain or compressed with gzip, or as tables of a calling program: columns found by name and unit, rows
//! split into drives.

mod account;
pub mod curves;
mod drives;
pub mod error;
pub mod identification;
pub mod mapping;
pub mod pedals;
pub mod quantity;
pub mod roads;
mod table;
mod words;

use account::how_numbers_are_written;
pub(crate) use account::{counted, row_notes};
pub use table::read_table;
pub use words::Words;

use crate::given_table::RowPlace;
use crate::text_file::{decompressed, delimiter};
use arrow_array::Float64Array;
use drives::Trips;
use error::LogFileError;
use mapping::{Columns, Mapping};
use quantity::{Label, Quantity, Word};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// Most rows of a file: they are kept in memory.
const MOST_ROWS: usize = 100_000_000;
/// What stands for a missing number, beside an empty cell.
const MISSING: [&str; 6] = ["NA", "na", "N/A", "null", "None", "-"];

/// The rows of one drive (and event).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoggedTrip {
    /// The driver, or the truck: the label, or the name of the file.
    pub driver: String,
    /// The drive: the label, or the name of the file.
    pub drive: String,
    /// The event, where there is a label.
    pub event: Option<String>,
    /// Values in SI, NaN where missing.
    columns: BTreeMap<Quantity, Float64Array>,
    /// Words of each row.
    words: BTreeMap<Word, Words>,
}

impl LoggedTrip {
    /// The words of a column.
    pub fn words(&self, word: Word) -> Option<&Words> {
        self.words.get(&word)
    }

    /// The values of a quantity.
    pub fn column(&self, quantity: Quantity) -> Option<&[f64]> {
        self.columns.get(&quantity).map(|column| column.values().as_ref())
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
    /// What stands there.
    pub text: String,
}

/// A log file.
#[derive(Clone, Debug, PartialEq)]
pub struct LogFile {
    /// Where it was read.
    pub path: PathBuf,
    /// The drives, in the order in which they begin.
    pub drives: Vec<LoggedTrip>,
    /// Where each quantity stood.
    pub columns: Columns,
    /// Rows.
    pub rows: usize,
    /// Rows with too few or too many cells; what is there was used.
    pub ragged_rows: usize,
    /// Cells that are no numbers.
    pub unreadable: Vec<Unreadable>,
}

/// What a reader needs of a log: one of the quantities.
#[derive(Clone, Debug, PartialEq)]
pub struct Need<'a> {
    /// In words.
    pub what: &'a str,
    /// Any of these.
    pub any_of: &'a [Quantity],
}

/// Reads a log.
///
/// # Errors
/// [`LogFileError`] where the file cannot be read, columns are missing or unclear, or there are no rows.
pub fn read(path: &Path, mappings: &[Mapping], needs: &[Need]) -> Result<LogFile, LogFileError> {
    let failed = |source| LogFileError::Read { path: path.to_owned(), source };
    let file = File::open(path).map_err(failed)?;
    read_text(path, decompressed(file).map_err(failed)?, mappings, needs)
}

/// Reads the text of a log, which is called `path` in messages.
///
/// # Errors
/// As [`read`].
pub fn read_text(
    path: &Path,
    text: impl Read,
    mappings: &[Mapping],
    needs: &[Need],
) -> Result<LogFile, LogFileError> {
    let failed = |source| LogFileError::Read { path: path.to_owned(), source };
    let mut text = BufReader::new(text);
    let start = text.fill_buf().map_err(failed)?;
    if start.is_empty() {
        return Err(LogFileError::Empty { path: path.to_owned() });
    }
    let delimiter = delimiter(start);
    let mut reader =
        csv::ReaderBuilder::new().flexible(true).delimiter(delimiter).from_reader(text);
    let not_csv = |error: &csv::Error| match error.kind() {
        csv::ErrorKind::Utf8 { pos, .. } => {
            let line = pos.as_ref().map_or(1, csv::Position::line);
            LogFileError::NotUtf8 { path: path.to_owned(), place: format!("line {line}") }
        }
        _ => LogFileError::NotCsv { path: path.to_owned(), reason: error.to_string() },
    };
    let header: Vec<String> = reader
        .headers()
        .map_err(|error| not_csv(&error))?
        .iter()
        .map(|name| name.trim_start_matches('\u{feff}').trim().to_owned())
        .collect();
    let mut file = opened(path, &header, mappings, needs)?;
    let mut drives = Trips::new(path);
    let mut record = csv::StringRecord::new();
    loop {
        match reader.read_record(&mut record) {
            Ok(true) => {}
            Ok(false) => break,
            Err(error) => return Err(not_csv(&error)),
        }
        file.rows += 1;
        if file.rows > MOST_ROWS {
            return Err(LogFileError::TooManyRows { path: path.to_owned(), most: MOST_ROWS });
        }
        file.ragged_rows += usize::from(record.len() != header.len());
        let label = |label| {
            let index = file.columns.label(label)?;
            Some(record.get(index).unwrap_or("").trim().to_owned())
        };
        let labels = Label::ALL.map(|which| label(which).unwrap_or_default());
        let drive = drives.place(labels);
        for (k, column) in file.columns.quantities.iter().enumerate() {
            let cell = record.get(column.index).unwrap_or("");
            let place = RowPlace::Line(record.position().map_or(0, csv::Position::line));
            let value = number(&mut file.unreadable, &column.name, cell, place);
            drives.push(drive, k, column.factor * value);
        }
        for (word, index) in &file.columns.words {
            drives.push_word(drive, *word, record.get(*index).unwrap_or("").trim());
        }
    }
    file.drives = drives.finish(&file.columns.quantities);
    ended(file, needs)
}

/// A file with this header, whose rows have not been read.
fn opened(
    path: &Path,
    header: &[String],
    mappings: &[Mapping],
    needs: &[Need],
) -> Result<LogFile, LogFileError> {
    let columns = Columns::find(header, mappings).map_err(|source| LogFileError::Header {
        path: path.to_owned(),
        source: Box::new(source),
    })?;
    for need in needs {
        check_need(path, &columns, header, need)?;
    }
    Ok(LogFile {
        path: path.to_owned(),
        drives: Vec::new(),
        columns,
        rows: 0,
        ragged_rows: 0,
        unreadable: Vec::new(),
    })
}

/// The file, all of whose rows have been read.
fn ended(file: LogFile, needs: &[Need]) -> Result<LogFile, LogFileError> {
    if file.rows == 0 {
        return Err(LogFileError::NoRows { path: file.path });
    }
    for need in needs {
        check_numbers(&file, need)?;
    }
    Ok(file)
}

fn check_need(
    path: &Path,
    columns: &Columns,
    header: &[String],
    need: &Need,
) -> Result<(), LogFileError> {
    if need.any_of.iter().any(|quantity| columns.quantity(*quantity).is_some()) {
        return Ok(());
    }
    let wanted: Vec<String> = need.any_of.iter().flat_map(|quantity| quantity.names()).collect();
    let without_unit = header.iter().find(|name| lacks_unit(name, need));
    let hint = without_unit.map(|name| format!(" (`{name}` has no known unit)"));
    Err(LogFileError::Missing {
        path: path.to_owned(),
        what: format!("{}{}", need.what, hint.unwrap_or_default()),
        example: format!("{}={}", wanted[0], without_unit.map_or("COLUMN", String::as_str)),
        wanted: wanted.join(", "),
        found: header.join(", "),
    })
}

/// Whether a name is that of a needed quantity, but for its unit.
fn lacks_unit(name: &str, need: &Need) -> bool {
    let quantity =
        Quantity::with_wrong_unit(name).filter(|quantity| need.any_of.contains(quantity));
    // `speed_furlongs`, but not `speed_limit_sign`
    quantity.is_some_and(|quantity| {
        !name[quantity.name().len()..].trim_start_matches('_').contains('_')
    })
}

/// A column that is needed has a number somewhere.
fn check_numbers(file: &LogFile, need: &Need) -> Result<(), LogFileError> {
    let present = need.any_of.iter().filter_map(|quantity| file.columns.quantity(*quantity));
    let mut empty = None;
    for column in present {
        let values = file.drives.iter().filter_map(|drive| drive.column(column.quantity));
        if values.flatten().any(|value| !value.is_nan()) {
            return Ok(());
        }
        empty = Some(column);
    }
    let Some(column) = empty else { return Ok(()) };
    let example = file.unreadable.iter().find(|cells| cells.column == column.name);
    Err(LogFileError::NoNumbers {
        path: file.path.clone(),
        column: column.name.clone(),
        rows: file.rows,
        example: example.map_or_else(String::new, |cells| {
            let hint = how_numbers_are_written(&cells.column, &cells.text);
            format!(": {} has `{}`{hint}", cells.place, cells.text)
        }),
    })
}

/// The number in a cell, NaN where there is none. A cell with something else than a number or a usual sign for a missing one is
/// counted.
fn number(unreadable: &mut Vec<Unreadable>, column: &str, cell: &str, place: RowPlace) -> f64 {
    let cell = cell.trim();
    let number = cell.parse().unwrap_or(f64::NAN);
    if number.is_finite() {
        return number;
    }
    if cell.is_empty() || cell.eq_ignore_ascii_case("nan") || MISSING.contains(&cell) {
        return f64::NAN;
    }
    if let Some(cells) = unreadable.iter_mut().find(|cells| cells.column == column) {
        cells.cells += 1;
    } else {
        let text = cell.chars().take(40).collect();
        unreadable.push(Unreadable { column: column.to_owned(), cells: 1, place, text });
    }
    f64::NAN
}

//! Tables with named columns, read row by row: CSV files, of which only the columns that are wanted are kept, and tables of a
//! calling program. Cells stand between commas, semicolons or tabulators, and a file may be compressed by gzip.

use crate::ambiguous_columns::{AmbiguousColumns, the_only};
use crate::given_table::{Cells, ColumnTypeError, GivenTable, RowPlace};
use crate::text_file::{decompressed, delimiter};
use arrow_array::{Array, StringArray};
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Most rows of a table: each keeps its numbers in memory.
pub const MOST_ROWS: usize = 20_000_000;

/// Suffixes of names that are units, the longer ones first.
const UNITS: [&str; 28] = [
    "_mm_per_h",
    "_percent",
    "_mps2",
    "_mbar",
    "_inhg",
    "_mps",
    "_kmh",
    "_mph",
    "_fps",
    "_rad",
    "_deg",
    "_hpa",
    "_kpa",
    "_bar",
    "_min",
    "_kn",
    "_km",
    "_ft",
    "_mi",
    "_pa",
    "_ms",
    "_s",
    "_h",
    "_k",
    "_c",
    "_f",
    "_g",
    "_m",
];

/// Why a table cannot be read.
#[derive(Debug, Error)]
pub enum ColumnFileError {
    /// The file cannot be read.
    #[error("cannot read `{}`: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is not a table.
    #[error("`{}`: {message}", path.display())]
    Csv {
        /// The file.
        path: PathBuf,
        /// What is wrong and where.
        message: String,
    },
    /// No header.
    #[error("`{}` is empty; the first line has to name the columns", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// Only a header.
    #[error("`{}` has column names and no rows", path.display())]
    NoRows {
        /// The file.
        path: PathBuf,
    },
    /// A column of a known quantity in another unit.
    #[error(
        "`{}`: column `{column}` has a unit that is not read; allowed is `{}`: convert the numbers and rename the column",
        path.display(),
        allowed.join("` or `")
    )]
    Unit {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
        /// The names that are read.
        allowed: Vec<String>,
    },
    /// A column that is needed is not there.
    #[error(
        "`{}` has no column `{column}`; its columns are {}{}",
        path.display(),
        found.join(", "),
        nearest.as_ref().map_or(String::new(), |name| format!("; did you mean to name `{name}` so?"))
    )]
    MissingColumn {
        /// The file.
        path: PathBuf,
        /// The column, with what may stand in its place.
        column: String,
        /// Columns of the file.
        found: Vec<String>,
        /// The column with the most similar name.
        nearest: Option<String>,
    },
    /// A column that is there twice.
    #[error("`{}` has the column `{column}` twice", path.display())]
    TwiceColumn {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
    },
    /// Two columns for one quantity.
    #[error(transparent)]
    Ambiguous(#[from] AmbiguousColumns),
    /// A column of a type that no cell has.
    #[error(transparent)]
    Type(#[from] ColumnTypeError),
    /// A cell with something else than what its column holds.
    #[error("`{}`, {place}, column `{column}`: `{value}`; allowed is {allowed}", path.display())]
    Cell {
        /// The file.
        path: PathBuf,
        /// The row.
        place: RowPlace,
        /// The column.
        column: String,
        /// What is there.
        value: String,
        /// What may be there.
        allowed: &'static str,
    },
    /// More rows than are read.
    #[error("`{}` has more than {MOST_ROWS} rows; split it up", path.display())]
    TooLong {
        /// The file.
        path: PathBuf,
    },
}

/// A table whose header has been read.
pub struct ColumnFile<R = Box<dyn Read>> {
    path: PathBuf,
    names: Vec<String>,
    rows: Rows<R>,
}

/// Where the rows come from.
enum Rows<R> {
    Csv(csv::Reader<BufReader<R>>),
    /// With the columns that were asked for, by their places.
    Table(GivenTable, Vec<Option<Cells>>),
}

/// A column of numbers of a [`ColumnFile`].
#[derive(Clone, Copy, Debug)]
pub struct NumberColumn(usize);

/// A column of words of a [`ColumnFile`].
#[derive(Clone, Copy, Debug)]
pub struct WordColumn(usize);

/// One row.
pub struct Row<'a> {
    path: &'a Path,
    names: &'a [String],
    cells: RowCells<'a>,
}

enum RowCells<'a> {
    Csv(&'a csv::StringRecord),
    Table(&'a [Option<Cells>], usize),
}

impl ColumnFile {
    /// Opens a file and reads its header.
    ///
    /// # Errors
    /// [`ColumnFileError`] where the file cannot be read or has no header.
    pub fn open(path: &Path) -> Result<Self, ColumnFileError> {
        let failed = |source| ColumnFileError::Read { path: path.to_owned(), source };
        let file = File::open(path).map_err(failed)?;
        Self::new(path, decompressed(file).map_err(failed)?)
    }

    /// A table of a calling program.
    ///
    /// # Errors
    /// As [`ColumnFile::open`].
    pub fn of_table(table: GivenTable) -> Result<Self, ColumnFileError> {
        let (path, names) = (table.path().to_owned(), table.names().to_vec());
        check_names(&path, &names)?;
        let columns = vec![None; names.len()];
        Ok(Self { path, names, rows: Rows::Table(table, columns) })
    }
}

impl<R: Read> ColumnFile<R> {
    /// Reads the header of a table that is called `path` in messages.
    ///
    /// # Errors
    /// As [`ColumnFile::open`].
    pub fn new(path: &Path, from: R) -> Result<Self, ColumnFileError> {
        let mut from = BufReader::new(from);
        let failed = |source| ColumnFileError::Read { path: path.to_owned(), source };
        let delimiter = delimiter(from.fill_buf().map_err(failed)?);
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .comment(Some(b'#'))
            .delimiter(delimiter)
            .from_reader(from);
        let header = reader.headers().map_err(|error| csv_error(path, error))?;
        let names: Vec<String> =
            header.iter().map(|name| name.trim_start_matches('\u{feff}').to_owned()).collect();
        check_names(path, &names)?;
        Ok(Self { path: path.to_owned(), names, rows: Rows::Csv(reader) })
    }

    /// What it is called.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Names of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Whether it has one of these columns.
    pub fn has(&self, names: &[&str]) -> bool {
        self.place(names).is_some()
    }

    /// Place of the first of these columns that is there.
    fn place(&self, names: &[&str]) -> Option<usize> {
        names.iter().find_map(|name| self.names.iter().position(|found| found == name))
    }

    /// A column that is none of these, and one of them in another unit.
    pub fn other_unit(&self, names: &[&str]) -> Option<&str> {
        let wanted: Vec<&str> = names.iter().filter_map(|name| without_unit(name)).collect();
        let other = |name: &&String| without_unit(name).is_some_and(|name| wanted.contains(&name));
        self.names.iter().find(other).map(String::as_str)
    }

    /// The one of these columns that is there, as numbers.
    ///
    /// # Errors
    /// [`ColumnFileError::Unit`] where it is there in another unit, [`ColumnFileError::Ambiguous`] where two of them are there, or
    /// [`ColumnFileError::Type`].
    pub fn numbers(&mut self, names: &[&str]) -> Result<Option<NumberColumn>, ColumnFileError> {
        let meant = self.names.iter().map(String::as_str).enumerate();
        let meant = meant.filter(|(_, name)| names.contains(name));
        let Some(place) = the_only(&self.path, meant)? else {
            return self.other_unit(names).map_or(Ok(None), |column| {
                Err(ColumnFileError::Unit {
                    path: self.path.clone(),
                    column: column.to_owned(),
                    allowed: names.iter().map(|name| (*name).to_owned()).collect(),
                })
            });
        };
        if let Rows::Table(table, columns) = &mut self.rows {
            columns[place] = Some(table.cells(place)?);
        }
        Ok(Some(NumberColumn(place)))
    }

    /// The first of these columns that is there, as words.
    ///
    /// # Errors
    /// [`ColumnFileError::Type`].
    pub fn words(&mut self, names: &[&str]) -> Result<Option<WordColumn>, ColumnFileError> {
        let Some(place) = self.place(names) else { return Ok(None) };
        if let Rows::Table(table, columns) = &mut self.rows {
            columns[place] = Some(Cells::Words(table.words(place)?));
        }
        Ok(Some(WordColumn(place)))
    }

    /// As [`ColumnFile::numbers`], for a column that is needed.
    ///
    /// # Errors
    /// [`ColumnFileError::MissingColumn`], or as [`ColumnFile::numbers`].
    pub fn need_numbers(&mut self, names: &[&str]) -> Result<NumberColumn, ColumnFileError> {
        self.numbers(names)?.ok_or_else(|| self.missing(names))
    }

    /// As [`ColumnFile::words`], for a column that is needed.
    ///
    /// # Errors
    /// [`ColumnFileError::MissingColumn`] or [`ColumnFileError::Type`].
    pub fn need_words(&mut self, names: &[&str]) -> Result<WordColumn, ColumnFileError> {
        self.words(names)?.ok_or_else(|| self.missing(names))
    }

    fn missing(&self, names: &[&str]) -> ColumnFileError {
        let similarity = |found: &&String| {
            let likeness = |name: &&str| strsim::jaro_winkler(name, found);
            names.iter().map(likeness).fold(0.0, f64::max)
        };
        let nearest = self.names.iter().max_by(|a, b| similarity(a).total_cmp(&similarity(b)));
        ColumnFileError::MissingColumn {
            path: self.path.clone(),
            column: names.join("` or `"),
            found: self.names.clone(),
            nearest: nearest.filter(|found| similarity(found) > 0.8).cloned(),
        }
    }

    /// Calls `use_row` with each row.
    ///
    /// # Errors
    /// [`ColumnFileError::NoRows`], or the first row that cannot be read, or that `use_row` refuses.
    pub fn for_each(
        self,
        mut use_row: impl FnMut(&Row) -> Result<(), ColumnFileError>,
    ) -> Result<(), ColumnFileError> {
        let Self { path, names, rows } = self;
        let mut reader = match rows {
            Rows::Csv(reader) => reader,
            Rows::Table(table, _) if table.rows() == 0 => {
                return Err(ColumnFileError::NoRows { path });
            }
            Rows::Table(table, columns) => {
                return (0..table.rows()).try_for_each(|row| {
                    let cells = RowCells::Table(&columns, row);
                    use_row(&Row { path: &path, names: &names, cells })
                });
            }
        };
        let mut record = csv::StringRecord::new();
        let mut rows = 0;
        while reader.read_record(&mut record).map_err(|error| csv_error(&path, error))? {
            rows += 1;
            if rows > MOST_ROWS {
                return Err(ColumnFileError::TooLong { path });
            }
            use_row(&Row { path: &path, names: &names, cells: RowCells::Csv(&record) })?;
        }
        if rows == 0 { Err(ColumnFileError::NoRows { path }) } else { Ok(()) }
    }
}

impl Row<'_> {
    /// The text of a cell.
    pub fn text(&self, column: WordColumn) -> &str {
        self.written(column.0)
    }

    /// What is written in a cell.
    fn written(&self, column: usize) -> &str {
        match self.cells {
            RowCells::Csv(record) => record.get(column).unwrap_or(""),
            RowCells::Table(columns, row) => match &columns[column] {
                Some(Cells::Words(words)) => word(words, row),
                _ => "",
            },
        }
    }

    /// The number in a cell; NaN where it is empty or says `NaN` or `NA`.
    ///
    /// # Errors
    /// [`ColumnFileError::Cell`] where something else is there.
    pub fn number(&self, column: NumberColumn) -> Result<f64, ColumnFileError> {
        if let RowCells::Table(columns, row) = self.cells
            && let Some(Cells::Numbers(numbers)) = &columns[column.0]
        {
            return Ok(numbers.value(row));
        }
        let text = self.written(column.0);
        if text.is_empty() || ["na", "nan", "null"].contains(&text.to_ascii_lowercase().as_str()) {
            return Ok(f64::NAN);
        }
        let allowed = "a number with a decimal point, or nothing where it is missing";
        text.parse().map_err(|_| self.refused(column.0, allowed))
    }

    /// The error of a cell that holds something else than `allowed`.
    pub fn refuse(&self, column: WordColumn, allowed: &'static str) -> ColumnFileError {
        self.refused(column.0, allowed)
    }

    /// As [`Row::refuse`], of a column of numbers.
    pub fn refuse_number(&self, column: NumberColumn, allowed: &'static str) -> ColumnFileError {
        self.refused(column.0, allowed)
    }

    fn refused(&self, column: usize, allowed: &'static str) -> ColumnFileError {
        let place = match self.cells {
            RowCells::Csv(record) => {
                RowPlace::Line(record.position().map_or(0, csv::Position::line))
            }
            RowCells::Table(_, row) => RowPlace::Row(row as u64 + 1),
        };
        ColumnFileError::Cell {
            path: self.path.to_owned(),
            place,
            column: self.names[column].clone(),
            value: self.written(column).chars().take(40).collect(),
            allowed,
        }
    }
}

/// A name without the unit at its end; none where it has none.
fn without_unit(name: &str) -> Option<&str> {
    UNITS.iter().find_map(|unit| name.strip_suffix(unit))
}

/// A word of a table, nothing where it is missing.
fn word(words: &StringArray, row: usize) -> &str {
    if words.is_null(row) { "" } else { words.value(row).trim() }
}

/// Names that name nothing, or the same twice, are refused.
fn check_names(path: &Path, names: &[String]) -> Result<(), ColumnFileError> {
    if names.iter().all(String::is_empty) {
        return Err(ColumnFileError::Empty { path: path.to_owned() });
    }
    for (k, name) in names.iter().enumerate() {
        if names[..k].contains(name) {
            let (path, column) = (path.to_owned(), name.clone());
            return Err(ColumnFileError::TwiceColumn { path, column });
        }
    }
    Ok(())
}

fn csv_error(path: &Path, error: csv::Error) -> ColumnFileError {
    let path = path.to_owned();
    match error.into_kind() {
        csv::ErrorKind::Io(source) => ColumnFileError::Read { path, source },
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
            let line = pos.map_or(0, |position| position.line());
            let message = format!(
                "line {line} has {len} cells; allowed are {expected_len}, as in the header"
            );
            ColumnFileError::Csv { path, message }
        }
        csv::ErrorKind::Utf8 { pos, .. } => {
            let line = pos.map_or(0, |position| position.line());
            let message = format!("line {line} is not UTF-8 text; save the table as CSV in UTF-8");
            ColumnFileError::Csv { path, message }
        }
        other => ColumnFileError::Csv { path, message: format!("no table: {other:?}") },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, columns: &[&str]) -> Result<Vec<f64>, String> {
        let mut file =
            ColumnFile::new(Path::new("t.csv"), text.as_bytes()).map_err(|e| e.to_string())?;
        let column = file.need_numbers(columns).map_err(|e| e.to_string())?;
        let mut values = Vec::new();
        file.for_each(|row| {
            values.push(row.number(column)?);
            Ok(())
        })
        .map_err(|e| e.to_string())?;
        Ok(values)
    }

    #[test]
    fn numbers_and_gaps() {
        let values = read("\u{feff}a, b\n1,2\n,NaN\n1e3 , 4\n", &["a"]).expect("a table");
        assert!(values[0] == 1.0 && values[1].is_nan() && values[2] == 1000.0);
    }

    #[test]
    fn what_is_wrong_is_said_with_its_place() {
        for (text, parts) in [
            ("", &["empty"][..]),
            ("\n\n", &["empty"]),
            ("b,sped_mps\n1,2\n", &["no column `speed_mps`", "b, sped_mps", "`sped_mps`"]),
            ("b,speed_kmh\n1,2\n", &["`speed_kmh`", "unit", "allowed is `speed_mps`"]),
            ("speed_mps,b\n", &["no rows"]),
            ("b;speed_mps\n1;2,5\n", &["line 2", "`2,5`", "a number with a decimal point"]),
            ("speed_mps\nfast\n", &["line 2", "speed_mps", "`fast`", "a number"]),
            ("speed_mps,b\n1,2\n3\n", &["line 3 has 1 cells", "2"]),
            ("speed_mps,speed_mps\n1,2\n", &["twice"]),
        ] {
            let told = read(text, &["speed_mps"]).expect_err(text);
            for part in parts {
                assert!(told.contains(part) && told.contains("t.csv"), "{told}");
            }
        }
        let file = ColumnFile::new(Path::new("t.csv"), &b"a\n1\n\xff\n"[..]).expect("a header");
        let told = file.for_each(|_| Ok(())).expect_err("no text").to_string();
        assert!(told.contains("line 3") && told.contains("UTF-8"), "{told}");
    }
}

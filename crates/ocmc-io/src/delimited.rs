//! Tables that others write: a header, and rows of cells between commas, semicolons or tabs.
//!
//! Column names are compared without case, units and brackets: `<s>`, `s [m]` and `S` are all `s`. A unit that stands in square
//! brackets has to be the one that is read, where a quantity has only one. Lines that begin with
//! `#` are comments; a byte-order mark and letters that are not UTF-8 (old files are Latin-1) do no harm.

use crate::ambiguous_columns::{AmbiguousColumns, the_only};
use crate::given_table::{ColumnTypeError, GivenTable};
use crate::text_file::{decompressed, delimiter};
use std::fmt::Write;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Largest table, in bytes.
const MOST_BYTES: u64 = 256 << 20;

/// Likeness of two names (Jaro and Winkler's) from which one is taken for a slip of the other.
const LIKE: f64 = 0.8;

/// What is wrong with a table.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TableError {
    /// A column of a type that no cell has.
    #[error(transparent)]
    Type(#[from] ColumnTypeError),
    /// A file that cannot be read.
    #[error("cannot read `{}`: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file that is too large.
    #[error("`{}` has {bytes} bytes, allowed are at most {MOST_BYTES}", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
    },
    /// A file without a row.
    #[error("`{}` has no rows below its header", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// A row of another length.
    #[error("{}:{line}: {found} cells, allowed are {wanted}, as many as the header has", path.display())]
    Cells {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: u64,
        /// Cells in the row.
        found: usize,
        /// Cells in the header.
        wanted: usize,
    },
    /// A cell that is no finite number.
    #[error("{}:{line}: `{column}` is {}, allowed is a finite number", path.display(), cell(value))]
    Number {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: u64,
        /// The column.
        column: String,
        /// The cell.
        value: String,
    },
    /// A column that is missing.
    #[error("`{}` has no column {wanted}; its columns are: {have}", path.display())]
    Column {
        /// The file.
        path: PathBuf,
        /// Names that it may have.
        wanted: String,
        /// The columns that there are.
        have: String,
    },
    /// Two columns for one quantity.
    #[error(transparent)]
    Ambiguous(#[from] AmbiguousColumns),
    /// A column in another unit.
    #[error(
        "`{}`: column `{column}` is read in {allowed}, not in {unit}; convert the numbers, and write `[{allowed}]` or nothing",
        path.display()
    )]
    Unit {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
        /// Its unit as written.
        unit: String,
        /// The unit that is read.
        allowed: &'static str,
    },
    /// Columns that nobody knows.
    #[error("`{}` has {}; allowed are: {allowed}", path.display(), unknown(columns))]
    Unknown {
        /// The file.
        path: PathBuf,
        /// The columns, each with the known name that was probably meant.
        columns: Vec<(String, Option<String>)>,
        /// The columns that are known.
        allowed: String,
    },
}

/// A cell in a message.
fn cell(value: &str) -> String {
    if value.is_empty() { "empty".to_owned() } else { format!("`{value}`") }
}

/// Columns that nobody knows, in a message.
fn unknown(columns: &[(String, Option<String>)]) -> String {
    let named = columns.iter().map(|(name, meant)| match meant {
        Some(meant) => format!("`{name}` (did you mean `{meant}`?)"),
        None => format!("`{name}`"),
    });
    let named = named.collect::<Vec<_>>().join(", ");
    if columns.len() == 1 {
        format!("an unknown column {named}")
    } else {
        format!("unknown columns {named}")
    }
}

/// How a unit is written; first the usual way.
pub type Unit = &'static [&'static str];

/// Metres.
pub const METRES: Unit = &["m", "metre", "metres", "meter", "meters"];
/// Seconds.
pub const SECONDS: Unit = &["s", "sec", "second", "seconds"];
/// Kilometres an hour.
pub const KMH: Unit = &["km/h", "kmh", "kph", "km/hr"];
/// Metres a second.
pub const MPS: Unit = &["m/s", "mps"];
/// Miles an hour.
pub const MPH: Unit = &["mph", "mile/h", "miles/h", "mi/h"];
/// Per cent.
pub const PERCENT: Unit = &["%", "percent", "per cent"];
/// Without a unit.
pub const PLAIN: Unit = &["-", "1", "m/m"];

/// A table as text.
#[derive(Clone, Debug)]
pub struct DelimitedTable {
    path: PathBuf,
    /// Names as written.
    header: Vec<String>,
    /// Line of each row, from 1, and its cells.
    rows: Vec<(u64, Vec<String>)>,
}

/// Reads a file as text, compressed by gzip or not; what is not UTF-8 is read as Latin-1.
pub(crate) fn read_text(path: &Path) -> Result<String, TableError> {
    let unreadable = |source| TableError::Unreadable { path: path.to_owned(), source };
    let bytes = std::fs::metadata(path).map_err(unreadable)?.len();
    if bytes > MOST_BYTES {
        return Err(TableError::TooLarge { path: path.to_owned(), bytes });
    }
    let text = decompressed(File::open(path).map_err(unreadable)?).map_err(unreadable)?;
    let mut bytes = Vec::new();
    text.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(TableError::TooLarge { path: path.to_owned(), bytes: bytes.len() as u64 });
    }
    let text = match String::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => error.into_bytes().into_iter().map(char::from).collect(),
    };
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

impl DelimitedTable {
    /// Reads a table.
    ///
    /// # Errors
    /// [`TableError`] names the file and the line.
    pub fn read(path: &Path) -> Result<Self, TableError> {
        Self::parse(path, &read_text(path)?)
    }

    /// Reads a table from a text that is called `path` in messages.
    ///
    /// # Errors
    /// As [`DelimitedTable::read`].
    pub fn parse(path: &Path, text: &str) -> Result<Self, TableError> {
        let mut lines = text.lines().enumerate().filter(|(_, line)| {
            let line = line.trim();
            !line.is_empty() && !line.starts_with('#')
        });
        let (_, first) = lines.next().ok_or_else(|| TableError::Empty { path: path.to_owned() })?;
        let delimiter = char::from(delimiter(first.as_bytes()));
        let split = |line: &str| -> Vec<String> {
            let cells = line.split(delimiter);
            cells.map(|cell| cell.trim().trim_matches('"').to_owned()).collect()
        };
        let header = split(first);
        let mut rows = Vec::new();
        for (k, line) in lines {
            let (line, cells) = (k as u64 + 1, split(line));
            if cells.len() != header.len() {
                let (found, wanted) = (cells.len(), header.len());
                return Err(TableError::Cells { path: path.to_owned(), line, found, wanted });
            }
            rows.push((line, cells));
        }
        if rows.is_empty() {
            return Err(TableError::Empty { path: path.to_owned() });
        }
        Ok(Self { path: path.to_owned(), header, rows })
    }

    /// A table of a calling program.
    ///
    /// # Errors
    /// As [`DelimitedTable::read`].
    pub fn of_table(table: &GivenTable) -> Result<Self, TableError> {
        let path = table.path().to_owned();
        if table.rows() == 0 {
            return Err(TableError::Empty { path });
        }
        let mut rows: Vec<(u64, Vec<String>)> =
            (1..=table.rows() as u64).map(|row| (row, Vec::new())).collect();
        for column in 0..table.names().len() {
            for ((_, cells), word) in rows.iter_mut().zip(&table.words(column)?) {
                cells.push(word.unwrap_or_default().trim().to_owned());
            }
        }
        Ok(Self { path, header: table.names().to_vec(), rows })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Line of each row, from 1.
    pub fn lines(&self) -> impl Iterator<Item = u64> + '_ {
        self.rows.iter().map(|row| row.0)
    }

    /// Names of the columns, made comparable.
    pub fn names(&self) -> impl Iterator<Item = String> + '_ {
        self.header.iter().map(|name| comparable(name))
    }

    /// The place of a column that has one of these names.
    pub fn find(&self, names: &[&str]) -> Option<usize> {
        self.names().position(|name| names.contains(&name.as_str()))
    }

    /// The place of the one column that has one of these names.
    ///
    /// # Errors
    /// [`TableError::Ambiguous`] where there are two of them.
    pub fn one_of(&self, names: &[&str]) -> Result<Option<usize>, TableError> {
        let meant = self.names().enumerate().filter(|(_, name)| names.contains(&name.as_str()));
        Ok(the_only(&self.path, meant.map(|(place, _)| (place, self.header[place].as_str())))?)
    }

    /// Refuses a column whose name has another unit in brackets than one of these, of which the first is the one to write.
    ///
    /// # Errors
    /// [`TableError::Unit`].
    pub fn check_unit(&self, column: usize, units: Unit) -> Result<(), TableError> {
        let name = &self.header[column];
        let Some((_, unit)) = name.split_once('[') else { return Ok(()) };
        let unit = unit.split(']').next().unwrap_or_default().trim();
        if unit.is_empty() || units.iter().any(|known| known.eq_ignore_ascii_case(unit)) {
            return Ok(());
        }
        let (column, unit, allowed) = (name.clone(), unit.to_owned(), units[0]);
        Err(TableError::Unit { path: self.path.clone(), column, unit, allowed })
    }

    /// The place of the one column that has to be there.
    ///
    /// # Errors
    /// [`TableError::Column`], or [`TableError::Ambiguous`] where there are two.
    pub fn column(&self, names: &[&str]) -> Result<usize, TableError> {
        self.one_of(names)?.ok_or_else(|| TableError::Column {
            path: self.path.clone(),
            wanted: names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(" or "),
            have: self.header.join(", "),
        })
    }

    /// The words of a column.
    pub fn words(&self, column: usize) -> Vec<String> {
        self.rows.iter().map(|row| row.1[column].clone()).collect()
    }

    /// The numbers of a column.
    ///
    /// # Errors
    /// [`TableError::Number`].
    pub fn numbers(&self, column: usize) -> Result<Vec<f64>, TableError> {
        self.numbers_or(column, None)
    }

    /// As [`DelimitedTable::numbers`], with the number that an empty cell means.
    ///
    /// # Errors
    /// As [`DelimitedTable::numbers`].
    pub fn numbers_or(&self, column: usize, empty: Option<f64>) -> Result<Vec<f64>, TableError> {
        let parse = |(line, cells): &(u64, Vec<String>)| {
            let cell = &cells[column];
            if let Some(number) = empty.filter(|_| cell.is_empty()) {
                return Ok(number);
            }
            let number = cell.parse::<f64>().ok().filter(|number| number.is_finite());
            number.ok_or_else(|| TableError::Number {
                path: self.path.clone(),
                line: *line,
                column: self.header[column].clone(),
                value: cell.chars().take(40).collect(),
            })
        };
        self.rows.iter().map(parse).collect()
    }

    /// The numbers of a column that has one of these names; none where there is no such column.
    ///
    /// # Errors
    /// As [`DelimitedTable::numbers`].
    pub fn numbers_of(&self, names: &[&str]) -> Result<Option<Vec<f64>>, TableError> {
        self.one_of(names)?.map(|column| self.numbers(column)).transpose()
    }

    /// As [`DelimitedTable::numbers_of`], of a column that has one unit only.
    ///
    /// # Errors
    /// As [`DelimitedTable::numbers_of`] and [`DelimitedTable::check_unit`].
    pub fn numbers_in(&self, names: &[&str], unit: Unit) -> Result<Option<Vec<f64>>, TableError> {
        let Some(column) = self.one_of(names)? else { return Ok(None) };
        self.check_unit(column, unit)?;
        self.numbers(column).map(Some)
    }

    /// Refuses columns that are not among these.
    ///
    /// # Errors
    /// [`TableError::Unknown`].
    pub fn refuse_others(&self, known: &[&str]) -> Result<(), TableError> {
        let others = self.names().zip(&self.header).filter(|(n, _)| !known.contains(&n.as_str()));
        let columns: Vec<_> =
            others.map(|(n, written)| (written.clone(), meant(&n, known))).collect();
        if columns.is_empty() {
            return Ok(());
        }
        Err(TableError::Unknown { path: self.path.clone(), columns, allowed: known.join(", ") })
    }
}

/// The known name that a name is most like; none where it is like none.
fn meant(name: &str, known: &[&str]) -> Option<String> {
    let scored = known.iter().map(|known| (strsim::jaro_winkler(name, known), known));
    let nearest = scored.max_by(|a, b| a.0.total_cmp(&b.0));
    nearest.filter(|(likeness, _)| *likeness > LIKE).map(|(_, known)| (*known).to_owned())
}

/// A column name without case, brackets, units and blanks at its ends.
fn comparable(name: &str) -> String {
    let name = name.split('[').next().unwrap_or_default();
    let name = name.trim().trim_matches(|c| c == '<' || c == '>').trim();
    let mut text = String::with_capacity(name.len());
    for character in name.chars() {
        let _ = write!(text, "{}", character.to_lowercase());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_of_others_are_understood() {
        let path = Path::new("a.vfld");
        let text =
            "# made by hand\nn [U/min];Mfull [Nm];<PT1> [s]\n560;1180;0.6\n\n600; 1282 ;0.6\n";
        let table = DelimitedTable::parse(path, text).unwrap();
        assert_eq!(table.names().collect::<Vec<_>>(), ["n", "mfull", "pt1"]);
        assert_eq!(table.numbers_of(&["mfull"]).unwrap().unwrap(), [1180.0, 1282.0]);
        assert_eq!(table.lines().collect::<Vec<_>>(), [3, 5]);
        assert!(table.numbers_of(&["torque"]).unwrap().is_none());
        assert!(table.refuse_others(&["n", "mfull"]).is_err());
    }

    #[test]
    fn units_and_columns_that_are_not_meant_are_refused() {
        let parse = |text: &str| DelimitedTable::parse(Path::new("c.csv"), text).unwrap();
        let table = parse("<s> [km],v [Km/h],t []\n1,2,3\n");
        let fault = table.numbers_in(&["s"], METRES).unwrap_err().to_string();
        assert!(fault.contains("`<s> [km]` is read in m, not in km"), "{fault}");
        assert_eq!(table.numbers_in(&["v"], KMH).unwrap().unwrap(), [2.0]);
        assert_eq!(table.numbers_in(&["t"], SECONDS).unwrap().unwrap(), [3.0]);
        let table = parse("s,V,v [km/h]\n1,2,3\n");
        let fault = table.column(&["v"]).unwrap_err().to_string();
        assert!(fault.contains("`c.csv` has the columns `V` and `v [km/h]`"), "{fault}");
        assert_eq!(table.one_of(&["s"]).unwrap(), Some(0));
    }

    #[test]
    fn faults_name_the_file_and_the_line() {
        let path = Path::new("b.csv");
        let fault = |text: &str| DelimitedTable::parse(path, text).unwrap_err().to_string();
        assert!(fault("").contains("`b.csv`"));
        assert!(fault("a,b\n1,2\n3\n").starts_with("b.csv:3: 1 cells"));
        let table = DelimitedTable::parse(path, "a,b\n1,2\n3,x\n").unwrap();
        assert!(table.numbers(1).unwrap_err().to_string().contains("b.csv:3: `b` is `x`"));
        let unknown = table.refuse_others(&["c"]).unwrap_err().to_string();
        assert!(unknown.contains("has unknown columns `a`, `b`; allowed are: c"), "{unknown}");
        let other = DelimitedTable::parse(path, "speed_kmh,s\n,1\n").unwrap();
        let unknown = other.refuse_others(&["s", "speed_limit_kmh"]).unwrap_err().to_string();
        let words = "an unknown column `speed_kmh` (did you mean `speed_limit_kmh`?); allowed";
        assert!(unknown.contains(words), "{unknown}");
        let empty = other.numbers(0).unwrap_err().to_string();
        assert!(empty.contains("b.csv:2: `speed_kmh` is empty, allowed is"), "{empty}");
        assert_eq!(other.numbers_or(0, Some(7.0)).unwrap(), [7.0]);
        let missing = table.column(&["s", "position_m"]).unwrap_err().to_string();
        assert!(missing.contains("`s` or `position_m`") && missing.contains("a, b"), "{missing}");
    }
}

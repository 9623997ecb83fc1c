//! CSV files with named columns, read row by row: only the columns that are wanted are kept.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Most rows of a table: each keeps its numbers in memory.
pub const MOST_ROWS: usize = 20_000_000;

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
    /// The file is not a table of comma-separated values.
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
    /// A cell with something else than what its column holds.
    #[error("`{}`, line {line}, column `{column}`: `{value}`; allowed is {allowed}", path.display())]
    Cell {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
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

/// A CSV file whose header has been read.
pub struct ColumnFile<R = File> {
    path: PathBuf,
    reader: csv::Reader<R>,
    names: Vec<String>,
}

/// One row of wanted cells.
pub struct Row<'a> {
    path: &'a Path,
    names: &'a [String],
    record: &'a csv::StringRecord,
}

impl ColumnFile {
    /// Opens a file and reads its header.
    ///
    /// # Errors
    /// [`ColumnFileError`] where the file cannot be read or has no header.
    pub fn open(path: &Path) -> Result<Self, ColumnFileError> {
        let file = File::open(path)
            .map_err(|source| ColumnFileError::Read { path: path.to_owned(), source })?;
        Self::new(path, file)
    }
}

impl<R: Read> ColumnFile<R> {
    /// Reads the header of a table that is called `path` in messages.
    ///
    /// # Errors
    /// As [`ColumnFile::open`].
    pub fn new(path: &Path, from: R) -> Result<Self, ColumnFileError> {
        let mut reader =
            csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(from);
        let header = reader.headers().map_err(|error| csv_error(path, error))?;
        let names: Vec<String> =
            header.iter().map(|name| name.trim_start_matches('\u{feff}').to_owned()).collect();
        if names.iter().all(String::is_empty) {
            return Err(ColumnFileError::Empty { path: path.to_owned() });
        }
        for (k, name) in names.iter().enumerate() {
            if names[..k].contains(name) {
                let (path, column) = (path.to_owned(), name.clone());
                return Err(ColumnFileError::TwiceColumn { path, column });
            }
        }
        Ok(Self { path: path.to_owned(), reader, names })
    }

    /// Names of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Place of the first of these columns that is there.
    pub fn find(&self, names: &[&str]) -> Option<usize> {
        names.iter().find_map(|name| self.names.iter().position(|found| found == name))
    }

    /// As [`ColumnFile::find`], for a column that is needed.
    ///
    /// # Errors
    /// [`ColumnFileError::MissingColumn`].
    pub fn need(&self, names: &[&str]) -> Result<usize, ColumnFileError> {
        self.find(names).ok_or_else(|| {
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
        })
    }

    /// Calls `use_row` with each row.
    ///
    /// # Errors
    /// The first row that cannot be read, or that `use_row` refuses.
    pub fn for_each(
        mut self,
        mut use_row: impl FnMut(&Row) -> Result<(), ColumnFileError>,
    ) -> Result<(), ColumnFileError> {
        let mut record = csv::StringRecord::new();
        let mut rows = 0;
        while self.reader.read_record(&mut record).map_err(|error| csv_error(&self.path, error))? {
            rows += 1;
            if rows > MOST_ROWS {
                return Err(ColumnFileError::TooLong { path: self.path });
            }
            use_row(&Row { path: &self.path, names: &self.names, record: &record })?;
        }
        Ok(())
    }
}

impl Row<'_> {
    /// The text of a cell.
    pub fn text(&self, column: usize) -> &str {
        self.record.get(column).unwrap_or("")
    }

    /// The number in a cell; NaN where it is empty or says `NaN` or `NA`.
    ///
    /// # Errors
    /// [`ColumnFileError::Cell`] where something else is there.
    pub fn number(&self, column: usize) -> Result<f64, ColumnFileError> {
        let text = self.text(column);
        if text.is_empty() || ["na", "nan", "null"].contains(&text.to_ascii_lowercase().as_str()) {
            return Ok(f64::NAN);
        }
        text.parse().map_err(|_| self.refuse(column, "a number, or nothing where it is missing"))
    }

    /// The error of a cell that holds something else than `allowed`.
    pub fn refuse(&self, column: usize, allowed: &'static str) -> ColumnFileError {
        ColumnFileError::Cell {
            path: self.path.to_owned(),
            line: self.record.position().map_or(0, csv::Position::line),
            column: self.names[column].clone(),
            value: self.text(column).chars().take(40).collect(),
            allowed,
        }
    }
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
        let file =
            ColumnFile::new(Path::new("t.csv"), text.as_bytes()).map_err(|e| e.to_string())?;
        let column = file.need(columns).map_err(|e| e.to_string())?;
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
            ("b,speed_kmh\n1,2\n", &["no column `speed_mps`", "b, speed_kmh", "`speed_kmh`"]),
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

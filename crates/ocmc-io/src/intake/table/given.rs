//! Tables that a calling program holds in Arrow's form. A column of 64-bit numbers in one piece and
//! without nulls is taken as it lies in memory; others are copied: other types of numbers, texts
//! that are to be numbers, nulls (which become NaN), and columns in several pieces.

use super::arrow_column::{is_number, numbers, words};
use super::error::{Fault, TableError};
use arrow_array::{Array, ArrayRef, Float64Array, StringArray};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where a row stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowPlace {
    /// A line of a file, from 1.
    Line(u64),
    /// A row of a table, from 1.
    Row(u64),
}

impl fmt::Display for RowPlace {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Row(row) => write!(f, "row {row}"),
        }
    }
}

/// A table of named columns of equal length, each in pieces.
#[derive(Clone, Debug)]
pub struct GivenTable {
    name: PathBuf,
    names: Vec<String>,
    /// Pieces of rows, each with all columns.
    pieces: Vec<Vec<ArrayRef>>,
    /// Whether its columns are those of a format, and nobody chose them.
    is_export: bool,
}

/// The cells of a column.
#[derive(Clone, Debug)]
pub enum Cells {
    /// Numbers, NaN where one is missing.
    Numbers(Float64Array),
    /// Texts, null where one is missing.
    Words(StringArray),
}

impl GivenTable {
    /// A table that is called `name` in messages.
    pub fn new(name: &str, names: Vec<String>, pieces: Vec<Vec<ArrayRef>>) -> Self {
        Self { name: PathBuf::from(name), names, pieces, is_export: false }
    }

    /// A table of a format, whose columns nobody chose: those that are not needed are left out.
    pub(crate) fn export(name: &str, names: Vec<String>, pieces: Vec<Vec<ArrayRef>>) -> Self {
        Self { is_export: true, ..Self::new(name, names, pieces) }
    }

    /// Whether its columns are those of a format.
    pub(crate) fn is_export(&self) -> bool {
        self.is_export
    }

    /// Path of the table.
    pub fn path(&self) -> &Path {
        &self.name
    }

    /// Names of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.pieces.iter().map(|piece| piece.first().map_or(0, Array::len)).sum()
    }

    /// A column as numbers where it has a type of numbers, otherwise as texts.
    ///
    /// # Errors
    /// [`TableError`].
    pub fn cells(&self, column: usize) -> Result<Cells, TableError> {
        if !self.pieces.iter().all(|piece| is_number(piece[column].data_type())) {
            return Ok(Cells::Words(self.words(column)?));
        }
        let pieces = self.pieces(column, numbers)?;
        if let [whole] = pieces.as_slice()
            && whole.null_count() == 0
        {
            return Ok(Cells::Numbers(whole.clone()));
        }
        let all = pieces.iter().flatten().map(|number| number.unwrap_or(f64::NAN));
        Ok(Cells::Numbers(Float64Array::from_iter_values(all)))
    }

    /// The table with all cells as texts, as a file has them: numbers are written exactly, and what
    /// is missing is empty.
    ///
    /// # Errors
    /// [`TableError`] of a column that is neither numbers nor texts.
    pub(crate) fn written(&self) -> Result<Self, TableError> {
        let known = |number: &f64| !number.is_nan();
        let column = |column| -> Result<ArrayRef, TableError> {
            Ok(Arc::new(match self.cells(column)? {
                Cells::Words(words) => words,
                Cells::Numbers(numbers) => {
                    let cells = numbers.iter().map(|number| number.filter(known));
                    cells.map(|number| number.map(|number| number.to_string())).collect()
                }
            }))
        };
        let columns = (0..self.names.len()).map(column).collect::<Result<_, _>>()?;
        Ok(Self { pieces: vec![columns], ..self.clone() })
    }

    /// The table in CSV.
    ///
    /// # Errors
    /// As [`GivenTable::words`].
    pub(crate) fn to_csv(&self) -> Result<String, TableError> {
        let columns = (0..self.names.len()).map(|column| self.words(column));
        let columns: Vec<StringArray> = columns.collect::<Result<_, _>>()?;
        let mut writer = csv::Writer::from_writer(Vec::new());
        let into_memory = "memory takes any text";
        writer.write_record(&self.names).expect(into_memory);
        for row in 0..self.rows() {
            let cell = |words: &StringArray| {
                if words.is_valid(row) { words.value(row).to_owned() } else { String::new() }
            };
            writer.write_record(columns.iter().map(cell)).expect(into_memory);
        }
        let bytes = writer.into_inner().expect(into_memory);
        Ok(String::from_utf8(bytes).expect("made of texts"))
    }

    /// A column as texts; numbers are written.
    ///
    /// # Errors
    /// [`TableError`].
    pub fn words(&self, column: usize) -> Result<StringArray, TableError> {
        let pieces = self.pieces(column, words)?;
        match pieces.as_slice() {
            [words] => Ok(words.clone()),
            several => Ok(several.iter().flatten().collect()),
        }
    }

    /// The pieces of a column, read in one way.
    fn pieces<T>(
        &self,
        column: usize,
        read: impl Fn(&dyn Array) -> Option<T>,
    ) -> Result<Vec<T>, TableError> {
        let pieces = self.pieces.iter().map(|piece| {
            read(&piece[column]).ok_or_else(|| {
                let (column, found) =
                    (self.names[column].clone(), piece[column].data_type().clone());
                TableError::of(&self.name, Fault::Type { column, found })
            })
        });
        pieces.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use arrow_array::{Int32Array, ListArray, types::Int32Type};
    use std::sync::Arc;

    fn table(pieces: &[ArrayRef]) -> GivenTable {
        let pieces = pieces.iter().map(|piece| vec![Arc::clone(piece)]).collect();
        GivenTable::new("t", vec!["a".to_owned()], pieces)
    }

    fn numbers(pieces: &[ArrayRef]) -> Float64Array {
        match table(pieces).cells(0) {
            Ok(Cells::Numbers(numbers)) => numbers,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn numbers_in_one_piece_are_not_copied() {
        let column = Float64Array::from(vec![1.0, f64::NAN, 3.0]);
        let place = column.values().as_ptr();
        let whole: ArrayRef = Arc::new(column);
        assert_eq!(numbers(&[Arc::clone(&whole)]).values().as_ptr(), place);
        // a slice of rows is not copied either
        assert_eq!(numbers(&[whole.slice(1, 2)]).values().as_ptr(), place.wrapping_add(1));
        assert_ne!(numbers(&[Arc::clone(&whole), whole]).values().as_ptr(), place);
    }

    #[test]
    fn other_numbers_become_numbers_and_nulls_nan() {
        let integers: ArrayRef = Arc::new(Int32Array::from(vec![Some(1), None, Some(3)]));
        let values = numbers(&[integers]);
        assert_eq!((values.value(0), values.value(2), values.null_count()), (1.0, 3.0, 0));
        assert!(values.value(1).is_nan());
    }

    #[test]
    fn labels_are_exact() {
        let ids: ArrayRef = Arc::new(arrow_array::UInt64Array::from(vec![u64::MAX, 7]));
        let words = table(&[Arc::clone(&ids), ids]).words(0).expect("numbers can be written");
        let words: Vec<&str> = words.iter().map(Option::unwrap_or_default).collect();
        assert_eq!(words, ["18446744073709551615", "7", "18446744073709551615", "7"]);
    }

    #[test]
    fn a_written_table_has_the_cells_of_a_file() {
        let numbers: ArrayRef = Arc::new(Float64Array::from(vec![Some(0.1), None, Some(f64::NAN)]));
        let words: ArrayRef = Arc::new(StringArray::from(vec![Some("a, b"), None, Some("\"c\"")]));
        let names = ["x", "y"].map(str::to_owned).to_vec();
        let table = GivenTable::new("t", names, vec![vec![numbers, words]]);
        let written = table.written().and_then(|table| table.to_csv()).expect("cells");
        assert_eq!(written, "x,y\n0.1,\"a, b\"\n,\n,\"\"\"c\"\"\"\n");
    }

    #[test]
    fn a_column_of_lists_is_neither() {
        let lists = ListArray::from_iter_primitive::<Int32Type, _, _>([Some([Some(1)])]);
        let error = table(&[Arc::new(lists)]).cells(0).expect_err("lists").to_string();
        assert!(error.contains("`t`: column `a` is of type List"), "{error}");
    }
}

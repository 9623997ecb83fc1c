//! One row of a table: its texts, and its numbers in SI.

use super::error::{Fault, TableError};
use super::given::{Cells, RowPlace};
use super::schema::{Column, Style};
use arrow_array::{Array, StringArray};
use std::path::Path;

/// What stands for a missing number, in any case.
const MISSING: [&str; 6] = ["", "na", "n/a", "null", "none", "-"];

/// One row.
pub struct Row<'a> {
    pub(super) table: &'a Header<'a>,
    pub(super) place: RowPlace,
    pub(super) cells: RowCells<'a>,
}

/// What a row has to know of its table.
pub(super) struct Header<'a> {
    pub(super) path: &'a Path,
    pub(super) names: &'a [String],
    pub(super) style: Style,
}

pub(super) enum RowCells<'a> {
    Text(&'a csv::StringRecord),
    /// The cells of each column that is understood, by its place, and the row.
    Given(&'a [Option<Cells>], usize),
}

impl Row<'_> {
    /// Where it stands.
    pub fn place(&self) -> RowPlace {
        self.place
    }

    /// How many cells it has beyond or below the number of columns.
    pub fn is_ragged(&self) -> bool {
        match self.cells {
            RowCells::Text(record) => record.len() != self.table.names.len(),
            RowCells::Given(..) => false,
        }
    }

    /// The text of a cell.
    pub fn text(&self, column: &Column) -> &str {
        let text = match self.cells {
            RowCells::Text(record) => record.get(column.place).unwrap_or(""),
            RowCells::Given(columns, row) => match &columns[column.place] {
                Some(Cells::Words(words)) => word(words, row),
                _ => "",
            },
        };
        text.trim()
    }

    /// The number in a cell as it is written: NaN where it is missing, none where something else is
    /// there.
    fn written(&self, column: &Column) -> Option<f64> {
        if let RowCells::Given(columns, row) = self.cells
            && let Some(Cells::Numbers(numbers)) = &columns[column.place]
        {
            return Some(numbers.value(row));
        }
        number(self.text(column))
    }

    /// The number in a cell, in SI; NaN where it is missing.
    ///
    /// # Errors
    /// [`Fault::Cell`] where something else is there, where it is out of its bounds, or
    /// missing in a description.
    pub fn number(&self, column: &Column) -> Result<f64, TableError> {
        self.number_as(column, |number| column.si(number))
    }

    /// As [`Row::number`], by another conversion to SI than the column's.
    ///
    /// # Errors
    /// As [`Row::number`].
    pub fn number_as(
        &self,
        column: &Column,
        si: impl FnOnce(f64) -> f64,
    ) -> Result<f64, TableError> {
        let number = match (self.written(column), self.table.style) {
            (Some(number), Style::Description) if number.is_finite() => number,
            (_, Style::Description) => return Err(self.refuse(column, "a finite number")),
            (Some(number), _) => number,
            (None, _) => {
                let allowed = "a number with a decimal point, or nothing where it is missing";
                return Err(self.refuse(column, allowed));
            }
        };
        let si = si(number);
        match column.bounds {
            Some(bounds) if si < bounds.minimum || si > bounds.maximum => {
                Err(self.refuse(column, bounds.allowed))
            }
            _ => Ok(si),
        }
    }

    /// The number in a cell of a log, in SI, NaN where it is missing; otherwise what stands there.
    pub(crate) fn logged(&self, column: &Column) -> Result<f64, String> {
        match self.written(column) {
            Some(number) if !number.is_infinite() => Ok(column.si(number)),
            Some(infinite) => Err(self.shown(column).unwrap_or_else(|| infinite.to_string())),
            None => Err(self.shown(column).unwrap_or_default()),
        }
    }

    /// The beginning of the text in a cell, where there is one.
    fn shown(&self, column: &Column) -> Option<String> {
        Some(self.text(column))
            .filter(|text| !text.is_empty())
            .map(|t| t.chars().take(40).collect())
    }

    /// The error of a cell that holds something else than `allowed`.
    pub fn refuse(&self, column: &Column, allowed: &'static str) -> TableError {
        let number = self.written(column).filter(|number| !number.is_nan());
        let value = self.shown(column).or_else(|| number.map(|number| number.to_string()));
        let fault = Fault::Cell {
            place: self.place,
            column: self.table.names[column.place].clone(),
            value: value.unwrap_or_default(),
            allowed,
        };
        TableError::of(self.table.path, fault)
    }
}

/// The number that a text is: NaN where it says that it is missing, none where it is something
/// else.
fn number(text: &str) -> Option<f64> {
    text.parse().ok().or_else(|| {
        MISSING.iter().any(|missing| missing.eq_ignore_ascii_case(text)).then_some(f64::NAN)
    })
}

/// A word of a table, nothing where it is missing.
fn word(words: &StringArray, row: usize) -> &str {
    if words.is_null(row) { "" } else { words.value(row) }
}

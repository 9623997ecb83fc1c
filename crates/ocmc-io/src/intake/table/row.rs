//! One row of a table: its texts, and its numbers in SI.

use super::decimal::Decimals;
use super::error::{Fault, TableError};
use super::given::{Cells, RowPlace};
use super::quantity::Quantity;
use super::schema::{Column, Style};
use super::spreadsheet;
use crate::intake::values::Watched;
use crate::number_text::has_decimal_comma;
use arrow_array::{Array, StringArray};
use std::cell::RefCell;
use std::path::Path;

/// Words for a missing number, in any case.
const MISSING: [&str; 6] = ["", "na", "n/a", "null", "none", "-"];

/// One row.
pub struct Row<'a> {
    pub(super) table: &'a Header<'a>,
    pub(super) place: RowPlace,
    pub(super) cells: RowCells<'a>,
}

/// Header that a row has to know of its table.
pub(super) struct Header<'a> {
    pub(super) path: &'a Path,
    pub(super) names: &'a [String],
    pub(super) columns: &'a [Column],
    pub(super) style: Style,
    /// State of the columns, in their order.
    pub(super) watched: RefCell<Vec<Watched>>,
    pub(super) decimals: Decimals,
    /// A number that stands for a missing one.
    pub(super) missing: Option<f64>,
    pub(super) is_export: bool,
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

    fn column(&self, quantity: Quantity) -> Option<&Column> {
        self.table.columns.iter().find(|column| column.quantity == quantity)
    }

    /// The text in the cell of a quantity, nothing where there is no column for it.
    pub fn text(&self, quantity: Quantity) -> &str {
        let Some(column) = self.column(quantity) else { return "" };
        let text = self.text_in(column);
        if matches!(self.cells, RowCells::Text(_)) { spreadsheet::read(text) } else { text }
    }

    fn text_in(&self, column: &Column) -> &str {
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
        let number = if let RowCells::Given(columns, row) = self.cells
            && let Some(Cells::Numbers(numbers)) = &columns[column.place]
        {
            Some(numbers.value(row))
        } else {
            self.number_in(self.text_in(column))
        };
        number.map(|number| if Some(number) == self.table.missing { f64::NAN } else { number })
    }

    /// The number that a text is: NaN where it says that it is missing, none where it is something
    /// else.
    fn number_in(&self, text: &str) -> Option<f64> {
        let missing = || MISSING.iter().any(|missing| missing.eq_ignore_ascii_case(text));
        self.table.decimals.number(text).or_else(|| missing().then_some(f64::NAN))
    }

    /// Remembers a value of a column.
    fn look(&self, column: &Column, written: f64, si: f64) {
        let mut columns = self.table.columns.iter();
        if let Some(k) = columns.position(|known| known.place == column.place) {
            self.table.watched.borrow_mut()[k].look(self.place, column, written, si);
        }
    }

    /// The number in the cell of a quantity, in SI; NaN where it is missing, or the column is.
    ///
    /// # Errors
    /// [`Fault::Cell`] where something else is there, where it is out of its bounds, or
    /// missing in a description.
    pub fn number(&self, quantity: Quantity) -> Result<f64, TableError> {
        Ok(self.optional(quantity)?.unwrap_or(f64::NAN))
    }

    /// As [`Row::number`]; none where there is no column for it.
    ///
    /// # Errors
    /// As [`Row::number`].
    pub fn optional(&self, quantity: Quantity) -> Result<Option<f64>, TableError> {
        self.column(quantity).map(|column| self.checked(column, Column::si)).transpose()
    }

    /// As [`Row::optional`], with the numbers of one unit divided: its factor would differ in the
    /// last bit.
    pub(crate) fn divided(
        &self,
        quantity: Quantity,
        suffix: &str,
        by: f64,
    ) -> Result<Option<f64>, TableError> {
        let si = |column: &Column, number: f64| {
            let divide = column.unit.suffix == suffix;
            if divide { column.sign * number / by } else { column.si(number) }
        };
        self.column(quantity).map(|column| self.checked(column, si)).transpose()
    }

    fn checked(
        &self,
        column: &Column,
        si: impl FnOnce(&Column, f64) -> f64,
    ) -> Result<f64, TableError> {
        let refuse = |allowed| Err(self.refuse(column.quantity, allowed));
        let number = match (self.written(column), self.table.style) {
            (Some(number), Style::Description) if number.is_finite() => number,
            // a receiver lacks some of what its format has
            (Some(number), Style::Description) if self.table.is_export && number.is_nan() => number,
            (_, Style::Description) if self.text_in(column).parse().is_ok_and(f64::is_finite) => {
                return refuse("a finite number with a decimal comma, as the others have");
            }
            (_, Style::Description) if has_decimal_comma(self.text_in(column)) => {
                return refuse(
                    "a finite number with a decimal point: 0.5, not 0,5 (commas are read \
                               where all numbers have them and semicolons separate the cells)",
                );
            }
            (_, Style::Description) => return refuse("a finite number"),
            (Some(number), _) => number,
            (None, _) => {
                return refuse("a number with a decimal point, or nothing where it is missing");
            }
        };
        let si = si(column, number);
        self.look(column, number, si);
        match column.bounds {
            Some(bounds) if si < bounds.minimum || si > bounds.maximum => refuse(bounds.allowed),
            _ => Ok(si),
        }
    }

    /// The number in a cell of a log, in SI, NaN where it is missing; otherwise what stands there.
    pub(crate) fn logged(&self, column: &Column) -> Result<f64, String> {
        match self.written(column) {
            Some(number) if !number.is_infinite() => {
                let si = column.si(number);
                self.look(column, number, si);
                Ok(si)
            }
            Some(infinite) => Err(self.shown(column).unwrap_or_else(|| infinite.to_string())),
            None => Err(self.shown(column).unwrap_or_default()),
        }
    }

    /// The beginning of the text in a cell, where there is one.
    fn shown(&self, column: &Column) -> Option<String> {
        let text = self.text_in(column);
        (!text.is_empty()).then(|| text.chars().take(40).collect())
    }

    /// The error of a cell that holds something else than `allowed`.
    pub fn refuse(&self, quantity: Quantity, allowed: &'static str) -> TableError {
        let column = self.column(quantity);
        let number = column.and_then(|column| self.written(column)).filter(|n| !n.is_nan());
        let shown = column.and_then(|column| self.shown(column));
        let fault = Fault::Cell {
            place: self.place,
            column: column.map_or(quantity.name(), |c| &self.table.names[c.place]).to_owned(),
            value: shown.or_else(|| number.map(|n| n.to_string())).unwrap_or_default(),
            allowed,
        };
        TableError::of(self.table.path, fault)
    }
}

/// A word of a table, nothing where it is missing.
fn word(words: &StringArray, row: usize) -> &str {
    if words.is_null(row) { "" } else { words.value(row) }
}

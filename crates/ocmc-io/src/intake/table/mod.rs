//! Tables with named columns, from wherever they come, and one vocabulary for all of them.
//!
//! [`source`] says where a table comes from, [`quantity`] and [`unit`](mod@unit) what a column can
//! be called, [`schema`] which columns a format has, [`mapping`] what a user says about them, and
//! [`error`] what can be wrong. A format is a [`Schema`] and a function that takes its rows.

mod arrow_column;
mod bounded;
pub mod clock;
pub(crate) mod date;
mod decimal;
mod dwd;
pub mod error;
pub mod formats;
pub mod given;
pub mod mapping;
pub mod quantity;
mod row;
pub mod schema;
pub mod source;
pub mod spreadsheet;
pub mod unit;
mod word;
mod words;

pub use error::TableError;
pub use mapping::Mapping;
pub use quantity::Quantity;
pub use row::Row;
use schema::ambiguous;
pub use schema::{Column, Field, Schema, Style};
pub use source::Source;
pub use words::words;

use crate::intake::Finding;
use crate::intake::account::{FileAccount, ReadColumn};
use crate::intake::values::Watched;
use arrow_array::Float64Array;
use decimal::Decimals;
use error::{Fault, nearest};
use given::{Cells, GivenTable, RowPlace};
use row::{Header, RowCells};
use source::{Opened, Rows, TextRows, csv_error};
use std::cell::RefCell;
use std::path::{Path, PathBuf};

/// A table whose header has been read.
pub struct Table {
    path: PathBuf,
    schema: &'static Schema,
    /// Names of the columns as they are written.
    names: Vec<String>,
    columns: Vec<Column>,
    rows: Rows,
    /// Findings of the header.
    findings: Vec<Finding>,
}

impl Table {
    /// Reads the header of a table of a format.
    ///
    /// # Errors
    /// [`TableError`] where the table cannot be read, has no header, or has columns that are not
    /// clear.
    pub fn open(
        source: Source,
        schema: &'static Schema,
        mappings: &[Mapping],
    ) -> Result<Self, TableError> {
        let path = source.path().to_owned();
        let Opened { names, rows, findings } = source::open(source, schema.style)?;
        if names.iter().all(String::is_empty) {
            return Err(TableError::of(&path, Fault::Empty));
        }
        let columns = schema.find(&path, &names, mappings)?;
        Ok(Self { path, schema, names, columns, rows, findings })
    }

    /// Path of the table.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Names of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The columns that are understood.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The column of a quantity.
    pub fn column(&self, quantity: Quantity) -> Option<Column> {
        self.columns.iter().find(|column| column.quantity == quantity).copied()
    }

    /// Checks that these quantities are all there.
    ///
    /// # Errors
    /// [`Fault::Missing`].
    pub fn need(&self, quantities: &[Quantity]) -> Result<(), TableError> {
        let mut each = quantities.iter();
        each.try_for_each(|quantity| self.need_any(quantity.noun(), &[*quantity]).map(drop))
    }

    /// The column of the first of these quantities that is there.
    ///
    /// # Errors
    /// [`Fault::Missing`]; `what` is what is missing, in words.
    pub fn need_any(&self, what: &str, any_of: &[Quantity]) -> Result<Column, TableError> {
        let column = any_of.iter().find_map(|quantity| self.column(*quantity));
        column.ok_or_else(|| self.missing(what, any_of))
    }

    /// The column of the one of these quantities that is there.
    ///
    /// # Errors
    /// [`Fault::Ambiguous`] where there are two of them.
    pub fn one_of(&self, any_of: &[Quantity]) -> Result<Option<Column>, TableError> {
        let mut columns = any_of.iter().filter_map(|quantity| self.column(*quantity));
        match (columns.next(), columns.next()) {
            (Some(one), Some(other)) => Err(ambiguous(&self.path, &self.names, [one, other])),
            (one, _) => Ok(one),
        }
    }

    /// Error that none of these quantities is there; `what` names in words what is missing.
    pub fn missing(&self, what: &str, any_of: &[Quantity]) -> TableError {
        let fields = any_of.iter().filter_map(|quantity| self.schema.of(*quantity));
        let wanted: Vec<String> = fields.flat_map(Field::names).collect();
        let lacking = self.names.iter().find(|name| {
            let field = self.schema.lacking_unit(name);
            field.is_some_and(|field| any_of.contains(&field.quantity))
        });
        let hint = lacking.map(|name| format!(" (`{name}` has no known unit)"));
        let first = wanted.first().map_or("", String::as_str);
        let fault = Fault::Missing {
            what: format!("{what}{}", hint.unwrap_or_default()),
            example: format!("{first}={}", lacking.map_or("COLUMN", String::as_str)),
            found: self.names.join(", "),
            nearest: nearest(first, &self.names),
            wanted,
        };
        TableError::of(&self.path, fault)
    }

    /// Whether a quantity is there, be it in a unit that is not read.
    pub fn has(&self, quantity: Quantity) -> bool {
        self.column(quantity).is_some() || self.in_other_unit(quantity).is_some()
    }

    /// A column of a quantity in a unit that is not read.
    fn in_other_unit(&self, quantity: Quantity) -> Option<&String> {
        self.names.iter().find(|name| quantity.in_other_unit(&name.to_lowercase()))
    }

    /// Refuses a quantity of the format that is there in a unit that is not read, and in no other.
    ///
    /// # Errors
    /// [`Fault::Unit`].
    pub fn refuse_other_units(&self) -> Result<(), TableError> {
        for field in self.schema.fields {
            if self.column(field.quantity).is_none()
                && let Some(column) = self.in_other_unit(field.quantity)
            {
                let fault = Fault::Unit { column: column.clone(), allowed: field.names() };
                return Err(TableError::of(&self.path, fault));
            }
        }
        Ok(())
    }

    /// Refuses columns that the format does not have.
    ///
    /// # Errors
    /// [`Fault::Unknown`].
    pub fn refuse_others(&self) -> Result<(), TableError> {
        let known: Vec<String> = self.schema.fields.iter().flat_map(Field::names).collect();
        let understood = |place: usize| self.columns.iter().any(|column| column.place == place);
        let others = self.names.iter().enumerate().filter(|(place, _)| !understood(*place));
        let named = others.map(|(_, name)| (name.clone(), nearest(&name.to_lowercase(), &known)));
        let columns: Vec<_> = named.collect();
        if columns.is_empty() || self.is_export() {
            return Ok(());
        }
        let fault = Fault::Unknown { columns, allowed: known.join(", ") };
        Err(TableError::of(&self.path, fault))
    }

    /// The names of the columns that the format has.
    pub fn allowed(&self) -> String {
        let known: Vec<String> = self.schema.fields.iter().flat_map(Field::names).collect();
        known.join(", ")
    }

    /// Whether its columns are those of a format, and nobody chose them.
    pub(crate) fn is_export(&self) -> bool {
        self.given().is_some_and(GivenTable::is_export)
    }

    /// The table of a calling program, where it is one.
    pub(crate) fn given(&self) -> Option<&GivenTable> {
        match &self.rows {
            Rows::Given(table) => Some(table),
            Rows::Text(_) => None,
        }
    }

    /// Calls `use_row` with each row, and says what was read.
    ///
    /// # Errors
    /// [`Fault::NoRows`], or the first row that cannot be read, or that `use_row` refuses.
    pub fn for_each(
        self,
        mut use_row: impl FnMut(&Row) -> Result<(), TableError>,
    ) -> Result<FileAccount, TableError> {
        let mut account = self.account();
        let is_export = self.is_export();
        let Self { path, schema, names, columns, rows, mut findings } = self;
        account.findings.append(&mut findings);
        let watched = RefCell::new(vec![Watched::default(); columns.len()]);
        let (path_of, style) = (&path, schema.style);
        let decimals = match &rows {
            Rows::Text(rows) => Decimals::new(rows.has_commas_free),
            Rows::Given(_) => Decimals::default(),
        };
        let (names_of, columns_of) = (&names, &columns);
        let header = Header {
            path: path_of,
            names: names_of,
            columns: columns_of,
            style,
            watched,
            decimals,
            missing: dwd::missing(names_of),
            is_export,
        };
        let rows = match rows {
            Rows::Text(rows) => header.each_of_text(rows, use_row)?,
            Rows::Given(table) => {
                header.check_size(table.rows())?;
                let cells = cells(&table, &columns, schema.style)?;
                for row in 0..table.rows() {
                    let place = RowPlace::Row(row as u64 + 1);
                    use_row(&Row { table: &header, place, cells: RowCells::Given(&cells, row) })?;
                }
                table.rows()
            }
        };
        if rows == 0 {
            return Err(TableError::of(&path, Fault::NoRows));
        }
        account.rows = rows;
        account.findings.extend(header.decimals.finding());
        let watched = header.watched.into_inner();
        let judge = |(column, watched): (&Column, Watched)| {
            watched.judge(&names[column.place], column, style)
        };
        account.judged(&path, columns.iter().zip(watched).filter_map(judge))?;
        Ok(account)
    }

    /// Account of the columns and their quantities.
    fn account(&self) -> FileAccount {
        let read = |column: &Column| ReadColumn {
            name: self.names[column.place].clone(),
            quantity: column.quantity.name(),
            unit: column.unit.suffix,
        };
        let understood = |place: usize| self.columns.iter().any(|column| column.place == place);
        let others = self.names.iter().enumerate().filter(|(place, _)| !understood(*place));
        FileAccount {
            file: self.path.display().to_string(),
            columns: self.columns.iter().map(read).collect(),
            left_out: others.map(|(_, name)| name.clone()).collect(),
            ..FileAccount::default()
        }
    }

    /// The numbers of some quantities, all of which are needed, in SI.
    ///
    /// # Errors
    /// As [`Table::for_each`], [`Fault::Missing`] and [`Fault::Cell`].
    pub fn numbers<const N: usize>(
        self,
        quantities: [Quantity; N],
    ) -> Result<[Vec<f64>; N], TableError> {
        self.need(&quantities)?;
        let mut numbers = [const { Vec::new() }; N];
        self.for_each(|row| {
            for (quantity, numbers) in quantities.into_iter().zip(&mut numbers) {
                numbers.push(row.number(quantity)?);
            }
            Ok(())
        })?;
        Ok(numbers)
    }
}

impl Header<'_> {
    /// Whether a row has the cells of all columns that are understood; what is beyond the names has
    /// to be empty.
    fn has_its_cells(&self, record: &csv::StringRecord) -> bool {
        let (found, wanted) = (record.len(), self.names.len());
        let last = self.columns.iter().map(|column| column.place).max().unwrap_or(wanted);
        found == wanted
            || (self.style == Style::Description
                && found > last
                && record.iter().skip(wanted).all(str::is_empty))
    }

    /// Most rows: each keeps its numbers in memory.
    fn check_size(&self, rows: usize) -> Result<(), TableError> {
        let most = if self.style == Style::Log { 100_000_000 } else { 20_000_000 };
        if rows <= most {
            return Ok(());
        }
        Err(TableError::of(self.path, Fault::TooLarge(format!("{most} rows"))))
    }

    /// Number of rows.
    fn each_of_text(
        &self,
        mut rows: TextRows,
        mut use_row: impl FnMut(&Row) -> Result<(), TableError>,
    ) -> Result<usize, TableError> {
        let mut record = csv::StringRecord::new();
        let mut count = 0;
        loop {
            let read = match rows.first.take() {
                Some(first) => first.map(|first| {
                    record = first;
                    true
                }),
                None => rows.reader.read_record(&mut record),
            };
            match read {
                Ok(false) => return Ok(count),
                Ok(true) => {}
                Err(error) => {
                    let line = rows.line(&csv::StringRecord::new());
                    return Err(csv_error(self.path, error, line));
                }
            }
            let place = RowPlace::Line(rows.line(&record));
            if self.style != Style::Log && !self.has_its_cells(&record) {
                let (found, wanted) = (record.len(), self.names.len());
                return Err(TableError::of(self.path, Fault::Cells { place, found, wanted }));
            }
            count += 1;
            self.check_size(count)?;
            let cells = RowCells::Text(&record);
            use_row(&Row { table: self, place, cells })?;
        }
    }
}

/// The cells of the columns that are understood, by their places.
fn cells(
    table: &GivenTable,
    columns: &[Column],
    style: Style,
) -> Result<Vec<Option<Cells>>, TableError> {
    let mut cells = vec![None; table.names().len()];
    for column in columns {
        // of a description numbers of 32 bits are the decimals that they were written from
        let words = style == Style::Description || column.quantity.is_text();
        cells[column.place] = Some(if words {
            Cells::Words(table.words(column.place)?)
        } else {
            table.cells(column.place)?
        });
    }
    Ok(cells)
}

/// The numbers of a column of a given table as they stand, and whether each one is such that they
/// can be used so: in SI and not infinite.
pub(crate) fn unchanged(table: &GivenTable, column: &Column) -> Option<Float64Array> {
    match table.cells(column.place) {
        Ok(Cells::Numbers(numbers)) if column.is_si() => {
            (!numbers.values().iter().any(|number| number.is_infinite())).then_some(numbers)
        }
        _ => None,
    }
}

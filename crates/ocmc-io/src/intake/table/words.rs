//! A table whose columns no format knows: all of it as texts.

use super::error::{Fault, TableError};
use super::given::RowPlace;
use super::schema::Style;
use super::source::{Opened, Rows, Source, TextRows, csv_error, open};
use arrow_array::{Array, StringArray};
use std::path::Path;

/// The names of the columns, and the rows of their cells; what is missing is empty.
///
/// # Errors
/// [`TableError`] where it cannot be read, has no rows, or a row has another number of cells.
pub fn words(source: Source) -> Result<(Vec<String>, Vec<Vec<String>>), TableError> {
    let path = source.path();
    let Opened { names, rows, .. } = open(source, Style::Description)?;
    let rows = match rows {
        Rows::Text(rows) => of_text(path, rows, names.len())?,
        Rows::Given(table) => {
            let columns = (0..names.len()).map(|column| table.words(column));
            let columns = columns.collect::<Result<Vec<_>, _>>()?;
            let row = |row: usize| {
                let cell = |column: &StringArray| {
                    if column.is_valid(row) { column.value(row).to_owned() } else { String::new() }
                };
                columns.iter().map(cell).collect()
            };
            (0..table.rows()).map(row).collect()
        }
    };
    if rows.is_empty() {
        return Err(TableError::of(path, Fault::NoRows));
    }
    Ok((names, rows))
}

fn of_text(path: &Path, mut rows: TextRows, wanted: usize) -> Result<Vec<Vec<String>>, TableError> {
    let mut read = Vec::new();
    while let Some(row) = rows.first.take().or_else(|| rows.reader.records().next()) {
        let line = rows.reader.position().line();
        let row = row.map_err(|error| csv_error(path, error, line))?;
        if row.len() != wanted {
            let place = RowPlace::Line(rows.line(&row));
            return Err(TableError::of(path, Fault::Cells { place, found: row.len(), wanted }));
        }
        read.push(row.iter().map(str::to_owned).collect());
    }
    Ok(read)
}

//! Logs that a calling program holds as tables.

use super::drives::Trips;
use super::error::LogFileError;
use super::mapping::{Mapping, QuantityColumn};
use super::quantity::Label;
use super::{LogFile, Need, Unreadable, ended, number, opened};
use crate::given_table::{Cells, GivenTable, RowPlace};
use arrow_array::{Array, Float64Array, StringArray};

/// Reads a table as [`super::read`] reads a file. A column in SI units that [`GivenTable`] does not copy is not copied here
/// either, as long as the table holds a single drive and no infinite number.
///
/// # Errors
/// As [`super::read`].
pub fn read_table(
    table: &GivenTable,
    mappings: &[Mapping],
    needs: &[Need],
) -> Result<LogFile, LogFileError> {
    if table.names().is_empty() {
        return Err(LogFileError::Empty { path: table.path().to_owned() });
    }
    let header: Vec<String> = table.names().iter().map(|name| name.trim().to_owned()).collect();
    let mut file = opened(table.path(), &header, mappings, needs)?;
    file.rows = table.rows();
    let mut drives = Trips::new(table.path());
    let places = places(table, &file, &mut drives)?;
    let one = places.iter().all(|place| *place == 0);
    let mut columns = Vec::with_capacity(file.columns.quantities.len());
    for column in &file.columns.quantities {
        columns.push(values(table, column, &mut file.unreadable)?);
    }
    let quantities = &file.columns.quantities;
    for (which, index) in &file.columns.words {
        let words = table.words(*index)?;
        for row in 0..file.rows {
            let word = if words.is_null(row) { "" } else { words.value(row).trim() };
            drives.push_word(places.get(row).copied().unwrap_or(0), *which, word);
        }
    }
    file.drives = if one {
        drives.finish_one(quantities.iter().map(|column| column.quantity).zip(columns))
    } else {
        for (k, column) in columns.iter().enumerate() {
            for (value, drive) in column.values().iter().zip(&places) {
                drives.push(*drive, k, *value);
            }
        }
        drives.finish(quantities)
    };
    ended(file, needs)
}

/// Which drive each row is of; of a table without labels the first row's, which is that of all.
fn places(
    table: &GivenTable,
    file: &LogFile,
    drives: &mut Trips,
) -> Result<Vec<usize>, LogFileError> {
    let mut labels: [Option<StringArray>; 3] = [None, None, None];
    for (which, words) in Label::ALL.into_iter().zip(&mut labels) {
        *words = file.columns.label(which).map(|index| table.words(index)).transpose()?;
    }
    let word = |words: &Option<StringArray>, row: usize| {
        let words = words.as_ref().filter(|words| !words.is_null(row));
        words.map_or("", |words| words.value(row).trim()).to_owned()
    };
    let rows = if labels.iter().all(Option::is_none) { file.rows.min(1) } else { file.rows };
    Ok((0..rows).map(|row| drives.place(labels.each_ref().map(|words| word(words, row)))).collect())
}

/// The values of a quantity in SI, NaN where there is none.
fn values(
    table: &GivenTable,
    column: &QuantityColumn,
    unreadable: &mut Vec<Unreadable>,
) -> Result<Float64Array, LogFileError> {
    let place = |row: usize| RowPlace::Row(row as u64 + 1);
    let numbers = match table.cells(column.index)? {
        Cells::Numbers(numbers) => numbers,
        Cells::Words(words) => {
            let cells = words.iter().map(Option::unwrap_or_default).enumerate();
            let numbers = cells.map(|(k, cell)| number(unreadable, &column.name, cell, place(k)));
            Float64Array::from_iter_values(numbers)
        }
    };
    if column.factor == 1.0 && !numbers.values().iter().any(|number| number.is_infinite()) {
        return Ok(numbers);
    }
    let scaled = numbers.values().iter().enumerate().map(|(k, value)| {
        let value = if value.is_infinite() {
            number(unreadable, &column.name, &value.to_string(), place(k))
        } else {
            *value
        };
        column.factor * value
    });
    Ok(Float64Array::from_iter_values(scaled))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::quantity::Quantity;
    use crate::log::{LoggedTrip, read_text};
    use arrow_array::ArrayRef;
    use std::path::Path;
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
        let file = read_table(&table, &[], &[]).expect("a log");
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
        let by_table = read_table(&table(&columns), &[], &[]).expect("a log");
        let by_text = read_text(Path::new("log"), text.as_bytes(), &[], &[]).expect("a log");
        let shown = |drives: &[LoggedTrip]| format!("{drives:?}");
        assert_eq!(shown(&by_table.drives), shown(&by_text.drives));
        assert_eq!((by_table.rows, by_table.drives.len()), (4, 2));
        let unreadable = &by_table.unreadable[0];
        assert_eq!((unreadable.cells, unreadable.text.as_str()), (2, "inf"));
        assert_eq!(unreadable.place, RowPlace::Row(2));
        assert_eq!(by_text.unreadable[0].place, RowPlace::Line(3));
    }

    #[test]
    fn what_is_wrong_is_said() {
        let error = |columns: &[(&str, ArrayRef)]| {
            read_table(&table(columns), &[], &[]).expect_err("wrong").to_string()
        };
        assert!(error(&[]).contains("`log` is empty"));
        assert!(error(&[("time_s", numbers(&[]))]).contains("no rows"));
    }
}

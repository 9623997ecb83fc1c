//! Sheets of a workbook. Cells stay where they are, so that messages name their rows; numbers are
//! those that are stored, whatever the sheet shows of them, and dates become stamps.

use super::Content;
use super::workbook::MOST_BYTES;
use crate::intake::Finding;
use calamine::{Data, Reader, Xlsx, open_workbook_from_rs};
use std::io::Cursor;

/// Most rows and columns of a sheet.
const MOST_ROWS: u32 = 1_048_576;
const MOST_COLUMNS: u32 = 400;

/// Reads the first sheet of a workbook that has a table.
pub(super) fn read(bytes: &[u8]) -> Result<Content, String> {
    let broken = |error: calamine::XlsxError| format!("cannot be read: {error}");
    let mut book: Xlsx<_> = open_workbook_from_rs(Cursor::new(bytes)).map_err(broken)?;
    let names = book.sheet_names();
    for (k, name) in names.iter().enumerate() {
        let Some(cells) = cells_of(&mut book, name)? else { continue };
        let others = names.len() - 1;
        let text = match others {
            0 => format!("sheet `{name}`"),
            _ => format!(
                "sheet `{name}`, number {} of {}: the others are left out",
                k + 1,
                names.len()
            ),
        };
        return Ok(Content::Cells(cells, vec![Finding::noted("sheet", [1.0, 0.0], text, "")]));
    }
    Err("has no sheet with a row of names and rows below it".to_owned())
}

/// A sheet as separated cells; none where it has fewer than two rows of several cells.
fn cells_of(book: &mut Xlsx<Cursor<&[u8]>>, sheet: &str) -> Result<Option<String>, String> {
    let broken = |error: calamine::XlsxError| format!("has a sheet that cannot be read: {error}");
    // charts are sheets without cells
    let Ok(mut cells) = book.worksheet_cells_reader(sheet) else { return Ok(None) };
    let (mut text, mut row, mut line) = (String::new(), 0_u32, Vec::<String>::new());
    let (mut tables, mut widest) = (0, 0);
    let mut finish = |line: &mut Vec<String>, text: &mut String| {
        // cells that are empty at the end of a row are not in the file
        widest = widest.max(line.len());
        if !line.is_empty() {
            line.resize(widest, String::new());
        }
        tables += u32::from(line.iter().filter(|cell| !cell.is_empty()).count() > 1);
        for (k, cell) in line.drain(..).enumerate() {
            if k > 0 {
                text.push(',');
            }
            text.push_str(&cell);
        }
        text.push('\n');
    };
    while let Some(cell) = cells.next_cell().map_err(broken)? {
        let (at_row, column) = cell.get_position();
        let value = written(&Data::from(cell.get_value().clone()));
        if value.is_empty() {
            continue;
        }
        if at_row >= MOST_ROWS || column >= MOST_COLUMNS {
            return Err(format!(
                "has a cell in row {}, column {}; allowed are {MOST_ROWS} rows and {MOST_COLUMNS} \
                 columns",
                at_row + 1,
                column + 1
            ));
        }
        if at_row < row {
            return Err("has rows out of order".to_owned());
        }
        while row < at_row {
            finish(&mut line, &mut text);
            row += 1;
        }
        if text.len() as u64 > MOST_BYTES {
            return Err(format!("has a sheet of more than {MOST_BYTES} bytes"));
        }
        let column = column as usize;
        if line.len() <= column {
            line.resize(column + 1, String::new());
        }
        line[column] = value;
    }
    finish(&mut line, &mut text);
    Ok((tables > 1).then_some(text))
}

/// A cell as it stands in a table of separated cells.
fn written(cell: &Data) -> String {
    let text = match cell {
        Data::Float(number) => return number.to_string(),
        Data::Int(number) => return number.to_string(),
        Data::Bool(flag) => return flag.to_string(),
        Data::DateTime(stamp) => return stamp_of(stamp.as_f64(), stamp.is_duration()),
        Data::DateTimeIso(text) | Data::DurationIso(text) | Data::String(text) => text.trim(),
        Data::Empty | Data::Error(_) => return String::new(),
    };
    if text.contains([',', '"', '\n', '\r']) {
        return format!("\"{}\"", text.replace('"', "\"\"").replace(['\n', '\r'], " "));
    }
    text.to_owned()
}

/// A stamp of days since the last day of 1899, to a thousandth of a second; below a day a time of
/// the day.
fn stamp_of(days: f64, is_duration: bool) -> String {
    let second = (days * 86_400_000.0).round() / 1000.0;
    if is_duration {
        return second.to_string();
    }
    let clock = |second: f64| {
        let (hour, minute) = (second / 3600.0, second / 60.0);
        let rest = second % 60.0;
        let rest = if rest.fract() == 0.0 { format!("{rest:02}") } else { format!("{rest:06.3}") };
        format!("{:02}:{:02}:{rest}", hour.floor(), minute.floor() % 60.0)
    };
    if (0.0..1.0).contains(&days) {
        return clock(second);
    }
    let day = (second / 86_400.0).floor();
    let date = jiff::civil::date(1899, 12, 30);
    let date = date.checked_add(jiff::Span::new().try_days(day as i64).unwrap_or_default());
    match date {
        Ok(date) if second % 86_400.0 == 0.0 => date.to_string(),
        Ok(date) => format!("{date}T{}", clock(second - 86_400.0 * day)),
        Err(_) => days.to_string(),
    }
}

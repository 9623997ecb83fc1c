//! A sheet as XML: rows of cells below a header that stays in sight.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::{self, Write};

/// Most rows of a sheet.
pub(super) const MOST_ROWS: u64 = 1_048_576;
/// Most characters of a cell.
pub(super) const MOST_CHARACTERS: usize = 32_767;

/// Text that is gathered before it is compressed, in bytes.
const GATHERED: usize = 1 << 16;
/// Widths of columns, in characters.
const WIDTHS: [usize; 2] = [9, 60];
/// The largest integer up to which a number of a spreadsheet holds each.
const LARGEST_INTEGER: u64 = 1 << 53;

/// Content of a cell. A text stays one, whatever it looks like: no cell is a formula.
pub(super) enum Cell<'a> {
    Empty,
    Number(f64),
    Integer(u64),
    Text(Cow<'a, str>),
}

impl From<Option<f64>> for Cell<'_> {
    fn from(number: Option<f64>) -> Self {
        number.map_or(Self::Empty, Self::Number)
    }
}

impl From<f64> for Cell<'_> {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<u64> for Cell<'_> {
    fn from(number: u64) -> Self {
        Self::Integer(number)
    }
}

impl<'a> From<&'a str> for Cell<'a> {
    fn from(text: &'a str) -> Self {
        Self::Text(text.into())
    }
}

impl From<String> for Cell<'_> {
    fn from(text: String) -> Self {
        Self::Text(text.into())
    }
}

/// A sheet that is being written.
pub(super) struct Sheet<W: Write> {
    out: W,
    text: String,
    /// Letters of the columns.
    letters: Vec<String>,
    row: u64,
}

impl<W: Write> Sheet<W> {
    /// Begins a sheet with the names of its columns, which are `widths` wide where their names are
    /// not wider. The first one is `shown` when the workbook is opened.
    pub(super) fn begin<'a>(
        out: W,
        names: impl IntoIterator<Item = &'a str>,
        widths: &[usize],
        shown: bool,
    ) -> io::Result<Self> {
        let names: Vec<&str> = names.into_iter().collect();
        let letters = (0..names.len()).map(letters).collect();
        let mut sheet = Self { out, text: String::new(), letters, row: 0 };
        let selected = if shown { " tabSelected=\"1\"" } else { "" };
        let _ = write!(
            sheet.text,
            "{HEAD}<worksheet xmlns=\"{MAIN}\"><sheetViews><sheetView{selected} \
             workbookViewId=\"0\"><pane ySplit=\"1\" topLeftCell=\"A2\" activePane=\"bottomLeft\" \
             state=\"frozen\"/></sheetView></sheetViews><cols>"
        );
        for (k, name) in names.iter().enumerate() {
            let wide = widths.get(k).copied().unwrap_or_default().max(name.chars().count() + 2);
            let wide = wide.clamp(WIDTHS[0], WIDTHS[1]);
            let k = k + 1;
            let _ = write!(
                sheet.text,
                "<col min=\"{k}\" max=\"{k}\" width=\"{wide}\" customWidth=\"1\"/>"
            );
        }
        sheet.text.push_str("</cols><sheetData>");
        sheet.add(names.into_iter().map(Cell::from), " s=\"1\"")?;
        Ok(sheet)
    }

    /// Writes a row.
    pub(super) fn row<'a>(&mut self, cells: impl IntoIterator<Item = Cell<'a>>) -> io::Result<()> {
        self.add(cells, "")
    }

    fn add<'a>(
        &mut self,
        cells: impl IntoIterator<Item = Cell<'a>>,
        style: &str,
    ) -> io::Result<()> {
        self.row += 1;
        let (row, text) = (self.row, &mut self.text);
        let _ = write!(text, "<row r=\"{row}\">");
        for (cell, column) in cells.into_iter().zip(&self.letters) {
            let number = match cell {
                Cell::Number(number) if number.is_finite() => format!("{number:?}"),
                Cell::Integer(number) if number <= LARGEST_INTEGER => number.to_string(),
                // the digits of a larger one stand in a text
                Cell::Integer(number) => {
                    add_text(text, (column, row, style), &number.to_string());
                    continue;
                }
                Cell::Text(words) => {
                    add_text(text, (column, row, style), &words);
                    continue;
                }
                Cell::Empty | Cell::Number(_) => continue,
            };
            let _ = write!(text, "<c r=\"{column}{row}\"{style}><v>{number}</v></c>");
        }
        text.push_str("</row>");
        if text.len() >= GATHERED {
            self.out.write_all(text.as_bytes())?;
            text.clear();
        }
        Ok(())
    }

    /// Ends the sheet.
    pub(super) fn end(mut self) -> io::Result<W> {
        self.text.push_str("</sheetData></worksheet>");
        self.out.write_all(self.text.as_bytes())?;
        Ok(self.out)
    }
}

/// The head of each part.
pub(super) const HEAD: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"yes\"?>\n";
/// The language of workbooks.
pub(super) const MAIN: &str = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";

/// Letters of a column, from 0.
fn letters(mut column: usize) -> String {
    let mut text = String::new();
    loop {
        text.insert(0, char::from(b'A' + (column % 26) as u8));
        match (column / 26).checked_sub(1) {
            Some(rest) => column = rest,
            None => return text,
        }
    }
}

/// Writes a cell of text, as far as a cell holds it.
fn add_text(xml: &mut String, (column, row, style): (&str, u64, &str), text: &str) {
    let _ =
        write!(xml, "<c r=\"{column}{row}\"{style} t=\"inlineStr\"><is><t xml:space=\"preserve\">");
    for (place, letter) in text.char_indices().take(MOST_CHARACTERS) {
        match letter {
            '&' => xml.push_str("&amp;"),
            '<' => xml.push_str("&lt;"),
            '>' => xml.push_str("&gt;"),
            '"' => xml.push_str("&quot;"),
            '\t' | '\n' => xml.push(letter),
            // what looks like a letter that is spelled out begins with one that is
            '_' if is_spelled(&text[place..]) => xml.push_str("_x005F_"),
            // XML has no such letter: a workbook spells it out
            '\0'..' ' | '\u{fffe}' | '\u{ffff}' => {
                let _ = write!(xml, "_x{:04X}_", u32::from(letter));
            }
            _ => xml.push(letter),
        }
    }
    xml.push_str("</t></is></c>");
}

/// Whether a text begins as a letter that a workbook spells out, such as `_x000D_`.
fn is_spelled(text: &str) -> bool {
    let bytes = text.as_bytes();
    bytes.len() >= 7
        && bytes.starts_with(b"_x")
        && bytes[2..6].iter().all(u8::is_ascii_hexdigit)
        && bytes[6] == b'_'
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_have_letters() {
        let all = [0, 25, 26, 51, 52, 701, 702, 16383].map(letters);
        assert_eq!(all, ["A", "Z", "AA", "AZ", "BA", "ZZ", "AAA", "XFD"]);
    }

    #[test]
    fn texts_are_escaped_and_cut() {
        let written = |text: &str| {
            let mut xml = String::new();
            add_text(&mut xml, ("A", 1, ""), text);
            let (_, rest) = xml.split_once("\"preserve\">").unwrap();
            rest.strip_suffix("</t></is></c>").unwrap().to_owned()
        };
        for (text, xml) in [
            ("=1+1", "=1+1"),
            ("a<b & \"c\">", "a&lt;b &amp; &quot;c&quot;&gt;"),
            ("a\r\u{1b}\n", "a_x000D__x001B_\n"),
            ("_x0041_ _x41_", "_x005F_x0041_ _x41_"),
        ] {
            assert_eq!(written(text), xml);
        }
        assert_eq!(written(&"ä".repeat(40_000)).chars().count(), MOST_CHARACTERS);
    }
}

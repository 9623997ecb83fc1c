//! Where a table comes from: a file of separated cells, plain or compressed by gzip or zstd, a
//! Parquet file, a text, or a table that a calling program holds.

use super::bounded::Bounded;
use super::error::{Fault, TableError};
use super::given::GivenTable;
use super::schema::Style;
use super::unit;
use crate::input_file;
use crate::intake::Finding;
use crate::intake::format::{self, Content, Format};
use crate::records::parquet::columns;
use flate2::read::MultiGzDecoder;
use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read};
use std::path::Path;

/// Largest description, in bytes: it is read as a whole.
const MOST_BYTES: u64 = 256 << 20;

/// Where a table comes from.
#[derive(Clone, Copy, Debug)]
pub enum Source<'a> {
    /// A file.
    File(&'a Path),
    /// A text that is called so in messages.
    Text(&'a Path, &'a str),
    /// A table of a calling program.
    Given(&'a GivenTable),
}

impl Source<'_> {
    /// Path of the source.
    pub fn path(&self) -> &Path {
        match self {
            Self::File(path) | Self::Text(path, _) => path,
            Self::Given(table) => table.path(),
        }
    }
}

/// Names of the columns as they are written, and rows that have not been read.
pub(super) struct Opened {
    pub(super) names: Vec<String>,
    pub(super) rows: Rows,
    /// Findings so far.
    pub(super) findings: Vec<Finding>,
}

/// Where the rows come from.
pub(super) enum Rows {
    Text(TextRows),
    Given(GivenTable),
}

/// Rows of separated cells.
pub(super) struct TextRows {
    pub(super) reader: csv::Reader<Box<dyn Read>>,
    /// Whether a line ends before its line feed, which then is that of the next one.
    crlf: bool,
    /// Lines of a title, which stand before the names.
    title_lines: u64,
    /// A row that was looked at already.
    pub(super) first: Option<Result<csv::StringRecord, csv::Error>>,
    /// Whether cells are separated by something else than a comma, which then may be a decimal one.
    pub(super) has_commas_free: bool,
}

impl TextRows {
    /// The line of the record that has been read, from 1.
    pub(super) fn line(&self, record: &csv::StringRecord) -> u64 {
        // where the record begins its position still is that of the comments and empty lines before
        // it
        let inside = record.as_slice().bytes().filter(|byte| *byte == b'\n').count() as u64;
        let line = self.reader.position().line() + self.title_lines - inside;
        line.saturating_sub(u64::from(!self.crlf))
    }
}

/// Reads the header of a table.
pub(super) fn open(source: Source, style: Style) -> Result<Opened, TableError> {
    let path = source.path();
    let failed = TableError::read(path);
    match source {
        Source::Given(table) => Ok(given(table.clone())),
        Source::Text(_, text) if style == Style::Description => {
            of_text(path, in_memory(text), style)
        }
        Source::Text(_, text) => of_text(path, Box::new(Cursor::new(text.to_owned())), style),
        Source::File(_) => {
            let mut file = BufReader::new(input_file::open(path).map_err(failed)?);
            if file.fill_buf().map_err(failed)?.starts_with(b"PAR1") {
                return parquet(path);
            }
            let file_bytes = file.get_ref().metadata().map_err(failed)?.len();
            let (text, is_compressed) = decompressed(file).map_err(failed)?;
            let mut text = BufReader::with_capacity(format::LOOKED_AT.max(1 << 16), text);
            let start = text.fill_buf().map_err(failed)?;
            if let Some(format) = format::recognise(start) {
                return of_format(path, format, text, style);
            }
            if is_other_format(start) {
                return Err(TableError::of(path, Fault::NotSeparated));
            }
            let text: Box<dyn Read> = if style == Style::Description {
                in_memory(&text_of(path, text)?)
            } else {
                Box::new(Bounded::new(text, file_bytes, is_compressed))
            };
            of_text(path, text, style)
        }
    }
}

/// Reads a file of another format as the table that it is.
fn of_format(
    path: &Path,
    format: &Format,
    content: impl Read,
    style: Style,
) -> Result<Opened, TableError> {
    let bytes = whole(path, content)?;
    let read = format.read(path, &bytes);
    let wrong = |reason| TableError::of(path, Fault::OfFormat(reason));
    match read.map_err(wrong)? {
        Content::Columns(table, findings) => Ok(Opened { findings, ..given(table) }),
        Content::Cells(text, mut findings) => {
            let text: Box<dyn Read> = if style == Style::Description {
                in_memory(&text)
            } else {
                Box::new(Cursor::new(text))
            };
            let mut opened = of_text(path, text, style)?;
            findings.append(&mut opened.findings);
            Ok(Opened { findings, ..opened })
        }
    }
}

/// Whether a file is a track in XML or in JSON, or an archive by its first bytes.
fn is_other_format(start: &[u8]) -> bool {
    let start = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start).trim_ascii_start();
    let marks: [&[u8]; 4] = [b"<?xml", b"{", b"PK\x03\x04", b"\xd0\xcf\x11\xe0"];
    marks.iter().any(|mark| start.starts_with(mark))
}

/// A text without the comments and the blanks of empty lines, whose ends stay.
fn in_memory(text: &str) -> Box<dyn Read> {
    let aside = |line: &str| line.trim().is_empty() || line.trim_start().starts_with('#');
    let lines = text.lines().map(|line| if aside(line) { "" } else { line });
    Box::new(Cursor::new(lines.flat_map(|line| [line, "\n"]).collect::<String>()))
}

/// A file as text; what is not UTF-8 is read as Latin-1.
pub fn read_text(path: &Path) -> Result<String, TableError> {
    let failed = TableError::read(path);
    let file = BufReader::new(input_file::open(path).map_err(failed)?);
    text_of(path, decompressed(file).map_err(failed)?.0)
}

/// All bytes of a file, which are bounded.
fn whole(path: &Path, content: impl Read) -> Result<Vec<u8>, TableError> {
    let mut bytes = Vec::new();
    content.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(TableError::read(path))?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(TableError::of(path, Fault::TooLarge(format!("{MOST_BYTES} bytes"))));
    }
    Ok(bytes)
}

fn text_of(path: &Path, content: impl Read) -> Result<String, TableError> {
    let bytes = whole(path, content)?;
    if is_utf16(&bytes) {
        return Err(TableError::of(path, Fault::Utf16));
    }
    let text = match String::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => error.into_bytes().into_iter().map(char::from).collect(),
    };
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

/// Whether a text begins as UTF-16 does: with its mark, or with a letter of which one byte is 0.
fn is_utf16(bytes: &[u8]) -> bool {
    matches!(bytes, [0xff, 0xfe, ..] | [0xfe, 0xff, ..] | [0, 1..=255, ..] | [1..=255, 0, ..])
}

/// The text of a file that may be compressed by gzip or zstd, and whether it is.
fn decompressed(mut file: BufReader<File>) -> std::io::Result<(Box<dyn Read>, bool)> {
    let start = file.fill_buf()?;
    Ok(if start.starts_with(&[0x1f, 0x8b]) {
        (Box::new(MultiGzDecoder::new(file)), true)
    } else if start.starts_with(&[0x28, 0xb5, 0x2f, 0xfd]) {
        (unpacked(file)?, true)
    } else {
        (Box::new(file), false)
    })
}

/// The text of a file that is compressed by zstd.
#[cfg(feature = "files")]
fn unpacked(file: BufReader<File>) -> std::io::Result<Box<dyn Read>> {
    Ok(Box::new(zstd::Decoder::with_buffer(file)?))
}

/// Refuses a file that is compressed by zstd.
#[cfg(not(feature = "files"))]
fn unpacked(_file: BufReader<File>) -> std::io::Result<Box<dyn Read>> {
    Err(std::io::Error::other("this program is built without zstd; compress it by gzip, or not"))
}

fn of_text(path: &Path, text: Box<dyn Read>, style: Style) -> Result<Opened, TableError> {
    let mut text = BufReader::new(text);
    let failed = TableError::read(path);
    let start = text.fill_buf().map_err(failed)?;
    if start.is_empty() {
        return Err(TableError::of(path, Fault::Empty));
    }
    if is_utf16(start) {
        return Err(TableError::of(path, Fault::Utf16));
    }
    let feed = start.iter().position(|byte| *byte == b'\n').unwrap_or(0);
    let crlf = feed > 0 && start[feed - 1] == b'\r';
    let mut mended = Vec::new();
    let title = title(start);
    if let Some((_, title)) = &title {
        let text = format!("the first line, `{title}`, is a title: the names stand below it");
        mended.push(Finding::mended("title-line", [1.0, 0.0], text));
    }
    let title_lines = u64::from(title.is_some());
    if let Some((bytes, _)) = title {
        text.consume(bytes);
    }
    let separator = separator(text.fill_buf().map_err(failed)?);
    // a last line without an end would be counted as none
    let end: &[u8] = if crlf { b"\r\n" } else { b"\n" };
    let text: Box<dyn Read> = Box::new(text.chain(end));
    let log = style == Style::Log;
    let mut reader = csv::ReaderBuilder::new()
        .flexible(true)
        .trim(if log { csv::Trim::None } else { csv::Trim::All })
        .comment((!log).then_some(b'#'))
        .delimiter(separator)
        .from_reader(text);
    let header = reader.headers().map_err(|error| csv_error(path, error, 1))?;
    let name = |name: &str| name.trim_start_matches('\u{feff}').trim().to_owned();
    let mut names: Vec<String> = header.iter().map(name).collect();
    let has_commas_free = separator != b',';
    let mut rows = TextRows { reader, crlf, title_lines, first: None, has_commas_free };
    let first = rows.reader.records().next();
    let units = first.as_ref().and_then(|row| with_units_of(&names, row.as_ref().ok()?));
    if let Some(with_units) = units {
        names = with_units;
        let text = "the row below the names has their units".to_owned();
        mended.push(Finding::mended("units-row", [1.0, 0.0], text));
    } else {
        rows.first = first;
    }
    Ok(Opened { names, rows: Rows::Text(rows), findings: mended })
}

fn given(table: GivenTable) -> Opened {
    let names = table.names().iter().map(|name| name.trim().to_owned()).collect();
    Opened { names, rows: Rows::Given(table), findings: Vec::new() }
}

fn parquet(path: &Path) -> Result<Opened, TableError> {
    let failed = TableError::read(path);
    let file = input_file::open(path).map_err(failed)?;
    let columns = columns(file).map_err(|reason| TableError::of(path, Fault::NoTable(reason)));
    let (names, pieces) = columns?;
    Ok(given(GivenTable::new(&path.to_string_lossy(), names, pieces)))
}

/// Error of the csv crate, with the line that was being read.
pub(super) fn csv_error(path: &Path, error: csv::Error, line: u64) -> TableError {
    let fault = match error.into_kind() {
        csv::ErrorKind::Io(source) => Fault::Read(source),
        csv::ErrorKind::Utf8 { .. } => Fault::NotUtf8(line),
        other => Fault::NoTable(format!("{other:?}")),
    };
    TableError::of(path, fault)
}

/// Names with the units of the row below them, where that has nothing but units; a name that has a
/// unit keeps it.
fn with_units_of(names: &[String], row: &csv::StringRecord) -> Option<Vec<String>> {
    let unit = |cell: &str| {
        let cell = cell.trim().trim_start_matches(['[', '(']).trim_end_matches([']', ')']).trim();
        (cell.is_empty() || ["-", "1"].contains(&cell) || unit::is_written(cell))
            .then(|| cell.to_owned())
    };
    let units: Vec<String> = row.iter().map(unit).collect::<Option<_>>()?;
    if !units.iter().any(|text| unit::is_written(text)) {
        return None;
    }
    let named = names.iter().enumerate().map(|(place, name)| match units.get(place) {
        Some(unit) if !unit.is_empty() && !name.contains(['[', '(']) => format!("{name} [{unit}]"),
        _ => name.clone(),
    });
    Some(named.collect())
}

/// Lines of a table that begins so which are neither blank nor comments (`#`), each with the byte
/// behind its end; the last one may be a piece.
fn content_lines(start: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let mut end = 0;
    let lines = start.split_inclusive(|byte| *byte == b'\n').map(move |line| {
        end += line.len();
        (end, line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line).trim_ascii())
    });
    lines.filter(|(_, line)| !line.is_empty() && !line.starts_with(b"#"))
}

const SEPARATORS: [u8; 3] = [b'\t', b';', b','];

fn cells_of(line: &[u8], separator: u8) -> usize {
    line.split(|byte| *byte == separator).count()
}

/// The bytes and the text of a line above the names: one cell, of several words, above a line of
/// several names.
fn title(start: &[u8]) -> Option<(usize, String)> {
    let mut lines = content_lines(start);
    let ((bytes, first), (_, second)) = (lines.next()?, lines.next()?);
    let is_one = |line: &[u8]| SEPARATORS.iter().all(|by| cells_of(line, *by) == 1);
    let by = SEPARATORS.into_iter().max_by_key(|by| cells_of(second, *by))?;
    let names = second.split(|byte| *byte == by).map(|cell| String::from_utf8_lossy(cell));
    let is_name = |cell: &str| cell.trim().parse::<f64>().is_err();
    let has_words = first.iter().any(u8::is_ascii_whitespace);
    (has_words && is_one(first) && !is_one(second) && names.into_iter().all(|name| is_name(&name)))
        .then(|| (bytes, String::from_utf8_lossy(first).chars().take(60).collect()))
}

/// Separator of a table that begins so: a comma, unless there are more semicolons or tabulators.
/// One that gives as many names as the row below has cells goes before all others. The names stand
/// in the first line that is neither blank nor a comment (`#`).
fn separator(start: &[u8]) -> u8 {
    let mut lines = content_lines(start).map(|(_, line)| line);
    let (names, row) = (lines.next().unwrap_or_default(), lines.next().unwrap_or_default());
    let fits = |by: u8| {
        let count = cells_of(names, by);
        (count > 1 && count == cells_of(row, by), count)
    };
    // of equal counts the last one wins
    SEPARATORS.into_iter().max_by_key(|separator| fits(*separator)).unwrap_or(b',')
}

/// The ending of a file's name that says its format, in lower-case letters, without that of a
/// compression.
pub fn ending(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let name = name.strip_suffix(".gz").or_else(|| name.strip_suffix(".zst")).unwrap_or(&name);
    name.rsplit_once('.').map_or_else(String::new, |(_, ending)| ending.to_owned())
}

/// Whether a file is a table by its name, or by its first bytes one of the other formats.
pub fn is_table(path: &Path) -> bool {
    ["csv", "tsv", "txt", "parquet"].contains(&ending(path).as_str()) || is_of_format(path)
}

/// Whether a file is one of the formats that are read as tables by its first bytes; what cannot be
/// read is none.
pub fn is_of_format(path: &Path) -> bool {
    format_of(path).is_some()
}

/// Whether a file is a track or an export of positions by its first bytes.
pub(crate) fn is_track(path: &Path) -> bool {
    format_of(path).is_some_and(|format| format.is_track)
}

fn format_of(path: &Path) -> Option<&'static Format> {
    let start = || {
        let file = BufReader::new(input_file::open(path)?);
        let (text, _) = decompressed(file)?;
        let mut start = Vec::new();
        text.take(format::LOOKED_AT as u64).read_to_end(&mut start)?;
        std::io::Result::Ok(start)
    };
    start().ok().and_then(|start| format::recognise(&start))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_a_title_above_names_and_none_above_numbers() {
        for (start, is_title) in [
            ("driven on Monday\ntime_s,speed_mps\n", true),
            ("driven on Monday\n0,12.5\n", false),
            ("driven on Monday\ntime_s,12.5\n", false),
            ("driven\ntime_s,speed_mps\n", false),
            ("driven on Monday\ntime_s\n", false),
        ] {
            assert_eq!(title(start.as_bytes()).is_some(), is_title, "{start}");
        }
    }

    #[test]
    fn the_header_tells_the_separator() {
        for (start, separated) in [
            ("a,b,c\n1;2;3;4\n", b','),
            ("\u{feff}a;b (x, y);c\n", b';'),
            ("# a, b, c\n\n a\tb\n1,2,3\n", b'\t'),
            ("a\n1;2\n", b','),
            ("", b','),
        ] {
            assert_eq!(separator(start.as_bytes()), separated, "{start}");
        }
    }

    #[test]
    fn a_compression_says_no_format() {
        for (name, wanted) in
            [("a.csv", "csv"), ("a.b.VDRI.gz", "vdri"), ("a.json.zst", "json"), ("a", "")]
        {
            assert_eq!(ending(Path::new(name)), wanted);
        }
    }
}

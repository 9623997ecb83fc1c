//! Formats of files that are no tables of separated cells: tracks, exports and workbooks, each as a
//! table with the names of the vocabulary.
//!
//! A file is recognised by its first bytes, whatever it is called. A format is a file here with a
//! function from its bytes to a table, and a line in [`FORMATS`].

mod epa;
mod epw;
mod geojson;
mod gpx;
mod kml;
mod points;
mod rfms;
#[cfg_attr(not(feature = "files"), path = "without_sheets.rs")]
mod sheets;
mod weather_archive;
mod workbook;
mod xml;

use crate::intake::Finding;
use crate::intake::table::given::GivenTable;
use std::path::Path;

/// Largest file that is read as a whole, in bytes.
const MOST_BYTES: usize = 256 << 20;
/// Bytes by which a format is recognised.
pub(crate) const LOOKED_AT: usize = 4096;

/// The content of a file of another format.
pub(crate) enum Content {
    /// A table with the names of the vocabulary, and what is worth knowing of it.
    Columns(GivenTable, Vec<Finding>),
    /// A table of separated cells.
    Cells(String, Vec<Finding>),
}

/// A format.
pub(crate) struct Format {
    /// Its name in messages.
    pub(crate) name: &'static str,
    /// Whether it has places over time, and nothing else.
    pub(crate) is_track: bool,
    /// Whether a file begins so; `start` has up to [`LOOKED_AT`] bytes.
    is_one: fn(start: &[u8]) -> bool,
    read: fn(path: &Path, bytes: &[u8]) -> Result<Content, String>,
}

/// All formats.
const FORMATS: [&Format; 7] = [
    &gpx::GPX,
    &kml::KML,
    &rfms::RFMS,
    &geojson::GEOJSON,
    &workbook::WORKBOOK,
    &epa::EPA,
    &epw::EPW,
];

/// The format of a file that begins so; none of a table of separated cells.
pub(crate) fn recognise(start: &[u8]) -> Option<&'static Format> {
    let start = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start);
    let start = &start[..start.len().min(LOOKED_AT)];
    FORMATS.into_iter().find(|format| (format.is_one)(start))
}

impl Format {
    /// Reads a file.
    ///
    /// # Errors
    /// The reason in words, for a message behind the name of the file.
    pub(crate) fn read(&self, path: &Path, bytes: &[u8]) -> Result<Content, String> {
        if bytes.len() > MOST_BYTES {
            return Err(format!("it has more than {MOST_BYTES} bytes; split it up"));
        }
        (self.read)(path, bytes).map_err(|reason| format!("as {} {reason}", self.name))
    }
}

/// A text; what is not UTF-8 is read as Latin-1.
fn text_of(bytes: &[u8]) -> String {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().copied().map(char::from).collect(),
    }
}

/// Whether some bytes have a piece in them.
fn contains(bytes: &[u8], piece: &[u8]) -> bool {
    bytes.windows(piece.len()).any(|window| window == piece)
}

#[cfg(test)]
mod tests;

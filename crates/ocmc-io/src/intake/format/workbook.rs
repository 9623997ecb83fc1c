//! Workbooks of spreadsheets (XLSX): the first sheet that has a table. Other archives are looked at
//! for [weather](super::weather_archive).
//!
//! A workbook is an archive, which may expand to anything: how much is looked at before anything is
//! read.

use super::{Content, Format, sheets, weather_archive};
use std::io::{Cursor, Read};
use std::path::Path;

/// The format.
pub(super) const WORKBOOK: Format = Format {
    name: "a workbook",
    is_track: false,
    is_one: |start| start.starts_with(b"PK\x03\x04"),
    read,
};

/// Most bytes of all parts of a workbook, and of a sheet.
pub(super) const MOST_BYTES: u64 = 192 << 20;
/// Most parts.
const MOST_PARTS: usize = 2000;

/// Checks that an archive expands to no more than fits.
fn check_size(bytes: &[u8]) -> Result<(), String> {
    let broken = |error: zip::result::ZipError| format!("cannot be opened: {error}");
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(broken)?;
    if archive.len() > MOST_PARTS {
        return Err(format!("has {} parts, allowed are {MOST_PARTS}", archive.len()));
    }
    let mut left = MOST_BYTES;
    for k in 0..archive.len() {
        let mut part = archive.by_index(k).map_err(broken)?;
        let mut taken = (&mut part).take(left + 1);
        let count = std::io::copy(&mut taken, &mut std::io::sink());
        let count = count.map_err(|error| format!("cannot be expanded: {error}"))?;
        if count > left {
            return Err(format!(
                "expands to more than {MOST_BYTES} bytes, which is the most that is read; save the \
                 sheet as CSV"
            ));
        }
        left -= count;
    }
    Ok(())
}

fn read(_: &Path, bytes: &[u8]) -> Result<Content, String> {
    check_size(bytes)?;
    if let Some(weather) = weather_archive::read(bytes)? {
        return Ok(weather);
    }
    sheets::read(bytes)
}

//! Archives (ZIP) in which weather is published: a series of the German weather service
//! (`produkt_*.txt`, beside files about the station), or a file of EnergyPlus (`.epw`).

use super::{Content, epw, text_of};
use crate::intake::Finding;
use std::borrow::Cow;
use std::io::{Cursor, Read};

/// Reads the weather in an archive whose size was checked; none where it has no such part.
///
/// # Errors
/// The reason in words.
pub(super) fn read(bytes: &[u8]) -> Result<Option<Content>, String> {
    let broken = |error: zip::result::ZipError| format!("cannot be opened: {error}");
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(broken)?;
    let names = archive.file_names().filter_map(|name| name.ok().map(Cow::into_owned));
    let names: Vec<String> = names.filter(|name| is_weather(name)).collect();
    let name = match &*names {
        [] => return Ok(None),
        [name] => name,
        several => {
            let names = several.join("`, `");
            return Err(format!("has several series, `{names}`: expand it, and name one"));
        }
    };
    let mut part = Vec::new();
    let read = archive.by_name(name).map_err(broken)?.read_to_end(&mut part);
    read.map_err(|error| format!("cannot be expanded: {error}"))?;
    let text = format!("`{name}` of the archive: the other parts are left out");
    let findings = vec![Finding::noted("archive", [1.0, 0.0], text, "")];
    let text = text_of(&part);
    let text = if is_epw(name) { epw::as_table(&text) } else { text };
    Ok(Some(Content::Cells(text, findings)))
}

fn is_weather(name: &str) -> bool {
    let is_series = name.starts_with("produkt_") && name.to_lowercase().ends_with(".txt");
    is_series || is_epw(name)
}

fn is_epw(name: &str) -> bool {
    name.to_lowercase().ends_with(".epw")
}

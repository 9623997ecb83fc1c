//! Where a table goes: a file, in the format of its extension, or standard output as CSV.

use crate::failure::Failure;
use crate::{output, request};
use ocmc_core::kernel::trace::TableColumn;
use ocmc_core::operating_cycle::tracks::Track;
use ocmc_io::{operating_cycle, table};
use std::fs;
use std::io;
use std::path::Path;

/// Where, and in which format.
pub(crate) struct Target<'a> {
    path: Option<&'a Path>,
    format: TableFormat,
}

/// Formats of tables.
enum TableFormat {
    Csv,
    Json,
}

/// Works out the format from the name of the file.
pub(crate) fn target(path: Option<&Path>) -> Result<Target<'_>, Failure> {
    let extension = path.map(|path| path.extension().and_then(|extension| extension.to_str()));
    let format = match extension {
        None | Some(Some("csv")) => TableFormat::Csv,
        Some(Some("json")) => TableFormat::Json,
        Some(_) => {
            return Err(request::usage("the name after --out has to end in `.csv` or `.json`"));
        }
    };
    Ok(Target { path, format })
}

/// Writes a table.
pub(crate) fn write(target: &Target, columns: &[TableColumn]) -> Result<(), Failure> {
    let mut bytes = Vec::new();
    match target.format {
        TableFormat::Csv => {
            table::write_csv(&mut bytes, columns).expect("memory takes what is written to it");
        }
        TableFormat::Json => {
            bytes.extend_from_slice(table::to_json(columns).to_string().as_bytes());
            bytes.push(b'\n');
        }
    }
    deliver(target, &bytes)
}

/// Writes the tracks of an operating cycle.
pub(crate) fn write_tracks(
    target: &Target,
    tracks: &[Track],
    json: impl FnOnce() -> serde_json::Value,
) -> Result<(), Failure> {
    write_either(target, |bytes| operating_cycle::write_csv(bytes, tracks), json)
}

/// Writes what has a form for each format.
pub(crate) fn write_either(
    target: &Target,
    csv: impl FnOnce(&mut Vec<u8>) -> io::Result<()>,
    json: impl FnOnce() -> serde_json::Value,
) -> Result<(), Failure> {
    let mut bytes = Vec::new();
    match target.format {
        TableFormat::Csv => csv(&mut bytes).expect("memory takes what is written to it"),
        TableFormat::Json => {
            bytes.extend_from_slice(json().to_string().as_bytes());
            bytes.push(b'\n');
        }
    }
    deliver(target, &bytes)
}

fn deliver(target: &Target, bytes: &[u8]) -> Result<(), Failure> {
    match target.path {
        None => output::answer_bytes(bytes),
        Some(path) => {
            fs::write(path, bytes).map_err(|source| Failure::File { path: path.to_owned(), source })
        }
    }
}

//! Where a table goes: a file, in the format of its extension, or standard output as CSV.

use crate::failure::Failure;
use crate::{output, request};
use serde::Serialize;
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

/// Writes what has a form for each format.
pub(crate) fn write(
    target: &Target,
    answer: &impl Serialize,
    csv: impl FnOnce(&mut Vec<u8>) -> io::Result<()>,
) -> Result<(), Failure> {
    let mut bytes = Vec::new();
    match target.format {
        TableFormat::Csv => csv(&mut bytes).expect("memory takes what is written to it"),
        TableFormat::Json => {
            serde_json::to_writer(&mut bytes, answer).expect("numbers, and keys that are words");
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

//! Given operating cycles, from the files of others and of ours:
//!
//! - `.vdri`: a VECTO cycle (distance, target speed, gradient, stop), `vdri`
//! - `.json` and tables with a column `track`: what `ocmc cycle` writes, `track_file`
//! - any other table: a route by rows, with position or latitude and longitude, `route`

mod route;
mod track_file;
mod vdri;

pub use route::SCHEMA as ROUTE;
pub use track_file::SCHEMA as TRACKS;
pub use vdri::SCHEMA as VECTO_CYCLE;

use crate::drive_cycle;
use crate::study::builtin;
use crate::table::given::RowPlace;
use crate::table::source::{ending, is_table, read_text};
use crate::table::{Column, Mapping, Quantity, Source, Table, TableError};
use ocmc_core::operating_cycle::given::{GivenCycle, GivenCycleError};
use sha2::{Digest, Sha256};
use std::fmt::Write;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// What is wrong with a file that should hold an operating cycle.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum GivenCycleFileError {
    /// A name that says no format.
    #[error("`{}` ends in none of `.vdri`, `.csv`, `.parquet` and `.json`", path.display())]
    Extension {
        /// The file.
        path: PathBuf,
    },
    /// A table that is not one.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A text that is not the JSON of an operating cycle.
    #[error("`{}` is not an operating cycle in JSON as `ocmc cycle` writes it: {source}", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// What the parser found.
        source: serde_json::Error,
    },
    /// An unknown track.
    #[error("`{}` has a track `{name}`; allowed are: {allowed}", path.display())]
    Track {
        /// The file.
        path: PathBuf,
        /// The track.
        name: String,
        /// The tracks that are known.
        allowed: String,
    },
    /// Tracks that are no road.
    #[error("`{}`: {source}", path.display())]
    Cycle {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: GivenCycleError,
    },
    /// A number of the whole cycle out of its range, or alone.
    #[error("`{}`: `{key}` is {value:?}, allowed is {allowed}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// What it is called.
        key: &'static str,
        /// The number.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A drive cycle over time.
    #[error("`{}` is a speed over time: it has a column `{column}`, and none for the position", path.display())]
    OverTime {
        /// The file.
        path: PathBuf,
        /// The column of the time.
        column: String,
    },
    /// A position that does not lie behind the one before it.
    #[error("`{}`, {place}: position {position_m} m does not lie behind the one before it", path.display())]
    Order {
        /// The file.
        path: PathBuf,
        /// The row.
        place: RowPlace,
        /// The position, in m.
        position_m: f64,
    },
    /// A file that is another one than the study was made with.
    #[error(
        "`{}` has another content than when this study was written: its SHA-256 is {found}, not {wanted}",
        path.display()
    )]
    Changed {
        /// The file.
        path: PathBuf,
        /// Its hash.
        found: String,
        /// The hash in the study.
        wanted: String,
    },
}

impl GivenCycleFileError {
    /// What to do, where the message does not say so.
    pub fn help(&self) -> Option<&'static str> {
        match self {
            Self::OverTime { .. } => Some(
                "a speed over time is driven with --follow-speed exact or --follow-speed driver (in Python follow_speed)",
            ),
            _ => None,
        }
    }
}

/// Reads a given operating cycle; the ending of the name, and for tables the header, say in which
/// format.
///
/// # Errors
/// [`GivenCycleFileError`] names the file, the place and what is allowed.
pub fn read(path: &Path, mappings: &[Mapping]) -> Result<GivenCycle, GivenCycleFileError> {
    match ending(path).as_str() {
        "vdri" => vdri::read(Source::File(path), mappings),
        "json" => track_file::read_json(path, &read_text(path)?),
        _ if is_table(path) => {
            let tracks = Table::open(Source::File(path), &TRACKS, &[])?;
            if tracks.column(Quantity::Track).is_some() {
                track_file::read_table(tracks)
            } else {
                route::read(Source::File(path), mappings)
            }
        }
        _ => Err(GivenCycleFileError::Extension { path: path.to_owned() }),
    }
}

/// Reads an operating cycle from the text of a CSV file as `ocmc cycle` writes it; `path` is its
/// name in messages.
///
/// # Errors
/// As [`read`].
pub fn read_tracks(path: &Path, text: &str) -> Result<GivenCycle, GivenCycleFileError> {
    track_file::read_table(Table::open(Source::Text(path, text), &TRACKS, &[])?)
}

/// Whether a file, or what is built in under its name, can be read at all.
///
/// # Errors
/// [`GivenCycleFileError::Table`] with what the system says.
pub fn check_readable(path: &Path) -> Result<(), GivenCycleFileError> {
    if path.to_str().is_some_and(|name| builtin::route(name).is_some()) {
        return Ok(());
    }
    let read = File::open(path).and_then(|mut file| file.read(&mut [0]));
    Ok(read.map(drop).map_err(TableError::read(path))?)
}

/// SHA-256 of a file, or of what is built in under its name, in hexadecimal digits.
///
/// # Errors
/// Where it cannot be read.
pub fn file_hash(path: &Path) -> Result<String, GivenCycleFileError> {
    if let Some(text) = path.to_str().and_then(builtin::route) {
        return Ok(hash(text.as_bytes()));
    }
    Ok(hash(&std::fs::read(path).map_err(TableError::read(path))?))
}

/// SHA-256 of some bytes, in hexadecimal digits.
pub fn hash(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(64);
    for byte in Sha256::digest(bytes) {
        write!(text, "{byte:02x}").expect("a string takes any text");
    }
    text
}

/// Names the file in an error of the core.
fn in_file(path: &Path) -> impl FnOnce(GivenCycleError) -> GivenCycleFileError + '_ {
    |source| GivenCycleFileError::Cycle { path: path.to_owned(), source }
}

/// Refuses a table that has the time, and no column for the position.
fn refuse_over_time(table: &Table, positions: &[Quantity]) -> Result<(), GivenCycleFileError> {
    let time = |name: &&String| drive_cycle::SCHEMA.quantity_of(name) == Some(Quantity::Time);
    match table.names().iter().find(time) {
        Some(column) if positions.iter().all(|position| table.column(*position).is_none()) => {
            let (path, column) = (table.path().to_owned(), column.clone());
            Err(GivenCycleFileError::OverTime { path, column })
        }
        _ => Ok(()),
    }
}

/// A number of another unit than SI's, divided: the factor would differ in the last bit.
fn divided(column: &Column, suffix: &str, by: f64) -> impl FnOnce(f64) -> f64 {
    let column = *column;
    let divide = column.unit.suffix == suffix;
    move |number| if divide { column.sign * number / by } else { column.si(number) }
}

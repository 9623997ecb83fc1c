//! Given operating cycles, from the files of others and of ours:
//!
//! - `.vdri`: a VECTO cycle (distance, target speed, gradient, stop), `vdri`
//! - `.json` and `.csv` with a column `track`: what `ocmc cycle` writes, `track_file`
//! - any other `.csv`: a route by rows, with position or latitude and longitude, `route`

mod route;
mod track_file;
mod vdri;

use crate::delimited::{DelimitedTable, TableError, read_text};
use crate::drive_cycle;
use crate::study::builtin;
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
    #[error("`{}` ends in none of `.vdri`, `.csv` and `.json`", path.display())]
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
    /// A track that nobody knows.
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
    #[error("{}:{line}: position {position_m} m does not lie behind the one before it", path.display())]
    Order {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: u64,
        /// The position, in m.
        position_m: f64,
    },
    /// Two columns for one quantity.
    #[error(
        "`{}` has the columns `{}` and `{}`, which are both {quantity}; allowed is one of them",
        path.display(),
        columns[0],
        columns[1]
    )]
    Ambiguous {
        /// The file.
        path: PathBuf,
        /// The quantity.
        quantity: &'static str,
        /// Both columns.
        columns: [String; 2],
    },
    /// A number out of its range.
    #[error("{}:{line}: `{column}` is {value}, allowed is {minimum} to {maximum}", path.display())]
    Range {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: u64,
        /// The column.
        column: String,
        /// The number.
        value: f64,
        /// Smallest allowed value.
        minimum: f64,
        /// Largest allowed value.
        maximum: f64,
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

/// Reads a given operating cycle; the ending of the name, and for `.csv` the header, say in which format.
///
/// # Errors
/// [`GivenCycleFileError`] names the file, the place and what is allowed.
pub fn read(path: &Path) -> Result<GivenCycle, GivenCycleFileError> {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    match ending.to_lowercase().as_str() {
        "vdri" => vdri::read(&DelimitedTable::read(path)?),
        "json" => track_file::read_json(path, &read_text(path)?),
        "csv" => {
            let table = DelimitedTable::read(path)?;
            if table.find(&["track"]).is_some() {
                track_file::read_csv(&table)
            } else {
                route::read(&table)
            }
        }
        _ => Err(GivenCycleFileError::Extension { path: path.to_owned() }),
    }
}

/// Reads an operating cycle from the text of a CSV file as `ocmc cycle` writes it; `path` is its name in messages.
///
/// # Errors
/// As [`read`].
pub fn read_tracks(path: &Path, text: &str) -> Result<GivenCycle, GivenCycleFileError> {
    track_file::read_csv(&DelimitedTable::parse(path, text)?)
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
    let unreadable = |source| TableError::Unreadable { path: path.to_owned(), source };
    Ok(read.map(drop).map_err(unreadable)?)
}

/// SHA-256 of a file, or of what is built in under its name, in hexadecimal digits.
///
/// # Errors
/// Where it cannot be read.
pub fn file_hash(path: &Path) -> Result<String, GivenCycleFileError> {
    if let Some(text) = path.to_str().and_then(builtin::route) {
        return Ok(hash(text.as_bytes()));
    }
    let unreadable = |source| TableError::Unreadable { path: path.to_owned(), source };
    Ok(hash(&std::fs::read(path).map_err(unreadable)?))
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
fn refuse_over_time(table: &DelimitedTable, positions: &[&str]) -> Result<(), GivenCycleFileError> {
    match table.names().find(|name| drive_cycle::TIME.contains(&name.as_str())) {
        Some(column) if table.find(positions).is_none() => {
            Err(GivenCycleFileError::OverTime { path: table.path().to_owned(), column })
        }
        _ => Ok(()),
    }
}

/// The numbers of a column, each of which has to lie in a range; none where there is no such column.
fn within(
    table: &DelimitedTable,
    names: &[&str],
    [minimum, maximum]: [f64; 2],
) -> Result<Option<Vec<f64>>, GivenCycleFileError> {
    within_or(table, names, [minimum, maximum], None)
}

/// As [`within`], with the number that an empty cell means.
fn within_or(
    table: &DelimitedTable,
    names: &[&str],
    [minimum, maximum]: [f64; 2],
    empty: Option<f64>,
) -> Result<Option<Vec<f64>>, GivenCycleFileError> {
    let Some(column) = table.one_of(names)? else { return Ok(None) };
    let numbers = table.numbers_or(column, empty)?;
    for (line, value) in table.lines().zip(&numbers) {
        if !(minimum..=maximum).contains(value) {
            let (path, value) = (table.path().to_owned(), *value);
            let column = table.names().nth(column).unwrap_or_default();
            return Err(GivenCycleFileError::Range { path, line, column, value, minimum, maximum });
        }
    }
    Ok(Some(numbers))
}

//! Faults of a table: place, value, and remedy.

use super::given::RowPlace;
use crate::intake::Finding;
use arrow_schema::DataType;
use ocmc_core::operating_cycle::given::GivenCycleError;
use ocmc_core::prescribed::DriveCycleError;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Names that are proposed for a misspelt one are at least this similar (Jaro and Winkler).
const SIMILAR: f64 = 0.8;

/// Why a table, or another file of numbers, cannot be read.
#[derive(Debug)]
pub struct TableError {
    /// The file, or what a table is called; none of an assignment that is none.
    path: Option<PathBuf>,
    /// Fault of the table.
    fault: Box<Fault>,
}

impl fmt::Display for TableError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match (&self.path, &*self.fault) {
            (None, fault) => fault.fmt(f),
            (Some(path), Fault::Read(source)) => {
                write!(f, "cannot read `{}`: {source}", path.display())
            }
            (Some(path), fault) => write!(f, "`{}`{fault}", path.display()),
        }
    }
}

impl std::error::Error for TableError {}

/// Fault of a file; its message goes on behind the name of the file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Fault {
    /// The file cannot be opened or read.
    #[error(": {0}")]
    Read(io::Error),
    /// More than fits into memory.
    #[error(" has more than {0}, which is the most that is read; split it up")]
    TooLarge(String),
    /// The file is no table, and why.
    #[error(" is no table: {0}")]
    NoTable(String),
    /// Letters of another encoding, in this line.
    #[error(
        ", line {0}: the text is not UTF-8 (perhaps Latin-1 or UTF-16); save the file as CSV in \
         UTF-8"
    )]
    NotUtf8(u64),
    /// Letters of two bytes each.
    #[error(" is in UTF-16; save it in UTF-8, as a spreadsheet's `CSV UTF-8`")]
    Utf16,
    /// Nothing in it.
    #[error(" is empty: a table has a line of column names, and rows below it")]
    Empty,
    /// Only a header.
    #[error(" has column names and no rows")]
    NoRows,
    /// A row of another length.
    #[error(", {place} has {found} cells, allowed are {wanted}, as many as there are column names")]
    Cells {
        /// The row.
        place: RowPlace,
        /// Cells in the row.
        found: usize,
        /// Columns.
        wanted: usize,
    },
    /// A column that holds neither numbers nor texts.
    #[error(": column `{column}` is of type {found}, allowed are numbers or texts")]
    Type {
        /// The column.
        column: String,
        /// Its type.
        found: DataType,
    },
    /// A cell with something else than what its column holds.
    #[error(", {place}, column `{column}`: {}; allowed is {allowed}", shown(value))]
    Cell {
        /// The row.
        place: RowPlace,
        /// The column.
        column: String,
        /// Text of the cell.
        value: String,
        /// Allowed values.
        allowed: &'static str,
    },
    /// A column that is needed and not there.
    #[error(
        " has no column for the {what}: name it {}, or say which one it is, as in --map {example}; \
         its columns are {found}{nearest}",
        list(wanted)
    )]
    Missing {
        /// Missing quantity, and the column that would do but for its unit.
        what: String,
        /// Names that would do.
        wanted: Vec<String>,
        /// An assignment that would do.
        example: String,
        /// Columns that were found.
        found: String,
        /// A column of a similar name.
        nearest: String,
    },
    /// Columns that the format does not have.
    #[error(" has {}; allowed are: {allowed}", unknown(columns))]
    Unknown {
        /// The columns, each with the known name that was probably meant.
        columns: Vec<(String, String)>,
        /// The columns that are known.
        allowed: String,
    },
    /// A column of a known quantity in another unit.
    #[error(
        ": column `{column}` has a unit that is not read; allowed is {}: convert the numbers and \
         rename the column",
        list(allowed)
    )]
    Unit {
        /// The column.
        column: String,
        /// The names that are read.
        allowed: Vec<String>,
    },
    /// A column with another unit in brackets than its name has.
    #[error(
        ": column `{column}` is read in {allowed}, not in {unit}; convert the numbers, and write \
         `[{allowed}]` or nothing"
    )]
    Bracket {
        /// The column.
        column: String,
        /// Its unit as written.
        unit: String,
        /// The unit that is read.
        allowed: &'static str,
    },
    /// Two columns for one quantity.
    #[error(
        " has the columns `{}` and `{}`, which are both the {quantity}: leave one of them out, or \
         choose one with --map",
        columns[0],
        columns[1]
    )]
    Ambiguous {
        /// The quantity.
        quantity: &'static str,
        /// Both columns.
        columns: [String; 2],
    },
    /// A column without a single number.
    #[error(": column `{column}` has no number in any of its {rows} rows{example}")]
    NoNumbers {
        /// The column.
        column: String,
        /// Rows.
        rows: usize,
        /// Text that stands there instead.
        example: String,
    },
    /// An assignment that is none, as it was written.
    #[error("`{0}` assigns no column: write NAME=COLUMN, as in speed_mph=gps_speed")]
    Mapping(String),
    /// A pause that is no time, as it was written.
    #[error(
        "`{0}` is no pause: write the time of a standstill that ends a trip, as in pause_min=20"
    )]
    Pause(String),
    /// A quantity without a unit, or with a wrong one.
    #[error("`{name}` has no known unit: allowed are {allowed}")]
    UnknownUnit {
        /// Unit as it was written.
        name: String,
        /// Allowed units.
        allowed: String,
    },
    /// A name that means nothing.
    #[error("`{name}` is not known{nearest}: allowed are, with their units, {allowed}")]
    UnknownName {
        /// Name as it was written.
        name: String,
        /// A similar name.
        nearest: String,
        /// Allowed names.
        allowed: String,
    },
    /// An assigned quantity that the format does not have.
    #[error(": `{name}` is assigned a column, and is nothing of {what}: allowed are {allowed}")]
    NotOfFormat {
        /// Name that was assigned.
        name: String,
        /// The format.
        what: &'static str,
        /// Allowed names.
        allowed: String,
    },
    /// An assigned column that is not there.
    #[error(": there is no column `{column}`{nearest}; its columns are {found}")]
    NoSuchColumn {
        /// Column as it was written.
        column: String,
        /// A similar one.
        nearest: String,
        /// Columns that were found.
        found: String,
    },
    /// A file of a known format with something wrong in it.
    #[error(" {0}")]
    OfFormat(String),
    /// Several tracks where one is a route.
    #[error(
        " has several tracks: a route is one of them; save each as a file of its own, or read all \
         of them as logs, as with `ocmc fit operating-cycle` and `ocmc road`"
    )]
    SeveralTracks,
    /// A file that says no format.
    #[error(
        " is no route by its name or content: allowed are `.vdri`, `.csv`, `.tsv`, `.parquet`, \
         `.xlsx`, `.gpx`, `.kml`, `.geojson` and the `.json` of `ocmc cycle` or of rFMS"
    )]
    Extension,
    /// A file of another kind where a table is read.
    #[error(
        " is no table: allowed are separated cells (CSV), Parquet, XLSX, GPX, KML, GeoJSON and \
         rFMS; convert it, a track for example with GPSBabel, a sheet by saving it as XLSX or CSV"
    )]
    NotSeparated,
    /// A text that is not the JSON of an operating cycle.
    #[error(" is not an operating cycle in JSON as `ocmc cycle` writes it: {0}")]
    Json(serde_json::Error),
    /// An unknown track.
    #[error(" has a track `{name}`; allowed are: {allowed}")]
    Track {
        /// The track.
        name: String,
        /// The tracks that are known.
        allowed: String,
    },
    /// A number of a whole operating cycle out of its range, or alone.
    #[error(": `{key}` is {value:?}, allowed is {allowed}")]
    Value {
        /// Name of the value.
        key: &'static str,
        /// The number.
        value: f64,
        /// Allowed values.
        allowed: &'static str,
    },
    /// Tracks that are no road.
    #[error(": {0}")]
    Cycle(GivenCycleError),
    /// A drive cycle over time in place of an operating cycle, with its column of the time.
    #[error(" is a speed over time: it has a column `{0}`, and none for the position")]
    OverTime(String),
    /// A position, in m, that does not lie behind the one before it.
    #[error(
        ", {0}: position {1} m does not lie behind the one before it: leave out a point that is \
         repeated, and sort the others"
    )]
    Order(RowPlace, f64),
    /// A drive of a log that goes on behind others.
    #[error(": the rows of a drive do not follow each other")]
    Mixed,
    /// A log whose time stands still.
    #[error(
        ": of its first {rows} rows {still} repeat the time of the row before them or go back, \
         which is no log of drives; is the column of the time the right one?"
    )]
    Still {
        /// Rows that do.
        still: usize,
        /// Rows that were read.
        rows: usize,
    },
    /// Finding for which a check refuses the file.
    #[error(": {0}")]
    Check(Finding),
    /// Numbers that are no drive cycle.
    #[error(": {0}")]
    DriveCycle(DriveCycleError),
    /// A drive cycle that is no route.
    #[error(" as a route: {0}")]
    Route(GivenCycleError),
    /// A file that is another one than the study was made with.
    #[error(
        " has another content than when this study was written: its SHA-256 is {found}, not \
         {wanted}"
    )]
    Changed {
        /// Its hash.
        found: String,
        /// The hash in the study.
        wanted: String,
    },
    /// Neither speed changes nor a log, with the columns.
    #[error(
        " is neither a table of speed changes (acceleration_mps2) nor a log (time, speed, limit); \
         its columns are {0}; --map says which column of a log is what"
    )]
    Neither(String),
}

impl TableError {
    /// Fault of a table with this name.
    pub(crate) fn of(path: &Path, fault: Fault) -> Self {
        Self { path: Some(path.to_owned()), fault: Box::new(fault) }
    }

    /// Error of the system in reading.
    pub(crate) fn read(path: &Path) -> impl Fn(io::Error) -> Self + Copy + '_ {
        |source| Self::of(path, Fault::Read(source))
    }

    /// Fault of an assignment.
    pub(super) fn of_mapping(fault: Fault) -> Self {
        Self { path: None, fault: Box::new(fault) }
    }

    /// Whether the rows of a log's drive do not follow each other.
    pub(crate) fn is_mixed(&self) -> bool {
        matches!(*self.fault, Fault::Mixed)
    }

    /// Error of the system, where a file cannot be read.
    pub fn reason(&self) -> Option<&io::Error> {
        match &*self.fault {
            Fault::Read(source) => Some(source),
            _ => None,
        }
    }

    /// Remedy, where the message does not say so.
    pub fn help(&self) -> Option<&'static str> {
        match &*self.fault {
            Fault::OverTime(_) => Some(
                "a speed over time is driven with --follow-speed exact or --follow-speed driver \
                 (in Python follow_speed)",
            ),
            Fault::Missing { what, .. } if *what == super::Quantity::Limit.noun() => Some(
                "a route without limits has them drawn from the study's road types with --draw \
                 limits (in Python draw)",
            ),
            _ => None,
        }
    }

    /// Whether columns are there and unclear: two of one quantity, or one with two units.
    pub(crate) fn is_of_columns(&self) -> bool {
        matches!(*self.fault, Fault::Ambiguous { .. } | Fault::Bracket { .. })
    }

    /// Whether a check refuses what was read.
    pub fn is_of_check(&self) -> bool {
        matches!(*self.fault, Fault::Check(_))
    }
}

/// ` (did you mean ...?)` for the most similar name.
pub(super) fn nearest(name: &str, known: &[String]) -> String {
    let scored = known.iter().map(|known| (strsim::jaro_winkler(name, known), known));
    let best = scored.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(score, _)| *score > SIMILAR);
    best.map_or_else(String::new, |(_, known)| format!(" (did you mean `{known}`?)"))
}

/// A cell in a message.
fn shown(value: &str) -> String {
    if value.is_empty() { "empty".to_owned() } else { format!("`{value}`") }
}

/// Columns that a format does not have, in a message.
fn unknown(columns: &[(String, String)]) -> String {
    let named: Vec<String> =
        columns.iter().map(|(name, nearest)| format!("`{name}`{nearest}")).collect();
    let what = if columns.len() == 1 { "an unknown column" } else { "unknown columns" };
    format!("{what} {}", named.join(", "))
}

/// Names one after the other: `a`, `b` or `c`.
fn list(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.split_last() {
        Some((last, first)) if !first.is_empty() => format!("{} or {last}", first.join(", ")),
        _ => quoted.concat(),
    }
}

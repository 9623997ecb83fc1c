//! What can be wrong with a log file, in words for whoever has to mend it.

use super::quantity::{Label, Quantity, Word};
use crate::given_table::ColumnTypeError;
use std::io;
use std::path::PathBuf;
use thiserror::Error;

/// Names that are proposed for a misspelt one are at least this similar (Jaro-Winkler).
const SIMILAR: f64 = 0.75;

/// Why a log file cannot be read.
#[derive(Debug, Error)]
pub enum LogFileError {
    /// The file cannot be opened or read.
    #[error("cannot read `{}`: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file is no CSV.
    #[error("`{}` is not comma-separated text: {reason}", path.display())]
    NotCsv {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// Letters of another encoding.
    #[error(
        "`{}`, {place}: the text is not UTF-8 (perhaps Latin-1 or UTF-16); save the file as CSV in UTF-8",
        path.display()
    )]
    NotUtf8 {
        /// The file.
        path: PathBuf,
        /// The line, in words.
        place: String,
    },
    /// A column of a type that no quantity has.
    #[error(transparent)]
    Type(#[from] ColumnTypeError),
    /// Nothing in it.
    #[error("`{}` is empty: a log has a line of column names, and rows below it", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// Only a header.
    #[error("`{}` has column names and no rows", path.display())]
    NoRows {
        /// The file.
        path: PathBuf,
    },
    /// More rows than fit into memory.
    #[error("`{}` has more than {most} rows: split it by drives", path.display())]
    TooManyRows {
        /// The file.
        path: PathBuf,
        /// Most rows.
        most: usize,
    },
    /// A column that is needed and not there.
    #[error(
        "`{}` has no column for the {what}: name it {wanted}, or say which one it is, as in --map {example}; its columns are {found}",
        path.display()
    )]
    Missing {
        /// The file.
        path: PathBuf,
        /// What is missing, and which column would do but for its unit.
        what: String,
        /// Names that would do.
        wanted: String,
        /// An assignment that would do.
        example: String,
        /// What there is.
        found: String,
    },
    /// A column without a single number.
    #[error("the column `{column}` of `{}` has no number in any of its {rows} rows{example}", path.display())]
    NoNumbers {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
        /// Rows.
        rows: usize,
        /// What stands there instead.
        example: String,
    },
    /// Something in a header, with the file in which it was met.
    #[error("`{}`: {source}", path.display())]
    Header {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: Box<LogFileError>,
    },
    /// An assignment that is none.
    #[error("`{text}` assigns no column: write NAME=COLUMN, as in speed_mph=gps_speed")]
    Mapping {
        /// What was written.
        text: String,
    },
    /// A quantity without a unit, or with a wrong one.
    #[error("`{name}` has no known unit: allowed are {}", allowed.join(", "))]
    UnknownUnit {
        /// What was written.
        name: String,
        /// What is allowed.
        allowed: Vec<String>,
    },
    /// A name that means nothing.
    #[error(
        "`{name}` is not known{nearest}: allowed are the labels driver, drive, event, the words road_type, map_object, and {allowed} with their units"
    )]
    UnknownName {
        /// What was written.
        name: String,
        /// A similar name.
        nearest: String,
        /// What is allowed.
        allowed: String,
    },
    /// An assigned column that is not there.
    #[error("there is no column `{column}`{nearest}; its columns are {found}")]
    NoSuchColumn {
        /// What was written.
        column: String,
        /// A similar one.
        nearest: String,
        /// What there is.
        found: String,
    },
    /// Two columns for one quantity.
    #[error("`{}` and `{}` are both the {name}: choose one with --map", columns[0], columns[1])]
    Ambiguous {
        /// The quantity or label.
        name: &'static str,
        /// Both columns.
        columns: [String; 2],
    },
}

impl LogFileError {
    pub(super) fn unknown_name(name: &str) -> Self {
        let names = Quantity::ALL.into_iter().flat_map(Quantity::names);
        let labels = Label::ALL.into_iter().map(|label| label.name().to_owned());
        let words = Word::ALL.into_iter().map(|word| word.name().to_owned());
        let nearest = nearest(name, names.chain(labels).chain(words));
        let allowed: Vec<&str> = Quantity::ALL.into_iter().map(Quantity::name).collect();
        Self::UnknownName { name: name.to_owned(), nearest, allowed: allowed.join(", ") }
    }

    pub(super) fn no_such_column(column: &str, header: &[String]) -> Self {
        Self::NoSuchColumn {
            column: column.to_owned(),
            nearest: nearest(column, header.iter().cloned()),
            found: header.join(", "),
        }
    }
}

/// `, did you mean ...?` for the most similar name.
fn nearest(name: &str, names: impl Iterator<Item = String>) -> String {
    let scored = names.map(|known| (strsim::jaro_winkler(name, &known), known));
    let best = scored.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(score, _)| *score >= SIMILAR);
    best.map_or_else(String::new, |(_, known)| format!(" (did you mean `{known}`?)"))
}

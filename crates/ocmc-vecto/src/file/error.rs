//! Why a file of VECTO cannot be used.

use ocmc_io::table::TableError;
use std::path::PathBuf;
use thiserror::Error;

/// Why a file of VECTO cannot be used.
#[derive(Debug, Error)]
pub enum VectoError {
    /// A file that cannot be read, or a table that is none.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A file that is no JSON, or lacks a value.
    #[error("`{}`: {}", .0.display(), .1)]
    Json(PathBuf, String),
    /// A file that another one names and that is not there.
    #[error(
        "`{}` names `{name}`, which is not beside it (blanks may be written as `_`)",
        .path.display()
    )]
    NotThere {
        /// The file that names it.
        path: PathBuf,
        /// The name.
        name: String,
    },
    /// Part of VECTO that is not computed here.
    #[error("`{}`: {what} is {found}; {allowed}", .path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// Name of the part.
        what: &'static str,
        /// Value in the file.
        found: String,
        /// Allowed values.
        allowed: &'static str,
    },
    /// A mission that is none.
    #[error("`{}`: {}", .0.display(), .1)]
    Mission(PathBuf, crate::driver::MissionError),
    /// A result without a column.
    #[error("`{}` has no column `{column}`; it has {found}", .path.display())]
    Column {
        /// The file.
        path: PathBuf,
        /// The column.
        column: &'static str,
        /// The columns that it has.
        found: String,
    },
    /// A row of a result that is no row of numbers.
    #[error("`{}`, line {line}: {problem}", .path.display())]
    Row {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// Fault of the row.
        problem: String,
    },
}

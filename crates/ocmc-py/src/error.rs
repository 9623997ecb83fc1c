//! Errors of the engine as exceptions: the same text as the command's.

use ocmc_io::drive_cycle::DriveCycleFileError;
use ocmc_io::given_cycle::GivenCycleFileError;
use ocmc_io::given_drive::GivenDriveError;
use ocmc_io::records::RecordsError;
use ocmc_io::run_directory::RunDirectoryError;
use ocmc_io::speed_change_table::SpeedChangeFileError;
use ocmc_io::study::{Cause, StudyFileError};
use ocmc_io::table::TableError;
use pyo3::PyErr;
use pyo3::exceptions::{
    PyFileExistsError, PyFileNotFoundError, PyIsADirectoryError, PyNotADirectoryError, PyOSError,
    PyValueError,
};
use std::io;
use std::path::Path;

/// A study that is not one: `OSError` where a file is at fault, otherwise `ValueError`.
pub(crate) fn study_error(error: &StudyFileError) -> PyErr {
    let text = error.to_string();
    match error.faults.first().map(|fault| &fault.cause) {
        Some(Cause::UnknownName { name, .. }) if is_path(name) => {
            PyFileNotFoundError::new_err(text)
        }
        Some(Cause::Directory { .. }) => PyIsADirectoryError::new_err(text),
        Some(Cause::Unreadable { .. }) => PyOSError::new_err(text),
        _ => PyValueError::new_err(text),
    }
}

/// Whether a name that is neither built in nor a file was meant to be a file.
fn is_path(name: &str) -> bool {
    let path = Path::new(name);
    path.components().count() > 1 || path.extension().is_some()
}

/// A run directory that cannot be written or read.
pub(crate) fn run_directory_error(error: &RunDirectoryError) -> PyErr {
    let text = error.to_string();
    match error {
        RunDirectoryError::Exists { .. } => PyFileExistsError::new_err(text),
        RunDirectoryError::NotADirectory { .. } => PyNotADirectoryError::new_err(text),
        RunDirectoryError::NotARun { source, .. } => io_error(source, error),
        RunDirectoryError::File(file) | RunDirectoryError::Records(RecordsError::File(file)) => {
            io_error(file.reason(), error)
        }
        _ => PyValueError::new_err(text),
    }
}

/// A table that cannot be read.
pub(crate) fn table_error(error: &TableError) -> PyErr {
    match error.reason() {
        Some(reason) => io_error(reason, error),
        None => PyValueError::new_err(error.to_string()),
    }
}

/// Speed changes that cannot be read.
pub(crate) fn speed_change_error(error: &SpeedChangeFileError) -> PyErr {
    match error {
        SpeedChangeFileError::Table(error) => table_error(error),
        SpeedChangeFileError::Drive { .. } | SpeedChangeFileError::Neither { .. } => {
            PyValueError::new_err(error.to_string())
        }
    }
}

/// An operating cycle that cannot be read.
pub(crate) fn given_cycle_error(error: &GivenCycleFileError) -> PyErr {
    match error {
        GivenCycleFileError::Table(error) => table_error(error),
        _ => PyValueError::new_err(error.to_string()),
    }
}

/// Something that cannot be driven.
pub(crate) fn given_drive_error(error: &GivenDriveError) -> PyErr {
    match error {
        GivenDriveError::GivenCycle(error) => given_cycle_error(error),
        GivenDriveError::DriveCycle(DriveCycleFileError::Table(error)) => table_error(error),
        GivenDriveError::Several | GivenDriveError::Route => {
            PyValueError::new_err(format!("`follow_speed`: {error}"))
        }
        GivenDriveError::Keep { .. } | GivenDriveError::DriveCycle(_) => {
            PyValueError::new_err(error.to_string())
        }
    }
}

/// Measurements that have no fit.
pub(crate) fn no_fit(source: &Path, error: &impl std::error::Error) -> PyErr {
    PyValueError::new_err(format!("`{}`: {error}", source.display()))
}

/// The kind of the system's error with the text of ours.
fn io_error(source: &io::Error, error: &impl std::error::Error) -> PyErr {
    io::Error::new(source.kind(), error.to_string()).into()
}

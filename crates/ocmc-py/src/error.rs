//! Errors of the engine as exceptions: the same text as the command's.

use ocmc_api::study::{Cause, StudyFileError};
use ocmc_api::{Error, GivenDriveError, RunDirectoryError};
use pyo3::PyErr;
use pyo3::exceptions::{
    PyFileExistsError, PyFileNotFoundError, PyIsADirectoryError, PyNotADirectoryError, PyOSError,
    PyValueError,
};
use std::io;
use std::path::Path;

/// A question without an answer: `OSError` where a file is at fault, otherwise `ValueError`.
pub(crate) fn exception(error: Error) -> PyErr {
    if let Some(source) = error.system() {
        // the kind of the system's error with the text of ours
        return io::Error::new(source.kind(), error.to_string()).into();
    }
    let text = error.to_string();
    match error {
        Error::Study(error) => study_error(error),
        Error::RunDirectory(RunDirectoryError::Exists { .. }) | Error::NotEmpty { .. } => {
            PyFileExistsError::new_err(text)
        }
        Error::RunDirectory(RunDirectoryError::NotADirectory { .. }) => {
            PyNotADirectoryError::new_err(text)
        }
        Error::GivenDrive(GivenDriveError::Several | GivenDriveError::Route) => {
            PyValueError::new_err(format!("`follow_speed`: {text}"))
        }
        Error::GivenDrive(GivenDriveError::File(error)) => {
            let help = error.help().map(|help| format!("; {help}"));
            PyValueError::new_err(text + &help.unwrap_or_default())
        }
        Error::Tobit => PyValueError::new_err(format!("`tobit` {text}")),
        _ => PyValueError::new_err(text),
    }
}

/// A study that is not one: `OSError` where a file is at fault, otherwise `ValueError`.
pub(crate) fn study_error(error: StudyFileError) -> PyErr {
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

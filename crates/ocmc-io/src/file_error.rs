//! A file or directory that the system does not let us create, write or read.

use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Failure of the system, with its place and reason.
#[derive(Debug, Error)]
#[error("cannot {action} `{}`: {source}", path.display())]
pub struct FileError {
    /// To create, write or read.
    pub action: &'static str,
    /// The file or directory.
    pub path: PathBuf,
    /// Why.
    pub source: io::Error,
}

impl FileError {
    /// Why the path cannot be created.
    pub fn create(path: &Path) -> impl Fn(io::Error) -> Self {
        Self::of("create", path)
    }

    /// Why the path cannot be written.
    pub fn write(path: &Path) -> impl Fn(io::Error) -> Self {
        Self::of("write", path)
    }

    /// Why the path cannot be read.
    pub fn read(path: &Path) -> impl Fn(io::Error) -> Self {
        Self::of("read", path)
    }

    fn of(action: &'static str, path: &Path) -> impl Fn(io::Error) -> Self {
        move |source| Self { action, path: path.to_owned(), source }
    }
}

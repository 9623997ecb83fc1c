//! A file or directory that the system does not let us create, write or read.

use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// What the system did not let us do, where, and why.
#[derive(Debug, Error)]
pub enum FileError {
    /// It cannot be created.
    #[error("cannot create `{}`: {source}", path.display())]
    Create {
        /// The file or directory.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It cannot be written, for instance because the disk is full.
    #[error("cannot write `{}`: {source}", path.display())]
    Write {
        /// The file or directory.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It cannot be read.
    #[error("cannot read `{}`: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

impl FileError {
    /// Why the path cannot be created.
    pub(crate) fn create(path: &Path) -> impl Fn(io::Error) -> Self {
        move |source| Self::Create { path: path.to_owned(), source }
    }

    /// Why the path cannot be written.
    pub(crate) fn write(path: &Path) -> impl Fn(io::Error) -> Self {
        move |source| Self::Write { path: path.to_owned(), source }
    }

    /// Why the path cannot be read.
    pub(crate) fn read(path: &Path) -> impl Fn(io::Error) -> Self {
        move |source| Self::Read { path: path.to_owned(), source }
    }

    /// What the system says.
    pub fn reason(&self) -> &io::Error {
        let (Self::Create { source, .. } | Self::Write { source, .. } | Self::Read { source, .. }) =
            self;
        source
    }
}

//! Everything that can end a command early.

use ocmc_api::study::StudyFileError;
use ocmc_api::{Error, GivenDriveError};
use std::io;
use std::path::PathBuf;
use thiserror::Error as ThisError;

/// Why a command did not do what it was asked to do.
#[derive(Debug, ThisError)]
pub(crate) enum Failure {
    /// Arguments that do not fit together.
    #[error("{0}")]
    Usage(String),
    /// A question without an answer.
    #[error(transparent)]
    Question(Error),
    /// JSON that asks nothing.
    #[error("{0}")]
    NoQuestion(String),
    /// A page that cannot be served.
    #[error("the page cannot be served: {0}")]
    Page(String),
    /// A file that exists already.
    #[error("`{}` exists already", path.display())]
    Exists { path: PathBuf },
    /// A file of a run directory that leads elsewhere.
    #[error(
        "`{}` is a symbolic link, and what it names is not ours: remove it, or say with \
         {otherwise}",
        path.display()
    )]
    Link { path: PathBuf, otherwise: &'static str },
    /// A file that cannot be written.
    #[error("cannot write `{}`: {source}", path.display())]
    File { path: PathBuf, source: io::Error },
    /// Standard output that cannot be written.
    #[error("cannot write to standard output: {source}")]
    StandardOutput { source: io::Error },
    /// A run directory with files that are not what was written.
    #[error("`{}` is not whole", path.display())]
    NotWhole { path: PathBuf },
    /// Ctrl-C.
    #[error("interrupted: {finished}")]
    Interrupted { finished: String, help: String },
}

impl From<Error> for Failure {
    /// Maps errors of options that do not fit together to wrong usage.
    fn from(error: Error) -> Self {
        match error {
            Error::GivenDrive(GivenDriveError::Several | GivenDriveError::Route) => {
                Self::Usage(format!("--follow-speed: {error}"))
            }
            Error::GivenDrive(GivenDriveError::Keep { .. }) => {
                Self::Usage(format!("--keep: {error}"))
            }
            Error::GivenDrive(GivenDriveError::Draw { .. }) => {
                Self::Usage(format!("--draw: {error}"))
            }
            Error::OtherRun { .. }
            | Error::Differs { .. }
            | Error::PartOfTruck { .. }
            | Error::NoColumn { .. }
            | Error::NothingToSweep
            | Error::ManyPoints { .. }
            | Error::SweptTwice(_)
            | Error::SamePoints { .. }
            | Error::Bounds(_) => Self::Usage(error.to_string()),
            Error::Tobit => Self::Usage(format!("--tobit {error}")),
            error => Self::Question(error),
        }
    }
}

impl From<StudyFileError> for Failure {
    fn from(error: StudyFileError) -> Self {
        Error::from(error).into()
    }
}

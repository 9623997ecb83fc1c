//! Everything that can end a command early.

use crate::study_report::study_report;
use ocmc_api::shell_word::resume_command;
use ocmc_api::study::StudyFileError;
use ocmc_api::{Error, GivenDriveError, RunDirectoryError, SensitivityError};
use std::borrow::Cow;
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
    /// A file that exists already.
    #[error("`{}` exists already", path.display())]
    Exists { path: PathBuf },
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
    /// What options that do not fit together cause is wrong usage.
    fn from(error: Error) -> Self {
        match error {
            Error::GivenDrive(GivenDriveError::Several | GivenDriveError::Route) => {
                Self::Usage(format!("--follow-speed: {error}"))
            }
            Error::GivenDrive(GivenDriveError::Keep { .. }) => {
                Self::Usage(format!("--keep: {error}"))
            }
            Error::OtherRun { .. } | Error::Bounds(_) => Self::Usage(error.to_string()),
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

impl Failure {
    /// What to tell the user.
    pub(crate) fn report(&self) -> String {
        if let Self::Question(Error::Study(error)) = self {
            return study_report(error);
        }
        let mut text = format!("error: {self}");
        if let Some(help) = self.help() {
            text.push_str("\n  help: ");
            text.push_str(&help);
        }
        text
    }

    fn help(&self) -> Option<Cow<'_, str>> {
        match self {
            Self::Question(error) => help_of(error),
            Self::Exists { .. } => Some("give another name, or remove the file".into()),
            Self::Interrupted { help, .. } => Some(help.into()),
            _ => None,
        }
    }
}

/// What to do about a question without an answer.
fn help_of(error: &Error) -> Option<Cow<'_, str>> {
    let help = match error {
        Error::RunDirectory(error) => return help_of_directory(error),
        Error::Table(error) | Error::GivenDrive(GivenDriveError::File(error)) => {
            return error.help().map(Cow::Borrowed);
        }
        Error::NothingToResume(_) => {
            "--resume finishes a run that was begun; leave it out to begin one"
        }
        Error::Unwritten(_) => {
            "what was finished is kept: --out with this directory and --resume goes on"
        }
        Error::Sensitivity(SensitivityError::TooFewRows { .. }) => {
            "more --cycles, or another --column; `ocmc` with this study says why cycles fail"
        }
        Error::Sensitivity(SensitivityError::TooFewCrossed { .. }) => {
            "more cycles with --crossed, or another --column; `ocmc` with this study says why cycles fail"
        }
        Error::Sensitivity(SensitivityError::NotIndependent) => {
            "add --set simulation.sampling=independent, or leave --crossed out"
        }
        Error::Interrupted(_) => {
            "there is no answer without the rest; fewer --cycles take less time"
        }
        _ => return None,
    };
    Some(help.into())
}

fn help_of_directory(error: &RunDirectoryError) -> Option<Cow<'_, str>> {
    let help = match error {
        RunDirectoryError::Exists { unfinished: true, path, .. } => {
            let resume = resume_command(path);
            return Some(
                format!("`{resume}` finishes it; or give another directory, or remove this one")
                    .into(),
            );
        }
        RunDirectoryError::NotWhole(path, _) => {
            let resume = resume_command(path);
            return Some(format!("if it was ended by force, `{resume}` finishes it").into());
        }
        RunDirectoryError::Exists { .. } => "give another directory with --out, or remove this one",
        RunDirectoryError::NotOneRun { .. } => {
            "parts have the same study, seed and program, and each begins where another one ends"
        }
        RunDirectoryError::NotADirectory { .. } => {
            "give a directory with --out; it is created where it does not exist"
        }
        RunDirectoryError::NotFinished { help, .. } => help,
        _ => return None,
    };
    Some(help.into())
}

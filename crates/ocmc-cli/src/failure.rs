//! Everything that can end a command early.

use crate::study_report::study_report;
use ocmc_core::fleet::sensitivity::SensitivityError;
use ocmc_io::drive_cycle::DriveCycleFileError;
use ocmc_io::given_cycle::GivenCycleFileError;
use ocmc_io::log::curves::TripError;
use ocmc_io::run_directory::RunDirectoryError;
use ocmc_io::shell_word::resume_command;
use ocmc_io::speed_change_table::SpeedChangeFileError;
use ocmc_io::study::StudyFileError;
use ocmc_io::table::TableError;
use std::borrow::Cow;
use std::io;
use std::path::PathBuf;
use thiserror::Error;

/// Why a command did not do what it was asked to do.
#[derive(Debug, Error)]
pub(crate) enum Failure {
    /// Arguments that do not fit together.
    #[error("{0}")]
    Usage(String),
    /// A study that is not one.
    #[error(transparent)]
    Study(#[from] StudyFileError),
    /// A drive cycle that is not one.
    #[error(transparent)]
    DriveCycle(#[from] DriveCycleFileError),
    /// A table that cannot be read.
    #[error(transparent)]
    Table(#[from] TableError),
    /// Speed changes that cannot be read.
    #[error(transparent)]
    SpeedChange(#[from] SpeedChangeFileError),
    /// An operating cycle that cannot be read.
    #[error(transparent)]
    GivenCycle(#[from] GivenCycleFileError),
    /// Measurements that have no fit.
    #[error("`{}`: {error}", path.display())]
    Fit { path: PathBuf, error: Box<dyn std::error::Error> },
    /// Logs without a single usable drive.
    #[error("{place}: {fault}")]
    Drive { place: String, fault: TripError },
    /// Logs without a single event that can be identified.
    #[error("{place}: {reason}")]
    NoEvent { place: String, reason: String },
    /// A run directory that cannot be written.
    #[error(transparent)]
    RunDirectory(#[from] RunDirectoryError),
    /// A run that is to be resumed and is not there.
    #[error(transparent)]
    NothingToResume(RunDirectoryError),
    /// A run directory that takes no more of a run that is under way.
    #[error(transparent)]
    Unwritten(RunDirectoryError),
    /// Shares that cannot be estimated.
    #[error(transparent)]
    Sensitivity(#[from] SensitivityError),
    /// A file that exists already.
    #[error("`{}` exists already", path.display())]
    Exists { path: PathBuf },
    /// A file that cannot be written.
    #[error("cannot write `{}`: {source}", path.display())]
    File { path: PathBuf, source: io::Error },
    /// Standard output that cannot be written.
    #[error("cannot write to standard output: {source}")]
    StandardOutput { source: io::Error },
    /// Ctrl-C.
    #[error("interrupted: {finished}")]
    Interrupted { finished: String, help: String },
}

impl Failure {
    /// What to tell the user.
    pub(crate) fn report(&self) -> String {
        if let Self::Study(error) = self {
            return study_report(error);
        }
        let mut text = format!("error: {self}");
        if let Some(help) = self.help() {
            text.push_str("\n  help: ");
            text.push_str(&help);
        }
        text
    }

    /// That of a run which could not be resumed.
    pub(crate) fn of_resume(self) -> Self {
        match self {
            Self::RunDirectory(error @ RunDirectoryError::NotARun { .. }) => {
                Self::NothingToResume(error)
            }
            other => other,
        }
    }

    fn help(&self) -> Option<Cow<'_, str>> {
        let help = match self {
            Self::RunDirectory(RunDirectoryError::Exists { unfinished: true, path, .. }) => {
                let resume = resume_command(path);
                return Some(
                    format!(
                        "`{resume}` finishes it; or give another directory, or remove this one"
                    )
                    .into(),
                );
            }
            Self::RunDirectory(RunDirectoryError::NotWhole { path, .. }) => {
                let resume = resume_command(path);
                return Some(format!("if it was ended by force, `{resume}` finishes it").into());
            }
            Self::GivenCycle(error) => error.help(),
            Self::NothingToResume(_) => {
                Some("--resume finishes a run that was begun; leave it away to begin one")
            }
            Self::RunDirectory(RunDirectoryError::Exists { .. }) => {
                Some("give another directory with --out, or remove this one")
            }
            Self::Unwritten(_) => {
                Some("what was finished is kept: --out with this directory and --resume goes on")
            }
            Self::RunDirectory(RunDirectoryError::NotOneRun { .. }) => Some(
                "parts have the same study, seed and program, and each begins where another one ends",
            ),
            Self::RunDirectory(RunDirectoryError::NotADirectory { .. }) => {
                Some("give a directory with --out; it is created where it does not exist")
            }
            Self::Sensitivity(SensitivityError::TooFewRows { .. }) => Some(
                "more --cycles, or another --column; `ocmc` with this study says why cycles fail",
            ),
            Self::Sensitivity(SensitivityError::TooFewCrossed { .. }) => Some(
                "more cycles with --crossed, or another --column; `ocmc` with this study says why cycles fail",
            ),
            Self::Sensitivity(SensitivityError::NotIndependent) => {
                Some("add --set simulation.sampling=independent, or leave --crossed away")
            }
            Self::Exists { .. } => Some("give another name, or remove the file"),
            Self::Interrupted { help, .. }
            | Self::RunDirectory(RunDirectoryError::NotFinished { help, .. }) => {
                Some(help.as_str())
            }
            _ => None,
        };
        help.map(Cow::Borrowed)
    }
}

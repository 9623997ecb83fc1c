//! Why a comparison with VECTO is not made.

use crate::file::VectoError;
use ocmc_core::prescribed::DriveCycleError;
use ocmc_io::study::StudyFileError;
use std::path::PathBuf;
use thiserror::Error;

/// Why a comparison with VECTO is not made.
#[derive(Debug, Error)]
pub enum ComparisonError {
    /// A truck that is not one.
    #[error(transparent)]
    Study(#[from] StudyFileError),
    /// A file of VECTO that cannot be used.
    #[error(transparent)]
    File(#[from] VectoError),
    /// A speed of VECTO that is no drive cycle.
    #[error("`{}`: {}", .0.display(), .1)]
    Speed(PathBuf, DriveCycleError),
    /// A plan of VECTO's driver that is no drive cycle.
    #[error("VECTO's driver does not get along the mission: {0}")]
    Plan(DriveCycleError),
    /// A job where no files are allowed.
    #[error(
        "`{}` is a job, which names files, and --no-files allows none; allowed is the name of a \
         built-in vehicle",
        .0.display()
    )]
    Refused(PathBuf),
    /// No result to compare with.
    #[error(
        "there is no result of VECTO to compare with: give time series or sums (`--result \
         FILE.vmod`), or put time series beside the job, whose name theirs begin with"
    )]
    NoResult,
    /// A result whose mission is not among those given.
    #[error(
        "`{}` belongs to none of the missions by its name: the name of a mission's file is part of \
         it",
        .0.display()
    )]
    Mission(PathBuf),
    /// A mission without a row in the sums.
    #[error(
        "no row of `{}` is of the mission `{}`, by the name of its file; it has `{rows}`",
        sums.display(),
        mission.display()
    )]
    Row {
        /// The mission.
        mission: PathBuf,
        /// The sums.
        sums: PathBuf,
        /// The missions that have one.
        rows: String,
    },
    /// A result on an even road of a job without a mass.
    #[error(
        "`{}` does not show the truck's mass, and the job does not say it: it was saved in \
         declaration mode, and the road is even",
        .0.display()
    )]
    Mass(PathBuf),
    /// A truck that is lighter than empty.
    #[error(
        "the truck of the result weighs {gross_mass_kg} kg, the empty one of the files {curb_kg} kg"
    )]
    TooLight {
        /// Gross mass of the result, in kg.
        gross_mass_kg: f64,
        /// Curb mass of the files, in kg.
        curb_kg: f64,
    },
    /// An electric vehicle beside a truck of VECTO.
    #[error(
        "VECTO's results are of combustion engines: give a vehicle with `engine` and `gearbox`"
    )]
    WithoutEngine,
}

//! What the user typed about given operating cycles and drive cycles.

use super::run::RunArguments;
use clap::{Args, ValueEnum};
use ocmc_api::Keep;
use std::path::PathBuf;

/// A run on given routes.
#[derive(Clone, Debug, Args)]
pub(crate) struct DriveArguments {
    /// Files with operating cycles: VECTO's `.vdri`, tracks or JSON of `ocmc cycle`, or a route as
    /// `.csv`. Of several, each cycle drives one, by the weights of the study's `mission.routes`
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// Says which column of a table is what, as in speed_limit_kmh=vmax; may be repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    pub(crate) map: Vec<String>,
    /// What is taken from the file instead of being drawn from the study; may be repeated or joined
    /// by commas
    #[arg(long, value_name = "WHAT", value_delimiter = ',')]
    pub(crate) keep: Vec<Kept>,
    /// Follows the speed of a drive cycle, a `.csv` with time, speed and grade; or, exactly, the
    /// speed planned on a route
    #[arg(long, value_name = "HOW")]
    pub(crate) follow_speed: Option<Follow>,
    #[command(flatten)]
    pub(crate) run: RunArguments,
}

/// How a drive cycle is followed, as typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Follow {
    /// A driver of the study drives it: its speeds are limits along the road, its standstills are
    /// stops
    Driver,
    /// Without a driver: the exact backward force balance of the prescribed speed
    Exact,
}

/// What is taken from a file, as typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Kept {
    /// Temperature, pressure, humidity, precipitation, wind
    Weather,
    /// Density of traffic
    Traffic,
    /// Payload and departure
    Mission,
}

impl From<Kept> for Keep {
    fn from(kept: Kept) -> Self {
        match kept {
            Kept::Weather => Self::Weather,
            Kept::Traffic => Self::Traffic,
            Kept::Mission => Self::Mission,
        }
    }
}

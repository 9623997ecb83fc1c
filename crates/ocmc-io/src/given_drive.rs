//! What somebody has given to be driven instead of a study's own roads: routes, for the study's drivers, or a speed to follow.

use crate::delimited::DelimitedTable;
use crate::drive_cycle::{self, DriveCycleFileError};
use crate::given_cycle::{self, GivenCycleFileError};
use crate::given_table::GivenTable;
use crate::study::{LoadedStudy, StudyFileError};
use ocmc_core::fleet::run::{RunPlan, run, run_with};
use ocmc_core::operating_cycle::given::{GivenCycle, Keep};
use ocmc_core::prescribed::{DriveCycle, follow_planned, follow_study};
use ocmc_core::simulation::record::{Outcome, Record};
use ocmc_core::study::Study;
use std::ops::{ControlFlow, Range};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use thiserror::Error;

/// How a speed is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Follow {
    /// By a driver of the study: its speeds are limits along the road, its standstills are stops.
    Driver,
    /// By nobody: the exact force balance of the prescribed speed.
    Exact,
}

impl Follow {
    /// Both ways.
    pub const ALL: [Self; 2] = [Self::Driver, Self::Exact];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Driver => "driver",
            Self::Exact => "exact",
        }
    }
}

/// Why nothing can be driven.
#[derive(Debug, Error)]
pub enum GivenDriveError {
    /// Several files where one can be followed.
    #[error("--follow-speed follows one file; give one")]
    Several,
    /// A route, which has a driver anyway.
    #[error(
        "--follow-speed driver takes a drive cycle over time; a route is driven by a driver without it"
    )]
    Route,
    /// A drive cycle that is not one.
    #[error(transparent)]
    DriveCycle(#[from] DriveCycleFileError),
    /// A route that is not one.
    #[error(transparent)]
    GivenCycle(#[from] GivenCycleFileError),
}

/// What is driven.
#[derive(Clone, Debug)]
pub struct GivenDrive {
    files: Vec<PathBuf>,
    keep: Vec<Keep>,
    how: How,
}

#[derive(Clone, Debug)]
enum How {
    /// Drivers on the routes.
    Routes,
    /// A driver on the road that a drive cycle makes.
    CycleAsRoute(Box<GivenCycle>),
    /// The speed of a drive cycle.
    Cycle(DriveCycle),
    /// The speed that drivers plan along a route.
    Planned,
}

impl GivenDrive {
    /// Reads what has to be known before a study is. Routes are read with the study.
    ///
    /// # Errors
    /// [`GivenDriveError`] names the file, the place and what is allowed.
    pub fn read(
        files: Vec<PathBuf>,
        keep: Vec<Keep>,
        follow: Option<Follow>,
    ) -> Result<Self, GivenDriveError> {
        let how = match follow {
            None => How::Routes,
            Some(follow) => followed(&files, follow)?,
        };
        Ok(Self { files, keep, how })
    }

    /// A drive cycle over time that a calling program holds as a table.
    ///
    /// # Errors
    /// As [`GivenDrive::read`].
    pub fn of_table(table: &GivenTable, follow: Follow) -> Result<Self, GivenDriveError> {
        let path = table.path().to_owned();
        let cells = DelimitedTable::of_table(table).map_err(DriveCycleFileError::from)?;
        let how = cycle(&path, drive_cycle::of_table(&cells)?, follow)?;
        Ok(Self { files: vec![path], keep: Vec::new(), how })
    }

    /// Whether nobody drives.
    fn is_exact(&self) -> bool {
        matches!(self.how, How::Cycle(_) | How::Planned)
    }

    /// Whether the study that the manifest of a run holds repeats it.
    pub fn is_repeatable(&self) -> bool {
        matches!(self.how, How::Routes)
    }

    /// The study as it is driven.
    ///
    /// # Errors
    /// As [`LoadedStudy::on_routes`].
    pub fn study(&self, loaded: LoadedStudy) -> Result<LoadedStudy, StudyFileError> {
        let called = |loaded: LoadedStudy, follow: Follow| {
            let file = self.files.first().map(|file| file.display().to_string());
            loaded.called(&format!("following {} ({})", file.unwrap_or_default(), follow.name()))
        };
        match &self.how {
            How::Routes => loaded.on_routes(&self.files, &self.keep),
            How::CycleAsRoute(route) => {
                called(loaded, Follow::Driver).on_route(&self.files[0], (**route).clone())
            }
            How::Cycle(_) => Ok(called(loaded, Follow::Exact)),
            How::Planned => called(loaded, Follow::Exact).on_routes(&self.files, &self.keep),
        }
    }

    /// Drives the plan, as [`run`] does.
    pub fn run<B>(
        &self,
        study: &Study,
        plan: &RunPlan,
        sink: impl FnMut(Vec<Record>) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        let one = |cycle_id| match &self.how {
            How::Cycle(cycle) => follow_study(study, plan.seed, cycle_id, cycle).0,
            // a plan that is no drive cycle is a cycle that cannot be driven
            _ => follow_planned(study, plan.seed, cycle_id).map_or_else(
                |_| Record { cycle_id, outcome: Outcome::Stalled, ..Record::default() },
                |done| done.0,
            ),
        };
        if !self.is_exact() {
            return run(study, plan, sink);
        }
        let each = |ids: Range<u64>, stop: &AtomicBool| {
            ids.take_while(|_| !stop.load(Ordering::Relaxed)).map(one).collect()
        };
        run_with(plan, &each, sink)
    }
}

fn followed(files: &[PathBuf], follow: Follow) -> Result<How, GivenDriveError> {
    let [file] = files else { return Err(GivenDriveError::Several) };
    if !drive_cycle::is_one(file) {
        if follow == Follow::Driver {
            return Err(GivenDriveError::Route);
        }
        given_cycle::read(file)?;
        return Ok(How::Planned);
    }
    cycle(file, drive_cycle::read(file)?, follow)
}

fn cycle(file: &Path, cycle: DriveCycle, follow: Follow) -> Result<How, GivenDriveError> {
    Ok(match follow {
        Follow::Driver => How::CycleAsRoute(Box::new(drive_cycle::as_route(file, &cycle)?)),
        Follow::Exact => How::Cycle(cycle),
    })
}

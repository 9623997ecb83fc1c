//! `ocmc drive`: given operating cycles, driven by the population of a study, and speeds that are followed.

use crate::arguments::{self, DriveArguments};
use crate::failure::Failure;
use crate::log::mappings;
use crate::output;
use crate::request;
use crate::run::run_study;
use ocmc_core::operating_cycle::route::Keep;
use ocmc_io::given_drive::{Follow, GivenDrive, GivenDriveError};

/// Reads what is given, runs the study on it, and prints the answer.
pub(crate) fn drive(arguments: &DriveArguments) -> Result<(), Failure> {
    let keep: Vec<Keep> = arguments.keep.iter().copied().map(Keep::from).collect();
    let typed = &arguments.run;
    let follow = arguments.follow_speed.map(|how| match how {
        arguments::Follow::Driver => Follow::Driver,
        arguments::Follow::Exact => Follow::Exact,
    });
    let given = GivenDrive::read(arguments.files.clone(), mappings(&arguments.map)?, keep, follow);
    let given = given.map_err(|error| match error {
        GivenDriveError::Several | GivenDriveError::Route => {
            request::usage(&format!("--follow-speed: {error}"))
        }
        GivenDriveError::Keep { .. } => request::usage(&format!("--keep: {error}")),
        GivenDriveError::DriveCycle(error) => error.into(),
        GivenDriveError::GivenCycle(error) => error.into(),
    })?;
    for warning in given.warnings() {
        output::note(&format!("warning: {warning}"));
    }
    run_study(typed, given)
}

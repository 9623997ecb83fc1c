//! `ocmc drive`: given operating cycles, driven by the population of a study, and speeds that are followed.

use crate::arguments::{self, DriveArguments};
use crate::failure::Failure;
use crate::output;
use crate::request;
use crate::run::run_study;
use ocmc_core::operating_cycle::route::Keep;
use ocmc_io::given_cycle;
use ocmc_io::given_drive::{Follow, GivenDrive, GivenDriveError};
use std::path::PathBuf;

/// Reads what is given, runs the study on it, and prints the answer.
pub(crate) fn drive(arguments: &DriveArguments) -> Result<(), Failure> {
    let keep: Vec<Keep> = arguments.keep.iter().copied().map(Keep::from).collect();
    let typed = &arguments.run;
    let follow = arguments.follow_speed.map(|how| match how {
        arguments::Follow::Driver => Follow::Driver,
        arguments::Follow::Exact => Follow::Exact,
    });
    let mission = keep.contains(&Keep::Mission);
    let given = GivenDrive::read(arguments.files.clone(), keep, follow);
    let given = given.map_err(|error| match error {
        GivenDriveError::Several | GivenDriveError::Route => {
            request::usage(&format!("--follow-speed: {error}"))
        }
        GivenDriveError::Keep { .. } => request::usage(&format!("--keep: {error}")),
        GivenDriveError::DriveCycle(error) => error.into(),
        GivenDriveError::GivenCycle(error) => error.into(),
    })?;
    if mission {
        tell_without_departure(&arguments.files);
    }
    run_study(typed, given)
}

/// Says which files hold a mission without its departure, which is then drawn.
fn tell_without_departure(files: &[PathBuf]) {
    for file in files {
        // what cannot be read is said when the study is made
        if given_cycle::read(file).is_ok_and(|cycle| cycle.departure.is_none()) {
            output::note(&format!(
                "warning: `{}` holds no departure, which is drawn from the study: of what `ocmc cycle` writes only the .json has it",
                file.display()
            ));
        }
    }
}

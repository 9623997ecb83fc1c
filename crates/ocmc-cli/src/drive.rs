//! `ocmc drive`: given operating cycles, driven by the population of a study, and speeds that are
//! followed.

use crate::arguments::{self, DriveArguments};
use crate::failure::Failure;
use crate::output::warn;
use crate::run::run_given;
use ocmc_api::{Error, Follow, GivenDrive, Keep, mappings};

/// Reads what is given, runs the study on it, and prints the answer.
pub(crate) fn drive(arguments: &DriveArguments) -> Result<(), Failure> {
    let keep: Vec<Keep> = arguments.keep.iter().copied().map(Keep::from).collect();
    let follow = arguments.follow_speed.map(|how| match how {
        arguments::Follow::Driver => Follow::Driver,
        arguments::Follow::Exact => Follow::Exact,
    });
    let given = GivenDrive::read(arguments.files.clone(), mappings(&arguments.map)?, keep, follow)
        .map_err(Error::from)?;
    given.warnings().iter().for_each(|warning| warn(warning));
    run_given(&arguments.run, &given)
}

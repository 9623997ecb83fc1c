//! `ocmc drive`: given operating cycles, driven by the population of a study.

use crate::arguments::DriveArguments;
use crate::failure::Failure;
use crate::run::run_study;
use ocmc_core::operating_cycle::given::Keep;
use ocmc_io::study;

/// Reads the routes, runs the study on them, and prints the answer.
pub(crate) fn drive(arguments: &DriveArguments) -> Result<(), Failure> {
    let keep: Vec<Keep> = arguments.keep.iter().copied().map(Keep::from).collect();
    run_study(&arguments.run, || {
        let loaded = study::load(&arguments.run.study, &arguments.run.set)?;
        Ok(loaded.on_routes(&arguments.files, &keep)?)
    })
}

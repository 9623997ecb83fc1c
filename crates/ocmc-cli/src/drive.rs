//! `ocmc drive`: given operating cycles, driven by the population of a study, and drive cycles, followed.

use crate::arguments::{DriveArguments, Follow};
use crate::failure::Failure;
use crate::request;
use crate::run::run_study;
use ocmc_core::fleet::run::{run, run_with};
use ocmc_core::operating_cycle::given::Keep;
use ocmc_core::prescribed::follow_study;
use ocmc_io::{
    drive_cycle,
    study::{self, LoadedStudy},
};

/// Reads the routes, runs the study on them, and prints the answer.
pub(crate) fn drive(arguments: &DriveArguments) -> Result<(), Failure> {
    let keep: Vec<Keep> = arguments.keep.iter().copied().map(Keep::from).collect();
    let load = || -> Result<LoadedStudy, Failure> {
        Ok(study::load(&arguments.run.study, &arguments.run.set)?)
    };
    let Some(follow) = arguments.follow_speed else {
        let load = || Ok(load()?.on_routes(&arguments.files, &keep)?);
        return run_study(&arguments.run, load, true, |study, plan, sink| run(study, plan, sink));
    };
    let [file] = arguments.files.as_slice() else {
        return Err(request::usage("--follow-speed follows one drive cycle; give one file"));
    };
    let cycle = drive_cycle::read(file)?;
    let how = match follow {
        Follow::Driver => "driver",
        Follow::Exact => "exact",
    };
    let load = || load().map(|l| l.called(&format!("following {} ({how})", file.display())));
    match follow {
        Follow::Driver => {
            let route = drive_cycle::as_route(file, &cycle)?;
            let load = || Ok(load()?.on_route(file, route)?);
            run_study(&arguments.run, load, false, |study, plan, sink| run(study, plan, sink))
        }
        Follow::Exact => run_study(&arguments.run, load, false, |study, plan, sink| {
            let one = |id| follow_study(study, plan.seed, id, &cycle).0;
            run_with(plan, &|ids, _| ids.map(one).collect(), sink)
        }),
    }
}

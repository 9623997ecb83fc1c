//! `ocmc drive`: given operating cycles, driven by the population of a study, and speeds that are followed.

use crate::arguments::{DriveArguments, Follow};
use crate::failure::Failure;
use crate::request;
use crate::run::{Given, run_study};
use ocmc_core::fleet::run::{run, run_with};
use ocmc_core::operating_cycle::given::Keep;
use ocmc_core::prescribed::{follow_planned, follow_study};
use ocmc_core::simulation::record::{Outcome, Record};
use ocmc_io::study::{self, LoadedStudy};
use ocmc_io::{drive_cycle, given_cycle};

/// Reads the routes, runs the study on them, and prints the answer.
pub(crate) fn drive(arguments: &DriveArguments) -> Result<(), Failure> {
    let keep: Vec<Keep> = arguments.keep.iter().copied().map(Keep::from).collect();
    let typed = &arguments.run;
    let Some(follow) = arguments.follow_speed else {
        let load =
            || Ok(study::load(&typed.study, &typed.set)?.on_routes(&arguments.files, &keep)?);
        return run_study(typed, load, Given::Routes, |study, plan, sink| run(study, plan, sink));
    };
    let [file] = arguments.files.as_slice() else {
        return Err(request::usage("--follow-speed follows one file; give one"));
    };
    if typed.resume {
        return Err(request::usage(
            "a run that follows a speed cannot be resumed: its directory does not hold the speed; run it again with another --out",
        ));
    }
    let how = match follow {
        Follow::Driver => "driver",
        Follow::Exact => "exact",
    };
    let called =
        |loaded: LoadedStudy| loaded.called(&format!("following {} ({how})", file.display()));
    if drive_cycle::is_one(file) {
        let cycle = drive_cycle::read(file)?;
        return match follow {
            Follow::Driver => {
                let route = drive_cycle::as_route(file, &cycle)?;
                let load =
                    || Ok(called(study::load(&typed.study, &typed.set)?).on_route(file, route)?);
                run_study(typed, load, Given::Speed, |study, plan, sink| run(study, plan, sink))
            }
            Follow::Exact => {
                let load = || Ok(called(study::load(&typed.study, &typed.set)?));
                run_study(typed, load, Given::Speed, |study, plan, sink| {
                    let one = |id| follow_study(study, plan.seed, id, &cycle).0;
                    run_with(plan, &|ids, _| ids.map(one).collect(), sink)
                })
            }
        };
    }
    if follow == Follow::Driver {
        return Err(request::usage(
            "--follow-speed driver takes a drive cycle over time; a route is driven by a driver without it",
        ));
    }
    given_cycle::read(file).map_err(Failure::GivenCycle)?;
    let load = || {
        let loaded = study::load(&typed.study, &typed.set)?;
        Ok(called(loaded.on_routes(&arguments.files, &keep)?))
    };
    run_study(typed, load, Given::Speed, |study, plan, sink| {
        // a plan that is no drive cycle is a cycle that cannot be driven
        let stalled =
            |cycle_id| Record { cycle_id, outcome: Outcome::Stalled, ..Record::default() };
        let one =
            |id| follow_planned(study, plan.seed, id).map_or_else(|_| stalled(id), |done| done.0);
        run_with(plan, &|ids, _| ids.map(one).collect(), sink)
    })
}

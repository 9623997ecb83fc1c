//! The routes of a study: `mission.routes` names files with given operating cycles, read when the
//! study is loaded.

use super::error::{self, Cause};
use super::files::Files;
use crate::given_cycle::{self, RouteOptions};
use crate::intake::table::error::Fault;
use crate::intake::table::{Mapping, TableError};
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::route::RouteModel;
use ocmc_core::study::{Study, StudyModel};
use std::path::{Path, PathBuf};

/// Reads the files of the model's routes and gives them to the study. The
/// model then names each file as it was found, with its hash.
pub(super) fn attach(
    study: Study,
    model: &mut StudyModel,
    files: &Files,
) -> Result<Study, (usize, Box<error::Fault>)> {
    let routes = &mut model.mission.routes;
    let mut cycles = Vec::with_capacity(routes.len());
    for (k, route) in routes.iter_mut().enumerate() {
        let cycle = read(route, files).map_err(|fault| (k, fault))?;
        cycles.push((cycle, route.weight, route.keep.clone(), route.draw.clone()));
    }
    if cycles.is_empty() {
        return Ok(study);
    }
    let unfit = |(k, error)| {
        let file: &RouteModel = &routes[k];
        (k, fault(&given_cycle::in_file(Path::new(&file.file))(error)))
    };
    study.with_routes(cycles).map_err(unfit)
}

fn read(route: &mut RouteModel, files: &Files) -> Result<GivenCycle, Box<error::Fault>> {
    let built_in = given_cycle::built_in(Path::new(&route.file));
    let path = if built_in.is_some() || route.table.is_some() {
        PathBuf::from(&route.file)
    } else {
        files.path("mission.routes.file", &route.file)?
    };
    let plan = route.stop_plan.as_ref();
    let plan = plan.map(|plan| files.path("mission.routes.stop_plan", plan)).transpose()?;
    read_at(route, &path, plan.as_deref(), built_in).map_err(|error| fault(&error))
}

fn read_at(
    route: &mut RouteModel,
    path: &Path,
    plan: Option<&Path>,
    built_in: Option<&str>,
) -> Result<GivenCycle, TableError> {
    let table = route.table.as_deref();
    let cycle = if let Some(text) = built_in.filter(|_| table.is_none()) {
        given_cycle::read_tracks(path, text)?
    } else {
        let mappings = Mapping::of_columns(&route.columns)?;
        let options =
            RouteOptions { mappings: &mappings, draw: &route.draw, stop_plan: plan, table };
        given_cycle::read_route(path, options)?.0
    };
    route.sha256 = Some(checked_hash(path, table, route.sha256.take())?);
    route.file = path.display().to_string();
    if let Some(plan) = plan {
        route.stop_plan_sha256 = Some(checked_hash(plan, None, route.stop_plan_sha256.take())?);
        route.stop_plan = Some(plan.display().to_string());
    }
    Ok(cycle)
}

/// The hash of a file, which has to be the one that is wanted.
fn checked_hash(
    path: &Path,
    table: Option<&str>,
    wanted: Option<String>,
) -> Result<String, TableError> {
    let hash = given_cycle::file_hash(path, table)?;
    match wanted {
        Some(wanted) if wanted != hash => {
            Err(TableError::of(path, Fault::Changed { found: hash, wanted }))
        }
        _ => Ok(hash),
    }
}

/// Fault of the file of a route.
pub(super) fn fault(error: &TableError) -> Box<error::Fault> {
    let mut fault = error::Fault::new(Cause::File(error.to_string()));
    fault.help = error.help().map(str::to_owned);
    fault
}

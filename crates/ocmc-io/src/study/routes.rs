//! The routes of a study: `mission.routes` names files with given operating cycles, read when the
//! study is loaded.

use super::error::{self, Cause};
use super::files::Files;
use crate::given_cycle;
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
    let path = match built_in {
        Some(_) => PathBuf::from(&route.file),
        None => files.path("mission.routes.file", &route.file)?,
    };
    read_at(route, &path, built_in).map_err(|error| fault(&error))
}

fn read_at(
    route: &mut RouteModel,
    path: &Path,
    built_in: Option<&str>,
) -> Result<GivenCycle, TableError> {
    let cycle = if let Some(text) = built_in {
        given_cycle::read_tracks(path, text)?
    } else {
        let mappings = Mapping::of_columns(&route.columns)?;
        given_cycle::read_to_draw(path, &mappings, &route.draw)?.0
    };
    let found = given_cycle::file_hash(path)?;
    if let Some(wanted) = route.sha256.take_if(|wanted| *wanted != found) {
        return Err(TableError::of(path, Fault::Changed { found, wanted }));
    }
    route.file = path.display().to_string();
    route.sha256 = Some(found);
    Ok(cycle)
}

/// What is wrong with the file of a route.
pub(super) fn fault(error: &TableError) -> Box<error::Fault> {
    let mut fault = error::Fault::new(Cause::File(error.to_string()));
    fault.help = error.help().map(str::to_owned);
    fault
}

//! The routes of a study: `mission.routes` names files with given operating cycles, read when the
//! study is loaded.

use super::builtin;
use super::error::{Cause, Fault};
use crate::given_cycle::{self, GivenCycleFileError};
use crate::table::Mapping;
use ocmc_core::operating_cycle::given::GivenCycleError;
use ocmc_core::study::{Study, StudyModel};
use std::path::Path;

/// Reads the files of the model's routes, relative to `folder`, and gives them to the study. The
/// model then names each file as it was found, with its hash.
pub(super) fn attach(
    study: Study,
    model: &mut StudyModel,
    folder: Option<&Path>,
) -> Result<Study, (usize, Box<Fault>)> {
    let mut cycles = Vec::with_capacity(model.mission.routes.len());
    for (k, route) in model.mission.routes.iter_mut().enumerate() {
        let built_in = builtin::route(&route.file);
        let in_folder =
            || folder.map_or_else(|| route.file.clone().into(), |f| f.join(&route.file));
        let path = built_in.map_or_else(in_folder, |_| route.file.clone().into());
        let wrong = |error: &GivenCycleFileError| {
            let fault = fault(error.to_string());
            (k, Box::new(Fault { help: error.help().map(str::to_owned), ..*fault }))
        };
        let cycle = match built_in {
            Some(text) => given_cycle::read_tracks(&path, text),
            None => Mapping::of_columns(&route.columns)
                .map_err(GivenCycleFileError::from)
                .and_then(|mappings| given_cycle::read(&path, &mappings)),
        };
        let cycle = cycle.map_err(|error| wrong(&error))?;
        let found = given_cycle::file_hash(&path).map_err(|error| wrong(&error))?;
        if let Some(wanted) = &route.sha256
            && *wanted != found
        {
            let wanted = wanted.clone();
            return Err(wrong(&GivenCycleFileError::Changed { path, found, wanted }));
        }
        route.file = path.display().to_string();
        route.sha256 = Some(found);
        cycles.push((cycle, route.weight, route.keep.clone()));
    }
    if cycles.is_empty() {
        return Ok(study);
    }
    let files: Vec<String> = model.mission.routes.iter().map(|route| route.file.clone()).collect();
    study.with_routes(cycles).map_err(|(k, source)| (k, unfit(Path::new(&files[k]), source)))
}

/// A given cycle that does not fit the study.
pub(super) fn unfit(file: &Path, source: GivenCycleError) -> Box<Fault> {
    let path = file.to_owned();
    fault(GivenCycleFileError::Cycle { path, source }.to_string())
}

fn fault(message: String) -> Box<Fault> {
    Box::new(Fault::new(Cause::File { message }))
}

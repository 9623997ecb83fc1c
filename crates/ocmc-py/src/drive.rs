//! `Study.drive`: what somebody has given to be driven.

use crate::error::{given_cycle_error, given_drive_error, study_error};
use crate::fit::warn;
use crate::input::{Input, inputs};
use crate::log::mappings;
use crate::run::{PyRun, run_with};
use crate::value::one_of;
use ocmc_core::fleet::run::RunPlan;
use ocmc_core::operating_cycle::route::Keep;
use ocmc_io::given_cycle;
use ocmc_io::given_drive::{Follow, GivenDrive};
use ocmc_io::study::LoadedStudy;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// What is to be driven.
pub(crate) fn given(
    py: Python,
    files: &Bound<PyAny>,
    columns: Option<BTreeMap<String, String>>,
    keep: Option<Vec<String>>,
    follow_speed: Option<&str>,
) -> PyResult<GivenDrive> {
    let follows = Follow::ALL.map(|follow| (follow.name(), follow));
    let follow = follow_speed.map(|word| one_of("follow_speed", word, &follows)).transpose()?;
    let keeps = Keep::ALL.map(|keep| (keep.name(), keep));
    let keep = keep.unwrap_or_default();
    let keep = keep.iter().map(|word| one_of("keep", word, &keeps)).collect::<PyResult<_>>()?;
    let mappings = mappings(columns)?;
    let mut paths: Vec<PathBuf> = Vec::new();
    let mut given = inputs(files, "files")?;
    if let [Input::Table(_)] = given.as_slice()
        && let Some(Input::Table(table)) = given.pop()
    {
        let follow = follow.ok_or_else(|| {
            PyValueError::new_err(
                "`files` is a table, which is a drive cycle over time: say with `follow_speed` how to follow it; routes \
                 come as files",
            )
        })?;
        let given = py.detach(|| GivenDrive::of_table(&table, &mappings, keep, follow));
        return given.map_err(|error| given_drive_error(&error));
    }
    for file in given {
        match file {
            Input::File(path) => paths.push(path),
            Input::Table(_) => {
                return Err(PyValueError::new_err("`files` has several items, allowed are paths"));
            }
        }
    }
    let (given, warnings) = py.detach(|| {
        for path in &paths {
            given_cycle::check_readable(path).map_err(|error| given_cycle_error(&error))?;
        }
        let given = GivenDrive::read(paths, mappings, keep, follow);
        let given = given.map_err(|error| given_drive_error(&error))?;
        let warnings = given.warnings();
        Ok::<_, PyErr>((given, warnings))
    })?;
    for warning in &warnings {
        warn(py, warning)?;
    }
    Ok(given)
}

/// Drives it.
pub(crate) fn drive(
    py: Python,
    study: &LoadedStudy,
    given: &GivenDrive,
    plan: &RunPlan,
    progress: Option<&Bound<PyAny>>,
) -> PyResult<PyRun> {
    let study = py.detach(|| given.study(study.clone())).map_err(|error| study_error(&error))?;
    run_with(py, &study, plan, progress, given)
}

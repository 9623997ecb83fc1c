//! `Study.drive`: what is given to be driven.

use crate::answer::warn;
use crate::error::exception;
use crate::input::inputs;
use crate::log::mappings;
use crate::value::one_of;
use ocmc_api::{Error, Follow, GivenDrive, Keep, Source, check_readable};
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
    if let [Source::Table(_)] = given.as_slice()
        && let Some(Source::Table(table)) = given.pop()
    {
        let follow = follow.ok_or_else(|| {
            PyValueError::new_err(
                "`files` is a table, which is a drive cycle over time: say with `follow_speed` how to follow it; routes \
                 come as files",
            )
        })?;
        let given = py.detach(|| GivenDrive::of_table(&table, &mappings, keep, follow));
        return given.map_err(|error| exception(&error.into()));
    }
    for file in given {
        match file {
            Source::File(path) => paths.push(path),
            Source::Table(_) => {
                return Err(PyValueError::new_err("`files` has several items, allowed are paths"));
            }
        }
    }
    let read = py.detach(|| -> Result<_, Error> {
        for path in &paths {
            check_readable(path)?;
        }
        let given = GivenDrive::read(paths, mappings, keep, follow)?;
        let warnings = given.warnings();
        Ok((given, warnings))
    });
    let (given, warnings) = read.map_err(|error| exception(&error))?;
    for warning in &warnings {
        warn(py, warning)?;
    }
    Ok(given)
}

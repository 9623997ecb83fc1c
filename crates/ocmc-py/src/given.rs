//! Drives in place of a study's roads, from arguments.

use crate::answer::warn;
use crate::error::exception;
use crate::input::{inputs, mappings};
use crate::progress::note;
use crate::value::one_of;
use ocmc_api::{Account, DRAWS, Error, FOLLOWS, GivenDrive, KEEPS, Source, check_readable};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Drive from arguments.
pub(crate) fn given(
    py: Python,
    files: &Bound<PyAny>,
    columns: Option<BTreeMap<String, String>>,
    keep: Option<Vec<String>>,
    draw: Option<Vec<String>>,
    stop_plan: Option<PathBuf>,
    follow_speed: Option<&str>,
    progress: Option<&Bound<PyAny>>,
) -> PyResult<(GivenDrive, Vec<Account>)> {
    let follow = follow_speed.map(|word| one_of("follow_speed", word, &FOLLOWS)).transpose()?;
    let keep = keep.unwrap_or_default();
    let keep = keep.iter().map(|word| one_of("keep", word, &KEEPS)).collect::<PyResult<_>>()?;
    let draw = draw.unwrap_or_default();
    let draw = draw.iter().map(|word| one_of("draw", word, &DRAWS)).collect::<PyResult<_>>()?;
    let mappings = mappings(columns)?;
    let files = inputs(files, "files")?;
    if let [Source::Table(table)] = files.as_slice() {
        let read = py.detach(|| -> Result<_, Error> {
            let given = GivenDrive::of_table(table, mappings, keep, draw, stop_plan, follow)?;
            let accounts = given.accounts();
            Ok((given, accounts))
        });
        return told(py, read.map_err(exception)?, progress);
    }
    let paths = files.into_iter().map(|file| match file {
        Source::File(path) => Ok(path),
        Source::Table(_) => {
            Err(PyValueError::new_err("`files` has several items, allowed are paths, or one table"))
        }
    });
    let paths: Vec<PathBuf> = paths.collect::<PyResult<_>>()?;
    let read = py.detach(|| -> Result<_, Error> {
        paths.iter().try_for_each(|path| check_readable(path))?;
        let given = GivenDrive::read(paths, mappings, keep, draw, stop_plan, follow)?;
        let accounts = given.accounts();
        Ok((given, accounts))
    });
    told(py, read.map_err(exception)?, progress)
}

/// Says what was read, and warns of what is odd in it.
fn told(
    py: Python,
    (given, accounts): (GivenDrive, Vec<Account>),
    progress: Option<&Bound<PyAny>>,
) -> PyResult<(GivenDrive, Vec<Account>)> {
    if let Some(read) = given.cycle_account() {
        read.told().iter().try_for_each(|told| note(py, progress, told))?;
        read.warnings().iter().try_for_each(|warning| warn(py, warning))?;
    }
    let told = accounts.iter().flat_map(|account| &account.told);
    told.into_iter().try_for_each(|told| note(py, progress, told))?;
    let doubts = accounts.iter().flat_map(|account| account.warnings.iter().cloned());
    given.warnings().into_iter().chain(doubts).try_for_each(|warning| warn(py, &warning))?;
    Ok((given, accounts))
}

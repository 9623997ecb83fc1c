//! `ocmc.Study.sweep`: values of a study's keys, in a grid or one by one.

use crate::answer::answer;
use crate::error::{exception, study_error};
use crate::input::{input, is_path, sequence, speaks_arrow};
use crate::progress::watched;
use crate::study::written;
use crate::value::{one_of, wrong_type};
use ocmc_api::study::LoadedStudy;
use ocmc_api::{AGAINSTS, MOST_POINTS, RunPlan, SweepPoints, SweepRequest};
use pyo3::prelude::*;
use pyo3::types::{PyMapping, PyString};

/// Drives the points, and compares them.
pub(crate) fn sweep<'py>(
    py: Python<'py>,
    study: &LoadedStudy,
    points: &Bound<'py, PyAny>,
    against: &str,
    plan: RunPlan,
    column: Option<&str>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let against = one_of("against", against, &AGAINSTS)?;
    let (fixed, points) = points_of(points)?;
    let base = study.set(&fixed).map_err(study_error)?;
    let study = (base.model.study.name.clone(), &base);
    let request = SweepRequest { study, points, against, plan, column: column.map(str::to_owned) };
    answer(py, &watched(py, progress, |watch| ocmc_api::sweep(&request, watch))?)
}

/// Settings that hold for all points, and the points.
fn points_of(points: &Bound<PyAny>) -> PyResult<(Vec<String>, SweepPoints)> {
    if speaks_arrow(points)? || is_path(points)? {
        let list = SweepPoints::list(&input(points, "points")?).map_err(exception)?;
        return Ok((Vec::new(), list));
    }
    if let Ok(grid) = points.cast::<PyMapping>() {
        let keys = pairs(grid)?.into_iter().map(|(key, values)| {
            let values = values_of(&key, &values)?;
            Ok((key, values))
        });
        return SweepPoints::grid(keys.collect::<PyResult<_>>()?).map_err(exception);
    }
    let Some(list) = sequence(points, "points")? else {
        let allowed = "a dictionary of lists, a list of dictionaries, a table or a file";
        return Err(wrong_type(points, "points", allowed));
    };
    let mut keys: Vec<String> = Vec::new();
    let mut rows: Vec<Vec<Option<String>>> = Vec::new();
    for (k, point) in list.iter().enumerate() {
        let mapping = point.cast::<PyMapping>();
        let mapping = mapping.map_err(|_| {
            wrong_type(point, &format!("points[{k}]"), "a dictionary of keys and values")
        })?;
        let mut row = vec![None; keys.len()];
        for (key, value) in pairs(mapping)? {
            let value = if value.is_none() { None } else { Some(written(&key, &value)?) };
            if let Some(place) = keys.iter().position(|known| *known == key) {
                row[place] = value;
            } else {
                keys.push(key);
                row.push(value);
            }
        }
        rows.push(row);
    }
    for row in &mut rows {
        row.resize(keys.len(), None);
    }
    Ok((Vec::new(), SweepPoints::new(keys, rows).map_err(exception)?))
}

fn pairs<'py>(mapping: &Bound<'py, PyMapping>) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
    mapping.items()?.extract()
}

/// The values of a key of a grid: those of a list, or a single one.
fn values_of(key: &str, values: &Bound<PyAny>) -> PyResult<Vec<String>> {
    let is_one = values.is_instance_of::<PyString>() || values.cast::<PyMapping>().is_ok();
    match values.try_iter() {
        // one more than there may be is refused, and the values may be endless
        Ok(values) if !is_one => {
            values.take(MOST_POINTS + 1).map(|value| written(key, &value?)).collect()
        }
        _ => Ok(vec![written(key, values)?]),
    }
}

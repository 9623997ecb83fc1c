//! `ocmc.Study`: the class, and from what it is made.

use crate::answer::warn;
use crate::error::study_error;
use crate::value::study_value;
use ocmc_api::study::{
    self, BuiltIn, Files, Given, LoadedStudy, Opened, StudyFileError, StudyModel,
};
use pyo3::exceptions::{PyAttributeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};
use std::path::PathBuf;

const NO_SETTINGS: &[&str] = &[];

/// A study: models of operating cycles, drivers and vehicles, and the numerics.
///
/// A study does not change; `set` makes another one. Studies are equal where they give the same
/// records, and can be pickled. Its values are read as attributes, ``study.vehicle.drag_area_m2``,
/// or by their paths, ``study["vehicle.drag_area_m2"]``; the tab key completes both.
///
/// Parameters
/// ----------
/// source : str, os.PathLike or dict
///     Name of a built-in study such as ``"field-truck"``, path of a study file (TOML), or a
///     dictionary of the same shape. SI units throughout, with the unit as the key's suffix.
/// allow_files : bool, default True
///     Whether a study may be a file, and name files. A service that runs studies of others says
///     False: then only built-in studies and dictionaries are read, and nothing is opened.
///
/// Raises
/// ------
/// ValueError
///     Where the study is not one. The message names the key, its value and the allowed values.
/// OSError
///     Where the file cannot be read.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> study = ocmc.Study("field-truck").set("mission.length_m", 5000.0)
/// >>> study.mission.length_m
/// 5000.0
/// >>> run = study.run(cycles=100, seed=1)
/// >>> bool(20.0 < run["consumption_l_per_100km"].mean() < 60.0)
/// True
#[pyclass(name = "Study", module = "ocmc", frozen)]
pub(crate) struct PyStudy {
    pub(crate) loaded: LoadedStudy,
    pub(crate) hash: String,
}

impl PyStudy {
    /// The study, or what is wrong with it as an exception.
    pub(crate) fn new(loaded: Result<LoadedStudy, StudyFileError>) -> PyResult<Self> {
        let loaded = loaded.map_err(study_error)?;
        let warnings = loaded.warnings();
        Python::attach(|py| warnings.iter().try_for_each(|warning| warn(py, warning)))?;
        let hash = study::study_hash(&loaded.model);
        Ok(Self { loaded, hash })
    }

    /// The study under its name.
    pub(crate) fn named(&self) -> (String, &LoadedStudy) {
        (self.loaded.model.study.name.clone(), &self.loaded)
    }
}

/// A study by its name, its file or a dictionary.
pub(crate) fn of_source(source: &Bound<PyAny>, allow_files: bool) -> PyResult<PyStudy> {
    let opened = opened(source, allow_files)?;
    PyStudy::new(opened.one())
}

/// As [`of_source`], of a study or of the groups of a fleet.
pub(crate) fn opened(source: &Bound<PyAny>, allow_files: bool) -> PyResult<Opened> {
    let files = if allow_files { Files::here() } else { Files::Refused };
    if source.cast::<PyMapping>().is_ok() {
        let dictionary = study_value(source, "")?;
        let opened = study::open_all(&Given::Dictionary(&dictionary), &files, NO_SETTINGS);
        return opened.map_err(study_error);
    }
    let path: PathBuf = source
        .extract()
        .map_err(|_| PyTypeError::new_err("a study is a built-in name, a path or a dictionary"))?;
    let open = || study::open_all(&Given::Named(&path), &files, NO_SETTINGS);
    source.py().detach(open).map_err(study_error)
}

/// The dictionary of a study's text.
pub(crate) fn dictionary<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyDict>> {
    Ok(py.import("tomllib")?.call_method1("loads", (text,))?.cast_into()?)
}

/// A table of a study's dictionary, with its values as attributes.
pub(crate) fn attribute<'py>(
    py: Python<'py>,
    content: impl FnOnce() -> PyResult<Bound<'py, PyDict>>,
    name: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let missing = || {
        let text = format!("a study has no {name:?}; dir() lists what it has");
        PyAttributeError::new_err(text)
    };
    if name.starts_with('_') {
        return Err(missing());
    }
    let table = content()?.get_item(name)?.ok_or_else(missing)?;
    py.import("ocmc._section")?.call_method1("section", (table, name))
}

/// The setting of a key of a study to a value.
pub(crate) fn setting(path: &str, value: &Bound<PyAny>) -> PyResult<String> {
    Ok(format!("{path}={}", written(path, value)?))
}

/// A value of a key as TOML.
pub(crate) fn written(path: &str, value: &Bound<PyAny>) -> PyResult<String> {
    let value = toml::Value::try_from(study_value(value, path)?);
    let value = value.map_err(|error| PyValueError::new_err(format!("`{path}`: {error}")))?;
    Ok(value.to_string())
}

/// The settings of a dictionary of keys and values, if there is one.
pub(crate) fn settings(values: Option<&Bound<PyDict>>) -> PyResult<Vec<String>> {
    let keys = values.into_iter().flatten();
    keys.map(|(path, value)| setting(&path.extract::<String>()?, &value)).collect()
}

/// The study that keeps what is not fitted.
pub(crate) fn base_model(base: Option<&Bound<PyStudy>>) -> StudyModel {
    match base {
        Some(study) => study.get().loaded.model.clone(),
        None => study::load("field-truck", &[] as &[&str]).expect("a built-in study is one").model,
    }
}

/// The built-in studies.
///
/// Returns
/// -------
/// dict of str to str
///     A description of each, by its name, the default one first.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> next(iter(ocmc.studies()))
/// 'field-truck'
#[pyfunction]
pub(crate) fn studies(py: Python) -> PyResult<Bound<PyDict>> {
    described(py, study::list())
}

/// The built-in vehicles, which a study takes by ``vehicle.base``.
///
/// Returns
/// -------
/// dict of str to str
///     A description of each, by its name.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> "rigid-12t" in ocmc.vehicles()
/// True
#[pyfunction]
pub(crate) fn vehicles(py: Python) -> PyResult<Bound<PyDict>> {
    described(py, study::vehicles())
}

fn described<'py>(py: Python<'py>, built_in: &[BuiltIn]) -> PyResult<Bound<'py, PyDict>> {
    let described = PyDict::new(py);
    for built_in in built_in {
        described.set_item(built_in.name, built_in.description())?;
    }
    Ok(described)
}

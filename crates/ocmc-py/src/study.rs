//! `ocmc.Study`: the class; [`crate::question`] has what is asked of it.

use crate::error::study_error;
use ocmc_api::study::{self, LoadedStudy, StudyFileError, StudyModel};
use pyo3::prelude::*;

/// A study: models of operating cycles, drivers and vehicles, and the numerics.
///
/// A study does not change; `set` makes another one. Studies are equal where they give the same
/// records, and can be pickled.
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
///     Where the study is not one: says which key, what its value is, and what is allowed.
/// OSError
///     Where the file cannot be read.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> study = ocmc.Study("field-truck").set("mission.length_m", 5000.0)
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
        let hash = study::study_hash(&loaded.model);
        Ok(Self { loaded, hash })
    }
}

/// The study that keeps what is not fitted.
pub(crate) fn base_model(base: Option<&Bound<PyStudy>>) -> StudyModel {
    match base {
        Some(study) => study.get().loaded.model.clone(),
        None => study::load("field-truck", &[] as &[&str]).expect("a built-in study is one").model,
    }
}

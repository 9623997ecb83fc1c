//! Answers and warnings on their way to Python.

use ocmc_api::Answer;
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use std::ffi::CString;

/// An answer as ``ocmc.Answer``, and its warnings as warnings.
pub(crate) fn answer<'py>(py: Python<'py>, answer: &impl Answer) -> PyResult<Bound<'py, PyAny>> {
    answer.warnings().iter().try_for_each(|warning| warn(py, warning))?;
    let content = py.import("json")?.call_method1("loads", (answer.to_json(),))?;
    py.import("ocmc._answer")?.call_method1("Answer", (content, answer.text()))
}

/// Something that has to be known, as a warning.
pub(crate) fn warn(py: Python, text: &str) -> PyResult<()> {
    let text = CString::new(text.replace('\0', " ")).expect("no zeros are left");
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1)
}

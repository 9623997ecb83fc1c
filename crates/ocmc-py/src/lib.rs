//! The compiled part of the Python package `ocmc`: conversions between Python and the engine, and nothing else.
#![allow(
    clippy::doc_link_with_quotes,
    reason = "documentation in the form that Python's tools read"
)]
#![allow(clippy::needless_pass_by_value, reason = "arguments of Python arrive as converted values")]

mod column;
mod error;
mod run;
mod study;
mod value;

use pyo3::prelude::*;
use std::ffi::OsString;

/// The compiled part of `ocmc`; import `ocmc` instead.
#[pymodule]
fn _ocmc(module: &Bound<PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<study::PyStudy>()?;
    module.add_class::<run::PyRun>()?;
    module.add_function(wrap_pyfunction!(run::load, module)?)?;
    module.add_function(wrap_pyfunction!(run_from, module)?)
}

/// Run the command with these arguments, the program's name first, and return its exit status.
#[pyfunction]
fn run_from(py: Python, arguments: Vec<OsString>) -> i32 {
    py.detach(|| ocmc_cli::run_from(arguments))
}

//! The compiled part of the Python package `ocmc`: conversions between Python and the engine, and
//! nothing else.
#![allow(
    clippy::doc_link_with_quotes,
    reason = "documentation in the form that Python's tools read"
)]
#![allow(clippy::needless_pass_by_value, reason = "arguments of Python arrive as converted values")]

mod answer;
mod benchmark;
mod calibrate;
mod compare;
mod cost;
mod error;
mod fit;
mod given;
mod input;
mod learn;
mod log;
mod mixed_fleet;
mod operating_cycle;
mod pickle;
mod plan;
mod progress;
mod question;
mod road;
mod run;
mod simulator_study;
mod study;
mod sweep;
mod table;
mod value;

use pyo3::prelude::*;
use std::ffi::OsString;

/// The compiled part of `ocmc`; import `ocmc` instead.
#[pymodule]
fn _ocmc(module: &Bound<PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<study::PyStudy>()?;
    module.add_class::<run::PyRun>()?;
    module.add_class::<operating_cycle::PyOperatingCycle>()?;
    module.add_class::<table::Table>()?;
    module.add_function(wrap_pyfunction!(run::load, module)?)?;
    module.add_function(wrap_pyfunction!(benchmark::benchmark, module)?)?;
    module.add_function(wrap_pyfunction!(calibrate::calibrate_curve_speed, module)?)?;
    module.add_function(wrap_pyfunction!(fit::fit_curve_speed, module)?)?;
    module.add_function(wrap_pyfunction!(fit::fit_speed_change, module)?)?;
    module.add_function(wrap_pyfunction!(fit::fit_operating_cycle, module)?)?;
    module.add_function(wrap_pyfunction!(fit::fit_fleet, module)?)?;
    module.add_function(wrap_pyfunction!(fit::fit_traffic, module)?)?;
    module.add_function(wrap_pyfunction!(fit::fit_weather, module)?)?;
    module.add_function(wrap_pyfunction!(learn::learn, module)?)?;
    module.add_function(wrap_pyfunction!(log::identify, module)?)?;
    module.add_function(wrap_pyfunction!(log::detect_curves, module)?)?;
    module.add_function(wrap_pyfunction!(road::road, module)?)?;
    module.add_function(wrap_pyfunction!(road::validate, module)?)?;
    module.add_function(wrap_pyfunction!(simulator_study::simulator_study, module)?)?;
    module.add_function(wrap_pyfunction!(compare::compare, module)?)?;
    module.add_function(wrap_pyfunction!(mixed_fleet::mixed_fleet, module)?)?;
    module.add_function(wrap_pyfunction!(run::joined, module)?)?;
    module.add_function(wrap_pyfunction!(run::merge, module)?)?;
    module.add_function(wrap_pyfunction!(study::studies, module)?)?;
    module.add_function(wrap_pyfunction!(study::vehicles, module)?)?;
    module.add_function(wrap_pyfunction!(run::unpickled, module)?)?;
    module.add_function(wrap_pyfunction!(table::unpickled_table, module)?)?;
    module.add_function(wrap_pyfunction!(label_of, module)?)?;
    module.add_function(wrap_pyfunction!(run_from, module)?)
}

/// Run the command with these arguments, the program's name first, and return its exit status.
#[pyfunction]
fn run_from(py: Python, arguments: Vec<OsString>) -> i32 {
    py.detach(|| ocmc_cli::run_from(arguments))
}

/// How a quantity of the summary is printed: its name with the unit for people, and the factor to
/// that unit.
#[pyfunction]
#[pyo3(name = "label")]
fn label_of(column: &str) -> (&str, f64) {
    ocmc_api::label(column)
}

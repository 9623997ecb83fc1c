//! `ocmc.Run`.

use crate::column;
use crate::error::run_directory_error;
use crate::value::shown;
use ocmc_core::fleet::run::{self, RunPlan};
use ocmc_core::fleet::summary::SummaryBuilder;
use ocmc_core::simulation::record::{self, COLUMNS};
use ocmc_io::records::RecordFormat;
use ocmc_io::run_directory::{self, Manifest, RunDirectory, StoredRun};
use ocmc_io::run_summary::RunSummary;
use ocmc_io::study::{LoadedStudy, Origin};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Time between two looks for Ctrl-C.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(100);

/// Columns of a printed summary.
const WIDTH: usize = 80;

/// The records of a run, one a cycle, in the order of the cycle ids.
///
/// ``run["column"]`` is one quantity of all cycles as a new numpy array: numbers as floats, NaN where a cycle does not
/// have the quantity; ids and counts as unsigned integers; ``run["outcome"]`` as words. SI units, with the unit as the
/// name's suffix; consumption in kWh/km, L/100 km, L/100 tkm and g/km.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> run = ocmc.Study("field-truck").set("mission.length_m", 5000.0).run(cycles=50)
/// >>> len(run), run.columns[:2]
/// (50, ['cycle_id', 'outcome'])
/// >>> run["cycle_id"][:3]
/// array([0, 1, 2], dtype=uint64)
#[pyclass(name = "Run", module = "ocmc", frozen)]
pub(crate) struct PyRun {
    stored: StoredRun,
    origin: Origin,
}

/// Drives the plan, without the interpreter but for its signals.
pub(crate) fn run(py: Python, study: &LoadedStudy, plan: &RunPlan) -> PyResult<PyRun> {
    let stored = py.detach(|| {
        let manifest = Manifest::new(&study.model, plan);
        let clock = Instant::now();
        let mut looked = clock;
        let mut records = Vec::new();
        let mut fleet = SummaryBuilder::default();
        let ended = run::run(&study.study, plan, |chunk| {
            fleet.add(&chunk);
            records.extend(chunk);
            if looked.elapsed() >= SIGNAL_INTERVAL {
                looked = Instant::now();
                #[expect(
                    clippy::redundant_closure_for_method_calls,
                    reason = "the method alone does not live long enough"
                )]
                if let Err(interrupt) = Python::attach(|py| py.check_signals()) {
                    return ControlFlow::Break(interrupt);
                }
            }
            ControlFlow::Continue(())
        });
        if let ControlFlow::Break(interrupt) = ended {
            return Err(interrupt);
        }
        let wall_s = clock.elapsed().as_secs_f64();
        let summary = RunSummary::new(&manifest, fleet.finish(), wall_s, plan.threads);
        Ok(StoredRun { manifest, records, summary })
    })?;
    Ok(PyRun { stored, origin: study.origin.clone() })
}

/// Read a run back from its directory.
///
/// Parameters
/// ----------
/// path : str or os.PathLike
///     What ``Run.save`` or ``ocmc --out`` has written.
///
/// Returns
/// -------
/// Run
///     The same run.
///
/// Raises
/// ------
/// OSError
///     Where a file is missing or cannot be read.
/// ValueError
///     Where the files are not those of a run that was ended.
#[pyfunction]
pub(crate) fn load(py: Python, path: PathBuf) -> PyResult<PyRun> {
    let stored = py.detach(|| run_directory::read(&path));
    let stored = stored.map_err(|error| run_directory_error(&error))?;
    Ok(PyRun { stored, origin: Origin::File(path) })
}

#[pymethods]
impl PyRun {
    /// Names of the columns.
    #[getter]
    #[expect(clippy::unused_self, reason = "a property of the object in Python")]
    fn columns(&self) -> Vec<&'static str> {
        COLUMNS.iter().map(|column| column.name).collect()
    }

    /// What the run adds up to.
    ///
    /// Returns
    /// -------
    /// Summary
    ///     A dictionary with the content of ``summary.json``, which prints as the command's answer.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> run = ocmc.Study("field-truck").set("mission.length_m", 5000.0).run(cycles=50)
    /// >>> summary = run.summary()
    /// >>> summary["cycles"], sorted(summary["statistics"]["duration_s"])[:3]
    /// (50, ['ci95', 'mean', 'p25'])
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let summary = &self.stored.summary;
        let content = py.import("json")?.call_method1("loads", (summary.to_json(),))?;
        let text = ocmc_cli::run_text(summary, &self.origin, WIDTH);
        py.import("ocmc._summary")?.call_method1("Summary", (content, text))
    }

    /// Write records, manifest and summary, as ``ocmc --out`` does. An existing run is not overwritten.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     The directory; it is created.
    /// format : {"parquet", "csv"}
    ///     Format of the records.
    ///
    /// Raises
    /// ------
    /// OSError
    ///     Where the directory holds a run already, or cannot be written.
    #[pyo3(signature = (path, *, format="parquet"))]
    fn save(&self, py: Python, path: PathBuf, format: &str) -> PyResult<()> {
        let known = RecordFormat::ALL.into_iter().find(|known| known.name() == format);
        let format = known.ok_or_else(|| {
            let names = RecordFormat::ALL.map(RecordFormat::name).join(", ");
            PyValueError::new_err(format!("`format` is {format:?}, allowed is one of: {names}"))
        })?;
        let StoredRun { manifest, records, summary } = &self.stored;
        py.detach(|| {
            let mut directory = RunDirectory::create(&path, format, manifest.clone())?;
            directory.add(records)?;
            directory.finish(summary)
        })
        .map_err(|error| run_directory_error(&error))?;
        Ok(())
    }

    fn __getitem__<'py>(
        &self,
        py: Python<'py>,
        column: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let known = column.extract::<String>().ok().and_then(|name| record::column(&name));
        let known = known.ok_or_else(|| {
            PyKeyError::new_err(format!("no column {}; `columns` lists them", shown(column)))
        })?;
        column::column(py, &self.stored.records, known)
    }

    fn __len__(&self) -> usize {
        self.stored.records.len()
    }

    fn __repr__(&self) -> String {
        let Manifest { study, seed, first_cycle, .. } = &self.stored.manifest;
        let cycles = self.stored.records.len();
        format!("<ocmc.Run of {study:?}, seed {seed}, {cycles} cycles from id {first_cycle}>")
    }
}

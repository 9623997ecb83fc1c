//! `ocmc.Run`.

use crate::error::run_directory_error;
use crate::parts;
use crate::progress::Watch;
use crate::study::PyStudy;
use crate::table::Table;
use ocmc_core::fleet::dependence::Dependence;
use ocmc_core::fleet::run::RunPlan;
use ocmc_core::fleet::summary::SummaryBuilder;
use ocmc_core::record::Record;
use ocmc_io::given_drive::GivenDrive;
use ocmc_io::records::arrow::{record_batch, records, schema};
use ocmc_io::records::{GROUP_ROWS, RecordFormat};
use ocmc_io::report;
use ocmc_io::run_directory::{
    self, Manifest, RunDirectory, RunDirectoryError, RunStatus, StoredRun,
};
use ocmc_io::run_summary::RunSummary;
use ocmc_io::study::{LoadedStudy, Origin, load_text};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyIterator, PyList};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

/// Columns of a printed summary.
const WIDTH: usize = 80;

/// The records of a run, one a cycle, in the order of the cycle ids.
///
/// ``run["column"]`` is one quantity of all cycles as a new numpy array: numbers as floats, NaN where a cycle does not
/// have the quantity; ids and counts as unsigned integers, or as floats with NaN where a cycle lacks the count;
/// ``run["outcome"]`` as words. ``run.records`` is the whole table, for whoever speaks Arrow. SI units, with the unit
/// as the name's suffix; consumption in kWh/km, L/100 km, L/100 tkm and g/km.
///
/// A run comes from `Study.run` or `load`, and can be pickled.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> run = ocmc.Study("field-truck").set("mission.length_m", 5000.0).run(cycles=50)
/// >>> len(run), run.columns[:2]
/// (50, ['cycle_id', 'outcome'])
/// >>> run["cycle_id"][:3]
/// array([0, 1, 2], dtype=uint64)
#[pyclass(name = "Run", module = "ocmc", frozen, mapping)]
pub(crate) struct PyRun {
    pub(crate) manifest: Manifest,
    pub(crate) summary: RunSummary,
    pub(crate) records: Table,
    pub(crate) origin: Origin,
}

/// What `unpickled` makes a run of.
type Pickled<'py> = (String, f64, usize, Bound<'py, PyBytes>, Vec<u8>);

/// Records on their way into a table: batches of as many rows as a file has in a group.
#[derive(Default)]
struct Batches {
    waiting: Vec<Record>,
    full: Vec<arrow_array::RecordBatch>,
}

impl Batches {
    fn add(&mut self, mut records: Vec<Record>) {
        self.waiting.append(&mut records);
        while self.waiting.len() >= GROUP_ROWS {
            let rest = self.waiting.split_off(GROUP_ROWS);
            self.full.push(record_batch(&self.waiting));
            self.waiting = rest;
        }
    }

    fn finish(mut self) -> Table {
        if !self.waiting.is_empty() {
            self.full.push(record_batch(&self.waiting));
        }
        Table::new(schema(), self.full)
    }
}

/// Drives the plan, without the interpreter but for a look at its signals and the progress bar.
pub(crate) fn run(
    py: Python,
    study: &LoadedStudy,
    plan: &RunPlan,
    progress: Option<&Bound<PyAny>>,
) -> PyResult<PyRun> {
    run_with(py, study, plan, progress, &GivenDrive::nothing())
}

/// As [`run`], of what is given to be driven.
pub(crate) fn run_with(
    py: Python,
    study: &LoadedStudy,
    plan: &RunPlan,
    progress: Option<&Bound<PyAny>>,
    given: &GivenDrive,
) -> PyResult<PyRun> {
    let mut watch = Watch::new(py, progress, plan.cycles)?;
    let mut fleet = SummaryBuilder::new(Dependence::of(&study.model));
    let ended = py.detach(|| {
        let manifest = Manifest::new(&study.model, plan, given);
        let clock = Instant::now();
        let mut batches = Batches::default();
        let ended = given.run(&study.study, plan, |chunk| {
            fleet.add(&chunk);
            batches.add(chunk);
            match watch.look(fleet.cycles()) {
                Ok(()) => ControlFlow::Continue(()),
                Err(interrupt) => ControlFlow::Break(interrupt),
            }
        });
        (ended, manifest, clock.elapsed().as_secs_f64(), batches.finish())
    });
    let (ended, mut manifest, wall_s, records) = ended;
    let finished = watch.finish(py, fleet.cycles());
    if let ControlFlow::Break(interrupt) = ended {
        return Err(interrupt);
    }
    finished?;
    manifest.status = RunStatus::Complete;
    manifest.completed = manifest.cycles;
    let summary = RunSummary::new(&manifest, fleet.finish(), wall_s, plan.threads);
    Ok(PyRun { manifest, summary, records, origin: study.origin.clone() })
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
///
/// Examples
/// --------
/// >>> import ocmc, tempfile
/// >>> run = ocmc.Study("field-truck").set("mission.length_m", 5000.0).run(cycles=50)
/// >>> with tempfile.TemporaryDirectory() as folder:
/// ...     run.save(f"{folder}/a")
/// ...     same = ocmc.load(f"{folder}/a")
/// >>> bool((same["fuel_kg"] == run["fuel_kg"]).all())
/// True
#[pyfunction]
pub(crate) fn load(py: Python, path: PathBuf) -> PyResult<PyRun> {
    let stored = py.detach(|| {
        let mut batches = Vec::new();
        let (manifest, summary) =
            run_directory::read_groups(&path, |group| batches.push(group.into_batch()))?;
        Ok((manifest, summary, Table::new(schema(), batches)))
    });
    let (manifest, summary, records) = stored.map_err(|error| run_directory_error(&error))?;
    Ok(PyRun { manifest, summary, records, origin: Origin::File(path) })
}

#[pymethods]
impl PyRun {
    /// Names of the columns.
    #[getter]
    fn columns(&self) -> Vec<&str> {
        self.records.names()
    }

    /// All columns as one table, which pyarrow, polars, pandas and duckdb take without a copy.
    #[getter]
    fn records(&self) -> Table {
        self.records.clone()
    }

    /// The study, as the run's manifest keeps it: every value that the run used.
    #[getter]
    fn study(&self) -> PyResult<PyStudy> {
        let manifest = &self.manifest;
        PyStudy::new(load_text(&manifest.study, &manifest.resolved_study, &[] as &[&str]))
    }

    /// The master seed.
    #[getter]
    fn seed(&self) -> u64 {
        self.manifest.seed
    }

    /// Id of the first cycle.
    #[getter]
    fn first_cycle(&self) -> u64 {
        self.manifest.first_cycle
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
        let content = py.import("json")?.call_method1("loads", (self.summary.to_json(),))?;
        let text = ocmc_cli::run_text(&self.summary, &self.origin, WIDTH);
        py.import("ocmc._summary")?.call_method1("Summary", (content, text))
    }

    /// One page with everything about the run: it opens offline in any browser.
    ///
    /// Returns
    /// -------
    /// str
    ///     HTML, as ``ocmc report`` writes it.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> run = ocmc.Study("field-truck").set("mission.length_m", 5000.0).run(cycles=50)
    /// >>> run.report().startswith("<!DOCTYPE html>")
    /// True
    fn report(&self, py: Python) -> String {
        py.detach(|| {
            let batches = self.records.batches().iter();
            let rows = batches.flat_map(|batch| records(batch).expect("made of records"));
            let (manifest, summary) = (self.manifest.clone(), self.summary.clone());
            report::html(&StoredRun { manifest, records: rows.collect(), summary })
        })
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
    /// ValueError
    ///     Where the format is not one of these.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc, tempfile
    /// >>> run = ocmc.Study("field-truck").set("mission.length_m", 5000.0).run(cycles=50)
    /// >>> with tempfile.TemporaryDirectory() as folder:
    /// ...     run.save(f"{folder}/a")
    /// ...     len(ocmc.load(f"{folder}/a"))
    /// 50
    #[pyo3(signature = (path, *, format="parquet"))]
    fn save(&self, py: Python, path: PathBuf, format: &str) -> PyResult<()> {
        let known = RecordFormat::ALL.into_iter().find(|known| known.name() == format);
        let format = known.ok_or_else(|| {
            let names = RecordFormat::ALL.map(RecordFormat::name).join(", ");
            PyValueError::new_err(format!("`format` is {format:?}, allowed is one of: {names}"))
        })?;
        let saved = py.detach(|| -> Result<(), RunDirectoryError> {
            let mut directory = RunDirectory::create(&path, format, self.manifest.clone())?;
            for batch in self.records.batches() {
                directory.add(&records(batch).expect("made of records"))?;
            }
            directory.finish(&self.summary).map(drop)
        });
        saved.map_err(|error| run_directory_error(&error))
    }

    fn __getitem__<'py>(
        &self,
        py: Python<'py>,
        column: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.records.column(py, column)
    }

    fn __contains__(&self, column: &Bound<PyAny>) -> bool {
        self.records.has(column)
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        PyList::new(py, self.columns())?.try_iter()
    }

    fn __len__(&self) -> usize {
        self.records.rows()
    }

    fn __repr__(&self) -> String {
        let Manifest { study, seed, first_cycle, .. } = &self.manifest;
        let cycles = self.records.rows();
        format!("<ocmc.Run of {study:?}, seed {seed}, {cycles} cycles from id {first_cycle}>")
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("ocmc._display")?.call_method1("run", (slf,))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Pickled<'py>)> {
        let manifest = serde_json::to_string(&self.manifest).expect("numbers and words");
        let stream = parts::to_bytes(py, &self.records)?;
        let make = py.import("ocmc._ocmc")?.getattr("unpickled")?;
        let sum = parts::checksum(&manifest, stream.as_bytes());
        Ok((make, (manifest, self.summary.wall_s, self.summary.threads, stream, sum)))
    }
}

//! `ocmc.Run`, and runs on their way between processes: pickled ones, and parts that are put
//! together again.

use crate::answer::warn;
use crate::error::exception;
use crate::pickle::{broken, checksum, read, stream_of};
use crate::plan::{number_of_cycles, precision_of, seed_of, threads_of, with_trips};
use crate::progress::watched;
use crate::study::PyStudy;
use crate::table::Table;
use crate::value::{one_of, whole_number};
use arrow_array::RecordBatch;
use arrow_schema::SchemaRef;
use ocmc_api::study::{Files, Given, LoadedStudy, Origin, open};
use ocmc_api::{
    Account, Answer, Asked, CpuLevel, FORMATS, GROUP_ROWS, Gathered, GivenDrive, LAST_CYCLE_ID,
    Manifest, MergeRequest, Precision, Record, RecordFormat, Reported, RequeueRequest, RunAnswer,
    RunPlan, RunRequest, in_our_order, joined as whole, record_batch, records, schema, summed_up,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyCapsule, PyIterator};
use pyo3_arrow::error::PyArrowResult;
use std::path::PathBuf;

/// The records of a run, one a cycle, in the order of the cycle ids.
///
/// ``run["column"]`` is one quantity of all cycles as a new numpy array: numbers as floats, NaN
/// where a cycle does not have the quantity. Ids and counts are unsigned integers, or floats with
/// NaN where a cycle lacks the count; ``run["outcome"]`` as words. ``run.records`` is the whole
/// table, for all that take Arrow. SI units, with the unit as the name's suffix; consumption in
/// kWh/km, L/100 km, L/100 tkm and g/km.
/// A run itself exports Arrow, too: ``run.to_pandas()``, ``polars.DataFrame(run)``.
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
    pub(crate) answer: RunAnswer,
    pub(crate) records: Table,
    /// Accounts of the routes that were driven.
    pub(crate) routes: Vec<Account>,
}

/// Parts of which `unpickled` makes a run.
type Pickled<'py> = (String, f64, usize, String, Bound<'py, PyBytes>, Vec<u8>);

/// Records on their way into a table: batches of as many rows as a file has in a group.
#[derive(Default)]
struct Batches {
    waiting: Vec<Record>,
    full: Vec<RecordBatch>,
}

/// Batches of records as one table: those of a study have the columns of its breakdown. Where there
/// is none, the table has the columns of `of_none`.
fn table_of(batches: Vec<RecordBatch>, of_none: impl FnOnce() -> SchemaRef) -> Table {
    let schema = batches.first().map_or_else(of_none, RecordBatch::schema);
    Table::new(schema, batches)
}

impl Batches {
    fn add(&mut self, records: &[Record]) {
        self.waiting.extend_from_slice(records);
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
        table_of(self.full, schema)
    }
}

/// Drives the plan, or what is given.
pub(crate) fn run(
    py: Python,
    study: &LoadedStudy,
    given: &GivenDrive,
    plan: RunPlan,
    precision: Option<Precision>,
    out: Option<(PathBuf, RecordFormat)>,
    progress: Option<&Bound<PyAny>>,
) -> PyResult<PyRun> {
    let request = RunRequest { study, given, plan, precision, out };
    let (answer, records) = watched(py, progress, |watch| {
        let mut batches = Batches::default();
        let answer = ocmc_api::run(&request, &mut |records| batches.add(records), watch)?;
        Ok((answer, batches.finish()))
    })?;
    answer.warnings().iter().try_for_each(|warning| warn(py, warning))?;
    Ok(PyRun { answer, records, routes: Vec::new() })
}

/// Most cycles that are driven where nothing is said of their number.
const MOST_UNSAID: u64 = 1_000_000;

/// Drives what `Study.run` is asked for: cycles, trucks, trips of each, seed, first cycle and
/// threads; where to, whether that is resumed, and in which format.
pub(crate) fn asked(
    py: Python,
    study: &LoadedStudy,
    [cycles, trucks, trips, seed, first_cycle, threads]: [Option<&Bound<PyAny>>; 6],
    precision: Option<&str>,
    (out, resume, format): (Option<PathBuf>, bool, Option<&str>),
    progress: Option<&Bound<PyAny>>,
) -> PyResult<PyRun> {
    let loaded = with_trips(study, trips)?;
    let of_truck = loaded.study.nesting().trips_per_truck;
    let precision = precision_of(precision)?;
    let format = format.map(|word| one_of("format", word, &FORMATS)).transpose()?;
    let may_lack = precision.is_some() || resume;
    let cycles = number_of_cycles(cycles, trucks, of_truck, may_lack)?;
    let last = LAST_CYCLE_ID - cycles.unwrap_or(MOST_UNSAID);
    let first = first_cycle.map(|id| whole_number(id, "first_cycle", 0, last)).transpose()?;
    let seed = seed.map(|seed| seed_of(Some(seed))).transpose()?;
    let (threads, level) = (threads_of(threads)?, CpuLevel::best());
    let asked = Asked {
        loaded: Some(&loaded),
        files: loaded.files().clone(),
        seed,
        first_cycle: first,
        cycles,
        precision,
        format,
        ..Asked::default()
    };
    match (out, resume) {
        (Some(directory), true) => requeued(py, directory, asked, threads, progress),
        (None, true) => Err(PyValueError::new_err("`resume` goes with `out`")),
        (None, false) if format.is_some() => Err(PyValueError::new_err("`format` goes with `out`")),
        (out, false) => {
            let study = asked.load().map_err(exception)?;
            let plan = asked.plan(&study, threads, None, level);
            let out = out.map(|path| (path, format.unwrap_or_default()));
            run(py, &study, &GivenDrive::nothing(), plan, asked.precision, out, progress)
        }
    }
}

/// Goes on with a run in a directory, or begins it where there is none.
fn requeued(
    py: Python,
    directory: PathBuf,
    asked: Asked,
    threads: Option<usize>,
    progress: Option<&Bound<PyAny>>,
) -> PyResult<PyRun> {
    let (given, level) = (&GivenDrive::nothing(), CpuLevel::best());
    let request =
        RequeueRequest { directory: &directory, asked, given, threads, chunk: None, level };
    watched(py, progress, |watch| ocmc_api::requeue(&request, watch))?;
    load(py, directory)
}

/// Read a run back from its directory.
///
/// Parameters
/// ----------
/// path : str or os.PathLike
///     The directory that ``Run.save`` or ``ocmc --out`` has written.
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
    let mut batches = Vec::new();
    let loaded = py.detach(|| ocmc_api::load(path, |batch| batches.push(batch)));
    let answer = loaded.map_err(exception)?;
    Ok(PyRun { answer, records: table_of(batches, schema), routes: Vec::new() })
}

/// Merge the parts of one run, from many machines, into the run that one machine would have
/// written.
///
/// Parameters
/// ----------
/// parts : sequence of str or os.PathLike
///     Run directories of the parts, in any order. Parts have the same study and seed, and each
///     begins where another one ends.
/// out : str or os.PathLike
///     Directory for the whole run; it is created.
/// format : {"parquet", "csv"}, optional
///     Format of the records; by default that of the first part.
///
/// Returns
/// -------
/// Run
///     The whole run, as it was written.
///
/// Raises
/// ------
/// ValueError
///     Where the parts are not those of one run.
/// OSError
///     Where a part cannot be read, or the whole not be written.
///
/// Examples
/// --------
/// >>> import ocmc, tempfile
/// >>> study = ocmc.Study("field-truck").set("mission.length_m", 5000.0)
/// >>> with tempfile.TemporaryDirectory() as folder:
/// ...     parts = [f"{folder}/a", f"{folder}/b"]
/// ...     for k, part in enumerate(parts):
/// ...         run = study.run(cycles=10, first_cycle=10 * k, out=part)
/// ...     whole = ocmc.merge(parts, out=f"{folder}/whole")
/// >>> len(whole)
/// 20
#[pyfunction]
#[pyo3(signature = (parts, *, out, format=None))]
pub(crate) fn merge(
    py: Python,
    parts: Vec<PathBuf>,
    out: PathBuf,
    format: Option<&str>,
) -> PyResult<PyRun> {
    let format = format.map(|word| one_of("format", word, &FORMATS)).transpose()?;
    let merged = py.detach(|| ocmc_api::merge(&MergeRequest { parts: &parts, out: &out, format }));
    merged.map_err(exception)?;
    load(py, out)
}

#[pymethods]
impl PyRun {
    /// Names of the columns.
    #[getter]
    fn columns(&self) -> Vec<&str> {
        self.records.columns()
    }

    /// All columns as one table, which pyarrow, polars, pandas and duckdb take without a copy.
    #[getter]
    fn records(&self) -> Table {
        self.records.clone()
    }

    /// The records as a data frame of pandas, as `Table.to_pandas` makes it: a row for each cycle.
    ///
    /// Returns
    /// -------
    /// pandas.DataFrame
    ///     A row for each cycle, and all columns.
    ///
    /// Raises
    /// ------
    /// ModuleNotFoundError
    ///     Where pandas is not installed.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> run = ocmc.Study("field-truck").set("mission.length_m", 5000.0).run(cycles=50)
    /// >>> run.to_pandas().shape == (50, len(run.columns))
    /// True
    fn to_pandas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Table::to_pandas(&Bound::new(py, self.records.clone())?)
    }

    /// The records as a data frame of polars, which shares their memory.
    ///
    /// Returns
    /// -------
    /// polars.DataFrame
    ///     A row for each cycle, and all columns; null where a cycle does not have the quantity.
    ///
    /// Raises
    /// ------
    /// ModuleNotFoundError
    ///     Where polars is not installed.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> run = ocmc.Study("field-truck").set("mission.length_m", 5000.0).run(cycles=50)
    /// >>> run.to_polars().shape == (50, len(run.columns))
    /// True
    fn to_polars<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Table::to_polars(&Bound::new(py, self.records.clone())?)
    }

    /// Truck-years as one table: a row for each truck and year, as ``trucks.parquet`` has them.
    ///
    /// Totals are of completed trips; ``consumption_l_per_100km`` and the other quantities are the
    /// truck's total over its total. None where each trip has a truck of its own.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> study = ocmc.Study("field-truck").set("mission.length_m", 5000.0)
    /// >>> trucks = study.run(trucks=3, trips=4).trucks
    /// >>> trucks["n_trips"]
    /// array([4, 4, 4], dtype=uint64)
    #[getter]
    fn trucks(&self) -> Option<Table> {
        let trucks = self.answer.summary.summary.trucks.as_ref()?;
        let batch = ocmc_api::truck_batch(&trucks.rows);
        Some(Table::new(batch.schema(), vec![batch]))
    }

    /// Load curves as one table: a row for each kind of chargers and quarter of an hour of the day,
    /// as ``loads.parquet`` has them.
    ///
    /// Mean, median and 95 % quantile of the power are over the days of the fleet's calendar;
    /// without one all trips of the run lie in one year. None where no trip was charged by a
    /// policy.
    ///
    /// Returns
    /// -------
    /// Table or None
    ///     ``place`` (``depot``, ``public``, ``stop``), ``quarter_hour`` (from 0 at midnight),
    ///     powers in W at the meter, and ``days``.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> study = ocmc.Study("electric-regional").set("mission.length_m", 20e3)
    /// >>> loads = study.run(cycles=40).loads()
    /// >>> len(loads), loads["place"][0]
    /// (96, np.str_('depot'))
    fn loads(&self) -> Option<Table> {
        let loads = self.answer.summary.summary.loads.as_ref()?;
        let batch = ocmc_api::loads_batch(&loads.rows);
        Some(Table::new(batch.schema(), vec![batch]))
    }

    /// Each charging of each trip as one table, as ``chargings.parquet`` has them.
    ///
    /// Times are in s after the departure, but for ``begin_s_of_year``. Energies are in J, of the
    /// store (``charged_energy_j``) and of the meter (``grid_energy_j``). The highest power at the
    /// meter is in W.
    ///
    /// Returns
    /// -------
    /// Table
    ///     Without rows where no trip was charged by a policy.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> run = ocmc.Study("electric-regional").set("mission.length_m", 20e3).run(cycles=40)
    /// >>> len(run.chargings())
    /// 40
    fn chargings(&self) -> Table {
        let chargings =
            |batch| ocmc_api::chargings_batch(&records(batch).expect("made of records"));
        let batches = self.records.batches.iter().map(chargings).collect();
        table_of(batches, || ocmc_api::chargings_batch(&[]).schema())
    }

    /// Account of each route that `Study.drive` was given: ``file``, ``length_m``, ``climb_m``,
    /// ``steepest_grade``, ``n_curves``, ``n_stops``, ``limits_mps`` (none where they are drawn),
    /// ``position_noise_m``, ``altitude_noise_m``, the same in words (``told``), and what of it is
    /// hardly a road (``warnings``). Empty of other runs, and of one that was saved or pickled.
    #[getter]
    fn routes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let text = serde_json::to_string(&self.routes).expect("numbers and words");
        py.import("json")?.call_method1("loads", (text,))
    }

    /// The study, as the run's manifest keeps it: every value that the run used.
    #[getter]
    fn study(&self) -> PyResult<PyStudy> {
        let manifest = &self.answer.manifest;
        let study = Given::Text(&manifest.study, &manifest.resolved_study);
        PyStudy::new(open(&study, &Files::here(), &[] as &[&str]))
    }

    /// The master seed.
    #[getter]
    fn seed(&self) -> u64 {
        self.answer.manifest.seed
    }

    /// Id of the first cycle.
    #[getter]
    fn first_cycle(&self) -> u64 {
        self.answer.manifest.first_cycle
    }

    /// The summary of the run.
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
    /// (50, ['adjusted', 'ci95', 'histogram'])
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let content = py.import("json")?.call_method1("loads", (self.answer.to_json(),))?;
        py.import("ocmc._summary")?.call_method1("Summary", (content, self.answer.text()))
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
            let mut gathered = Gathered::default();
            for batch in &self.records.batches {
                gathered.add(&records(batch).expect("made of records"));
            }
            let RunAnswer { manifest, summary, .. } = self.answer.clone();
            ocmc_api::report(&Reported { manifest, summary, gathered })
        })
    }

    /// Write a workbook for spreadsheets (XLSX), as ``ocmc report --xlsx`` does. An existing file
    /// is replaced.
    ///
    /// The sheets are the answer, the records with a row for each cycle, and the study. Where there
    /// are several routes, the quantities are there by route; where trips belong to trucks, the
    /// trucks. Numbers are numbers, and what a cycle does not have is an empty cell. No cell is a
    /// formula.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     The file, whose name should end in ``.xlsx``.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Where the run has more records than a sheet has rows, which are 1,048,575: write them as
    ///     CSV or Parquet with `Run.save`.
    /// OSError
    ///     Where the file cannot be written.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc, tempfile
    /// >>> run = ocmc.Study("field-truck").set("mission.length_m", 5000.0).run(cycles=50)
    /// >>> with tempfile.TemporaryDirectory() as folder:
    /// ...     run.to_excel(f"{folder}/run.xlsx")
    fn to_excel(&self, py: Python, path: PathBuf) -> PyResult<()> {
        let written =
            py.detach(|| ocmc_api::run_workbook(&self.answer, &self.records.batches, &path));
        written.map_err(exception)
    }

    /// Write records, manifest and summary, as ``ocmc --out`` does. An existing run is not
    /// overwritten.
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
        let format = one_of("format", format, &FORMATS)?;
        let saved = py.detach(|| {
            let batches = self.records.batches.iter();
            let groups = batches.map(|batch| records(batch).expect("made of records"));
            ocmc_api::save(&self.answer, &path, format, groups)
        });
        saved.map_err(exception)
    }

    fn __getitem__<'py>(
        &self,
        py: Python<'py>,
        column: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.records.__getitem__(py, column)
    }

    fn __contains__(&self, column: &Bound<PyAny>) -> bool {
        self.records.__contains__(column)
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        self.records.__iter__(py)
    }

    fn __len__(&self) -> usize {
        self.records.__len__()
    }

    /// The rows for numpy, as `Table.__array__` gives them.
    #[pyo3(signature = (dtype=None, copy=None))]
    fn __array__<'py>(
        &self,
        py: Python<'py>,
        dtype: Option<Bound<'py, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        Table::__array__(&Bound::new(py, self.records.clone())?, dtype, copy)
    }

    /// The schema of the records, for all that take Arrow.
    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyArrowResult<Bound<'py, PyCapsule>> {
        self.records.__arrow_c_schema__(py)
    }

    /// The records, for all that take Arrow: shared, not copied.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyCapsule>>,
    ) -> PyArrowResult<Bound<'py, PyCapsule>> {
        self.records.__arrow_c_stream__(py, requested_schema)
    }

    fn _ipython_key_completions_(&self) -> Vec<&str> {
        self.records.columns()
    }

    fn __repr__(&self) -> String {
        let Manifest { study, seed, first_cycle, .. } = &self.answer.manifest;
        let cycles = self.records.__len__();
        format!("<ocmc.Run of {study:?}, seed {seed}, {cycles} cycles from id {first_cycle}>")
    }

    fn _repr_html_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.summary(py)?.call_method0("_repr_html_")
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Pickled<'py>)> {
        let manifest = serde_json::to_string(&self.answer.manifest).expect("numbers and words");
        let stream = PyBytes::new(
            py,
            &py.detach(|| stream_of(&self.records.schema, &self.records.batches))?,
        );
        let make = py.import("ocmc._ocmc")?.getattr("unpickled")?;
        let sum = checksum(&manifest, stream.as_bytes());
        let summary = &self.answer.summary;
        let ended_at = summary.ended_at.clone();
        Ok((make, (manifest, summary.wall_s, summary.threads, ended_at, stream, sum)))
    }
}

/// A pickled run: its manifest (JSON), what was measured, its records, and the checksum of all
/// that.
#[pyfunction]
pub(crate) fn unpickled(
    py: Python,
    manifest: &str,
    wall_s: f64,
    threads: usize,
    ended_at: String,
    stream: &[u8],
    sum: &[u8],
) -> PyResult<PyRun> {
    py.detach(|| {
        let (_, batches) = read(manifest, stream, sum)?;
        if let Some(version) = Manifest::other_version(manifest) {
            return Err(broken(format!("version {version} of the program wrote it")));
        }
        let manifest: Manifest = serde_json::from_str(manifest).map_err(broken)?;
        let groups = batches.iter().map(|batch| {
            let ours = in_our_order(batch).map_err(broken)?;
            if batch.schema() != ours.schema() {
                return Err(broken("its records have other columns"));
            }
            records(batch).map_err(broken)
        });
        let mut answer = summed_up(manifest, Origin::Dictionary, (wall_s, threads), groups)?;
        answer.summary.ended_at = ended_at;
        Ok(PyRun { answer, records: table_of(batches, schema), routes: Vec::new() })
    })
}

/// One run of consecutive parts of it, as if it had been driven in one go.
///
/// # Errors
/// Where the parts are of different studies or seeds, or leave a gap.
#[pyfunction]
pub(crate) fn joined(
    py: Python,
    parts: Vec<Bound<PyRun>>,
    wall_s: f64,
    threads: usize,
) -> PyResult<PyRun> {
    let parts: Vec<&PyRun> = parts.iter().map(Bound::get).collect();
    let manifests: Vec<&Manifest> = parts.iter().map(|part| &part.answer.manifest).collect();
    let manifest = whole(&manifests).map_err(|error| PyValueError::new_err(error.to_string()))?;
    let origin = parts[0].answer.origin.clone();
    py.detach(|| {
        let batches = parts.iter().flat_map(|part| &part.records.batches);
        let batches: Vec<_> = batches.cloned().collect();
        let groups = batches.iter().map(|batch| records(batch).map_err(broken));
        let answer = summed_up(manifest, origin, (wall_s, threads), groups)?;
        Ok(PyRun { answer, records: table_of(batches, schema), routes: Vec::new() })
    })
}

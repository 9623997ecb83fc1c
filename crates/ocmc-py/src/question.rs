//! Questions to studies: the methods of `ocmc.Study`.

use crate::answer::answer;
use crate::calibrate::totals;
use crate::error::exception;
use crate::given::given;
use crate::operating_cycle::PyOperatingCycle;
use crate::plan::{cycle_id_of, plan_of, seed_of, with_trips};
use crate::progress::watched;
use crate::run::{PyRun, asked, run};
use crate::study::{PyStudy, attribute, dictionary, of_source, setting, settings};
use crate::sweep::sweep;
use crate::table::Table;
use crate::value::{inner_share, one_of, one_or_more, whole_number};
use ocmc_api::study::{self, Files};
use ocmc_api::{
    BirdsEyeRequest, BoundRequest, DoubtRequest, LAST_CYCLE_ID, OVERS, RangeRequest, SEASONS,
    SensitivityRequest, SizeRequest, TrainingRequest, check_empty,
};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Parts from which a study is made again: its class, its dictionary, and whether it may name
/// files.
type Pickled<'py> = (Bound<'py, PyType>, (Bound<'py, PyDict>, bool));

#[pymethods]
impl PyStudy {
    #[new]
    #[pyo3(signature = (source, allow_files=true))]
    fn from_source(source: &Bound<PyAny>, allow_files: bool) -> PyResult<Self> {
        of_source(source, allow_files)
    }

    /// Name of the study.
    #[getter]
    fn name(&self) -> &str {
        &self.loaded.model.study.name
    }

    /// SHA-256 of the resolved study, in hexadecimal digits: the same as in a run's manifest.
    #[getter]
    fn hash(&self) -> &str {
        &self.hash
    }

    /// Another study, in which one value differs.
    ///
    /// Parameters
    /// ----------
    /// path : str
    ///     The key's full path, such as ``"driver.curve_speed.exponent"``; numbers in it are places
    ///     in a list, from 0.
    /// value : float, int, str, bool, list or dict
    ///     The value, in the key's unit.
    ///
    /// Returns
    /// -------
    /// Study
    ///     The other study.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> study = ocmc.Study("field-truck").set("driver.curve_speed.exponent", 0.5)
    /// >>> study.to_dict()["driver"]["curve_speed"]["exponent"]
    /// 0.5
    fn set(&self, path: &str, value: &Bound<PyAny>) -> PyResult<Self> {
        Self::new(self.loaded.set(&[setting(path, value)?]))
    }

    /// The resolved study: every value that a run uses.
    ///
    /// Returns
    /// -------
    /// dict
    ///     A dictionary of the shape of a study file, which `Study` takes.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> study = ocmc.Study("field-truck")
    /// >>> ocmc.Study(study.to_dict()) == study
    /// True
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        dictionary(py, &self.to_toml())
    }

    /// The resolved study as the text of a study file.
    ///
    /// Returns
    /// -------
    /// str
    ///     TOML.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> print(ocmc.Study("field-truck").to_toml())  # doctest: +ELLIPSIS
    /// [study]
    /// name = "field-truck"
    /// ...
    fn to_toml(&self) -> String {
        study::resolved_toml(&self.loaded.model)
    }

    /// Drive a range of cycles. Other Python threads go on meanwhile; Ctrl-C ends the run.
    ///
    /// Parameters
    /// ----------
    /// cycles : int, optional
    ///     Number of cycles, at least 1; or `trucks`.
    /// trucks : int, optional
    ///     Number of trucks, in place of `cycles`: each makes the study's
    ///     ``fleet.trips_per_truck`` trips, or `trips`.
    /// trips : int, optional
    ///     Trips of each truck: sets ``fleet.trips_per_truck`` of the study that is driven.
    /// seed : int
    ///     Master seed: with the study and a cycle's id it fixes everything that happens in the
    ///     cycle.
    /// first_cycle : int
    ///     Id of the first cycle.
    /// threads : int, optional
    ///     Threads to use, one for each CPU by default. The records do not depend on it.
    /// precision : str, optional
    ///     The run ends when half of the 95 % interval of the mean consumption is that small,
    ///     relative to the mean, as in ``"0.2%"``. Of a quantile it is as in ``"p95:1%"``. `cycles`
    ///     is then the largest number, 1 000 000 by default.
    /// out : str or os.PathLike, optional
    ///     Directory that the run is written to while it is driven, as ``ocmc --out`` does.
    /// resume : bool
    ///     Finishes the run in `out`, or begins it where there is none. Arguments that are given
    ///     have to be those of that run.
    /// format : {"parquet", "csv"}, optional
    ///     Format of the records in `out`; Parquet by default.
    /// progress : bool or callable, optional
    ///     True draws a progress bar, False does not; by default there is one on a terminal and in
    ///     a notebook. A callable is called instead, some times a second, with the numbers of
    ///     cycles that are done and that were asked for.
    ///
    /// Returns
    /// -------
    /// Run
    ///     The records, in the order of the cycle ids.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Where a number is out of its range, or where the run in `out` is another one.
    /// OSError
    ///     Where `out` holds a run and `resume` is not said, or cannot be written.
    /// KeyboardInterrupt
    ///     After Ctrl-C; what was finished is kept in `out`, and `resume` drives the rest.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> study = ocmc.Study("field-truck").set("mission.length_m", 5000.0)
    /// >>> len(study.run(cycles=20))
    /// 20
    /// >>> len(study.run(precision="2%", cycles=50_000)) < 50_000
    /// True
    /// >>> run = study.run(trucks=4, trips=5)
    /// >>> run["truck_id"][[0, 4, 5, 19]]
    /// array([0, 0, 1, 3], dtype=uint64)
    #[pyo3(
        signature = (
            *, cycles=None, trucks=None, trips=None, seed=None, first_cycle=None, threads=None,
            precision=None, out=None, resume=false, format=None, progress=None
        ),
        text_signature = "($self, *, cycles=None, trucks=None, trips=None, seed=1, first_cycle=0, \
                          threads=None, precision=None, out=None, resume=False, format=None, \
                          progress=None)"
    )]
    fn run(
        &self,
        py: Python,
        cycles: Option<&Bound<PyAny>>,
        trucks: Option<&Bound<PyAny>>,
        trips: Option<&Bound<PyAny>>,
        seed: Option<&Bound<PyAny>>,
        first_cycle: Option<&Bound<PyAny>>,
        threads: Option<&Bound<PyAny>>,
        precision: Option<&str>,
        out: Option<PathBuf>,
        resume: bool,
        format: Option<&str>,
        progress: Option<&Bound<PyAny>>,
    ) -> PyResult<PyRun> {
        let which = [cycles, trucks, trips, seed, first_cycle, threads];
        asked(py, &self.loaded, which, precision, (out, resume, format), progress)
    }

    /// Drive given routes, or follow a given speed, with the study's drivers and trucks.
    ///
    /// Parameters
    /// ----------
    /// files : str or os.PathLike, or a list of these, or table
    ///     Routes: VECTO's ``.vdri``, CSV or JSON as ``ocmc cycle`` writes it, or a route by rows.
    ///     That is a CSV file or one table with ``position_m`` or ``latitude`` and ``longitude``,
    ///     ``speed_limit_kmh``, ``altitude_m`` and others. Of several files, each cycle drives one.
    ///     With `follow_speed` one drive cycle over time: a CSV file or a table with ``time_s``
    ///     or a column of dates, a speed, and ``slope`` or ``grade``. With ``"exact"`` a route,
    ///     too. Tables are whatever exports Arrow (pandas, polars, pyarrow, duckdb), or a
    ///     dictionary of columns.
    /// cycles : int
    ///     Number of cycles, at least 1.
    /// columns : dict of str to str, optional
    ///     Which column of a table is what, such as ``{"speed_limit_kmh": "vmax"}``.
    /// keep : sequence of {"weather", "traffic", "mission"}, optional
    ///     Parts that are taken from the file of a route instead of being drawn from the study.
    /// draw : sequence of {"stops", "limits", "hills", "curves"}, optional
    ///     Parts that are drawn from the study's laws of each road type, anew in each cycle. They
    ///     are drawn where the file of a route lacks them.
    /// stop_plan : str or os.PathLike, optional
    ///     A table with the stop plan that is driven on the route: places by kilometre or
    ///     coordinates, dwells, loads and the departure.
    /// follow_speed : {"driver", "exact"}, optional
    ///     A driver of the study drives the speeds as limits along the road and stops where it
    ///     stands. Or there is no driver, and the speed is kept exactly. Of a route, ``"exact"``
    ///     keeps the speed that the driver plans.
    /// seed : int
    ///     Master seed.
    /// first_cycle : int
    ///     Id of the first cycle.
    /// threads : int, optional
    ///     Threads to use, one for each CPU by default.
    /// progress : bool or callable, optional
    ///     As for `Study.run`.
    ///
    /// Returns
    /// -------
    /// Run
    ///     The records, as of ``ocmc drive``. Where a speed was followed, the run's manifest holds
    ///     it beside the study, and a route that was a table in the study.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Where a file is neither a route nor a drive cycle, or where a number is out of its
    ///     range.
    /// OSError
    ///     Where a file cannot be read.
    ///
    /// Warns
    /// -----
    /// UserWarning
    ///     Where the mission of a file is kept that holds no departure, and where a route is hardly
    ///     a road, such as one of noisy positions. `Run.routes` has what was read of each file;
    ///     where there is a progress bar, it is told on standard error, too.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> study = ocmc.Study("field-truck-loaded")
    /// >>> speed = {"time_s": [0.0, 40.0, 160.0, 180.0], "speed_mps": [0.0, 20.0, 20.0, 0.0]}
    /// >>> run = study.drive(speed, cycles=10, follow_speed="exact")
    /// >>> run["distance_m"][0], run["duration_s"][0]
    /// (np.float64(3000.0), np.float64(180.0))
    /// >>> route = {"position_m": [0.0, 2000.0, 5000.0], "speed_limit_kmh": [50.0, 80.0, 80.0]}
    /// >>> len(study.drive(route, cycles=10, draw=["stops", "hills", "curves"]))
    /// 10
    #[pyo3(
        signature = (
            files, *, cycles, columns=None, keep=None, draw=None, stop_plan=None,
            follow_speed=None, seed=None, first_cycle=None, threads=None, progress=None
        ),
        text_signature = "($self, files, *, cycles, columns=None, keep=None, draw=None, \
                          stop_plan=None, follow_speed=None, seed=1, first_cycle=0, threads=None, \
                          progress=None)"
    )]
    fn drive(
        &self,
        py: Python,
        files: &Bound<PyAny>,
        cycles: &Bound<PyAny>,
        columns: Option<BTreeMap<String, String>>,
        keep: Option<Vec<String>>,
        draw: Option<Vec<String>>,
        stop_plan: Option<PathBuf>,
        follow_speed: Option<&str>,
        seed: Option<&Bound<PyAny>>,
        first_cycle: Option<&Bound<PyAny>>,
        threads: Option<&Bound<PyAny>>,
        progress: Option<&Bound<PyAny>>,
    ) -> PyResult<PyRun> {
        let plan = plan_of(cycles, seed, first_cycle, threads)?;
        let (given, routes) =
            given(py, files, columns, keep, draw, stop_plan, follow_speed, progress)?;
        Ok(PyRun { routes, ..run(py, &self.loaded, &given, plan, None, None, progress)? })
    }

    /// Shares of the variance between cycles by factor.
    ///
    /// Parameters
    /// ----------
    /// cycles : int
    ///     Number of base rows of the design, at least 1; each factor costs as many cycles.
    /// seed : int
    ///     Master seed.
    /// first_cycle : int
    ///     Id of the first cycle.
    /// column : str, optional
    ///     The quantity whose variance is shared out; by default the consumption.
    /// factors : sequence of str, optional
    ///     Only these factors, such as ``["road", "driver"]``; all by default.
    /// over : {"trip", "truck"}
    ///     Over which the variance is taken: trips, or trucks, each by its total over its total.
    /// crossed : int, optional
    ///     A second opinion: also drives so many cycles, at least 2, with each of 30 drivers, and
    ///     splits the variance two ways (``two_way``).
    /// shapley : bool
    ///     Shares of the six factors that add up to one, too, for 64 more cycles a row.
    /// out : str or os.PathLike, optional
    ///     Directory for the design, the study, ``sensitivity.json`` and a page; it has to be
    ///     empty, and is made where it is not there.
    /// threads : int, optional
    ///     Threads to use, one for each CPU by default.
    /// progress : bool or callable, optional
    ///     As for `Study.run`.
    ///
    /// Returns
    /// -------
    /// Answer
    ///     The content of ``ocmc sensitivity --json``: ``factors`` with ``first`` and ``total``,
    ///     each with its 95 % interval, and others. ``first`` is the first-order effect of a
    ///     factor, ``total`` its total effect: the share that would be gone if it were fixed. With
    ///     ``shapley`` there is also ``shapley`` with its ``factors`` and their ``share``.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Where a number is out of its range, or where there is no such column or factor.
    ///
    /// Notes
    /// -----
    /// By exchanging the random streams of each factor; the guide's page on sensitivity has the
    /// estimators.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> study = ocmc.Study("field-truck").set("mission.length_m", 5000.0)
    /// >>> answer = study.sensitivity(cycles=50, factors=["road", "driver"])
    /// >>> [share["factor"] for share in answer["factors"]]
    /// ['road', 'driver']
    #[pyo3(
        signature = (
            *, cycles, seed=None, first_cycle=None, column=None, factors=None, over=None,
            crossed=None, shapley=false, out=None, threads=None, progress=None
        ),
        text_signature = "($self, *, cycles, seed=1, first_cycle=0, column=None, factors=None, \
                          over='trip', crossed=None, shapley=False, out=None, threads=None, \
                          progress=None)"
    )]
    fn sensitivity<'py>(
        &self,
        py: Python<'py>,
        cycles: &Bound<'py, PyAny>,
        seed: Option<&Bound<'py, PyAny>>,
        first_cycle: Option<&Bound<'py, PyAny>>,
        column: Option<&str>,
        factors: Option<Vec<String>>,
        over: Option<&str>,
        crossed: Option<&Bound<'py, PyAny>>,
        shapley: bool,
        out: Option<PathBuf>,
        threads: Option<&Bound<'py, PyAny>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let plan = plan_of(cycles, seed, first_cycle, threads)?;
        let (study, column) = (&self.loaded, column.map(str::to_owned));
        let over = over.map(|word| one_of("over", word, &OVERS)).transpose()?.unwrap_or_default();
        let last = MOST_CROSSED.min(LAST_CYCLE_ID - plan.first_cycle);
        let crossed = crossed.map(|n| whole_number(n, "crossed", 2, last)).transpose()?;
        out.as_deref().map_or(Ok(()), check_empty).map_err(exception)?;
        let request = SensitivityRequest { study, plan, column, factors, over, crossed, shapley };
        let effects = watched(py, progress, |watch| ocmc_api::sensitivity(&request, watch))?;
        out.map_or(Ok(()), |out| effects.save(&out)).map_err(exception)?;
        answer(py, &effects)
    }

    /// The best that is possible: the least energy for the same road, truck and trip time, and how
    /// far the drivers are from it.
    ///
    /// Parameters
    /// ----------
    /// cycles : int
    ///     Number of cycles; one of 100 km takes a few seconds.
    /// seed : int
    ///     Master seed.
    /// first_cycle : int
    ///     Id of the first cycle.
    /// threads : int, optional
    ///     Threads to use, one for each CPU by default.
    /// progress : bool or callable, optional
    ///     As for `Study.run`.
    ///
    /// Returns
    /// -------
    /// Answer
    ///     The content of ``ocmc bound --json``: ``potential``, the shares of the drivers' energy
    ///     that were not needed, with those of each kind of road in ``by_road_type``, and
    ///     ``bounds``, the cycles.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Where a number is out of its range, or where no driver arrives.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> study = ocmc.Study("field-truck").set("mission.length_m", 3000.0)
    /// >>> answer = study.bound(cycles=2)
    /// >>> [part["name"] for part in answer["potential"]][:3]
    /// ['all', 'gears', 'stop']
    #[pyo3(
        signature = (*, cycles, seed=None, first_cycle=None, threads=None, progress=None),
        text_signature = "($self, *, cycles, seed=1, first_cycle=0, threads=None, progress=None)"
    )]
    fn bound<'py>(
        &self,
        py: Python<'py>,
        cycles: &Bound<'py, PyAny>,
        seed: Option<&Bound<'py, PyAny>>,
        first_cycle: Option<&Bound<'py, PyAny>>,
        threads: Option<&Bound<'py, PyAny>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let plan = plan_of(cycles, seed, first_cycle, threads)?;
        let request = BoundRequest { study: &self.loaded, plan };
        answer(py, &watched(py, progress, |watch| ocmc_api::bound(&request, watch))?)
    }

    /// Contribution of judged numbers to the answer's uncertainty: each is driven at both ends of
    /// its plausible range, on the same cycles.
    ///
    /// Parameters
    /// ----------
    /// cycles : int
    ///     Number of cycles at each end of the twelve entries that matter most; the others drive a
    ///     tenth of them.
    /// against : Study, optional
    ///     A study B: then it is B less this one, A, that is asked about.
    /// seed : int
    ///     Master seed.
    /// first_cycle : int
    ///     Id of the first cycle.
    /// column : str, optional
    ///     The quantity; by default the first consumption that the studies have.
    /// out : str or os.PathLike, optional
    ///     Directory for ``doubt.json``, ``doubt.csv``, the studies and a page; it has to be empty,
    ///     and is made where it is not there.
    /// threads : int, optional
    ///     Threads to use, one for each CPU by default.
    /// progress : bool or callable, optional
    ///     As for `Study.run`.
    ///
    /// Returns
    /// -------
    /// Answer
    ///     The content of ``ocmc doubt --json``: ``together``, the roots of the sums of squares of
    ///     the effects on mean, standard deviation and 95th percentile. ``numbers`` have each its
    ///     changes at the ``low`` and the ``high`` end, its ``share``, its ``reason`` and the
    ///     command whose data would replace it (``replaced_by``).
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Where a number is out of its range, where there is no such column, or where nothing is
    ///     judged.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> study = ocmc.Study("field-truck").set("mission.length_m", 3000.0)
    /// >>> answer = study.doubt(cycles=10)
    /// >>> answer["numbers"][0]["standing"]
    /// 'judged'
    #[pyo3(
        signature = (
            *, cycles, against=None, seed=None, first_cycle=None, column=None, out=None,
            threads=None, progress=None
        ),
        text_signature = "($self, *, cycles, against=None, seed=1, first_cycle=0, column=None, \
                          out=None, threads=None, progress=None)"
    )]
    fn doubt<'py>(
        &self,
        py: Python<'py>,
        cycles: &Bound<'py, PyAny>,
        against: Option<&Bound<'py, Self>>,
        seed: Option<&Bound<'py, PyAny>>,
        first_cycle: Option<&Bound<'py, PyAny>>,
        column: Option<&str>,
        out: Option<PathBuf>,
        threads: Option<&Bound<'py, PyAny>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let plan = plan_of(cycles, seed, first_cycle, threads)?;
        out.as_deref().map_or(Ok(()), check_empty).map_err(exception)?;
        let against = against.map(|study| study.get().named());
        let column = column.map(str::to_owned);
        let request = DoubtRequest { study: self.named(), against, plan, column };
        let doubted = watched(py, progress, |watch| ocmc_api::doubt(&request, watch))?;
        out.map_or(Ok(()), |out| doubted.save(&out)).map_err(exception)?;
        answer(py, &doubted)
    }

    /// Values of the study's keys, in a grid or one by one, on the same cycles: the mean of each
    /// point, and how it differs from the first one.
    ///
    /// Parameters
    /// ----------
    /// points : dict of str to list, list of dict, table, str or os.PathLike
    ///     A dictionary from keys to lists of values is a grid. The last key goes through its
    ///     values first, and a key with one value holds for all points. A list of dictionaries has
    ///     the points one by one. So does a table, or its file: its columns are keys, its rows are
    ///     points. What a point lacks is as in the study. Values are in the unit of their key, 1000
    ///     points at most.
    /// cycles : int
    ///     Number of cycles that each point drives, at least 1.
    /// against : {"first", "base"}
    ///     What the points are compared with: the first one, or the study as it is.
    /// seed : int
    ///     Master seed.
    /// first_cycle : int
    ///     Id of the first cycle.
    /// column : str, optional
    ///     The quantity that is compared, such as ``"mean_speed_mps"``, or another column of the
    ///     records that is a number; by default the first consumption that all points have.
    /// threads : int, optional
    ///     Threads to use, one for each CPU by default.
    /// progress : bool or callable, optional
    ///     As for `Study.run`.
    ///
    /// Returns
    /// -------
    /// Answer
    ///     The content of ``ocmc sweep --json``: ``points``, each with its ``values``, its ``mean``
    ///     with its 95 % interval ``ci95``, its ``difference`` with ``difference_ci95``, and
    ///     ``share_not_completed``, in the unit of ``column``. ``pandas.json_normalize`` makes a
    ///     data frame of ``points``.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Before anything is driven, where a point is no study, two are the same, or there is
    ///     nothing to compare. Where a number is out of its range, or where there is no such
    ///     column.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> study = ocmc.Study("field-truck").set("mission.length_m", 5000.0)
    /// >>> answer = study.sweep({"mission.payload_kg": [0, 10_000, 20_000]}, cycles=20)
    /// >>> [point["values"]["mission.payload_kg"] for point in answer["points"]]
    /// [0, 10000, 20000]
    /// >>> answer["points"][2]["difference"] > answer["points"][1]["difference"] > 0.0
    /// True
    #[pyo3(
        signature = (
            points, *, cycles, against="first", seed=None, first_cycle=None, column=None,
            threads=None, progress=None
        ),
        text_signature = "($self, points, *, cycles, against='first', seed=1, first_cycle=0, \
                          column=None, threads=None, progress=None)"
    )]
    fn sweep<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        cycles: &Bound<'py, PyAny>,
        against: &str,
        seed: Option<&Bound<'py, PyAny>>,
        first_cycle: Option<&Bound<'py, PyAny>>,
        column: Option<&str>,
        threads: Option<&Bound<'py, PyAny>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let plan = plan_of(cycles, seed, first_cycle, threads)?;
        sweep(py, &self.loaded, points, against, plan, column, progress)
    }

    /// Calibrate the study to the totals of a fleet's trips.
    ///
    /// Parameters
    /// ----------
    /// trips : table, str or os.PathLike
    ///     One row a trip: ``distance_km``, ``fuel_l`` or ``energy_kwh``, and where known
    ///     ``gross_weight_kg``, ``driving_time_h``, ``climb_m``, ``truck``, ``driver``; or one row
    ///     a fill: ``truck``, ``odometer_km``, ``litres``, ``full``.
    /// columns : dict of str to str, optional
    ///     Which column is what, such as ``{"fuel_amount_l": "diesel"}``.
    /// amount_noise : float
    ///     Noise of the amounts, SD as a share.
    /// weight_noise : float
    ///     Noise of the gross weights, SD as a share.
    /// seed : int
    ///     Master seed.
    /// threads : int, optional
    ///     Threads to use, one for each CPU by default.
    /// progress : bool or callable, optional
    ///     As for `Study.run`.
    ///
    /// Returns
    /// -------
    /// Answer
    ///     The content of ``ocmc calibrate totals --json``: ``table`` and ``simulated``, what
    ///     changes would do (``questions``), the judged ``numbers`` with their scores, what
    ///     ``further`` columns would tell, and ``study``, the part of a study that follows.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Where the table cannot be read or has too few rows, or where its amounts are of another
    ///     carrier than the study's. Where no number of the study is judged.
    /// OSError
    ///     Where the file cannot be read.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> try:
    /// ...     ocmc.Study("field-truck").calibrate_totals("trips.csv", amount_noise=3)
    /// ... except ValueError as error:
    /// ...     print(error)
    /// `amount_noise` is 3, allowed is a share from 0 to 0.5
    #[pyo3(
        signature = (trips, *, columns=None, amount_noise=0.03, weight_noise=0.05, seed=None,
                     threads=None, progress=None),
        text_signature = "($self, trips, *, columns=None, amount_noise=0.03, weight_noise=0.05, \
                          seed=1, threads=None, progress=None)"
    )]
    fn calibrate_totals<'py>(
        &self,
        py: Python<'py>,
        trips: &Bound<'py, PyAny>,
        columns: Option<BTreeMap<String, String>>,
        amount_noise: f64,
        weight_noise: f64,
        seed: Option<&Bound<'py, PyAny>>,
        threads: Option<&Bound<'py, PyAny>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (noise, work) = ([amount_noise, weight_noise], (seed, threads));
        totals(py, (trips, columns), &self.loaded, noise, work, progress)
    }

    /// Costs of the study: per trip, km, tkm, truck-year and whole life, item by item. Or which of
    /// two studies costs less on the same cycles, from where on, and which numbers decide.
    ///
    /// Parameters
    /// ----------
    /// cycles : int, optional
    ///     Number of cycles that each study drives, at least 1; or `trucks`.
    /// trucks : int, optional
    ///     Number of trucks, in place of `cycles`: each makes the study's
    ///     ``fleet.trips_per_truck`` trips, or `trips`.
    /// trips : int, optional
    ///     Trips of each truck: sets ``fleet.trips_per_truck``.
    /// against : Study, optional
    ///     The study B that this one, A, is compared with.
    /// seed : int
    ///     Master seed of the cycles, and of the states of the world that prices are drawn for.
    /// first_cycle : int
    ///     Id of the first cycle.
    /// threads : int, optional
    ///     Threads to use, one for each CPU by default.
    /// progress : bool or callable, optional
    ///     As for `Study.run`.
    ///
    /// Returns
    /// -------
    /// Answer
    ///     The content of ``ocmc cost --json``, in the study's currency. ``items`` and ``total``
    ///     have their costs ``per_trip``, ``all_trips``, ``per_km``, ``per_tkm``, ``per_a`` (year)
    ///     and ``whole_life``. ``fleet`` is the cost of trucks that make several trips. ``spread``
    ///     is that over states of the world, with the shares of its variance in ``inputs``.
    ///     ``emissions`` stand beside them. With `against` these of ``a`` and of ``b``, and their
    ///     ``difference``.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Where a number is out of its range, where a study has no prices, where two have them in
    ///     two currencies, or where no cycle is completed.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> study = ocmc.Study("field-truck").set("mission.length_m", 5000.0)
    /// >>> prices = {"currency": "EUR", "fuel_per_l": 1.5, "driver_per_h": 30.0}
    /// >>> study = study.set("cost", prices)
    /// >>> answer = study.cost(cycles=20)
    /// >>> [item["item"] for item in answer["items"]]
    /// ['fuel', 'driver']
    #[pyo3(
        signature = (
            *, cycles=None, trucks=None, trips=None, against=None, seed=None, first_cycle=None,
            threads=None, progress=None
        ),
        text_signature = "($self, *, cycles=None, trucks=None, trips=None, against=None, seed=1, \
                          first_cycle=0, threads=None, progress=None)"
    )]
    fn cost<'py>(
        &self,
        py: Python<'py>,
        cycles: Option<&Bound<'py, PyAny>>,
        trucks: Option<&Bound<'py, PyAny>>,
        trips: Option<&Bound<'py, PyAny>>,
        against: Option<&Bound<'py, Self>>,
        seed: Option<&Bound<'py, PyAny>>,
        first_cycle: Option<&Bound<'py, PyAny>>,
        threads: Option<&Bound<'py, PyAny>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let counts = (cycles, trucks, trips);
        crate::cost::costed(py, self, against, counts, (seed, first_cycle, threads), progress)
    }

    /// The worth of a year's training for the drivers who stand worst in a fleet's records, and how
    /// sure it is who they are.
    ///
    /// Each trip is driven twice: by its own driver, and by another one or by the trained one, on
    /// the same road with the same truck.
    ///
    /// Parameters
    /// ----------
    /// trucks : int
    ///     Number of trucks, at least 2.
    /// trips : int, optional
    ///     Trips of each truck: sets ``fleet.trips_per_truck``; the study's by default.
    /// share : float
    ///     Share of the drivers who are trained, above 0 and below 1: those who stand worst.
    /// coached : dict, optional
    ///     Keys that training changes in the study, as ``{"driver.key": value}``; by default
    ///     trained drivers drive as the middle fifth of drivers.
    /// seed : int
    ///     Master seed.
    /// threads : int, optional
    ///     Threads to use, one for each CPU by default.
    /// progress : bool or callable, optional
    ///     As for `Study.run`.
    ///
    /// Returns
    /// -------
    /// Answer
    ///     The content of ``ocmc training --json``: ``shown``, the excess in the records.
    ///     ``expected``, the part of it that would come back. ``gain``, the gain of the training,
    ///     with ``amount_per_a`` and ``money_per_a`` for each chosen driver. ``truly_worst`` and
    ///     ``by_trips`` stand beside it.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Where a number is out of its range, where `coached` is no part of a study, or where
    ///     fewer than two drivers complete a trip.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> study = ocmc.Study("field-truck").set("mission.length_m", 3000.0)
    /// >>> answer = study.training(trucks=20, trips=5)
    /// >>> answer["drivers"], answer["chosen"]
    /// (20, 4)
    #[pyo3(
        signature = (
            *, trucks, trips=None, share=0.2, coached=None, seed=None, threads=None, progress=None
        ),
        text_signature = "($self, *, trucks, trips=None, share=0.2, coached=None, seed=1, \
                          threads=None, progress=None)"
    )]
    fn training<'py>(
        &self,
        py: Python<'py>,
        trucks: &Bound<'py, PyAny>,
        trips: Option<&Bound<'py, PyAny>>,
        share: f64,
        coached: Option<&Bound<'py, PyDict>>,
        seed: Option<&Bound<'py, PyAny>>,
        threads: Option<&Bound<'py, PyAny>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let share = inner_share(share, "share")?;
        let loaded = with_trips(&self.loaded, trips)?;
        let of_truck = loaded.study.nesting().trips_per_truck;
        let trucks = whole_number(trucks, "trucks", 2, LAST_CYCLE_ID / of_truck)?;
        let cycles = (trucks * of_truck).into_pyobject(py)?;
        let plan = plan_of(&cycles, seed, None, threads)?;
        let coached = settings(coached)?;
        let study = (loaded.model.study.name.clone(), &loaded);
        let request = TrainingRequest { study, coached, share, plan };
        answer(py, &watched(py, progress, |watch| ocmc_api::training(&request, watch))?)
    }

    /// How far battery trucks come: which share arrives, by length of the trip, season and payload.
    ///
    /// Trips are made long enough to empty the battery, without charging on the way. On given
    /// routes, which keep their lengths, a trip that arrives tells only that the range is longer.
    ///
    /// Parameters
    /// ----------
    /// cycles : int
    ///     Number of cycles, at least 1.
    /// seed : int
    ///     Master seed.
    /// first_cycle : int
    ///     Id of the first cycle.
    /// threads : int, optional
    ///     Threads to use, one for each CPU by default.
    /// progress : bool or callable, optional
    ///     As for `Study.run`.
    ///
    /// Returns
    /// -------
    /// Answer
    ///     The content of ``ocmc range --json``: ``arriving``, for shares of the trucks the longest
    ///     trip that they complete, and ``curve``, the share that arrives over the length.
    ///     ``by_season`` and ``by_payload`` have the same ``arriving``. Lengths are in m, intervals
    ///     of 95 %.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Where a number is out of its range, or the trucks have no battery.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> capacity = "vehicle.powertrain.battery_electric.battery.capacity_j"
    /// >>> study = ocmc.Study("battery-truck").set(capacity, 1.8e8)
    /// >>> answer = study.range(cycles=20)
    /// >>> answer["trips"], answer["depleted"], answer["curve"][0]["share"]
    /// (20, 20, 1.0)
    #[pyo3(
        signature = (*, cycles, seed=None, first_cycle=None, threads=None, progress=None),
        text_signature = "($self, *, cycles, seed=1, first_cycle=0, threads=None, progress=None)"
    )]
    fn range<'py>(
        &self,
        py: Python<'py>,
        cycles: &Bound<'py, PyAny>,
        seed: Option<&Bound<'py, PyAny>>,
        first_cycle: Option<&Bound<'py, PyAny>>,
        threads: Option<&Bound<'py, PyAny>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let plan = plan_of(cycles, seed, first_cycle, threads)?;
        let request = RangeRequest { study: self.named(), plan };
        answer(py, &watched(py, progress, |watch| ocmc_api::range(&request, watch))?)
    }

    /// How large a battery has to be for shares of the trips to arrive.
    ///
    /// Sizes are tried on the same trips, by bisection. Batteries differ in energy, and in mass
    /// where `kg_per_kwh` is given.
    ///
    /// Parameters
    /// ----------
    /// cycles : int
    ///     Number of cycles, at least 1.
    /// arrive : float or sequence of float
    ///     Shares of the trips, each above 0 and below 1.
    /// kg_per_kwh : float
    ///     Mass of the truck that a kWh of battery adds, in kg.
    /// season : {"winter", "spring", "summer", "autumn"}, optional
    ///     Only the trips among them that depart in this season of the north.
    /// seed : int
    ///     Master seed.
    /// first_cycle : int
    ///     Id of the first cycle.
    /// threads : int, optional
    ///     Threads to use, one for each CPU by default.
    /// progress : bool or callable, optional
    ///     As for `Study.run`.
    ///
    /// Returns
    /// -------
    /// Answer
    ///     The content of ``ocmc size --json``: ``sizes``, for each share ``capacity_j`` and its
    ///     95 % interval ``ci95_j``, in J, None where no battery is enough or the trips are too
    ///     few. ``tried`` are the sizes that were tried with the ``share`` that arrives.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Where a number is out of its range, or the trucks have no battery.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> study = ocmc.Study("battery-truck").set("mission.length_m", 20000.0)
    /// >>> half, most = study.size(cycles=40, arrive=[0.5, 0.9])["sizes"]
    /// >>> half["capacity_j"] < most["capacity_j"]
    /// True
    #[pyo3(
        signature = (
            *, cycles, arrive=None, kg_per_kwh=0.0, season=None, seed=None, first_cycle=None,
            threads=None, progress=None
        ),
        text_signature = "($self, *, cycles, arrive=0.95, kg_per_kwh=0.0, season=None, seed=1, \
                          first_cycle=0, threads=None, progress=None)"
    )]
    fn size<'py>(
        &self,
        py: Python<'py>,
        cycles: &Bound<'py, PyAny>,
        arrive: Option<&Bound<'py, PyAny>>,
        kg_per_kwh: f64,
        season: Option<&str>,
        seed: Option<&Bound<'py, PyAny>>,
        first_cycle: Option<&Bound<'py, PyAny>>,
        threads: Option<&Bound<'py, PyAny>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let plan = plan_of(cycles, seed, first_cycle, threads)?;
        let arrive = arrive.map_or_else(|| Ok(vec![0.95]), one_or_more)?;
        let study = self.named();
        let season = season.map(|word| one_of("season", word, &SEASONS)).transpose()?;
        let request = SizeRequest { study, arrive, kg_per_kwh, season, plan };
        answer(py, &watched(py, progress, |watch| ocmc_api::size(&request, watch))?)
    }

    /// List the keys in which another study differs from this one, what differs most first.
    ///
    /// Parameters
    /// ----------
    /// other : Study
    ///     Study B; this one is A.
    ///
    /// Returns
    /// -------
    /// Answer
    ///     The content of ``ocmc study diff --json``: ``differences`` with ``key``, ``a``, ``b``
    ///     and ``ratio`` of each, and others.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> study = ocmc.Study("field-truck")
    /// >>> other = study.set("vehicle.drag_area_m2", 4.5)
    /// >>> [difference["key"] for difference in study.diff(other)["differences"]]
    /// ['vehicle.drag_area_m2']
    fn diff<'py>(&self, py: Python<'py>, other: &Self) -> PyResult<Bound<'py, PyAny>> {
        let [a, b] = [self, other].map(|study| (study.name(), &study.loaded));
        answer(py, &ocmc_api::study_difference(a, b))
    }

    /// Look at the roads that the study draws from above: coarse classes.
    ///
    /// Parameters
    /// ----------
    /// cycles : int
    ///     Number of operating cycles that are drawn.
    /// seed : int
    ///     Master seed.
    /// first_cycle : int
    ///     Id of the first cycle.
    /// laws : bool
    ///     Draw no road: the classes of infinitely many, by the laws of the study. The other
    ///     numbers count for nothing then.
    ///
    /// Returns
    /// -------
    /// Answer
    ///     The content of ``ocmc study birds-eye --json``: ``birds_eye`` with the classes
    ///     ``hilliness``, ``transport_cycle``,
    ///     ``stop_density`` and ``curve_density``, the shares and numbers per km that they come
    ///     from, and others.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Where a number is out of its range, or where the study drives given routes and ``laws``
    ///     is asked for.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> view = ocmc.Study("field-truck").birds_eye(cycles=20)["birds_eye"]
    /// >>> view["hilliness"], view["transport_cycle"]
    /// ('predominantly_flat', 'long_distance')
    /// >>> ocmc.Study("urban-delivery").birds_eye(laws=True)["birds_eye"]["transport_cycle"]
    /// 'local'
    #[pyo3(
        signature = (*, cycles=None, seed=None, first_cycle=None, laws=false),
        text_signature = "($self, *, cycles=100, seed=1, first_cycle=0, laws=False)"
    )]
    fn birds_eye<'py>(
        &self,
        py: Python<'py>,
        cycles: Option<&Bound<'py, PyAny>>,
        seed: Option<&Bound<'py, PyAny>>,
        first_cycle: Option<&Bound<'py, PyAny>>,
        laws: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let standard = 100_u64.into_pyobject(py)?.into_any();
        let plan = plan_of(cycles.unwrap_or(&standard), seed, first_cycle, None)?;
        let plan = (!laws).then_some(plan);
        let request = BirdsEyeRequest { study: &self.loaded, plan };
        answer(py, &watched(py, None, |watch| ocmc_api::birds_eye(&request, watch))?)
    }

    /// The operating cycle of one cycle, as tracks along the road: without the driver and the
    /// truck.
    ///
    /// Parameters
    /// ----------
    /// cycle_id : int
    ///     Id of the cycle, as in the records.
    /// seed : int
    ///     Master seed of the run.
    ///
    /// Returns
    /// -------
    /// OperatingCycle
    ///     Tracks by their names (``grade``, ``curvature_per_m``, ``speed_limit_mps`` and others,
    ///     in SI units, with the unit as the name's suffix); also one table, for all that speak
    ///     Arrow.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> cycle = ocmc.Study("field-truck").set("mission.length_m", 5000.0).operating_cycle(3)
    /// >>> float(cycle["altitude_m"]["position_m"][-1]), cycle["altitude_m"]["rule"]
    /// (5000.0, 'linear')
    #[pyo3(
        signature = (cycle_id, *, seed=None),
        text_signature = "($self, cycle_id, *, seed=1)"
    )]
    fn operating_cycle(
        &self,
        py: Python,
        cycle_id: &Bound<PyAny>,
        seed: Option<&Bound<PyAny>>,
    ) -> PyResult<PyOperatingCycle> {
        let (cycle_id, seed) = (cycle_id_of(cycle_id)?, seed_of(seed)?);
        let cycle = py.detach(|| ocmc_api::operating_cycle(&self.loaded, seed, cycle_id));
        Ok(PyOperatingCycle(cycle))
    }

    /// The time series of one cycle.
    ///
    /// Parameters
    /// ----------
    /// cycle_id : int
    ///     Id of the cycle, as in the records.
    /// seed : int
    ///     Master seed of the run.
    ///
    /// Returns
    /// -------
    /// Table
    ///     One row a step: ``time_s``, ``position_m``, ``speed_mps``, ``desired_speed_mps`` and
    ///     others, in SI units, with the unit as the name's suffix.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> study = ocmc.Study("field-truck").set("mission.length_m", 5000.0)
    /// >>> trace = study.trace(3)
    /// >>> bool(trace["speed_mps"].max() < 40.0)
    /// True
    #[pyo3(
        signature = (cycle_id, *, seed=None),
        text_signature = "($self, cycle_id, *, seed=1)"
    )]
    fn trace(
        &self,
        py: Python,
        cycle_id: &Bound<PyAny>,
        seed: Option<&Bound<PyAny>>,
    ) -> PyResult<Table> {
        let (cycle_id, seed) = (cycle_id_of(cycle_id)?, seed_of(seed)?);
        let series = py.detach(|| ocmc_api::trace(&self.loaded, seed, cycle_id));
        Ok(Table::of_numbers(series.columns))
    }

    /// A table of the study, with its values as attributes.
    fn __getattr__<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        attribute(slf.py(), || slf.get().to_dict(slf.py()), name)
    }

    fn __dir__(slf: &Bound<Self>) -> PyResult<Vec<String>> {
        let mut names: Vec<String> = slf.get_type().dir()?.extract()?;
        names.extend(slf.get().to_dict(slf.py())?.keys().extract::<Vec<String>>()?);
        Ok(names)
    }

    /// A value of the study, by its dotted path; a table, with its values as attributes.
    fn __getitem__<'py>(slf: &Bound<'py, Self>, path: &str) -> PyResult<Bound<'py, PyAny>> {
        let content = slf.get().to_dict(slf.py())?;
        slf.py().import("ocmc._section")?.call_method1("at", (content, path))
    }

    fn _ipython_key_completions_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let content = slf.get().to_dict(slf.py())?;
        slf.py().import("ocmc._section")?.call_method1("paths", (content,))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.hash == other.hash
    }

    fn __hash__(&self, py: Python) -> PyResult<isize> {
        pyo3::types::PyString::new(py, &self.hash).hash()
    }

    fn __repr__(&self) -> String {
        format!("<ocmc.Study {:?}, hash {}>", self.name(), &self.hash[..8])
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("ocmc._display")?.call_method1("study", (slf,))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Pickled<'py>> {
        let allow_files = *slf.get().loaded.files() != Files::Refused;
        let ranged = toml::to_string(&slf.get().loaded.with_ranges());
        let ranged = ranged.expect("a study is tables, lists, numbers and words");
        Ok((slf.get_type(), (dictionary(slf.py(), &ranged)?, allow_files)))
    }
}

/// Most cycles of a crossed design.
const MOST_CROSSED: u64 = 1_000_000;

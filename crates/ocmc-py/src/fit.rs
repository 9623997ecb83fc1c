//! Fits: from measurements to the numbers of a study.

use crate::answer::answer;
use crate::error::exception;
use crate::input::{input, inputs, is_path, is_table, mappings, sequence};
use crate::log::steering;
use crate::operating_cycle::PyOperatingCycle;
use crate::plan::seed_of;
use crate::progress::warned;
use crate::study::{PyStudy, base_model};
use crate::value::{one_of, place_clock, whole_number, wrong_type};
use ocmc_api::{
    BESTS, CODINGS, CurveOptions, CurveSpeedOptions, CurveSpeedRequest, FleetOptions, FleetRequest,
    MOST_DRAWS, MOST_NEXT_TRIPS, OperatingCycleRequest, RoadOptions, RoadSource,
    SpeedChangeOptions, SpeedChangeRequest, TrafficRequest, WeatherRequest,
};
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// Fit the curve speeds of drivers: regression, analysis of variance, population.
///
/// Parameters
/// ----------
/// curves : table, str or os.PathLike
///     One row a curve: ``driver`` (or ``truck``), ``radius_m`` (m), ``speed_mps`` (m/s), and where
///     known ``direction`` (``left`` or ``right``), ``route_m`` (length of the route, m),
///     ``limit_mps`` (m/s). Further ``gap_before_m``, ``gap_after_m``, ``slowest_near_mps``,
///     ``stop_near_m``, as `detect_curves` gives them. Any table that exports Arrow, a dictionary
///     of columns, or a CSV file.
/// columns : dict of str to str, optional
///     Which column is what, such as ``{"speed_kmh": "v"}``.
/// base : Study, optional
///     The study that keeps all that curves do not show; ``field-truck`` by default.
/// tobit : bool
///     Take the population from the censored regression at the speed limits.
/// reference_radius_m : float
///     Radius at which speeds are compared, in m.
/// radius_range_m : tuple of float
///     Smallest and largest radius that take part, in m.
/// minimum_route_m : float
///     Routes have to be longer than this, in m, where their lengths are known.
/// isolated_m : float, optional
///     Take only curves that were driven freely. That is without another curve, a standstill or the
///     end of the log within this way, in m, and without a slower speed near them.
/// least_lateral_mps2 : float
///     Take only curves with at least this lateral acceleration, speed squared over radius, in
///     m/s².
/// fixed_exponent : float
///     Exponent of the second model, and the one that is tested.
/// significance : float
///     The direction stays in the model where its p is below this.
/// limit_share : float
///     Share of the speed limit from which on a curve counts as driven at the limit.
/// coding : {"sum_to_zero", "treatment"}
///     How the coefficients of drivers and directions are listed.
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc fit curve-speed --json``: ``anova``, ``estimated``, ``fixed``,
///     ``by_driver`` and others;
///     ``study`` is the part of a study that follows from it.
///
/// Raises
/// ------
/// ValueError
///     Where a column is missing or a cell is wrong, where the curves do not determine the model,
///     or where an option is out of its range.
/// OSError
///     Where the file cannot be read.
///
/// Notes
/// -----
/// ln v = ln v₀ + δ (ln R − ln R₀) + driver + direction + residual: Romano, Godio, Bruzelius,
/// Johannesson.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> radius = [50.0, 100.0, 200.0, 400.0]
/// >>> curves = {"driver": ["a"] * 4 + ["b"] * 4 + ["c"] * 4, "radius_m": radius * 3}
/// >>> speed = [10.1, 13.9, 20.2, 27.8, 11.1, 15.3, 22.1, 30.6, 9.6, 13.5, 19.0, 27.2]
/// >>> fit = ocmc.fit_curve_speed(curves | {"speed_mps": speed})
/// >>> round(fit["estimated"]["exponent"], 3)
/// 0.495
/// >>> study = ocmc.Study({"study": {"base": "field-truck"}} | fit["study"])
#[pyfunction]
#[pyo3(
    signature = (
        curves, *, columns=None, base=None, tobit=false, reference_radius_m=250.0,
        radius_range_m=(20.0, 500.0), minimum_route_m=5000.0, isolated_m=None,
        least_lateral_mps2=0.0, fixed_exponent=0.5, significance=0.05, limit_share=0.9,
        coding="sum_to_zero"
    ),
    text_signature = "(curves, *, columns=None, base=None, tobit=False, reference_radius_m=250.0, \
                      radius_range_m=(20.0, 500.0), minimum_route_m=5000.0, isolated_m=None, \
                      least_lateral_mps2=0.0, fixed_exponent=0.5, \
                      significance=0.05, limit_share=0.9, coding='sum_to_zero')"
)]
pub(crate) fn fit_curve_speed<'py>(
    py: Python<'py>,
    curves: &Bound<'py, PyAny>,
    columns: Option<BTreeMap<String, String>>,
    base: Option<&Bound<'py, PyStudy>>,
    tobit: bool,
    reference_radius_m: f64,
    radius_range_m: (f64, f64),
    minimum_route_m: f64,
    isolated_m: Option<f64>,
    least_lateral_mps2: f64,
    fixed_exponent: f64,
    significance: f64,
    limit_share: f64,
    coding: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let options = CurveSpeedOptions {
        reference_radius_m,
        radius_range_m: radius_range_m.into(),
        minimum_route_m,
        isolated_m,
        least_lateral_mps2,
        fixed_exponent,
        significance,
        limit_share,
        coding: one_of("coding", coding, &CODINGS)?,
    };
    let mappings = mappings(columns)?;
    let (curves, base) = (input(curves, "curves")?, &base_model(base));
    let request = CurveSpeedRequest { curves, mappings, base, options, tobit };
    answer(py, &py.detach(|| ocmc_api::fit_curve_speed(&request)).map_err(exception)?)
}

/// Fit accelerations and decelerations at changes of the speed limit: log-normal laws.
///
/// Parameters
/// ----------
/// table : table, str or os.PathLike, or a list of these
///     One row a speed change: ``acceleration_mps2`` (m/s², negative for slowing down), and where
///     known ``category`` and
///     ``driver`` (or ``truck``). Or logs: ``time_s``, ``speed_mps`` or ``speed_kmh``,
///     ``limit_mps`` or ``limit_kmh``. Any table that exports Arrow, a dictionary of columns, or a
///     CSV file.
/// columns : dict of str to str, optional
///     Which column of a log is what, such as ``{"speed_mph": "gps_speed"}``.
/// base : Study, optional
///     The study that keeps all that was not measured; ``field-truck`` by default.
/// untruncated : bool
///     Take the study from the laws with the thresholds in their likelihood.
/// window_s : float
///     Length of the window with the largest change of speed in a log, in s.
/// smallest_acceleration_mps2 : float
///     Smallest acceleration that counts as a change, in m/s².
/// smallest_deceleration_mps2 : float
///     Smallest deceleration that counts as a change, as a positive number, in m/s².
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc fit speed-change --json``: ``acceleration``, ``deceleration``,
///     ``by_category`` and others;
///     ``study`` is the part of a study that follows from it.
///
/// Raises
/// ------
/// ValueError
///     Where a column is missing or a cell is wrong, where no speed change is left, or where an
///     option is out of its range.
/// OSError
///     Where a file cannot be read.
///
/// Warns
/// -----
/// UserWarning
///     Where no acceleration or no deceleration was measured, and where cells of a log are no
///     numbers.
///
/// Notes
/// -----
/// a = a₀ exp(e), e normal: Romano, Godio, Bruzelius, Johannesson.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> sizes = [0.4, 0.45, 0.6, 0.65, 0.8, 0.9, -0.5, -0.55, -0.7, -0.75, -0.9, -1.0]
/// >>> drivers = ["a", "a", "b", "b", "c", "c"] * 2
/// >>> fit = ocmc.fit_speed_change({"driver": drivers, "acceleration_mps2": sizes})
/// >>> round(fit["acceleration"]["median_mps2"], 3), fit["deceleration"]["n"]
/// (0.608, 6)
/// >>> study = ocmc.Study({"study": {"base": "field-truck"}} | fit["study"])
#[pyfunction]
#[pyo3(signature = (
    table, *, columns=None, base=None, untruncated=false, window_s=2.0,
    smallest_acceleration_mps2=0.2, smallest_deceleration_mps2=0.4
))]
pub(crate) fn fit_speed_change<'py>(
    py: Python<'py>,
    table: &Bound<'py, PyAny>,
    columns: Option<BTreeMap<String, String>>,
    base: Option<&Bound<'py, PyStudy>>,
    untruncated: bool,
    window_s: f64,
    smallest_acceleration_mps2: f64,
    smallest_deceleration_mps2: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let options = SpeedChangeOptions {
        window_s,
        smallest_acceleration_mps2,
        smallest_deceleration_mps2,
        ..SpeedChangeOptions::default()
    };
    let mappings = mappings(columns)?;
    let (tables, base) = (&inputs(table, "table")?[..], &base_model(base));
    let request = SpeedChangeRequest { tables, mappings, base, options, untruncated };
    answer(py, &warned(py, None, |warn, watch| ocmc_api::fit_speed_change(&request, warn, watch))?)
}

/// Fit the road model of given operating cycles or logs, and look at them from above.
///
/// Parameters
/// ----------
/// cycles : OperatingCycle, str, os.PathLike or table, or a list of these
///     Operating cycles with the track ``road_type``: from `Study.operating_cycle`, or files as
///     ``ocmc cycle`` writes them. Or logs: ``time_s``, ``speed_mps`` or ``speed_kmh``, and where
///     known ``yaw_rate_radps``, ``limit_mps``, ``grade`` or ``altitude_m``, ``road_type``,
///     ``map_object``, ``position_m``, ``payload_kg`` and others. Logs are any tables that export
///     Arrow, dictionaries of columns, or CSV files.
/// columns : dict of str to str, optional
///     Which column of a log is what, such as ``{"speed_mph": "gps_speed"}``; then all files are
///     logs.
/// base : Study, optional
///     The study with these road types that keeps all that roads do not show; ``field-truck`` by
///     default.
/// radius_range_m : tuple of float, optional
///     Smallest and largest radius of the curves that are known, in m; the others are there and
///     were not seen. 20 to 500 m for logs, all for operating cycles by default.
/// road_type : str, optional
///     Road type of logs without a column ``road_type``; by default it follows from the speed
///     limit.
/// altitude_average_m : float
///     Length over which the altitudes of logs are averaged for the bird's-eye view, in m.
/// mission_stop_s : float
///     Standstills of logs from this time on are stops of the mission, in s.
/// split_ratio : float, optional
///     Cut a curve of a log in two where its curvature steps by this factor or more.
/// steering_ratio : float, optional
///     Ratio of the steering, 1 to 100, for logs that only have the angle of the steering wheel.
/// wheelbase_m : float, optional
///     Wheelbase, 0.5 to 20 m, for such logs.
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc fit operating-cycle --json``: ``types`` with their ``parameters``,
///     ``junction_turn``, ``mission``,
///     ``birds_eye`` and others; ``study`` is the part of a study that follows from it. Lengths are
///     in m.
///
/// Raises
/// ------
/// ValueError
///     Where a cycle has no road types, or one that the base study does not have. Where a file is
///     no operating cycle, a log cannot be used, or an option is out of its range.
/// OSError
///     Where a file cannot be read.
///
/// Warns
/// -----
/// UserWarning
///     Where the roads do not tell something, which then stays as in the base study, and where a
///     part of a log is not used.
///
/// Notes
/// -----
/// Maximum likelihood or moments of the model that draws each part of the road: the guide's page on
/// it has the list.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> study = ocmc.Study("field-truck")
/// >>> fit = ocmc.fit_operating_cycle([study.operating_cycle(k) for k in range(20)])
/// >>> fit["cycles"], [road["road_type"] for road in fit["types"]]
/// (20, ['motorway', 'rural', 'urban'])
#[pyfunction]
#[pyo3(signature = (
    cycles, *, columns=None, base=None, radius_range_m=None, road_type=None,
    altitude_average_m=200.0, mission_stop_s=300.0, split_ratio=None, steering_ratio=None,
    wheelbase_m=None
))]
pub(crate) fn fit_operating_cycle<'py>(
    py: Python<'py>,
    cycles: &Bound<'py, PyAny>,
    columns: Option<BTreeMap<String, String>>,
    base: Option<&Bound<'py, PyStudy>>,
    radius_range_m: Option<(f64, f64)>,
    road_type: Option<String>,
    altitude_average_m: f64,
    mission_stop_s: f64,
    split_ratio: Option<f64>,
    steering_ratio: Option<f64>,
    wheelbase_m: Option<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let standard = RoadOptions::default();
    let radius_range_m: Option<[f64; 2]> = radius_range_m.map(Into::into);
    let options = RoadOptions {
        curves: CurveOptions { split_ratio, ..standard.curves },
        radius_range_m: radius_range_m.unwrap_or(standard.radius_range_m),
        altitude_average_m,
        mission_stop_s,
        road_type,
        ..standard
    };
    let steering = steering(steering_ratio, wheelbase_m)?;
    let mappings = mappings(columns)?;
    let given = sequence(cycles, "cycles")?.unwrap_or_else(|| vec![cycles.clone()]);
    let roads = given.iter().enumerate().map(|(k, cycle)| road(cycle, k));
    let (roads, base) = (&roads.collect::<PyResult<Vec<_>>>()?[..], &base_model(base));
    let request =
        OperatingCycleRequest { roads, mappings, base, options, radius_range_m, steering };
    let fitted =
        warned(py, None, |warn, watch| ocmc_api::fit_operating_cycle(&request, warn, watch))?;
    answer(py, &fitted)
}

/// An operating cycle, or what one or a log is read from.
fn road<'a>(cycle: &'a Bound<PyAny>, k: usize) -> PyResult<RoadSource<'a>> {
    if let Ok(cycle) = cycle.cast::<PyOperatingCycle>() {
        return Ok(RoadSource::Cycle(&cycle.get().0));
    }
    if !is_path(cycle)? && !is_table(cycle)? {
        let allowed = "a path, a log or an ocmc.OperatingCycle, or a list of these";
        return Err(wrong_type(cycle, "cycles", allowed));
    }
    Ok(RoadSource::Measured(input(cycle, &format!("cycles[{k}]"))?))
}

/// Fit the records of a fleet: how much trucks, drivers and trips differ, and conclusions.
///
/// Parameters
/// ----------
/// records : table, str or os.PathLike
///     One row a trip: ``truck_id`` (or ``truck``, ``vehicle_id``), and where known ``driver_id``
///     (or ``driver``) and ``outcome``. Any table that exports Arrow, a dictionary of columns, a
///     file, or the directory of a run.
/// columns : dict of str to str, optional
///     Which column is what, such as ``{"truck": "plate"}``.
/// column : str, optional
///     The column that is compared; by default ``consumption_l_per_100km``, or where no trip has
///     one, ``consumption_kwh_per_km``.
/// weight : str, optional
///     The column that says how much a trip counts, such as ``distance_m``: the variance of a trip
///     is inverse to it. ``"none"``: each counts once; by default the distance, where it is there
///     and the column is an amount over the distance.
/// own_drivers : bool
///     Drivers are numbered within each truck.
/// month : bool
///     Months are part of the model; needs ``departure_s_of_year`` (s).
/// differ : float
///     The difference that is to be told apart, as a share of the mean.
/// power : float
///     The power with which it is to be told apart.
/// next_trips : int, optional
///     Trips of each truck in the next year; as many as in the records by default.
/// best : {"lowest", "highest"}
///     Which end of the column stands first in the league.
/// draws : int
///     Draws of all trucks and drivers, in which it is counted how sure the league is.
/// seed : int
///     Seed of these draws.
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc fit fleet --json``: ``components``, ``leagues``, ``telling_apart``,
///     ``next_year`` and others.
///
/// Raises
/// ------
/// ValueError
///     Where a column is missing or a cell is wrong, or where an option is out of its range. Where
///     there are fewer than two trucks or no repeated trips.
/// OSError
///     Where the file cannot be read.
///
/// Notes
/// -----
/// y = mean + truck + driver + trip, by restricted maximum likelihood: Bates, Mächler, Bolker,
/// Walker (2015).
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> records = {
/// ...     "truck_id": ["a"] * 3 + ["b"] * 3 + ["c"] * 3,
/// ...     "consumption_l_per_100km": [30.1, 31.9, 30.8, 33.5, 32.0, 33.1, 29.0, 30.2, 28.1],
/// ... }
/// >>> fit = ocmc.fit_fleet(records)
/// >>> [(part["level"], round(part["sd"], 2)) for part in fit["components"]]
/// [('truck', 1.81), ('trip', 0.92)]
/// >>> fit["leagues"][0]["members"][0]["label"]
/// 'c'
#[pyfunction]
#[pyo3(
    signature = (
        records, *, columns=None, column=None, weight=None, own_drivers=false, month=false,
        differ=0.01, power=0.8, next_trips=None, best="lowest", draws=None, seed=None
    ),
    text_signature = "(records, *, columns=None, column=None, weight=None, own_drivers=False, \
                      month=False, differ=0.01, power=0.8, next_trips=None, best='lowest', \
                      draws=4000, seed=1)"
)]
pub(crate) fn fit_fleet<'py>(
    py: Python<'py>,
    records: &Bound<'py, PyAny>,
    columns: Option<BTreeMap<String, String>>,
    column: Option<String>,
    weight: Option<String>,
    own_drivers: bool,
    month: bool,
    differ: f64,
    power: f64,
    next_trips: Option<&Bound<'py, PyAny>>,
    best: &str,
    draws: Option<&Bound<'py, PyAny>>,
    seed: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let standard = FleetOptions::default();
    let trips = |n| whole_number(n, "next_trips", 1, MOST_NEXT_TRIPS);
    let count = |n| whole_number(n, "draws", 1, MOST_DRAWS);
    let request = FleetRequest {
        records: input(records, "records")?,
        mappings: mappings(columns)?,
        column,
        weight,
        options: FleetOptions {
            own_drivers,
            month,
            differ,
            power,
            next_trips: next_trips.map(trips).transpose()?,
            best: one_of("best", best, &BESTS)?,
            draws: draws.map_or(Ok(standard.draws), count)?,
            seed: seed_of(seed)?,
            ..standard
        },
    };
    answer(py, &py.detach(|| ocmc_api::fit_fleet(&request)).map_err(exception)?)
}

/// Fit traffic densities by the hour and road type.
///
/// Parameters
/// ----------
/// table : table, str or os.PathLike
///     One row a measurement: ``road_type``, ``time`` (such as ``2024-03-01T14:00``) or ``time_s``
///     (from a midnight), and where there are several of a type, ``site``. The measurement is one
///     of ``density_share`` (of the density of standing traffic), ``density_per_m`` (vehicles per m
///     and lane) and ``speed_ratio`` (of the free speed). Any table that exports Arrow, a
///     dictionary of columns, or a CSV file.
/// columns : dict of str to str, optional
///     Which column is what, such as ``{"time": "stamp"}``.
/// base : Study, optional
///     The study that keeps all that was not measured; ``field-truck`` by default.
/// utc_offset_h : float, optional
///     Hours by which the place's standard time is ahead of UTC. Times in UTC need it; times with
///     another offset are taken at that of the first row without it.
/// zone : str, optional
///     The time zone of the place instead, such as ``Europe/Berlin``: times without an offset are
///     then its local times, with summer time.
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc fit traffic --json``: ``parameters``, ``n`` and others; ``study`` is
///     the part of a study that follows from it.
///
/// Raises
/// ------
/// ValueError
///     Where a column is missing or a cell is wrong, or where the measurements do not determine the
///     densities.
/// OSError
///     Where the file cannot be read.
///
/// Warns
/// -----
/// UserWarning
///     Where the measurements do not tell something, which then stays as in the base study.
///
/// Notes
/// -----
/// Off-peak and peak densities with an autoregression on the logit scale: the guide's page on it
/// has the list.
///
/// Examples
/// --------
/// >>> import numpy as np, ocmc
/// >>> time = 300.0 * np.arange(20 * 288)
/// >>> share = 0.1 * np.exp(0.2 * np.random.default_rng(1).normal(size=time.size))
/// >>> table = {"time_s": time, "road_type": ["rural"] * time.size, "density_share": share}
/// >>> import warnings
/// >>> with warnings.catch_warnings():
/// ...     warnings.simplefilter("ignore")  # noise without a correlation
/// ...     fit = ocmc.fit_traffic(table)
/// >>> round(fit["study"]["traffic"]["types"]["rural"]["off_peak_share"], 1)
/// 0.1
#[pyfunction]
#[pyo3(signature = (table, *, columns=None, base=None, utc_offset_h=None, zone=None))]
pub(crate) fn fit_traffic<'py>(
    py: Python<'py>,
    table: &Bound<'py, PyAny>,
    columns: Option<BTreeMap<String, String>>,
    base: Option<&Bound<'py, PyStudy>>,
    utc_offset_h: Option<f64>,
    zone: Option<&str>,
) -> PyResult<Bound<'py, PyAny>> {
    let (table, mappings, base) = (input(table, "table")?, mappings(columns)?, &base_model(base));
    let place = place_clock(utc_offset_h, zone)?;
    let request = TrafficRequest { table, mappings, base, place };
    answer(py, &py.detach(|| ocmc_api::fit_traffic(&request)).map_err(exception)?)
}

/// Fit the climate of hourly records.
///
/// Parameters
/// ----------
/// table : table, str or os.PathLike, or a sequence of them
///     One row an hour: ``time`` (such as ``2024-03-01T14:00``, the place's standard time) or
///     ``time_s`` (from a midnight of 1 January). With it any of ``temperature_k`` or
///     ``temperature_c``, ``pressure_pa`` or ``pressure_hpa``, ``relative_humidity`` (0 to 1) or
///     ``relative_humidity_percent``. Further ``precipitation_mps`` or ``precipitation_mm_per_h``,
///     ``wind_speed_mps``, ``wind_direction_rad`` or ``wind_direction_deg``. Any table that exports
///     Arrow, a dictionary of columns, or a CSV file. Several of one place are joined by time.
/// columns : dict of str to str, optional
///     Which column is what, such as ``{"time": "stamp"}``.
/// base : Study, optional
///     The study that keeps all that was not recorded; ``field-truck`` by default.
/// utc_offset_h : float, optional
///     Hours by which the place's standard time is ahead of UTC. Times in UTC need it; times with
///     another offset are taken at that of the first row without it.
/// zone : str, optional
///     The time zone of the place instead, such as ``Europe/Berlin``: times without an offset are
///     then its local times, with summer time.
///
/// Returns
/// -------
/// Answer
///     The content of ``ocmc fit weather --json``: ``parameters``, ``hours``, ``years`` and others;
///     ``study`` is the part of a study that follows from it.
///
/// Raises
/// ------
/// ValueError
///     Where a column is missing or a cell is wrong, or where the records do not determine the
///     climate.
/// OSError
///     Where the file cannot be read.
///
/// Warns
/// -----
/// UserWarning
///     Where the records do not tell something, which then stays as in the base study.
///
/// Notes
/// -----
/// Harmonics of year and day, autoregressions, a chain of wet hours, Weibull winds: the guide's
/// page on it has the list.
///
/// Examples
/// --------
/// >>> import numpy as np, ocmc
/// >>> time = 3600.0 * np.arange(4 * 8766)
/// >>> day = 2 * np.pi * time / 86400
/// >>> noise = np.random.default_rng(1).normal(size=time.size)
/// >>> year = 2 * np.pi * time / 86400 / 365.25
/// >>> table = {"time_s": time, "temperature_c": 8 - 9 * np.cos(year) - 2 * np.cos(day) + noise}
/// >>> import warnings
/// >>> with warnings.catch_warnings():
/// ...     warnings.simplefilter("ignore")  # only temperatures were recorded
/// ...     fit = ocmc.fit_weather(table)
/// >>> round(fit["study"]["weather"]["temperature"]["mean_k"])
/// 281
#[pyfunction]
#[pyo3(signature = (table, *, columns=None, base=None, utc_offset_h=None, zone=None))]
pub(crate) fn fit_weather<'py>(
    py: Python<'py>,
    table: &Bound<'py, PyAny>,
    columns: Option<BTreeMap<String, String>>,
    base: Option<&Bound<'py, PyStudy>>,
    utc_offset_h: Option<f64>,
    zone: Option<&str>,
) -> PyResult<Bound<'py, PyAny>> {
    let (tables, mappings, base) =
        (&inputs(table, "table")?, mappings(columns)?, &base_model(base));
    let place = place_clock(utc_offset_h, zone)?;
    let request = WeatherRequest { tables, mappings, base, place };
    answer(py, &py.detach(|| ocmc_api::fit_weather(&request)).map_err(exception)?)
}

//! `ocmc.OperatingCycle`: tracks along the road.

use crate::table::{Table, numbers, words};
use crate::value::shown;
use numpy::PyArray1;
use ocmc_api::{RealisedCycle, Track, Values};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict, PyIterator, PyList};
use pyo3_arrow::error::PyArrowResult;

/// Road, weather, traffic and mission of one cycle, as tracks along the road: without driver and
/// truck.
///
/// ``cycle["grade"]`` is one track, a dictionary: ``position_m`` and ``value`` are numpy arrays,
/// ``rule`` says how they are read: ``"constant"`` up to the next position, ``"linear"`` between
/// them, or ``"event"`` at the position alone. The whole cycle is also one table for all that speak
/// Arrow, such as ``polars.DataFrame(cycle)``. SI units throughout, with the unit as the name's
/// suffix.
///
/// An operating cycle comes from `Study.operating_cycle`.
///
/// Examples
/// --------
/// >>> import ocmc
/// >>> cycle = ocmc.Study("field-truck").set("mission.length_m", 5000.0).operating_cycle(3)
/// >>> cycle.length_m, list(cycle)[:3]
/// (5000.0, ['road_type', 'speed_limit_mps', 'curvature_per_m'])
/// >>> cycle["altitude_m"]["rule"]
/// 'linear'
#[pyclass(name = "OperatingCycle", module = "ocmc", frozen, mapping)]
pub(crate) struct PyOperatingCycle(pub(crate) RealisedCycle);

impl PyOperatingCycle {
    fn track<'py>(py: Python<'py>, track: &Track) -> PyResult<Bound<'py, PyDict>> {
        let parts = PyDict::new(py);
        parts.set_item("rule", track.rule.name())?;
        parts.set_item("position_m", PyArray1::from_slice(py, &track.position_m))?;
        let value = match &track.value {
            Values::Numbers(values) => PyArray1::from_slice(py, values).into_any(),
            Values::Names(names) => py.import("numpy")?.call_method1("array", (names, "U"))?,
        };
        parts.set_item("value", value)?;
        Ok(parts)
    }
}

/// Its rows: one a position.
fn rows_of(track: &Track) -> impl Iterator<Item = (&Track, usize)> {
    (0..track.position_m.len()).map(move |row| (track, row))
}

#[pymethods]
impl PyOperatingCycle {
    /// Id of the cycle.
    #[getter]
    fn cycle_id(&self) -> u64 {
        self.0.cycle_id
    }

    /// The master seed.
    #[getter]
    fn seed(&self) -> u64 {
        self.0.seed
    }

    /// Length, in m.
    #[getter]
    fn length_m(&self) -> f64 {
        self.0.length_m
    }

    /// Names of the tracks, so that ``dict(cycle)`` is a dictionary of them.
    ///
    /// Returns
    /// -------
    /// list of str
    ///     The names.
    fn keys(&self) -> Vec<&'static str> {
        self.0.tracks.iter().map(|track| track.name).collect()
    }

    /// Names and tracks.
    ///
    /// Returns
    /// -------
    /// list of tuple of str and dict
    ///     The tracks, in their order.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> cycle = ocmc.Study("field-truck").set("mission.length_m", 5000.0).operating_cycle(3)
    /// >>> [name for name, track in cycle.items() if track["rule"] == "linear"]
    /// ['altitude_m']
    fn items<'py>(&self, py: Python<'py>) -> PyResult<Vec<(&'static str, Bound<'py, PyDict>)>> {
        self.0.tracks.iter().map(|track| Ok((track.name, Self::track(py, track)?))).collect()
    }

    /// All tracks one below the other, as ``ocmc cycle`` writes them.
    ///
    /// Returns
    /// -------
    /// Table
    ///     ``track``, ``rule``, ``position_m``, and ``value`` for tracks of numbers or ``name`` for
    ///     tracks of names; the other one is null.
    ///
    /// Examples
    /// --------
    /// >>> import ocmc
    /// >>> cycle = ocmc.Study("field-truck").set("mission.length_m", 5000.0).operating_cycle(3)
    /// >>> cycle.to_table().columns
    /// ['track', 'rule', 'position_m', 'value', 'name']
    fn to_table(&self) -> Table {
        let rows = || self.0.tracks.iter().flat_map(rows_of);
        Table::of_columns(vec![
            ("track", words(rows().map(|(track, _)| Some(track.name)))),
            ("rule", words(rows().map(|(track, _)| Some(track.rule.name())))),
            ("position_m", numbers(rows().map(|(track, row)| Some(track.position_m[row])))),
            (
                "value",
                numbers(rows().map(|(track, row)| match &track.value {
                    Values::Numbers(numbers) => Some(numbers[row]),
                    Values::Names(_) => None,
                })),
            ),
            (
                "name",
                words(rows().map(|(track, row)| match &track.value {
                    Values::Numbers(_) => None,
                    Values::Names(names) => Some(names[row].as_str()),
                })),
            ),
        ])
    }

    fn __getitem__<'py>(
        &self,
        py: Python<'py>,
        name: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let wanted = name.extract::<String>().unwrap_or_default();
        let track = self.0.tracks.iter().find(|track| track.name == wanted);
        let track = track.ok_or_else(|| {
            PyKeyError::new_err(format!("no track {}; `list(cycle)` names them", shown(name)))
        })?;
        Self::track(py, track)
    }

    fn __contains__(&self, name: &Bound<PyAny>) -> bool {
        let name = name.extract::<String>();
        name.is_ok_and(|name| self.0.tracks.iter().any(|track| track.name == name))
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        PyList::new(py, self.keys())?.try_iter()
    }

    fn __len__(&self) -> usize {
        self.0.tracks.len()
    }

    fn __repr__(&self) -> String {
        let RealisedCycle { cycle_id, seed, .. } = &self.0;
        let (kilometres, tracks) = (self.length_m() / 1000.0, self.0.tracks.len());
        format!(
            "<ocmc.OperatingCycle {cycle_id}, seed {seed}: {kilometres:.1} km, {tracks} tracks>"
        )
    }

    /// The rows of `to_table` for numpy, as `Table.__array__` gives them.
    #[pyo3(signature = (dtype=None, copy=None))]
    fn __array__<'py>(
        &self,
        py: Python<'py>,
        dtype: Option<Bound<'py, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        Table::__array__(&Bound::new(py, self.to_table())?, dtype, copy)
    }

    /// The rows of `to_table`, for all that take Arrow.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyCapsule>>,
    ) -> PyArrowResult<Bound<'py, PyCapsule>> {
        self.to_table().__arrow_c_stream__(py, requested_schema)
    }
}

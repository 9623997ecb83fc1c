//! Drive cycles over time: a table with time, speed and slope, of ours, of FASTSim or of VECTO.
//!
//! Other columns are not used. The slope of a row holds over the step that ends there.

use crate::given_cycle::VECTO_CYCLE;
use crate::table::source::{ending, is_table};
use crate::table::unit::KMH;
use crate::table::{Field, Mapping, Quantity, Schema, Source, Style, Table, TableError};
use ocmc_core::operating_cycle::TrafficStretch;
use ocmc_core::operating_cycle::given::{GivenCycle, GivenCycleError};
use ocmc_core::operating_cycle::tracks::{Rule, Track};
use ocmc_core::prescribed::{DriveCycle, DriveCycleError};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// What a drive cycle holds. Time and speed are needed; without a slope the road is flat.
pub const SCHEMA: Schema = Schema {
    what: "a drive cycle",
    style: Style::Description,
    fields: &[
        Field::named(
            Quantity::Time,
            &[("time_s", "s"), ("time", "s"), ("t", "s"), ("cycsecs", "s")],
        ),
        Field::named(
            Quantity::Speed,
            &[
                ("speed_mps", "mps"),
                ("mps", "mps"),
                ("cycmps", "mps"),
                ("speed_kmh", KMH),
                ("v", KMH),
                ("speed_mph", "mph"),
                ("mph", "mph"),
            ],
        ),
        Field::named(
            Quantity::Gradient,
            &[
                ("grade", ""),
                ("cycgrade", ""),
                ("grad", "percent"),
                // whatever the unit, a `grade` of a drive cycle is rise over run
                ("grade_percent", "percent"),
            ],
        ),
        Field::named(Quantity::Grade, &[("slope", "")]),
    ],
};

/// Seconds at rest from which a standstill is a stop of the route.
const STOP_S: f64 = 0.5;
/// How far inside the road a rest at one of its ends is a stop, in m: at the ends themselves a
/// truck only starts and ends.
const INSIDE_M: f64 = 0.5;

/// What is wrong with a drive cycle's file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DriveCycleFileError {
    /// A table that is not one.
    #[error(transparent)]
    Table(#[from] TableError),
    /// Numbers that are no drive cycle.
    #[error("`{}`: {source}", path.display())]
    Cycle {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: DriveCycleError,
    },
    /// A drive cycle that is no route.
    #[error("`{}` as a route: {source}", path.display())]
    Route {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: GivenCycleError,
    },
}

/// Whether a file is a table over time, of ours or of VECTO; what cannot be read is none.
pub fn is_one(path: &Path, mappings: &[Mapping]) -> bool {
    let (ours, vecto) = (is_table(path), ending(path) == "vdri");
    // a cycle of VECTO over distance may name the time, too
    let distance =
        |name: &String| vecto && VECTO_CYCLE.quantity_of(name) == Some(Quantity::Position);
    match Table::open(Source::File(path), &SCHEMA, mappings) {
        Ok(table) => {
            let time = table.column(Quantity::Time).is_some();
            (ours || vecto) && time && !table.names().iter().any(distance)
        }
        // a cycle whose columns are unclear is one, and says so when it is read
        Err(error) => (ours || vecto) && error.is_ambiguous(),
    }
}

/// Reads a drive cycle.
///
/// # Errors
/// [`DriveCycleFileError`] names the file, the line and what is allowed.
pub fn read(source: Source, mappings: &[Mapping]) -> Result<DriveCycle, DriveCycleFileError> {
    let table = Table::open(source, &SCHEMA, mappings)?;
    let time = table.need(Quantity::Time)?;
    let speed = table.need(Quantity::Speed)?;
    let slope = table.one_of(&[Quantity::Gradient, Quantity::Grade])?;
    let (mut time_s, mut speed_mps, mut sine) = (Vec::new(), Vec::new(), Vec::new());
    table.for_each(|row| {
        time_s.push(row.number(&time)?);
        speed_mps.push(row.number(&speed)?);
        let slope = slope.map(|column| row.number(&column).map(|slope| (column.quantity, slope)));
        sine.push(match slope.transpose()? {
            None => 0.0,
            Some((Quantity::Grade, slope)) => slope,
            Some((_, tangent)) => tangent / (1.0 + tangent * tangent).sqrt(),
        });
        Ok(())
    })?;
    DriveCycle::new(time_s, speed_mps, sine).map_err(|error| DriveCycleFileError::Cycle {
        path: source.path().to_owned(),
        source: error,
    })
}

/// The drive cycle as a table in CSV, from which [`read`] makes it again to the last bit.
pub fn to_csv(cycle: &DriveCycle) -> String {
    let mut text = "time_s,speed_mps,slope\n".to_owned();
    for [time_s, speed_mps, slope] in cycle.points() {
        writeln!(text, "{time_s},{speed_mps},{slope}").expect("a string takes any text");
    }
    text
}

/// The drive cycle as a route for a driver: the mean speed of each step is the limit on its stretch
/// of road, a standstill is a stop, half a metre inside the road where it is at one of its ends.
///
/// # Errors
/// [`DriveCycleFileError::Route`] where there is no road, as for a cycle that never moves.
pub fn as_route(path: &Path, cycle: &DriveCycle) -> Result<GivenCycle, DriveCycleFileError> {
    let mut limits = Track::empty("speed_limit_mps", Rule::Constant);
    let mut grades = Track::empty("grade", Rule::Constant);
    let mut stops = Track::empty("stop_sign_s", Rule::Event);
    let mut position_m = 0.0;
    let mut rests = Vec::new();
    for step in cycle.steps() {
        let way_m = step.speed.distance_m();
        if way_m <= 0.0 {
            rests.push((position_m, step.speed.dt_s));
            continue;
        }
        // a driver cannot be asked for less than walking pace
        limits.push(position_m, step.speed.mean_mps().max(1.0));
        grades.push(position_m, step.slope);
        position_m += way_m;
    }
    // a rest is one step, however many rows it has
    for (at_m, rest_s) in rests.into_iter().filter(|rest| rest.1 >= STOP_S) {
        stops.push(f64::min(at_m, position_m - INSIDE_M).max(INSIDE_M), rest_s);
    }
    let route = GivenCycle::from_tracks(&[limits, grades, stops], Some(position_m));
    // a prescribed speed contains the traffic already
    let free = vec![TrafficStretch { start_m: 0.0, density_per_m: 0.0 }];
    route
        .map(|route| GivenCycle { traffic: Some(free), ..route })
        .map_err(|source| DriveCycleFileError::Route { path: path.to_owned(), source })
}

//! Drive cycles over time: a table with time, speed and slope.
//!
//! | column | unit |
//! |---|---|
//! | `time_s` (`time`, `t`, `cycSecs`) | s |
//! | `speed_mps` (`mps`, `cycMps`), `speed_kmh` (`v` of a VECTO cycle over time) or `speed_mph` (`mph`) | m/s, km/h, mile/h |
//! | `slope` (climb per metre of road), or `grade` (`cycGrade`: rise over run), or `grad` (rise over run in %); absent: flat | - |
//!
//! Other columns are not used. The slope of a row holds over the step that ends there.

use crate::delimited::{DelimitedTable, KMH, MPH, MPS, PERCENT, PLAIN, SECONDS, TableError, Unit};
use ocmc_core::operating_cycle::TrafficStretch;
use ocmc_core::operating_cycle::given::{GivenCycle, GivenCycleError};
use ocmc_core::operating_cycle::tracks::{Rule, Track};
use ocmc_core::prescribed::{DriveCycle, DriveCycleError};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Names of the time's column.
pub(crate) const TIME: [&str; 4] = ["time_s", "time", "t", "cycsecs"];
/// Names of the speed's column, its unit, and what is 1 of it in m/s.
const SPEEDS: [(&str, Unit, f64); 7] = [
    ("speed_mps", MPS, 1.0),
    ("mps", MPS, 1.0),
    ("cycmps", MPS, 1.0),
    ("speed_kmh", KMH, 1.0 / 3.6),
    ("v", KMH, 1.0 / 3.6),
    ("speed_mph", MPH, 0.44704),
    ("mph", MPH, 0.44704),
];
/// Names of the slope's column, its unit, and what it has to be multiplied with.
const SLOPES: [(&str, Unit, f64); 4] = [
    ("slope", PLAIN, 1.0),
    ("grade", PLAIN, 1.0),
    ("cycgrade", PLAIN, 1.0),
    ("grad", PERCENT, 0.01),
];
/// Seconds at rest from which a standstill is a stop of the route.
const STOP_S: f64 = 0.5;
/// How far inside the road a rest at one of its ends is a stop, in m: at the ends themselves a truck only starts and ends.
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
pub fn is_one(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default();
    let [csv, vecto] = ["csv", "vdri"].map(|known| ending.eq_ignore_ascii_case(known));
    // a cycle of VECTO over distance may name the time, too
    let over_time = |table: &DelimitedTable| {
        table.find(&TIME).is_some() && (csv || table.find(&["s"]).is_none())
    };
    (csv || vecto) && DelimitedTable::read(path).is_ok_and(|table| over_time(&table))
}

/// Reads a drive cycle.
///
/// # Errors
/// [`DriveCycleFileError`] names the file, the line and what is allowed.
pub fn read(path: &Path) -> Result<DriveCycle, DriveCycleFileError> {
    of_table(&DelimitedTable::read(path)?)
}

/// The drive cycle of a table.
///
/// # Errors
/// As [`read`].
pub fn of_table(table: &DelimitedTable) -> Result<DriveCycle, DriveCycleFileError> {
    let read = |column: usize, names: &[(&str, Unit, f64)]| -> Result<Vec<f64>, TableError> {
        let name = table.names().nth(column).unwrap_or_default();
        let known = names.iter().find(|known| name == known.0);
        let (unit, factor) = known.map_or((PLAIN, 1.0), |known| (known.1, known.2));
        table.check_unit(column, unit)?;
        Ok(table.numbers(column)?.into_iter().map(|number| number * factor).collect())
    };
    let time_s = read(table.column(&TIME)?, &TIME.map(|name| (name, SECONDS, 1.0)))?;
    let speed = read(table.column(&SPEEDS.map(|(name, ..)| name))?, &SPEEDS)?;
    let slope = match table.one_of(&SLOPES.map(|(name, ..)| name))? {
        None => vec![0.0; time_s.len()],
        Some(column) => {
            let values = read(column, &SLOPES)?;
            if table.names().nth(column).as_deref() == Some("slope") {
                values
            } else {
                values.iter().map(|t| t / (1.0 + t * t).sqrt()).collect()
            }
        }
    };
    DriveCycle::new(time_s, speed, slope)
        .map_err(|source| DriveCycleFileError::Cycle { path: table.path().to_owned(), source })
}

/// The drive cycle as a table in CSV, from which [`of_table`] makes it again to the last bit.
pub fn to_csv(cycle: &DriveCycle) -> String {
    let mut text = "time_s,speed_mps,slope\n".to_owned();
    for [time_s, speed_mps, slope] in cycle.points() {
        writeln!(text, "{time_s},{speed_mps},{slope}").expect("a string takes any text");
    }
    text
}

/// The drive cycle as a route for a driver: the mean speed of each step is the limit on its stretch of road, a standstill is a stop,
/// half a metre inside the road where it is at one of its ends.
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
        // a driver cannot be told less than walking pace
        limits.push(position_m, step.speed.mean_mps().max(1.0));
        grades.push(position_m, step.slope);
        position_m += way_m;
    }
    // a rest is one step, however many rows it has
    for (at_m, rest_s) in rests.into_iter().filter(|rest| rest.1 >= STOP_S) {
        stops.push(f64::min(at_m, position_m - INSIDE_M).max(INSIDE_M), rest_s);
    }
    let route = GivenCycle::from_tracks(&[limits, grades, stops], Some(position_m));
    // whoever prescribes a speed has been through the traffic
    let free = vec![TrafficStretch { start_m: 0.0, density_per_m: 0.0 }];
    route
        .map(|route| GivenCycle { traffic: Some(free), ..route })
        .map_err(|source| DriveCycleFileError::Route { path: path.to_owned(), source })
}

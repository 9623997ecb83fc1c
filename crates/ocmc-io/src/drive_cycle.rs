//! Drive cycles over time: a table with time, speed and slope, of ours, of FASTSim or of VECTO.
//!
//! Other columns are not used. The slope of a row holds over the step that ends there.

use crate::intake::FileAccount;
use crate::table::error::Fault;
use crate::table::formats::{DRIVE_CYCLE, VECTO_CYCLE};
use crate::table::source::{ending, is_table};
use crate::table::{Mapping, Quantity, Source, Table, TableError};
use ocmc_core::operating_cycle::TrafficStretch;
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::tracks::{Rule, Track};
use ocmc_core::prescribed::DriveCycle;
use std::fmt::Write;
use std::path::Path;

/// Seconds at rest from which a standstill is a stop of the route.
const STOP_S: f64 = 0.5;
/// How far inside the road a rest at one of its ends is a stop, in m: at the ends themselves a
/// truck only starts and ends.
const INSIDE_M: f64 = 0.5;

/// Whether a file is a table over time, of ours or of VECTO; what cannot be read is none.
pub fn is_one(path: &Path, mappings: &[Mapping]) -> bool {
    let (ours, vecto) = (is_table(path), ending(path) == "vdri");
    // a cycle of VECTO over distance may name the time, too
    let distance =
        |name: &String| vecto && VECTO_CYCLE.quantity_of(name) == Some(Quantity::Position);
    match Table::open(Source::File(path), &DRIVE_CYCLE, mappings) {
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
/// [`TableError`] names the file, the line and what is allowed.
pub fn read(source: Source, mappings: &[Mapping]) -> Result<DriveCycle, TableError> {
    read_with_account(source, mappings).map(|(cycle, _)| cycle)
}

/// Reads a drive cycle, and says what was read.
///
/// # Errors
/// As [`read`].
pub fn read_with_account(
    source: Source,
    mappings: &[Mapping],
) -> Result<(DriveCycle, FileAccount), TableError> {
    let table = Table::open(source, &DRIVE_CYCLE, mappings)?;
    table.need(&[Quantity::Time, Quantity::Speed])?;
    table.one_of(&[Quantity::Gradient, Quantity::Grade])?;
    let (mut time_s, mut speed_mps, mut sine) =
        (Vec::<f64>::new(), Vec::<f64>::new(), Vec::<f64>::new());
    let of = |time_s, speed_mps, sine| {
        DriveCycle::new(time_s, speed_mps, sine)
            .map_err(|error| TableError::of(source.path(), Fault::DriveCycle(error)))
    };
    let account = table.for_each(|row| {
        time_s.push(row.number(Quantity::Time)?);
        speed_mps.push(row.number(Quantity::Speed)?);
        sine.push(match row.optional(Quantity::Gradient)? {
            Some(tangent) => tangent / (1.0 + tangent * tangent).sqrt(),
            None => row.optional(Quantity::Grade)?.unwrap_or(0.0),
        });
        // what is no cycle already is not read to its end; the last row alone may last for no time
        match time_s[..] {
            [.., a, b, _] if b <= a => {
                of(time_s.clone(), speed_mps.clone(), sine.clone()).map(drop)
            }
            _ => Ok(()),
        }
    })?;
    Ok((of(time_s, speed_mps, sine)?, account))
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
/// [`Fault::Route`] where there is no road, as for a cycle that never moves.
pub fn as_route(path: &Path, cycle: &DriveCycle) -> Result<GivenCycle, TableError> {
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
        .map_err(|error| TableError::of(path, Fault::Route(error)))
}

//! Drive cycles over time: a table with time, speed and slope, of ours, of FASTSim or of VECTO.
//!
//! The slope of a row holds over the step that ends there; where there is none, altitudes make it.

use crate::given_cycle::{checked_noise, in_file};
use crate::intake::table::clock::LogClock;
use crate::intake::table::error::Fault;
use crate::intake::table::formats::{DRIVE_CYCLE, ROUTE, TRACKS, VECTO_CYCLE};
use crate::intake::table::source::{ending, is_table};
use crate::intake::table::{Mapping, Quantity, Row, Source, Table, TableError};
use crate::intake::{
    Extent, FileAccount, Finding, contradiction, jump, sampling, slope, unused_column,
};
use crate::log;
use ocmc_core::operating_cycle::TrafficStretch;
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::road::route_geometry::interpolate;
use ocmc_core::operating_cycle::road::route_noise::{
    least_noise_of_altitudes_m, noise_of_altitudes, smooth_altitudes,
};
use ocmc_core::operating_cycle::tracks::{Rule, Track};
use ocmc_core::prescribed::{CycleStep, DriveCycle};
use std::fmt::Write;
use std::path::Path;

/// Seconds at rest from which a standstill is a stop of the route.
const STOP_S: f64 = 0.5;
/// Time over which the speeds of a cycle are one limit to a driver, in s.
const LIMIT_S: f64 = 1.0;
/// Step of cycles with rows further apart, in s: a business district by corners and at 10 Hz then
/// take the same within 0.1 %, and with 1 s 1 % more.
const STEP_S: f64 = 0.5;
/// Steps at most that a cycle is divided into.
const MOST_STEPS: f64 = 2e6;
/// Shortest way between the altitudes of which slopes are made, in m.
const SHORTEST_STEP_M: f64 = 1.0;
/// How far inside the road a rest at one of its ends is a stop, in m: at the ends themselves a
/// truck only starts and ends.
const INSIDE_M: f64 = 0.5;

/// Whether a source is a table over time, of ours or of VECTO, or at least none over the way; what
/// cannot be read is none.
pub fn is_one(source: Source, mappings: &[Mapping]) -> bool {
    let (ours, vecto) = match source {
        Source::File(path) => (is_table(path), ending(path) == "vdri"),
        Source::Text(..) | Source::Given(_) => (true, false),
    };
    // a cycle of VECTO over distance may name the time, too
    let distance =
        |name: &String| vecto && VECTO_CYCLE.quantity_of(name) == Some(Quantity::Position);
    let place = [Quantity::Position, Quantity::Latitude, Quantity::Longitude, Quantity::Track];
    let has_place = |name: &String| {
        let meant = ROUTE.means(name).or_else(|| TRACKS.means(name));
        meant.is_some_and(|quantity| place.contains(&quantity))
    };
    match Table::open(source, &DRIVE_CYCLE, mappings) {
        Ok(table) => {
            let time = table.column(Quantity::Time).is_some();
            let names = table.names();
            // a track has places, and its times tell how fast they were passed
            if table.is_export() && time {
                return true;
            }
            (ours || vecto) && !names.iter().any(distance) && (time || !names.iter().any(has_place))
        }
        // a cycle whose columns are unclear is one, and says so when it is read
        Err(error) => (ours || vecto) && error.is_of_columns(),
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
    if table.is_export() && table.column(Quantity::Speed).is_none() {
        return of_track(source, mappings);
    }
    table.need(&[Quantity::Time, Quantity::Speed])?;
    let sloped = table.one_of(&[Quantity::Gradient, Quantity::Grade])?.is_some();
    refuse_bare_v(&table, mappings)?;
    let allowed = table.allowed();
    let (mut time_s, mut speed_mps, mut sine) =
        (Vec::<f64>::new(), Vec::<f64>::new(), Vec::<f64>::new());
    let (mut altitude_m, mut position_m) = (Vec::<f64>::new(), Vec::<f64>::new());
    let cycle_of = |time_s, speed_mps, sine| {
        DriveCycle::new(time_s, speed_mps, sine)
            .map_err(|error| TableError::of(source.path(), Fault::DriveCycle(error)))
    };
    let (mut clock, mut origin_s) = (LogClock::default(), None);
    let mut account = table.for_each(|row| {
        time_s.push(time_of(row, &mut clock, &mut origin_s)?);
        speed_mps.push(row.number(Quantity::Speed)?);
        altitude_m.extend(row.optional(Quantity::Altitude)?);
        position_m.extend(row.optional(Quantity::Position)?);
        sine.push(match row.optional(Quantity::Gradient)? {
            Some(tangent) => tangent / (1.0 + tangent * tangent).sqrt(),
            None => row.optional(Quantity::Grade)?.unwrap_or(0.0),
        });
        // what is no cycle already is not read to its end; the last row alone may last for no time
        match time_s[..] {
            [.., a, b, _] if b <= a => {
                cycle_of(time_s.clone(), speed_mps.clone(), sine.clone()).map(drop)
            }
            _ => Ok(()),
        }
    })?;
    account.findings.extend(clock.finding());
    account.extent = Extent::of_drives([(&time_s[..], Some(&speed_mps[..]))].into_iter());
    account.findings.extend(unused_column::judge(&account.left_out, &allowed));
    let column = |quantity| match quantity {
        Quantity::Time => Some(time_s.as_slice()),
        Quantity::Speed => Some(speed_mps.as_slice()),
        Quantity::Position => Some(position_m.as_slice()).filter(|column| !column.is_empty()),
        Quantity::Altitude => Some(altitude_m.as_slice()).filter(|column| !column.is_empty()),
        Quantity::Grade => Some(sine.as_slice()).filter(|_| sloped),
        _ => None,
    };
    account.judged(source.path(), contradiction::of_drive(&column))?;
    let way_m = way_of(&time_s, &speed_mps);
    if !sloped && !altitude_m.is_empty() {
        let spikes;
        (sine, spikes) = slopes_of_altitudes(source.path(), &way_m, &altitude_m)?;
        account.findings.extend(spikes);
    }
    let steps_m = way_m.windows(2).map(|pair| pair[1] - pair[0]);
    let slopes = steps_m.zip(sine.iter().skip(1).copied());
    account.judged(source.path(), slope::judge(slopes, account.has_slope_with_unit()))?;
    let cycle = cycle_of(time_s, speed_mps, sine)?;
    let Some(finding) = sampling::judge(&cycle, STEP_S) else { return Ok((cycle, account)) };
    account.findings.push(finding);
    // a small file may last for years
    Ok((cycle.refined(STEP_S.max(cycle.duration_s() / MOST_STEPS)), account))
}

/// Reads a track whose places and times tell a speed; its altitudes tell the slope.
fn of_track(source: Source, mappings: &[Mapping]) -> Result<(DriveCycle, FileAccount), TableError> {
    let path = source.path();
    let file = log::read(source, mappings, &log::roads::NEEDS)?;
    let mut account = file.read;
    let [drive] = file.drives.as_slice() else {
        return Err(TableError::of(path, Fault::SeveralTracks));
    };
    let column = |quantity| drive.column(quantity).unwrap_or_default();
    let [time_s, speed_mps, altitude_m] =
        [Quantity::Time, Quantity::Speed, Quantity::Altitude].map(column);
    let known = |k: &usize| time_s[*k].is_finite() && speed_mps[*k].is_finite();
    let rows: Vec<usize> = (0..time_s.len()).filter(known).collect();
    let selected = |values: &[f64]| rows.iter().map(|k| values[*k]).collect::<Vec<f64>>();
    let start_s = rows.first().map_or(0.0, |row| time_s[*row]);
    let at_s: Vec<f64> = selected(time_s).iter().map(|time_s| time_s - start_s).collect();
    let speed_mps = selected(speed_mps);
    let way_m = way_of(&at_s, &speed_mps);
    let heights: Vec<(f64, f64)> = way_m
        .iter()
        .copied()
        .zip(rows.iter().map(|k| altitude_m.get(*k).copied().unwrap_or(f64::NAN)))
        .filter(|(_, altitude_m)| altitude_m.is_finite())
        .collect();
    let mut sine = vec![0.0; at_s.len()];
    if heights.len() > 1 {
        let (at_m, height_m): (Vec<f64>, Vec<f64>) = heights.into_iter().unzip();
        let altitude_m: Vec<f64> =
            way_m.iter().map(|way_m| interpolate(&at_m, &height_m, *way_m)).collect();
        let spikes;
        (sine, spikes) = slopes_of_altitudes(path, &way_m, &altitude_m)?;
        account.findings.extend(spikes);
    }
    let cycle = DriveCycle::new(at_s, speed_mps, sine)
        .map_err(|error| TableError::of(path, Fault::DriveCycle(error)))?;
    Ok((cycle, account))
}

/// The time of a row, in s: a number, or a date, counted from the first one.
fn time_of(row: &Row, clock: &mut LogClock, origin_s: &mut Option<f64>) -> Result<f64, TableError> {
    let text = row.text(Quantity::Time);
    if text.contains([':', 'T'])
        && let Ok(time_s) = clock.time_s(text)
    {
        return Ok(time_s - *origin_s.get_or_insert(time_s));
    }
    row.number(Quantity::Time)
}

/// The way up to each row, in m, with the speed straight between the rows.
fn way_of(time_s: &[f64], speed_mps: &[f64]) -> Vec<f64> {
    let mut way_m = vec![0.0; time_s.len()];
    for k in 1..time_s.len() {
        let step_m = 0.5 * (speed_mps[k] + speed_mps[k - 1]) * (time_s[k] - time_s[k - 1]);
        way_m[k] = way_m[k - 1] + step_m.max(0.0);
    }
    way_m
}

/// Refuses a speed `v` without a unit: VECTO's cycles, which write `<v>`, mean km/h, other people
/// m/s.
fn refuse_bare_v(table: &Table, mappings: &[Mapping]) -> Result<(), TableError> {
    let speed = table.column(Quantity::Speed).map(|column| &table.names()[column.place]);
    let vecto = ending(table.path()) == "vdri" || table.names().iter().any(|n| n.contains('<'));
    match speed {
        Some(name) if name.eq_ignore_ascii_case("v") && !vecto && !assigned(mappings, name) => {
            let text = format!("column `{name}` has no unit: it may be m/s or km/h");
            let remedy = "name it `speed_mps` or `speed_kmh`, or say which it is, as in --map \
                          speed_mps=v";
            let finding = Finding::refused("speed-without-unit", [1.0, 0.0], text, remedy);
            Err(TableError::of(table.path(), Fault::Check(finding)))
        }
        _ => Ok(()),
    }
}

fn assigned(mappings: &[Mapping], name: &str) -> bool {
    mappings.iter().any(|mapping| mapping.assigns(name))
}

/// The slope of each row, over the step that ends there, from altitudes: smoothed first where they
/// scatter, and with what was left out of them.
fn slopes_of_altitudes(
    path: &Path,
    way_m: &[f64],
    altitude_m: &[f64],
) -> Result<(Vec<f64>, Option<Finding>), TableError> {
    // at rest only the receiver wanders
    let (mut at_m, mut height_m) = (Vec::<f64>::new(), Vec::new());
    let mut rows = Vec::new();
    for (row, (way_m, altitude_m)) in way_m.iter().zip(altitude_m).enumerate() {
        if at_m.last().is_none_or(|last| *way_m >= last + SHORTEST_STEP_M) {
            at_m.push(*way_m);
            height_m.push(*altitude_m);
            rows.push(row + 1);
        }
    }
    // a vehicle that stands has no slope
    if at_m.len() < 2 {
        return Ok((vec![0.0; way_m.len()], None));
    }
    let spikes = jump::altitude_spikes(&at_m, &mut height_m, |k| format!("row {}", rows[k]));
    let noise_m = noise_of_altitudes(&at_m, &height_m);
    let noise_m = checked_noise("altitudes", noise_m).map_err(in_file(path))?;
    if noise_m >= least_noise_of_altitudes_m(&at_m) {
        (at_m, height_m) = smooth_altitudes(&at_m, &height_m, noise_m).into_iter().unzip();
    }
    let mut slopes = vec![0.0; way_m.len()];
    for k in 1..way_m.len() {
        let [from, to] = [k - 1, k].map(|k| interpolate(&at_m, &height_m, way_m[k]));
        if way_m[k] > way_m[k - 1] {
            slopes[k] = (to - from) / (way_m[k] - way_m[k - 1]);
        }
    }
    Ok((slopes, spikes))
}

/// The drive cycle as a table in CSV, from which [`read`] makes it again to the last bit.
pub fn to_csv(cycle: &DriveCycle) -> String {
    let mut text = "time_s,speed_mps,slope\n".to_owned();
    for [time_s, speed_mps, slope] in cycle.points() {
        writeln!(text, "{time_s},{speed_mps},{slope}").expect("a string takes any text");
    }
    text
}

/// Steps that follow each other.
#[derive(Clone, Copy, Debug, Default)]
struct Stretch {
    time_s: f64,
    way_m: f64,
    climb_m: f64,
}

impl Stretch {
    fn add(&mut self, step: &CycleStep) {
        let way_m = step.speed.distance_m();
        self.time_s += step.speed.dt_s;
        self.way_m += way_m;
        self.climb_m += step.slope * way_m;
    }

    /// Mean speed in m/s and slope; of a single step its own, to the bit.
    fn means(&self, last: &CycleStep) -> (f64, f64) {
        if self.time_s == last.speed.dt_s {
            return (last.speed.mean_mps(), last.slope);
        }
        (self.way_m / self.time_s, self.climb_m / self.way_m)
    }
}

/// The drive cycle as a route for a driver: the mean speed of each second is the limit on its
/// stretch of road, a standstill is a stop, half a metre inside the road where it is at one of its
/// ends.
///
/// # Errors
/// [`Fault::Route`] where there is no road, as for a cycle that never moves.
pub fn as_route(path: &Path, cycle: &DriveCycle) -> Result<GivenCycle, TableError> {
    let mut limits = Track::empty("speed_limit_mps", Rule::Constant);
    let mut grades = Track::empty("grade", Rule::Constant);
    let mut stops = Track::empty("stop_sign_s", Rule::Event);
    let mut position_m = 0.0;
    let mut rests = Vec::new();
    // a driver sees as much of a cycle of 10 Hz, or by corners, as of one of 1 Hz
    let mut stretch = Stretch::default();
    let mut steps = cycle.steps().peekable();
    while let Some(step) = steps.next() {
        if step.speed.distance_m() <= 0.0 {
            rests.push((position_m, step.speed.dt_s));
            continue;
        }
        stretch.add(&step);
        let goes_on = steps.peek().is_some_and(|next| {
            next.speed.distance_m() > 0.0
                && stretch.time_s + next.speed.dt_s <= LIMIT_S * (1.0 + 1e-6)
        });
        if !goes_on {
            // a driver cannot be asked for less than walking pace
            let (mean_mps, slope) = stretch.means(&step);
            limits.push(position_m, mean_mps.max(1.0));
            grades.push(position_m, slope);
            position_m += stretch.way_m;
            stretch = Stretch::default();
        }
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

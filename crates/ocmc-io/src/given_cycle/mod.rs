//! Given operating cycles, from the files of others and of ours:
//!
//! - `.vdri`: a VECTO cycle (distance, target speed, gradient, stop), `vdri`
//! - `.json` and tables with a column `track`: what `ocmc cycle` writes, `track_file`
//! - a stop plan, `stop_plan`: places with dwells and loads, alone or on a route
//! - any other table, or a track (GPX, KML, GeoJSON): a route by rows, with position or latitude
//!   and longitude, `route`

mod account;
mod objects;
mod places;
mod route;
mod stop_plan;
mod track_file;
mod vdri;

use crate::input_file;
use crate::intake::table::error::Fault;
use crate::intake::table::formats::{DRIVE_CYCLE, TRACKS};
use crate::intake::table::given::GivenTable;
use crate::intake::table::source::{ending, is_of_format, is_table, is_track, read_text};
use crate::intake::table::{Mapping, Quantity, Source, Table, TableError};
use crate::intake::{FileAccount, Finding, drawn, high_altitude, slope, unlike_a_road};
use crate::sha256;
use ocmc_core::operating_cycle::drawn_part::Draw;
use ocmc_core::operating_cycle::given::{GivenCycle, GivenCycleError};
use std::io::Read;
use std::path::Path;

pub use account::{Account, account};
pub use places::places_deg;
pub(crate) use route::checked_noise;
use stop_plan::StopPlan;

/// The routes that built-in studies name, by the name in the study, as `ocmc cycle` would write
/// them.
const BUILT_IN: &[(&str, &str)] = &[
    ("built-in/simulator-slopes.csv", include_str!("../../../../configs/simulator-slopes.csv")),
    ("built-in/simulator-route-1.csv", include_str!("../../../../configs/simulator-route-1.csv")),
    ("built-in/simulator-route-2.csv", include_str!("../../../../configs/simulator-route-2.csv")),
    ("built-in/simulator-route-3.csv", include_str!("../../../../configs/simulator-route-3.csv")),
    ("built-in/simulator-route-4.csv", include_str!("../../../../configs/simulator-route-4.csv")),
    ("built-in/simulator-route-5.csv", include_str!("../../../../configs/simulator-route-5.csv")),
    ("built-in/simulator-route-6.csv", include_str!("../../../../configs/simulator-route-6.csv")),
    ("built-in/simulator-route-7.csv", include_str!("../../../../configs/simulator-route-7.csv")),
    ("built-in/simulator-route-8.csv", include_str!("../../../../configs/simulator-route-8.csv")),
];

/// The text of what is built in under a name.
pub(crate) fn built_in(path: &Path) -> Option<&'static str> {
    BUILT_IN.iter().find(|(name, _)| path.to_str() == Some(name)).map(|(_, text)| *text)
}

/// How a route is to be read, beyond what its file says.
#[derive(Clone, Copy, Debug, Default)]
pub struct RouteOptions<'a> {
    /// Columns of a table.
    pub mappings: &'a [Mapping],
    /// Parts that are drawn where the file lacks them.
    pub draw: &'a [Draw],
    /// A file with the stop plan that is driven on the route.
    pub stop_plan: Option<&'a Path>,
    /// The content, in CSV, of what is no file but a table of a calling program.
    pub table: Option<&'a str>,
}

/// Reads a given operating cycle; the ending of the name, and for tables the header, say in which
/// format.
///
/// # Errors
/// [`TableError`] names the file, the place and what is allowed.
pub fn read(path: &Path, mappings: &[Mapping]) -> Result<GivenCycle, TableError> {
    read_with_account(path, mappings).map(|(cycle, _)| cycle)
}

/// As [`read`], with what was read.
///
/// # Errors
/// As [`read`].
pub fn read_with_account(
    path: &Path,
    mappings: &[Mapping],
) -> Result<(GivenCycle, FileAccount), TableError> {
    read_route(path, RouteOptions { mappings, ..RouteOptions::default() })
}

/// As [`read_with_account`], with more that is said of how it is to be read.
///
/// # Errors
/// As [`read`], also of the stop plan.
pub fn read_route(
    path: &Path,
    options: RouteOptions,
) -> Result<(GivenCycle, FileAccount), TableError> {
    let (cycle, mut account) = read_unjudged(path, options)?;
    account.findings.extend(drawn::told(&cycle, options.draw));
    // what altitudes say is looked at where they are read
    let has_slope = account.columns.iter().any(|column| column.quantity.starts_with("grad"));
    let points = cycle.altitude.windows(2).filter(|_| has_slope);
    let slopes = points.map(|pair| {
        let way_m = pair[1].0 - pair[0].0;
        (way_m, if way_m > 0.0 { (pair[1].1 - pair[0].1) / way_m } else { 0.0 })
    });
    account.judged(path, slope::judge(slopes, account.has_slope_with_unit()))?;
    let altitudes_m = cycle.altitude.iter().map(|point| point.1);
    account.judged(path, high_altitude::judge(altitudes_m))?;
    account.judged(path, unlike_a_road::judge(&cycle))?;
    Ok((cycle, account))
}

/// A route with the mission of its stop plan, where there is one.
fn read_unjudged(
    path: &Path,
    options: RouteOptions,
) -> Result<(GivenCycle, FileAccount), TableError> {
    let RouteOptions { mappings, draw, stop_plan, table } = options;
    let read = |mappings: &[Mapping]| match table {
        Some(text) => read_table(Source::Text(path, text), mappings, draw),
        None => read_file(path, mappings, draw),
    };
    let Some(plan) = stop_plan else {
        let (cycle, account, _) = read(mappings)?;
        return Ok((cycle, account));
    };
    let (of_plan, of_route): (Vec<Mapping>, Vec<Mapping>) =
        mappings.iter().cloned().partition(stop_plan::is_of_plan);
    let (mut cycle, mut account, points) = read(&of_route)?;
    check_readable(plan)?;
    let read = StopPlan::read(Source::File(plan), &of_plan)?;
    let of_plan = read.put_on(&mut cycle, points.as_ref())?;
    account.findings.extend(of_plan.findings.into_iter().map(|finding| {
        let text = format!("`{}`: {}", plan.display(), finding.text);
        Finding { text, ..finding }
    }));
    Ok((cycle, account))
}

/// A route, what was read of it, and its points where it has coordinates.
type ReadRoute = (GivenCycle, FileAccount, Option<route::Points>);

fn read_file(path: &Path, mappings: &[Mapping], draw: &[Draw]) -> Result<ReadRoute, TableError> {
    match ending(path).as_str() {
        "vdri" => {
            let (cycle, account) = vdri::read(Source::File(path), mappings)?;
            Ok((cycle, account, None))
        }
        "json" if !is_of_format(path) => {
            let cycle = track_file::read_json(path, &read_text(path)?, draw)?;
            let file = path.display().to_string();
            Ok((cycle, FileAccount { file, ..FileAccount::default() }, None))
        }
        _ if is_track(path) => route::read(Source::File(path), mappings, draw),
        _ if is_table(path) => read_table(Source::File(path), mappings, draw),
        _ => {
            check_readable(path)?;
            Err(TableError::of(path, Fault::Extension))
        }
    }
}

/// Reads a route from any table: a stop plan, tracks, or rows.
fn read_table(
    source: Source,
    mappings: &[Mapping],
    draw: &[Draw],
) -> Result<ReadRoute, TableError> {
    let alone = |(cycle, account)| (cycle, account, None);
    if stop_plan::is_one(source, mappings) {
        return stop_plan::read_alone(source, mappings, draw).map(alone);
    }
    let tracks = Table::open(source, &TRACKS, &[])?;
    if tracks.column(Quantity::Track).is_some() {
        return track_file::read_table(tracks, draw).map(alone);
    }
    route::read(source, mappings, draw)
}

/// Whether a table can be read as a route; what is wrong with it stands in a row, not in a line.
pub(crate) fn check_table(
    table: &GivenTable,
    mappings: &[Mapping],
    draw: &[Draw],
) -> Result<(), TableError> {
    read_table(Source::Given(table), mappings, draw).map(drop)
}

/// Reads an operating cycle from the text of a CSV file as `ocmc cycle` writes it; `path` is its
/// name in messages.
///
/// # Errors
/// As [`read`].
pub fn read_tracks(path: &Path, text: &str) -> Result<GivenCycle, TableError> {
    let table = Table::open(Source::Text(path, text), &TRACKS, &[])?;
    track_file::read_table(table, &[]).map(|(cycle, _)| cycle)
}

/// Whether a file, or what is built in under its name, can be read at all.
///
/// # Errors
/// [`Fault::Read`] with what the system says.
pub fn check_readable(path: &Path) -> Result<(), TableError> {
    if built_in(path).is_some() {
        return Ok(());
    }
    let read = input_file::open(path).and_then(|mut file| file.read(&mut [0]));
    read.map(drop).map_err(TableError::read(path))
}

/// SHA-256 of a file, of what is built in under its name, or of the content of a table that is no
/// file, in hexadecimal digits.
///
/// # Errors
/// Where it cannot be read.
pub fn file_hash(path: &Path, table: Option<&str>) -> Result<String, TableError> {
    match table.or_else(|| built_in(path)) {
        Some(text) => Ok(sha256::of_bytes(text.as_bytes())),
        None => sha256::of_file(path).map_err(TableError::read(path)),
    }
}

/// Names the file in an error of the core.
pub(crate) fn in_file(path: &Path) -> impl FnOnce(GivenCycleError) -> TableError + '_ {
    |error| TableError::of(path, Fault::Cycle(error))
}

/// Refuses a table that has the time, and no column for the position.
fn refuse_over_time(table: &Table, positions: &[Quantity]) -> Result<(), TableError> {
    let time = |name: &&String| DRIVE_CYCLE.quantity_of(name) == Some(Quantity::Time);
    match table.names().iter().find(time) {
        Some(column) if positions.iter().all(|position| table.column(*position).is_none()) => {
            Err(TableError::of(table.path(), Fault::OverTime(column.clone())))
        }
        _ => Ok(()),
    }
}

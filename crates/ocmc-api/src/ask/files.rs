//! Accounts of files that someone gives without saying what they are: routes, tracks, stop plans,
//! tables of trips, studies.

use super::thinned::thinned;
use crate::error::Error;
use crate::study::{Files, Given, Opened, open_all};
use ocmc_core::operating_cycle::drawn_part::{Draw, lacking};
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_io::export::{ExportKind, kind_of};
use ocmc_io::given_cycle::{RouteOptions, account, places_deg, read_route};
use ocmc_io::intake::FileAccount;
use ocmc_io::table::{Source, TableError};
use ocmc_io::trip_totals;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;

/// Points of a sketch.
const SKETCHED: usize = 400;

/// Kinds of files, and an account of each.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct FilesAnswer {
    /// The files, in the order in which they were asked for.
    pub files: Vec<AccountedFile>,
}

/// A file, and what was read of it.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct AccountedFile {
    /// Its name.
    pub file: String,
    /// Kind of the file.
    pub kind: FileKind,
    /// The same for people.
    pub words: &'static str,
    /// Account of the input that was read, in sentences.
    pub told: Vec<String>,
    /// Oddities and missing parts.
    pub warnings: Vec<String>,
    /// Why it cannot be used; none of a file that can.
    pub reason: Option<String>,
    /// Length of a route, in m.
    pub length_m: Option<f64>,
    /// Sum of the climbs of a route, in m.
    pub climb_m: Option<f64>,
    /// Altitudes of a route, thinned.
    pub profile: Option<RouteProfile>,
    /// Places of a route, thinned.
    pub map: Option<RouteMap>,
    /// The entry of `mission.routes` that drives it.
    pub route: Option<RouteEntry>,
}

/// Kind of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FileKind {
    /// A route, a track, a stop plan or an operating cycle: it can be driven.
    Route,
    /// A log of drives.
    Log,
    /// Totals of trips, or fills.
    Totals,
    /// Hours of weather.
    Weather,
    /// Densities or speeds of the traffic.
    Traffic,
    /// Measured curves.
    Curves,
    /// Measured changes of speed.
    SpeedChanges,
    /// A study.
    Study,
    /// A study of groups.
    Fleet,
    /// None of these.
    Unknown,
}

impl FileKind {
    fn words(self) -> &'static str {
        match self {
            Self::Route => "route",
            Self::Study => "study",
            Self::Fleet => "fleet of groups",
            Self::Unknown => "no file that can be read",
            Self::Log => ExportKind::Log.words(),
            Self::Totals => ExportKind::Totals.words(),
            Self::Weather => ExportKind::Weather.words(),
            Self::Traffic => ExportKind::Traffic.words(),
            Self::Curves => ExportKind::Curves.words(),
            Self::SpeedChanges => ExportKind::SpeedChanges.words(),
        }
    }
}

/// Altitudes along a route.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct RouteProfile {
    /// Position, in m.
    pub position_m: Vec<f64>,
    /// Altitude, in m.
    pub altitude_m: Vec<f64>,
}

/// Places of a route.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct RouteMap {
    /// Latitude, in degrees.
    pub latitude_deg: Vec<f64>,
    /// Longitude, in degrees.
    pub longitude_deg: Vec<f64>,
}

/// An entry of `mission.routes`.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct RouteEntry {
    /// The file.
    pub file: String,
    /// Parts that are drawn from the study, as the file lacks them.
    pub draw: Vec<Draw>,
}

/// Finds out what files are.
///
/// # Errors
/// [`Error::Study`] where a name leads out of where files may be read.
pub(super) fn accounted(names: Option<&[String]>, files: &Files) -> Result<FilesAnswer, Error> {
    let all = names.is_none().then(|| files.names()).transpose()?;
    let names = names.or(all.as_deref()).unwrap_or_default();
    let one = |name: &String| Ok(of_file(name, &files.path_of("files", name)?, files));
    Ok(FilesAnswer { files: names.iter().map(one).collect::<Result<_, Error>>()? })
}

fn of_file(name: &str, path: &Path, files: &Files) -> AccountedFile {
    if path.extension().is_some_and(|ending| ending == "toml") {
        return study(name, files);
    }
    let kind = kind_of(path, &[]);
    if let Ok(Some(ExportKind::Totals)) = kind {
        return totals(name, path);
    }
    match (route(path), kind) {
        (Ok((cycle, read, draw)), _) => driven(name, path, &cycle, read, draw),
        (Err(_), Ok(Some(ExportKind::Log))) => {
            let text =
                "drives of every second teach roads, curves and drivers: `ocmc learn FOLDER`";
            AccountedFile { told: vec![text.to_owned()], ..empty(name, FileKind::Log) }
        }
        (Err(_), Ok(Some(kind))) => {
            let kind = match kind {
                ExportKind::Weather => FileKind::Weather,
                ExportKind::Traffic => FileKind::Traffic,
                ExportKind::Curves => FileKind::Curves,
                ExportKind::SpeedChanges => FileKind::SpeedChanges,
                _ => FileKind::Unknown,
            };
            let text = "it fits a part of a study: `ocmc learn FOLDER`, or `ocmc fit`";
            AccountedFile { told: vec![text.to_owned()], ..empty(name, kind) }
        }
        (Err(error), _) => unusable(name, FileKind::Unknown, &error),
    }
}

fn empty(name: &str, kind: FileKind) -> AccountedFile {
    AccountedFile {
        file: name.to_owned(),
        kind,
        words: kind.words(),
        told: Vec::new(),
        warnings: Vec::new(),
        reason: None,
        length_m: None,
        climb_m: None,
        profile: None,
        map: None,
        route: None,
    }
}

fn unusable(name: &str, kind: FileKind, error: &TableError) -> AccountedFile {
    let help = error.help().map_or(String::new(), |help| format!("; {help}"));
    AccountedFile { reason: Some(format!("{error}{help}")), ..empty(name, kind) }
}

fn study(name: &str, files: &Files) -> AccountedFile {
    let none: &[&str] = &[];
    match open_all(&Given::Named(Path::new(name)), files, none) {
        Ok(Opened::Study(_)) => empty(name, FileKind::Study),
        Ok(Opened::Fleet(groups)) => {
            let names: Vec<&str> = groups.iter().map(|group| group.name.as_str()).collect();
            let groups = format!("groups: {}", names.join(", "));
            AccountedFile { told: vec![groups], ..empty(name, FileKind::Fleet) }
        }
        Err(error) => {
            AccountedFile { reason: Some(error.to_string()), ..empty(name, FileKind::Study) }
        }
    }
}

fn totals(name: &str, path: &Path) -> AccountedFile {
    match trip_totals::read(Source::File(path), &[]) {
        Ok((_, account)) => AccountedFile {
            told: account.told(),
            warnings: account.warnings(),
            ..empty(name, FileKind::Totals)
        },
        Err(error) => unusable(name, FileKind::Totals, &error),
    }
}

/// Reads a file as a route; what it lacks is drawn, of stops all or none.
fn route(path: &Path) -> Result<(GivenCycle, FileAccount, Vec<Draw>), TableError> {
    let read = |draw: &[Draw]| read_route(path, RouteOptions { draw, ..RouteOptions::default() });
    let (cycle, account) = read(&Draw::ALL)?;
    let has_stops = !cycle.events.is_empty() || !cycle.open_places.is_empty();
    let draw: Vec<Draw> = lacking(&cycle)
        .into_iter()
        .filter(|part| *part != Draw::Stops || !has_stops || !cycle.open_places.is_empty())
        .collect();
    // a file that has its own parts is read as it is, and one that cannot be says what it lacks
    match read(&draw) {
        Ok((cycle, account)) => Ok((cycle, account, draw)),
        Err(_) => Ok((cycle, account, Draw::ALL.to_vec())),
    }
}

fn driven(
    name: &str,
    path: &Path,
    cycle: &GivenCycle,
    read: FileAccount,
    draw: Vec<Draw>,
) -> AccountedFile {
    let route = account(path, cycle, read);
    let (position_m, altitude_m) = thinned(&cycle.altitude, SKETCHED).into_iter().unzip();
    let profile = Some(RouteProfile { position_m, altitude_m }).filter(|p| p.position_m.len() > 1);
    let map = places_deg(path).map(|[latitude_deg, longitude_deg]| {
        let places: Vec<_> = latitude_deg.into_iter().zip(longitude_deg).collect();
        let (latitude_deg, longitude_deg) = thinned(&places, SKETCHED).into_iter().unzip();
        RouteMap { latitude_deg, longitude_deg }
    });
    AccountedFile {
        told: route.told,
        warnings: route.warnings,
        length_m: Some(route.length_m),
        climb_m: Some(route.climb_m).filter(|_| profile.is_some()),
        profile,
        map,
        route: Some(RouteEntry { file: name.to_owned(), draw }),
        ..empty(name, FileKind::Route)
    }
}

//! The road that a log was driven on: as far as the log determines it.
//!
//! - way: the column of positions where it never falls, otherwise the integral of the speed
//! - curves: those of [`super::curve`]; length = heading change × radius of the central part, so
//!   that length and radius are those of one constant curvature
//! - slope: climbed up by the column of slopes; or the altitude, averaged over a length (judgement:
//!   200 m for a satellite receiver). The laws of slopes are estimated from the altitudes as they
//!   were measured
//! - speed limits, road types, roughness: columns, each value held until another one comes
//! - events: the map's objects where a column names them, with the standstills from 100 m before to
//!   10 m behind them (judgement); nothing else distinguishes a sign from a queue
//! - mission stops: the object, or standstills of at least 5 minutes (judgement)
//!
//! What a road's rows do not determine is not known of it ([`UnobservedSpans`]), rather than
//! absent: a road without altitude is not flat. The road of a drive is cut where nothing was logged
//! for more than 10 s, unless the vehicle stood; the drive is not: its roads are parts of one
//! mission ([`DrivePart`]). Everything that is not used is counted.

use super::Samples;
use super::TripLog;
use super::curve::{CurveOptions, detect_curves};
use super::road_rows::{RoadRows, SHORTEST_ROAD_M};
pub use super::road_slope::MeasuredAltitude;
use super::signal::{LIMITS_MPS, LogCounts, LogError, prepare};
use super::speed_envelope::limits_of_speed;
use super::standstill::Standstill;
use super::way::DrivenWay;
use crate::option_check::check_options;
use ocmc_core::operating_cycle::coverage::{Coverage, CurveCoverage, CurveWindow, UnobservedSpans};
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::road::route_geometry::Path2d;
use serde::Serialize;

/// A curve that begins this close to an object is a turn at it, in m: detectors see starts to
/// within two cells and the object's row.
const TURN_WITHIN_M: f64 = 20.0;

/// One drive whose road is wanted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RoadLog<'a> {
    /// Time, speed, yaw rate, limit. Without yaw rates no curves.
    pub drive: TripLog<'a>,
    /// Positions along the road, in m.
    pub position_m: Option<Samples<'a>>,
    /// Altitudes, in m.
    pub altitude_m: Option<Samples<'a>>,
    /// Slopes, each on the way from the row before.
    pub grade: Option<Samples<'a>>,
    /// Roughness coefficients, in m³.
    pub roughness_m3: Option<Samples<'a>>,
    /// Payload, in kg.
    pub payload_kg: Option<Samples<'a>>,
    /// Time of the day, in s from midnight.
    pub time_of_day_s: Option<Samples<'a>>,
    /// Day of the year, from 0.
    pub day_of_year: Option<Samples<'a>>,
    /// Road type of each row, empty where it is not known.
    pub road_type: Option<Vec<&'a str>>,
    /// Object of the map at each row, empty where there is none.
    pub map_object: Option<Vec<&'a str>>,
}

/// Substitute for the limits of a log that has none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MissingLimits {
    /// Nothing: they are not known.
    #[default]
    Unknown,
    /// One for the whole log, in m/s.
    Everywhere(f64),
    /// Limits that the speed of the drive shows ([`super::speed_envelope`]).
    OfSpeed,
}

/// Where the limits of a road come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LimitSource {
    /// A column of the log.
    Column,
    /// They were given.
    Given,
    /// The speed of the drive.
    Estimated,
    /// They are not known.
    Unknown,
}

impl LimitSource {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Column => "column",
            Self::Given => "given",
            Self::Estimated => "estimated",
            Self::Unknown => "unknown",
        }
    }
}

/// Options.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RoadOptions {
    /// How curves are found.
    pub curves: CurveOptions,
    /// Smallest and largest radius of curves that are taken, in m.
    pub radius_range_m: [f64; 2],
    /// Length over which altitudes are averaged, in m; 0: not.
    pub altitude_average_m: f64,
    /// Standstills from this time on are stops of the mission, in s.
    pub mission_stop_s: f64,
    /// Road type of logs that have none; none: by the speed limit.
    pub road_type: Option<String>,
    /// Limits of logs that have none.
    pub missing_limits: MissingLimits,
    /// Mass that is taken off gross weights, in kg: the rest is payload; none: they tell none.
    pub curb_mass_kg: Option<f64>,
}

impl Default for RoadOptions {
    fn default() -> Self {
        Self {
            curves: CurveOptions::default(),
            radius_range_m: [20.0, 500.0],
            altitude_average_m: 200.0,
            mission_stop_s: 300.0,
            road_type: None,
            missing_limits: MissingLimits::Unknown,
            curb_mass_kg: None,
        }
    }
}

/// Where a road lies on its drive, of which something was not logged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrivePart {
    /// Way from the start of the drive to the road, gaps included, in m.
    pub start_m: f64,
    /// Way of the whole drive, gaps and pieces that are no roads included, in m.
    pub drive_m: f64,
    /// Whether no road of the drive comes before.
    pub is_first: bool,
}

/// A stretch of road, and what is known of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoggedRoad {
    /// The road.
    pub cycle: GivenCycle,
    /// Standstills that no event explains.
    pub standstills: Vec<Standstill>,
    /// Where a part of it is not known.
    pub unobserved: UnobservedSpans,
    /// Its altitudes as they were measured, where no slope was: those of `cycle` are averaged.
    pub altitudes: Vec<MeasuredAltitude>,
    /// The drive; empty where the road is not that of a log.
    pub way: DrivenWay,
    /// Mean way from row to row of the log, in m.
    pub row_way_m: f64,
    /// Its place on the drive; none where it is the whole drive.
    pub part: Option<DrivePart>,
}

impl LoggedRoad {
    /// Whether a drive begins with it.
    pub fn begins_drive(&self) -> bool {
        self.part.is_none_or(|part| part.is_first)
    }
}

/// Counts of what was not used, or had to be supposed.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RoadCounts {
    /// Rows.
    pub rows: LogCounts,
    /// Cuts at times without rows.
    pub cuts: usize,
    /// Way across them, in m.
    pub cut_way_m: f64,
    /// Cuts across which positions do not tell the way: it is taken at the drive's mean speed.
    pub cuts_by_speed: usize,
    /// Pieces shorter than 200 m, which are no roads.
    pub too_short: usize,
    /// Rows whose limit is missing or impossible: the one before holds; a road without any has no
    /// signs.
    pub without_limit: usize,
    /// Rows without slope or altitude, where others have one: it goes on evenly over up to 200 m,
    /// longer ways are not known.
    pub without_slope: usize,
    /// Altitude that was taken out as jumps of the receiver, or steeper than any road, in m.
    pub altitude_jumps_m: f64,
    /// Rows without yaw rate, where others have one: longer ways of them determine nothing about
    /// curves.
    pub without_yaw_rate: usize,
    /// Rows without road type: the one before holds.
    pub without_road_type: usize,
    /// Roads without road type and speed limit, which are left out.
    pub untyped: usize,
    /// Roads whose types follow from limits, where others have a column for it.
    pub typed_by_limit: usize,
    /// Curves outside the range of radii.
    pub curves_outside: usize,
    /// Curves that the detector dropped: short, nearly straight, slow, or without a radius.
    pub curves_dropped: usize,
    /// Objects of the map with a name that means nothing here.
    pub unknown_objects: usize,
    /// Whether positions are the integral of the speed.
    pub by_speed: bool,
    /// Whether the road types of the whole log follow from limits.
    pub type_by_limit: bool,
}

/// The roads of a drive.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedRoads {
    /// Roads, in order.
    pub roads: Vec<LoggedRoad>,
    /// Coverage of the log.
    pub coverage: Coverage,
    /// Counts of what was not used.
    pub counts: RoadCounts,
    /// Where the limits come from.
    pub limits: LimitSource,
}

/// The roads of a log.
///
/// # Errors
/// [`LogError`] where the log cannot be used, an option is out of its range, or nothing determines
/// road types.
pub fn roads(log: &RoadLog, options: &RoadOptions) -> Result<LoggedRoads, LogError> {
    options.check()?;
    let known = |column: &Option<Samples>| {
        column.as_ref().is_some_and(|values| values.iter().any(|value| value.is_finite()))
    };
    let (given, limit_source) = with_limits(log, options.missing_limits);
    let log = &given;
    let limits = known(&log.drive.limit_mps);
    let words = |column: &Option<Vec<&str>>| {
        column.as_ref().is_some_and(|words| words.iter().any(|word| !word.is_empty()))
    };
    let types = words(&log.road_type);
    if !types && options.road_type.is_none() && !limits {
        return Err(LogError::NoRoadType);
    }
    let turns = log.drive.yaw_rate_radps.iter().any(|yaw| yaw.is_finite());
    let (tracks, rows) = tracks(log)?;
    let mut counts = RoadCounts {
        rows,
        type_by_limit: !types && options.road_type.is_none(),
        ..RoadCounts::default()
    };
    let detection = if turns { Some(detect_curves(&log.drive, &options.curves)?) } else { None };
    let curves = detection.as_ref().map_or(&[][..], |detection| &detection.curves);
    counts.curves_dropped = detection.as_ref().map_or(0, |detection| {
        detection.too_short + detection.too_straight + detection.too_slow + detection.without_radius
    });
    counts.cuts = tracks.len().saturating_sub(1);
    let gaps = gaps(&tracks, log);
    counts.cut_way_m = gaps.iter().map(|gap| gap.0).sum();
    counts.cuts_by_speed = gaps.iter().filter(|gap| gap.1).count();
    let mut roads: Vec<LoggedRoad> = Vec::new();
    // where the next track begins on the drive
    let mut start_m = 0.0;
    for (k, track) in tracks.iter().enumerate() {
        if let Some(mut road) = track.road(log, options, curves, &mut counts) {
            let is_first = roads.is_empty();
            road.part = Some(DrivePart { start_m, drive_m: 0.0, is_first });
            roads.push(road);
        }
        start_m += track.way(log).length_m() + gaps.get(k).map_or(0.0, |gap| gap.0);
    }
    for road in &mut roads {
        let part = road.part.map(|part| DrivePart { drive_m: start_m, ..part });
        road.part = part.filter(|_| tracks.len() > 1);
    }
    let slopes = known(&log.grade) || known(&log.altitude_m);
    // said of the whole log
    if !slopes {
        counts.without_slope = 0;
    }
    if !turns {
        counts.without_yaw_rate = 0;
    }
    if counts.type_by_limit {
        counts.typed_by_limit = 0;
    }
    let objects = words(&log.map_object);
    let coverage = Coverage {
        signs: limits,
        events: objects,
        slopes,
        curves: if turns { CurveCoverage::Within(options.window()) } else { CurveCoverage::None },
        turn_within_m: TURN_WITHIN_M,
        mission_stop_s: if objects { 0.0 } else { options.mission_stop_s },
    };
    Ok(LoggedRoads { roads, coverage, counts, limits: limit_source })
}

/// A log with what stands for its limits, where it has none, and where they come from.
fn with_limits<'a>(log: &RoadLog<'a>, missing: MissingLimits) -> (RoadLog<'a>, LimitSource) {
    let possible = |limit: &f64| (LIMITS_MPS[0]..=LIMITS_MPS[1]).contains(limit);
    let has = log.drive.limit_mps.as_ref().is_some_and(|limits| limits.iter().any(possible));
    let (limits, source) = match missing {
        _ if has => return (log.clone(), LimitSource::Column),
        MissingLimits::Unknown => return (log.clone(), LimitSource::Unknown),
        MissingLimits::Everywhere(limit) => {
            (vec![limit; log.drive.time_s.len()], LimitSource::Given)
        }
        MissingLimits::OfSpeed => {
            let limits = limits_of_speed(&log.drive.time_s, &log.drive.speed_mps);
            (limits, LimitSource::Estimated)
        }
    };
    let drive = TripLog { limit_mps: Some(limits.into()), ..log.drive.clone() };
    (RoadLog { drive, ..log.clone() }, source)
}

/// The ways of a log, cut where nothing was logged; those shorter than 200 m are left out.
///
/// # Errors
/// [`LogError`] where the log cannot be used.
pub fn ways(log: &RoadLog) -> Result<(Vec<DrivenWay>, LogCounts), LogError> {
    let (tracks, rows) = tracks(log)?;
    let ways = tracks.iter().map(|track| track.way(log));
    Ok((ways.filter(|way| way.length_m() >= SHORTEST_ROAD_M).collect(), rows))
}

/// Rows that one road goes through.
fn tracks(log: &RoadLog) -> Result<(Vec<RoadRows>, LogCounts), LogError> {
    let (pieces, rows) = prepare(&TripLog {
        time_s: log.drive.time_s.clone(),
        speed_mps: log.drive.speed_mps.clone(),
        yaw_rate_radps: vec![0.0; log.drive.time_s.len()].into(),
        ..TripLog::default()
    })?;
    let mut tracks = vec![RoadRows::default()];
    for piece in &pieces {
        if !tracks[tracks.len() - 1].goes_on(log, piece.row[0]) {
            tracks.push(RoadRows::default());
        }
        let track = tracks.last_mut().expect("there is always one");
        track.append(log, &piece.row, &piece.time_s, &piece.speed_mps);
    }
    Ok((tracks, rows))
}

/// The way across the time without rows behind each track but the last one, in m, and whether the
/// drive's mean speed stands for it: where no positions tell it.
fn gaps(tracks: &[RoadRows], log: &RoadLog) -> Vec<(f64, bool)> {
    let ways: Vec<DrivenWay> = tracks.iter().map(|track| track.way(log)).collect();
    let way_m: f64 = ways.iter().map(DrivenWay::length_m).sum();
    let logged_s: f64 = ways.iter().map(DrivenWay::duration_s).sum();
    let mean_mps = if logged_s > 0.0 { way_m / logged_s } else { 0.0 };
    let across = |pair: &[RoadRows]| {
        let (from, to) = (pair[0].last_row(), pair[1].first_row());
        let gap_s = log.drive.time_s[to] - log.drive.time_s[from];
        let told = log.moved_m(from, to);
        (told.unwrap_or(mean_mps * gap_s), told.is_none())
    };
    tracks.windows(2).map(across).collect()
}

impl RoadLog<'_> {
    /// Way between two rows, in m, as far as positions tell it: along the road, or else straight.
    fn moved_m(&self, from: usize, to: usize) -> Option<f64> {
        let values = |column: &Option<Samples>| {
            let column = column.as_ref()?;
            let pair = [column[from], column[to]];
            pair.iter().all(|value| value.is_finite()).then_some(pair)
        };
        if let Some([from_m, to_m]) = values(&self.position_m).filter(|[a, b]| b >= a) {
            return Some(to_m - from_m);
        }
        let latitude_deg = values(&self.drive.latitude_deg)?;
        let longitude_deg = values(&self.drive.longitude_deg)?;
        Path2d::new(&latitude_deg, &longitude_deg).position_m.last().copied()
    }
}

impl RoadOptions {
    /// The curves that are seen.
    pub fn window(&self) -> CurveWindow {
        CurveWindow {
            radius_m: self.radius_range_m,
            shortest_m: self.curves.shortest_m,
            smallest_turn_rad: self.curves.smallest_turn_rad,
        }
    }

    fn check(&self) -> Result<(), LogError> {
        let ([low, high], over_m) = (self.radius_range_m, self.altitude_average_m);
        let (short, stop_s) = ((0.0..=2000.0).contains(&over_m), self.mission_stop_s);
        if let MissingLimits::Everywhere(value) = self.missing_limits {
            let known = (LIMITS_MPS[0]..=LIMITS_MPS[1]).contains(&value);
            check_options([("the speed limit, in m/s,", value, "1 to 70", known)])
                .map_err(LogError::Option)?;
        }
        let stop = "the time from which a standstill is a stop of the mission, in s,";
        check_options([
            ("the smallest radius, in m,", low, "a number from 0 on", low >= 0.0),
            ("the largest radius, in m,", high, "a number above the smallest", high > low),
            ("the length over which altitudes are averaged, in m,", over_m, "0 to 2000", short),
            (stop, stop_s, "a number above 0", stop_s > 0.0),
        ])
        .map_err(LogError::Option)
    }
}

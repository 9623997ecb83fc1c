//! From log files to the roads that they were driven on.

use super::curves::{Steering, TripError, tells_steering_only, tells_turns, turning_log};
use super::noise::noise_of_turning;
use super::totals::of_drive;
use super::{LogFile, LoggedTrip, Need, counted, read_in_parts, row_notes};
use crate::intake::FileAccount;
use crate::intake::table::formats::LOG;
use crate::intake::table::given::RowPlace;
use crate::intake::table::source::is_track;
use crate::intake::table::{Mapping, Quantity, Source, Table, TableError};
use crate::number_text::{count_of, rounded};
use crate::trip_totals::{Amount, TripTotal};
use ocmc_core::operating_cycle::coverage::{Coverage, CurveCoverage, CurveWindow};
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::road::point_event::KINDS;
use ocmc_estimation::log::TripLog;
use ocmc_estimation::log::road::{
    LoggedRoad, LoggedRoads, RoadCounts, RoadLog, RoadOptions, roads,
};
use ocmc_estimation::log::way::DrivenWay;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

/// Altitude that is taken out of a log without a word, in m: a receiver that scatters by some
/// metres is steeper than a road now and then (judgement).
const LEAST_JUMPS_M: f64 = 10.0;

/// Most scatter of positions that alone tell how a vehicle turned, in m: errors of 3 m that fade
/// over 30 s scatter by 0.4 m from row to row at 1 Hz, and a track of `field-truck` has 1.1 curves
/// a km of them instead of 0.7 (`scripts/tracks_check.py`). A rounded seventh digit of a degree
/// scatters by 3 mm, a sixth by 3 cm.
const MOST_TURNING_NOISE_M: f64 = 0.1;

/// Most measured altitudes that are kept for a fit: of more, those of every second road, or fourth,
/// and so on, and of the others the first and the last. So many tell the SD of slopes to half a per
/// cent.
const MOST_ALTITUDES: usize = 500_000;

/// Way between the averaged altitudes of a road that are kept for a fit, in m; slopes are looked at
/// over 100 m.
const KEPT_ALTITUDE_M: f64 = 20.0 - 1e-6;
/// Rows of a log after which its complete drives are given away.
const PART_ROWS: usize = 1_000_000;
/// Most notes that say the same of other drives.
const MOST_ALIKE: usize = 3;

/// Needs of roads in a log.
pub const NEEDS: [Need; 2] = [&[Quantity::Time], &[Quantity::Speed]];

/// Whether a file is a log: a table with a column for time or speed, which no operating cycle has.
/// What cannot be read is none.
pub fn is_log(path: &Path, mappings: &[Mapping]) -> bool {
    if is_track(path) {
        return true;
    }
    match Table::open(Source::File(path), &LOG, mappings) {
        // a unit may be missing: that is said when it is read
        Ok(table) => {
            let named = |name: &String| name == "time" || name == "speed";
            let told = [Quantity::Time, Quantity::Date, Quantity::Day, Quantity::Speed];
            told.into_iter().any(|quantity| table.column(quantity).is_some())
                || table.names().iter().any(named)
        }
        // a log whose columns are unclear is one, and says so when it is read
        Err(error) => error.is_of_columns(),
    }
}

/// The roads of a log whose drives are in part held back.
#[derive(Clone, Debug, Default)]
pub struct RoadsApart {
    /// Roads of the drives that are not held back.
    pub others: FoundRoads,
    /// Roads of the drives that are held back.
    pub held_back: FoundRoads,
    /// Totals of all drives that tell an amount.
    pub totals: Vec<(Amount, TripTotal)>,
}

/// The roads of many drives, with what a fit needs of them.
#[derive(Clone, Debug, Default)]
pub struct FoundRoads {
    /// The roads.
    pub roads: Vec<LoggedRoad>,
    /// Coverage that all of them share; none before the first one.
    coverage: Option<Coverage>,
    /// Whether an object of the map stands beside any of them.
    has_objects: bool,
    /// Measured altitudes that are kept, and of which roads: each so many-th has all of its own.
    altitudes: usize,
    altitudes_of_each: usize,
    /// Notes that have to be known, each with its place.
    pub notes: Vec<String>,
    /// Where the drives stand that could not be used, and why.
    pub left_out: Vec<(String, TripError)>,
    /// Files that were read.
    pub inputs: Vec<FileAccount>,
}

impl FoundRoads {
    /// The roads of a log. Its drives are given away as it is read, where they follow each other.
    ///
    /// # Errors
    /// As [`super::read`].
    pub fn of_log(
        source: Source,
        mappings: &[Mapping],
        options: &RoadOptions,
        steering: Option<Steering>,
    ) -> Result<Self, TableError> {
        let mut roads = Self::default();
        let mut add = |part| roads.add(part, options, steering);
        let rest = match read_in_parts(source, mappings, &NEEDS, PART_ROWS, &mut add) {
            Err(error) if error.is_mixed() => {
                roads = Self::default();
                super::read(source, mappings, &NEEDS)?
            }
            rest => rest?,
        };
        roads.add(rest, options, steering);
        Ok(roads)
    }

    /// The roads of a log in two heaps, and the totals of its drives: those of drives for which
    /// `is_held_back` says so are the second one.
    ///
    /// # Errors
    /// As [`super::read`].
    pub fn of_log_apart(
        source: Source,
        mappings: &[Mapping],
        options: &RoadOptions,
        is_held_back: &dyn Fn(&LoggedTrip) -> bool,
    ) -> Result<RoadsApart, TableError> {
        let mut heaps = [Self::default(), Self::default()];
        let mut totals = Vec::new();
        let add = |mut part: LogFile, heaps: &mut [Self; 2], totals: &mut Vec<_>| {
            let drives = std::mem::take(&mut part.drives);
            for (k, drive) in drives.iter().enumerate() {
                let place = RowPlace::Row(k as u64 + 1);
                totals.extend(of_drive(drive, place, options.mission_stop_s));
            }
            let (held_back, others) = drives.into_iter().partition(is_held_back);
            let read = std::mem::take(&mut part.read);
            heaps[1].add(LogFile { drives: held_back, ..part.clone() }, options, None);
            heaps[0].add(LogFile { drives: others, read, ..part }, options, None);
        };
        let mut parts = |part| add(part, &mut heaps, &mut totals);
        let rest = match read_in_parts(source, mappings, &NEEDS, PART_ROWS, &mut parts) {
            Err(error) if error.is_mixed() => {
                (heaps, totals) = Default::default();
                super::read(source, mappings, &NEEDS)?
            }
            rest => rest?,
        };
        add(rest, &mut heaps, &mut totals);
        let [others, held_back] = heaps;
        Ok(RoadsApart { others, held_back, totals })
    }

    /// Finds the roads of a log's drives.
    /// Positions that scatter tell no curves: a detector would see other ones in them than those
    /// of its window. Nor do positions with rows that were put in between.
    pub fn add(&mut self, mut file: LogFile, options: &RoadOptions, steering: Option<Steering>) {
        let weighs = |quantity| file.columns.iter().any(|(column, _)| column.quantity == quantity);
        if let Some(curb_kg) = options.curb_mass_kg
            && weighs(Quantity::GrossWeight)
            && !weighs(Quantity::Payload)
        {
            let note = format!(
                "`{}`: payloads are gross weights less the curb mass of the base study, {} kg",
                file.path.display(),
                rounded(curb_kg)
            );
            if !self.notes.contains(&note) {
                self.notes.push(note);
            }
        }
        let places: Vec<String> = file.drives.iter().map(|drive| file.place(drive)).collect();
        // a drive is not kept beside its roads
        for (drive, place) in std::mem::take(&mut file.drives).into_iter().zip(places) {
            let scatter_m = noise_of_turning(&drive);
            let steered = steering.is_none() && tells_steering_only(&drive);
            let apart_s = drive.measured_each_s.filter(|_| !tells_turns(&drive));
            let turns = scatter_m < MOST_TURNING_NOISE_M && !steered && apart_s.is_none();
            match found(&drive, options, steering, turns) {
                Ok(measured) => {
                    self.has_objects |= measured.coverage.events;
                    // beside a road without objects the map was looked at, too, where it has them
                    // elsewhere
                    let events = drive.words(Quantity::MapObject).is_some();
                    self.cover(Coverage { events, ..measured.coverage });
                    self.notes.extend(notes(&place, &measured.counts));
                    if steered {
                        self.notes.push(steering_note(&place));
                    } else if let Some(apart_s) = apart_s {
                        self.notes.push(format!(
                            "{place}: only positions {} s apart tell how it turned: its curves are \
                             not known (rows of a second, a yaw rate or a course would tell them)",
                            rounded(apart_s)
                        ));
                    } else if !turns {
                        self.notes.push(format!(
                            "{place}: only positions tell how it turned, and they scatter by \
                             {scatter_m:.1} m: its curves are not known (a yaw rate or a course \
                             would tell them)"
                        ));
                    }
                    measured.roads.into_iter().for_each(|road| self.keep(road));
                }
                Err(fault) => self.left_out.push((place, fault)),
            }
        }
        if file.read != FileAccount::default() {
            self.inputs.push(file.read);
        }
    }

    /// Adds the roads of others.
    pub fn append(&mut self, others: Self) {
        others.roads.into_iter().for_each(|road| self.keep(road));
        self.has_objects |= others.has_objects;
        others.coverage.into_iter().for_each(|coverage| self.cover(coverage));
        self.notes.extend(others.notes);
        self.left_out.extend(others.left_out);
        self.inputs.extend(others.inputs);
    }

    /// Keeps a road, without its rows and with at most so many altitudes as all are to have.
    fn keep(&mut self, road: LoggedRoad) {
        self.altitudes += road.altitudes.len();
        self.roads.push(LoggedRoad { way: DrivenWay::default(), ..road });
        // laws of slopes are those of the measured altitudes: the averaged ones, every 5 m, tell
        // how hilly the road is
        if let Some(road) = self.roads.last_mut().filter(|road| road.altitudes.len() > 1) {
            let points = &road.cycle.altitude;
            let mut kept: Vec<(f64, f64)> = Vec::with_capacity(points.len() / 4 + 2);
            for (k, point) in points.iter().enumerate() {
                let ends = [kept.last(), points.get(k + 1)];
                let is_near = |end: Option<&(f64, f64)>| {
                    end.is_some_and(|end| (end.0 - point.0).abs() < KEPT_ALTITUDE_M)
                };
                if !ends.into_iter().all(is_near) {
                    kept.push(*point);
                }
            }
            kept.shrink_to_fit();
            road.cycle.altitude = kept;
        }
        let each = self.altitudes_of_each.max(1);
        if !(self.roads.len() - 1).is_multiple_of(each) {
            self.thin(self.roads.len() - 1);
        }
        if self.altitudes > MOST_ALTITUDES {
            self.altitudes_of_each = 2 * each;
            let others = (0..self.roads.len()).filter(|k| !k.is_multiple_of(2 * each));
            others.for_each(|k| self.thin(k));
        }
    }

    /// Keeps the first and the last altitude of a road.
    fn thin(&mut self, road: usize) {
        let altitudes = &mut self.roads[road].altitudes;
        if let [first, .., last] = altitudes[..] {
            self.altitudes -= altitudes.len() - 2;
            *altitudes = vec![first, last];
        }
    }

    /// Gives the notes and what was left out; of notes that say the same of many drives, the first
    /// ones.
    pub fn told(&self) -> Vec<String> {
        let left_out =
            self.left_out.iter().map(|(place, fault)| format!("{place} is left out: {fault}"));
        told_once(self.notes.iter().cloned().chain(left_out))
    }

    /// Adds the road of an operating cycle, of which everything is known.
    pub fn add_cycle(&mut self, cycle: GivenCycle) {
        self.roads.push(LoggedRoad { cycle, ..LoggedRoad::default() });
        self.has_objects = true;
        self.cover(Coverage::ALL);
    }

    fn cover(&mut self, more: Coverage) {
        self.coverage = Some(self.coverage.map_or(more, |coverage| coverage.with(more)));
    }

    /// Coverage of all roads. With a range, in m, the curves of operating cycles are those of a
    /// detector: others are there and were not seen.
    pub fn coverage(&self, radius_range_m: Option<[f64; 2]>) -> Coverage {
        let coverage = self.coverage.unwrap_or(Coverage::ALL);
        let coverage = Coverage { events: coverage.events && self.has_objects, ..coverage };
        match (coverage.curves, radius_range_m) {
            (CurveCoverage::All, Some(radius_m)) => {
                let window = CurveWindow { radius_m, shortest_m: 0.0, smallest_turn_rad: 0.0 };
                Coverage { curves: CurveCoverage::Within(window), ..coverage }
            }
            _ => coverage,
        }
    }

    /// The first drive that was left out, where nothing was found.
    pub fn failed(&self) -> Option<&(String, TripError)> {
        self.left_out.first().filter(|_| self.roads.is_empty())
    }
}

/// Gives notes; of those that say the same of many drives, the first ones.
pub fn told_once(notes: impl Iterator<Item = String>) -> Vec<String> {
    let mut kinds: BTreeMap<String, usize> = BTreeMap::new();
    let mut told = Vec::new();
    for note in notes {
        let count = kinds.entry(kind_of(&note)).or_insert(0);
        *count += 1;
        if *count <= MOST_ALIKE {
            told.push(note);
        }
    }
    let more: usize = kinds.values().map(|count| count.saturating_sub(MOST_ALIKE)).sum();
    if more > 0 {
        told.push(format!("{} as these, of other drives", count_of(more as u64, "note")));
    }
    told
}

/// Gives the text of a note without its names and numbers.
fn kind_of(note: &str) -> String {
    let said = note.split('`').step_by(2).collect::<String>();
    said.chars().filter(|letter| !letter.is_ascii_digit()).collect()
}

/// Note on a drive of which only the steering wheel tells how it turned.
pub(super) fn steering_note(place: &str) -> String {
    format!(
        "{place}: only the angle of the steering wheel tells how it turned: its curves are not \
         known (--steering-ratio and --wheelbase-m would tell them)"
    )
}

/// The roads of a drive; of which nothing is known about `turns` where these are not wanted.
pub(super) fn found(
    drive: &LoggedTrip,
    options: &RoadOptions,
    steering: Option<Steering>,
    turns: bool,
) -> Result<LoggedRoads, TripError> {
    // what a wheel without a ratio would tell is not used
    let any = Steering { ratio: 1.0, wheelbase_m: 1.0 };
    let steering = if turns { steering } else { steering.or(Some(any)) };
    let (mut log, corrections) = turning_log(drive, steering, &options.curves)?;
    if !turns {
        log.yaw_rate_radps.to_mut().fill(f64::NAN);
    }
    let mut log = road_log(drive, Some(log));
    if log.payload_kg.is_none() {
        let gross_kg = drive.column(Quantity::GrossWeight).zip(options.curb_mass_kg);
        log.payload_kg = gross_kg.map(|(gross_kg, curb_kg)| {
            gross_kg.iter().map(|gross_kg| (gross_kg - curb_kg).max(0.0)).collect()
        });
    }
    Ok(roads(&log, &RoadOptions { curves: corrections, ..options.clone() })?)
}

/// A drive as roads are found in it; `turning`: with what tells how its vehicle turns.
pub(super) fn road_log<'a>(drive: &'a LoggedTrip, turning: Option<TripLog<'a>>) -> RoadLog<'a> {
    let lent = |quantity| drive.column(quantity).map(Cow::Borrowed);
    let words = |word| drive.words(word).map(|words| words.rows().collect());
    let plain = || TripLog {
        time_s: lent(Quantity::Time).unwrap_or_default(),
        speed_mps: lent(Quantity::Speed).unwrap_or_default(),
        ..TripLog::default()
    };
    RoadLog {
        drive: turning.unwrap_or_else(plain),
        position_m: lent(Quantity::Position),
        altitude_m: lent(Quantity::Altitude),
        grade: lent(Quantity::Grade),
        roughness_m3: lent(Quantity::Roughness),
        payload_kg: lent(Quantity::Payload),
        time_of_day_s: lent(Quantity::TimeOfDay),
        day_of_year: lent(Quantity::DayOfYear),
        road_type: words(Quantity::RoadType),
        map_object: words(Quantity::MapObject),
    }
}

/// Notes on parts of a drive that were not used, or had to be supposed.
pub(super) fn notes(place: &str, counts: &RoadCounts) -> Vec<String> {
    let mut notes = row_notes(place, &counts.rows);
    let objects = KINDS.map(|kind| kind.map_object);
    notes.extend(counted(
        place,
        [
            (counts.cuts, "cut", "at more than 10 s without rows: the road is not known there"),
            (counts.too_short, "piece", "shorter than 200 m: not used"),
            (counts.untyped, "road", "with neither road type nor speed limit: left out"),
            (
                counts.typed_by_limit,
                "road",
                "without a word in road_type: urban up to a limit of 55 km/h, motorway from 82 \
             km/h, rural between (judgement)",
            ),
            (
                counts.without_limit,
                "row",
                "without a possible speed limit: the one before holds, and a road without any \
             tells no signs",
            ),
            (
                counts.without_slope,
                "row",
                "without slope or altitude: it goes on evenly over up to 200 m, and longer ways \
             tell no slopes",
            ),
            (
                counts.without_yaw_rate,
                "row",
                "without yaw rate: ways of more than 2 s of them tell no \
            curves",
            ),
            (counts.without_road_type, "row", "without road type: the one before holds"),
            (counts.curves_outside, "curve", "outside the range of radii: left out"),
            (counts.curves_dropped, "curve", "too short, too straight or too slow to be measured"),
            (
                counts.unknown_objects,
                "object",
                &format!("of the map, none of {}: left out", objects.join(", ")),
            ),
        ],
    ));
    if counts.altitude_jumps_m >= LEAST_JUMPS_M {
        notes.push(format!(
            "{place}: its altitudes jump by {:.0} m in all, more steeply than a road of 10 %: \
             taken out, and what follows is moved along",
            counts.altitude_jumps_m
        ));
    }
    if counts.cuts > 0 {
        let by_speed = match counts.cuts_by_speed {
            0 => String::new(),
            n => format!(" ({n} of them at the mean speed of the drive: no positions tell it)"),
        };
        notes.push(format!(
            "{place}: the way across what was not logged is {:.2} km{by_speed}: the drive is one \
             mission, with it",
            counts.cut_way_m / 1000.0
        ));
    }
    if counts.by_speed {
        notes.push(format!(
            "{place}: no positions that only grow: the way is the integral of the speed"
        ));
    }
    if counts.type_by_limit {
        notes.push(format!(
            "{place}: no column road_type: urban up to a limit of 55 km/h, motorway from 82 km/h, \
             rural between (judgement)"
        ));
    }
    notes
}

//! Checkpoints: a trip as it was at some places on its way. Where a rest is put into a trip that has
//! been driven, all before the place at which the truck could know of the stop is as it was: the
//! trip goes on from there, and not from its start.
//!
//! A checkpoint is taken at the end of a marked row, in an event outside of the hot loop. What is
//! driven from it is, bit by bit, what is driven from the start: a trace always drives from there
//! (`tests/it/charging.rs`).

use super::lane_task::{LaneTask, Progress};
use super::parts::{Laid, PartsProgress};
use super::rest_stops::{RestProgress, is_mission_stop};
use super::road_row::RoadRow;
use super::state::Lane;
use crate::energy_ledger::Ledger;
use crate::lanes::UNBOUNDED;
use crate::powertrain::Powertrain;
use crate::study::Scenario;
use crate::tactical::SpeedProfile;
use fearless_simd::Simd;
use std::ops::RangeInclusive;

/// A braking ramp is seldom longer, in m. If one is, the checkpoint before serves.
const RAMP_M: f64 = 1500.0;
/// Checkpoints from place to place where a rest may be taken on the spot, in m.
const SPACING_M: f64 = 20.0e3;
/// Places closer than this share a checkpoint, in m.
const CLOSE_M: f64 = 1000.0;

/// Places at which a temperature is looked at, from one to the next, in m.
const LOOK_M: f64 = 2000.0;

/// What a place is marked for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Purpose {
    Keep,
    Look,
    Decide,
}

/// A trip as it was at a place on its way.
#[derive(Clone, Debug)]
struct Checkpoint {
    row: usize,
    position_m: f64,
    /// What the lane remembered, column by column.
    memory: Vec<f64>,
    ledger: Ledger<f64>,
    progress: Progress,
    parts: PartsProgress,
    rests: Option<RestProgress>,
}

/// A marked row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark {
    row: usize,
    /// Where it ends, in m.
    pub end_m: f64,
    /// Whether a checkpoint is taken there.
    keeps: bool,
    /// Whether the powertrain's temperature is looked at there.
    pub looks: bool,
    /// Whether the driver decides there whether to charge.
    pub decides: bool,
    /// Whether the line of a stop that he has decided on is within reach.
    hidden: bool,
}

/// What rows are marked for.
#[derive(Clone, Debug)]
pub(super) struct Marking {
    /// Distance to the stop line in a marked row, in m.
    pub mark_m: f64,
    /// Whether rests may be put into the trip that was driven.
    pub takes_rests: bool,
    /// Where the driver decides whether to charge, in m.
    pub decides_m: Vec<f64>,
    /// How far ahead a truck may know of a stop, beside braking for it, in m.
    pub ahead_m: f64,
    /// Whether the powertrain's temperature is looked at.
    pub looks: bool,
}

/// The checkpoints of the trip in a lane.
#[derive(Clone, Debug, Default)]
pub(super) struct Checkpoints {
    /// Marked rows, in order.
    marks: Vec<Mark>,
    /// The next of them.
    next: usize,
    taken: Vec<Checkpoint>,
    /// How far ahead a truck may know of a stop, beside braking for it, in m.
    ahead_m: f64,
}

/// How a trip had been planned.
pub(super) struct Before {
    pub rows: Vec<RoadRow>,
    pub laid: Laid,
    pub air_temperature_k: f64,
}

impl Checkpoints {
    /// Marks rows of a planned trip.
    pub(super) fn mark(
        &mut self,
        marking: &Marking,
        scenario: &Scenario,
        profile: &SpeedProfile,
        rows: &mut [RoadRow],
    ) {
        self.marks.clear();
        self.ahead_m = marking.ahead_m;
        let road = &scenario.cycle.road;
        let each = |step_m: f64| {
            let count = (road.length_m / step_m) as u32;
            (1..=count).map(move |k| step_m * f64::from(k))
        };
        let mut keep_m: Vec<f64> = Vec::new();
        if marking.takes_rests {
            let stops = road.events.iter().filter(|event| is_mission_stop(event));
            let chargers = scenario.chargers.iter().map(|charger| charger.position_m);
            let ahead_m = marking.ahead_m + RAMP_M;
            let places = stops.map(|stop| stop.position_m).chain(chargers);
            keep_m.extend(places.map(|place_m| place_m - ahead_m));
            keep_m.extend(each(SPACING_M));
        }
        keep_m.sort_unstable_by(f64::total_cmp);
        keep_m.retain(|place_m| *place_m > 0.0);
        keep_m.dedup_by(|next, before| *next < *before + CLOSE_M);
        let looks_m = each(LOOK_M).filter(|_| marking.looks);
        let mut places: Vec<(f64, Purpose)> =
            keep_m.into_iter().map(|at_m| (at_m, Purpose::Keep)).collect();
        places.extend(looks_m.map(|at_m| (at_m, Purpose::Look)));
        let decides_m = marking.decides_m.iter().filter(|place_m| **place_m > 0.0);
        places.extend(decides_m.map(|at_m| (*at_m, Purpose::Decide)));
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (place_m, purpose) in places {
            let behind = profile.segments.partition_point(|segment| segment.start_m < place_m);
            let Some(segment) = profile.segments.get(behind) else { break };
            let (row, end_m) = (behind - 1, segment.start_m);
            let (keeps, decides) = (purpose == Purpose::Keep, purpose == Purpose::Decide);
            let looks = purpose == Purpose::Look || decides && marking.looks;
            if let Some(last) = self.marks.last_mut().filter(|mark| mark.row == row) {
                last.keeps |= keeps;
                last.looks |= looks;
                last.decides |= decides;
                continue;
            }
            let to_stop_m = &mut rows[row].0[RoadRow::TO_STOP];
            // within reach of a stop line there is none
            if *to_stop_m == UNBOUNDED || *to_stop_m == marking.mark_m {
                *to_stop_m = marking.mark_m;
                self.marks.push(Mark { row, end_m, keeps, looks, decides, hidden: false });
            }
        }
    }

    /// A trip begins at its start.
    pub(super) fn depart(&mut self) {
        self.begin();
        self.taken.clear();
    }

    /// A truck enters its road.
    pub(super) fn begin(&mut self) {
        self.next = 0;
        for mark in &mut self.marks {
            mark.hidden = false;
        }
    }

    /// The line of a stop is within reach on some rows.
    pub(super) fn hide(&mut self, rows: RangeInclusive<usize>) {
        let first = self.marks.partition_point(|mark| mark.row < *rows.start());
        for mark in self.marks[first..].iter_mut().take_while(|mark| rows.contains(&mark.row)) {
            mark.hidden = true;
        }
    }

    /// The mark of a row: the stop line that a truck seems to be at is none.
    pub(super) fn mark_at(&mut self, row: usize) -> Option<Mark> {
        while self.marks.get(self.next).is_some_and(|mark| mark.row < row) {
            self.next += 1;
        }
        self.marks.get(self.next).filter(|mark| mark.row == row && !mark.hidden).copied()
    }

    /// Forgets those that a stop at a place makes void; returns whether one is left.
    fn keep_before(
        &mut self,
        place_m: f64,
        before: &Before,
        rows: &[RoadRow],
        laid: &Laid,
    ) -> bool {
        self.taken.retain(|taken| taken.position_m + self.ahead_m < place_m);
        let Some(last) = self.taken.last() else { return false };
        // the row behind the checkpoint is the first one that has not been driven
        let pairs = before.rows.iter().zip(rows).take(last.row + 1);
        let same = pairs.take_while(|(old, new)| old.is_driven_as(new)).count();
        let same = same.min(before.laid.same_until(laid));
        self.taken.retain(|taken| taken.row < same);
        !self.taken.is_empty()
    }
}

impl LaneTask {
    /// Takes a checkpoint where the truck is at the end of a marked row.
    pub(super) fn take_checkpoint<S: Simd, P: Powertrain>(&mut self, lane: &mut Lane<S, P>) {
        let (row, number) = (lane.state.motion.at[lane.number], lane.number);
        let Some(mark) = self.checkpoints.mark_at(row).filter(|_| lane.is_at_end()) else { return };
        self.checkpoints.next += 1;
        if !mark.keeps {
            return;
        }
        // a row ahead that is not as it was planned would have to be kept, too
        if self.parts.is_stretched() || self.served.last().is_some_and(|served| served.0 > row) {
            return;
        }
        let memory = lane.state.memory().into_iter().map(|column| column[number]).collect();
        self.checkpoints.taken.push(Checkpoint {
            row,
            position_m: mark.end_m,
            memory,
            ledger: lane.state.ledger.lane(number),
            progress: self.progress,
            parts: self.parts.progress(),
            rests: self.rests.as_ref().map(|rests| rests.progress),
        });
    }

    /// Goes on from the last checkpoint before everything that a stop at a place changes, in a lane
    /// that the truck has just entered. Without one it is at its start.
    pub(super) fn go_on<S: Simd, P: Powertrain>(
        &mut self,
        lane: &mut Lane<S, P>,
        place_m: f64,
        before: &Before,
    ) {
        let number = lane.number;
        let rows = &lane.state.motion.roads[number];
        // heating and cooling are by the mean of the whole way, which stops may change in its last bit
        let same_air = self.road.air_temperature_k == before.air_temperature_k;
        let laid = self.parts.laid();
        if !(same_air && self.checkpoints.keep_before(place_m, before, rows, &laid)) {
            return self.checkpoints.depart();
        }
        let Some(last) = self.checkpoints.taken.last() else { return };
        self.progress = last.progress;
        self.parts.go_on(&last.parts);
        if let (Some(rests), Some(progress)) = (&mut self.rests, last.rests) {
            rests.progress = progress;
        }
        lane.state.set_gear(number, last.progress.gear, lane.parameters);
        lane.state.motion.at[number] = last.row;
        for (column, value) in lane.state.memory().into_iter().zip(&last.memory) {
            column[number] = *value;
        }
        lane.state.ledger.clear(number);
        lane.state.ledger.add_to_lane(number, &last.ledger);
        let row = last.row;
        self.checkpoints.next = self.checkpoints.marks.partition_point(|mark| mark.row <= row);
    }
}

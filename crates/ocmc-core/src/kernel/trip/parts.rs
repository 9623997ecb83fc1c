//! The parts of a cycle, road types and event kinds: where along the road they change, and what
//! each of them has taken so far.
//!
//! The step knows nothing of them. A row at whose end a part ends has, in the column of the next
//! stop line, a distance at which the step finds the line captured when the row is at its end: an
//! event outside of the hot loop, which books what the totals have gained. Within reach of a true
//! stop line no row is marked so: a part that ends there is booked at the next event.

use super::stop_ahead::Changed;
use crate::breakdown::{Axis, Breakdown, MOST_AMOUNTS};
use crate::energy::ledger::Term;
use crate::event_kind::{Kind, Point, kinds, regains};
use crate::kernel::step::road_row::RoadRow;
use crate::kernel::step::state::Lane;
use crate::lanes::UNBOUNDED;
use crate::operating_cycle::road::Road;
use crate::powertrain::Powertrain;
use crate::study::{SimulationModel, Study};
use crate::tactical::SpeedProfile;
use fearless_simd::Simd;
use std::sync::Arc;

/// The row at whose end a part ends.
#[derive(Clone, Copy, Debug)]
struct Change {
    row: usize,
    /// The part that ends, by road type and by kind.
    road_type: usize,
    kind: Kind,
    /// Whether the step makes an event of it.
    marked: bool,
}

/// The parts of the cycle in a lane.
#[derive(Clone, Debug, Default)]
pub(super) struct Parts {
    /// In order along the road; empty where nothing is broken down.
    changes: Vec<Change>,
    /// The next part that ends.
    next: usize,
    /// Totals that have been booked.
    booked: [f64; MOST_AMOUNTS],
    by_road_type: Vec<[f64; MOST_AMOUNTS]>,
    by_kind: [[f64; MOST_AMOUNTS]; Kind::ALL.len()],
    /// Distance in a marked row, in m.
    mark_m: f64,
    /// Whether they are event kinds, too.
    has_kinds: bool,
}

impl Parts {
    /// Lays the parts of a road. `road_types`: those that hold from a row on; `kinds`: of each row,
    /// or none.
    pub(super) fn lay(
        &mut self,
        simulation: &SimulationModel,
        road_types: &[(usize, usize)],
        kinds: &[Kind],
        rows: &mut [RoadRow],
    ) {
        self.changes.clear();
        self.mark_m = mark_m(simulation);
        self.has_kinds = !kinds.is_empty();
        let last = rows.len() - 1;
        let mut ends = road_types.iter().skip(1).map(|(from, _)| from - 1).chain([last]);
        for (k, (from, road_type)) in road_types.iter().enumerate() {
            let to = ends.next().unwrap_or(last);
            let change = |row, kind| Change { row, road_type: *road_type, kind, marked: false };
            let within = kinds.get(*from..=to).unwrap_or_default();
            for (j, pair) in within.windows(2).enumerate() {
                if pair[0] != pair[1] {
                    self.changes.push(change(from + j, pair[0]));
                }
            }
            let kind = within.last().copied().unwrap_or(Kind::Cruise);
            // two sections of one road type are one part
            let goes_on = road_types
                .get(k + 1)
                .is_some_and(|next| next.1 == *road_type && kinds.get(to) == kinds.get(to + 1));
            if !goes_on {
                self.changes.push(change(to, kind));
            }
        }
        for change in &mut self.changes {
            mark(change, &mut rows[change.row], self.mark_m);
        }
    }

    /// Nothing is broken down.
    pub(super) fn clear(&mut self) {
        self.changes.clear();
    }

    /// Begins at the start of the road.
    pub(super) fn depart(&mut self, road_types: usize) {
        self.next = 0;
        self.booked = [0.0; MOST_AMOUNTS];
        self.by_road_type.clear();
        self.by_road_type.resize(road_types, [0.0; MOST_AMOUNTS]);
        self.by_kind = [[0.0; MOST_AMOUNTS]; Kind::ALL.len()];
    }

    /// Books the parts that have ended where the truck is. Returns whether its row is marked: the
    /// stop line that it seems to be at is none.
    pub(super) fn pass<S: Simd, P: Powertrain>(
        &mut self,
        lane: &mut Lane<S, P>,
        standstill_s: f64,
    ) -> bool {
        let (at, left_m) = (lane.state.motion.at[lane.number], lane.state.motion.left[lane.number]);
        while self.changes.get(self.next).is_some_and(|change| change.row < at) {
            self.book(lane, standstill_s);
        }
        let Some(change) = self.changes.get(self.next).filter(|change| change.row == at) else {
            return false;
        };
        let marked = change.marked;
        // where a stop line is, the truck stands first
        if marked && left_m <= 0.0 && !self.goes_on(lane) {
            self.book(lane, standstill_s);
        }
        marked
    }

    /// Whether a truck that is slower than the plan still regains its speed: then the part goes on
    /// for one row more.
    fn goes_on<S: Simd, P: Powertrain>(&mut self, lane: &mut Lane<S, P>) -> bool {
        let [change, next, ..] = &mut self.changes[self.next..] else { return false };
        let regained = matches!(change.kind, Kind::Hill | Kind::Cruise);
        let follows = matches!(next.kind, Kind::Hill | Kind::Cruise);
        if regained || !follows || change.road_type != next.road_type || next.row <= change.row + 1
        {
            return false;
        }
        let speed = lane.state.motion.speed[lane.number];
        let row = &mut lane.state.motion.roads[lane.number][change.row + 1];
        if !regains(speed * speed, row.0[RoadRow::LIMIT]) {
            return false;
        }
        change.row += 1;
        mark(change, row, self.mark_m);
        true
    }

    /// The driver decides to stop at the end of a row: from where he brakes it is the part of a
    /// stop, and behind it until the speed is regained. What ends within reach of the line is
    /// booked at the next event.
    pub(super) fn stop_within(&mut self, changed: &Changed, line: usize, rows: &mut [RoadRow]) {
        let mut parts = self.changes.split_off(self.next);
        if self.has_kinds {
            let mut from = 0;
            let mut split: Vec<Change> = Vec::with_capacity(parts.len() + 4);
            for change in parts {
                // as it is, up to braking; a stop, up to the line, and for one row more
                let cuts = [changed.braked_from.checked_sub(1), Some(line), Some(line + 1)];
                for (k, end) in cuts.into_iter().enumerate() {
                    let Some(end) = end.filter(|end| *end >= from && *end < change.row) else {
                        continue;
                    };
                    let kind = if k == 0 { change.kind } else { Kind::Stop };
                    split.push(Change { row: end, kind, marked: false, ..change });
                    from = end + 1;
                }
                let is_stop = from >= changed.braked_from && change.row <= line + 1;
                let kind = if is_stop { Kind::Stop } else { change.kind };
                split.push(Change { kind, ..change });
                from = change.row + 1;
            }
            parts = split;
        }
        for change in &mut parts {
            let is_hidden = change.row >= changed.reach_from && change.row <= line;
            if is_hidden {
                change.marked = false;
            } else if !change.marked {
                mark(change, &mut rows[change.row], self.mark_m);
            }
        }
        self.changes.append(&mut parts);
    }

    /// Marks what was within reach of a stop line that has been served.
    pub(super) fn unhide(&mut self, line: usize, rows: &mut [RoadRow]) {
        for change in self.changes[self.next..].iter_mut().take_while(|change| change.row <= line) {
            mark(change, &mut rows[change.row], self.mark_m);
        }
    }

    /// The part that ends next, and what the totals have gained since it began.
    fn gained<S: Simd, P: Powertrain>(
        &self,
        lane: &Lane<S, P>,
        standstill_s: f64,
    ) -> Option<(Change, [f64; MOST_AMOUNTS])> {
        let change = self.changes.get(self.next)?;
        let ledger = &lane.state.ledger;
        let mut gained = [0.0; MOST_AMOUNTS];
        let terms = [Term::Distance, Term::Time, Term::Wheel].iter().chain(P::STORES);
        for (gained, term) in gained.iter_mut().zip(terms) {
            *gained = ledger[*term][lane.number];
        }
        gained[1] += standstill_s;
        for (total, before) in gained.iter_mut().zip(self.booked) {
            *total -= before;
        }
        Some((*change, gained))
    }

    /// Books it.
    fn book<S: Simd, P: Powertrain>(&mut self, lane: &Lane<S, P>, standstill_s: f64) {
        let Some((change, gained)) = self.gained(lane, standstill_s) else { return };
        add(&mut self.by_road_type[change.road_type], gained);
        add(&mut self.by_kind[change.kind as usize], gained);
        add(&mut self.booked, gained);
        self.next += 1;
    }

    /// The breakdown of the cycle as it stands.
    pub(super) fn breakdown<S: Simd, P: Powertrain>(
        &self,
        study: &Study,
        lane: &Lane<S, P>,
        standstill_s: f64,
    ) -> Breakdown {
        let Some(columns) = study.breakdown() else { return Breakdown::default() };
        let (mut by_road_type, mut by_kind) = (self.by_road_type.clone(), self.by_kind);
        if let Some((change, gained)) = self.gained(lane, standstill_s) {
            add(&mut by_road_type[change.road_type], gained);
            add(&mut by_kind[change.kind as usize], gained);
        }
        let (by, amounts) = (&study.model().simulation.columns_by, columns.amounts().len());
        let mut values = Vec::with_capacity(columns.names().len());
        for axis in Axis::ALL.into_iter().filter(|axis| by.contains(axis)) {
            let sums = match axis {
                Axis::RoadType => &by_road_type[..],
                Axis::EventKind => &by_kind[..],
            };
            values.extend(sums.iter().flat_map(|sums| &sums[..amounts]));
        }
        Breakdown::new(Arc::clone(columns), Some(values))
    }
}

fn add(sums: &mut [f64; MOST_AMOUNTS], gained: [f64; MOST_AMOUNTS]) {
    for (sum, gained) in sums.iter_mut().zip(gained) {
        *sum += gained;
    }
}

/// Distance to the stop line in a marked row, in m.
pub(super) fn mark_m(simulation: &SimulationModel) -> f64 {
    simulation.capture_distance_m.min(simulation.creep_distance_m)
}

/// Marks a row at whose end a part ends, but within reach of a stop line.
fn mark(change: &mut Change, row: &mut RoadRow, mark_m: f64) {
    if row.0[RoadRow::TO_STOP] == UNBOUNDED {
        row.0[RoadRow::TO_STOP] = mark_m;
        change.marked = true;
    }
}

/// The kinds of the segments of a plan, as if it were driven exactly. `stops`: the segments that
/// end at a stop line, in order, the last one among them.
pub(super) fn kinds_of_plan(profile: &SpeedProfile, road: &Road, stops: &[usize]) -> Vec<Kind> {
    let mut height_m = 0.0;
    let mut stops = stops.iter().peekable();
    let mut is_start = true;
    let mut points = Vec::with_capacity(profile.segments.len() + 1);
    for (i, (segment, branch)) in profile.segments.iter().zip(&profile.branches).enumerate() {
        let planned_mps = if is_start { 0.0 } else { profile.speed_mps(i, 0.0) };
        let in_curve = segment.curve().is_some() && !branch.by_sign;
        let limit_mps = branch.limit.sqrt();
        points.push(Point {
            way_m: segment.start_m,
            height_m,
            planned_mps,
            driven_mps: planned_mps,
            limit_mps,
            in_curve,
            is_start,
            is_stop: is_start && i > 0,
        });
        height_m += road.slopes[segment.slope as usize] * segment.length_m;
        is_start = stops.next_if(|stop| **stop == i).is_some();
    }
    if let Some(last) = points.last().copied() {
        let end =
            Point { way_m: road.length_m, height_m, planned_mps: 0.0, driven_mps: 0.0, ..last };
        points.push(Point { is_start: false, is_stop: true, in_curve: false, ..end });
    }
    kinds(&points)
}

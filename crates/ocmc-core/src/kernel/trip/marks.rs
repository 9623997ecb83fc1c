//! Marks of a road: rows at whose end the driver decides on a charger, or the temperature of the
//! powertrain is looked at. They are events outside of the hot loop, as the ends of parts are
//! ([`super::parts`]).

use crate::kernel::step::road_row::RoadRow;
use crate::lanes::UNBOUNDED;
use crate::tactical::SpeedProfile;
use std::ops::RangeInclusive;

/// Places at which a temperature is looked at, from one to the next, in m.
const LOOK_M: f64 = 2000.0;

/// A marked row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark {
    row: usize,
    /// Where it ends, in m.
    pub end_m: f64,
    /// Whether the powertrain's temperature is looked at there.
    pub looks: bool,
    /// Whether the driver decides there whether to charge.
    pub decides: bool,
    /// Whether the line of a stop that he has decided on is within reach.
    hidden: bool,
}

/// Reasons for which rows are marked.
#[derive(Clone, Debug)]
pub(super) struct Marking {
    /// Distance to the stop line in a marked row, in m.
    pub mark_m: f64,
    /// Where the driver decides whether to charge, in m.
    pub decides_m: Vec<f64>,
    /// Whether the powertrain's temperature is looked at.
    pub looks: bool,
}

/// The marks of the road in a lane.
#[derive(Clone, Debug, Default)]
pub(super) struct Marks {
    /// In order along the road.
    marks: Vec<Mark>,
    /// The next of them.
    next: usize,
}

impl Marks {
    /// Marks rows of a planned road.
    pub(super) fn lay(
        &mut self,
        marking: &Marking,
        length_m: f64,
        profile: &SpeedProfile,
        rows: &mut [RoadRow],
    ) {
        self.marks.clear();
        let count = if marking.looks { (length_m / LOOK_M) as u32 } else { 0 };
        let looks_m = (1..=count).map(|k| (LOOK_M * f64::from(k), false));
        let decides_m = marking.decides_m.iter().filter(|place_m| **place_m > 0.0);
        let mut places: Vec<(f64, bool)> =
            looks_m.chain(decides_m.map(|at_m| (*at_m, true))).collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (place_m, decides) in places {
            let behind = profile.segments.partition_point(|segment| segment.start_m < place_m);
            let Some(segment) = profile.segments.get(behind) else { break };
            let (row, end_m, looks) = (behind - 1, segment.start_m, marking.looks);
            if let Some(last) = self.marks.last_mut().filter(|mark| mark.row == row) {
                last.decides |= decides;
                continue;
            }
            let to_stop_m = &mut rows[row].0[RoadRow::TO_STOP];
            // within reach of a stop line there is none
            if *to_stop_m == UNBOUNDED || *to_stop_m == marking.mark_m {
                *to_stop_m = marking.mark_m;
                self.marks.push(Mark { row, end_m, looks, decides, hidden: false });
            }
        }
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
    pub(super) fn at(&mut self, row: usize) -> Option<Mark> {
        while self.marks.get(self.next).is_some_and(|mark| mark.row < row) {
            self.next += 1;
        }
        self.marks.get(self.next).filter(|mark| mark.row == row && !mark.hidden).copied()
    }

    /// The next one is behind the truck.
    pub(super) fn pass(&mut self) {
        self.next += 1;
    }
}

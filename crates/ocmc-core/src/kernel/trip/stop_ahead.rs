//! A stop that a driver decides on while he drives: it changes the road ahead of the truck, and
//! only what a stop changes. The rows of the way to it get its braking ramp, as far back as nothing
//! else is braked for there; the last of them ends at its line.
//!
//! It is what planning the whole road with that stop would give (`tests/it/charging_decision.rs`).

use crate::kernel::step::road_row::RoadRow;
use crate::lanes::UNBOUNDED;

/// A stop that the driver has decided on.
#[derive(Clone, Copy, Debug)]
pub(super) struct StopAhead {
    /// The row that ends at its line.
    pub row: usize,
    /// Where it is, in m.
    pub position_m: f64,
    /// Whether the law on rests is what he stops for.
    pub rests: bool,
}

/// Where a truck stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Standing {
    /// Where it is, in m.
    pub position_m: f64,
    /// Whether it is a stop of the mission.
    pub of_mission: bool,
    /// Whether its time is a rest: any other stop is a part of the driving.
    pub is_rest: bool,
    /// Whether the driver has stopped for the law on rests.
    pub rests: bool,
}

/// Rows that a stop ahead has changed.
pub(super) struct Changed {
    /// The first row that is braked for it.
    pub braked_from: usize,
    /// The first row within reach of its line.
    pub reach_from: usize,
}

/// Puts a stop at the end of a row, of which none before `from` may change. `before` gets the rows
/// that change, as they were: who puts them back begins with the last one.
pub(super) fn put_in(
    rows: &mut [RoadRow],
    [from, line]: [usize; 2],
    twice_deceleration: f64,
    coasts: bool,
    near_m: f64,
    before: &mut Vec<(usize, RoadRow)>,
) -> Changed {
    let (mut node, mut braked_from) = (0.0, line);
    for (k, row) in rows[..=line].iter_mut().enumerate().skip(from).rev() {
        if row.0[RoadRow::BACKWARD] <= node {
            break;
        }
        before.push((k, *row));
        row.0[RoadRow::BACKWARD] = node;
        row.set_coasting(if coasts { 0.0 } else { UNBOUNDED });
        if node < row.0[RoadRow::LIMIT] {
            braked_from = k;
        }
        node += twice_deceleration * row.0[RoadRow::LENGTH];
    }
    rows[line].set_stop(0.0);
    let (mut beyond_m, mut reach_from) = (0.0, line);
    for (k, row) in rows[..=line].iter_mut().enumerate().skip(from).rev() {
        let is_another = beyond_m > 0.0 && row.dwell_s().is_some();
        if beyond_m > near_m || is_another {
            break;
        }
        before.push((k, *row));
        row.0[RoadRow::TO_STOP] = beyond_m;
        reach_from = k;
        beyond_m += row.0[RoadRow::LENGTH];
    }
    Changed { braked_from, reach_from }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of 100 m at 20 m/s; behind the fourth one 5 m/s is allowed.
    fn rows(twice_deceleration: f64) -> Vec<RoadRow> {
        let row = |k: usize| {
            let mut row = RoadRow::PARKED;
            let to_slow = |m: f64| 25.0 + twice_deceleration * m;
            row.0[RoadRow::LENGTH] = 100.0;
            row.0[RoadRow::LIMIT] = if k < 4 { 400.0 } else { 25.0 };
            row.0[RoadRow::BACKWARD] = if k < 4 { to_slow(100.0 * (3 - k) as f64) } else { 1e4 };
            row
        };
        (0..12).map(row).collect()
    }

    #[test]
    fn a_stop_changes_the_ramp_before_it_and_nothing_else() {
        for (line, from) in [(10, 0), (3, 0), (10, 6), (2, 1)] {
            let (planned, mut served) = (rows(1.0), Vec::new());
            let mut rows = planned.clone();
            let changed = put_in(&mut rows, [from, line], 1.0, true, 150.0, &mut served);
            for (k, (row, planned)) in rows.iter().zip(&planned).enumerate() {
                let ramp = 100.0 * line.saturating_sub(k) as f64;
                let before = planned.0[RoadRow::BACKWARD];
                let is_changed = k >= from && k <= line && ramp < before;
                let said = if is_changed { ramp } else { before };
                assert_eq!(row.0[RoadRow::BACKWARD], said, "{line} {k}");
                let near_m = if k == line { 0.0 } else { 100.0 * (line.max(k) - k) as f64 };
                let is_near = k >= from && k <= line && near_m <= 100.0;
                assert_eq!(row.0[RoadRow::TO_STOP] < UNBOUNDED, is_near, "{line} {k}");
                assert_eq!(row.dwell_s().is_some(), k == line, "{line} {k}");
            }
            let is_braked = |k: &usize| {
                let [now, limit] =
                    [RoadRow::BACKWARD, RoadRow::LIMIT].map(|column| rows[*k].0[column]);
                now < limit && now < planned[*k].0[RoadRow::BACKWARD]
            };
            assert_eq!(Some(changed.braked_from), (from..=line).find(is_braked));
            // what is put back is the plan
            for (k, row) in served.drain(..).rev() {
                rows[k] = row;
            }
            for (row, planned) in rows.iter().zip(&planned) {
                let kept = [RoadRow::BACKWARD, RoadRow::TO_STOP];
                assert_eq!(kept.map(|column| row.0[column]), kept.map(|column| planned.0[column]));
            }
        }
    }
}

//! A stop that a driver decides on while he drives: it changes the road ahead of the truck, and only
//! what a stop changes. The rows of the way to it get its braking ramp, as far back as nothing else
//! is braked for there; the last of them ends at its line.
//!
//! It is what planning the whole road with that stop would give (`tests/it/charging_decision.rs`).

use super::lane_task::LaneTask;
use super::rest_stops::is_mission_stop;
use super::road_row::RoadRow;
use super::state::Lane;
use crate::energy_ledger::Term;
use crate::lanes::UNBOUNDED;
use crate::powertrain::Powertrain;
use fearless_simd::Simd;

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
    for (row, RoadRow(columns)) in rows[..=line].iter_mut().enumerate().skip(from).rev() {
        if columns[RoadRow::BACKWARD] <= node {
            break;
        }
        before.push((row, RoadRow(*columns)));
        columns[RoadRow::BACKWARD] = node;
        columns[RoadRow::DWELL] = -1.0 - if coasts { 0.0 } else { UNBOUNDED };
        if node < columns[RoadRow::LIMIT] {
            braked_from = row;
        }
        node += twice_deceleration * columns[RoadRow::LENGTH];
    }
    rows[line].0[RoadRow::DWELL] = 0.0;
    let (mut beyond_m, mut reach_from) = (0.0, line);
    for (row, RoadRow(columns)) in rows[..=line].iter_mut().enumerate().skip(from).rev() {
        let is_another = beyond_m > 0.0 && columns[RoadRow::DWELL] >= 0.0;
        if beyond_m > near_m || is_another {
            break;
        }
        before.push((row, RoadRow(*columns)));
        columns[RoadRow::TO_STOP] = beyond_m;
        reach_from = row;
        beyond_m += columns[RoadRow::LENGTH];
    }
    Changed { braked_from, reach_from }
}

impl LaneTask {
    /// The driver decides to stop at the end of a row. He is where the row `from` begins.
    pub(super) fn stop_ahead<S: Simd, P: Powertrain>(
        &mut self,
        lane: &mut Lane<S, P>,
        from: usize,
        stop: StopAhead,
    ) {
        let number = lane.number;
        let near_m = lane.parameters.simulation.creep_distance_m;
        let coasts = lane.parameters.look_ahead.coasting;
        let twice_deceleration = lane.state.constants.twice_deceleration[number];
        let rows = &mut lane.state.motion.roads[number];
        let span = [from, stop.row];
        let changed = put_in(rows, span, twice_deceleration, coasts, near_m, &mut self.served);
        self.marks.hide(changed.reach_from..=stop.row);
        self.parts.stop_within(&changed, stop.row, rows);
        self.stops_ahead.push(stop);
    }

    /// Whether the truck is on its way to a stop that its driver has decided on.
    pub(super) fn has_stop_ahead(&self, here_m: f64) -> bool {
        self.stops_ahead.iter().any(|stop| stop.position_m > here_m)
    }

    /// Where a truck stands that stands at the line at the end of a row; none at the road's end.
    pub(super) fn standing(&self, row: usize) -> Option<Standing> {
        if let Some(stop) = self.stops_ahead.iter().find(|stop| stop.row == row) {
            let StopAhead { position_m, rests, .. } = *stop;
            return Some(Standing { position_m, of_mission: false, is_rest: true, rests });
        }
        let event = self.road.event_after(row)?;
        let of = &self.scenario.cycle.road.events[event];
        let (position_m, of_mission) = (of.position_m, is_mission_stop(of));
        Some(Standing { position_m, of_mission, is_rest: of_mission, rests: false })
    }

    /// The truck stands at a line for a time that was planned: charges there and rests, and returns for
    /// how long it does then, in s, and whether the law on rests asked for it.
    pub(super) fn stand<S: Simd, P: Powertrain>(
        &mut self,
        lane: &mut Lane<S, P>,
        at: &Standing,
        planned_s: f64,
    ) -> (f64, bool) {
        let mut dwell_s = planned_s;
        let mut added_s = 0.0;
        let stays = self.charges_at(at.position_m);
        if !stays {
            let asked_s = self.rest_asked_s(lane, at, planned_s);
            (dwell_s, added_s) = (planned_s.max(asked_s), asked_s - planned_s);
        }
        dwell_s = self.charge(lane, at, dwell_s);
        if stays {
            // it stands as long as charging takes
            let asked_s = self.rest_asked_s(lane, at, dwell_s);
            (dwell_s, added_s) = (dwell_s.max(asked_s), asked_s - dwell_s);
        }
        let driven_s = lane.state.ledger[Term::Time][lane.number];
        let Some(rests) = &mut self.rests else { return (dwell_s, false) };
        rests.drive_to(driven_s);
        rests.stand(at, dwell_s, added_s);
        (dwell_s, added_s > 0.0)
    }

    /// Whether the driver has decided to charge at a place.
    fn charges_at(&self, position_m: f64) -> bool {
        self.charging.as_ref().is_some_and(|charging| charging.planned.contains(&position_m))
    }
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
                assert_eq!(row.0[RoadRow::DWELL] >= 0.0, k == line, "{line} {k}");
            }
            let is_braked = |k: &usize| {
                let [now, limit] = [RoadRow::BACKWARD, RoadRow::LIMIT].map(|of| rows[*k].0[of]);
                now < limit && now < planned[*k].0[RoadRow::BACKWARD]
            };
            assert_eq!(Some(changed.braked_from), (from..=line).find(is_braked));
            // what is put back is the plan
            for (k, row) in served.drain(..).rev() {
                rows[k] = row;
            }
            for (row, planned) in rows.iter().zip(&planned) {
                let kept = [RoadRow::BACKWARD, RoadRow::TO_STOP];
                assert_eq!(kept.map(|of| row.0[of]), kept.map(|of| planned.0[of]));
            }
        }
    }
}

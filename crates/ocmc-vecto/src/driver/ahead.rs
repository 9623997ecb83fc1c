//! VECTO 3's driver: what he wants of a second follows from where he is and how fast, not from a
//! plan of seconds.
//!
//! Source: VECTO 3, user manual (look-ahead coasting, overspeed) and its driver strategy,
//! `DefaultDriverStrategy` in the copy of tanawadeatharva/BharatVECTO. Overspeed downhill alone is
//! the rule of 2016, which VECTO 3's time series of its class 5 tractor show.

use super::mission::{Mission, MissionRow};
use super::truck::Truck;
use super::{Overspeed, VectoDriver};

/// Preview in s: 10 m for each km/h.
const PREVIEW_S: f64 = 36.0;
/// Pieces of a way over which braking is summed.
const BRAKING_PIECES: u32 = 64;
/// A truck at rest this near to a stop has reached it, in m.
const AT_STOP_M: f64 = 1.0;
/// Nobody coasts to less, in m/s: 5 km/h.
const COASTS_TO_MPS: f64 = 5.0 / 3.6;
/// Speed on a way that has no target, between two stops, in m/s.
const CREEPING_MPS: f64 = 1.0;
/// No speed rises by more in a second, in m/s.
const MOST_RISE_MPS: f64 = 5.0;
/// Steps of a bisection.
const BISECTIONS: u32 = 40;

/// Wish of a driver for a second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wish {
    /// Speed at its end, in m/s.
    pub(super) end_mps: f64,
    /// Speed at its end above which the brakes act whatever the truck does, in m/s.
    pub(super) most_mps: f64,
    /// Whether the truck may roll instead where the clutch is open.
    pub(super) rolls: bool,
    /// Mean target speed, in m/s.
    pub(super) target_mps: f64,
    /// Power of auxiliaries that the mission adds, in W.
    pub(super) auxiliary_w: f64,
}

/// Where a truck is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Situation {
    /// Way since the start, in m.
    pub(super) way_m: f64,
    /// Its speed, in m/s.
    pub(super) speed_mps: f64,
    /// Its gear; none with an open clutch.
    pub(super) gear: Option<usize>,
    /// Climb per metre of road.
    pub(super) slope: f64,
    /// Power of the auxiliaries that always run, in W.
    pub(super) auxiliary_w: f64,
}

/// A lower speed that the truck slows for.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Action {
    /// Row of the mission from which it holds.
    row: usize,
    /// It, in m/s.
    end_mps: f64,
    /// Where the accelerator is left for it, in m.
    from_m: f64,
}

/// The driver.
#[derive(Clone, Debug)]
pub(super) struct Ahead<'a> {
    rows: &'a [MissionRow],
    truck: &'a Truck<'a>,
    driver: &'a VectoDriver,
    minimum_speed_mps: f64,
    /// Target speeds, in m/s: 0 at stops alone.
    target_mps: Vec<f64>,
    /// Speeds that a truck may have at a row, in m/s: the target, or more downhill.
    allowed_mps: Vec<f64>,
    /// Squares of the speeds from which the table's braking meets all that is allowed, in m²/s².
    braking_m2ps2: Vec<f64>,
    altitude_m: Vec<f64>,
    /// Rows at which the target falls.
    falls: Vec<usize>,
    /// The next stop, a row, and the way of the last one in m.
    stop: Option<usize>,
    left_m: f64,
    /// Seconds that are still waited at the stop; none before it is reached.
    waits_s: Option<f64>,
    action: Option<Action>,
}

impl<'a> Ahead<'a> {
    pub(super) fn new(
        mission: &'a Mission,
        truck: &'a Truck<'a>,
        driver: &'a VectoDriver,
        minimum_speed_mps: f64,
    ) -> Self {
        let rows = mission.rows();
        let last = rows.len() - 1;
        let stops = |k: usize| k == 0 || k == last || rows[k].stop_s > 0.0;
        let target = |(k, row): (usize, &MissionRow)| {
            if row.target_mps > 0.0 || stops(k) { row.target_mps } else { CREEPING_MPS }
        };
        let target_mps: Vec<f64> = rows.iter().enumerate().map(target).collect();
        let overspeed = driver.overspeed.as_ref();
        let falls: Vec<usize> =
            (1..rows.len()).filter(|k| target_mps[*k] < target_mps[*k - 1]).collect();
        // where a target holds the slope of the moment decides, where a lower one begins its own
        let mut allowed_mps: Vec<f64> =
            target_mps.iter().map(|mps| allowed_mps(overspeed, *mps, -1.0)).collect();
        for k in &falls {
            allowed_mps[*k] = self::allowed_mps(overspeed, target_mps[*k], rows[*k].gradient);
        }
        let mut altitude_m = vec![0.0; rows.len()];
        for k in 1..rows.len() {
            let piece_m = rows[k].distance_m - rows[k - 1].distance_m;
            let gradient = 0.5 * (rows[k].gradient + rows[k - 1].gradient);
            altitude_m[k] = altitude_m[k - 1] + gradient * piece_m;
        }
        let mut ahead = Self {
            rows,
            truck,
            driver,
            minimum_speed_mps,
            braking_m2ps2: allowed_mps.iter().map(|v| v * v).collect(),
            target_mps,
            allowed_mps,
            altitude_m,
            falls,
            stop: None,
            left_m: 0.0,
            waits_s: None,
            action: None,
        };
        ahead.brake_ramps();
        ahead.stop = ahead.stop_from(0);
        ahead
    }

    /// From the end to the start: no row is faster than the table's braking allows.
    fn brake_ramps(&mut self) {
        for k in (1..self.rows.len()).rev() {
            let piece_m = self.rows[k].distance_m - self.rows[k - 1].distance_m;
            let end_m2ps2 = self.braking_m2ps2[k];
            let mut start_m2ps2 = end_m2ps2;
            for _ in 0..3 {
                let mean_mps = 0.5 * (start_m2ps2.sqrt() + end_m2ps2.sqrt());
                let most_mps2 = self.driver.acceleration.deceleration_mps2(mean_mps);
                start_m2ps2 = end_m2ps2 - 2.0 * most_mps2 * piece_m;
            }
            self.braking_m2ps2[k - 1] = self.braking_m2ps2[k - 1].min(start_m2ps2);
        }
    }

    /// The speed at the start, in m/s.
    pub(super) fn start_mps(&self) -> f64 {
        self.braking_m2ps2[0].sqrt().min(self.target_mps[0])
    }

    /// Whether the mission is over: at its last stop, or where its last row is.
    pub(super) fn ends(&self, way_m: f64) -> bool {
        self.stop.is_none() && way_m.max(self.left_m) >= self.way_m(self.rows.len() - 1)
    }

    fn way_m(&self, row: usize) -> f64 {
        self.rows[row].distance_m - self.rows[0].distance_m
    }

    fn stop_from(&self, row: usize) -> Option<usize> {
        (row..self.rows.len()).find(|k| self.target_mps[*k] == 0.0)
    }

    /// The row that holds at a way.
    fn row(&self, way_m: f64) -> usize {
        let place_m = self.rows[0].distance_m + way_m;
        self.rows.partition_point(|row| row.distance_m <= place_m).max(1) - 1
    }

    /// Altitude at a way, in m.
    fn altitude_m(&self, way_m: f64) -> f64 {
        let row = self.row(way_m);
        let Some(next) = self.rows.get(row + 1) else {
            return self.altitude_m[row];
        };
        let piece_m = next.distance_m - self.rows[row].distance_m;
        let share = ((way_m - self.way_m(row)) / piece_m).clamp(0.0, 1.0);
        self.altitude_m[row] + share * (self.altitude_m[row + 1] - self.altitude_m[row])
    }

    /// The target behind a way, in m/s: at a stop that of the row after it.
    fn target_mps(&self, way_m: f64) -> f64 {
        let row = self.row(way_m.max(self.left_m));
        let here_mps = self.target_mps[row];
        if here_mps > 0.0 {
            return here_mps;
        }
        self.target_mps.get(row + 1).copied().unwrap_or(0.0)
    }

    /// Whether the truck stands at a stop.
    pub(super) fn stands(&self) -> bool {
        self.waits_s.is_some()
    }

    /// Square of the speed from which braking by the table still meets all lower speeds, in m²/s².
    fn braking_m2ps2(&self, way_m: f64) -> f64 {
        let way_m = way_m.max(self.left_m);
        if self.stop.is_some_and(|row| way_m >= self.way_m(row)) {
            return 0.0;
        }
        let row = self.row(way_m);
        let Some(next) = self.rows.get(row + 1) else {
            return self.braking_m2ps2[row];
        };
        let share = (way_m - self.way_m(row)) / (next.distance_m - self.rows[row].distance_m);
        let end_m2ps2 = self.braking_m2ps2[row + 1];
        self.braking_m2ps2[row] + share * (end_m2ps2 - self.braking_m2ps2[row])
    }

    /// The highest speed at the end of a second that begins at a speed from which braking by the
    /// table still meets all lower speeds, both in m/s.
    fn most_mps(&self, way_m: f64, start_mps: f64) -> f64 {
        let meets = |end_mps: f64| {
            end_mps * end_mps <= self.braking_m2ps2(way_m + 0.5 * (start_mps + end_mps))
        };
        let (mut low, mut high) = (0.0, start_mps + MOST_RISE_MPS);
        if meets(high) {
            return high;
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if meets(middle) { low = middle } else { high = middle }
        }
        low
    }

    /// Wish for the next second.
    pub(super) fn wish(&mut self, situation: &Situation) -> Wish {
        let Situation { way_m, speed_mps, .. } = *situation;
        let target_mps = self.target_mps(way_m + 0.5 * speed_mps);
        let auxiliary_w = self.rows[self.row(way_m)].auxiliary_w;
        let rest = Wish { end_mps: 0.0, most_mps: 0.0, rolls: false, target_mps, auxiliary_w };
        if self.waits(way_m, speed_mps) {
            return rest;
        }
        self.act(situation);
        let most_mps = self.most_mps(way_m, speed_mps);
        let coasting_mps = speed_mps + self.coasting_mps2(situation);
        let (end_mps, rolls) = match self.action {
            Some(action) if speed_mps > action.end_mps => {
                let least_mps = COASTS_TO_MPS.min(target_mps);
                (coasting_mps.min(target_mps.max(speed_mps)).max(least_mps), true)
            }
            // it has been reached before its place
            Some(action) => (action.end_mps.max(COASTS_TO_MPS).min(target_mps), false),
            None => {
                let overspeed = self.driver.overspeed.as_ref();
                let allowed_mps = allowed_mps(overspeed, target_mps, situation.slope);
                let wanted_mps = coasting_mps.clamp(target_mps, allowed_mps);
                (wanted_mps, wanted_mps == coasting_mps)
            }
        };
        Wish { end_mps: end_mps.min(most_mps), most_mps, rolls, ..rest }
    }

    /// Whether the truck stands at its stop for another second.
    fn waits(&mut self, way_m: f64, speed_mps: f64) -> bool {
        let Some(row) = self.stop else {
            return false;
        };
        if speed_mps > 0.0 || self.way_m(row) - way_m > AT_STOP_M {
            return false;
        }
        let left_s = self.waits_s.unwrap_or(self.rows[row].stop_s);
        if left_s >= 0.5 {
            self.waits_s = Some(left_s - 1.0);
            return true;
        }
        self.left_m = self.way_m(row);
        self.stop = self.stop_from(row + 1);
        (self.waits_s, self.action) = (None, None);
        // the end of the mission
        self.stop.is_none() && row + 1 == self.rows.len()
    }

    /// Takes up a lower speed where coasting for it begins, and keeps it until its place.
    fn act(&mut self, situation: &Situation) {
        if self.action.is_some_and(|action| situation.way_m >= self.way_m(action.row)) {
            self.action = None;
        }
        let Some(next) = self.next_action(situation) else {
            return;
        };
        // on seconds: that which is nearer to the place
        let begins = situation.way_m + 0.5 * situation.speed_mps >= next.from_m;
        if self
            .action
            .map_or(begins, |action| next.row != action.row && next.from_m < action.from_m)
        {
            self.action = Some(next);
        }
    }

    /// The lower speed for which the brakes would have to be pressed first; none where it is not
    /// coasted for.
    fn next_action(&self, situation: &Situation) -> Option<Action> {
        let Situation { way_m, speed_mps, .. } = *situation;
        if speed_mps <= self.minimum_speed_mps {
            return None;
        }
        let preview_m = PREVIEW_S * speed_mps;
        let from = self.falls.partition_point(|row| self.way_m(*row) <= way_m);
        let ahead = self.falls[from..].iter().map(|row| (*row, self.allowed_mps[*row]));
        let ahead = ahead.take_while(|(row, _)| self.way_m(*row) <= way_m + preview_m);
        let starts = ahead.filter(|(_, end_mps)| *end_mps < speed_mps).map(|(row, end_mps)| {
            (row, end_mps, self.way_m(row) - self.braking_m(speed_mps, end_mps))
        });
        let (row, end_mps, braking_from_m) = starts.min_by(|a, b| a.2.total_cmp(&b.2))?;
        let coasting_m = self.coasting_m(situation, row, end_mps);
        let from_m = braking_from_m.min(self.way_m(row) - coasting_m);
        (coasting_m >= 0.0).then_some(Action { row, end_mps, from_m })
    }

    /// Way of braking by the table from one speed to another, in m.
    fn braking_m(&self, start_mps: f64, end_mps: f64) -> f64 {
        let step_mps = (start_mps - end_mps) / f64::from(BRAKING_PIECES);
        let piece_m = |k: u32| {
            let mps = end_mps + (f64::from(k) + 0.5) * step_mps;
            mps * step_mps / -self.driver.acceleration.deceleration_mps2(mps)
        };
        (0..BRAKING_PIECES).map(piece_m).sum()
    }

    /// Way over which a lower speed is coasted for, in m: the energy that has to go, over a
    /// multiple of the force of coasting.
    fn coasting_m(&self, situation: &Situation, row: usize, end_mps: f64) -> f64 {
        let climb_m = self.altitude_m[row] - self.altitude_m(situation.way_m);
        let speeds_mps = [situation.speed_mps, end_mps];
        let slowing = self.truck.slowing(situation.gear, speeds_mps, climb_m);
        slowing.energy_j / (decision_factor(situation.speed_mps, end_mps) * slowing.coasting_n)
    }

    fn coasting_mps2(&self, situation: &Situation) -> f64 {
        let Situation { way_m, speed_mps, slope, .. } = *situation;
        let auxiliary_w = situation.auxiliary_w + self.rows[self.row(way_m)].auxiliary_w;
        match situation.gear {
            Some(gear) => self.truck.dragged_mps2(gear, speed_mps, slope, auxiliary_w),
            None => self.truck.rolling_mps2(speed_mps, slope),
        }
    }
}

/// Speed up to which a driver lets a truck run where a target and a slope hold, in m/s: more
/// downhill.
fn allowed_mps(overspeed: Option<&Overspeed>, target_mps: f64, slope: f64) -> f64 {
    let rolls = |overspeed: &&Overspeed| slope < 0.0 && target_mps > overspeed.minimum_speed_mps;
    let above = overspeed.filter(rolls);
    target_mps + above.map_or(0.0, |overspeed| overspeed.above_mps)
}

/// VECTO 3's decision factor from one speed to another, in m/s.
fn decision_factor(start_mps: f64, end_mps: f64) -> f64 {
    let (end, drop) = (3.6 * end_mps, 3.6 * (start_mps - end_mps));
    let by_speed = ((end - 48.0) / 4.0).clamp(0.0, 1.0);
    let by_drop = ((11.0 - drop) / 2.0).clamp(0.0, 1.0);
    2.5 - 1.5 * by_speed * by_drop
}

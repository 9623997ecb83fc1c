//! A mission: target speed, gradient and stops over distance, and its nodes at whole seconds.

use super::{AccelerationTable, MissionError};

/// Length of the pieces into which a mission is cut, in m.
const PIECE_M: f64 = 1.0;
/// By how much a speed is lowered at once until a ramp can be braked, in m/s.
const RAMP_STEP_MPS: f64 = 0.001;
/// A node that is slower than this rests, in m/s.
const REST_MPS: f64 = 0.5;
/// Longest mission, in pieces.
const MOST_PIECES: f64 = 1e7;

/// One row of a mission.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MissionRow {
    /// Place, in m.
    pub distance_m: f64,
    /// Target speed, in m/s; 0 at a stop.
    pub target_mps: f64,
    /// Gradient: the tangent of the road's angle.
    pub gradient: f64,
    /// Time that a stop takes, in s.
    pub stop_s: f64,
    /// Power of auxiliaries beside those that always run, in W.
    pub auxiliary_w: f64,
}

/// Target speed, gradient and stops over distance, in steps of a metre.
#[derive(Clone, Debug, PartialEq)]
pub struct Mission {
    rows: Vec<MissionRow>,
}

/// Nodes at each whole second of a driver without limits but those of braking.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Nodes {
    /// Places along the mission, in m.
    pub(super) way_m: Vec<f64>,
    /// Speeds, in m/s.
    pub(super) speed_mps: Vec<f64>,
    /// Target speeds before braking ramps, in m/s.
    pub(super) target_mps: Vec<f64>,
    /// Power of auxiliaries that the mission adds, in W.
    pub(super) auxiliary_w: Vec<f64>,
}

/// A place on the mission's clock.
#[derive(Clone, Copy, Debug)]
struct Passage {
    time_s: f64,
    distance_m: f64,
    speed_mps: f64,
    target_mps: f64,
    auxiliary_w: f64,
}

impl Mission {
    /// Checks rows and cuts them into steps of a metre. A row holds until the next one; after a
    /// stop the target is that of the next row.
    ///
    /// # Errors
    /// [`MissionError`] names the row and what is allowed.
    pub fn new(rows: &[MissionRow]) -> Result<Self, MissionError> {
        if rows.len() < 2 {
            return Err(MissionError::Short { rows: rows.len() });
        }
        for (k, row) in rows.iter().enumerate() {
            let before_m = k.checked_sub(1).map_or(-1e9, |k| rows[k].distance_m + 1e-3);
            for (name, value, minimum, maximum) in [
                ("distance_m", row.distance_m, before_m, 1e9),
                ("target_mps", row.target_mps, 0.0, 70.0),
                ("gradient", row.gradient, -0.5, 0.5),
                ("stop_s", row.stop_s, 0.0, 172_800.0),
                ("auxiliary_w", row.auxiliary_w, 0.0, 1e6),
            ] {
                if !(value >= minimum && value <= maximum) {
                    return Err(MissionError::Range { row: k + 1, name, value, minimum, maximum });
                }
            }
        }
        let length_m = rows[rows.len() - 1].distance_m - rows[0].distance_m;
        if length_m / PIECE_M > MOST_PIECES {
            let (row, name, value) = (rows.len(), "distance_m", length_m);
            let maximum = MOST_PIECES * PIECE_M;
            return Err(MissionError::Range { row, name, value, minimum: 0.0, maximum });
        }
        let mut cut = Vec::with_capacity(length_m as usize + rows.len());
        for pair in rows.windows(2) {
            let (row, next) = (pair[0], pair[1]);
            cut.push(row);
            let target_mps = if row.target_mps > 0.0 { row.target_mps } else { next.target_mps };
            let mut distance_m = row.distance_m + PIECE_M;
            while distance_m < next.distance_m - 1e-6 {
                cut.push(MissionRow { distance_m, target_mps, stop_s: 0.0, ..row });
                distance_m += PIECE_M;
            }
        }
        cut.push(rows[rows.len() - 1]);
        Ok(Self { rows: cut })
    }

    /// Its length, in m.
    pub fn length_m(&self) -> f64 {
        self.rows[self.rows.len() - 1].distance_m - self.rows[0].distance_m
    }

    /// Gradient at a distance from its start in m: constant between two rows, their mean.
    pub fn gradient(&self, way_m: f64) -> f64 {
        let place_m = self.rows[0].distance_m + way_m;
        let above = self.rows.partition_point(|row| row.distance_m <= place_m);
        let k = above.clamp(1, self.rows.len() - 1);
        0.5 * (self.rows[k - 1].gradient + self.rows[k].gradient)
    }

    pub(super) fn rows(&self) -> &[MissionRow] {
        &self.rows
    }

    /// The nodes at whole seconds of a driver who brakes as the table says and has no other limit.
    pub(super) fn nodes(&self, table: &AccelerationTable) -> Nodes {
        let passages = self.passages(table);
        let mut nodes = Nodes::default();
        let last_s = passages[passages.len() - 1].time_s;
        let mut k = 1;
        for second in 0..=libm::floor(last_s) as usize {
            let now_s = second as f64;
            while k + 1 < passages.len() && passages[k].time_s < now_s {
                k += 1;
            }
            let (a, b) = (&passages[k - 1], &passages[k]);
            let share = ((now_s - a.time_s) / (b.time_s - a.time_s)).clamp(0.0, 1.0);
            let between = |a: f64, b: f64| a + (b - a) * share;
            let speed_mps = between(a.speed_mps, b.speed_mps);
            let rests = speed_mps < REST_MPS;
            nodes.way_m.push(between(a.distance_m, b.distance_m) - self.rows[0].distance_m);
            nodes.speed_mps.push(if rests { 0.0 } else { single(speed_mps) });
            nodes.target_mps.push(single(between(a.target_mps, b.target_mps)));
            nodes.auxiliary_w.push(a.auxiliary_w);
        }
        if nodes.speed_mps.len() > 1 && nodes.speed_mps[0] == 0.0 && nodes.speed_mps[1] > 0.0 {
            nodes.repeat_first();
        }
        nodes
    }

    /// The rows with braking ramps on the clock of a driver who has no other limit.
    fn passages(&self, table: &AccelerationTable) -> Vec<Passage> {
        let rows = &self.rows;
        let mut speed_mps: Vec<f64> = rows.iter().map(|row| row.target_mps).collect();
        for k in (1..rows.len()).rev() {
            let piece_m = rows[k].distance_m - rows[k - 1].distance_m;
            let end_mps = speed_mps[k];
            let mean = |start_mps: f64| 0.5 * (start_mps + end_mps);
            let slows =
                |v: f64| mean(v) * (end_mps - v) / piece_m < table.deceleration_mps2(mean(v));
            let start_mps = &mut speed_mps[k - 1];
            while *start_mps > end_mps && slows(*start_mps) {
                *start_mps -= RAMP_STEP_MPS;
            }
        }
        let mut passages = Vec::with_capacity(rows.len() + 8);
        let mut time_s = 0.0;
        for (k, row) in rows.iter().enumerate() {
            if let Some(before) = k.checked_sub(1) {
                let mean_mps = 0.5 * (speed_mps[k] + speed_mps[before]);
                // two stops in a row of rows: the way between them is crept
                time_s += (row.distance_m - rows[before].distance_m) / mean_mps.max(0.5 * REST_MPS);
            }
            let passage = Passage {
                time_s,
                distance_m: row.distance_m,
                speed_mps: speed_mps[k],
                target_mps: row.target_mps,
                auxiliary_w: row.auxiliary_w,
            };
            passages.push(passage);
            if speed_mps[k] == 0.0 && row.stop_s > 0.0 {
                time_s += row.stop_s;
                passages.push(Passage { time_s, ..passage });
            }
        }
        passages
    }
}

impl Nodes {
    /// Number of seconds between the nodes.
    pub(super) fn seconds(&self) -> usize {
        self.speed_mps.len().saturating_sub(1)
    }

    /// Mean speed of a second, in m/s.
    pub(super) fn mean_mps(&self, second: usize) -> f64 {
        0.5 * (self.speed_mps[second] + self.speed_mps[second + 1])
    }

    /// Acceleration in a second, in m/s².
    pub(super) fn acceleration_mps2(&self, second: usize) -> f64 {
        self.speed_mps[second + 1] - self.speed_mps[second]
    }

    /// Mean target of a second, in m/s.
    pub(super) fn mean_target_mps(&self, second: usize) -> f64 {
        0.5 * (self.target_mps[second] + self.target_mps[second + 1])
    }

    /// Repeats a second: a node of its mean speed comes between its nodes.
    pub(super) fn repeat(&mut self, second: usize) {
        if second < self.seconds() {
            self.speed_mps.insert(second + 1, self.mean_mps(second));
            self.target_mps.insert(second + 1, self.target_mps[second]);
            self.auxiliary_w.insert(second + 1, self.auxiliary_w[second]);
        }
    }

    /// Leaves a second out.
    pub(super) fn drop(&mut self, second: usize) {
        if second < self.seconds() {
            for values in [&mut self.speed_mps, &mut self.target_mps, &mut self.auxiliary_w] {
                values.remove(second + 1);
            }
        }
    }

    fn repeat_first(&mut self) {
        for values in
            [&mut self.way_m, &mut self.speed_mps, &mut self.target_mps, &mut self.auxiliary_w]
        {
            values.insert(0, values[0]);
        }
    }
}

/// A number with the precision that VECTO has: where a slope begins at a whole metre the last bit
/// decides.
fn single(x: f64) -> f64 {
    f64::from(x as f32)
}

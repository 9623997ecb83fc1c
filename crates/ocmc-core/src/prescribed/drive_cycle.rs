//! A drive cycle: speed over time, as regulations and other simulators prescribe it.

use crate::powertrain::{GearOrder, SpeedStep};
use thiserror::Error;

/// Shortest step, in s.
pub(super) const SHORTEST_STEP_S: f64 = 1e-3;
/// Points that are closer than [`SHORTEST_STEP_S`] and differ by less than this, in m/s, are one.
const SAME_SPEED_MPS: f64 = 0.01;
/// Relative rounding of times.
const ROUNDING: f64 = 1e-6;
/// Longest step of a moving vehicle, in s.
const LONGEST_STEP_S: f64 = 3600.0;
/// Longest rest, in s: what a file of a road allows, too.
const LONGEST_REST_S: f64 = 172_800.0;
/// Highest speed, in m/s.
const FASTEST_MPS: f64 = 70.0;
/// Largest slope, as climb per metre of road.
const STEEPEST: f64 = 0.5;

/// Speed and slope over time, linear in speed between the points.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveCycle {
    time_s: Vec<f64>,
    speed_mps: Vec<f64>,
    /// Climb per metre of road; that of a point holds over the step that ends there.
    slope: Vec<f64>,
    /// Gear order of the step that ends at a point; empty where none is given.
    gear: Vec<GearOrder>,
}

/// Error of a drive cycle.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DriveCycleError {
    /// Too few points.
    #[error("{points} points, allowed are 2 and more")]
    Short {
        /// Number of points.
        points: usize,
    },
    /// A value out of range.
    #[error("at point {point}, `{name}` is {value}, allowed is {minimum} to {maximum}")]
    Range {
        /// Number of the point, from 1.
        point: usize,
        /// Name of the quantity.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Smallest allowed value.
        minimum: f64,
        /// Largest allowed value.
        maximum: f64,
    },
}

/// One step of a drive cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleStep {
    /// Its speed.
    pub speed: SpeedStep,
    /// Climb per metre of road.
    pub slope: f64,
}

impl DriveCycle {
    /// Checks a cycle; three lists of equal length.
    ///
    /// # Errors
    /// [`DriveCycleError`] names the point and what is allowed.
    pub fn new(
        time_s: Vec<f64>,
        speed_mps: Vec<f64>,
        slope: Vec<f64>,
    ) -> Result<Self, DriveCycleError> {
        let points = time_s.len().min(speed_mps.len()).min(slope.len());
        if points < 2 {
            return Err(DriveCycleError::Short { points });
        }
        let check = |k: usize, name, value: f64, minimum: f64, maximum: f64| {
            if value >= minimum && value <= maximum {
                Ok(())
            } else {
                Err(DriveCycleError::Range { point: k + 1, name, value, minimum, maximum })
            }
        };
        let mut kept: Vec<usize> = Vec::with_capacity(points);
        for k in 0..points {
            check(k, "speed_mps", speed_mps[k], 0.0, FASTEST_MPS)?;
            check(k, "grade", slope[k], -STEEPEST, STEEPEST)?;
            if let Some(&before) = kept.last() {
                let since_s = time_s[k] - time_s[before];
                let change_mps = (speed_mps[k] - speed_mps[before]).abs();
                // traces have steps of microseconds, and end with a row of no duration, at rest
                let same =
                    since_s > 0.0 && since_s < SHORTEST_STEP_S && change_mps < SAME_SPEED_MPS;
                let end = since_s == 0.0 && k + 1 == points && speed_mps[k] == 0.0;
                if same || end {
                    continue;
                }
                let rests = speed_mps[before] == 0.0 && speed_mps[k] == 0.0;
                let longest_s = if rests { LONGEST_REST_S } else { LONGEST_STEP_S };
                check(k, "time since the point before", since_s, SHORTEST_STEP_S, longest_s)?;
            }
            kept.push(k);
        }
        if kept.len() < 2 {
            return Err(DriveCycleError::Short { points: kept.len() });
        }
        let kept_values = |values: Vec<f64>| kept.iter().map(|&k| values[k]).collect();
        let (time_s, speed_mps, slope) =
            (kept_values(time_s), kept_values(speed_mps), kept_values(slope));
        Ok(Self { time_s, speed_mps, slope, gear: Vec::new() })
    }

    /// A cycle that follows from a plan: its study and its road have been checked, and a truck may
    /// rest longer than what a file may say.
    pub fn of_plan(time_s: Vec<f64>, speed_mps: Vec<f64>, slope: Vec<f64>) -> Self {
        Self { time_s, speed_mps, slope, gear: Vec::new() }
    }

    /// The same cycle with what is said of the gears: an order for each of its points, for the step
    /// that ends there.
    ///
    /// # Panics
    /// Unless there are as many orders as points.
    #[must_use]
    pub fn with_gears(self, gear: Vec<GearOrder>) -> Self {
        assert_eq!(gear.len(), self.time_s.len(), "an order for each point");
        Self { gear, ..self }
    }

    /// The same cycle with nothing said of the gears.
    #[must_use]
    pub fn without_gears(mut self) -> Self {
        self.gear.clear();
        self
    }

    /// Longest step in which the vehicle moves, in s.
    pub fn longest_moving_step_s(&self) -> f64 {
        let steps = self.steps().filter(|step| step.speed.distance_m() > 0.0);
        steps.fold(0.0, |longest, step| longest.max(step.speed.dt_s))
    }

    /// The same cycle with steps of at most `longest_s` in which the vehicle moves: a point that is
    /// further behind the one before gets points between, at equal times, with the speed straight
    /// between them. A rest stays one step: nothing depends on its length but linearly.
    #[must_use]
    pub fn refined(&self, longest_s: f64) -> Self {
        if self.longest_moving_step_s() <= longest_s * (1.0 + ROUNDING) {
            return self.clone();
        }
        let mut fine = Self {
            time_s: self.time_s[..1].to_vec(),
            speed_mps: self.speed_mps[..1].to_vec(),
            slope: self.slope[..1].to_vec(),
            gear: self.gear.iter().take(1).copied().collect(),
        };
        for k in 1..self.time_s.len() {
            let (from_s, to_s) = (self.time_s[k - 1], self.time_s[k]);
            let (from_mps, to_mps) = (self.speed_mps[k - 1], self.speed_mps[k]);
            let moves = from_mps > 0.0 || to_mps > 0.0;
            let parts = libm::ceil((to_s - from_s) / longest_s - ROUNDING).max(1.0);
            let parts = if moves { parts } else { 1.0 };
            let mut part = 1.0;
            while part <= parts {
                let share = part / parts;
                // the last one is the point itself, to the bit
                let between = |from: f64, to: f64| {
                    if part < parts { from + share * (to - from) } else { to }
                };
                fine.time_s.push(between(from_s, to_s));
                fine.speed_mps.push(between(from_mps, to_mps));
                fine.slope.push(self.slope[k]);
                fine.gear.extend(self.gear.get(k));
                part += 1.0;
            }
        }
        fine
    }

    /// Gear orders, one for each point; empty where none is given.
    pub fn gears(&self) -> &[GearOrder] {
        &self.gear
    }

    /// Its points: time in s, speed in m/s, and the slope over the step that ends there.
    pub fn points(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        let rest = self.speed_mps.iter().zip(&self.slope);
        self.time_s.iter().zip(rest).map(|(time, (speed, slope))| [*time, *speed, *slope])
    }

    /// Its steps. A rest is one step, however many points it has: whether it is worth charging
    /// depends on all of it.
    pub fn steps(&self) -> impl Iterator<Item = CycleStep> + '_ {
        let rests = |k: usize| self.speed_mps[k] == 0.0;
        let mut start = 0;
        std::iter::from_fn(move || {
            let mut end = start + 1;
            if end >= self.time_s.len() {
                return None;
            }
            if rests(start) && rests(end) {
                while end + 1 < self.time_s.len() && rests(end + 1) {
                    end += 1;
                }
            }
            let speed = SpeedStep {
                dt_s: self.time_s[end] - self.time_s[start],
                start_mps: self.speed_mps[start],
                end_mps: self.speed_mps[end],
                gear: self.gear.get(end).copied().unwrap_or_default(),
            };
            let step = CycleStep { speed, slope: self.slope[end] };
            start = end;
            Some(step)
        })
    }

    /// Duration, in s.
    pub fn duration_s(&self) -> f64 {
        self.time_s[self.time_s.len() - 1] - self.time_s[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_that_say_nothing_new_are_left_out_and_others_too_close_are_refused() {
        let cycle = |time_s: &[f64], speed_mps: &[f64]| {
            DriveCycle::new(time_s.to_vec(), speed_mps.to_vec(), vec![0.0; time_s.len()])
        };
        let trace = cycle(&[0.0, 1.0, 1.0 + 1e-6, 2.0, 2.0], &[0.0, 2.0, 2.0, 1.0, 0.0]).unwrap();
        let points: Vec<f64> = trace.points().map(|point| point[0]).collect();
        assert_eq!(points, [0.0, 1.0, 2.0]);
        for (time_s, speed_mps) in [
            ([0.0, 1.0, 1.0, 2.0], [0.0, 2.0, 2.0, 1.0]),
            ([0.0, 1.0, 1.0 + 1e-6, 2.0], [0.0, 2.0, 3.0, 1.0]),
            ([0.0, 1.0, 2.0, 2.0], [0.0, 2.0, 2.0, 1.0]),
            ([0.0, 1.0, 2.0, 1.0], [0.0, 2.0, 2.0, 0.0]),
        ] {
            let error = cycle(&time_s, &speed_mps).unwrap_err().to_string();
            assert!(error.contains("time since the point before"), "{error}");
        }
    }

    #[test]
    fn points_far_apart_get_points_between_them_and_rests_none() {
        let cycle = DriveCycle::new(
            vec![0.0, 10.0, 12.5, 13.0, 113.0],
            vec![0.0, 15.0, 15.0, 0.0, 0.0],
            vec![0.0, 0.01, 0.02, 0.0, 0.0],
        );
        let cycle = cycle.unwrap();
        let fine = cycle.refined(1.0);
        assert_eq!(fine.points().count(), 1 + 10 + 3 + 1 + 1);
        let [time_s, speed_mps, slope] = fine.points().nth(4).unwrap();
        assert_eq!((time_s, speed_mps, slope), (4.0, 6.0, 0.01));
        let way_m =
            |cycle: &DriveCycle| -> f64 { cycle.steps().map(|step| step.speed.distance_m()).sum() };
        assert!((way_m(&fine) - way_m(&cycle)).abs() < 1e-9);
        assert_eq!((fine.duration_s(), fine.longest_moving_step_s()), (113.0, 1.0));
        assert_eq!(fine.refined(1.0), fine);
    }
}

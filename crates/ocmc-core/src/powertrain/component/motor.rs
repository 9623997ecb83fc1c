//! Electric motor with its inverter: torque limits, and a map of losses.
//!
//! Torque up to the smaller of the highest torque and power over speed, driving and braking each
//! with its own limits. Losses are given over speed and torque without sign, the same for driving
//! and braking; bilinear in the map's cells, held beyond its edges. Terminals see P = w T + loss:
//! what the motor gives back while braking is w |T| less the loss, and may be less than nothing.

use super::bilinear::{Cells, cells};
use super::engine::MOST_KNOTS;
use crate::lanes::{Bounded, Flags, Lanes, clip, columns, masked, one};
use crate::validation::{Problems, rises};
use fearless_simd::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An electric motor with its inverter; several motors count as one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotorModel {
    /// Highest torque, in Nm.
    #[schemars(range(min = 1.0, max = 100_000.0))]
    pub torque_nm: f64,
    /// Highest power, in W.
    #[schemars(range(min = 1000.0, max = 1.0e7))]
    pub power_w: f64,
    /// Highest torque while braking, in Nm.
    #[schemars(range(min = 0.0, max = 100_000.0))]
    pub brake_torque_nm: f64,
    /// Highest power while braking, in W.
    #[schemars(range(min = 0.0, max = 1.0e7))]
    pub brake_power_w: f64,
    /// Share of what the pedal asks for that the motor may brake at most: only driven axles brake
    /// by it.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub brake_share: f64,
    /// Speed below which braking by the motor fades out, in m/s.
    #[schemars(range(min = 0.01, max = 20.0))]
    pub brake_fade_mps: f64,
    /// Highest speed, in rad/s.
    #[schemars(range(min = 10.0, max = 5000.0))]
    pub maximum_speed_radps: f64,
    /// Moment of inertia, in kg m².
    #[schemars(range(min = 0.0, max = 100.0))]
    pub inertia_kgm2: f64,
    /// Speeds of the map of losses, in rad/s.
    #[schemars(inner(range(min = 0.0, max = 5000.0)))]
    pub map_speed_radps: Vec<f64>,
    /// Torques of the map of losses, from 0 up, in Nm.
    #[schemars(inner(range(min = 0.0, max = 100_000.0)))]
    pub map_torque_nm: Vec<f64>,
    /// Losses of motor and inverter, in W: a row for each speed.
    #[schemars(inner(inner(range(min = 0.0, max = 1.0e7))))]
    pub map_loss_w: Vec<Vec<f64>>,
}

impl MotorModel {
    /// A map of rising speeds and torques, with a value for each of them.
    pub fn validate(&self, problems: &mut Problems) {
        for (key, knots) in
            [("map_speed_radps", &self.map_speed_radps), ("map_torque_nm", &self.map_torque_nm)]
        {
            let rising = knots.len() >= 2 && rises(knots);
            problems.require(rising, key, format!("{knots:?}"), "2 and more rising numbers");
            let count = knots.len();
            let few = count <= MOST_KNOTS;
            problems.require(few, key, format!("{count} numbers"), "at most 16 numbers");
        }
        // a slip of a unit; a battery of any size would be empty within a step
        let largest_w = self.map_loss_w.iter().flatten().copied().fold(0.0, f64::max);
        let allowed = "at most twice the motor's power_w";
        problems.require(largest_w <= 2.0 * self.power_w, "map_loss_w", largest_w, allowed);
        let columns = self.map_torque_nm.len();
        problems.require(
            self.map_loss_w.len() == self.map_speed_radps.len()
                && self.map_loss_w.iter().all(|row| row.len() == columns),
            "map_loss_w",
            "a map of another size",
            "a row for each of map_speed_radps, with a column for each of map_torque_nm",
        );
    }

    /// Whether a speed in rad/s and a torque in Nm lie within the points of the map.
    pub fn map_covers(&self, speed_radps: f64, torque_nm: f64) -> bool {
        self.maps_cover(one(speed_radps), one(torque_nm)).test(0)
    }

    /// The same for vehicles.
    #[inline(always)]
    pub fn maps_cover<S: Simd>(&self, speed_radps: Lanes<S>, torque_nm: Lanes<S>) -> Flags<S> {
        let (speeds, torques) = (&self.map_speed_radps, &self.map_torque_nm);
        let torque_nm = torque_nm.abs();
        let beyond = speed_radps.simd_gt(speeds[speeds.len() - 1])
            | torque_nm.simd_gt(torques[torques.len() - 1])
            | speed_radps.simd_lt(speeds[0])
            | torque_nm.simd_lt(torques[0]);
        !beyond
    }

    /// Highest torque while driving, in Nm, at a speed in rad/s.
    pub fn drive_limit_nm(&self, speed_radps: f64) -> f64 {
        self.drive_limits_nm(one(speed_radps))[0]
    }

    /// The same for vehicles.
    #[inline(always)]
    pub fn drive_limits_nm<S: Simd>(&self, speed_radps: Lanes<S>) -> Lanes<S> {
        let limit = (self.power_w / speed_radps.at_least(1.0)).at_most(self.torque_nm);
        masked(!speed_radps.simd_gt(self.maximum_speed_radps), limit)
    }

    /// Highest torque while braking, in Nm, without sign, at a motor speed in rad/s and a vehicle
    /// speed in m/s.
    pub fn brake_limit_nm(&self, speed_radps: f64, vehicle_mps: f64) -> f64 {
        self.brake_limits_nm(one(speed_radps), one(vehicle_mps))[0]
    }

    /// The same for vehicles.
    #[inline(always)]
    pub fn brake_limits_nm<S: Simd>(
        &self,
        speed_radps: Lanes<S>,
        vehicle_mps: Lanes<S>,
    ) -> Lanes<S> {
        let fade = clip(vehicle_mps * (1.0 / self.brake_fade_mps), 0.0, 1.0);
        fade * (self.brake_power_w / speed_radps.at_least(1.0)).at_most(self.brake_torque_nm)
    }
}

/// A motor prepared for the hot loop.
#[derive(Clone, Debug)]
pub struct Motor {
    model: MotorModel,
    /// The map's cells {a, b, c, d}: loss = a + b w + T (c + d w); those of one speed lie together.
    cells: Cells,
}

impl Motor {
    /// Prepares a checked model.
    pub fn new(model: &MotorModel) -> Self {
        let cells = cells(&model.map_speed_radps, &model.map_torque_nm, &model.map_loss_w);
        Self { model: model.clone(), cells }
    }

    /// Losses of motor and inverter, in W.
    pub fn loss_w(&self, speed_radps: f64, torque_nm: f64) -> f64 {
        self.losses_w(one(speed_radps), one(torque_nm))[0]
    }

    /// The same for vehicles.
    #[inline(always)]
    pub fn losses_w<S: Simd>(&self, speed_radps: Lanes<S>, torque_nm: Lanes<S>) -> Lanes<S> {
        let (speeds, torques) = (&self.model.map_speed_radps, &self.model.map_torque_nm);
        let w = clip(speed_radps, speeds[0], speeds[speeds.len() - 1]);
        let t = clip(torque_nm.abs(), torques[0], torques[torques.len() - 1]);
        let cell = pieces(speeds, w) * MOST_KNOTS as f64 + pieces(torques, t);
        let [a, b, c, d] = columns(
            w.simd,
            #[inline(always)]
            |l| &self.cells[cell[l] as usize % (MOST_KNOTS * MOST_KNOTS)],
        );
        a + b * w + t * (c + d * w)
    }

    /// Power at the terminals, in W; negative where the motor gives back.
    pub fn terminals_w(&self, speed_radps: f64, torque_nm: f64) -> f64 {
        speed_radps * torque_nm + self.loss_w(speed_radps, torque_nm)
    }

    /// The torque between zero and the wanted one, in Nm, up to which the power at the terminals
    /// stays within limits, in W.
    ///
    /// At one speed the power is a polygon over the torque: it is followed from zero to where it
    /// leaves the limits.
    pub fn within_nm(&self, speed_radps: f64, torque_nm: f64, least_w: f64, most_w: f64) -> f64 {
        let sign = if torque_nm < 0.0 { -1.0 } else { 1.0 };
        let knots = self.model.map_torque_nm.iter().copied().filter(|knot| *knot > 0.0);
        let ends = knots.take_while(|knot| *knot < torque_nm.abs()).chain([torque_nm.abs()]);
        let (mut inside, mut before) = (0.0, self.terminals_w(speed_radps, 0.0));
        for end in ends {
            let after = self.terminals_w(speed_radps, sign * end);
            // losses can be larger than what braking gives back
            let above = after > most_w && after > before;
            if above || after < least_w {
                let limit = if above { most_w } else { least_w };
                let share = ((limit - before) / (after - before)).clamp(0.0, 1.0);
                return sign * (inside + share * (end - inside));
            }
            (inside, before) = (end, after);
        }
        torque_nm
    }
}

/// The pieces of a grid in which numbers lie, from 0.
#[inline(always)]
fn pieces<S: Simd>(knots: &[f64], x: Lanes<S>) -> Lanes<S> {
    let one = Lanes::splat(x.simd, 1.0);
    let mut piece = Lanes::splat(x.simd, 0.0);
    for knot in &knots[1..knots.len() - 1] {
        piece += masked(!x.simd_lt(*knot), one);
    }
    piece
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn motor() -> MotorModel {
        MotorModel {
            torque_nm: 2400.0,
            power_w: 490e3,
            brake_torque_nm: 2400.0,
            brake_power_w: 400e3,
            brake_share: 0.9,
            brake_fade_mps: 2.0,
            maximum_speed_radps: 480.0,
            inertia_kgm2: 2.0,
            map_speed_radps: vec![0.0, 200.0, 480.0],
            map_torque_nm: vec![0.0, 1000.0, 2400.0],
            map_loss_w: vec![vec![500.0, 5e3, 20e3], vec![2e3, 10e3, 30e3], vec![6e3, 20e3, 50e3]],
        }
    }

    #[test]
    fn the_map_returns_its_points_and_holds_its_edges() {
        let motor = Motor::new(&motor());
        let loss = |w: f64, t: f64| motor.loss_w(w, t);
        for (speed, torque, wanted) in [
            (0.0, 0.0, 500.0),
            (200.0, 1000.0, 10e3),
            (480.0, 2400.0, 50e3),
            (100.0, 500.0, (500.0 + 5e3 + 2e3 + 10e3) / 4.0),
            (200.0, -1000.0, 10e3),
            (1e9, 1e9, 50e3),
            (-5.0, 0.0, 500.0),
        ] {
            // the cell is multiplied out: its corners come back to the last digits
            let got = loss(speed, torque);
            assert!((got / wanted - 1.0).abs() < 1e-12, "{speed} {torque}: {got}");
        }
    }

    #[test]
    fn a_brake_that_loses_more_than_it_gives_back_stays_within_the_battery() {
        let lossy = vec![vec![500.0, 5e3, 20e3], vec![2e3, 10e3, 9e6], vec![6e3, 20e3, 50e3]];
        let motor = Motor::new(&MotorModel { map_loss_w: lossy, ..motor() });
        let (speed, least, most) = (200.0, -300e3, 300e3);
        let torque = motor.within_nm(speed, -2400.0, least, most);
        let got = motor.terminals_w(speed, torque);
        assert!(torque < -1000.0 && (got - most).abs() < 1.0, "{torque} {got}");
    }

    #[test]
    fn the_map_knows_its_edges() {
        let motor = MotorModel { map_speed_radps: vec![10.0, 200.0, 480.0], ..motor() };
        for (speed, torque, covered) in [
            (10.0, 0.0, true),
            (480.0, -2400.0, true),
            (9.9, 0.0, false),
            (480.1, 0.0, false),
            (100.0, -2400.1, false),
        ] {
            assert_eq!(motor.map_covers(speed, torque), covered, "{speed} {torque}");
        }
    }

    #[test]
    fn limits_are_torque_then_power() {
        let motor = motor();
        let drive = |w: f64| motor.drive_limit_nm(w);
        assert_eq!((drive(0.0), drive(100.0), drive(400.0)), (2400.0, 2400.0, 1225.0));
        assert_eq!(drive(500.0), 0.0);
        let brake = |w: f64, v: f64| motor.brake_limit_nm(w, v);
        assert_eq!((brake(100.0, 9.0), brake(400.0, 9.0)), (2400.0, 1000.0));
        assert_eq!((brake(100.0, 0.0), brake(100.0, 1.0)), (0.0, 1200.0));
    }

    #[test]
    fn the_torque_within_limits_meets_them() {
        let motor = Motor::new(&motor());
        for speed in [20.0, 150.0, 400.0] {
            for limit in [-150e3f64, -40e3, -1.0, 30e3, 200e3] {
                let wanted = if limit < 0.0 { -2400.0 } else { 2400.0 };
                let torque = motor.within_nm(speed, wanted, limit.min(0.0), limit.max(0.0));
                let power = motor.terminals_w(speed, torque);
                let at_the_limit = (power - limit).abs() < 1e-6 * limit.abs();
                // what the limit does not hold back is left as it is
                let free = torque == wanted && (power - limit) * limit.signum() < 0.0;
                assert!(at_the_limit || free, "{speed} {limit}: {torque} {power}");
            }
            // where even standing idle takes more than there is, nothing is left
            assert_eq!(motor.within_nm(speed, 100.0, 0.0, 1.0), 0.0);
        }
    }
}

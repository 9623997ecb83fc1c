//! Electric motor with its inverter: torque limits, and a map of losses.
//!
//! Torque up to the smaller of the highest torque and power over speed, driving and braking each with its own limits. Losses are given over speed
//! and torque without sign, the same for driving and braking; bilinear in the map's cells, held beyond its edges. Terminals see
//! P = w T + loss: what the motor gives back while braking is w |T| less the loss, and may be less than nothing.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An electric motor with its inverter; several motors count as one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotorModel {
    /// Highest torque, in Nm.
    pub torque_nm: f64,
    /// Highest power, in W.
    pub power_w: f64,
    /// Highest torque while braking, in Nm.
    pub brake_torque_nm: f64,
    /// Highest power while braking, in W.
    pub brake_power_w: f64,
    /// Share of what the pedal asks for that the motor may brake at most: only driven axles brake by it.
    pub brake_share: f64,
    /// Speed below which braking by the motor fades out, in m/s.
    pub brake_fade_mps: f64,
    /// Highest speed, in rad/s.
    pub maximum_speed_radps: f64,
    /// Moment of inertia, in kg m².
    pub inertia_kgm2: f64,
    /// Speeds of the map of losses, in rad/s.
    pub map_speed_radps: Vec<f64>,
    /// Torques of the map of losses, from 0 up, in Nm.
    pub map_torque_nm: Vec<f64>,
    /// Losses of motor and inverter, in W: a row for each speed.
    pub map_loss_w: Vec<Vec<f64>>,
}

impl MotorModel {
    /// Highest torque while driving, in Nm, at a speed in rad/s.
    pub fn drive_limit_nm(&self, speed_radps: f64) -> f64 {
        if speed_radps > self.maximum_speed_radps {
            return 0.0;
        }
        self.torque_nm.min(self.power_w / speed_radps.max(1.0))
    }

    /// Highest torque while braking, in Nm, without sign, at a motor speed in rad/s and a vehicle speed in m/s.
    pub fn brake_limit_nm(&self, speed_radps: f64, vehicle_mps: f64) -> f64 {
        let fade = (vehicle_mps / self.brake_fade_mps).clamp(0.0, 1.0);
        fade * self.brake_torque_nm.min(self.brake_power_w / speed_radps.max(1.0))
    }

    /// Losses, in W.
    pub fn loss_w(&self, speed_radps: f64, torque_nm: f64) -> f64 {
        let (i, x) = place(&self.map_speed_radps, speed_radps);
        let (j, y) = place(&self.map_torque_nm, torque_nm.abs());
        let (low, high) = (&self.map_loss_w[i], &self.map_loss_w[i + 1]);
        let along = |row: &[f64]| row[j] + y * (row[j + 1] - row[j]);
        along(low) + x * (along(high) - along(low))
    }

    /// Power at the terminals, in W; negative where the motor gives back.
    pub fn terminals_w(&self, speed_radps: f64, torque_nm: f64) -> f64 {
        speed_radps * torque_nm + self.loss_w(speed_radps, torque_nm)
    }
}

/// The piece of a grid and the share of it at a place; held beyond the ends.
fn place(knots: &[f64], x: f64) -> (usize, f64) {
    let mut k = 0;
    while k + 2 < knots.len() && knots[k + 1] <= x {
        k += 1;
    }
    (k, ((x - knots[k]) / (knots[k + 1] - knots[k])).clamp(0.0, 1.0))
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
        let motor = motor();
        let loss = |w: f64, t: f64| motor.loss_w(w, t);
        assert_eq!((loss(0.0, 0.0), loss(200.0, 1000.0), loss(480.0, 2400.0)), (500.0, 10e3, 50e3));
        assert_eq!(loss(100.0, 500.0), (500.0 + 5e3 + 2e3 + 10e3) / 4.0);
        assert_eq!(loss(200.0, -1000.0), 10e3);
        assert_eq!((loss(1e9, 1e9), loss(-5.0, 0.0)), (50e3, 500.0));
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
}

//! How hard a driver brakes and accelerates for a change of the desired speed.
//!
//! Deceleration: one number of a driver. Acceleration: a law over speed and power to mass,
//! 1/a(v) = 1/a₀ + v m/(κ P). From rest the driver takes a₀; with speed it falls by the mass m over
//! a factor κ times the rated power P. Both are scaled by the driver's share, the a₀ that he has
//! drawn over the typical one. Without κ the acceleration is a₀ at every speed, as the paper has
//! it.
//!
//! The law has closed forms: g = 1/a grows along a rise as g² = g₀² + 2 t m/(κ P), and the way from
//! rest to v is v²/(2 a₀) + v³ m/(3 κ P).
//!
//! Decelerations and a₀ are log-normal, one draw a driver for each direction: the paper's law. Its
//! medians (1.16 down, 0.52 up, in m/s²) are those of the *largest* windows.

use crate::distribution::Quantity;
use crate::lanes::UNBOUNDED;
use crate::random::{Stream, Streams};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Statistical description of speed changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpeedChangeModel {
    /// Deceleration, as a positive number, in m/s².
    #[schemars(range(min = 0.05, max = 5.0))]
    pub deceleration_mps2: Quantity,
    /// Acceleration from rest, in m/s².
    #[schemars(range(min = 0.05, max = 5.0))]
    pub acceleration_mps2: Quantity,
    /// Factor on the rated power in the law of the acceleration over speed; the acceleration is the
    /// same at every speed where it is left out, and nearly so at 10 000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.05, max = 10_000.0))]
    pub acceleration_power_factor: Option<f64>,
    /// How the desired speed rises.
    pub rise: Rise,
    /// Desired speed at which a standing truck starts, in m/s.
    #[schemars(range(min = 0.5, max = 6.0))]
    pub launch_speed_mps: f64,
    /// The most that the accelerator pedal asks for, over the driver's acceleration; 100: no limit.
    #[schemars(range(min = 0.5, max = 100.0))]
    pub peak_acceleration_ratio: f64,
}

/// How the desired speed rises at a higher limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Rise {
    /// With the driver's acceleration.
    Ramp,
    /// At once, as in the paper.
    Paper,
}

/// One driver's accelerations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedChange {
    /// Deceleration, as a positive number, in m/s².
    pub deceleration_mps2: f64,
    /// Acceleration from rest, in m/s².
    pub acceleration_mps2: f64,
    /// Factor on the rated power in the law of the acceleration over speed; unbounded where the
    /// acceleration is the same at every speed.
    pub power_factor: f64,
    /// How the desired speed rises.
    pub rise: Rise,
    /// Desired speed at which a standing truck starts, in m/s.
    pub launch_speed_mps: f64,
    /// The most that the accelerator pedal asks for, over the driver's acceleration; unbounded
    /// where there is no limit.
    pub peak_ratio: f64,
}

/// Factor on the rated power with which the acceleration is the same at every speed but for some
/// 0.01 %.
pub const SAME_AT_EVERY_SPEED: f64 = 10_000.0;

/// Ratio of the peak acceleration from which on there is no limit.
const NO_PEAK_RATIO: f64 = 100.0;

impl SpeedChangeModel {
    /// Draws one driver; `spread` false gives the typical one.
    pub fn sample(&self, streams: &Streams, spread: bool) -> SpeedChange {
        let mut draws = streams.open(Stream::SpeedChange);
        let mut draw =
            |law: &Quantity| law.drawn_from(spread, streams, Stream::SpeedChange, &mut draws);
        let deceleration_mps2 = draw(&self.deceleration_mps2);
        let acceleration_mps2 = draw(&self.acceleration_mps2);
        let share = acceleration_mps2 / self.acceleration_mps2.centre();
        let ratio = self.peak_acceleration_ratio;
        SpeedChange {
            deceleration_mps2,
            acceleration_mps2,
            power_factor: self
                .acceleration_power_factor
                .map_or(UNBOUNDED, |typical| typical * share),
            rise: self.rise,
            launch_speed_mps: self.launch_speed_mps,
            peak_ratio: if ratio >= NO_PEAK_RATIO { UNBOUNDED } else { ratio },
        }
    }
}

impl SpeedChange {
    /// The driver's acceleration in a truck of some rated power, in W, and mass, in kg.
    pub fn acceleration(&self, rated_power_w: f64, mass_kg: f64) -> AccelerationLaw {
        let power_w = self.power_factor * rated_power_w;
        AccelerationLaw {
            from_rest: 1.0 / self.acceleration_mps2,
            per_mps: if self.power_factor < UNBOUNDED { mass_kg / power_w } else { 0.0 },
        }
    }
}

/// A driver's acceleration over the speed v, by its inverse 1/a = `from_rest` + v `per_mps`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AccelerationLaw {
    /// Inverse acceleration from rest, in s²/m.
    pub from_rest: f64,
    /// Its growth with the speed, in s³/m².
    pub per_mps: f64,
}

/// Steps of Newton's method: the error falls from 1e-1 to below 1e-15 in five, as it is squared in
/// each.
const NEWTON_STEPS: usize = 6;

impl AccelerationLaw {
    /// Acceleration at a speed in m/s, in m/s².
    pub fn at_mps2(&self, speed_mps: f64) -> f64 {
        1.0 / (self.from_rest + self.per_mps * speed_mps)
    }

    /// Square of the speed, in m²/s², some way behind a place where it was `squared`. The way from
    /// rest, v²/2 `from_rest` + v³/3 `per_mps`, is inverted by Newton's method, from above.
    pub fn squared_after(&self, squared: f64, way_m: f64) -> f64 {
        let constant = squared + 2.0 * way_m / self.from_rest;
        if self.per_mps == 0.0 || way_m <= 0.0 {
            return constant;
        }
        let way = |v: f64| v * v * (self.from_rest / 2.0 + v * self.per_mps / 3.0);
        let to_m = way(squared.sqrt()) + way_m;
        let mut v = constant.sqrt();
        for _ in 0..NEWTON_STEPS {
            v -= (way(v) - to_m) / (v * (self.from_rest + v * self.per_mps));
        }
        v * v
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_of_a_rise_add_up_and_follow_the_law() {
        let law = AccelerationLaw { from_rest: 1.0 / 0.9, per_mps: 0.21 };
        for way_m in [0.3, 20.0, 700.0] {
            let whole = law.squared_after(0.0, way_m);
            let halves = law.squared_after(law.squared_after(0.0, 0.4 * way_m), 0.6 * way_m);
            assert!((whole - halves).abs() < 1e-11 * whole, "{whole} {halves}");
            // d(v²)/ds = 2 a(v)
            let step_m = 1e-4 * way_m;
            let slope = (law.squared_after(whole, step_m) - whole) / step_m;
            let wanted = 2.0 * law.at_mps2(whole.sqrt());
            assert!((slope / wanted - 1.0).abs() < 1e-3, "{slope} {wanted}");
        }
        let constant = AccelerationLaw { from_rest: 2.0, per_mps: 0.0 };
        assert!(constant.squared_after(4.0, 10.0) == 14.0);
    }
}

//! Capability of an engine behind its gearbox: where its clutch may slip, what a body may take, its
//! rated speed, and how it brakes a truck that coasts.

use super::CombustionPowertrain;
use crate::lanes::one;

impl CombustionPowertrain {
    /// Accelerator from which on the engine drives at the speed of a slipping clutch. With less
    /// there is nothing to slip for.
    pub fn slips_from(&self, auxiliary_power_w: f64) -> f64 {
        let speed_radps = self.clutch.launch_radps;
        let drag_nm = self.engine.drag_nm(speed_radps);
        let reach_nm = self.engine.full_load_nm(speed_radps) - drag_nm;
        (auxiliary_power_w / speed_radps - drag_nm) / reach_nm
    }

    /// The most that the body can have beside auxiliaries of some power, in W.
    pub fn power_take_off_w(&self, auxiliary_power_w: f64) -> f64 {
        let speed_radps = self.engine_model.working_radps();
        (self.engine.full_load_nm(speed_radps) * speed_radps - auxiliary_power_w).max(0.0)
    }

    /// Drag of the retarder at the wheels at a speed in m/s, in N.
    pub fn retarder_n(&self, speed_mps: f64) -> f64 {
        self.gearbox.retarder_n(self.axle_per_m, speed_mps)
    }

    /// Speed of the engine at its highest power, in rad/s.
    pub fn rated_speed_radps(&self) -> f64 {
        let power = |w: f64| self.engine.full_load_nm(w) * w;
        let knots = self.engine_model.full_load_speed_radps.windows(2);
        // the power of a line of torque has one peak
        let places = knots.flat_map(|pair| {
            (0..=100).map(move |k| pair[0] + (pair[1] - pair[0]) * f64::from(k) / 100.0)
        });
        places.max_by(|a, b| power(*a).total_cmp(&power(*b))).unwrap_or(self.clutch.idle_radps)
    }

    /// Force at the wheels of a truck that coasts in top gear at a speed in m/s, in N: that of the
    /// engine's drag.
    pub fn coasting_force_n(&self, speed_mps: f64) -> f64 {
        let Some(gear) = self.gears.last() else { return 0.0 };
        let drag_nm = self.engine.drag_nm(gear.speed_ratio_per_m * speed_mps);
        let (per_m, share) = (one(gear.speed_ratio_per_m), one(gear.loss_share));
        let (speed, drag) = (one(speed_mps), one(drag_nm));
        self.losses.wheel_and_lost_forces_n(per_m, share, speed, drag)[0][0]
    }
}

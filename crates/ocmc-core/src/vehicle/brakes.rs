//! Service brakes and engine brake.
//!
//! The brake pedal asks for a deceleration b_p · 5 m/s² (the least that UN Regulation 13 asks of
//! service brakes) times the mass. The engine brake serves first, as far as it reaches, the service
//! brakes give the rest. Its power grows with the square of the engine speed, P = P₀ (w/w₀)² (a
//! Volvo VEB+ is said to give about 375 kW at 2300 rpm; recalled, not certain).
//!
//! Checked: both brakes are terms of the energy balance, which closes to 1e-9. Trucks arrive slowly
//! and stop at the line (`tests/it/closed_loop.rs`).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Brakes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BrakeModel {
    /// Deceleration at full pedal, in m/s².
    #[schemars(range(min = 0.5, max = 15.0))]
    pub full_deceleration_mps2: f64,
    /// Power of the engine brake at its reference speed, in W; 0 for none.
    #[schemars(range(min = 0.0, max = 2.0e6))]
    pub engine_brake_power_w: f64,
    /// Engine speed at which it has that power, in rad/s.
    #[schemars(range(min = 50.0, max = 1024.0))]
    pub engine_brake_speed_radps: f64,
}

impl BrakeModel {
    /// Engine-brake torque for each rad/s of engine speed, in Nm s.
    pub fn engine_brake_nms(&self) -> f64 {
        self.engine_brake_power_w / (self.engine_brake_speed_radps * self.engine_brake_speed_radps)
    }
}

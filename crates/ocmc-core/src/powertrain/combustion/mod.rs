//! Diesel: engine and fuel map, and the powertrain that they make with clutch and gearbox.

pub mod engine;
pub mod fuel_map;
mod inverse;
mod powertrain;

pub use powertrain::{DieselPowertrain, DieselStage, DieselState, PredictedTorque};

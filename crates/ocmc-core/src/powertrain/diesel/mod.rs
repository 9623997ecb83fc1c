//! Diesel: engine and fuel map.

pub mod engine;
pub mod fuel_map;

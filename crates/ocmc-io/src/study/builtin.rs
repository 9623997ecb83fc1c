//! The studies and vehicles that are part of the program.

/// The default study.
pub const FIELD_TRUCK: &str = include_str!("../../../../configs/field-truck.toml");
/// The default vehicle.
pub const TRACTOR_40T: &str = include_str!("../../../../configs/vehicles/tractor-40t.toml");

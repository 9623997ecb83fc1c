//! Powertrains: what turns fuel or charge into force at the wheels.

pub mod battery_electric;
mod bilinear;
pub mod diesel;
pub mod efficiency;
pub mod gearbox;
mod piece_table;

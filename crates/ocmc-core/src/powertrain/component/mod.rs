//! Components that powertrains are made of: a model of the study file, and the same prepared for
//! the hot loop.

pub mod ageing;
pub mod battery;
mod bilinear;
pub mod climate;
pub mod clutch;
pub mod engine;
pub mod fuel_map;
pub mod gearbox;
pub mod motor;
mod piece_table;
pub mod thermal;

//! The closed loop: lanes, one step, records and traces.

pub mod battery_electric;
pub mod cabin;
pub mod cpu;
pub mod diesel;
pub mod drive;
pub mod event;
pub mod record;
pub mod road_row;
pub mod state;
pub mod step;
pub mod step_view;
pub mod trace;
pub mod traction;

//! The closed loop: lanes, one step, records and traces.

mod alarm;
pub mod battery_electric;
mod books;
pub mod cabin;
mod change_of_mind;
mod control;
pub mod cpu;
pub mod diesel;
pub mod drive;
mod ending;
pub mod event;
mod lag;
pub mod record;
pub mod road_row;
mod stage;
pub mod state;
pub mod step;
mod step_length;
pub mod step_view;
pub mod trace;
pub mod traction;

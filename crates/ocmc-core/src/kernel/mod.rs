//! The closed loop: lanes, one step, records and traces.

mod accumulate;
pub mod battery_electric;
mod control;
pub mod cpu;
pub mod diesel;
mod first_order_lag;
mod lane_event;
pub mod lane_task;
pub mod pedal_event;
pub mod powertrain;
pub mod record;
pub mod road_row;
pub mod scheduler;
mod stage;
pub mod state;
pub mod step;
mod step_end;
mod step_length;
pub mod step_view;
mod switching_event;
pub mod trace;

//! The closed loop: lanes, one step, their events and traces.

mod accumulate;
mod charging_stops;
mod control;
pub mod cpu;
mod forecast;
pub mod lane_event;
pub mod lane_task;
mod look_ahead;
pub mod pedal_event;
mod rest_stops;
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

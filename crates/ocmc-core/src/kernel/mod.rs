//! The closed loop: lanes, one step, their events and traces.
//!
//! Checked: the mean absolute bias of the default study is below 0.05 % (`tests/it/step_bias.rs`).
//! The balance of 200 cycles of each built-in study closes to 1e-9, and a trace sums up to its
//! record exactly (`tests/it/energy_balance.rs`). Constant speed equals the closed form to 1e-6,
//! with second order on a smooth case (`tests/it/closed_form.rs`). No cycle of 10,000 of the
//! default study stalls (`tests/it/closed_loop.rs`). Each part that is turned off changes the
//! records in the right direction and leaves all other draws alone (`tests/it/parts.rs`). Bytes are
//! the same for 1, 2 and 8 threads, five chunk sizes and all CPU levels
//! (`tests/it/determinism.rs`).

mod accumulate;
pub mod chain;
mod charging_decision;
mod charging_stops;
mod control;
pub mod cpu;
mod forecast;
pub mod lane_event;
pub mod lane_task;
mod look_ahead;
mod marks;
mod parts;
pub mod pedal_event;
mod rest_decision;
mod rest_stops;
pub mod road_row;
pub mod scheduler;
mod stage;
pub mod state;
pub mod step;
mod step_end;
mod step_length;
pub mod step_view;
mod stop_ahead;
mod switching_event;
pub mod trace;
mod whole_trip;

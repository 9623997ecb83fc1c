//! One step of trucks side by side: their state, the driver's control, the two stages, where the
//! step ends, and what it adds to the ledger.

mod accumulate;
mod control;
mod event_flag;
mod forecast;
mod look_ahead;
pub mod one_step;
pub mod road_row;
mod stage;
pub mod state;
mod step_end;
mod step_length;
pub mod step_view;
mod switching_event;

pub use event_flag::{LaneEvent, ShiftLanes};

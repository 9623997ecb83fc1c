//! A truck on its trip: how it departs, what happens at stop lines, chargers, rests and marks of
//! its road, and the record of its arrival.

mod arrival;
mod charging_decision;
mod charging_site;
mod charging_stops;
mod departure;
mod lane_event;
pub mod lane_task;
mod marks;
mod parts;
mod rest_decision;
pub(crate) mod rest_stops;
mod standstill;
mod stop_ahead;

pub use departure::{InitialMotion, LastShift};

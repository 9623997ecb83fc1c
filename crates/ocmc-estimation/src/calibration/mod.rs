//! Laws behind observed tables: indirect inference.
//!
//! A table of measured speeds holds what a driver wanted and what signs, stops, traffic and
//! neighbouring bends made of it. [`curve_speed`] finds the law that, driven through a study, gives
//! the measured table back; [`root`] is the search.

pub mod curve_speed;
mod delta_method;
pub mod root;
mod simulated;

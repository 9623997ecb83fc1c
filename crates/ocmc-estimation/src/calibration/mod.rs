//! Laws behind observed tables: indirect inference.
//!
//! A table of measured speeds holds what a driver wanted and what signs, stops, traffic and
//! neighbouring bends made of it. [`curve_speed`] finds the law that, driven through a study, gives
//! the measured table back; [`root`] is the search. [`totals`] finds the judged numbers of a study
//! with which its trips take what those of a fleet took.

pub mod curve_speed;
mod delta_method;
pub mod root;
mod simulated;
pub mod totals;

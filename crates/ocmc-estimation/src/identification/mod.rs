//! From logs of single events to the gains of the driver who drove them.
//!
//! [`event::PedalLog`] is the log of an event as plain columns; [`identify::identify_event`] fits a
//! controller to it, with the truck of a study in closed loop ([`closed_loop`]) and least squares
//! within a box ([`bounded_least_squares`]). An event ends where something ahead may set the speed
//! ([`speed_ahead`]), and those of one truck are fitted together ([`one_truck`]).
//!
//! Checked in `tests/it/identification.rs` by smaller versions of the guide's tables, with late
//! drivers, a wrong mass and a noisy slope; `examples/identification_study.rs` makes the large
//! ones, and `tests/it/nist_nonlinear.rs` certifies the solver.

mod bias;
pub mod bounded_least_squares;
pub mod closed_loop;
mod comparison;
pub mod compass_search;
pub mod even_slope;
pub mod event;
mod fit_test;
pub mod identify;
mod noise;
pub mod one_truck;
pub mod options;
pub mod population;
mod problem;
mod profile_interval;
mod search;
pub mod speed_ahead;
mod truck_prior;
mod verdict;

//! Fleets: many cycles in parallel, and what they add up to.

pub mod run;

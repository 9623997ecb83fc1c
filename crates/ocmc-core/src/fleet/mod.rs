//! Fleets: many cycles in parallel, and what they add up to.

pub mod histogram;
pub mod quantile;
pub mod ratio;
pub mod run;
pub mod statistic;
pub mod summary;

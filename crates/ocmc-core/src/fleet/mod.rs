//! Fleets: many cycles in parallel, and what they add up to.

pub mod association;
pub mod charging;
pub mod comparison;
pub mod cost;
pub mod cost_difference;
pub mod dependence;
pub mod histogram;
pub mod kaplan_meier;
pub mod precision;
pub mod quantile;
pub mod quantity;
pub mod random_effects;
pub mod range;
pub mod ratio;
pub mod run;
pub mod sensitivity;
pub mod shapley;
pub mod size;
pub mod statistic;
pub mod summary;
pub mod truck_year;
pub mod uncertainty;
pub mod variance_share;

//! Fleets: many cycles in parallel, and what they add up to.
//!
//! Checked: small samples by hand, ranks of printed tables (median of 100: 40 and 61), exact
//! coverage of the intervals of quantiles never below 95 %, and simulated coverage within four
//! standard errors, for seeds 1, 2 and 3. `examples/uncertainty_coverage.rs` counts how often the
//! interval with uncertain numbers covers the truth of synthetic studies.

#![cfg_attr(
    test,
    allow(
        clippy::unwrap_used,
        clippy::float_cmp,
        clippy::disallowed_methods,
        reason = "tests fail by panic, compare bits, and compare with the platform's functions"
    )
)]

pub mod adjustment;
pub mod association;
pub mod bound;
pub mod charging;
pub mod clustering;
pub mod comparison;
pub mod components;
pub mod cost;
pub mod cost_difference;
pub mod dependence;
pub mod doubt;
pub mod histogram;
pub mod kaplan_meier;
pub mod load;
mod outcomes;
mod outline_sample;
mod pair;
pub mod parts;
pub mod precision;
pub mod quantile;
pub mod quantity;
pub mod random_effects;
pub mod range;
pub mod ratio;
pub mod route_summary;
pub mod run;
pub mod sensitivity;
pub mod shapley;
pub mod size;
pub mod statistic;
pub mod summary;
pub mod sweep;
pub mod training;
pub mod truck_arrivals;
pub mod truck_column;
pub mod truck_year;
pub mod uncertainty;
pub mod variance_share;

/// The statistics of the integration tests.
#[cfg(test)]
#[path = "../../ocmc-core/tests/it/common/statistics.rs"]
#[allow(dead_code, reason = "the integration tests use the rest")]
mod statistics;

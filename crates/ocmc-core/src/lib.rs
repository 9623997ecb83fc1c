//! Pure models and engine of `ocmc`: a study is sampled into scenarios, each scenario is planned
//! into a speed profile, driven in closed loop into a record, and the records are summed up into
//! fleet answers.
//!
//! Nothing here reads files, prints, logs or looks at a clock; everything random is a pure function
//! of (seed, cycle id, stream). SI units, with the unit in the name.

#![cfg_attr(
    test,
    allow(
        clippy::unwrap_used,
        clippy::float_cmp,
        clippy::disallowed_methods,
        reason = "tests fail by panic, compare bits, and compare with the platform's functions"
    )
)]

pub mod breakdown;
pub mod charging;
pub mod cost;
mod crest;
pub mod distribution;
pub mod driver;
pub mod energy;
pub mod event_kind;
pub mod first_order_lag;
pub mod kernel;
pub mod lanes;
pub mod operating_cycle;
pub mod powertrain;
pub mod prescribed;
pub mod random;
pub mod record;
pub mod rest;
pub mod special_functions;
pub mod study;
pub mod switch;
pub mod tactical;
pub mod validation;
pub mod vehicle;

/// The statistics of the integration tests.
#[cfg(test)]
#[path = "../tests/it/common/statistics.rs"]
#[allow(dead_code, reason = "the integration tests use the rest")]
mod statistics;
#[cfg(test)]
mod testing;

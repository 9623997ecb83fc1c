//! Pure models and engine of `ocmc`: a study is sampled into scenarios, each scenario is planned
//! into a speed profile, driven in closed loop into a record, and the records are summed up into
//! fleet answers.
//!
//! Nothing here reads files, prints, logs or looks at a clock; everything random is a pure function
//! of (seed, cycle id, stream). SI units, with the unit in the name.
//!
//! Who asks questions of studies, as the command does, uses the crate `ocmc-api`: it reads studies,
//! drives them and answers. This crate is for who wants the models themselves:
//!
//! ```
//! use ocmc_core::distribution::Law;
//! use ocmc_core::vehicle::resistance::drag_force_n;
//!
//! // half the density of air, a truck at 80 km/h without wind, its drag area
//! let force_n = drag_force_n(0.5 * 1.225, 80.0 / 3.6, 0.0, 5.5);
//! assert!((force_n - 1663.6).abs() < 0.1);
//! // half of the gaps between stops are shorter than this
//! let gap_m = Law::Exponential { mean: 450.0 }.quantile(0.5);
//! assert_eq!(gap_m.map(f64::round), Some(312.0));
//! ```

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
pub mod threads;
pub mod validation;
pub mod vehicle;

#[cfg(test)]
extern crate self as ocmc_core;
/// An engine.
#[cfg(test)]
#[path = "../tests/it/common/engine_b.rs"]
mod engine_b;
/// The statistics of the integration tests.
#[cfg(test)]
#[path = "../tests/it/common/statistics.rs"]
#[allow(dead_code, reason = "the integration tests use the rest")]
mod statistics;
#[cfg(test)]
mod testing;

//! VECTO beside `ocmc`: its driver as a planner, its files, and what is computed here compared
//! with what it found.

#![cfg_attr(
    test,
    allow(
        clippy::unwrap_used,
        clippy::float_cmp,
        clippy::disallowed_methods,
        reason = "tests fail by panic, compare bits, and compare with the platform's functions"
    )
)]

pub mod comparison;
pub mod driver;
pub mod file;

/// An engine of the core's tests.
#[cfg(test)]
#[path = "../../ocmc-core/tests/it/common/engine_b.rs"]
mod engine_b;

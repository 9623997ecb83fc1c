//! Tests of ocmc-fleet: one executable.
#![allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a test fails by panic, compares bits, prints its figures, and has functions of the \
              platform"
)]

#[path = "../../../ocmc-core/tests/it/common/mod.rs"]
#[allow(dead_code, reason = "the tests of the core use the rest")]
mod common;
mod cost;

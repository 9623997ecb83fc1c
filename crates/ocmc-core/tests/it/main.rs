//! Tests of ocmc-core: one executable.
#![allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    clippy::print_stdout,
    reason = "a test fails by panic, compares bits, and prints its figures"
)]

mod common;
mod outside_facts;
mod sampled;
mod value_stability;

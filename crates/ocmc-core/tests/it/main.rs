//! Tests of ocmc-core: one executable.
#![allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a test fails by panic, compares bits, prints its figures, and has functions of the \
              platform"
)]

mod common;
#[path = "../../../../tests/it/others_data.rs"]
mod others_data;
mod outside_facts;
mod rest;
mod sampled;
mod value_stability;

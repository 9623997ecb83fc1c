//! Tests of ocmc-io: one executable.
#![allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    clippy::print_stdout,
    reason = "a test fails by panic, compares bits, and prints its figures"
)]

mod fuzzed_readers;
mod reference;
mod simulator_routes;
mod study_builtin;
mod study_errors;
mod study_mutation;
mod table_names;
mod table_reading;
mod table_reference;
mod table_sources;

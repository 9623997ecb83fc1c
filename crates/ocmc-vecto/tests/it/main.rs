//! Tests of ocmc-vecto: one executable.
#![allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    clippy::print_stdout,
    reason = "a test fails by panic, compares bits, and prints its figures"
)]

mod jobs;
#[path = "../../../../tests/it/others_data.rs"]
mod others_data;

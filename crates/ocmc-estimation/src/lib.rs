//! From measurements to the laws of a study: estimators of `ocmc`, over plain columns.
//!
//! [`fit`] turns measured curves, speed changes, traffic counts, weather and roads into laws with
//! their intervals; [`log`] finds curves and roads in the time series of a drive;
//! [`identification`] finds the gains of a driver; [`calibration`] finds the law behind a table
//! that traffic, signs and stops had a part in; [`validation`] lays measured drives over simulated
//! ones. Nothing here reads files or prints; the engine that simulates is `ocmc-core`.

#![cfg_attr(
    test,
    allow(
        clippy::unwrap_used,
        clippy::float_cmp,
        clippy::disallowed_methods,
        reason = "tests fail by panic, compare bits, and compare with the platform's functions"
    )
)]

pub mod calibration;
pub mod fit;
pub mod identification;
pub mod log;
mod moments;
pub mod option_check;
pub mod validation;

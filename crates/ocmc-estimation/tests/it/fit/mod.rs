//! Fits beside printed tables: the paper's, NIST's certified values, and a published mixed model.

mod clustered_error;
mod coverage;
mod field_table;
mod fleet;
mod joint_estimates;
mod nist;
mod operating_cycle;
mod plain_log;
mod selection;
mod simulator_table;
mod sleepstudy;
mod traffic;
mod weather;

use crate::others_data;
use std::fs;

/// The text of a file of the data of others; none, with a note, where it is absent.
fn shared(path: &str) -> Option<String> {
    Some(fs::read_to_string(others_data::shared(path)?).unwrap())
}

/// Fails where a number, rounded as it was printed, is not what was printed.
#[track_caller]
fn assert_prints(what: &str, value: f64, printed: &str) {
    let digits = printed.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let text = format!("{value:.digits$}");
    let text = if text.parse::<f64>().unwrap() == 0.0 { text.replace('-', "") } else { text };
    assert_eq!(text, printed, "{what}: {value}");
}

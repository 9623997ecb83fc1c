//! Fits beside printed tables: the paper's, NIST's certified values, and a published mixed model.

mod clustered_error;
mod coverage;
mod field_table;
mod fleet;
mod nist;
mod operating_cycle;
mod simulator_table;
mod sleepstudy;
mod traffic;
mod weather;

use std::fs;
use std::path::{Path, PathBuf};

/// A file of the shared data; none, with a message, where it is absent.
fn shared(path: &str) -> Option<String> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("OCMC_DATA").map_or_else(beside, PathBuf::from);
    let file = folder.join(path);
    let text = fs::read_to_string(&file).ok();
    if text.is_none() {
        println!("SKIPPED: {} is absent", file.display());
    }
    text
}

/// Fails where a number, rounded as it was printed, is not what was printed.
#[track_caller]
fn assert_prints(what: &str, value: f64, printed: &str) {
    let digits = printed.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let text = format!("{value:.digits$}");
    let text = if text.parse::<f64>().unwrap() == 0.0 { text.replace('-', "") } else { text };
    assert_eq!(text, printed, "{what}: {value}");
}

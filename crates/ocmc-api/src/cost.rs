//! What an answer has cost, in words.

use ocmc_io::number_text::{rough, short};

/// The line about it.
pub(crate) fn took(wall_s: f64, threads: usize, cycles: u64) -> String {
    let rate = rough(cycles as f64 / wall_s);
    format!("{:<10} {} s on {}: {rate} cycles/s\n", "took", short(wall_s), threads_text(threads))
}

/// So many threads.
pub(crate) fn threads_text(threads: usize) -> String {
    if threads == 1 { "1 thread".to_owned() } else { format!("{threads} threads") }
}

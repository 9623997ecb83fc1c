//! What `ocmc` reads and writes: study files, logs, records, run directories and reports.

pub mod delimited;
pub mod drive_cycle;
pub mod given_cycle;
pub mod operating_cycle;
pub mod records;
pub mod run_directory;
pub mod run_summary;
pub mod study;
pub mod table;

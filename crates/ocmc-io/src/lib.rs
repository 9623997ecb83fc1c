//! What `ocmc` reads and writes: study files, logs, records and reports.

pub mod study;

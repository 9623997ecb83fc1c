//! What `ocmc` reads and writes: study files, logs, records, run directories and reports.

pub mod ambiguous_columns;
pub mod clock_column;
pub mod column_file;
pub mod curve_table;
pub mod delimited;
pub mod drive_cycle;
pub mod file_error;
pub mod given_cycle;
pub mod given_drive;
pub mod given_table;
pub mod label;
pub mod log;
pub mod number_text;
pub mod operating_cycle;
pub mod records;
pub mod report;
pub mod run_directory;
pub mod run_summary;
pub mod shell_word;
pub mod speed_change_table;
pub mod study;
pub mod table;
mod text_file;
pub mod traffic_table;
pub mod weather_table;

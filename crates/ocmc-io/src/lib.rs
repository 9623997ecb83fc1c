//! What `ocmc` reads and writes: study files, logs, records, run directories and reports.

pub mod charging_table;
pub mod curve_table;
pub mod drive_cycle;
pub mod file_error;
pub mod fleet_table;
pub mod given_cycle;
pub mod given_drive;
mod input_file;
pub mod label;
pub mod log;
pub mod loss_law;
pub mod number_text;
pub mod operating_cycle;
pub mod part_table;
pub mod printable;
pub mod records;
pub mod report;
pub mod run_directory;
pub mod sha256;
pub mod shell_word;
pub mod speed_change_table;
pub mod study;
pub mod table;
mod table_file;
pub mod traffic_table;
pub mod trucks;
pub mod weather_table;

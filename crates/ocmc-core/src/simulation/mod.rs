//! The closed loop: lanes, one step, records and traces.

pub mod cpu;
pub mod drive;
pub mod record;

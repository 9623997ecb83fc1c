//! How trips are driven: lanes of one CPU level, the scheduler that refills them, trips in a chain,
//! whole trips, traces, and events of a drive.

pub mod chain;
pub mod cpu;
pub mod pedal_event;
pub mod scheduler;
pub mod trace;
mod whole_trip;

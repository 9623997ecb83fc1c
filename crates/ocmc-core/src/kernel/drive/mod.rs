//! How trips are driven: lanes of one CPU level, the scheduler that refills them, trips in a chain,
//! whole trips, traces, and events of a drive.

pub mod chain;
pub mod cpu;
mod observer;
pub mod pedal_event;
mod rolling_truck;
pub mod scheduler;
pub mod trace;
mod trace_writer;
mod whole_trip;

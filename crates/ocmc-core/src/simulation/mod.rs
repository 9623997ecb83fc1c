//! The closed loop: lanes, one step, records and traces.

pub mod record;

//! Checks of all input. A reader takes a file into quantities ([`table`]); checks look at
//! quantities, whatever the command; the account says what was read, what was left out and what is
//! odd.
//!
//! A check is a name, a figure that it compares with a bound, a remedy, and an end: it refuses,
//! warns, or mends and says so. Its file has the check and its tests: to add one, write a file, or
//! add it to the list of its kind.

pub mod account;
pub mod contradiction;
pub mod curve;
pub mod drawn;
pub mod drift;
pub mod finding;
pub(crate) mod format;
pub mod fuel_map;
pub mod high_altitude;
pub mod jump;
pub mod lacks;
pub mod limit_unit;
pub mod sampling;
pub mod scatter;
pub mod slope;
pub mod spacing;
pub mod sparse_altitudes;
pub mod study_value;
pub mod table;
pub mod trip;
pub mod unlike_a_road;
pub mod unused_column;
pub mod values;

pub use account::{Extent, FileAccount};
pub use finding::{End, Finding};

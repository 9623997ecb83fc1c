//! VECTO's own files: a job (`.vecto`) with its vehicle, engine, gearbox and driver, missions
//! (`.vdri`), and what VECTO found (`.vmod` by the second, `.vsum` in sums).
//!
//! Files of VECTO 2.2 and of its successors until 2016 are read. They are JSON and tables of
//! separated cells, with names of other files in them; blanks in names may be written as `_`.

mod driver;
mod error;
mod gearbox;
mod job;
mod mission;
mod part;
mod result;
mod vehicle;
pub mod vmod;

pub use driver::declared_driver;
pub use error::VectoError;
pub use job::{Job, VEHICLES};
pub use mission::MissionFile;
pub use result::{Second, Series, Sum, read_series, read_sums};

//! VECTO's own files: a job (`.vecto`) with its vehicle, engine, gearbox and driver, missions
//! (`.vdri`), and what VECTO found (`.vmod` by the second, `.vsum` in sums).
//!
//! Files of VECTO 2 and 3 are read where they are JSON and tables of separated cells, with names of
//! other files in them; blanks in names may be written as `_`. What is not computed here is refused
//! by its name, and what is left out is said ([`Job::notes`]).

mod driver;
mod engine;
mod error;
mod gearbox;
mod job;
mod kind;
mod mission;
mod part;
mod result;
mod tyre;
mod vehicle;
pub mod vmod;

pub use driver::declared_driver;
pub use error::VectoError;
pub use job::{Job, VEHICLES};
pub use mission::MissionFile;
pub use result::{Second, Series, Sum, read_series, read_sums};

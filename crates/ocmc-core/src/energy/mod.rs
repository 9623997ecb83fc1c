//! Energy: the carriers that trucks store, what they emit, and the ledger of what is integrated
//! over a cycle.

pub mod carrier;
pub mod emission_model;
pub mod ledger;

pub use carrier::Carrier;

//! Energy: the carriers that trucks store, and the ledger of what is integrated over a cycle.

pub mod carrier;
pub mod ledger;

pub use carrier::Carrier;

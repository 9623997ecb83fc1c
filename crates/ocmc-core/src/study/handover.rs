//! State that a truck and its drivers bring from the trips before, where trips of a truck chain.

use crate::rest::DutyClock;

/// State at the beginning of a trip, and after it.
#[derive(Clone, Debug, PartialEq)]
pub struct Handover {
    /// State of charge up to which the depot charges: what the trip would have departed with by
    /// itself.
    pub full_charge: Option<f64>,
    /// The clock of its driver; none where he has not driven a trip of this truck, or has no law to
    /// keep.
    pub clock: Option<DutyClock>,
    /// Time from its departure to the next one of the truck, in s; none behind the last trip.
    pub next_departure_s: Option<f64>,
}

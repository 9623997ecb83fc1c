//! Rests of drivers: the table of a study, the laws, and the clock of duty.

pub mod clock;
pub mod law;

pub use clock::{Activity, DutyClock, Rest};
pub use law::RestLaw;

use crate::distribution::Quantity;
use crate::random::{Stream, Streams};
use crate::validation::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Place of the draw among those of the departure.
const PLACE: u64 = 16;

/// Rests that the law asks of drivers. Absent: none are taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RestModel {
    /// Law that the drivers follow.
    pub law: RestLaw,
    /// Drivers on the truck: 2 take turns, the other sits beside.
    #[schemars(range(min = 1.0, max = 2.0))]
    #[serde(default = "one")]
    pub drivers: u32,
    /// Time that the first driver has driven at departure since his daily rest, without a break, in
    /// s; who may drive on for less than five minutes has rested before.
    #[schemars(range(min = 0.0, max = 28_800.0))]
    #[serde(default = "none")]
    pub driven_before_s: Quantity,
}

fn one() -> u32 {
    1
}

fn none() -> Quantity {
    Quantity::Number(0.0)
}

impl RestModel {
    /// Rules between its keys.
    pub fn validate(&self, problems: &mut Problems) {
        let limit_s = self.law.rules(self.drivers).driving_s;
        let (_, most_s) = self.driven_before_s.practical_range();
        let allowed = format!("0 to {limit_s}: what the law allows without a break");
        problems.require(most_s <= limit_s, "driven_before_s", most_s, &allowed);
    }

    /// Draws what has been driven at departure, in s.
    pub fn sample(&self, streams: &Streams) -> f64 {
        let stream = Stream::Departure;
        self.driven_before_s.sample_once(streams, stream, streams.open(stream).at(PLACE))
    }
}

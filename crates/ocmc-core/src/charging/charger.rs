//! Public chargers along the way: their law, and the chargers that one trip meets. They belong to
//! the operating cycle: neither driver nor truck move them.

use super::queue::QueueModel;
use crate::distribution::Quantity;
use crate::random::{Stream, Streams};
use crate::validation::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Chargers that a law draws closer than this are moved apart, in m.
const MINIMUM_SPACING_M: f64 = 100.0;
/// Room of a charger beside other events, and to the ends of the road, in m.
const ROOM_M: f64 = 5.0;
/// Places of the draws of one charger.
const PLACES: u64 = 4;

/// Chargers along the way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublicChargerModel {
    /// Distance from one site to the next, in m; either this or `positions_m`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Quantity", range(min = 0.0, max = 5.0e6))]
    pub spacing_m: Option<Quantity>,
    /// Where the sites of a road are whose length is given, in m, rising.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(inner(range(min = 0.0, max = 5.0e6)))]
    pub positions_m: Vec<f64>,
    /// Power of a charger at the meter, in W; a law is drawn for each site.
    #[schemars(range(min = 1000.0, max = 1.0e7))]
    pub power_w: Quantity,
    /// Share of the sites that can be used; who plans a trip knows which. Absent: all.
    #[serde(default = "one")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub available_share: f64,
    /// Wait for a free charger, in s; absent: none, where there is no `queue`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Quantity", range(min = 0.0, max = 86_400.0))]
    pub wait_s: Option<Quantity>,
    /// The queue that the wait is of, instead of `wait_s`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub queue: Option<QueueModel>,
    /// State of charge at which charging ends.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub end_at: f64,
    /// Charging ends where less is enough; absent: at `end_at`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub enough: Option<EnoughModel>,
}

/// When a battery is charged enough.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EnoughModel {
    /// Goal that has to be reached with the reserve.
    pub reach: Goal,
    /// Charge beyond the driver's forecast, `[charging.forecast]` with its margin, over the way.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub margin: f64,
}

/// Goal of a truck that leaves a charger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Goal {
    /// The end of the trip.
    Destination,
    /// The next charger that can be used, or the end of the trip.
    NextCharger,
}

fn one() -> f64 {
    1.0
}

/// A site with a charger that can be used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Charger {
    /// Where it is, in m.
    pub position_m: f64,
    /// Its power at the meter, in W.
    pub power_w: f64,
    /// Wait before it is free, in s.
    pub wait_s: f64,
}

impl PublicChargerModel {
    /// Either a spacing or positions, and either a wait or a queue.
    pub fn validate(&self, problems: &mut Problems) {
        let one_place = self.spacing_m.is_some() == self.positions_m.is_empty();
        let presence = if self.spacing_m.is_some() { "given, too" } else { "absent" };
        let allowed = "one of `spacing_m` and `positions_m`";
        problems.require(one_place, "positions_m", presence, allowed);
        let rises = self.positions_m.windows(2).all(|pair| pair[0] + MINIMUM_SPACING_M <= pair[1]);
        let shown = format!("{:?}", self.positions_m);
        problems.require(rises, "positions_m", shown, "positions that rise, 100 m apart");
        if let Some(Quantity::Number(spacing_m)) = &self.spacing_m {
            let allowed = "100 to 5000000; the draws of a law below 100 are put there";
            problems.require(*spacing_m >= MINIMUM_SPACING_M, "spacing_m", spacing_m, allowed);
        }
        let one_wait = self.wait_s.is_none() || self.queue.is_none();
        problems.require(one_wait, "queue", "given beside `wait_s`", "one of the two");
        problems.part_if("queue", self.queue.as_ref(), QueueModel::validate);
    }

    /// A given site beyond the end of a road, in m.
    pub fn beyond(&self, length_m: f64) -> Option<f64> {
        self.positions_m.iter().copied().find(|at_m| *at_m >= length_m)
    }

    /// Refuses a site beyond the end of a road.
    pub fn require_within(&self, length_m: f64, problems: &mut Problems) {
        if let Some(beyond_m) = self.beyond(length_m) {
            let allowed = format!("below {length_m}, the length of the road");
            problems.require(false, "positions_m", beyond_m, &allowed);
        }
    }

    /// Draws the sites of a road that can be used. Each keeps its draws whatever the laws of the
    /// others are. `events_m`: where other events are, in order; a site moves before them.
    pub fn sample(&self, length_m: f64, events_m: &[f64], streams: &Streams) -> Vec<Charger> {
        let mut draws = streams.open(Stream::Charger);
        let (mut chargers, mut next_m): (Vec<Charger>, f64) = (Vec::new(), 0.0);
        for k in 0_u64.. {
            next_m = match (&self.spacing_m, self.positions_m.get(k as usize)) {
                (Some(spacing_m), _) => {
                    next_m + spacing_m.sample(draws.at(PLACES * k)).max(MINIMUM_SPACING_M)
                }
                (None, Some(position_m)) => *position_m,
                (None, None) => break,
            };
            if next_m >= length_m {
                break;
            }
            let power_w = self.power_w.sample(draws.at(PLACES * k + 1));
            let is_available = draws.at(PLACES * k + 2).uniform() < self.available_share;
            let wait = draws.at(PLACES * k + 3);
            let wait_s = match (&self.queue, &self.wait_s) {
                (Some(queue), _) => queue.sample(wait),
                (None, Some(wait_s)) => wait_s.sample(wait),
                (None, None) => 0.0,
            };
            let position_m = beside(next_m.min(length_m - ROOM_M), events_m);
            if is_available && position_m >= ROOM_M {
                chargers.push(Charger { position_m, power_w, wait_s });
            }
        }
        chargers.dedup_by(|next, before| next.position_m <= before.position_m);
        chargers
    }
}

/// The place at or before a position that has room beside events in order.
fn beside(position_m: f64, events_m: &[f64]) -> f64 {
    events_m.iter().rev().fold(position_m, |place_m, event_m| {
        if (event_m - place_m).abs() < ROOM_M { event_m - ROOM_M } else { place_m }
    })
}

//! Charging: where trucks are charged, with what power, and what reserve their drivers keep.

pub mod charger;
pub mod curve;
pub mod event;
pub mod forecast;
pub mod queue;

pub use charger::{Charger, EnoughModel, Goal, PublicChargerModel};
pub use curve::ChargeCurve;
pub use event::{ChargeCourse, ChargingEvent, ChargingPlace};
pub use forecast::{Driven, ForecastModel};

use crate::validation::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Charging of battery trucks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChargingPolicy {
    /// State of charge that drivers keep. Where there are no public chargers a truck stops below
    /// it, else below the battery's own `minimum_charge`: a wrong forecast uses the reserve.
    #[schemars(range(min = 0.0, max = 0.9))]
    pub reserve: f64,
    /// Efficiency of chargers, from the meter to the battery's terminals.
    #[schemars(range(min = 0.5, max = 1.0))]
    pub efficiency: f64,
    /// Time in which the plug is put in and taken out, in s; absent: none.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub connection_s: f64,
    /// The most power that the battery takes by its state of charge, beside its own limits; absent:
    /// those alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curve: Option<ChargeCurve>,
    /// How drivers forecast whether they reach the next charger; absent where there is no `public`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub forecast: Option<ForecastModel>,
    /// Charging after the trip; absent: it is not looked at.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depot: Option<DepotModel>,
    /// Chargers along the way; absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub public: Option<PublicChargerModel>,
    /// Charging at stops of the mission; absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop: Option<StopChargerModel>,
}

/// Charging in the depot, once the trip has ended, up to the charge at departure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DepotModel {
    /// Power of a charger at the meter, in W.
    #[schemars(range(min = 1000.0, max = 1.0e7))]
    pub power_w: f64,
    /// Time from arrival to the next departure, in s.
    #[schemars(range(min = 0.0, max = 604_800.0))]
    pub parked_s: f64,
}

/// Charging at stops of the mission.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StopChargerModel {
    /// Power of the charger at the meter, in W.
    #[schemars(range(min = 1000.0, max = 1.0e7))]
    pub power_w: f64,
    /// State of charge below which a stop is used to charge.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub begin_below: f64,
    /// State of charge at which charging ends.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub end_at: f64,
    /// Shortest standstill that is used, in s.
    #[schemars(range(min = 0.0, max = 86_400.0))]
    pub shortest_s: f64,
}

impl ChargingPolicy {
    /// Rules between its keys.
    pub fn validate(&self, problems: &mut Problems) {
        problems.part_if("curve", self.curve.as_ref(), ChargeCurve::validate);
        let reserve = self.reserve;
        let ends = |end_at: f64, problems: &mut Problems| {
            let allowed = format!("above `charging.reserve`, which is {reserve}");
            problems.require(end_at > reserve, "end_at", end_at, &allowed);
        };
        let presence = if self.forecast.is_some() { "given" } else { "absent" };
        let is_known = self.public.is_none() || self.forecast.is_some();
        let allowed = "a table beside `charging.public`, as in `electric-long-haul`";
        problems.require(is_known, "forecast", presence, allowed);
        problems.part_if("public", self.public.as_ref(), |public, problems| {
            ends(public.end_at, problems);
            public.validate(problems);
        });
        problems.part_if("stop", self.stop.as_ref(), |stop, problems| ends(stop.end_at, problems));
    }
}

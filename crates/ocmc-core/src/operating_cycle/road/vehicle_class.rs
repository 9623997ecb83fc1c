//! Classes of vehicles, as far as the law of the road tells them apart.

use super::RoadTypeModel;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Class of a vehicle: which limits hold for it beside the signs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum VehicleClass {
    /// A goods vehicle above 3.5 t.
    #[default]
    Truck,
    /// A bus or coach.
    Coach,
    /// A goods vehicle up to 3.5 t: the signs alone.
    Van,
    /// A passenger car: the signs alone.
    Car,
}

impl VehicleClass {
    /// Whether it is what holds where a vehicle does not say it.
    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde lends the value")]
    pub(crate) fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Limit of the law on a road type beside the signs, in m/s; infinite where there is none.
    pub fn limit_mps(self, road_type: &RoadTypeModel) -> f64 {
        let limit = match self {
            Self::Truck => road_type.truck_limit_mps,
            Self::Coach => road_type.coach_limit_mps,
            Self::Van | Self::Car => None,
        };
        limit.unwrap_or(f64::INFINITY)
    }
}

impl fmt::Display for VehicleClass {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Truck => "truck",
            Self::Coach => "coach",
            Self::Van => "van",
            Self::Car => "car",
        })
    }
}

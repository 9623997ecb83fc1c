//! Models that a study turns off, to see what each of them does. A switch moves no draw of another
//! model.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A model that is turned off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ModelSwitch {
    /// A flat road.
    Slope,
    /// A straight road, without junction turns.
    Curves,
    /// No signs: 130 km/h, so that only the truck's limits hold. Curves still follow the drawn
    /// signs.
    Signs,
    /// No stop signs.
    StopSigns,
    /// No give-way signs.
    GiveWays,
    /// No traffic lights.
    TrafficLights,
    /// No speed bumps.
    SpeedBumps,
    /// No railway crossings.
    RailwayCrossings,
    /// Still, dry air at 15 °C.
    Weather,
    /// No other vehicles.
    Traffic,
    /// Every truck carries the mean payload.
    PayloadSpread,
    /// Every driver is the typical one, without residuals.
    DriverSpread,
    /// Every truck is the typical one.
    VehicleSpread,
}

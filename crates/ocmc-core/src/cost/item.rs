//! Items of a cost.

use serde::Serialize;

/// One item of a cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Item {
    /// Fuel.
    Fuel,
    /// Electricity in the depot: what the trips took from the battery, less what was charged on the
    /// way.
    DepotCharging,
    /// Electricity at stops on the way.
    PublicCharging,
    /// Driver.
    Driver,
    /// Tolls.
    Toll,
    /// Maintenance, repair, tyres.
    Maintenance,
    /// Payload that could not be carried.
    LostPayload,
    /// Purchase of the truck without what is listed apart.
    Purchase,
    /// Tank.
    Tank,
    /// Plug or charger.
    Charger,
    /// Engine.
    Engine,
    /// Motor and power electronics.
    Motor,
    /// Battery.
    Battery,
    /// Worth of the truck at the end, negative.
    Residual,
    /// Insurance and what else is paid by time.
    Insurance,
}

impl Item {
    /// All items, in the order in which they are shown.
    pub const ALL: [Self; 15] = [
        Self::Fuel,
        Self::DepotCharging,
        Self::PublicCharging,
        Self::Driver,
        Self::Toll,
        Self::Maintenance,
        Self::LostPayload,
        Self::Purchase,
        Self::Tank,
        Self::Charger,
        Self::Engine,
        Self::Motor,
        Self::Battery,
        Self::Residual,
        Self::Insurance,
    ];

    /// Its name in answers.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fuel => "fuel",
            Self::DepotCharging => "depot_charging",
            Self::PublicCharging => "public_charging",
            Self::Driver => "driver",
            Self::Toll => "toll",
            Self::Maintenance => "maintenance",
            Self::LostPayload => "lost_payload",
            Self::Purchase => "purchase",
            Self::Tank => "tank",
            Self::Charger => "charger",
            Self::Engine => "engine",
            Self::Motor => "motor",
            Self::Battery => "battery",
            Self::Residual => "residual",
            Self::Insurance => "insurance",
        }
    }
}

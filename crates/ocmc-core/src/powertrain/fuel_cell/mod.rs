//! A fuel-cell truck: motor and battery of a battery-electric one, and a fuel cell with its tank
//! that feed them.
//!
//! The cell follows the mean demand and brings the battery back to a target of its charge
//! ([`split`]). It takes hydrogen by the lower convex envelope of its map ([`cell`]).
//!
//! Checked: the energy balance closes to 1e-9, hydrogen is what the map says of the cell's power,
//! the battery stays near its target, and the consumption at 40 t on VECTO's LongHaul lies among
//! published ones (`tests/it/fuel_cell.rs`).

pub mod cell;
mod inverse;
mod powertrain;
pub mod split;

pub use powertrain::{FuelCellPowertrain, FuelCellState};

use super::battery_electric::ElectricModel;
use crate::validation::Problems;
use cell::CellModel;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use split::SplitModel;

/// A fuel-cell powertrain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FuelCellModel {
    /// Motor, gears and battery.
    pub electric: ElectricModel,
    /// Fuel cell.
    pub cell: CellModel,
    /// Split of the demand between fuel cell and battery.
    pub split: SplitModel,
    /// Hydrogen that the tank gives, in kg.
    #[schemars(range(min = 0.1, max = 1000.0))]
    pub usable_hydrogen_kg: f64,
}

impl FuelCellModel {
    /// Parts that fit in themselves and to each other.
    pub fn validate(&self, problems: &mut Problems) {
        problems.part("electric", |problems| self.electric.validate(problems));
        problems.part("cell", |problems| self.cell.validate(problems));
        let battery = &self.electric.battery;
        let range = battery.minimum_charge..=battery.maximum_charge;
        problems.require(
            range.contains(&self.split.target_charge),
            "split.target_charge",
            self.split.target_charge,
            "between the lowest and the highest charge of the battery",
        );
        problems.require(
            battery.thermal.is_none(),
            "electric.battery.thermal",
            "there",
            "absent: the battery of a fuel-cell truck has no temperature yet",
        );
    }

    /// The most that tank and battery give, in J.
    pub fn usable_j(&self) -> f64 {
        let battery = &self.electric.battery;
        self.usable_hydrogen_kg * self.cell.heating_value_jpkg
            + battery.capacity_j * (self.split.target_charge - battery.minimum_charge)
    }
}

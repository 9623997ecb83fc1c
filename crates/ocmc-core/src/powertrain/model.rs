//! The powertrain of a study's trucks, as its file says it.

use super::PowertrainKind;
use super::battery_electric::{BatteryElectricPowertrain, ElectricModel};
use super::combustion::{CombustionModel, CombustionPowertrain};
use super::component::battery::BatteryModel;
use super::component::gearbox::{Gear, ShiftModel};
use super::fuel_cell::{FuelCellModel, FuelCellPowertrain};
use crate::distribution::Quantity;
use crate::energy::Carrier;
use crate::random::{Stream, Streams};
use crate::validation::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parts of a truck that are priced by their sizes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sizes {
    /// Largest power at the points of the engine's full load, in kW; none without an engine.
    pub engine_kw: Option<f64>,
    /// Power of the motor, in kW; none without one.
    pub motor_kw: Option<f64>,
    /// Capacity of the battery, in kWh; none without one.
    pub battery_kwh: Option<f64>,
    /// Highest net power of the fuel cell, in kW; none without one.
    pub cell_kw: Option<f64>,
    /// Carriers that it stores.
    pub carriers: &'static [Carrier],
    /// Whether chargers charge it.
    pub plugs_in: bool,
}

impl Sizes {
    /// With those of motor and battery.
    fn with_electric(self, model: &ElectricModel) -> Self {
        Self {
            motor_kw: Some(model.motor.power_w / 1000.0),
            battery_kwh: Some(model.battery.capacity_j / 3.6e6),
            ..self
        }
    }
}

/// The powertrain: one of these tables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PowertrainModel {
    /// An engine behind clutch and gearbox.
    Combustion(CombustionModel),
    /// A battery and a motor.
    BatteryElectric(ElectricModel),
    /// A fuel cell, a battery and a motor.
    FuelCell(FuelCellModel),
}

/// Laws of a powertrain whose level may be set.
pub const TRUCK_LAWS: [&str; 4] = [
    "vehicle.powertrain.combustion.engine.fuel_factor",
    "vehicle.powertrain.battery_electric.battery.initial_charge",
    "vehicle.powertrain.fuel_cell.cell.hydrogen_factor",
    "vehicle.powertrain.fuel_cell.electric.battery.initial_charge",
];

impl PowertrainModel {
    /// Parts that fit in themselves and to each other.
    pub fn validate(&self, problems: &mut Problems) {
        match self {
            Self::Combustion(model) => {
                problems.part("combustion", |problems| model.validate(problems));
            }
            Self::BatteryElectric(model) => {
                problems.part("battery_electric", |problems| model.validate(problems));
            }
            Self::FuelCell(model) => {
                problems.part("fuel_cell", |problems| model.validate(problems));
            }
        }
    }

    /// The one with an engine.
    pub fn combustion(&self) -> Option<&CombustionModel> {
        if let Self::Combustion(model) = self { Some(model) } else { None }
    }

    /// The one with a battery alone.
    pub fn battery_electric(&self) -> Option<&ElectricModel> {
        if let Self::BatteryElectric(model) = self { Some(model) } else { None }
    }

    /// Carriers that it stores.
    pub fn carriers(&self) -> &'static [Carrier] {
        match self {
            Self::Combustion(model) => model.engine.fuel.carrier.alone(),
            Self::BatteryElectric(_) => Carrier::Electricity.alone(),
            Self::FuelCell(_) => &[Carrier::Electricity, Carrier::Hydrogen],
        }
    }

    /// Its battery, and the key of that.
    pub fn battery(&self) -> Option<(&'static str, &BatteryModel)> {
        match self {
            Self::Combustion(_) => None,
            Self::BatteryElectric(model) => Some(("battery_electric.battery", &model.battery)),
            Self::FuelCell(model) => Some(("fuel_cell.electric.battery", &model.electric.battery)),
        }
    }

    /// Whether chargers charge it.
    pub fn plugs_in(&self) -> bool {
        matches!(self, Self::BatteryElectric(_))
    }

    /// The most that its stores give, in J, down to a reserve of the charge; none of stores that
    /// are not told.
    pub fn usable_j(&self, reserve: f64) -> Option<f64> {
        match self {
            Self::Combustion(_) => None,
            Self::BatteryElectric(ElectricModel { battery, .. }) => {
                Some(battery.capacity_j * (1.0 - battery.minimum_charge.max(reserve)))
            }
            Self::FuelCell(model) => Some(model.usable_j()),
        }
    }

    /// Sizes by which its parts are priced.
    pub fn sizes(&self) -> Sizes {
        let sizes =
            Sizes { carriers: self.carriers(), plugs_in: self.plugs_in(), ..Sizes::default() };
        match self {
            Self::Combustion(model) => {
                Sizes { engine_kw: Some(model.engine.peak_power_w() / 1000.0), ..sizes }
            }
            Self::BatteryElectric(model) => sizes.with_electric(model),
            Self::FuelCell(FuelCellModel { electric, cell, .. }) => {
                let cell_w = cell.map_power_w.last().copied().unwrap_or(0.0);
                Sizes { cell_kw: Some(cell_w / 1000.0), ..sizes.with_electric(electric) }
            }
        }
    }

    /// Rated power of what drives the wheels, in W: the engine's largest at its points of full
    /// load, or the motor's.
    pub fn rated_power_w(&self) -> f64 {
        match self {
            Self::Combustion(model) => model.engine.peak_power_w(),
            Self::BatteryElectric(model) => model.motor.power_w,
            Self::FuelCell(model) => model.electric.motor.power_w,
        }
    }

    /// Differences between trucks: the factor on the fuel map, 1 without one, and the state of
    /// charge at departure, where there is a battery. `draw` draws a law of the vehicle.
    pub fn sample(
        &self,
        draw: &mut dyn FnMut(&Quantity) -> f64,
        streams: &Streams,
        spread: bool,
    ) -> (f64, Option<f64>) {
        let factor = match self {
            Self::Combustion(model) => Some(&model.engine.fuel_factor),
            Self::BatteryElectric(_) => None,
            Self::FuelCell(model) => Some(&model.cell.hydrogen_factor),
        };
        let drawn = |battery: &BatteryModel| {
            battery.initial_charge.drawn(spread, streams, Stream::Electric)
        };
        let charge = self.battery().map(|(_, battery)| drawn(battery));
        (factor.map_or(1.0, draw), charge)
    }

    /// The powertrain over wheels of a radius, in m, with an engine brake, in Nm s; its gears, and
    /// when they are shifted.
    pub fn prepare(
        &self,
        radius_m: f64,
        engine_brake_nms: f64,
    ) -> (PowertrainKind, Vec<Gear>, ShiftModel) {
        match self {
            Self::Combustion(CombustionModel { engine, gearbox }) => {
                let combustion =
                    CombustionPowertrain::new(engine, gearbox, radius_m, engine_brake_nms);
                let (gears, shift) = (combustion.gears.clone(), gearbox.shift.clone());
                (PowertrainKind::Combustion(combustion), gears, shift)
            }
            Self::BatteryElectric(model) => {
                let electric = BatteryElectricPowertrain::new(model, radius_m);
                let gears = electric.gears.clone();
                (PowertrainKind::BatteryElectric(electric), gears, model.strategy())
            }
            Self::FuelCell(model) => {
                let fuel_cell = FuelCellPowertrain::new(model, radius_m);
                let gears = fuel_cell.electric.gears.clone();
                (PowertrainKind::FuelCell(Box::new(fuel_cell)), gears, model.electric.strategy())
            }
        }
    }
}

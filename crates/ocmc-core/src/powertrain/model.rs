//! The powertrain of a study's trucks, as its file says it.

use super::PowertrainKind;
use super::battery_electric::{BatteryElectricPowertrain, ElectricModel};
use super::combustion::{CombustionModel, CombustionPowertrain};
use super::component::gearbox::{Gear, ShiftModel};
use crate::distribution::Quantity;
use crate::energy::Carrier;
use crate::random::{Stream, Streams};
use crate::validation::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The powertrain: one of these tables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PowertrainModel {
    /// An engine behind clutch and gearbox.
    Combustion(CombustionModel),
    /// A battery and a motor.
    BatteryElectric(ElectricModel),
}

/// Laws of a powertrain whose level may be set.
pub const TRUCK_LAWS: [&str; 2] = [
    "vehicle.powertrain.combustion.engine.fuel_factor",
    "vehicle.powertrain.battery_electric.battery.initial_charge",
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

    /// What it stores.
    pub fn carriers(&self) -> &'static [Carrier] {
        match self {
            Self::Combustion(model) => model.engine.fuel.carrier.alone(),
            Self::BatteryElectric(_) => Carrier::Electricity.alone(),
        }
    }

    /// What differs between trucks: the factor on the fuel map, 1 without one, and the state of charge
    /// at departure, where there is a battery. `draw` draws a law of the vehicle.
    pub fn sample(
        &self,
        draw: &mut dyn FnMut(&Quantity) -> f64,
        streams: &Streams,
        spread: bool,
    ) -> (f64, Option<f64>) {
        match self {
            Self::Combustion(model) => (draw(&model.engine.fuel_factor), None),
            Self::BatteryElectric(model) => {
                let (law, stream) = (&model.battery.initial_charge, Stream::Electric);
                let charge = if spread {
                    law.sample_once(streams, stream, &mut streams.open(stream))
                } else {
                    law.centre()
                };
                (1.0, Some(charge))
            }
        }
    }

    /// The powertrain over wheels of a radius, in m, with an engine brake, in Nm s; its gears, and when
    /// they are shifted.
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
        }
    }
}

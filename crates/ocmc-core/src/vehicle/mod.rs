//! The truck: masses, resistances, engine, gearbox and brakes, and how the trucks of a fleet
//! differ.

pub mod brakes;
pub mod coast_down;
pub mod resistance;
pub mod tyre;

use crate::distribution::Quantity;
use crate::lanes::UNBOUNDED;
use crate::operating_cycle::road::vehicle_class::VehicleClass;
use crate::powertrain::component::gearbox::{Gear, ShiftModel};
use crate::powertrain::{PowertrainKind, PowertrainModel, TruckInputs};
use crate::random::{Stream, Streams};
use crate::switch::ModelSwitch;
use crate::validation::Problems;
use brakes::BrakeModel;
use resistance::{AxleModel, CrossWind, CrossWindModel, LoadRange, rolling_coefficient};
use resistance::{DragBySpeed, DragBySpeedModel};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Statistical description of a fleet's vehicles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VehicleModel {
    /// Class: which limits of the law hold for it beside the signs.
    #[serde(default, skip_serializing_if = "VehicleClass::is_default")]
    pub class: VehicleClass,
    /// Mass without payload, in kg.
    #[schemars(range(min = 500.0, max = 100_000.0), extend("usual" = [600.0, 40e3]))]
    pub curb_mass_kg: f64,
    /// Largest mass with payload that the law allows, in kg: larger draws of the payload are cut
    /// there; absent: none are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 500.0, max = 200_000.0), extend("usual" = [1000.0, 100e3]))]
    pub gross_mass_limit_kg: Option<f64>,
    /// Drag area CdA without cross wind, in m².
    #[schemars(range(min = 0.1, max = 20.0), extend("usual" = [0.4, 12.0]))]
    pub drag_area_m2: Quantity,
    /// Growth of the drag area in a cross wind.
    pub cross_wind: CrossWindModel,
    /// Change of the drag area with speed; absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drag_by_speed: Option<DragBySpeedModel>,
    /// Mass of the loaded vehicle to which the load shares of the axles belong, in kg; needed where
    /// those of the empty vehicle differ.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 500.0, max = 200_000.0))]
    pub full_mass_kg: Option<f64>,
    /// Axles.
    pub axles: Vec<AxleModel>,
    /// Factor on the axles' rolling coefficients.
    #[schemars(range(min = 0.1, max = 10.0))]
    pub rolling_factor: Quantity,
    /// Exponent of the tyre load.
    #[schemars(range(min = 0.5, max = 1.5))]
    pub rolling_load_exponent: f64,
    /// Temperature coefficient of rolling resistance, per K.
    #[schemars(range(min = 0.0, max = 0.02))]
    pub rolling_temperature_coefficient_per_k: f64,
    /// Cornering stiffness of the tyres for each N of their load, in N/(N rad): they roll at a slip
    /// angle in bends, which costs; absent: it does not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0, max = 50.0))]
    pub cornering_stiffness_per_rad: Option<f64>,
    /// Dynamic radius of the driven wheels, in m.
    #[schemars(range(min = 0.1, max = 1.5))]
    pub wheel_radius_m: f64,
    /// Moment of inertia of all wheels, in kg m².
    #[schemars(range(min = 0.0, max = 5000.0))]
    pub wheel_inertia_kgm2: f64,
    /// Power of the auxiliaries, in W: at the crankshaft, or from the battery without heating and
    /// cooling.
    #[schemars(range(min = 0.0, max = 100_000.0), extend("usual" = [50.0, 40e3]))]
    pub auxiliary_power_w: Quantity,
    /// Speed from which the limiter fades traction out, over `limiter_range_mps`, in m/s.
    #[schemars(range(min = 5.0, max = 100.0), extend("usual" = [12.0, 70.0]))]
    pub limiter_speed_mps: f64,
    /// Speed range over which the limiter fades traction out, in m/s.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub limiter_range_mps: f64,
    /// Powertrain: one of these tables.
    pub powertrain: PowertrainModel,
    /// Brakes.
    pub brakes: BrakeModel,
    /// Whether it has to stop at open railway crossings, as buses and dangerous goods.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub stops_at_railway_crossings: bool,
}

/// Parameters that all trucks of a study share, prepared for the hot loop.
#[derive(Clone, Debug)]
pub struct VehicleParameters {
    /// The powertrain.
    pub powertrain: PowertrainKind,
    /// Gears, from first to top.
    pub gears: Vec<Gear>,
    /// When they are shifted.
    pub shift: ShiftModel,
    /// Cross-wind polynomial.
    pub cross_wind: CrossWind,
    /// Change of the drag area with speed.
    pub drag_by_speed: DragBySpeed,
    /// Rated power of engine or motor, in W.
    pub rated_power_w: f64,
    /// The numbers as given.
    pub model: VehicleModel,
}

/// One truck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vehicle {
    /// Mass with payload, in kg.
    pub mass_kg: f64,
    /// Drag area without cross wind, in m².
    pub drag_area_m2: f64,
    /// Mass that the driven axles carry, in kg; unbounded where none is said to be driven.
    pub driven_mass_kg: f64,
    /// Rolling coefficient of the loaded truck on smooth dry asphalt at 25 °C.
    pub rolling_coefficient: f64,
    /// The truck's own factor in it.
    pub rolling_factor: f64,
    /// Power of the auxiliaries, in W.
    pub auxiliary_power_w: f64,
    /// Factor on the fuel map; 1 without one.
    pub map_factor: f64,
    /// State of charge at departure; none without a battery.
    pub initial_charge: Option<f64>,
    /// Whether it has to stop at open railway crossings.
    pub stops_at_railway_crossings: bool,
}

impl VehicleModel {
    /// Axles that carry the whole weight, and one powertrain that fits in itself.
    pub fn validate(&self, problems: &mut Problems) {
        let carried = self.axles.iter().fold(0.0, |sum, axle| sum + axle.load_share);
        problems.require(
            (carried - 1.0).abs() < 1e-3,
            "axles",
            format!("load shares with a sum of {carried}"),
            "load shares with a sum of 1",
        );
        self.validate_empty_shares(problems);
        let limit_kg = self.gross_mass_limit_kg.unwrap_or(f64::INFINITY);
        problems.require(
            limit_kg > self.curb_mass_kg,
            "gross_mass_limit_kg",
            limit_kg,
            "above curb_mass_kg",
        );
        problems.part("powertrain", |problems| self.powertrain.validate(problems));
    }

    fn validate_empty_shares(&self, problems: &mut Problems) {
        let shares: Vec<f64> = self.axles.iter().filter_map(|a| a.empty_load_share).collect();
        if shares.is_empty() {
            return;
        }
        let carried = shares.iter().sum::<f64>();
        problems.require(
            shares.len() == self.axles.len() && (carried - 1.0).abs() < 1e-3,
            "axles",
            format!("{} empty_load_share with a sum of {carried}", shares.len()),
            "one for each axle, with a sum of 1",
        );
        let full_kg = self.full_mass_kg.unwrap_or(0.0);
        problems.require(
            full_kg > self.curb_mass_kg,
            "full_mass_kg",
            full_kg,
            "above curb_mass_kg: axles[].empty_load_share needs the mass that load_share belongs \
             to",
        );
    }

    /// The most that the law lets it carry, in kg.
    pub fn most_payload_kg(&self) -> f64 {
        self.gross_mass_limit_kg.map_or(f64::INFINITY, |limit_kg| limit_kg - self.curb_mass_kg)
    }

    fn load_range(&self) -> LoadRange {
        LoadRange { empty_kg: self.curb_mass_kg, full_kg: self.full_mass_kg }
    }

    /// Mass on the driven axles, in kg.
    fn driven_mass_kg(&self, mass_kg: f64) -> f64 {
        let driven = self.axles.iter().filter(|axle| axle.driven);
        let shares: Vec<f64> =
            driven.map(|axle| axle.share_at(mass_kg, self.load_range())).collect();
        if shares.is_empty() { UNBOUNDED } else { shares.iter().sum::<f64>() * mass_kg }
    }

    /// Draws one truck with a payload. Without [`ModelSwitch::VehicleSpread`] all are the typical
    /// one.
    pub fn sample(&self, payload_kg: f64, streams: &Streams, without: &[ModelSwitch]) -> Vehicle {
        let spread = !without.contains(&ModelSwitch::VehicleSpread);
        let mut draws = streams.open(Stream::Vehicle);
        let mut draw =
            |law: &Quantity| law.drawn_from(spread, streams, Stream::Vehicle, &mut draws);
        let mass_kg = self.curb_mass_kg + payload_kg;
        let drag_area_m2 = draw(&self.drag_area_m2);
        let rolling_factor = draw(&self.rolling_factor);
        let auxiliary_power_w = draw(&self.auxiliary_power_w);
        let (map_factor, initial_charge) = self.powertrain.sample(&mut draw, streams, spread);
        Vehicle {
            mass_kg,
            driven_mass_kg: self.driven_mass_kg(mass_kg),
            drag_area_m2,
            rolling_coefficient: rolling_factor * self.rolling_base(mass_kg),
            rolling_factor,
            auxiliary_power_w,
            map_factor,
            initial_charge,
            stops_at_railway_crossings: self.stops_at_railway_crossings,
        }
    }

    /// The rolling coefficient of the typical truck.
    fn rolling_base(&self, mass_kg: f64) -> f64 {
        rolling_coefficient(&self.axles, mass_kg, self.load_range(), self.rolling_load_exponent)
    }

    /// A truck with another payload.
    pub fn loaded(&self, truck: &Vehicle, payload_kg: f64) -> Vehicle {
        let mass_kg = self.curb_mass_kg + payload_kg;
        Vehicle {
            mass_kg,
            driven_mass_kg: self.driven_mass_kg(mass_kg),
            rolling_coefficient: truck.rolling_factor * self.rolling_base(mass_kg),
            ..*truck
        }
    }

    /// Prepares what all trucks share.
    pub fn prepare(&self) -> VehicleParameters {
        let engine_brake_nms = self.brakes.engine_brake_nms();
        let (powertrain, gears, shift) =
            self.powertrain.prepare(self.wheel_radius_m, engine_brake_nms);
        let cross_wind = self.cross_wind.in_tangent();
        let by_speed = self.drag_by_speed.as_ref();
        let drag_by_speed = by_speed.map_or(DragBySpeed::NONE, DragBySpeedModel::prepare);
        let rated_power_w = self.powertrain.rated_power_w();
        VehicleParameters {
            powertrain,
            gears,
            shift,
            cross_wind,
            drag_by_speed,
            rated_power_w,
            model: self.clone(),
        }
    }

    /// Wheels' inertia as a mass at the rim, in kg.
    pub fn wheel_mass_kg(&self) -> f64 {
        self.wheel_inertia_kgm2 / (self.wheel_radius_m * self.wheel_radius_m)
    }
}

impl Vehicle {
    /// Inputs of its powertrain. `climate_w`: power of heating and cooling, in W.
    pub fn powertrain_inputs(&self, climate_w: f64) -> TruckInputs {
        TruckInputs {
            auxiliary_power_w: self.auxiliary_power_w + climate_w,
            map_factor: self.map_factor,
            initial_charge: self.initial_charge,
        }
    }
}

//! Cost of transport: prices, the use by a trip of all that has a price, and the whole life of a
//! truck.
//!
//! With a_k what a trip uses of charge k (litres, kWh, hours, km), p_k,i its price in year i of the
//! life, d the distance of a truck in a year, and δ_i = (1 + r)^-i what a unit of money in year i
//! is worth at the start, the first year having i = 0:
//!
//! levelised price  P_k = Σ w_i δ_i p_k,i / D,  D = Σ w_i δ_i
//! cost over km     Σ_k P_k Σ a_k / Σ km + K / (d D)
//! K                purchase − residual share · purchase · (1 + r)^-life + Σ w_i δ_i insurance_i
//!
//! w_i is 1, and in the last year the part of it that belongs to the life. The sums of a_k and km
//! are over the completed trips of the fleet, so that the first term is a ratio of two totals. The
//! whole life costs d D times the cost over km, a year d times it, and a trip its own km times the
//! second term and its own charges.
//!
//! Discounting from the start of each year, and items that are summed up by year of the life, are
//! those of T3CO 1.0 (National Renewable Energy Laboratory, *Transportation Technology Total Cost
//! of Ownership*, repository NREL/T3CO, 2024), whose own test results are this room's check
//! (`tests/it/cost.rs`); the residual value comes at the end of the life, there at the start of the
//! last year.
//!
//! A price is a state of the world, not of a trip: a law of `[cost]` is drawn once for all trips
//! ([`state`]). What a fleet costs, and which of two fleets costs less, is for `fleet/`.

pub mod costing;
pub mod emissions;
pub mod item;
pub mod levelised;
pub mod state;
mod yearly;

pub use yearly::Yearly;

use crate::distribution::Quantity;
use crate::validation::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The road types whose share of a trip its record has.
pub const TOLL_ROAD_TYPES: [&str; 3] = ["urban", "rural", "motorway"];

/// Prices and what else decides the cost of a truck, in one currency. What is absent is not
/// counted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CostModel {
    /// Code of the currency of all prices by ISO 4217, such as EUR.
    pub currency: String,
    /// Fuel, per L.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Yearly", range(min = 0.0, max = 1.0e6), extend("usual" = [0.2, 60.0]))]
    pub fuel_per_l: Option<Yearly>,
    /// Hydrogen, per kg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Yearly", range(min = 0.0, max = 1.0e6), extend("usual" = [0.5, 200.0]))]
    pub hydrogen_per_kg: Option<Yearly>,
    /// Natural gas or biomethane, per kg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Yearly", range(min = 0.0, max = 1.0e6), extend("usual" = [0.2, 60.0]))]
    pub methane_per_kg: Option<Yearly>,
    /// Electricity in the depot, per kWh of the meter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Yearly", range(min = 0.0, max = 1.0e6), extend("usual" = [0.01, 10.0]))]
    pub depot_charging_per_kwh: Option<Yearly>,
    /// Electricity at stops on the way, per kWh of the meter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Yearly", range(min = 0.0, max = 1.0e6), extend("usual" = [0.01, 20.0]))]
    pub public_charging_per_kwh: Option<Yearly>,
    /// Share of the metered electricity that reaches the battery; needed where electricity has a
    /// price.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.3, max = 1.0))]
    pub charging_efficiency: Option<f64>,
    /// Driver, per h of the trip, standstills included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Yearly", range(min = 0.0, max = 1.0e6), extend("usual" = [1.0, 1500.0]))]
    pub driver_per_h: Option<Yearly>,
    /// Maintenance, repair and tyres of a truck with an engine, per km.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Yearly", range(min = 0.0, max = 1.0e6))]
    pub combustion_maintenance_per_km: Option<Yearly>,
    /// Maintenance, repair and tyres of an electric truck, per km.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Yearly", range(min = 0.0, max = 1.0e6))]
    pub electric_maintenance_per_km: Option<Yearly>,
    /// Tolls; those that a truck falls under add up.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub toll: Vec<TollModel>,
    /// Mass by which tolls are classed, in kg, such as the permissible one; absent: that of the
    /// trip, payload included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 200_000.0))]
    pub toll_mass_kg: Option<f64>,
    /// Payload that this truck cannot take and another one could, in kg, in the mean of all trips.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 100_000.0))]
    pub lost_payload_kg: Option<f64>,
    /// Price of carrying the lost payload otherwise, per tkm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Yearly", range(min = 0.0, max = 1.0e6))]
    pub lost_payload_per_tkm: Option<Yearly>,
    /// Purchase of a truck, per truck, without the parts that are priced apart below.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Quantity", range(min = 0.0, max = 1.0e12))]
    pub purchase_per_truck: Option<Quantity>,
    /// Tank of a truck with an engine, per truck.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Quantity", range(min = 0.0, max = 1.0e12))]
    pub tank_per_truck: Option<Quantity>,
    /// Plug or charger of an electric truck, per truck.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Quantity", range(min = 0.0, max = 1.0e12))]
    pub charger_per_truck: Option<Quantity>,
    /// Engine, per kW of its full load.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Quantity", range(min = 0.0, max = 1.0e9))]
    pub engine_per_kw: Option<Quantity>,
    /// Motor and power electronics of an electric truck, per kW.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Quantity", range(min = 0.0, max = 1.0e9))]
    pub motor_per_kw: Option<Quantity>,
    /// Battery of an electric truck, per kWh of its capacity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Quantity", range(min = 0.0, max = 1.0e9), extend("usual" = [20.0, 15e3]))]
    pub battery_per_kwh: Option<Quantity>,
    /// Fuel cell, per kW of its highest net power.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Quantity", range(min = 0.0, max = 1.0e9))]
    pub fuel_cell_per_kw: Option<Quantity>,
    /// Worth of a truck at the end of its life, as a share of its purchase.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Quantity", range(min = 0.0, max = 1.0))]
    pub residual_share: Option<Quantity>,
    /// Insurance, taxes and whatever else a truck costs by time, per a (year).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Yearly", range(min = 0.0, max = 1.0e9))]
    pub insurance_per_a: Option<Yearly>,
    /// Life of a truck, in a (years).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Quantity", range(min = 0.1, max = 50.0), extend("usual" = [1.0, 30.0]))]
    pub life_a: Option<Quantity>,
    /// Discount rate without inflation, per a (year).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Quantity", range(min = 0.0, max = 1.0))]
    pub discount_rate_per_a: Option<Quantity>,
    /// Distance of a truck, in km per a (year).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Quantity", range(min = 1.0, max = 1.0e6), extend("usual" = [1000.0, 400e3]))]
    pub distance_km_per_a: Option<Quantity>,
}

/// A toll.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TollModel {
    /// Road types on which it is taken: `urban`, `rural`, `motorway`; absent: all.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub road_types: Vec<String>,
    /// Mass from which on it is taken, in kg; absent: any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 200_000.0))]
    pub from_kg: Option<f64>,
    /// Mass below which it is taken, in kg; absent: any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 200_000.0))]
    pub below_kg: Option<f64>,
    /// Its price, per km.
    #[schemars(range(min = 0.0, max = 1.0e6))]
    pub toll_per_km: Yearly,
}

impl CostModel {
    /// Prices that may be listed by year, with their keys; those of tolls are not among them.
    pub fn yearly(&self) -> [(&'static str, Option<&Yearly>); 10] {
        [
            ("fuel_per_l", self.fuel_per_l.as_ref()),
            ("depot_charging_per_kwh", self.depot_charging_per_kwh.as_ref()),
            ("public_charging_per_kwh", self.public_charging_per_kwh.as_ref()),
            ("driver_per_h", self.driver_per_h.as_ref()),
            ("combustion_maintenance_per_km", self.combustion_maintenance_per_km.as_ref()),
            ("electric_maintenance_per_km", self.electric_maintenance_per_km.as_ref()),
            ("lost_payload_per_tkm", self.lost_payload_per_tkm.as_ref()),
            ("insurance_per_a", self.insurance_per_a.as_ref()),
            ("hydrogen_per_kg", self.hydrogen_per_kg.as_ref()),
            ("methane_per_kg", self.methane_per_kg.as_ref()),
        ]
    }

    /// The price of that key for what is filled in.
    pub fn price(&self, key: &str) -> Option<&Yearly> {
        self.yearly().into_iter().find(|(known, _)| *known == key)?.1
    }

    /// Keys of the prices that are paid by the truck, and whether each is set.
    fn by_truck(&self) -> [(&'static str, bool); 9] {
        [
            ("purchase_per_truck", self.purchase_per_truck.is_some()),
            ("tank_per_truck", self.tank_per_truck.is_some()),
            ("charger_per_truck", self.charger_per_truck.is_some()),
            ("engine_per_kw", self.engine_per_kw.is_some()),
            ("motor_per_kw", self.motor_per_kw.is_some()),
            ("battery_per_kwh", self.battery_per_kwh.is_some()),
            ("fuel_cell_per_kw", self.fuel_cell_per_kw.is_some()),
            ("residual_share", self.residual_share.is_some()),
            ("insurance_per_a", self.insurance_per_a.is_some()),
        ]
    }

    /// A currency, a life where something is paid by it, and keys that need one another.
    pub fn validate(&self, problems: &mut Problems) {
        let code = &self.currency;
        let is_code = code.len() == 3 && code.bytes().all(|byte| byte.is_ascii_uppercase());
        let allowed = "three capital letters of ISO 4217, such as EUR";
        problems.require(is_code, "currency", format!("`{code}`"), allowed);
        self.validate_life(problems);
        let electricity =
            self.depot_charging_per_kwh.is_some() || self.public_charging_per_kwh.is_some();
        problems.require(
            !electricity || self.charging_efficiency.is_some(),
            "charging_efficiency",
            "not there",
            "a number where `depot_charging_per_kwh` or `public_charging_per_kwh` is",
        );
        let lost = ("lost_payload_kg", self.lost_payload_kg.is_some());
        let priced = ("lost_payload_per_tkm", self.lost_payload_per_tkm.is_some());
        for ((key, there), (other, needed)) in [(lost, priced), (priced, lost)] {
            let allowed = format!("given where `{other}` is");
            problems.require(there || !needed, key, "not there", &allowed);
        }
        for toll in &self.toll {
            problems.part("toll", |problems| toll.validate(problems));
        }
    }

    fn validate_life(&self, problems: &mut Problems) {
        let life = [
            ("life_a", self.life_a.is_some()),
            ("discount_rate_per_a", self.discount_rate_per_a.is_some()),
            ("distance_km_per_a", self.distance_km_per_a.is_some()),
        ];
        let listed = self
            .yearly()
            .into_iter()
            .filter(|(_, price)| price.is_some_and(|price| matches!(price, Yearly::ByYear(_))));
        let tolls = self.toll.iter().filter(|toll| matches!(toll.toll_per_km, Yearly::ByYear(_)));
        let by_truck = self.by_truck().into_iter().filter(|(_, there)| *there);
        let asking = listed.map(|(key, _)| key).chain(tolls.map(|_| "toll.toll_per_km"));
        let asking = asking.chain(by_truck.map(|(key, _)| key)).next();
        let given = life.iter().find(|(_, there)| *there).map(|(key, _)| *key);
        if let Some(needing) = asking.or(given) {
            for (key, there) in life {
                let allowed = format!("given where `{needing}` is");
                problems.require(there, key, "not there", &allowed);
            }
        }
        let lists = self.yearly().into_iter().filter_map(|(key, price)| Some((key, price?)));
        let tolls = self.toll.iter().map(|toll| ("toll.toll_per_km", &toll.toll_per_km));
        for (key, price) in lists.chain(tolls) {
            let holds = !matches!(price, Yearly::ByYear(years) if years.is_empty());
            problems.require(holds, key, "an empty list", "one price at least, that of year 1");
        }
    }
}

impl TollModel {
    fn validate(&self, problems: &mut Problems) {
        for name in &self.road_types {
            let known = TOLL_ROAD_TYPES.contains(&name.as_str());
            let allowed = format!("one of {}", TOLL_ROAD_TYPES.join(", "));
            problems.require(known, "road_types", format!("`{name}`"), &allowed);
        }
        if let (Some(from_kg), Some(below_kg)) = (self.from_kg, self.below_kg) {
            let allowed = format!("above `from_kg`, {from_kg}");
            problems.require(below_kg > from_kg, "below_kg", below_kg, &allowed);
        }
    }
}

//! Prices of a study that apply to its trucks, prepared: charges of trips, parts of a truck, and
//! the inputs that a state of the world gives values to.

use super::item::Item;
use super::{CostModel, TollModel, Yearly};
use crate::distribution::Quantity;
use crate::energy::carrier::{Carrier, Declaration};
use crate::powertrain::Sizes;
use crate::record::Record;
use crate::vehicle::VehicleModel;

/// J in a kWh.
const J_PER_KWH: f64 = 3.6e6;

/// Measure of a charge in a trip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    /// Amount filled in, in the unit in which it is sold.
    Filled(Carrier),
    /// Electricity from the depot's meter, in kWh.
    DepotKwh,
    /// Electricity from meters on the way, in kWh.
    PublicKwh,
    /// Time, in h.
    Hours,
    /// Distance, in km.
    Distance,
    /// Payload that could not be carried times distance, in tkm.
    LostTonnes,
    /// Distance under a toll, in km; its place in the list.
    Toll(usize),
}

/// A price, and what it is multiplied by.
#[derive(Clone, Copy, Debug)]
pub struct Charge {
    /// Its input.
    pub input: usize,
    /// The item that it belongs to.
    pub item: Item,
    /// Measure of its use in a trip.
    pub measure: Measure,
}

/// A part of a truck that is bought.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Its input.
    pub input: usize,
    /// The item that it belongs to.
    pub item: Item,
    /// How much of it a truck has: 1, or kW, or kWh.
    pub amount: f64,
}

/// A number of `[cost]` that a state of the world gives a value to.
#[derive(Clone, Debug)]
pub struct Input {
    /// Path of its key.
    pub key: String,
    /// Where its draws begin in the stream of prices: the same in every study that has the key.
    pub place: u64,
    /// Its number, law or list.
    pub price: Yearly,
}

/// Inputs of a truck's life.
#[derive(Clone, Copy, Debug)]
pub struct LifeInputs {
    /// Its length.
    pub life: usize,
    /// The discount rate.
    pub rate: usize,
    /// Distance in a year.
    pub distance: usize,
}

/// Prices of a study that apply to its trucks.
#[derive(Clone, Debug)]
pub struct Costing {
    /// Code of the currency.
    pub currency: String,
    /// The numbers that have a price in a state of the world.
    pub inputs: Vec<Input>,
    /// Charges that trips pay.
    pub charges: Vec<Charge>,
    /// Parts that are bought.
    pub parts: Vec<Part>,
    /// Input of the share that is left of the purchase.
    pub residual: Option<usize>,
    /// Input of what is paid by time.
    pub insurance: Option<usize>,
    /// Inputs of the life, where there is one.
    pub life: Option<LifeInputs>,
    tolls: Vec<TollModel>,
    toll_mass_kg: Option<f64>,
    curb_mass_kg: f64,
    charging_efficiency: f64,
    lost_payload_kg: f64,
}

/// Keys whose laws are drawn, in the order of their places: append, never reorder.
const KEYS: [&str; 21] = [
    "fuel_per_l",
    "depot_charging_per_kwh",
    "public_charging_per_kwh",
    "driver_per_h",
    "combustion_maintenance_per_km",
    "electric_maintenance_per_km",
    "lost_payload_per_tkm",
    "insurance_per_a",
    "purchase_per_truck",
    "tank_per_truck",
    "charger_per_truck",
    "engine_per_kw",
    "motor_per_kw",
    "battery_per_kwh",
    "residual_share",
    "life_a",
    "discount_rate_per_a",
    "distance_km_per_a",
    "hydrogen_per_kg",
    "methane_per_kg",
    "fuel_cell_per_kw",
];

/// Prices that a break-even is looked for, where a study has them.
pub const BREAK_EVEN_KEYS: [&str; 6] = [
    "cost.fuel_per_l",
    "cost.hydrogen_per_kg",
    "cost.methane_per_kg",
    "cost.depot_charging_per_kwh",
    "cost.public_charging_per_kwh",
    "cost.battery_per_kwh",
];

/// Draws between the places of two keys: more than any law takes.
const PLACES_APART: u64 = 1 << 16;
/// Place of the first toll, in keys.
const FIRST_TOLL: u64 = 1 << 10;

impl Costing {
    /// Prepares the prices of a study that apply to its trucks.
    pub fn of(cost: &CostModel, vehicle: &VehicleModel) -> Self {
        Self::new(cost, vehicle.powertrain.sizes(), vehicle.curb_mass_kg)
    }

    /// Prepares prices for trucks of these sizes and this empty mass.
    pub fn new(cost: &CostModel, sizes: Sizes, curb_mass_kg: f64) -> Self {
        let mut costing = Self {
            currency: cost.currency.clone(),
            inputs: Vec::new(),
            charges: Vec::new(),
            parts: Vec::new(),
            residual: None,
            insurance: None,
            life: None,
            tolls: cost.toll.clone(),
            toll_mass_kg: cost.toll_mass_kg,
            curb_mass_kg,
            charging_efficiency: cost.charging_efficiency.unwrap_or(1.0),
            lost_payload_kg: cost.lost_payload_kg.unwrap_or(0.0),
        };
        costing.add_charges(cost, sizes);
        costing.add_parts(cost, sizes);
        let [life, rate, distance] = [
            ("life_a", &cost.life_a),
            ("discount_rate_per_a", &cost.discount_rate_per_a),
            ("distance_km_per_a", &cost.distance_km_per_a),
        ]
        .map(|(key, quantity)| costing.add_quantity(key, quantity.as_ref()));
        costing.residual = costing.add_quantity("residual_share", cost.residual_share.as_ref());
        costing.insurance = costing.add("insurance_per_a", cost.insurance_per_a.as_ref());
        costing.life = life.zip(rate).zip(distance).map(|((life, rate), distance)| LifeInputs {
            life,
            rate,
            distance,
        });
        costing
    }

    fn add(&mut self, key: &str, price: Option<&Yearly>) -> Option<usize> {
        let place = KEYS.iter().position(|known| *known == key).expect("a key of the list") as u64;
        Some(self.add_at(format!("cost.{key}"), place, price?))
    }

    fn add_quantity(&mut self, key: &str, quantity: Option<&Quantity>) -> Option<usize> {
        self.add(key, Some(&Yearly::Constant(quantity?.clone())))
    }

    fn add_at(&mut self, key: String, place: u64, price: &Yearly) -> usize {
        let place = place * PLACES_APART;
        self.inputs.push(Input { key, place, price: price.clone() });
        self.inputs.len() - 1
    }

    fn add_charges(&mut self, cost: &CostModel, sizes: Sizes) {
        let (engine, electric) = (sizes.engine_kw.is_some(), sizes.battery_kwh.is_some());
        let plug = sizes.plugs_in;
        for carrier in sizes.carriers {
            let Some(keys) = carrier.declaration().filled else { continue };
            let (item, measure) = (Item::Fuel, Measure::Filled(*carrier));
            let input = self.add(keys.price, cost.price(keys.price));
            self.charges.extend(input.map(|input| Charge { input, item, measure }));
        }
        for (applies, key, item, measure) in [
            (plug, "depot_charging_per_kwh", Item::DepotCharging, Measure::DepotKwh),
            (plug, "public_charging_per_kwh", Item::PublicCharging, Measure::PublicKwh),
            (true, "driver_per_h", Item::Driver, Measure::Hours),
            (engine, "combustion_maintenance_per_km", Item::Maintenance, Measure::Distance),
            (electric, "electric_maintenance_per_km", Item::Maintenance, Measure::Distance),
            (true, "lost_payload_per_tkm", Item::LostPayload, Measure::LostTonnes),
        ] {
            let input = if applies { self.add(key, cost.price(key)) } else { None };
            self.charges.extend(input.map(|input| Charge { input, item, measure }));
        }
        for (n, toll) in cost.toll.iter().enumerate() {
            let key = format!("cost.toll.{n}.toll_per_km");
            let input = self.add_at(key, FIRST_TOLL + n as u64, &toll.toll_per_km);
            let (item, measure) = (Item::Toll, Measure::Toll(n));
            self.charges.push(Charge { input, item, measure });
        }
    }

    fn add_parts(&mut self, cost: &CostModel, sizes: Sizes) {
        let one = |there: bool| there.then_some(1.0);
        let fills = sizes.carriers.iter().any(|carrier| carrier.declaration().filled.is_some());
        for (key, price, item, amount) in [
            ("purchase_per_truck", &cost.purchase_per_truck, Item::Purchase, Some(1.0)),
            ("tank_per_truck", &cost.tank_per_truck, Item::Tank, one(fills)),
            ("charger_per_truck", &cost.charger_per_truck, Item::Charger, one(sizes.plugs_in)),
            ("engine_per_kw", &cost.engine_per_kw, Item::Engine, sizes.engine_kw),
            ("motor_per_kw", &cost.motor_per_kw, Item::Motor, sizes.motor_kw),
            ("fuel_cell_per_kw", &cost.fuel_cell_per_kw, Item::Engine, sizes.cell_kw),
            ("battery_per_kwh", &cost.battery_per_kwh, Item::Battery, sizes.battery_kwh),
        ] {
            let Some(amount) = amount else { continue };
            let input = self.add_quantity(key, price.as_ref());
            self.parts.extend(input.map(|input| Part { input, item, amount }));
        }
    }

    /// The input of that key.
    pub fn input(&self, key: &str) -> Option<usize> {
        self.inputs.iter().position(|input| input.key == key)
    }

    /// Whether something is paid by the truck.
    pub fn has_whole_life(&self) -> bool {
        self.life.is_some()
    }

    /// Use of each charge by a trip, of what it drove where its battery cut it short; none of a
    /// trip that stalled or timed out.
    pub fn trip(&self, record: &Record) -> Option<Trip> {
        if !record.outcome.counts() || !(record.distance_m > 0.0) {
            return None;
        }
        let km = record.distance_m / 1000.0;
        let amounts = self.charges.iter().map(|charge| self.amount(charge.measure, record, km));
        Some(Trip {
            cycle_id: record.cycle_id,
            km,
            tkm: km * record.payload_kg / 1000.0,
            amounts: amounts.collect(),
        })
    }

    fn amount(&self, measure: Measure, record: &Record, km: f64) -> f64 {
        match measure {
            Measure::Filled(carrier) => sold(record, carrier.declaration()),
            Measure::DepotKwh => depot_kwh(record, self.charging_efficiency),
            Measure::PublicKwh => public_kwh(record, self.charging_efficiency),
            Measure::Hours => record.duration_s / 3600.0,
            Measure::Distance => km,
            Measure::LostTonnes => km * self.lost_payload_kg / 1000.0,
            Measure::Toll(n) => km * self.share_under(&self.tolls[n], record),
        }
    }

    /// Share of a trip that is under a toll.
    fn share_under(&self, toll: &TollModel, record: &Record) -> f64 {
        let mass_kg = self.toll_mass_kg.unwrap_or(self.curb_mass_kg + record.payload_kg);
        let is_in = toll.from_kg.is_none_or(|from| mass_kg >= from)
            && toll.below_kg.is_none_or(|below| mass_kg < below);
        if !is_in {
            return 0.0;
        }
        if toll.road_types.is_empty() {
            return 1.0;
        }
        // a study may lack a road type: then no trip has any of it
        let shares = toll.road_types.iter().map(|name| match name.as_str() {
            "urban" => record.urban_share.unwrap_or(0.0),
            "rural" => record.rural_share.unwrap_or(0.0),
            "motorway" => record.motorway_share.unwrap_or(0.0),
            _ => 0.0,
        });
        shares.sum()
    }
}

/// Amount of a carrier that a trip took and that is filled in, in the unit in which it is sold.
pub(super) fn sold(record: &Record, declared: &Declaration) -> f64 {
    record.consumption(declared.carrier).unwrap_or(0.0) * record.distance_m / 1.0e5
}

/// Electricity from the depot's meter, in kWh, where the study charges there. Elsewhere what the
/// battery lost in the trip and was not given on the way; negative where a trip ends with more than
/// it began with. The heat in the battery is left out then, as a depot charges slowly.
pub(super) fn depot_kwh(record: &Record, efficiency: f64) -> f64 {
    if let Some(metered_j) = record.grid_energy_depot_j {
        return metered_j / J_PER_KWH;
    }
    let drawn_j = record.amount(Carrier::Electricity).unwrap_or(0.0);
    let lost_j = drawn_j - record.charged_energy_j.unwrap_or(0.0);
    lost_j / J_PER_KWH / efficiency
}

/// Electricity from meters on the way, in kWh, the heat in the battery included.
pub(super) fn public_kwh(record: &Record, efficiency: f64) -> f64 {
    if let (Some(public_j), Some(stop_j)) = (record.grid_energy_public_j, record.grid_energy_stop_j)
    {
        return (public_j + stop_j) / J_PER_KWH;
    }
    let given_j = record.charged_energy_j.unwrap_or(0.0) + record.charging_loss_j.unwrap_or(0.0);
    given_j / J_PER_KWH / efficiency
}

/// Amounts that a trip uses.
#[derive(Clone, Debug, PartialEq)]
pub struct Trip {
    /// Id of its cycle.
    pub cycle_id: u64,
    /// Distance, in km.
    pub km: f64,
    /// Payload times distance, in tkm.
    pub tkm: f64,
    /// Amount of each charge that it uses, in the order of [`Costing::charges`].
    pub amounts: Vec<f64>,
}

impl Trip {
    /// Adds another one, whose id does not matter.
    pub fn add(&mut self, other: &Self) {
        self.km += other.km;
        self.tkm += other.tkm;
        for (sum, amount) in self.amounts.iter_mut().zip(&other.amounts) {
            *sum += amount;
        }
    }

    /// Counts it so many times.
    pub fn scale(&mut self, times: f64) {
        self.km *= times;
        self.tkm *= times;
        self.amounts.iter_mut().for_each(|amount| *amount *= times);
    }

    /// All of some trips together; none of no trips.
    pub fn total<'a>(mut trips: impl Iterator<Item = &'a Self>) -> Option<Self> {
        let mut total = trips.next()?.clone();
        trips.for_each(|trip| total.add(trip));
        Some(total)
    }
}

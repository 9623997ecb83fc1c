//! Energy carriers: what trucks store and somebody pays for.
//!
//! [`CARRIERS`] declares each carrier once: the term of the ledger that counts it, its columns in
//! the records, its units and words, the key of its price and the heating values that it can have.
//! Records, breakdowns, quantities of a fleet, sums over trucks, costs, emissions, tables and
//! pictures follow from the declaration; none of them names a carrier. A truck may store several:
//! each has its own consumption, and all together have one in kWh.

use super::ledger::Term;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A kind of energy that a truck stores.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Carrier {
    /// Diesel, petrol and other liquid fuels, sold by the litre.
    LiquidFuel,
    /// Electricity in a battery.
    Electricity,
    /// Hydrogen, sold by the kilogram.
    Hydrogen,
    /// Natural gas and biomethane, compressed or liquefied, sold by the kilogram.
    Methane,
}

/// A column: its name, with the unit as a suffix, and what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Named {
    /// Name in files.
    pub name: &'static str,
    /// Meaning, with the unit.
    pub meaning: &'static str,
}

/// The declaration of a carrier.
#[derive(Clone, Copy, Debug)]
pub struct Declaration {
    /// The carrier.
    pub carrier: Carrier,
    /// Word for it.
    pub name: &'static str,
    /// Place of its energy, in a sentence such as "of 100 kWh in the fuel".
    pub place: &'static str,
    /// Term of the ledger that counts what is taken.
    pub term: Term,
    /// Amount of a cycle.
    pub amount: Named,
    /// Unit of the amount, and that in which people read the amount of a trip, with the factor to
    /// it.
    pub units: (&'static str, &'static str, f64),
    /// Amount over distance.
    pub consumption: Named,
    /// Amount over distance and tonnes of payload.
    pub per_tonne: Named,
    /// Both for people.
    pub labels: [&'static str; 2],
    /// Consumption where so much of the unit of sale is taken for each metre.
    pub per_m: fn(f64) -> f64,
    /// Amount in the unit of sale, where that is not the amount's.
    pub sold: Option<Named>,
    /// Unit in which people read totals, and the factor to it from the unit of sale.
    pub total: (&'static str, f64),
    /// Keys of `[cost]` and `[emissions]` that value an amount that is filled in, and of the cost's
    /// item; none for what is charged, whose meters are priced by their places.
    pub filled: Option<FilledKeys>,
    /// Lower heating values that it can have, in J/kg; none without a mass.
    pub heating_value_jpkg: Option<[f64; 2]>,
}

/// Keys of what is filled in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FilledKeys {
    /// Price, in `[cost]`.
    pub price: &'static str,
    /// Factor from the well to the wheel, in `[emissions]`.
    pub well_to_wheel: &'static str,
}

const fn filled(price: &'static str, well_to_wheel: &'static str) -> FilledKeys {
    FilledKeys { price, well_to_wheel }
}

const fn named(name: &'static str, meaning: &'static str) -> Named {
    Named { name, meaning }
}

/// The carriers, in the order in which they are shown.
pub const CARRIERS: &[Declaration] = &[
    Declaration {
        carrier: Carrier::LiquidFuel,
        name: "fuel",
        place: "in the fuel",
        term: Term::Fuel,
        amount: named("fuel_kg", "Liquid fuel, in kg, idling at stops included."),
        units: ("kg", "kg", 1.0),
        consumption: named("consumption_l_per_100km", "Fuel over distance, in L/100 km."),
        per_tonne: named(
            "consumption_l_per_100tkm",
            "Fuel over distance and tonne of payload, in L/100 tkm; null for an empty truck.",
        ),
        labels: ["L/100 km", "L/100 tkm"],
        per_m: hundred_km,
        sold: Some(named("fuel_l", "Fuel, in L")),
        total: ("L", 1.0),
        filled: Some(filled("fuel_per_l", "fuel_well_to_wheel_kg_per_l")),
        // methanol to hydrotreated oil
        heating_value_jpkg: Some([15e6, 48e6]),
    },
    Declaration {
        carrier: Carrier::Electricity,
        name: "electricity",
        place: "from the battery",
        term: Term::Battery,
        amount: named(
            "battery_energy_j",
            "Energy that left the battery's store, in J, charging at stops not counted; null \
             without a battery.",
        ),
        units: ("J", "kWh", 1.0 / 3.6e6),
        consumption: named(
            "consumption_kwh_per_km",
            "Energy that left the battery's store, over distance, in kWh/km; null without a \
             battery.",
        ),
        per_tonne: named(
            "consumption_kwh_per_tkm",
            "Energy that left the battery's store, over distance and tonne of payload, in kWh/tkm; \
             null for an empty truck, and without a battery.",
        ),
        labels: ["kWh/km", "kWh/tkm"],
        per_m: kwh_per_km,
        sold: None,
        total: ("MWh", 1.0 / 3.6e9),
        filled: None,
        heating_value_jpkg: None,
    },
    Declaration {
        carrier: Carrier::Hydrogen,
        name: "hydrogen",
        place: "in the hydrogen",
        term: Term::Fuel,
        amount: named("hydrogen_kg", "Hydrogen, in kg, idling at stops included."),
        units: ("kg", "kg", 1.0),
        consumption: named(
            "consumption_hydrogen_kg_per_100km",
            "Hydrogen over distance, in kg/100 km.",
        ),
        per_tonne: named(
            "consumption_hydrogen_kg_per_100tkm",
            "Hydrogen over distance and tonne of payload, in kg/100 tkm; null for an empty truck.",
        ),
        labels: ["kg H2/100 km", "kg H2/100 tkm"],
        per_m: hundred_km,
        sold: None,
        total: ("kg", 1.0),
        filled: Some(filled("hydrogen_per_kg", "hydrogen_well_to_wheel_kg_per_kg")),
        heating_value_jpkg: Some([119e6, 121e6]),
    },
    Declaration {
        carrier: Carrier::Methane,
        name: "methane",
        place: "in the gas",
        term: Term::Fuel,
        amount: named("methane_kg", "Natural gas or biomethane, in kg, idling at stops included."),
        units: ("kg", "kg", 1.0),
        consumption: named("consumption_methane_kg_per_100km", "Gas over distance, in kg/100 km."),
        per_tonne: named(
            "consumption_methane_kg_per_100tkm",
            "Gas over distance and tonne of payload, in kg/100 tkm; null for an empty truck.",
        ),
        labels: ["kg CH4/100 km", "kg CH4/100 tkm"],
        per_m: hundred_km,
        sold: None,
        total: ("kg", 1.0),
        filled: Some(filled("methane_per_kg", "methane_well_to_wheel_kg_per_kg")),
        // lean natural gas to pure methane
        heating_value_jpkg: Some([38e6, 50.1e6]),
    },
];

// the place of a carrier is that of its declaration
const _: () = {
    let mut k = 0;
    while k < CARRIERS.len() {
        assert!(CARRIERS[k].carrier as usize == k, "the order of the carriers");
        k += 1;
    }
};

impl Declaration {
    /// Column of the amount in the unit of sale.
    pub fn sold(&self) -> Named {
        self.sold.unwrap_or(self.amount)
    }
}

/// Most carriers that one truck stores.
pub const MOST_CARRIERS: usize = 2;

/// Column of the energy from all stores over distance, where a truck has several.
pub const ALL_STORES: Named = named(
    "consumption_all_kwh_per_km",
    "Energy from all stores over distance, in kWh/km, that of fuels by their heating value; null \
     where a truck stores one carrier, and has its consumption.",
);

impl Carrier {
    /// Number of carriers.
    pub const COUNT: usize = CARRIERS.len();

    /// Declaration of the carrier.
    pub fn declaration(self) -> &'static Declaration {
        &CARRIERS[self as usize]
    }

    /// The carriers of a truck that stores this one alone.
    pub fn alone(self) -> &'static [Self] {
        std::slice::from_ref(&CARRIERS[self as usize].carrier)
    }
}

fn hundred_km(per_m: f64) -> f64 {
    per_m * 1e5
}

fn kwh_per_km(j_per_m: f64) -> f64 {
    j_per_m / 3600.0
}

//! The columns of a table of truck-years.

use super::quantity::QUANTITIES;
use super::truck_year::TruckTime;
use ocmc_core::energy::carrier::{CARRIERS, Carrier, Named};
use ocmc_core::record::Cell;

/// One column of a table of truck-years.
#[derive(Clone, Copy, Debug)]
pub struct TruckColumn {
    /// Its name, with the unit.
    pub name: &'static str,
    /// Meaning of the column.
    pub meaning: &'static str,
    get: Get,
}

#[derive(Clone, Copy, Debug)]
enum Get {
    Field(fn(&TruckTime) -> Cell),
    Taken(usize),
    Sold(usize),
    Quantity(usize),
}

impl TruckColumn {
    /// The value of a truck-year.
    pub fn get(&self, time: &TruckTime) -> Cell {
        match self.get {
            Get::Field(get) => get(time),
            Get::Taken(k) => Cell::Number(time.taken[k]),
            Get::Sold(k) => Cell::Number(time.sold[k]),
            Get::Quantity(k) => Cell::Number(time.value(k)),
        }
    }
}

const fn field(
    name: &'static str,
    meaning: &'static str,
    get: fn(&TruckTime) -> Cell,
) -> TruckColumn {
    TruckColumn { name, meaning, get: Get::Field(get) }
}

/// The columns that are totals, or say which truck and which year.
const FIELDS: [TruckColumn; 8] = [
    field("truck_id", "The truck", |t| Cell::Integer(Some(t.truck_id))),
    field("year", "The year, from 0", |t| Cell::Integer(Some(t.year))),
    field("n_trips", "Completed trips", |t| Cell::Integer(Some(t.n_trips))),
    field(
        "n_failed",
        "Trips that were not completed; those that stalled or timed out are in no total",
        |t| Cell::Integer(Some(t.n_failed)),
    ),
    field("distance_m", "Distance, in m", |t| Cell::Number(Some(t.distance_m))),
    field("total_duration_s", "Duration of all trips, in s", |t| Cell::Number(Some(t.duration_s))),
    field("payload_distance_kgm", "Payload times distance, in kg m", |t| {
        Cell::Number(Some(t.payload_distance_kgm))
    }),
    field("wheel_energy_j", "Positive work at the hubs of the driven wheels, in J", |t| {
        Cell::Number(Some(t.wheel_energy_j))
    }),
];

/// Greenhouse gases and cost, behind the columns of the carriers.
const BEHIND: [TruckColumn; 3] = [
    field("co2_kg", "Carbon dioxide from burning the fuel, in kg", |t| Cell::Number(t.co2_kg)),
    field(
        "well_to_wheel_kg",
        "Greenhouse gases from the well to the wheel, in kg of CO2 equivalents",
        |t| Cell::Number(t.well_to_wheel_kg),
    ),
    field(
        "cost",
        "Cost in the currency of the study, at the centres of its prices; null without prices",
        |t| Cell::Number(t.cost),
    ),
];

/// Columns of what was taken: of each carrier its amount, and that in the unit of sale where it is
/// another one.
const TAKEN: usize = {
    let (mut count, mut k) = (Carrier::COUNT, 0);
    while k < Carrier::COUNT {
        count += CARRIERS[k].sold.is_some() as usize;
        k += 1;
    }
    count
};

/// Columns before those of the quantities.
const TOTALS: usize = FIELDS.len() + TAKEN + BEHIND.len();

/// The columns of a table of truck-years: totals, then each quantity of the fleet as the truck's
/// total over total.
pub const TRUCK_COLUMNS: [TruckColumn; TOTALS + QUANTITIES.len()] = {
    let mut all = [BEHIND[0]; TOTALS + QUANTITIES.len()];
    let mut k = 0;
    while k < FIELDS.len() {
        all[k] = FIELDS[k];
        k += 1;
    }
    let mut carrier = 0;
    while carrier < Carrier::COUNT {
        let Named { name, meaning } = CARRIERS[carrier].amount;
        all[k] = TruckColumn { name, meaning, get: Get::Taken(carrier) };
        k += 1;
        if let Some(Named { name, meaning }) = CARRIERS[carrier].sold {
            all[k] = TruckColumn { name, meaning, get: Get::Sold(carrier) };
            k += 1;
        }
        carrier += 1;
    }
    let mut behind = 0;
    while behind < BEHIND.len() {
        all[k] = BEHIND[behind];
        (k, behind) = (k + 1, behind + 1);
    }
    let mut quantity = 0;
    while quantity < QUANTITIES.len() {
        let name = QUANTITIES[quantity].column;
        let meaning = "The quantity of that name over the truck's year, total over total";
        all[TOTALS + quantity] = TruckColumn { name, meaning, get: Get::Quantity(quantity) };
        quantity += 1;
    }
    all
};

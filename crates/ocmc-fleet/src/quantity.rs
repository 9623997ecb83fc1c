//! The quantities that a fleet is asked about, and what their mean over the fleet is: total over
//! total.
//!
//! | quantity | mean of the fleet | per cycle |
//! |---|---|---|
//! | litres, kWh, wheel kWh or grams of CO2 per distance | total over total distance | the cycle's own |
//! | litres per 100 tkm, kWh and grams of CO2 per tkm | total over total tonne-kilometres, empty trips included | the cycle's own; none where it is empty |
//! | speed | total distance over total time | the cycle's own |
//! | stops per km | total stops over total distance | the cycle's own |
//! | duration, and any other column that is asked about | plain mean | the cycle's own |
//! | kWh of the whole trip per distance | total over total distance of the whole trips | the cycle's own |
//!
//! A trip that its battery cut short counts with what it drove, but for the duration, which is that
//! of trips that arrive, and for the whole trip, which is as long as the others.

use ocmc_core::energy::carrier::{ALL_STORES, CARRIERS, Carrier};
use ocmc_core::record::{COLUMNS, Column, Outcome, Record, column};

/// Weight by which a cycle's value is multiplied for a total, or a total is divided.
#[derive(Clone, Copy, Debug)]
pub enum Weight {
    /// Each cycle counts once.
    One,
    /// Distance, in m.
    Distance,
    /// Payload times distance, in t m.
    TonneDistance,
    /// Duration, in s.
    Duration,
    /// Distance of the whole trip, in m.
    WholeTrip,
}

/// Parts of a weight.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Distance, in m.
    pub distance_m: f64,
    /// Duration, in s.
    pub duration_s: f64,
    /// Payload, in kg.
    pub payload_kg: f64,
    /// Distance of the whole trip, in m; NaN where it is not known.
    pub whole_trip_m: f64,
}

impl Extent {
    /// Extent of a cycle.
    pub fn of(record: &Record) -> Self {
        let Record { distance_m, duration_s, .. } = *record;
        let payload_kg = record.mean_payload_kg;
        let whole_trip_m = record.whole_trip_m.unwrap_or(f64::NAN);
        Self { distance_m, duration_s, payload_kg, whole_trip_m }
    }
}

impl Weight {
    /// The weight of a cycle.
    pub fn of(self, extent: Extent) -> f64 {
        match self {
            Self::One => 1.0,
            Self::Distance => extent.distance_m,
            Self::TonneDistance => extent.payload_kg / 1000.0 * extent.distance_m,
            Self::Duration => extent.duration_s,
            Self::WholeTrip => extent.whole_trip_m,
        }
    }
}

/// Where a cycle's own value is from.
#[derive(Clone, Copy, Debug)]
pub enum Value<'a> {
    /// Value of the record, or one that is made of it.
    Of(fn(&Record) -> Option<f64>),
    /// Amount of a carrier that it took over distance.
    Consumption(Carrier),
    /// The same by tonne of payload.
    PerTonne(Carrier),
    /// A column of the records.
    Column(&'static Column),
    /// A column of the breakdown, by its name: each study has its own.
    Part(&'a str),
}

impl Value<'_> {
    /// The value of a cycle, however it ended.
    pub fn get(self, record: &Record) -> Option<f64> {
        match self {
            Self::Of(value) => value(record),
            Self::Consumption(carrier) => record.consumption(carrier),
            Self::PerTonne(carrier) => record.consumption_per_tonne(carrier),
            Self::Column(column) => column.get(record).number(),
            Self::Part(name) => {
                let place = record.breakdown.names().iter().position(|known| known == name)?;
                record.breakdown.value(place)
            }
        }
    }
}

/// One quantity: its fleet mean is Σ `of` × `times` / Σ `over`.
#[derive(Clone, Copy, Debug)]
pub struct NamedQuantity<'a> {
    /// Name, with its unit.
    pub column: &'a str,
    /// A cycle's own value.
    pub value: Value<'a>,
    /// Name of the quantity that is summed up.
    pub of: &'a str,
    /// Weight by which each of its values is multiplied.
    pub times: Weight,
    /// Weight by which the total is divided.
    pub over: Weight,
    /// Whether a trip that its battery cut short counts.
    pub counts_cut_short: bool,
}

/// One of the [`QUANTITIES`].
pub type RecordQuantity = NamedQuantity<'static>;

/// Quantities of the [`QUANTITIES`] that may be below zero: downhill a battery may gain, and the
/// wheels brake.
const MAY_BE_NEGATIVE: [&str; 8] = [
    CHARGED,
    CARRIERS[Carrier::Electricity as usize].per_tonne.name,
    ALL_STORES.name,
    WHOLE_TRIP,
    WHEEL,
    "grid_co2_g_per_km",
    WELL_TO_WHEEL,
    "well_to_wheel_g_per_tkm",
];

impl NamedQuantity<'_> {
    /// The least that its mean can be.
    pub fn least(&self) -> f64 {
        let never = quantity(self.column).is_some() && !MAY_BE_NEGATIVE.contains(&self.column);
        if never { 0.0 } else { f64::NEG_INFINITY }
    }

    /// The value of a cycle that counts and has one.
    pub fn of_cycle(&self, record: &Record) -> Option<f64> {
        let counts = match record.outcome {
            Outcome::Completed => true,
            Outcome::Depleted => self.counts_cut_short,
            Outcome::Stalled | Outcome::TimedOut => false,
        };
        self.value.get(record).filter(|value| counts && value.is_finite())
    }

    /// Contributions of a cycle that counts to the two totals of the fleet's mean.
    pub fn totals(&self, record: &Record) -> Option<(f64, f64)> {
        let summed = match quantity(self.of) {
            Some(summed) => summed.of_cycle(record)?,
            None => self.of_cycle(record)?,
        };
        let extent = Extent::of(record);
        Some((summed * self.times.of(extent), self.over.of(extent)))
    }
}

/// Litres over 100 km.
pub const LITRES: &str = CARRIERS[Carrier::LiquidFuel as usize].consumption.name;
/// Charged energy, over distance.
const CHARGED: &str = CARRIERS[Carrier::Electricity as usize].consumption.name;
/// Greenhouse gases from the well to the wheel over distance.
const WELL_TO_WHEEL: &str = "well_to_wheel_g_per_km";
/// Electricity of the whole trip over distance: with a battery that never empties.
pub const WHOLE_TRIP: &str = "whole_trip_kwh_per_km";
/// Work at the wheels over distance.
pub const WHEEL: &str = "wheel_kwh_per_km";

/// Quantities by which a fleet is judged, where nothing else is asked for: the first that its
/// cycles have. Of trucks with several stores it is the energy of all.
pub const CONSUMPTIONS: [&str; Carrier::COUNT + 2] = {
    let mut all = [WHEEL; Carrier::COUNT + 2];
    all[0] = ALL_STORES.name;
    let mut k = 0;
    while k < Carrier::COUNT {
        all[k + 1] = CARRIERS[k].consumption.name;
        k += 1;
    }
    all
};

/// A quantity that is averaged by a weight.
const fn mean_by<'a>(weight: Weight, column: &'a str, value: Value<'a>) -> NamedQuantity<'a> {
    let (times, over) = (weight, weight);
    NamedQuantity { column, value, of: column, times, over, counts_cut_short: true }
}

/// A quantity per distance.
const fn per_distance(column: &'static str, value: Value<'static>) -> RecordQuantity {
    mean_by(Weight::Distance, column, value)
}

/// A quantity per tonne of payload and distance, of which `of` is that per distance.
const fn per_tonne_distance(
    column: &'static str,
    value: Value<'static>,
    of: &'static str,
) -> RecordQuantity {
    RecordQuantity { of, over: Weight::TonneDistance, ..per_distance(column, value) }
}

/// The quantities, in the order in which they are reported.
pub const QUANTITIES: [RecordQuantity; 2 * Carrier::COUNT + OTHERS.len()] = {
    let mut all = [OTHERS[0]; 2 * Carrier::COUNT + OTHERS.len()];
    let mut k = 0;
    while k < Carrier::COUNT {
        let (declared, carrier) = (&CARRIERS[k], CARRIERS[k].carrier);
        let over_distance = declared.consumption.name;
        all[2 * k] = per_distance(over_distance, Value::Consumption(carrier));
        let per_tonne = Value::PerTonne(carrier);
        all[2 * k + 1] = per_tonne_distance(declared.per_tonne.name, per_tonne, over_distance);
        k += 1;
    }
    let mut k = 0;
    while k < OTHERS.len() {
        all[2 * Carrier::COUNT + k] = OTHERS[k];
        k += 1;
    }
    all
};

/// The quantities behind those of the carriers.
const OTHERS: [RecordQuantity; 10] = [
    per_distance(ALL_STORES.name, Value::Of(Record::all_kwh_per_km)),
    mean_by(Weight::WholeTrip, WHOLE_TRIP, Value::Of(|r| r.whole_trip_kwh_per_km)),
    per_distance(WHEEL, Value::Of(|r| Some(r.wheel_kwh_per_km))),
    per_distance("co2_g_per_km", Value::Of(|r| r.co2_g_per_km)),
    per_distance("grid_co2_g_per_km", Value::Of(|r| r.grid_co2_g_per_km)),
    per_distance(WELL_TO_WHEEL, Value::Of(|r| r.well_to_wheel_g_per_km)),
    per_tonne_distance(
        "well_to_wheel_g_per_tkm",
        Value::Of(|r| r.well_to_wheel_g_per_tkm),
        WELL_TO_WHEEL,
    ),
    mean_by(Weight::Duration, "mean_speed_mps", Value::Of(|r| Some(r.mean_speed_mps))),
    RecordQuantity {
        counts_cut_short: false,
        ..mean_by(Weight::One, "duration_s", Value::Of(|r| Some(r.duration_s)))
    },
    per_distance(
        "stops_per_km",
        Value::Of(|r| Some(f64::from(r.n_stops) / (r.distance_m / 1000.0))),
    ),
];

/// The quantity of that name.
pub fn quantity(column: &str) -> Option<&'static RecordQuantity> {
    QUANTITIES.iter().find(|quantity| quantity.column == column)
}

/// Columns of the records that are no quantities: how a cycle ended, and ids.
const NO_QUANTITIES: [&str; 6] =
    ["cycle_id", "outcome", "truck_id", "driver_id", "trip", "route_id"];

/// Names of the columns that can be asked about and that every study has: the quantities, then all
/// other numbers of the records.
pub fn numeric_columns() -> impl Iterator<Item = &'static str> {
    let others = COLUMNS.iter().map(|column| column.name);
    let others = others.filter(|name| quantity(name).is_none() && !NO_QUANTITIES.contains(name));
    QUANTITIES.iter().map(|quantity| quantity.column).chain(others)
}

/// The quantity of a column of the records, `parts` being the names of those of the breakdown: one
/// of the [`QUANTITIES`], or a column whose mean is that of the cycles that were completed, each
/// counted once. None where there is no such column, or it is no number.
pub fn quantity_of_column<'a, 'b>(
    name: &'a str,
    mut parts: impl Iterator<Item = &'b str>,
) -> Option<NamedQuantity<'a>> {
    if let Some(known) = quantity(name) {
        return Some(*known);
    }
    let value = match column(name).filter(|_| !NO_QUANTITIES.contains(&name)) {
        Some(column) => Value::Column(column),
        None if parts.any(|part| part == name) => Value::Part(name),
        None => return None,
    };
    Some(NamedQuantity { counts_cut_short: false, ..mean_by(Weight::One, name, value) })
}

/// The consumption that these cycles have: of what their trucks store, else the work at the wheels.
/// Where a battery cut trips short, it is that of the whole trips: the same ones for all.
pub fn consumption(records: &[Record]) -> &'static RecordQuantity {
    shared_consumption(&[records])
}

/// The consumption that all of these fleets have; of fleets that have none in common that of the
/// first.
pub fn shared_consumption(fleets: &[&[Record]]) -> &'static RecordQuantity {
    Consumed::shared(&fleets.iter().map(|fleet| Consumed::of(fleet)).collect::<Vec<_>>())
}

/// Consumptions that the cycles of a fleet have.
pub(crate) struct Consumed {
    pub(crate) has: Vec<&'static RecordQuantity>,
    /// Whether a battery cut a trip short.
    cut_short: bool,
}

impl Consumed {
    pub(crate) fn of(records: &[Record]) -> Self {
        let known = CONSUMPTIONS.into_iter().chain([WHOLE_TRIP]).filter_map(quantity);
        let has = |quantity: &&RecordQuantity| {
            records.iter().any(|record| quantity.of_cycle(record).is_some())
        };
        let cut_short = records.iter().any(|record| record.outcome == Outcome::Depleted);
        Self { has: known.filter(has).collect(), cut_short }
    }

    /// As [`shared_consumption`].
    pub(crate) fn shared(fleets: &[Self]) -> &'static RecordQuantity {
        let cut_short = fleets.iter().any(|fleet| fleet.cut_short);
        let drawn = [ALL_STORES.name, CHARGED];
        let columns = CONSUMPTIONS
            .map(|name| if cut_short && drawn.contains(&name) { WHOLE_TRIP } else { name });
        let has = |fleet: &Self, name: &str| fleet.has.iter().any(|q| q.column == name);
        let consumptions = || columns.iter().filter_map(|name| quantity(name));
        let shared = consumptions().find(|q| fleets.iter().all(|fleet| has(fleet, q.column)));
        let first =
            || consumptions().find(|q| fleets.first().is_some_and(|fleet| has(fleet, q.column)));
        shared.or_else(first).unwrap_or(&QUANTITIES[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fleets_of_two_powertrains_share_the_work_at_the_wheels() {
        let diesel = Record::default().with(Carrier::LiquidFuel, [None, Some(30.0), None]);
        let electric = Record::default().with(Carrier::Electricity, [None, Some(1.2), None]);
        let failed = Record { outcome: Outcome::Stalled, ..diesel.clone() };
        let (diesel, electric, failed) = ([diesel], [electric], [failed]);
        let column = |fleets: &[&[Record]]| shared_consumption(fleets).column;
        assert_eq!(column(&[&diesel, &diesel]), LITRES);
        assert_eq!(column(&[&electric, &electric]), CHARGED);
        assert_eq!(column(&[&diesel, &electric]), WHEEL);
        // nothing in common: that of the first
        assert_eq!(column(&[&electric, &failed]), CHARGED);
        assert_eq!(column(&[&failed]), LITRES);
        let cut_short = Record {
            outcome: Outcome::Depleted,
            whole_trip_kwh_per_km: Some(1.3),
            whole_trip_m: Some(3e5),
            ..electric[0].clone()
        };
        assert_eq!(column(&[&[cut_short]]), WHOLE_TRIP);
    }

    #[test]
    fn any_number_of_the_records_is_a_quantity_and_ids_are_none() {
        let quantity = |name| quantity_of_column(name, ["fuel_kg_urban"].into_iter());
        let record = Record { n_stops: 3, ..Record::default() };
        let record = record.with(Carrier::LiquidFuel, [Some(20.0), None, None]);
        let totals = |name| quantity(name).and_then(|quantity| quantity.totals(&record));
        assert_eq!(totals("n_stops"), Some((3.0, 1.0)));
        assert_eq!(totals("fuel_kg"), Some((20.0, 1.0)));
        // a column of the breakdown, which this record lacks
        assert!(quantity("fuel_kg_urban").is_some() && totals("fuel_kg_urban").is_none());
        for name in
            ["cycle_id", "outcome", "truck_id", "driver_id", "trip", "route_id", "fuel_kg_rural"]
        {
            assert!(quantity(name).is_none(), "{name}");
        }
        for name in numeric_columns() {
            assert!(quantity(name).is_some(), "{name}");
        }
        assert_eq!(numeric_columns().count(), COLUMNS.len() - NO_QUANTITIES.len() + 1);
    }
}

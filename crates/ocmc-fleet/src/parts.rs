//! Totals of a fleet on each road type and near each kind of event, over the cycles that count.

use ocmc_core::breakdown::{Amount, Axis, BreakdownColumns, MOST_AMOUNTS};
use ocmc_core::energy::carrier::{CARRIERS, Carrier};
use ocmc_core::record::Record;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::borrow::Cow;
use std::sync::Arc;

/// Totals of one part.
#[derive(Clone, Debug, PartialEq)]
pub struct FleetPart {
    /// By what the fleet is broken down.
    pub axis: Axis,
    /// Name of the part.
    pub name: String,
    /// Distance, in m.
    pub distance_m: f64,
    /// Duration with standstill, in s.
    pub duration_s: f64,
    /// Positive work at the hubs of the driven wheels, in J.
    pub wheel_energy_j: f64,
    /// Amount of each carrier of its trucks that it took.
    pub taken: Vec<Taken>,
}

/// Amount of a carrier that a part took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taken {
    /// The carrier.
    pub carrier: Carrier,
    /// In the unit of its amount.
    pub amount: f64,
    /// In the unit of its consumption; none where nothing was driven.
    pub consumption: Option<f64>,
}

/// As it is serialised.
impl JsonSchema for FleetPart {
    fn schema_name() -> Cow<'static, str> {
        "FleetPart".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let number = generator.subschema_for::<Option<f64>>();
        let word = generator.subschema_for::<String>();
        json_schema!({
            "description": "Totals of a part of the trips: of each carrier the amount and the \
                            consumption",
            "type": "object",
            "properties": { "by": word, "part": word },
            "required": ["by", "part", "distance_m", "duration_s", "wheel_energy_j"],
            "additionalProperties": number,
        })
    }
}

impl Serialize for FleetPart {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("by", &self.axis)?;
        map.serialize_entry("part", &self.name)?;
        map.serialize_entry(Amount::Distance.column(), &self.distance_m)?;
        map.serialize_entry(Amount::Duration.column(), &self.duration_s)?;
        map.serialize_entry(Amount::Wheel.column(), &self.wheel_energy_j)?;
        for Taken { carrier, amount, consumption } in &self.taken {
            map.serialize_entry(carrier.declaration().amount.name, amount)?;
            map.serialize_entry(carrier.declaration().consumption.name, consumption)?;
        }
        map.end()
    }
}

/// Adds up what parts took.
#[derive(Clone, Debug, Default)]
pub struct PartSums {
    columns: Option<Arc<BreakdownColumns>>,
    sums: Vec<[f64; MOST_AMOUNTS]>,
    /// Sums over all cycles of what is filled in: amounts, and in the unit of sale.
    amounts: [f64; Carrier::COUNT],
    sold: [f64; Carrier::COUNT],
}

impl PartSums {
    /// Adds a cycle.
    pub fn add(&mut self, record: &Record) {
        let breakdown = &record.breakdown;
        if self.columns.is_none() {
            self.columns = breakdown.columns().cloned();
            let parts = self.columns.as_ref().map_or(0, |columns| columns.parts().len());
            self.sums.resize(parts, [0.0; MOST_AMOUNTS]);
        }
        if breakdown.columns() != self.columns.as_ref() {
            return;
        }
        for (k, sums) in self.sums.iter_mut().enumerate() {
            let amounts = breakdown.of_part(k).into_iter().flatten();
            for (sum, amount) in sums.iter_mut().zip(amounts) {
                *sum += amount;
            }
        }
        for declared in CARRIERS.iter().filter(|declared| declared.filled.is_some()) {
            let place = declared.carrier as usize;
            self.amounts[place] += record.amount(declared.carrier).unwrap_or(0.0);
            let consumption = record.consumption(declared.carrier).unwrap_or(0.0);
            self.sold[place] += consumption * record.distance_m / 1e5;
        }
    }

    /// The parts; none where cycles are not broken down.
    pub fn finish(self) -> Vec<FleetPart> {
        let Some(columns) = self.columns else { return Vec::new() };
        // consumption for each metre and each unit of the amount
        let factor = |carrier: Carrier| {
            let [amount, sold] = [self.amounts, self.sold].map(|sums| sums[carrier as usize]);
            let declared = carrier.declaration();
            let per_amount = match declared.filled {
                Some(_) if amount > 0.0 => sold / amount,
                Some(_) => 0.0,
                None => 1.0,
            };
            (declared.per_m)(1.0) * per_amount
        };
        let parts = columns.parts().iter().zip(&self.sums).map(|(part, sums)| {
            let [distance_m, duration_s, wheel_energy_j, taken @ ..] = *sums;
            let taken = columns.carriers().zip(taken).map(|(carrier, amount)| {
                let per_m = (distance_m > 0.0).then(|| amount / distance_m);
                Taken { carrier, amount, consumption: per_m.map(|per_m| factor(carrier) * per_m) }
            });
            FleetPart {
                axis: part.axis,
                name: part.name.clone(),
                distance_m,
                duration_s,
                wheel_energy_j,
                taken: taken.collect(),
            }
        });
        let parts: Vec<FleetPart> = parts.collect();
        // a speed that is followed exactly has no road
        if parts.iter().all(|part| part.distance_m == 0.0) { Vec::new() } else { parts }
    }
}

/// Adds what a record knows to a sum over the records that know it.
pub(super) fn add_known(sum: &mut Option<f64>, part: Option<f64>) {
    if let Some(part) = part {
        *sum = Some(sum.unwrap_or(0.0) + part);
    }
}

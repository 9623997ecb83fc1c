//! What a fleet took on each road type and near each kind of event: totals over the cycles that
//! count.

use super::quantity::{ELECTRICITY, LITRES};
use ocmc_core::breakdown::{AMOUNTS, Amount, Axis, BreakdownColumns};
use ocmc_core::record::Record;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::sync::Arc;

/// What one part took.
#[derive(Clone, Debug, PartialEq)]
pub struct FleetPart {
    /// By what the fleet is broken down.
    pub axis: Axis,
    /// Name of the part.
    pub name: String,
    /// Fuel or battery.
    pub source: Amount,
    /// Distance, in m.
    pub distance_m: f64,
    /// Duration with standstill, in s.
    pub duration_s: f64,
    /// Positive work at the wheels, in J.
    pub wheel_energy_j: f64,
    /// Fuel, in kg, or what the battery's store lost, in J.
    pub source_amount: f64,
    /// In L/100 km or kWh/km; none where nothing was driven.
    pub consumption: Option<f64>,
}

impl FleetPart {
    /// Name of its consumption.
    pub fn consumption_column(&self) -> &'static str {
        match self.source {
            Amount::Fuel => LITRES,
            _ => ELECTRICITY,
        }
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
        map.serialize_entry(self.source.column(), &self.source_amount)?;
        map.serialize_entry(self.consumption_column(), &self.consumption)?;
        map.end()
    }
}

/// Adds up what parts took.
#[derive(Clone, Debug, Default)]
pub struct PartSums {
    columns: Option<Arc<BreakdownColumns>>,
    sums: Vec<[f64; AMOUNTS]>,
    /// Fuel of all cycles, in kg and in L.
    fuel_kg: f64,
    fuel_l: f64,
}

impl PartSums {
    /// Adds a cycle.
    pub fn add(&mut self, record: &Record) {
        let breakdown = &record.breakdown;
        if self.columns.is_none() {
            self.columns = breakdown.columns().cloned();
            self.sums.resize(breakdown.names().len() / AMOUNTS, [0.0; AMOUNTS]);
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
        self.fuel_kg += record.fuel_kg.unwrap_or(0.0);
        self.fuel_l += record.consumption_l_per_100km.unwrap_or(0.0) * record.distance_m / 1e5;
    }

    /// The parts; none where cycles are not broken down.
    pub fn finish(self) -> Vec<FleetPart> {
        let Some(columns) = self.columns else { return Vec::new() };
        let source = columns.amounts()[AMOUNTS - 1];
        let l_per_kg = if self.fuel_kg > 0.0 { self.fuel_l / self.fuel_kg } else { 0.0 };
        let parts = columns.parts().iter().zip(self.sums).map(|(part, sums)| {
            let [distance_m, duration_s, wheel_energy_j, source_amount] = sums;
            let per_m = (distance_m > 0.0).then(|| source_amount / distance_m);
            let factor = if source == Amount::Fuel { 1e5 * l_per_kg } else { 1.0 / 3600.0 };
            FleetPart {
                axis: part.axis,
                name: part.name.clone(),
                source,
                distance_m,
                duration_s,
                wheel_energy_j,
                source_amount,
                consumption: per_m.map(|per_m| factor * per_m),
            }
        });
        let parts: Vec<FleetPart> = parts.collect();
        // a speed that is followed exactly has no road
        if parts.iter().all(|part| part.distance_m == 0.0) { Vec::new() } else { parts }
    }
}

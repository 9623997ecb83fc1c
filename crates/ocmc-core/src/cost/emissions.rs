//! Greenhouse gases: from the tank, from power plants, and from the well.
//!
//! From tank to wheel a trip emits the carbon dioxide of the fuel that it burns, a battery nothing.
//! From well to wheel it emits what its litres and its metered kWh are multiplied by here. In
//! between lies what power plants emit for those kWh: the factor that statistics of the grid print.

use super::CostModel;
use super::costing::{depot_kwh, public_kwh, sold};
use crate::charging::ChargingPolicy;
use crate::energy::carrier::Declaration;
use crate::energy::emission_model::EmissionModel;
use crate::record::Record;

/// The factors of a study, and what share of metered electricity reaches the battery.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EmissionFactors {
    factors: EmissionModel,
    charging_efficiency: Option<f64>,
    /// Whether the electricity of its trucks comes from the grid.
    plugs_in: bool,
}

/// Emissions of a completed trip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TripEmissions {
    /// Id of its cycle.
    pub cycle_id: u64,
    /// Distance, in km.
    pub km: f64,
    /// Payload times distance, in tkm.
    pub tkm: f64,
    /// From tank to wheel, in kg of CO2.
    pub tank_to_wheel_kg: f64,
    /// From power plants, in kg of CO2 equivalents; none of fuel, and without a factor.
    pub generation_kg: Option<f64>,
    /// From well to wheel, in kg of CO2 equivalents; none without a factor of what it uses.
    pub well_to_wheel_kg: Option<f64>,
}

impl EmissionFactors {
    /// Factors of a study, whose trucks are charged from the grid or not. The efficiency of
    /// charging is that of its costs, else that of its chargers, else the one beside the factors.
    pub fn of(
        factors: Option<&EmissionModel>,
        cost: Option<&CostModel>,
        charging: Option<&ChargingPolicy>,
        plugs_in: bool,
    ) -> Self {
        let factors = factors.cloned().unwrap_or_default();
        let charging_efficiency = cost
            .and_then(|cost| cost.charging_efficiency)
            .or(charging.map(|charging| charging.efficiency))
            .or(factors.charging_efficiency);
        Self { factors, charging_efficiency, plugs_in }
    }

    /// Emissions of a trip, with what it drove where its battery cut it short; none of one that
    /// stalled or timed out.
    pub fn of_trip(&self, record: &Record) -> Option<TripEmissions> {
        if !record.outcome.counts() || !(record.distance_m > 0.0) {
            return None;
        }
        let km = record.distance_m / 1000.0;
        let Self { factors, charging_efficiency, plugs_in } = self;
        let metered = |factor: Option<f64>| {
            factor.zip(*charging_efficiency).map(|(factor, efficiency)| {
                factor * (depot_kwh(record, efficiency) + public_kwh(record, efficiency))
            })
        };
        let (mut generation_kg, mut well_to_wheel_kg) = (None, None);
        let charged = |declared: &&Declaration| declared.filled.is_some() || *plugs_in;
        for (k, declared) in record.carriers().filter(charged).enumerate() {
            let of_this = if let Some(keys) = declared.filled {
                let factor = factors.well_to_wheel(keys.well_to_wheel);
                factor.map(|factor| factor * sold(record, declared))
            } else {
                generation_kg = metered(factors.electricity_generation_kg_per_kwh);
                metered(factors.electricity_well_to_wheel_kg_per_kwh)
            };
            // the sum is known where each part is
            let before_kg = if k == 0 { Some(0.0) } else { well_to_wheel_kg };
            well_to_wheel_kg = before_kg.zip(of_this).map(|(before, more)| before + more);
        }
        Some(TripEmissions {
            cycle_id: record.cycle_id,
            km,
            tkm: km * record.payload_kg / 1000.0,
            tank_to_wheel_kg: record.co2_g_per_km.unwrap_or(0.0) / 1000.0 * km,
            generation_kg,
            well_to_wheel_kg,
        })
    }

    /// Fills in the columns of a record that has all others.
    pub fn fill(&self, record: &mut Record) {
        let Some(trip) = self.of_trip(record) else { return };
        let per_km = |kg: Option<f64>| kg.map(|kg| kg * 1000.0 / trip.km);
        record.grid_co2_g_per_km = per_km(trip.generation_kg);
        record.well_to_wheel_g_per_km = per_km(trip.well_to_wheel_kg);
        record.well_to_wheel_g_per_tkm = record.per_tonne(record.well_to_wheel_g_per_km);
    }
}

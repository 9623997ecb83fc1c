//! Temperature of the battery: one node, warmed by the battery's own losses and by a heater, cooled
//! by a cooler, and open to the air.
//!
//! ```text
//! C dT/dt = R I² + c_h P_h − c_c P_c − k (T − T_air)
//! ```
//!
//! C is the heat capacity of cells and housing, P_h and P_c the electric powers of heater and
//! cooler, c_h and c_c the heat that each J of them moves. From one look at it to the next the heat
//! flows are their means: T tends to T_air + Q/k, by the factor e^(−k t/C). While a truck is driven
//! it is looked at each 2 km, at rest each five minutes; in between resistance and limits stay as
//! they are. Heater and cooler are on or off over such a span, and off at rest but at a charger.
//!
//! Cells and housing are one: heat comes out of the cells at once. Where a speed is followed
//! exactly and in the depot, the battery is as its other keys say.

use super::battery::BatteryModel;
use crate::validation::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a battery is warmed and cooled, and what its temperature does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ThermalModel {
    /// Heat capacity of cells and housing, in J/K.
    #[schemars(range(min = 1000.0, max = 1.0e9))]
    pub heat_capacity_j_per_k: f64,
    /// Heat that goes to the air for each K above it, in W/K.
    #[schemars(range(min = 0.0, max = 10_000.0))]
    pub air_w_per_k: f64,
    /// Temperature below which it is heated, in K; at departure it is no colder.
    #[schemars(range(min = 233.15, max = 323.15))]
    pub heat_below_k: f64,
    /// Electric power of the heater, in W.
    #[schemars(range(min = 0.0, max = 200_000.0))]
    pub heater_w: f64,
    /// Heat for each J of it.
    #[schemars(range(min = 0.5, max = 10.0))]
    pub heater_ratio: f64,
    /// Temperature above which it is cooled, in K; at departure it is no warmer.
    #[schemars(range(min = 273.15, max = 343.15))]
    pub cool_above_k: f64,
    /// Electric power of the cooler, in W.
    #[schemars(range(min = 0.0, max = 200_000.0))]
    pub cooler_w: f64,
    /// Heat for each J of it.
    #[schemars(range(min = 0.5, max = 10.0))]
    pub cooler_ratio: f64,
    /// Heating ahead of planned charging stops; absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub precondition: Option<PreconditionModel>,
    /// Temperatures of the tables below, rising, in K; level beyond them.
    #[schemars(inner(range(min = 233.15, max = 343.15)))]
    pub temperature_k: Vec<f64>,
    /// States of charge of `resistance_factor`, rising; level beyond them.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub charge: Vec<f64>,
    /// Resistance over `resistance_ohm`: a row for each temperature, a number for each charge.
    #[schemars(inner(inner(range(min = 0.1, max = 100.0))))]
    pub resistance_factor: Vec<Vec<f64>>,
    /// Share of `discharge_power_w` that is left at each temperature.
    #[schemars(inner(range(min = 0.01, max = 1.0)))]
    pub discharge_share: Vec<f64>,
    /// Share of `charge_power_w` that is left at each temperature.
    #[schemars(inner(range(min = 0.01, max = 1.0)))]
    pub charge_share: Vec<f64>,
}

/// Heating ahead of planned charging stops.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PreconditionModel {
    /// Temperature up to which it is heated, in K.
    #[schemars(range(min = 273.15, max = 323.15))]
    pub up_to_k: f64,
    /// How far ahead of the charger that begins, in m.
    #[schemars(range(min = 0.0, max = 200_000.0))]
    pub ahead_m: f64,
}

impl ThermalModel {
    /// Tables that fit together, and heating that ends below where cooling begins.
    pub fn validate(&self, problems: &mut Problems) {
        let heats_up_to_k =
            self.precondition.as_ref().map_or(self.heat_below_k, |warmer| warmer.up_to_k);
        let allowed = format!("above {heats_up_to_k}, up to which it is heated");
        let cools = self.cool_above_k > heats_up_to_k;
        problems.require(cools, "cool_above_k", self.cool_above_k, &allowed);
        for (name, values) in [("temperature_k", &self.temperature_k), ("charge", &self.charge)] {
            let rises = values.windows(2).all(|pair| pair[0] < pair[1]) && !values.is_empty();
            problems.require(rises, name, format!("{values:?}"), "at least one number, rising");
        }
        let (rows, columns) = (self.temperature_k.len(), self.charge.len());
        let fits = self.resistance_factor.len() == rows
            && self.resistance_factor.iter().all(|row| row.len() == columns);
        let allowed =
            format!("{rows} rows of {columns} numbers: one for each temperature and charge");
        problems.require(fits, "resistance_factor", "another table", &allowed);
        for (name, shares) in
            [("discharge_share", &self.discharge_share), ("charge_share", &self.charge_share)]
        {
            let count = format!("{} numbers", shares.len());
            let allowed = format!("{rows}: one for each temperature");
            problems.require(shares.len() == rows, name, count, &allowed);
        }
    }

    /// Temperature at departure, in K: that of the air, as far as the depot has let it.
    pub fn departure_k(&self, air_k: f64) -> f64 {
        air_k.max(self.heat_below_k).min(self.cool_above_k)
    }

    /// Electric power of heater and cooler at a temperature, in W, and the heat that they bring, in
    /// W.
    pub fn conditioning_w(&self, temperature_k: f64, preconditions: bool) -> [f64; 2] {
        let warmer = self.precondition.as_ref().filter(|_| preconditions);
        let heat_below_k = warmer.map_or(self.heat_below_k, |warmer| warmer.up_to_k);
        if temperature_k < heat_below_k {
            [self.heater_w, self.heater_w * self.heater_ratio]
        } else if temperature_k > self.cool_above_k {
            [self.cooler_w, -self.cooler_w * self.cooler_ratio]
        } else {
            [0.0, 0.0]
        }
    }

    /// Temperature after some time with a heat flow, in W, in K.
    pub fn after_k(&self, temperature_k: f64, air_k: f64, heat_w: f64, time_s: f64) -> f64 {
        let Self { heat_capacity_j_per_k: capacity, air_w_per_k: to_air, .. } = *self;
        if to_air == 0.0 {
            return temperature_k + heat_w * time_s / capacity;
        }
        let at_last_k = air_k + heat_w / to_air;
        at_last_k + (temperature_k - at_last_k) * libm::exp(-to_air * time_s / capacity)
    }

    /// Resistance, in Ω, and the powers that a battery gives and takes, in W, at a temperature and
    /// a state of charge.
    pub fn limits_at(&self, battery: &BatteryModel, temperature_k: f64, charge: f64) -> [f64; 3] {
        let temperature = Place::of(&self.temperature_k, temperature_k);
        let column = Place::of(&self.charge, charge);
        let [low, high] =
            temperature.ends().map(|row| column.of_table(&self.resistance_factor[row]));
        [
            battery.resistance_ohm * (low + (high - low) * temperature.share),
            battery.discharge_power_w * temperature.of_table(&self.discharge_share),
            battery.charge_power_w * temperature.of_table(&self.charge_share),
        ]
    }

    /// A battery as it is at a temperature and a state of charge.
    pub fn at(&self, battery: &BatteryModel, temperature_k: f64, charge: f64) -> BatteryModel {
        let [resistance_ohm, discharge_power_w, charge_power_w] =
            self.limits_at(battery, temperature_k, charge);
        // its tables are not needed, and cloning them would take longer than all else
        BatteryModel {
            capacity_j: battery.capacity_j,
            empty_voltage_v: battery.empty_voltage_v,
            full_voltage_v: battery.full_voltage_v,
            resistance_ohm,
            discharge_power_w,
            charge_power_w,
            minimum_charge: battery.minimum_charge,
            maximum_charge: battery.maximum_charge,
            charge_fade: battery.charge_fade,
            initial_charge: battery.initial_charge.clone(),
            ageing: None,
            thermal: None,
        }
    }
}

/// A place between two points of a table.
#[derive(Clone, Copy)]
struct Place {
    below: usize,
    above: usize,
    share: f64,
}

impl Place {
    fn of(points: &[f64], at: f64) -> Self {
        let above = points.partition_point(|point| *point <= at).min(points.len() - 1);
        let below = above.saturating_sub(1);
        let width = points[above] - points[below];
        let share = if width > 0.0 { ((at - points[below]) / width).clamp(0.0, 1.0) } else { 0.0 };
        Self { below, above, share }
    }

    fn ends(self) -> [usize; 2] {
        [self.below, self.above]
    }

    fn of_table(self, values: &[f64]) -> f64 {
        let [low, high] = self.ends().map(|at| values[at]);
        low + (high - low) * self.share
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::super::battery::tests::pack;
    use super::*;

    pub(crate) fn thermal() -> ThermalModel {
        ThermalModel {
            heat_capacity_j_per_k: 3.0e6,
            air_w_per_k: 40.0,
            heat_below_k: 283.15,
            heater_w: 10.0e3,
            heater_ratio: 1.0,
            cool_above_k: 306.15,
            cooler_w: 10.0e3,
            cooler_ratio: 3.0,
            precondition: None,
            temperature_k: vec![273.15, 293.15, 313.15],
            charge: vec![0.1, 0.5],
            resistance_factor: vec![vec![2.4, 1.6], vec![1.3, 1.0], vec![0.9, 0.8]],
            discharge_share: vec![0.6, 1.0, 1.0],
            charge_share: vec![0.3, 1.0, 1.0],
        }
    }

    #[test]
    fn warming_is_the_closed_form_and_keeps_its_heat() {
        let node = thermal();
        // an hour of 4 kW at −10 °C from 10 °C: by hand C dT/dt = 4000 − 40 (T − 263.15)
        let after_k = node.after_k(283.15, 263.15, 4000.0, 3600.0);
        let said_k = 363.15 + (283.15 - 363.15) * (-40.0 * 3600.0 / 3.0e6f64).exp();
        assert!((after_k - said_k).abs() < 1e-9);
        // many short spans are one long one
        let short_k = (0..3600).fold(283.15, |k, _| node.after_k(k, 263.15, 4000.0, 1.0));
        assert!((short_k - after_k).abs() < 1e-9);
        // what came in is kept or goes to the air, whose mean is that of many short spans
        let mut temperature_k = 283.15;
        let mut to_air_j = 0.0;
        for _ in 0..36_000 {
            let next_k = node.after_k(temperature_k, 263.15, 4000.0, 0.1);
            to_air_j += 40.0 * (0.5 * (temperature_k + next_k) - 263.15) * 0.1;
            temperature_k = next_k;
        }
        let open_j = 4000.0 * 3600.0 - to_air_j - 3.0e6 * (temperature_k - 283.15);
        assert!(open_j.abs() < 1e-6 * 4000.0 * 3600.0, "{open_j}");
        let closed = ThermalModel { air_w_per_k: 0.0, ..node };
        let warmer_k = closed.after_k(280.0, 263.15, 3000.0, 1000.0);
        assert!((warmer_k - 281.0).abs() < 1e-12);
    }

    #[test]
    fn a_battery_is_what_its_tables_say() {
        let (node, pack) = (thermal(), pack());
        let at = |kelvin: f64, charge: f64| node.at(&pack, kelvin, charge);
        assert_eq!(at(293.15, 0.5), pack);
        let cold = at(283.15, 0.3);
        // means of four numbers: 2.4, 1.6, 1.3, 1.0
        assert!((cold.resistance_ohm / pack.resistance_ohm - 1.575).abs() < 1e-12);
        assert!((cold.discharge_power_w / pack.discharge_power_w - 0.8).abs() < 1e-12);
        assert!((cold.charge_power_w / pack.charge_power_w - 0.65).abs() < 1e-12);
        // level beyond the tables
        assert_eq!(at(200.0, 0.0), at(273.15, 0.1));
        assert_eq!(at(400.0, 1.0), at(313.15, 0.5));
    }

    #[test]
    fn it_is_heated_where_cold_and_cooled_where_hot() {
        let node = thermal();
        assert_eq!(node.conditioning_w(283.0, false), [10e3, 10e3]);
        assert_eq!(node.conditioning_w(290.0, false), [0.0, 0.0]);
        assert_eq!(node.conditioning_w(307.0, false), [10e3, -30e3]);
        let ahead = PreconditionModel { up_to_k: 298.15, ahead_m: 30e3 };
        let warmer = ThermalModel { precondition: Some(ahead), ..node };
        assert_eq!(warmer.conditioning_w(290.0, true), [10e3, 10e3]);
        assert_eq!(warmer.conditioning_w(290.0, false), [0.0, 0.0]);
        assert_eq!(warmer.departure_k(250.0), 283.15);
        assert_eq!(warmer.departure_k(320.0), 306.15);
    }
}

//! Crests of predictive cruise control: where a truck may come over a crest so slowly that the
//! descent behind it gives the speed back, instead of the brakes taking it.
//!
//! Along the road, from where coasting in gear begins to accelerate the truck: v² grows by 2 a(v,
//! slope) dx until it no longer does. What comes above the upper edge of the band is taken off at
//! the crest, down to the lower edge at most. The rule reads the road and the truck's mass, drag
//! and engine, in air of 1.2 kg/m³ at rest.

use crate::operating_cycle::segments::Segment;
use crate::study::{Scenario, Study};
use crate::vehicle::resistance::{GRAVITY_MPS2, drag_force_n};

/// Half of the density of the air, in kg/m³.
const HALF_DENSITY_KGPM3: f64 = 0.6;

/// The truck as the rule knows it.
struct Coasting<'a> {
    study: &'a Study,
    scenario: &'a Scenario,
}

impl Coasting<'_> {
    /// Acceleration at a place in top gear without a pedal, in m/s².
    fn acceleration_mps2(&self, speed_mps: f64, slope: f64, position_m: f64) -> f64 {
        let vehicle = self.scenario.vehicle_at(position_m);
        let drag_n = drag_force_n(HALF_DENSITY_KGPM3, speed_mps, 0.0, vehicle.drag_area_m2);
        let rolling = vehicle.rolling_coefficient * (1.0 - slope * slope).sqrt();
        let weight_n = vehicle.mass_kg * GRAVITY_MPS2;
        let engine_n = self.study.vehicle().powertrain.coasting_force_n(speed_mps);
        let mass_kg = vehicle.mass_kg + self.study.vehicle().model.wheel_mass_kg();
        (engine_n - drag_n - weight_n * (rolling + slope)) / mass_kg
    }
}

/// The square of the speed that the rule allows at the start of each segment, in m²/s²; unbounded
/// where it says nothing. `limits`: the static limit of each segment, squared, and whether it is
/// that of a sign.
pub(crate) fn crest_speeds(
    study: &Study,
    scenario: &Scenario,
    segments: &[Segment],
    limits: &[(f64, bool)],
) -> Vec<f64> {
    let driver = &study.model().driver;
    let model = &driver.look_ahead;
    let over_mps = driver.pedals.overspeed_band_mps;
    let truck = Coasting { study, scenario };
    let slopes = &scenario.cycle.road.slopes;
    let slope_of = |segment: &Segment| slopes[segment.slope as usize];
    let mut allowed = vec![f64::INFINITY; segments.len()];
    let mut i = 1;
    while i < segments.len() {
        let (limit, by_sign) = limits[i];
        let speed_mps = limit.sqrt();
        let falls = |k: usize, squared: f64| {
            let segment = &segments[k];
            truck.acceleration_mps2(squared.sqrt(), slope_of(segment), segment.start_m)
        };
        let begins = falls(i, limit) > 0.0 && falls(i - 1, limits[i - 1].0) <= 0.0;
        if !(begins && by_sign && speed_mps > model.minimum_speed_mps) {
            i += 1;
            continue;
        }
        let (mut squared, mut highest, mut k) = (limit, limit, i);
        while k < segments.len() && limits[k] == (limit, by_sign) {
            let gained = 2.0 * falls(k, squared) * segments[k].length_m;
            if gained <= 0.0 {
                break;
            }
            squared += gained;
            highest = f64::max(highest, squared);
            k += 1;
        }
        let top_mps = speed_mps + over_mps;
        let lowest_mps = (speed_mps - model.underspeed_mps).max(0.0);
        let surplus = highest - top_mps * top_mps;
        if surplus > 0.0 {
            allowed[i] = (limit - surplus).max(lowest_mps * lowest_mps);
        }
        i = k.max(i + 1);
    }
    allowed
}

//! The outline of a cycle: the numbers that describe it before it is driven, drawn without its
//! road.
//!
//! A few microseconds each, where a drive takes milliseconds. The outline of a cycle is drawn from
//! the streams of the cycle itself, so it says what that cycle has; the outlines of the second
//! sample are independent of every cycle of the run, and their means are what the cycles' numbers
//! are expected to be (`fleet::adjustment`).

use super::{SimulationModel, Study};
use crate::distribution::Quantity;
use crate::random::nesting::Nesting;
use crate::random::sampling::{BATCH, Sampling};
use crate::random::{Factor, PickFreeze, StreamSet, Streams};
use crate::switch::ModelSwitch;

/// Numbers of an outline beside the shares of the road types.
const NUMBERS: [&str; 20] = [
    "payload_kg",
    "length_m",
    "rolling_factor",
    "drag_area_m2",
    "air_temperature_k",
    "wind_speed_mps",
    "head_wind_mps",
    "driver_deceleration_mps2",
    "driver_curve_speed_mps",
    "driver_acceleration_mps2",
    "driver_compliance",
    "engine_map_factor",
    "auxiliary_power_w",
    "route_climb_m",
    "traffic_density_per_m",
    "air_density_kgpm3",
    "driver_kp",
    "driver_is_pid",
    "rain_mps",
    "driver_curve_exponent",
];

/// Places of the numbers that have expectations of their own.
const PAYLOAD: usize = 0;
const LENGTH: usize = 1;

/// Longest way over which the expected shares of road types are followed step by step, in m; beyond
/// it they are those of the long run.
const LONGEST_FOLLOWED_M: f64 = 1.0e6;
/// Steps of that, and the shortest, in m.
const STEPS: f64 = 20_000.0;
const SHORTEST_STEP_M: f64 = 5.0;

/// Expectations of the numbers of an outline where they are known better than from draws:
/// the payload by the mean of its law, the shares of road types by the renewal equations of their
/// chain, given the length of the trip.
#[derive(Clone, Debug)]
pub struct OutlineExpectation {
    payload_kg: Option<f64>,
    /// Expected length of each road type, a row for each step of the way.
    lengths_m: Option<Vec<Vec<f64>>>,
    step_m: f64,
    long_run: Vec<f64>,
}

impl OutlineExpectation {
    /// Puts what is known into a drawn outline, in place of what was drawn.
    pub fn put_into(&self, outline: &mut [f64]) {
        if let Some(payload_kg) = self.payload_kg {
            outline[PAYLOAD] = payload_kg;
        }
        let Some(rows) = &self.lengths_m else { return };
        let length_m = outline[LENGTH];
        let last = rows.len() - 1;
        let place = (length_m / self.step_m).min(last as f64);
        let k = (place as usize).min(last - 1);
        let beyond_m = (length_m - last as f64 * self.step_m).max(0.0);
        let shares = &mut outline[NUMBERS.len()..];
        for (j, share) in shares.iter_mut().enumerate() {
            let (a, b) = (rows[k][j], rows[k + 1][j]);
            let expected_m = a + (place - k as f64) * (b - a) + beyond_m * self.long_run[j];
            *share = expected_m / length_m;
        }
    }
}

impl Study {
    /// Expectations of an outline's numbers that need no draws.
    pub fn outline_expectation(&self) -> OutlineExpectation {
        let SimulationModel { frozen, without, .. } = &self.model.simulation;
        let (sampler, law) = (&self.operating_cycle, &self.model.mission.payload_kg);
        let most_kg = self.model.vehicle.most_payload_kg();
        let is_drawn = sampler.draws_roads() && !frozen.contains(&Factor::Mission);
        let payload_kg = if without.contains(&ModelSwitch::PayloadSpread) {
            Some(law.centre().min(most_kg))
        } else {
            law.mean_below(most_kg)
        };
        let (_, longest_m) = self.model.mission.length_m.practical_range();
        let longest_m = longest_m.min(LONGEST_FOLLOWED_M);
        let step_m = (longest_m / STEPS).max(SHORTEST_STEP_M);
        let steps = (libm::ceil(longest_m / step_m) as usize).max(1);
        let road_is_drawn = sampler.draws_roads() && !frozen.contains(&Factor::Road);
        let several = self.road_types.len() > 1 && road_is_drawn;
        OutlineExpectation {
            payload_kg: payload_kg.filter(|_| is_drawn && !matches!(law, Quantity::Number(_))),
            lengths_m: several.then(|| sampler.road().expected_lengths_m(step_m, steps)).flatten(),
            step_m,
            long_run: sampler.road().share_by_length().to_vec(),
        }
    }

    /// Names of the numbers of an outline: those of every study, then the share of each road type
    /// but the last, which is what the others leave.
    pub fn outline_names(&self) -> Vec<String> {
        let types = &self.road_types[..self.road_types.len().saturating_sub(1)];
        let shares = types.iter().map(|name| format!("{name}_share"));
        NUMBERS.iter().map(|name| (*name).to_owned()).chain(shares).collect()
    }

    /// Draws the outline of a cycle of a run, in the order of [`Study::outline_names`].
    pub fn outline(&self, seed: u64, cycle_id: u64) -> Vec<f64> {
        self.outline_from(&self.streams(seed, cycle_id, PickFreeze::NONE))
    }

    /// Draws one batch of [`BATCH`] outlines of the second sample, spread evenly: each of a truck,
    /// a driver and a day of its own, on this trip of the study's calendar.
    pub fn outlines_of_second_sample(&self, seed: u64, batch: u64, trip: u64) -> Vec<Vec<f64>> {
        let nesting: Nesting = self.nesting.of_trip_alone(trip);
        let pick_freeze = PickFreeze { streams: StreamSet::ALL, cycle_id: None };
        let SimulationModel { frozen, .. } = &self.model.simulation;
        let outline = |cycle_id| {
            let (sampling, nesting) = (Sampling::Sobol, &nesting);
            let streams = Streams { seed, cycle_id, frozen, pick_freeze, sampling, nesting };
            self.outline_from(&streams)
        };
        (batch * BATCH..(batch + 1) * BATCH).map(outline).collect()
    }

    fn outline_from(&self, streams: &Streams) -> Vec<f64> {
        let without = &self.model.simulation.without;
        let cycle = self.operating_cycle.outline(streams, without);
        let driver = self.sample_driver(streams);
        let payload_kg = cycle.mission.payload_kg.min(self.model.vehicle.most_payload_kg());
        let vehicle = self.model.vehicle.sample(payload_kg, streams, without);
        let numbers: [f64; NUMBERS.len()] = [
            payload_kg,
            cycle.mission.length_m,
            vehicle.rolling_factor,
            vehicle.drag_area_m2,
            cycle.weather.temperature_k,
            cycle.weather.wind_speed_mps,
            cycle.head_wind_mps,
            driver.speed_change.deceleration_mps2,
            driver.curve_speed.reference_speed_mps,
            driver.speed_change.acceleration_mps2,
            driver.speed_limit.compliance,
            vehicle.map_factor,
            vehicle.auxiliary_power_w,
            cycle.route_climb_m,
            cycle.density_per_m,
            cycle.weather.air_density_kgpm3(0.0),
            driver.pedals.proportional,
            f64::from(driver.pedals.threshold_mps.is_none()),
            cycle.weather.precipitation_mps,
            driver.curve_speed.exponent,
        ];
        let shares = &cycle.type_shares[..cycle.type_shares.len().saturating_sub(1)];
        numbers.into_iter().chain(shares.iter().copied()).collect()
    }
}

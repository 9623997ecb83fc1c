//! What the step function reads of the road: one row of twelve numbers a segment.

use crate::road::surface::iri_mm_per_m;
use crate::study::{Scenario, Study};
use crate::tactical::SpeedProfile;
use crate::vehicle::resistance::{
    GRAVITY_MPS2, braking_friction, rolling_roughness_factor, rolling_temperature_factor,
    rolling_wet_factor,
};

/// The numbers of one segment.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct RoadRow(pub [f64; Self::COLUMNS]);

impl RoadRow {
    /// Where an empty lane stands.
    pub const PARKED: Self = Self([FAR, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, FAR, 1.0, -1.0]);
    /// Numbers in a row.
    pub const COLUMNS: usize = 12;
    /// Length, in m.
    pub const LENGTH: usize = 0;
    /// Static limit of v², in m²/s².
    pub const LIMIT: usize = 1;
    /// Braking branch of v² at the end, in m²/s².
    pub const BACKWARD: usize = 2;
    /// Accelerating branch of v² at the end, in m²/s².
    pub const FORWARD: usize = 3;
    /// g sin θ, in m/s².
    pub const GRADE: usize = 4;
    /// g cos θ times the rolling coefficient, in m/s².
    pub const ROLLING: usize = 5;
    /// Half the air density, in kg/m³.
    pub const HALF_DENSITY: usize = 6;
    /// Headwind beside the truck, in m/s.
    pub const HEAD_WIND: usize = 7;
    /// Cross wind beside the truck, without sign, in m/s.
    pub const CROSS_WIND: usize = 8;
    /// Distance from the end to the stop line, in m; [`FAR`] where it is not near.
    pub const TO_STOP: usize = 9;
    /// Deceleration that the tyres allow, in m/s².
    pub const GRIP: usize = 10;
    /// Standstill at the end, in s; negative where there is no stop.
    pub const DWELL: usize = 11;
}

impl RoadRow {
    /// The row in groups of four numbers.
    #[inline(always)]
    pub fn quads(&self) -> &[[f64; 4]] {
        self.0.as_chunks().0
    }
}

/// A distance or a squared speed that never binds.
pub const FAR: f64 = 1e9;

/// The rows of one scenario, and what the record says about its road.
#[derive(Clone, Debug, Default)]
pub struct RoadRows {
    /// One row a segment.
    pub rows: Vec<RoadRow>,
    /// Mean air temperature along the road, in K.
    pub air_temperature_k: f64,
    /// Mean headwind beside the truck along the road, in m/s.
    pub head_wind_mps: f64,
    /// Sum of the climbs, in m.
    pub climb_m: f64,
}

impl RoadRows {
    /// Writes the rows of a planned scenario; the buffers are reused.
    pub fn fill(&mut self, study: &Study, scenario: &Scenario, profile: &SpeedProfile) {
        let (cycle, vehicle) = (&scenario.cycle, &scenario.vehicle);
        let road = &cycle.road;
        let model = &study.powertrain().model;
        let types = study.operating_cycle().road().types();
        self.rows.clear();
        self.rows.reserve(profile.segments.len());
        let (mut temperature_sum, mut wind_sum, mut climb_sum) = (0.0, 0.0, 0.0);
        let mut heading = road.heading_rad;
        let mut altitude_m = 0.0;
        // what changes with the weather, the surface and the wind's angle, kept from row to row
        let (mut weather_key, mut half_density, mut rolling_weather, mut grip) =
            (u32::MAX, 0.0, 0.0, 0.0);
        let (mut roughness_key, mut iri) = (u32::MAX, 0.0);
        let (mut wind_key, mut head_wind, mut cross_wind) = ((u32::MAX, 0, 0u64), 0.0, 0.0);

        for (segment, branch) in profile.segments.iter().zip(&profile.branches) {
            let length_m = segment.length_m;
            let weather = &cycle.weather[segment.weather as usize].weather;
            if segment.weather != weather_key {
                weather_key = segment.weather;
                half_density = 0.5 * weather.air_density_kgpm3(altitude_m);
                let coefficient = model.rolling_temperature_coefficient_per_k;
                rolling_weather = vehicle.rolling_coefficient
                    * rolling_temperature_factor(weather.temperature_k, coefficient)
                    * rolling_wet_factor(weather.precipitation_mps, weather.snow);
                grip = GRAVITY_MPS2 * braking_friction(weather.precipitation_mps, weather.snow);
            }
            if segment.roughness != roughness_key {
                roughness_key = segment.roughness;
                iri = iri_mm_per_m(road.roughness_m3[segment.roughness as usize]);
            }
            // a left curve turns the compass heading back
            let turn =
                segment.curve().map_or(0.0, |k| -road.curves[k].curvature_per_m() * length_m);
            let middle = heading + 0.5 * turn;
            heading += turn;
            let key = (segment.weather, segment.section, middle.to_bits());
            if key != wind_key {
                wind_key = key;
                let road_type = road.sections[segment.section as usize].road_type;
                let exposure = types[road_type].wind_exposure;
                let (head, cross) = weather.wind_components_mps(middle);
                (head_wind, cross_wind) = (exposure * head, exposure * cross.abs());
            }
            let sine = road.slopes[segment.slope as usize];
            let cosine = (1.0 - sine * sine).sqrt();
            let ground = road.grounds[segment.section as usize].rolling_factor();
            let rough = rolling_roughness_factor(iri, branch.limit.sqrt());

            altitude_m += sine * length_m;
            climb_sum += sine.max(0.0) * length_m;
            temperature_sum += weather.temperature_k * length_m;
            wind_sum += head_wind * length_m;
            self.rows.push(RoadRow([
                length_m,
                branch.limit,
                branch.backward_end,
                branch.forward_start + profile.twice_acceleration * length_m,
                GRAVITY_MPS2 * sine,
                GRAVITY_MPS2 * cosine * rolling_weather * ground * rough,
                half_density,
                head_wind,
                cross_wind,
                FAR,
                grip * cosine,
                -1.0,
            ]));
        }
        self.mark_stops(study, scenario, profile);
        self.air_temperature_k = temperature_sum / road.length_m;
        self.head_wind_mps = wind_sum / road.length_m;
        self.climb_m = climb_sum;
    }

    /// Writes dwell times and distances to stop lines, from the end back.
    fn mark_stops(&mut self, study: &Study, scenario: &Scenario, profile: &SpeedProfile) {
        let creep_m = study.model().simulation.creep_distance_m;
        let events = &scenario.cycle.road.events;
        let mut beyond_m = FAR;
        for i in (0..self.rows.len()).rev() {
            let row = &mut self.rows[i].0;
            let last = i + 1 == profile.segments.len();
            let dwell_s = if last {
                Some(0.0)
            } else {
                profile.segments[i + 1].event().and_then(|k| events[k].kind.standstill_s())
            };
            if let Some(dwell_s) = dwell_s {
                row[RoadRow::DWELL] = dwell_s;
                beyond_m = 0.0;
            }
            row[RoadRow::TO_STOP] = if beyond_m <= creep_m { beyond_m } else { FAR };
            beyond_m += row[RoadRow::LENGTH];
        }
    }
}

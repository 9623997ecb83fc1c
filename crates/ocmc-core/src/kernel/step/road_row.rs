//! Road as the step function reads it: one row of twelve numbers for each segment.

use crate::lanes::{Flags, Lanes, UNBOUNDED};
use crate::operating_cycle::road::surface::iri_mm_per_m;
use crate::operating_cycle::segments::Segment;
use crate::operating_cycle::weather::Weather;
use crate::study::{Scenario, Study};
use crate::tactical::SpeedProfile;
use crate::vehicle::resistance::{
    GRAVITY_MPS2, braking_friction, cornering_resistance_mps2, rolling_roughness_factor,
    rolling_temperature_factor, rolling_wet_factor,
};
use fearless_simd::prelude::*;

/// The numbers of one segment.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct RoadRow(pub [f64; Self::COLUMNS]);

impl RoadRow {
    /// Where an empty lane stands.
    pub const PARKED: Self =
        Self([UNBOUNDED, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, UNBOUNDED, 1.0, -1.0]);
    /// Numbers in a row.
    pub const COLUMNS: usize = 12;
    /// Length, in m.
    pub const LENGTH: usize = 0;
    /// Static limit of v², in m²/s².
    pub const LIMIT: usize = 1;
    /// Braking branch of v² at the end, in m²/s².
    pub const BACKWARD: usize = 2;
    /// Static limit, in m/s: above zero where it is that of a sign or of the truck, below where it
    /// is that of a curve or of traffic. Read by [`Self::static_mps`].
    const STATIC: usize = 3;
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
    /// Distance from the end to the stop line, in m; [`UNBOUNDED`] where it is not near.
    pub const TO_STOP: usize = 9;
    /// Deceleration that the tyres allow, in m/s².
    pub const GRIP: usize = 10;
    /// Standstill at the end, in s; where there is no stop −1 − v², v the speed to which the truck
    /// may coast ahead of the next braking ramp: all of them are below zero. Read by
    /// [`Self::dwell_s`].
    const DWELL: usize = 11;

    /// Static limit, in m/s, whatever sets it.
    pub fn static_mps(&self) -> f64 {
        self.0[Self::STATIC].abs()
    }

    /// Sets the static limit, in m/s: that of a sign or of the truck, or that of a curve or of
    /// traffic.
    pub fn set_static(&mut self, speed_mps: f64, is_sign: bool) {
        self.0[Self::STATIC] = signed_static(speed_mps, is_sign);
    }

    /// Standstill at the stop line where the row ends, in s; none where it ends at no line.
    pub fn dwell_s(&self) -> Option<f64> {
        let dwell_s = self.0[Self::DWELL];
        (dwell_s >= 0.0).then_some(dwell_s)
    }

    /// The row ends at a stop line, where the truck stands for some time, in s.
    pub fn set_stop(&mut self, dwell_s: f64) {
        self.0[Self::DWELL] = dwell_s;
    }

    /// The row ends at no stop line; ahead of the next braking ramp the truck may coast to a speed,
    /// whose square is given, in m²/s².
    pub fn set_coasting(&mut self, speed_squared: f64) {
        self.0[Self::DWELL] = coasting(speed_squared);
    }

    /// The row in groups of four numbers.
    #[inline(always)]
    pub fn quads(&self) -> &[[f64; 4]] {
        self.0.as_chunks().0
    }
}

fn signed_static(speed_mps: f64, is_sign: bool) -> f64 {
    if is_sign { speed_mps } else { -speed_mps }
}

fn coasting(speed_squared: f64) -> f64 {
    -1.0 - speed_squared
}

/// The road rows under the trucks, by the columns of [`RoadRow`].
pub(super) type RoadRowLanes<S> = [Lanes<S>; RoadRow::COLUMNS];

/// Static limits under the trucks, in m/s, whatever sets them.
#[inline(always)]
pub(super) fn static_limit<S: Simd>(row: &RoadRowLanes<S>) -> Lanes<S> {
    row[RoadRow::STATIC].abs()
}

/// Flag: the static limit under a truck is that of a sign or of the truck.
#[inline(always)]
pub(super) fn is_limited_by_sign<S: Simd>(row: &RoadRowLanes<S>) -> Flags<S> {
    row[RoadRow::STATIC].simd_gt(0.0)
}

/// Square of the speed to which a truck may coast, in m²/s²: `stop` before a stop line.
#[inline(always)]
pub(super) fn coasting_target<S: Simd>(row: &RoadRowLanes<S>, stop: Lanes<S>) -> Lanes<S> {
    let dwell = row[RoadRow::DWELL];
    dwell.simd_lt(0.0).select(-1.0 - dwell, stop)
}

/// Climb after which the air density is taken anew, in m: it has changed by 0.6 %.
const SAME_AIR_M: f64 = 50.0;

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
    /// Rows that end at a stop line, the standstill there, in s, and the event, but at the road's
    /// end.
    pub(crate) stops: Vec<(usize, f64, Option<usize>)>,
    /// Rows with which a section begins, and its road type.
    pub road_types: Vec<(usize, usize)>,
}

impl RoadRows {
    /// Writes the rows of a planned scenario; the buffers are reused.
    pub fn fill(&mut self, study: &Study, scenario: &Scenario, profile: &SpeedProfile) {
        let (rows, stops) = (&mut self.rows, &mut self.stops);
        let (segments, road) = (&profile.segments, &scenario.cycle.road);
        let mut around = Surroundings::new(study, scenario);
        let (mut altitude_m, mut climb_m) = (0.0, 0.0);
        let road_types = &mut self.road_types;
        // all are written anew
        rows.resize(segments.len(), RoadRow::PARKED);
        stops.clear();
        road_types.clear();
        for run in profile.runs.windows(2) {
            let (first, end) = (run[0], run[1]);
            let (segments, branches) = (&segments[first..end], &profile.branches[first..end]);
            let (head, limit) = (&segments[0], branches[0].limit);
            let stops_at = head.event().map(|k| &road.events[k]);
            if let Some(load) = stops_at.and_then(|event| scenario.load_from(event.position_m)) {
                around.carry(load.vehicle.rolling_coefficient);
            }
            if around.differ(head, limit, altitude_m) && around.update(head, limit, altitude_m) {
                road_types.push((first, road.sections[head.section as usize].road_type));
            }
            if let Some(k) = head.event()
                && let Some(dwell_s) = scenario.passage(k).standstill_s()
                && first > 0
            {
                stops.push((first - 1, dwell_s, Some(k)));
            }
            let turns = head.curve().is_some();
            let ahead = segments.iter().zip(branches).zip(&mut rows[first..end]).enumerate();
            for (i, ((segment, branch), row)) in ahead {
                // the heading changes along a curve, the density of the air with the altitude
                if i > 0 && (turns || around.has_climbed(altitude_m)) {
                    around.update(segment, limit, altitude_m);
                }
                let length_m = segment.length_m;
                // segments of one slope step follow one another where a road is cut
                let sine = road.slopes[segment.slope as usize];
                let cosine = (1.0 - sine * sine).sqrt();
                altitude_m += sine * length_m;
                climb_m += if sine > 0.0 { sine * length_m } else { 0.0 };
                *row = RoadRow([
                    length_m,
                    limit,
                    branch.backward_end,
                    signed_static(limit.sqrt(), branches[0].by_sign),
                    GRAVITY_MPS2 * sine,
                    around.rolling * cosine,
                    around.half_density,
                    around.head_wind_mps,
                    around.cross_wind_mps,
                    UNBOUNDED,
                    around.grip * cosine,
                    coasting(branch.coasts_to),
                ]);
            }
        }
        stops.push((rows.len() - 1, 0.0, None));
        self.mark_stops(study.model().simulation.creep_distance_m);
        around.add_to_means(road.length_m);
        self.air_temperature_k = around.temperature_sum / road.length_m;
        self.head_wind_mps = around.head_wind_sum / road.length_m;
        self.climb_m = climb_m;
    }

    /// Rows that end at a stop line, in order.
    pub fn stop_rows(&self) -> Vec<usize> {
        self.stops.iter().map(|stop| stop.0).collect()
    }

    /// The same, and the event there, but at the road's end.
    pub fn stop_rows_and_events(&self) -> Vec<(usize, Option<usize>)> {
        self.stops.iter().map(|stop| (stop.0, stop.2)).collect()
    }

    /// The event at whose stop line a row ends.
    pub fn event_after(&self, row: usize) -> Option<usize> {
        self.stops.iter().find(|stop| stop.0 == row)?.2
    }

    /// Writes dwell times, and distances to stop lines from the rows that end near one.
    fn mark_stops(&mut self, near_m: f64) {
        for &(last, dwell_s, _) in &self.stops {
            self.rows[last].set_stop(dwell_s);
            let mut beyond_m = 0.0;
            for row in self.rows[..=last].iter_mut().rev() {
                let is_another = beyond_m > 0.0 && row.dwell_s().is_some();
                if beyond_m > near_m || is_another {
                    break;
                }
                row.0[RoadRow::TO_STOP] = beyond_m;
                beyond_m += row.0[RoadRow::LENGTH];
            }
        }
    }
}

/// Values that rows take from weather, surface and speed limit: they hold over many segments.
struct Surroundings<'a> {
    study: &'a Study,
    scenario: &'a Scenario,
    /// Weather, roughness, section and curve here, and the static limit of v², in m²/s².
    tracks: [u32; 3],
    curve: Option<usize>,
    limit: f64,
    /// Where they began to hold, in m, and the altitude over the start at which the air density was
    /// taken, in m.
    since_m: f64,
    air_altitude_m: f64,
    /// Compass heading in the middle of the segment and at its end, in rad.
    middle_rad: f64,
    heading_rad: f64,
    /// Rolling coefficient of the truck as it is loaded here.
    rolling_coefficient: f64,
    /// Rolling on a smooth road in this weather.
    rolling_weather: f64,
    /// Values of [`RoadRow`], rolling and grip for a level road.
    rolling: f64,
    half_density: f64,
    head_wind_mps: f64,
    cross_wind_mps: f64,
    grip: f64,
    temperature_k: f64,
    /// Temperature and headwind times the length that they held over.
    temperature_sum: f64,
    head_wind_sum: f64,
}

impl<'a> Surroundings<'a> {
    fn new(study: &'a Study, scenario: &'a Scenario) -> Self {
        Self {
            study,
            scenario,
            tracks: [u32::MAX; 3],
            curve: None,
            limit: 0.0,
            since_m: 0.0,
            air_altitude_m: 0.0,
            middle_rad: f64::NAN,
            rolling_coefficient: scenario.vehicle.rolling_coefficient,
            rolling_weather: 0.0,
            heading_rad: scenario.cycle.road.heading_rad,
            rolling: 0.0,
            half_density: 0.0,
            head_wind_mps: 0.0,
            cross_wind_mps: 0.0,
            grip: 0.0,
            temperature_k: 0.0,
            temperature_sum: 0.0,
            head_wind_sum: 0.0,
        }
    }

    /// From here on the truck carries another load.
    fn carry(&mut self, rolling_coefficient: f64) {
        self.rolling_coefficient = rolling_coefficient;
        // it is taken with the weather
        self.tracks[0] = u32::MAX;
    }

    /// Whether a segment differs from the one before, turns the heading, or lies elsewhere in
    /// altitude.
    #[inline(always)]
    fn differ(&self, segment: &Segment, limit: f64, altitude_m: f64) -> bool {
        let tracks = [segment.weather, segment.roughness, segment.section];
        segment.curve().is_some()
            || self.curve.is_some()
            || tracks != self.tracks
            || limit != self.limit
            || self.has_climbed(altitude_m)
    }

    #[inline(always)]
    fn has_climbed(&self, altitude_m: f64) -> bool {
        (altitude_m - self.air_altitude_m).abs() > SAME_AIR_M
    }

    /// Takes them at a segment; returns whether it is of another section.
    #[inline(never)]
    fn update(&mut self, segment: &Segment, limit: f64, altitude_m: f64) -> bool {
        self.add_to_means(segment.start_m);
        let road = &self.scenario.cycle.road;
        let weather = &self.scenario.cycle.weather[segment.weather as usize].weather;
        let [last_weather, _, last_section] = self.tracks;
        let new_weather = segment.weather != last_weather;
        if new_weather || self.has_climbed(altitude_m) {
            self.set_weather(weather, altitude_m);
        }
        let tracks = [segment.weather, segment.roughness, segment.section];
        // along a curve nothing but the heading changes
        if (tracks, limit, segment.curve()) != (self.tracks, self.limit, self.curve) {
            self.set_rolling(segment, limit);
        }

        let (curve, last_heading_rad) = (segment.curve(), self.middle_rad);
        // a left curve turns the compass heading back
        let turn_rad = curve.map_or(0.0, |k| -road.curves[k].curvature_per_m() * segment.length_m);
        self.middle_rad = self.heading_rad + 0.5 * turn_rad;
        self.heading_rad += turn_rad;
        if new_weather || segment.section != last_section || self.middle_rad != last_heading_rad {
            let road_type = road.sections[segment.section as usize].road_type;
            let exposure = self.study.operating_cycle().road().types()[road_type].wind_exposure;
            let (head, cross) = weather.wind_components_mps(self.middle_rad);
            (self.head_wind_mps, self.cross_wind_mps) = (exposure * head, exposure * cross.abs());
        }
        (self.tracks, self.curve, self.limit) = (tracks, curve, limit);
        segment.section != last_section
    }

    fn set_rolling(&mut self, segment: &Segment, limit: f64) {
        let road = &self.scenario.cycle.road;
        let iri = iri_mm_per_m(road.roughness_m3[segment.roughness as usize]);
        self.rolling = self.rolling_weather
            * road.grounds[segment.section as usize].rolling_factor()
            * rolling_roughness_factor(iri, limit.sqrt());
        let vehicle = &self.study.vehicle().model;
        if let (Some(k), Some(stiffness)) = (segment.curve(), vehicle.cornering_stiffness_per_rad) {
            // at the static limit, and within what the tyres hold
            let lateral = (limit * road.curves[k].curvature_per_m().abs()).min(self.grip);
            self.rolling += cornering_resistance_mps2(lateral, stiffness);
        }
    }

    fn set_weather(&mut self, weather: &Weather, altitude_m: f64) {
        let vehicle = &self.study.vehicle().model;
        self.half_density = 0.5 * weather.air_density_kgpm3(altitude_m);
        self.air_altitude_m = altitude_m;
        self.temperature_k = weather.temperature_k;
        self.grip = GRAVITY_MPS2 * braking_friction(weather.precipitation_mps, weather.snow);
        let coefficient = vehicle.rolling_temperature_coefficient_per_k;
        self.rolling_weather = GRAVITY_MPS2
            * self.rolling_coefficient
            * rolling_temperature_factor(weather.temperature_k, coefficient)
            * rolling_wet_factor(weather.precipitation_mps, weather.snow);
    }

    /// Adds what held up to here to the means.
    fn add_to_means(&mut self, here_m: f64) {
        let length_m = here_m - self.since_m;
        self.temperature_sum += self.temperature_k * length_m;
        self.head_wind_sum += self.head_wind_mps * length_m;
        self.since_m = here_m;
    }
}

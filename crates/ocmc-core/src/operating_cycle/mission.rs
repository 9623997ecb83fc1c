//! Mission: length, payload, departure and stops with dwell.
//!
//! Streams `MissionLength`, `Payload`, `Departure` and `MissionStop`. Checked through the moments
//! of the laws, and through whole runs of `urban-delivery`, the built-in study with stops. What
//! happens at the stops is in [`super::mission_part`].

use super::mission_part::{CargoModel, MissionPart, PowerTakeOffModel};
use crate::distribution::Quantity;
use crate::operating_cycle::road::point_event::{EventKind, PointEvent};
use crate::operating_cycle::route::RouteModel;
use crate::random::{Draws, Stream, Streams};
use crate::switch::ModelSwitch;
use crate::validation::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Stops that a law draws closer than this are moved apart, in m.
pub(crate) const MINIMUM_SPACING_M: f64 = 50.0;

/// Statistical description of missions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MissionModel {
    /// Length, in m.
    #[schemars(range(min = 200.0, max = 5.0e6), extend("usual" = [1000.0, 2e6]))]
    pub length_m: Quantity,
    /// Payload, in kg.
    #[schemars(range(min = 0.0, max = 100_000.0), extend("usual" = [100.0, 60e3]))]
    pub payload_kg: Quantity,
    /// Departure, in s from midnight; a draw outside the day is wrapped into it.
    #[schemars(range(min = -86_400.0, max = 172_800.0))]
    pub departure_s_of_day: Quantity,
    /// Day of the year, from 0.
    #[schemars(range(min = 0.0, max = 366.0))]
    pub departure_day_of_year: Quantity,
    /// Stops of the mission; absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stops: Option<MissionStopModel>,
    /// Given operating cycles to drive instead of drawn roads; absent: none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub routes: Vec<RouteModel>,
    /// Whether cycle k drives route k, counted on from the first one behind the last, instead of
    /// one drawn by weight; absent: false.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub routes_in_turn: bool,
}

/// Stops of a mission.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MissionStopModel {
    /// Distance from one stop to the next, in m.
    #[schemars(range(min = 0.0, max = 5.0e6))]
    pub spacing_m: Quantity,
    /// Dwell, in s.
    #[schemars(range(min = 0.0, max = 86_400.0), extend("usual" = [10.0, 43200.0]))]
    pub dwell_s: Quantity,
    /// Cargo that is unloaded and loaded there; absent: the payload stays as it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cargo: Option<CargoModel>,
    /// Work of a body, such as a crane or a tank pump; absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub power_take_off: Option<PowerTakeOffModel>,
}

/// A realised mission.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mission {
    /// Length, in m.
    pub length_m: f64,
    /// Payload at departure, in kg.
    pub payload_kg: f64,
    /// Departure, in s from midnight.
    pub departure_s: f64,
    /// Day of the year, from 0.
    pub day_of_year: f64,
    /// Stops with their dwell.
    pub stops: Vec<PointEvent>,
    /// Parts of the mission behind its stops, in order; none where nothing changes there.
    pub parts: Vec<MissionPart>,
}

impl MissionModel {
    /// Stops that are given a fixed distance lie so far apart, and their cargo is said once.
    pub fn validate(&self, problems: &mut Problems) {
        let Some(stops) = &self.stops else { return };
        if let Quantity::Number(spacing_m) = stops.spacing_m {
            problems.require(
                spacing_m >= MINIMUM_SPACING_M,
                "stops.spacing_m",
                spacing_m,
                "50 to 5000000; the draws of a law below 50 are put there",
            );
        }
        problems.part_if("stops.cargo", stops.cargo.as_ref(), CargoModel::validate);
    }

    /// Draws a mission, of `given_length_m` where the road is given. Without
    /// [`ModelSwitch::PayloadSpread`] every truck carries the mean payload.
    pub fn sample(
        &self,
        given_length_m: Option<f64>,
        streams: &Streams,
        without: &[ModelSwitch],
    ) -> Mission {
        let draw = || self.length_m.drawn(true, streams, Stream::MissionLength);
        let length_m = given_length_m.unwrap_or_else(draw);
        let spread = !without.contains(&ModelSwitch::PayloadSpread);
        let payload_kg = self.payload_kg.drawn(spread, streams, Stream::Payload);
        let mut draws = streams.open(Stream::Departure);
        let mut departure =
            |law: &Quantity| law.sample_once(streams, Stream::Departure, &mut draws);
        let clock = departure(&self.departure_s_of_day) + streams.departure_offset_s();
        let departure_s = clock - 86_400.0 * libm::floor(clock / 86_400.0);
        let drawn_day = libm::floor(departure(&self.departure_day_of_year));
        let day_of_year = streams.day_of_year().unwrap_or(drawn_day);

        let mut stops = Vec::new();
        if let Some(model) = &self.stops {
            let mut draws = streams.open(Stream::MissionStop);
            let spacing_m =
                |draws: &mut Draws| model.spacing_m.sample(draws).max(MINIMUM_SPACING_M);
            let mut position_m = spacing_m(&mut draws);
            while position_m < length_m {
                let standstill_s = model.dwell_s.sample(&mut draws);
                let kind = EventKind::MissionStop { standstill_s };
                stops.push(PointEvent { position_m, kind, turns: false });
                position_m += spacing_m(&mut draws);
            }
        }
        Mission { length_m, payload_kg, departure_s, day_of_year, stops, parts: Vec::new() }
    }
}

//! The streams of draws, and the factors that they belong to.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One sampled factor. The number is part of the stream's key: append, never renumber.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
#[repr(u8)]
pub enum Stream {
    /// Sequence and lengths of road types.
    RoadType = 0,
    /// Speed signs.
    SpeedSign = 1,
    /// Curve positions, radii, lengths and directions.
    Curve = 2,
    /// Slope of the road.
    Topography = 3,
    /// Stop signs and their marks.
    StopSign = 4,
    /// Give-way signs and their marks.
    GiveWay = 5,
    /// Traffic lights and their marks.
    TrafficLight = 6,
    /// Speed bumps and their marks.
    SpeedBump = 7,
    /// Turns taken at junctions.
    JunctionTurn = 8,
    /// Roughness blocks.
    Roughness = 9,
    /// Ground types.
    Ground = 10,
    /// Compass heading at the start.
    Heading = 11,
    /// Air temperature.
    Temperature = 12,
    /// Air pressure.
    Pressure = 13,
    /// Relative humidity.
    Humidity = 14,
    /// Rain and snow.
    Precipitation = 15,
    /// Wind speed and direction.
    Wind = 16,
    /// Traffic density.
    Traffic = 17,
    /// Length of the mission.
    MissionLength = 18,
    /// Payload.
    Payload = 19,
    /// Day and time of departure.
    Departure = 20,
    /// Mission stops and dwell times.
    MissionStop = 21,
    /// The driver's curve-speed parameters.
    CurveSpeed = 22,
    /// The residual of each curve.
    CurveResidual = 23,
    /// The driver's decelerations and accelerations.
    SpeedChange = 24,
    /// Compliance with speed limits.
    Compliance = 25,
    /// Pedal controller and its gains.
    Pedals = 26,
    /// Comfort at speed bumps.
    BumpComfort = 27,
    /// The truck: drag area, rolling, auxiliaries, engine.
    Vehicle = 28,
    /// Parameter uncertainty of the curve-speed fit, keyed by replicate and not by cycle.
    CurveSpeedParameters = 29,
    /// Choice of a route among several given ones.
    Route = 30,
    /// Resampling of rows for bootstrap intervals, keyed by replicate and not by cycle. Belongs to
    /// no cycle.
    Bootstrap = 31,
    /// A battery-electric powertrain: state of charge at departure, auxiliaries.
    Electric = 32,
    /// Railway crossings and their marks.
    RailwayCrossing = 33,
    /// Where the driver's wanted speed changes at a sign.
    SignOffset = 34,
    /// By how much what a truck meets or carries differs from its fleet's.
    TruckEffect = 35,
    /// Choice of the driver of a pool who makes a trip.
    DriverAssignment = 36,
    /// Prices, keyed by replicate and not by cycle: a price is a state of the world.
    Price = 37,
    /// Public chargers along the way, and the waits there.
    Charger = 38,
    /// Cargo and work of the body at stops of the mission.
    MissionPart = 39,
    /// Places of judged numbers and noises of weights and fuel in the members of a calibration's
    /// design, keyed by member and not by cycle. Belongs to no cycle.
    Calibration = 40,
}

/// A group of streams that is frozen, and turned off, together.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, PartialOrd, Ord,
)]
#[serde(rename_all = "snake_case")]
pub enum Factor {
    /// Road types, signs, curves, topography, events, surface, public chargers.
    Road,
    /// Temperature, pressure, humidity, precipitation, wind.
    Weather,
    /// Traffic density.
    Traffic,
    /// Length, payload, departure, mission stops.
    Mission,
    /// The whole driver.
    Driver,
    /// Drag area, rolling, auxiliaries, engine.
    Vehicle,
}

/// The streams in the order of their numbers, each with its factor.
const FACTORS: [(Stream, Option<Factor>); 41] = [
    (Stream::RoadType, Some(Factor::Road)),
    (Stream::SpeedSign, Some(Factor::Road)),
    (Stream::Curve, Some(Factor::Road)),
    (Stream::Topography, Some(Factor::Road)),
    (Stream::StopSign, Some(Factor::Road)),
    (Stream::GiveWay, Some(Factor::Road)),
    (Stream::TrafficLight, Some(Factor::Road)),
    (Stream::SpeedBump, Some(Factor::Road)),
    (Stream::JunctionTurn, Some(Factor::Road)),
    (Stream::Roughness, Some(Factor::Road)),
    (Stream::Ground, Some(Factor::Road)),
    (Stream::Heading, Some(Factor::Road)),
    (Stream::Temperature, Some(Factor::Weather)),
    (Stream::Pressure, Some(Factor::Weather)),
    (Stream::Humidity, Some(Factor::Weather)),
    (Stream::Precipitation, Some(Factor::Weather)),
    (Stream::Wind, Some(Factor::Weather)),
    (Stream::Traffic, Some(Factor::Traffic)),
    (Stream::MissionLength, Some(Factor::Mission)),
    (Stream::Payload, Some(Factor::Mission)),
    (Stream::Departure, Some(Factor::Mission)),
    (Stream::MissionStop, Some(Factor::Mission)),
    (Stream::CurveSpeed, Some(Factor::Driver)),
    (Stream::CurveResidual, Some(Factor::Driver)),
    (Stream::SpeedChange, Some(Factor::Driver)),
    (Stream::Compliance, Some(Factor::Driver)),
    (Stream::Pedals, Some(Factor::Driver)),
    (Stream::BumpComfort, Some(Factor::Driver)),
    (Stream::Vehicle, Some(Factor::Vehicle)),
    (Stream::CurveSpeedParameters, Some(Factor::Driver)),
    (Stream::Route, Some(Factor::Road)),
    (Stream::Bootstrap, None),
    (Stream::Electric, Some(Factor::Vehicle)),
    (Stream::RailwayCrossing, Some(Factor::Road)),
    (Stream::SignOffset, Some(Factor::Driver)),
    (Stream::TruckEffect, None),
    (Stream::DriverAssignment, None),
    (Stream::Price, None),
    (Stream::Charger, Some(Factor::Road)),
    (Stream::MissionPart, Some(Factor::Mission)),
    (Stream::Calibration, None),
];

impl Stream {
    /// All streams, in the order of their numbers.
    pub const ALL: [Self; FACTORS.len()] = {
        let mut all = [Self::RoadType; FACTORS.len()];
        let mut k = 0;
        while k < all.len() {
            all[k] = FACTORS[k].0;
            assert!(all[k] as usize == k, "the order of the streams");
            k += 1;
        }
        all
    };

    /// The factor that this stream belongs to; none for what is no part of a cycle.
    pub fn factor(self) -> Option<Factor> {
        FACTORS[self as usize].1
    }
}

//! The fleet of a study: how many trips a truck makes, who drives it, when, and at which level
//! quantities are drawn.

use crate::powertrain::TRUCK_LAWS;
use crate::random::Stream;
use crate::random::nesting::{Drivers, Level, Nesting, OperatingDays};
use crate::validation::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

/// Trucks that make several trips. Absent: each trip has a truck and a driver of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FleetModel {
    /// Trips per truck.
    #[schemars(range(min = 1.0, max = 1.0e6))]
    pub trips_per_truck: u64,
    /// Drivers per truck, who take turns from trip to trip.
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub drivers_per_truck: u64,
    /// Drivers of a pool that all trucks share, each trip drawing one of them; absent: each truck
    /// has drivers of its own.
    #[schemars(range(min = 1.0, max = 1.0e6))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub driver_pool: Option<u64>,
    /// Levels of streams that are drawn at another one than usual, as in `{ payload = "truck" }`.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub levels: BTreeMap<Stream, Level>,
    /// Days on which trucks drive; absent: each trip draws its day by itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub calendar: Option<CalendarModel>,
}

impl Default for FleetModel {
    fn default() -> Self {
        Self {
            trips_per_truck: 1,
            drivers_per_truck: 1,
            driver_pool: None,
            levels: BTreeMap::new(),
            calendar: None,
        }
    }
}

/// Days on which trucks drive: trips follow one another through the year, from its first day on,
/// which is the first of a week.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CalendarModel {
    /// Days of a week on which trucks drive, its first ones; on the others they are at the depot.
    #[schemars(range(min = 1.0, max = 7.0))]
    pub operating_days_per_week: u64,
    /// Trips of a truck on such a day.
    #[schemars(range(min = 1.0, max = 100.0))]
    pub trips_per_day: u64,
    /// From one departure of a day to the next, in s; absent where a truck makes one trip a day.
    #[schemars(range(min = 0.0, max = 86_400.0))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub departure_interval_s: Option<f64>,
    /// Whether trucks that drive on the same day meet the same weather by the clock; absent: each
    /// trip has its own.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub shared_weather: bool,
    /// Whether they meet the same deviation of the traffic by the clock; absent: each trip has its
    /// own.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub shared_traffic: bool,
    /// Whether a truck's trips chain: it departs with what its depot has charged by then, its
    /// drivers go on with their clocks, and who comes back late departs late; absent: each trip
    /// stands alone.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub chain: bool,
}

/// Streams of the weather.
const WEATHER: [Stream; 5] =
    [Stream::Temperature, Stream::Pressure, Stream::Humidity, Stream::Precipitation, Stream::Wind];

/// Quantities that a trip has once: laws whose level may be set.
const ONCE_A_TRIP: &[&str] = &[
    "mission.length_m",
    "mission.payload_kg",
    "mission.departure_s_of_day",
    "mission.departure_day_of_year",
    "driver.speed_change.deceleration_mps2",
    "driver.speed_change.acceleration_mps2",
    "driver.speed_limit.compliance",
    "driver.speed_limit.sign_offset_m",
    "driver.speed_limit.bump_acceleration_mps2",
    "driver.pedals.switched.proportional",
    "driver.pedals.switched.threshold_mps",
    "vehicle.drag_area_m2",
    "vehicle.rolling_factor",
    "vehicle.auxiliary_power_w",
];

impl FleetModel {
    /// Whether each trip has a truck and a driver of its own.
    pub fn is_absent(&self) -> bool {
        *self == Self::default()
    }

    /// How cycles belong to trucks, drivers and days.
    pub fn nesting(&self) -> Nesting {
        let mut levels: Vec<(Stream, Level)> = Vec::new();
        if let Some(calendar) = &self.calendar {
            let weather = WEATHER.iter().filter(|_| calendar.shared_weather);
            let traffic = [Stream::Traffic].into_iter().filter(|_| calendar.shared_traffic);
            levels.extend(weather.copied().chain(traffic).map(|stream| (stream, Level::Day)));
        }
        // what is named goes before what the calendar shares
        levels.retain(|(stream, _)| !self.levels.contains_key(stream));
        levels.extend(self.levels.iter().map(|(stream, level)| (*stream, *level)));
        Nesting {
            trips_per_truck: self.trips_per_truck.max(1),
            drivers: match self.driver_pool {
                Some(drivers) => Drivers::OfPool(drivers.max(1)),
                None => Drivers::OfTruck(self.drivers_per_truck.max(1)),
            },
            days: self.calendar.as_ref().map(|calendar| OperatingDays {
                per_week: calendar.operating_days_per_week.clamp(1, 7),
                trips: calendar.trips_per_day.max(1),
                departure_interval_s: calendar.departure_interval_s.unwrap_or(0.0),
            }),
            levels,
            first_trip: 0,
        }
    }

    /// Rules between its keys.
    pub fn validate(&self, problems: &mut Problems) {
        let both = self.driver_pool.is_some() && self.drivers_per_truck != 1;
        problems.require(
            !both,
            "drivers_per_truck",
            self.drivers_per_truck,
            "left out beside `driver_pool`: a truck has drivers of its own, or shares a pool",
        );
        let of_no_trip = [
            Stream::Bootstrap,
            Stream::CurveSpeedParameters,
            Stream::TruckEffect,
            Stream::DriverAssignment,
        ];
        for (stream, level) in &self.levels {
            let name = serde_json::to_value(stream).unwrap_or_default();
            let name = name.as_str().unwrap_or_default();
            let shown = serde_json::to_value(level).unwrap_or_default();
            problems.require(
                !of_no_trip.contains(stream),
                &format!("levels.{name}"),
                shown,
                "a stream of trips, as payload or temperature: what this one draws has no level",
            );
        }
        if let Some(calendar) = &self.calendar {
            let holds = calendar.trips_per_day == 1 || calendar.departure_interval_s.is_some();
            let allowed = "there where a truck makes several trips on a day";
            problems.require(holds, "calendar.departure_interval_s", "not there", allowed);
        }
    }

    /// Laws with a level where a trip draws more than one value.
    pub(super) fn validate_levels(tree: &Value, problems: &mut Problems) {
        levels_below(tree, &mut String::new(), false, problems);
    }
}

/// Looks for laws with a level below a path.
fn levels_below(value: &Value, path: &mut String, is_part: bool, problems: &mut Problems) {
    match value {
        Value::Object(table) => {
            let is_law = table.contains_key("distribution");
            let levels = crate::distribution::levelled::LEVEL_KEYS;
            for key in levels.into_iter().filter(|key| is_law && table.contains_key(*key)) {
                let allowed = if is_part {
                    "beside the weights: a part of a mixture has no level of its own"
                } else {
                    "a law that a trip draws once, as mission.payload_kg or vehicle.drag_area_m2"
                };
                let mut once = ONCE_A_TRIP.iter().chain(&TRUCK_LAWS);
                let holds = !is_part && once.any(|known| known == path);
                problems.require(holds, &format!("{path}.{key}"), &table[key], allowed);
            }
            for (name, below) in table {
                let length = path.len();
                if !path.is_empty() {
                    path.push('.');
                }
                path.push_str(name);
                levels_below(below, path, is_part || is_law, problems);
                path.truncate(length);
            }
        }
        Value::Array(items) => {
            for item in items {
                levels_below(item, path, is_part, problems);
            }
        }
        _ => {}
    }
}

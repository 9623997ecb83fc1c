//! The one vocabulary of all tables: what a column can be called, and in which units.
//!
//! A name is a quantity, or a quantity, `_` and a unit: `speed_kmh`. The unit may stand in brackets
//! instead: `speed [km/h]`.

use super::unit::{self, Unit, is_suffix, with_suffix};
use ocmc_core::energy::Carrier;

/// Quantity in a column. The meaning of each is in its [`Entry`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "the vocabulary below says what each is")]
pub enum Quantity {
    Time,
    Date,
    Day,
    TimeOfDay,
    DayOfYear,
    Driver,
    Truck,
    Drive,
    Event,
    Site,
    Category,
    Speed,
    Acceleration,
    Limit,
    Position,
    Latitude,
    Longitude,
    Altitude,
    Grade,
    Gradient,
    Course,
    YawRate,
    Curvature,
    LateralAcceleration,
    SteeringWheelAngle,
    Accelerator,
    Brake,
    Gear,
    Payload,
    Roughness,
    RoadType,
    MapObject,
    Stop,
    Radius,
    Direction,
    RouteLength,
    GapBefore,
    GapAfter,
    SlowestNear,
    StopNear,
    Temperature,
    Pressure,
    RelativeHumidity,
    Precipitation,
    WindSpeed,
    WindDirection,
    DensityShare,
    Density,
    SpeedRatio,
    EngineSpeed,
    Torque,
    FullLoadTorque,
    DragTorque,
    FuelRate,
    BatteryPower,
    InputTorque,
    LossTorque,
    Track,
    Rule,
    Value,
    Response,
    Weight,
    Departure,
    Outcome,
    FuelUsed,
    GrossWeight,
    Ignition,
    Pause,
    Order,
    Place,
    Leg,
    Dwell,
    Loaded,
    Unloaded,
    Arrival,
    AmbientTemperature,
    Distance,
    FuelAmount,
    EnergyAmount,
    DrivingTime,
    Duration,
    Climb,
    Odometer,
    FullTank,
    RouteName,
    Group,
}

/// An entry of the vocabulary.
#[derive(Debug)]
pub struct Entry {
    /// The quantity.
    pub quantity: Quantity,
    /// Its names without a unit, the usual one first.
    pub names: &'static [&'static str],
    /// Its units.
    pub units: &'static [Unit],
    /// Noun for it in messages.
    pub noun: &'static str,
    /// Meaning beyond that.
    pub meaning: &'static str,
    /// The values that it usually has on a road, in SI: others are named (judgement).
    pub usual: Option<[f64; 2]>,
}

impl Entry {
    const fn usual(self, low: f64, high: f64) -> Self {
        Self { usual: Some([low, high]), ..self }
    }
}

const fn entry(
    quantity: Quantity,
    names: &'static [&'static str],
    units: &'static [Unit],
    noun: &'static str,
    meaning: &'static str,
) -> Entry {
    Entry { quantity, names, units, noun, meaning, usual: None }
}

use Quantity as Q;

/// The vocabulary, in the order of [`Quantity`].
#[rustfmt::skip] // a quantity a line
pub const VOCABULARY: [Entry; 86] = [
    entry(Q::Time, &["time"], unit::TIME, "time",
        "of weather and traffic from the midnight of a 1 January"),
    entry(Q::Date, &["time"], unit::TEXT, "date and time",
        "of weather and traffic, such as `2024-03-01T14:00`"),
    entry(Q::Day, &["date"], unit::TEXT, "date",
        "such as `2024-03-01`, where the time of the day stands in a column of its own"),
    entry(Q::TimeOfDay, &["time_of_day"], unit::TIME, "time of the day", "from midnight"),
    entry(Q::DayOfYear, &["day_of_year"], unit::NUMBER, "day of the year", "from 0"),
    entry(Q::Driver, &["driver"], unit::TEXT, "driver", "who drove"),
    entry(Q::Truck, &["truck"], unit::TEXT, "truck", "which vehicle"),
    entry(Q::Drive, &["drive"], unit::TEXT, "drive", "which journey"),
    entry(Q::Event, &["event"], unit::TEXT, "event", "which event of a journey, such as a slope"),
    entry(Q::Site, &["site"], unit::TEXT, "site", "where traffic or weather was measured"),
    entry(Q::Category, &["category"], unit::TEXT, "category",
        "of a speed change, such as `70-to-40`"),
    entry(Q::Speed, &["speed"], unit::SPEED, "speed", "").usual(-10.0, 70.0),
    entry(Q::Acceleration, &["acceleration"], unit::ACCELERATION, "acceleration",
        "negative where a vehicle slows down").usual(-15.0, 15.0),
    entry(Q::Limit, &["limit", "speed_limit"], unit::SPEED, "speed limit",
        "of a route from here on").usual(1.3, 45.0),
    entry(Q::Position, &["position"], unit::LENGTH, "position", "along the road"),
    entry(Q::Latitude, &["latitude", "lat"], unit::DEGREES, "latitude", "positive to the north"),
    entry(Q::Longitude, &["longitude", "lon"], unit::DEGREES, "longitude", "positive to the east"),
    entry(Q::Altitude, &["altitude", "elevation"], unit::LENGTH, "altitude",
        "of a route linear between rows").usual(-450.0, 5500.0),
    entry(Q::Grade, &["grade"], unit::GRADE, "slope",
        "climb per metre of road, positive uphill; in a log since the row before"),
    entry(Q::Gradient, &["gradient"], unit::GRADIENT, "gradient", "rise over run, positive uphill"),
    entry(Q::Course, &["course"], unit::ANGLE, "course", "over ground, clockwise from north"),
    entry(Q::YawRate, &["yaw_rate"], unit::ANGULAR_RATE, "yaw rate",
        "positive to the left").usual(-3.0, 3.0),
    entry(Q::Curvature, &["curvature"], unit::PER_LENGTH, "curvature",
        "of the path, positive to the left"),
    entry(Q::LateralAcceleration, &["lateral_acceleration"], unit::ACCELERATION,
        "lateral acceleration", "positive to the left").usual(-15.0, 15.0),
    entry(Q::SteeringWheelAngle, &["steering_wheel_angle"], unit::ANGLE,
        "angle of the steering wheel", "positive to the left").usual(-30.0, 30.0),
    entry(Q::Accelerator, &["accelerator"], unit::SHARE, "accelerator pedal",
        "from 0 to 1").usual(-0.1, 1.2),
    entry(Q::Brake, &["brake"], unit::SHARE, "brake pedal", "from 0 to 1").usual(-0.1, 1.2),
    entry(Q::Gear, &["gear"], unit::NUMBER, "gear", "from 1").usual(-5.0, 30.0),
    entry(Q::Payload, &["payload"], unit::MASS, "payload", "").usual(0.0, 100e3),
    entry(Q::Roughness, &["roughness"], unit::ROUGHNESS, "roughness",
        "coefficient of ISO 8608, of the road"),
    entry(Q::RoadType, &["road_type"], unit::TEXT, "road type", "name of a road type of the study"),
    entry(Q::MapObject, &["map_object"], unit::TEXT, "object of the map",
        "`stop_sign`, `give_way`, `traffic_light`, `speed_bump`, `mission_stop`, \
         `railway_crossing`"),
    entry(Q::Stop, &["stop"], unit::TIME, "standstill", "at this place; 0 or an empty cell: none"),
    entry(Q::Radius, &["radius"], unit::LENGTH, "radius", "of a curve").usual(2.0, 1e6),
    entry(Q::Direction, &["direction"], unit::TEXT, "direction", "of a curve: `left` or `right`"),
    entry(Q::RouteLength, &["route", "route_length"], unit::LENGTH, "length of the route",
        "on which a curve was driven"),
    entry(Q::GapBefore, &["gap_before"], unit::LENGTH, "gap before a curve",
        "way from the curve before, or from the start of the log"),
    entry(Q::GapAfter, &["gap_after"], unit::LENGTH, "gap behind a curve",
        "way to the next curve, or to the end of the log"),
    entry(Q::SlowestNear, &["slowest_near"], unit::SPEED, "slowest speed near a curve",
        "from 150 m before to 150 m behind it"),
    entry(Q::StopNear, &["stop_near"], unit::LENGTH, "way between a curve and a standstill",
        "the nearest one; an empty cell: none"),
    entry(Q::Temperature, &["temperature"], unit::TEMPERATURE, "temperature", "of the air"),
    entry(Q::Pressure, &["pressure"], unit::PRESSURE, "pressure",
        "of the air at the place, not reduced to the sea"),
    entry(Q::RelativeHumidity, &["relative_humidity"], unit::SHARE, "relative humidity",
        "from 0 to 1"),
    entry(Q::Precipitation, &["precipitation"], unit::PRECIPITATION, "precipitation",
        "as water").usual(0.0, 5e-5),
    entry(Q::WindSpeed, &["wind_speed"], unit::SPEED, "wind speed",
        "10 m above the ground").usual(0.0, 60.0),
    entry(Q::WindDirection, &["wind_direction"], unit::ANGLE, "wind direction",
        "where the wind comes from, clockwise from north"),
    entry(Q::DensityShare, &["density_share"], unit::NUMBER, "density of the traffic",
        "over that of standing traffic"),
    entry(Q::Density, &["density"], unit::PER_LENGTH, "density of the traffic",
        "vehicles per metre and lane"),
    entry(Q::SpeedRatio, &["speed_ratio"], unit::NUMBER, "speed of the traffic",
        "over the speed of cars on the empty road"),
    entry(Q::EngineSpeed, &["engine_speed"], unit::ROTATIONAL_SPEED, "speed of the shaft",
        "of an engine, a retarder or a gearbox's input"),
    entry(Q::Torque, &["torque"], unit::TORQUE, "torque", ""),
    entry(Q::FullLoadTorque, &["full_load_torque"], unit::TORQUE, "full-load torque", ""),
    entry(Q::DragTorque, &["drag_torque"], unit::TORQUE, "drag torque", "negative"),
    entry(Q::FuelRate, &["fuel", "fuel_rate"], unit::MASS_FLOW, "fuel consumption",
        "in a log the mean since the row before").usual(-1e-4, 0.05),
    entry(Q::BatteryPower, &["battery_power"], unit::POWER, "power of the battery",
        "at its terminals, positive where it is discharged; in a log the mean since the row \
         before").usual(-3e6, 3e6),
    entry(Q::InputTorque, &["input_torque"], unit::TORQUE, "input torque",
        "of a gearbox or an axle"),
    entry(Q::LossTorque, &["loss_torque", "torque_loss"], unit::TORQUE, "loss torque", ""),
    entry(Q::Track, &["track"], unit::TEXT, "track",
        "of an operating cycle that `ocmc cycle` wrote"),
    entry(Q::Rule, &["rule"], unit::TEXT, "rule", "of such a track"),
    entry(Q::Value, &["value"], unit::TEXT, "value", "of such a track"),
    entry(Q::Response, &["response"], unit::NUMBER, "quantity that is compared",
        "of a trip, in whatever unit"),
    entry(Q::Weight, &["weight"], unit::NUMBER, "weight of a trip", "such as its length"),
    entry(Q::Departure, &["departure"], unit::TIME, "departure", "from the beginning of the year"),
    entry(Q::Outcome, &["outcome"], unit::TEXT, "outcome", "of a trip: `completed`, or another \
        one"),
    entry(Q::FuelUsed, &["fuel_used", "total_fuel"], unit::FUEL, "fuel used",
        "a counter that goes on; litres are those of diesel, at 0.835 kg/L"),
    entry(Q::GrossWeight, &["gross_weight", "gross_combination_weight"], unit::MASS,
        "gross weight", "of a combination, as it is driven").usual(500.0, 150e3),
    entry(Q::Ignition, &["ignition"], unit::TEXT, "ignition",
        "`on` or `off`, 1 or 0: switching off ends a trip; an empty cell: as before"),
    entry(Q::Pause, &["pause"], unit::TIME, "pause",
        "no column, but a time: `--map pause_min=20` ends a trip at each standstill of 20 minutes"),
    entry(Q::Order, &["order"], unit::NUMBER, "order", "of a place in a stop plan"),
    entry(Q::Place, &["place"], unit::TEXT, "name of a place", "in a stop plan"),
    entry(Q::Leg, &["leg"], unit::LENGTH, "way from the place before", "in a stop plan"),
    entry(Q::Dwell, &["dwell"], unit::TIME, "dwell", "of a truck at a place of a stop plan"),
    entry(Q::Loaded, &["loaded", "load"], unit::MASS, "cargo that is loaded", "at a place"),
    entry(Q::Unloaded, &["unloaded", "unload"], unit::MASS, "cargo that is unloaded", "at a place"),
    entry(Q::Arrival, &["arrival"], unit::TEXT, "arrival",
        "time of the day at a place, such as `06:30`, or a date with a time"),
    entry(Q::AmbientTemperature, &["ambient_temperature", "outside_temperature"],
        unit::TEMPERATURE, "ambient temperature",
        "of the air around a vehicle").usual(213.0, 333.0),
    entry(Q::Distance, &["distance"], unit::LENGTH, "distance", "of a trip"),
    entry(Q::FuelAmount, &["fuel_amount", "litres", "liters"], unit::FUEL, "amount of fuel",
        "of a trip, or put into the tank; a name without a unit means litres"),
    entry(Q::EnergyAmount, &["energy"], unit::ENERGY, "electric energy",
        "of a trip, that left the battery"),
    entry(Q::DrivingTime, &["driving_time", "driving"], unit::TIME, "driving time",
        "of a trip, as a tachograph counts it: without breaks"),
    entry(Q::Duration, &["duration"], unit::TIME, "duration",
        "of a trip, from its start to its end, breaks included"),
    entry(Q::Climb, &["climb", "ascent"], unit::LENGTH, "climb", "sum of the climbs of a trip"),
    entry(Q::Odometer, &["odometer"], unit::LENGTH, "odometer", "where fuel was filled in"),
    entry(Q::FullTank, &["full", "full_tank"], unit::TEXT, "full tank",
        "`yes`, `true`, `full` or 1 where a fill filled the tank; anything else: in part"),
    entry(Q::RouteName, &["route"], unit::TEXT, "route", "which route a trip drove"),
    entry(Q::Group, &["group"], unit::TEXT, "group", "which group a trip is of, such as a tyre"),
];

impl Quantity {
    /// The rate at which a carrier is taken, as logs have it.
    pub fn rate_of(carrier: Carrier) -> Self {
        match carrier.declaration().filled {
            Some(_) => Self::FuelRate,
            None => Self::BatteryPower,
        }
    }

    /// Its entry of the vocabulary.
    pub fn entry(self) -> &'static Entry {
        &VOCABULARY[self as usize]
    }

    /// Its usual name, without a unit.
    pub fn name(self) -> &'static str {
        self.entry().names[0]
    }

    /// Noun for it in messages.
    pub fn noun(self) -> &'static str {
        self.entry().noun
    }

    /// Its units.
    pub fn units(self) -> &'static [Unit] {
        self.entry().units
    }

    /// Whether it is a text.
    pub fn is_text(self) -> bool {
        self.units() == unit::TEXT
    }

    /// The names with which it can be written, such as `speed_kmh`.
    pub fn names(self) -> impl Iterator<Item = String> {
        let units = self.units().iter();
        units.map(move |unit| with_unit(self.name(), unit.suffix))
    }

    /// The unit in which a name means it, all in lower-case letters; a name without a unit means
    /// none of those that have a suffix.
    pub(super) fn unit_of(self, name: &str) -> Option<&'static Unit> {
        let mut rest = self.entry().names.iter().filter_map(|base| rest(name, base));
        rest.find_map(|suffix| with_suffix(self.units(), suffix))
    }

    /// Whether a name is this quantity, but for its unit, which is missing, unknown, or one of
    /// another quantity.
    pub(super) fn lacks_unit(self, name: &str) -> bool {
        // the longest name counts: `lateral_acceleration` before anything shorter
        let length = |quantity: Self| {
            let names = quantity.entry().names.iter().filter(|base| rest(name, base).is_some());
            names.map(|base| base.len()).max()
        };
        let longest = VOCABULARY.iter().filter_map(|entry| length(entry.quantity)).max();
        longest.is_some()
            && length(self) == longest
            && !self.is_text()
            && self.unit_of(name).is_none()
    }

    /// Whether a name is this quantity in a unit that is one, and that is not read.
    pub(super) fn in_other_unit(self, name: &str) -> bool {
        let rests = self.entry().names.iter().filter_map(|base| rest(name, base));
        self.lacks_unit(name) && rests.into_iter().any(|rest| !rest.is_empty() && is_suffix(rest))
    }
}

/// A name with the suffix of a unit.
pub(super) fn with_unit(name: &str, suffix: &str) -> String {
    if suffix.is_empty() { name.to_owned() } else { format!("{name}_{suffix}") }
}

/// Rest of a name behind a base and `_`.
fn rest<'a>(name: &'a str, base: &str) -> Option<&'a str> {
    let rest = name.strip_prefix(base)?;
    if rest.is_empty() { Some(rest) } else { rest.strip_prefix('_') }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_stand_in_the_order_of_the_quantities() {
        for (k, entry) in VOCABULARY.iter().enumerate() {
            assert_eq!(entry.quantity as usize, k, "{entry:?}");
        }
    }

    #[test]
    fn names_are_quantities_and_units() {
        let factor = |quantity: Quantity, name| quantity.unit_of(name).map(|unit| unit.factor);
        assert_eq!(factor(Q::Speed, "speed_kmh"), Some(1.0 / 3.6));
        assert_eq!(factor(Q::Limit, "speed_limit_mph"), Some(0.44704));
        assert_eq!(factor(Q::Accelerator, "accelerator"), Some(1.0));
        assert_eq!(factor(Q::Curvature, "curvature_per_m"), Some(1.0));
        assert_eq!(factor(Q::Speed, "speed"), None);
        assert!(Q::Speed.lacks_unit("speed") && Q::Speed.lacks_unit("speed_furlongs"));
        assert!(!Q::Speed.lacks_unit("speedy") && !Q::Speed.lacks_unit("speed_limit_sign"));
        assert!(!Q::Acceleration.lacks_unit("lateral_acceleration_g"));
        assert!(Q::Pressure.in_other_unit("pressure_inhg"));
        assert!(!Q::Speed.in_other_unit("speed_sensor"));
        let mut names: Vec<String> =
            VOCABULARY.iter().flat_map(|entry| entry.quantity.names()).collect();
        let all = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), all);
    }
}

//! What a column of a log can be, and in which units: `speed_kmh`, `yaw_rate_degps`.
//!
//! A name is a quantity, or a quantity, `_` and a unit. Everything becomes SI as soon as it is read.

use std::f64::consts::PI;

/// A measured quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// Time.
    Time,
    /// Speed.
    Speed,
    /// Yaw rate, positive to the left.
    YawRate,
    /// Curvature of the path, positive to the left.
    Curvature,
    /// Lateral acceleration, positive to the left.
    LateralAcceleration,
    /// Angle of the steering wheel, positive to the left.
    SteeringWheelAngle,
    /// Course over ground, clockwise from north.
    Course,
    /// Latitude.
    Latitude,
    /// Longitude.
    Longitude,
    /// Speed limit.
    Limit,
    /// Accelerator pedal, from 0 to 1.
    Accelerator,
    /// Brake pedal, from 0 to 1.
    Brake,
    /// Slope of the road, positive uphill.
    Grade,
    /// Position along the road.
    Position,
    /// Gear, from 1.
    Gear,
    /// Altitude.
    Altitude,
    /// Roughness coefficient of the road (ISO 8608).
    Roughness,
    /// Payload.
    Payload,
    /// Time of the day, from midnight.
    TimeOfDay,
    /// Day of the year, from 0.
    DayOfYear,
}

/// A unit: its suffix, and how many SI units it is.
type Unit = (&'static str, f64);

const TIMES: [Unit; 6] =
    [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9), ("min", 60.0), ("h", 3600.0)];
const SPEEDS: [Unit; 4] =
    [("mps", 1.0), ("kmh", 1.0 / 3.6), ("mph", 0.44704), ("kn", 1852.0 / 3600.0)];
const ANGLES: [Unit; 2] = [("rad", 1.0), ("deg", PI / 180.0)];
const ANGULAR_RATES: [Unit; 2] = [("radps", 1.0), ("degps", PI / 180.0)];
const ACCELERATIONS: [Unit; 2] = [("mps2", 1.0), ("g", 9.80665)];
const SHARES: [Unit; 2] = [("", 1.0), ("percent", 0.01)];
/// Degrees are the only unit of positions on the earth, and stay degrees.
const PLACES: [Unit; 1] = [("deg", 1.0)];
const LENGTHS: [Unit; 2] = [("m", 1.0), ("km", 1000.0)];
const NUMBERS: [Unit; 1] = [("", 1.0)];
const CURVATURES: [Unit; 1] = [("per_m", 1.0)];
const ROUGHNESSES: [Unit; 1] = [("m3", 1.0)];
const MASSES: [Unit; 2] = [("kg", 1.0), ("t", 1000.0)];

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 20] = [
        Self::Time,
        Self::Speed,
        Self::YawRate,
        Self::Curvature,
        Self::LateralAcceleration,
        Self::SteeringWheelAngle,
        Self::Course,
        Self::Latitude,
        Self::Longitude,
        Self::Limit,
        Self::Accelerator,
        Self::Brake,
        Self::Grade,
        Self::Position,
        Self::Gear,
        Self::Altitude,
        Self::Roughness,
        Self::Payload,
        Self::TimeOfDay,
        Self::DayOfYear,
    ];

    /// Its name, without a unit.
    pub fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Speed => "speed",
            Self::YawRate => "yaw_rate",
            Self::Curvature => "curvature",
            Self::LateralAcceleration => "lateral_acceleration",
            Self::SteeringWheelAngle => "steering_wheel_angle",
            Self::Course => "course",
            Self::Latitude => "latitude",
            Self::Longitude => "longitude",
            Self::Limit => "limit",
            Self::Accelerator => "accelerator",
            Self::Brake => "brake",
            Self::Grade => "grade",
            Self::Position => "position",
            Self::Gear => "gear",
            Self::Altitude => "altitude",
            Self::Roughness => "roughness",
            Self::Payload => "payload",
            Self::TimeOfDay => "time_of_day",
            Self::DayOfYear => "day_of_year",
        }
    }

    /// Its units.
    pub fn units(self) -> &'static [Unit] {
        match self {
            Self::Time | Self::TimeOfDay => &TIMES,
            Self::Speed | Self::Limit => &SPEEDS,
            Self::YawRate => &ANGULAR_RATES,
            Self::Curvature => &CURVATURES,
            Self::LateralAcceleration => &ACCELERATIONS,
            Self::SteeringWheelAngle | Self::Course => &ANGLES,
            Self::Latitude | Self::Longitude => &PLACES,
            Self::Position | Self::Altitude => &LENGTHS,
            Self::Gear | Self::DayOfYear => &NUMBERS,
            Self::Roughness => &ROUGHNESSES,
            Self::Payload => &MASSES,
            Self::Accelerator | Self::Brake | Self::Grade => &SHARES,
        }
    }

    /// The names with which it can be written, such as `speed_kmh`.
    pub fn names(self) -> impl Iterator<Item = String> {
        self.units().iter().map(move |(unit, _)| match *unit {
            "" => self.name().to_owned(),
            unit => format!("{}_{unit}", self.name()),
        })
    }

    /// The quantity of a name, and the size of its unit in SI.
    pub fn parse(name: &str) -> Option<(Self, f64)> {
        Self::ALL.into_iter().find_map(|quantity| {
            let mut units = quantity.names().zip(quantity.units());
            units.find(|(written, _)| written == name).map(|(_, (_, size))| (quantity, *size))
        })
    }

    /// The quantity whose name this begins with, where the unit is missing or unknown.
    pub fn with_wrong_unit(name: &str) -> Option<Self> {
        // the longest name: `lateral_acceleration` before anything shorter
        let matching = Self::ALL.into_iter().filter(|quantity| {
            name.strip_prefix(quantity.name())
                .is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
        });
        matching.max_by_key(|quantity| quantity.name().len())
    }
}

/// What tells rows apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Label {
    /// The driver, or the truck.
    Driver,
    /// The drive: rows of one journey.
    Drive,
    /// The event of a drive, such as a slope.
    Event,
}

impl Label {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Driver, Self::Drive, Self::Event];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Driver => "driver",
            Self::Drive => "drive",
            Self::Event => "event",
        }
    }

    /// The label of a name.
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|label| label.name() == name)
    }
}

/// What a column says in words, row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Word {
    /// Type of the road.
    RoadType,
    /// Object of the map at this place: a sign, a light.
    MapObject,
}

impl Word {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::RoadType, Self::MapObject];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::RoadType => "road_type",
            Self::MapObject => "map_object",
        }
    }

    /// The word of a name.
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|word| word.name() == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_quantities_and_units() {
        assert_eq!(Quantity::parse("speed_kmh"), Some((Quantity::Speed, 1.0 / 3.6)));
        assert_eq!(Quantity::parse("accelerator"), Some((Quantity::Accelerator, 1.0)));
        assert_eq!(Quantity::parse("curvature_per_m"), Some((Quantity::Curvature, 1.0)));
        assert_eq!(Quantity::parse("speed"), None);
        assert_eq!(Quantity::with_wrong_unit("speed"), Some(Quantity::Speed));
        assert_eq!(Quantity::with_wrong_unit("speed_furlongs"), Some(Quantity::Speed));
        assert_eq!(Quantity::with_wrong_unit("speedy"), None);
        let mut names: Vec<String> = Quantity::ALL.into_iter().flat_map(Quantity::names).collect();
        let all = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), all);
    }
}

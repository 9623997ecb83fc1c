//! Units in which the columns of a table may be written, and how large they are in SI.

use super::quantity::VOCABULARY;
use std::f64::consts::PI;

/// A unit.
#[derive(Debug, PartialEq)]
pub struct Unit {
    /// At the end of a column's name: `kmh` of `speed_kmh`. Empty where the name alone says it.
    pub suffix: &'static str,
    /// How it is written in brackets, the usual way first.
    pub written: &'static [&'static str],
    /// One of it in SI.
    pub factor: f64,
    /// Its zero in SI.
    pub offset: f64,
    /// Function of the number then.
    pub scale: Scale,
}

/// Function of the number that a unit makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// The number.
    Linear,
    /// The sine of an angle: climb per metre of road.
    Sine,
    /// The tangent of an angle: rise over run.
    Tangent,
}

impl Unit {
    const fn new(suffix: &'static str, written: &'static [&'static str], factor: f64) -> Self {
        Self { suffix, written, factor, offset: 0.0, scale: Scale::Linear }
    }

    const fn scaled(self, scale: Scale) -> Self {
        Self { scale, ..self }
    }

    /// Whether numbers mean the same in both.
    pub fn is_same(&self, other: &Self) -> bool {
        let conversion = |unit: &Self| (unit.factor, unit.offset, unit.scale);
        conversion(self) == conversion(other)
    }

    /// A number of it in SI.
    pub fn si(&self, number: f64) -> f64 {
        let size = self.factor * number;
        // adding zero would lose the sign of a zero
        let number = if self.offset == 0.0 { size } else { size + self.offset };
        match self.scale {
            Scale::Linear => number,
            Scale::Sine => libm::sin(number),
            Scale::Tangent => libm::tan(number),
        }
    }
}

/// Kilometres an hour.
pub const KMH: &str = "kmh";

/// Texts, which have no unit.
pub const TEXT: &[Unit] = &[Unit::new("", &[], 1.0)];
/// A number without a unit.
pub const NUMBER: &[Unit] = &[Unit::new("", &["-", "1"], 1.0)];
/// Shares.
pub const SHARE: &[Unit] = &[
    Unit::new("", &["-", "1", "m/m"], 1.0),
    Unit::new("percent", &["%", "percent", "per cent"], 0.01),
];
const SLOPE_ANGLE: Unit = Unit::new("deg", &["°", "deg", "degree", "degrees"], PI / 180.0);
const RADIANS: Unit = Unit::new("rad", &["rad"], 1.0);
const PER_MILLE: Unit = Unit::new("permille", &["‰", "per mille", "m/km"], 1e-3);
/// Climb per metre of road.
pub const GRADE: &[Unit] = &[
    Unit::new("", &["-", "1", "m/m"], 1.0),
    Unit::new("percent", &["%", "percent", "per cent"], 0.01),
    PER_MILLE,
    SLOPE_ANGLE.scaled(Scale::Sine),
    RADIANS.scaled(Scale::Sine),
];
/// Rise over run.
pub const GRADIENT: &[Unit] = &[
    Unit::new("", &["-", "1", "m/m"], 1.0),
    Unit::new("percent", &["%", "percent", "per cent"], 0.01),
    PER_MILLE,
    SLOPE_ANGLE.scaled(Scale::Tangent),
    RADIANS.scaled(Scale::Tangent),
];
/// Times.
pub const TIME: &[Unit] = &[
    Unit::new("s", &["s", "sec", "secs", "second", "seconds"], 1.0),
    Unit::new("ms", &["ms"], 1e-3),
    Unit::new("us", &["us", "µs"], 1e-6),
    Unit::new("ns", &["ns"], 1e-9),
    Unit::new("min", &["min", "minutes"], 60.0),
    Unit::new("h", &["h", "hours"], 3600.0),
];
/// Lengths.
pub const LENGTH: &[Unit] = &[
    Unit::new("m", &["m", "metre", "metres", "meter", "meters"], 1.0),
    Unit::new("km", &["km"], 1000.0),
    Unit::new("ft", &["ft", "feet"], 0.3048),
    Unit::new("mi", &["mi", "mile", "miles"], 1609.344),
];
/// Speeds.
pub const SPEED: &[Unit] = &[
    Unit::new("mps", &["m/s", "mps", "m/sec", "m s-1"], 1.0),
    Unit::new(KMH, &["km/h", "kmh", "kph", "km/hr"], 1.0 / 3.6),
    Unit::new("mph", &["mph", "mile/h", "miles/h", "mi/h"], 0.44704),
    Unit::new("kn", &["kn", "kt", "knots"], 1852.0 / 3600.0),
];
/// Accelerations.
pub const ACCELERATION: &[Unit] =
    &[Unit::new("mps2", &["m/s²", "m/s2", "m/s^2", "mps2"], 1.0), Unit::new("g", &["g"], 9.80665)];
/// Angles.
pub const ANGLE: &[Unit] =
    &[Unit::new("rad", &["rad"], 1.0), Unit::new("deg", &["°", "deg"], PI / 180.0)];
/// Angular rates.
pub const ANGULAR_RATE: &[Unit] = &[
    Unit::new("radps", &["rad/s", "radps"], 1.0),
    Unit::new("degps", &["°/s", "deg/s", "degps"], PI / 180.0),
];
/// Latitude and longitude, which stay degrees.
pub const DEGREES: &[Unit] =
    &[Unit::new("deg", &["°", "deg"], 1.0), Unit::new("", &["°", "deg"], 1.0)];
/// 1 over a length.
pub const PER_LENGTH: &[Unit] = &[Unit::new("per_m", &["1/m"], 1.0)];
/// Coefficients of a road's roughness.
pub const ROUGHNESS: &[Unit] = &[Unit::new("m3", &["m³", "m3", "m^3"], 1.0)];
/// Masses.
pub const MASS: &[Unit] = &[Unit::new("kg", &["kg"], 1.0), Unit::new("t", &["t"], 1000.0)];
/// Density of the litres of fuel counters, in kg/L: diesel (EN 590 allows 0.820 to 0.845).
const DIESEL_KG_PER_L: f64 = 0.835;
/// Amounts of fuel.
pub const FUEL: &[Unit] = &[
    Unit::new("kg", &["kg"], 1.0),
    Unit::new("g", &["g"], 1e-3),
    Unit::new("l", &["L", "litre", "litres", "liter", "liters"], DIESEL_KG_PER_L),
    Unit::new("ml", &["mL"], 1e-3 * DIESEL_KG_PER_L),
];
/// Amounts of energy.
pub const ENERGY: &[Unit] = &[
    Unit::new("kwh", &["kWh"], 3.6e6),
    Unit::new("mj", &["MJ"], 1e6),
    Unit::new("j", &["J"], 1.0),
];
/// Temperatures.
pub const TEMPERATURE: &[Unit] = &[
    Unit::new("k", &["K"], 1.0),
    Unit { offset: 273.15, ..Unit::new("c", &["°C", "C", "degC"], 1.0) },
    Unit { offset: 273.15 - 160.0 / 9.0, ..Unit::new("f", &["°F", "F", "degF"], 5.0 / 9.0) },
];
/// Pressures.
pub const PRESSURE: &[Unit] = &[
    Unit::new("pa", &["Pa"], 1.0),
    Unit::new("hpa", &["hPa"], 100.0),
    Unit::new("mbar", &["mbar", "mb"], 100.0),
    Unit::new("kpa", &["kPa"], 1000.0),
];
/// Water that falls.
pub const PRECIPITATION: &[Unit] =
    &[Unit::new("mps", &["m/s"], 1.0), Unit::new("mm_per_h", &["mm/h"], 1e-3 / 3600.0)];
/// Rotational speeds.
pub const ROTATIONAL_SPEED: &[Unit] = &[
    Unit::new("radps", &["rad/s", "radps"], 1.0),
    Unit::new(
        "rpm",
        &["rpm", "1/min", "min-1", "min^-1", "/min", "U/min", "rev/min", "r/min"],
        PI / 30.0,
    ),
];
/// Torques.
pub const TORQUE: &[Unit] = &[Unit::new("nm", &["Nm", "N m", "N.m", "N·m"], 1.0)];
/// Mass a time.
pub const MASS_FLOW: &[Unit] = &[
    Unit::new("kgps", &["kg/s"], 1.0),
    Unit::new("gph", &["g/h", "g/hr"], 1.0 / 3.6e6),
    Unit::new("kgph", &["kg/h", "kg/hr"], 1.0 / 3600.0),
    Unit::new("lph", &["L/h", "L/hr"], DIESEL_KG_PER_L / 3600.0),
];
/// Powers.
pub const POWER: &[Unit] = &[Unit::new("w", &["W"], 1.0), Unit::new("kw", &["kW"], 1000.0)];

/// Units that people write at the end of a column's name, and that no quantity is read in.
const OTHER_SUFFIXES: [&str; 5] = ["inhg", "bar", "lb", "fps", "per_km"];

/// The one of some units that has this suffix.
pub fn with_suffix(units: &'static [Unit], suffix: &str) -> Option<&'static Unit> {
    units.iter().find(|unit| unit.suffix == suffix)
}

/// The one of some units that is written so in brackets.
pub fn written(units: &'static [Unit], text: &str) -> Option<&'static Unit> {
    units.iter().find(|unit| unit.written.iter().any(|known| known.eq_ignore_ascii_case(text)))
}

/// Whether a text is a unit as it is written in brackets, of whatever quantity; a mere number or
/// dash is none.
pub fn is_written(text: &str) -> bool {
    !["", "-", "1"].contains(&text)
        && (VOCABULARY.iter().any(|entry| written(entry.units, text).is_some())
            || OTHER_SUFFIXES.iter().any(|suffix| suffix.eq_ignore_ascii_case(text)))
}

/// Whether the end of a column's name is a unit, of whatever quantity.
pub fn is_suffix(text: &str) -> bool {
    VOCABULARY.iter().any(|entry| with_suffix(entry.units, text).is_some())
        || OTHER_SUFFIXES.contains(&text)
}

//! Every column name that some version of the program understood still means the same, in the same
//! unit.

use ocmc_io::table::formats::SCHEMAS;
use ocmc_io::table::{Quantity as Q, Schema, Source, Table};
use std::f64::consts::PI;
use std::path::Path;

fn schema(what: &str) -> &'static Schema {
    SCHEMAS.into_iter().find(|schema| schema.what == what).expect(what)
}

/// Quantity in a column of this name, and how many SI units one of its numbers is.
fn understood(schema: &'static Schema, name: &str) -> Option<(Q, f64)> {
    let text = format!("{name},other\n1,1\n");
    let table = Table::open(Source::Text(Path::new("t.csv"), &text), schema, &[]).expect(name);
    table.columns().first().map(|column| (column.quantity, column.unit.factor))
}

const LOG: &str = "a log";
const CURVES: &str = "a table of curves";
const CHANGES: &str = "a table of speed changes";
const WEATHER: &str = "a table of weather";
const TRAFFIC: &str = "a table of traffic";
const ROUTE: &str = "a route";
const VECTO: &str = "a cycle of VECTO";
const TRACKS: &str = "an operating cycle";
const CYCLE: &str = "a drive cycle";
const ENGINE: &str = "the curves of an engine";
const FUEL: &str = "the fuel map of an engine";
const LOSS: &str = "a loss map";

const KMH: f64 = 1.0 / 3.6;
const MPH: f64 = 0.44704;
const KNOT: f64 = 1852.0 / 3600.0;
const DEGREE: f64 = PI / 180.0;
const RPM: f64 = PI / 30.0;
const GPH: f64 = 1.0 / 3.6e6;

/// A format, a quantity, and its names with the size of their units in SI.
type Understood = (&'static str, Q, &'static [(&'static str, f64)]);

const NAMES: &[Understood] = &[
    (
        LOG,
        Q::Time,
        &[
            ("time_s", 1.0),
            ("time_ms", 1e-3),
            ("time_us", 1e-6),
            ("time_ns", 1e-9),
            ("time_min", 60.0),
            ("time_h", 3600.0),
        ],
    ),
    (
        LOG,
        Q::Speed,
        &[("speed_mps", 1.0), ("speed_kmh", KMH), ("speed_mph", MPH), ("speed_kn", KNOT)],
    ),
    (LOG, Q::YawRate, &[("yaw_rate_radps", 1.0), ("yaw_rate_degps", DEGREE)]),
    (LOG, Q::Curvature, &[("curvature_per_m", 1.0)]),
    (
        LOG,
        Q::LateralAcceleration,
        &[("lateral_acceleration_mps2", 1.0), ("lateral_acceleration_g", 9.80665)],
    ),
    (
        LOG,
        Q::SteeringWheelAngle,
        &[("steering_wheel_angle_rad", 1.0), ("steering_wheel_angle_deg", DEGREE)],
    ),
    (LOG, Q::Course, &[("course_rad", 1.0), ("course_deg", DEGREE)]),
    (LOG, Q::Latitude, &[("latitude_deg", 1.0)]),
    (LOG, Q::Longitude, &[("longitude_deg", 1.0)]),
    (
        LOG,
        Q::Limit,
        &[("limit_mps", 1.0), ("limit_kmh", KMH), ("limit_mph", MPH), ("limit_kn", KNOT)],
    ),
    (LOG, Q::Accelerator, &[("accelerator", 1.0), ("accelerator_percent", 0.01)]),
    (LOG, Q::Brake, &[("brake", 1.0), ("brake_percent", 0.01)]),
    (LOG, Q::Grade, &[("grade", 1.0), ("grade_percent", 0.01)]),
    (LOG, Q::Position, &[("position_m", 1.0), ("position_km", 1000.0)]),
    (LOG, Q::Gear, &[("gear", 1.0)]),
    (LOG, Q::Altitude, &[("altitude_m", 1.0), ("altitude_km", 1000.0)]),
    (LOG, Q::Roughness, &[("roughness_m3", 1.0)]),
    (LOG, Q::Payload, &[("payload_kg", 1.0), ("payload_t", 1000.0)]),
    (LOG, Q::FuelRate, &[("fuel_kgps", 1.0), ("fuel_rate_kgps", 1.0), ("fuel_gph", GPH)]),
    (LOG, Q::BatteryPower, &[("battery_power_w", 1.0), ("battery_power_kw", 1000.0)]),
    (LOG, Q::TimeOfDay, &[("time_of_day_s", 1.0), ("time_of_day_h", 3600.0)]),
    (LOG, Q::DayOfYear, &[("day_of_year", 1.0)]),
    (LOG, Q::Driver, &[("driver", 1.0)]),
    (LOG, Q::Drive, &[("drive", 1.0)]),
    (LOG, Q::Event, &[("event", 1.0)]),
    (LOG, Q::RoadType, &[("road_type", 1.0)]),
    (LOG, Q::MapObject, &[("map_object", 1.0)]),
    (CURVES, Q::Driver, &[("driver", 1.0), ("truck", 1.0)]),
    (CURVES, Q::Radius, &[("radius_m", 1.0)]),
    (CURVES, Q::Speed, &[("speed_mps", 1.0)]),
    (CURVES, Q::Direction, &[("direction", 1.0)]),
    (CURVES, Q::RouteLength, &[("route_m", 1.0), ("route_length_m", 1.0)]),
    (CURVES, Q::Limit, &[("limit_mps", 1.0), ("speed_limit_mps", 1.0)]),
    (CURVES, Q::Acceleration, &[("acceleration_mps2", 1.0)]),
    (CURVES, Q::GapBefore, &[("gap_before_m", 1.0)]),
    (CURVES, Q::GapAfter, &[("gap_after_m", 1.0)]),
    (CURVES, Q::SlowestNear, &[("slowest_near_mps", 1.0)]),
    (CURVES, Q::StopNear, &[("stop_near_m", 1.0)]),
    (CHANGES, Q::Acceleration, &[("acceleration_mps2", 1.0)]),
    (CHANGES, Q::Driver, &[("driver", 1.0), ("truck", 1.0)]),
    (CHANGES, Q::Category, &[("category", 1.0)]),
    (WEATHER, Q::Date, &[("time", 1.0)]),
    (WEATHER, Q::Time, &[("time_s", 1.0)]),
    (WEATHER, Q::Temperature, &[("temperature_k", 1.0), ("temperature_c", 1.0)]),
    (WEATHER, Q::Pressure, &[("pressure_pa", 1.0), ("pressure_hpa", 100.0)]),
    (
        WEATHER,
        Q::RelativeHumidity,
        &[("relative_humidity", 1.0), ("relative_humidity_percent", 0.01)],
    ),
    (
        WEATHER,
        Q::Precipitation,
        &[("precipitation_mps", 1.0), ("precipitation_mm_per_h", 1e-3 / 3600.0)],
    ),
    (WEATHER, Q::WindSpeed, &[("wind_speed_mps", 1.0)]),
    (WEATHER, Q::WindDirection, &[("wind_direction_rad", 1.0), ("wind_direction_deg", DEGREE)]),
    (TRAFFIC, Q::Date, &[("time", 1.0)]),
    (TRAFFIC, Q::Time, &[("time_s", 1.0)]),
    (TRAFFIC, Q::RoadType, &[("road_type", 1.0)]),
    (TRAFFIC, Q::Site, &[("site", 1.0)]),
    (TRAFFIC, Q::DensityShare, &[("density_share", 1.0)]),
    (TRAFFIC, Q::Density, &[("density_per_m", 1.0)]),
    (TRAFFIC, Q::SpeedRatio, &[("speed_ratio", 1.0)]),
    (ROUTE, Q::Position, &[("position_m", 1.0), ("Position_m [m]", 1.0)]),
    (ROUTE, Q::Latitude, &[("lat", 1.0), ("latitude", 1.0), ("Lat [°]", 1.0)]),
    (ROUTE, Q::Longitude, &[("lon", 1.0), ("longitude", 1.0)]),
    (ROUTE, Q::Limit, &[("speed_limit_mps", 1.0), ("speed_limit_kmh", KMH)]),
    (ROUTE, Q::Altitude, &[("altitude_m", 1.0), ("elevation_m", 1.0)]),
    (ROUTE, Q::Grade, &[("grade", 1.0)]),
    (ROUTE, Q::Curvature, &[("curvature_per_m", 1.0)]),
    (ROUTE, Q::Stop, &[("stop_s", 1.0)]),
    (ROUTE, Q::RoadType, &[("road_type", 1.0)]),
    (VECTO, Q::Position, &[("<s>", 1.0), ("s [m]", 1.0), ("S", 1.0)]),
    (VECTO, Q::Speed, &[("<v>", KMH), ("<v> [Km/h]", KMH), ("v []", KMH)]),
    (VECTO, Q::Gradient, &[("<grad>", 0.01), ("<grad> [%]", 0.01)]),
    (VECTO, Q::Stop, &[("<stop>", 1.0), ("stop [s]", 1.0)]),
    (TRACKS, Q::Track, &[("track", 1.0)]),
    (TRACKS, Q::Rule, &[("rule", 1.0)]),
    (TRACKS, Q::Position, &[("position_m", 1.0)]),
    (TRACKS, Q::Value, &[("value", 1.0)]),
    (CYCLE, Q::Time, &[("time_s", 1.0), ("time", 1.0), ("<t>", 1.0), ("cycSecs", 1.0)]),
    (
        CYCLE,
        Q::Speed,
        &[
            ("speed_mps", 1.0),
            ("mps", 1.0),
            ("cycMps", 1.0),
            ("speed_kmh", KMH),
            ("<v> [km/h]", KMH),
            ("speed_mph", MPH),
            ("mph", MPH),
        ],
    ),
    (CYCLE, Q::Grade, &[("slope", 1.0), ("slope [m/m]", 1.0)]),
    (CYCLE, Q::Gradient, &[("grade", 1.0), ("cycGrade", 1.0), ("<grad> [%]", 0.01)]),
    (
        ENGINE,
        Q::EngineSpeed,
        &[
            ("n [U/min]", RPM),
            ("engine speed [1/min]", RPM),
            ("Engine Speed [rpm]", RPM),
            ("speed", RPM),
            ("rpm", RPM),
            ("input speed", RPM),
            ("retarder speed", RPM),
            ("speed_rpm", RPM),
            ("engine_speed_rpm", RPM),
        ],
    ),
    (
        ENGINE,
        Q::FullLoadTorque,
        &[
            ("Mfull [Nm]", 1.0),
            ("full load torque [Nm]", 1.0),
            ("max. torque", 1.0),
            ("torque_nm", 1.0),
            ("full_load_torque_nm", 1.0),
        ],
    ),
    (
        ENGINE,
        Q::DragTorque,
        &[
            ("Mdrag [Nm]", 1.0),
            ("motoring torque [Nm]", 1.0),
            ("drag torque", 1.0),
            ("drag_torque_nm", 1.0),
        ],
    ),
    (FUEL, Q::Torque, &[("M", 1.0), ("torque [Nm]", 1.0), ("torque_nm", 1.0)]),
    (
        FUEL,
        Q::FuelRate,
        &[("FC", GPH), ("fuel consumption [g/h]", GPH), ("fuel_gph", GPH), ("fuel", GPH)],
    ),
    (
        LOSS,
        Q::InputTorque,
        &[("Input Torque [Nm]", 1.0), ("torque", 1.0), ("input_torque_nm", 1.0)],
    ),
    (
        LOSS,
        Q::LossTorque,
        &[
            ("Torque Loss [Nm]", 1.0),
            ("loss_torque_nm", 1.0),
            ("torque_loss_nm", 1.0),
            ("loss torque", 1.0),
        ],
    ),
];

#[test]
fn names_that_were_understood_stay_understood() {
    for (what, quantity, names) in NAMES {
        for (name, factor) in *names {
            let found = understood(schema(what), name);
            assert_eq!(found, Some((*quantity, *factor)), "`{name}` of {what}");
        }
    }
}

#[test]
fn a_quantity_has_its_units_in_every_format() {
    for what in [LOG, ROUTE, CURVES] {
        for (name, factor) in [("limit_kmh", KMH), ("speed_limit_mph", MPH), ("Limit_kn", KNOT)] {
            assert_eq!(understood(schema(what), name), Some((Q::Limit, factor)), "{name} {what}");
        }
    }
    for what in [LOG, CURVES, VECTO, CYCLE] {
        for (name, factor) in [("speed_kmh", KMH), ("speed_mph", MPH), ("speed [km/h]", KMH)] {
            assert_eq!(understood(schema(what), name), Some((Q::Speed, factor)), "{name} {what}");
        }
    }
}

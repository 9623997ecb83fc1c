//! All formats of tables: what their columns are called beside the names of the vocabulary.

use super::quantity::Quantity as Q;
use super::schema::{Field, Schema, Style};
use super::unit::KMH;

/// The formats.
pub const SCHEMAS: [&Schema; 15] = [
    &LOG,
    &CURVES,
    &SPEED_CHANGES,
    &WEATHER,
    &TRAFFIC,
    &FLEET,
    &TRIP_TOTALS,
    &ROUTE,
    &STOP_PLAN,
    &VECTO_CYCLE,
    &TRACKS,
    &DRIVE_CYCLE,
    &ENGINE_CURVES,
    &FUEL_MAP,
    &LOSS_MAP,
];

/// A log of one or several drives.
pub const LOG: Schema = Schema {
    what: "a log",
    style: Style::Log,
    fields: &[
        Field::of(Q::Time),
        Field::of(Q::Date),
        Field::of(Q::Day),
        Field::of(Q::Speed),
        Field::of(Q::YawRate),
        Field::of(Q::Curvature),
        Field::of(Q::LateralAcceleration),
        Field::of(Q::SteeringWheelAngle),
        Field::named(Q::Course, &[("deg", &["gps_heading"])]),
        Field::named(Q::Latitude, &[("deg", &["latitude_deg", "gps_lat"])]),
        Field::named(Q::Longitude, &[("deg", &["longitude_deg", "gps_long", "gps_lon"])]),
        Field::of(Q::Limit),
        Field::of(Q::Accelerator),
        Field::of(Q::Brake),
        Field::of(Q::Grade),
        Field::of(Q::Position),
        Field::of(Q::Gear),
        Field::named(Q::Altitude, &[("m", &["gps_elevation", "gps_altitude"])]),
        Field::of(Q::Roughness),
        Field::of(Q::Payload),
        Field::of(Q::GrossWeight),
        Field::of(Q::FuelRate),
        Field::of(Q::FuelUsed),
        Field::of(Q::BatteryPower),
        Field::of(Q::TimeOfDay),
        Field::of(Q::DayOfYear),
        Field::of(Q::Truck),
        Field::of(Q::Driver),
        Field::of(Q::Drive),
        Field::of(Q::Event),
        Field::of(Q::RoadType),
        Field::of(Q::MapObject),
        Field::of(Q::Ignition),
        Field::of(Q::Pause),
        Field::of(Q::AmbientTemperature),
    ],
};

/// Measured curves. Driver, radius and speed are needed.
pub const CURVES: Schema = Schema {
    what: "a table of curves",
    style: Style::Measurements,
    fields: &[
        DRIVER,
        Field::named(Q::Radius, &[("m", &["radius_m"])]),
        Field::named(Q::Speed, &[("mps", &["speed_mps"])]),
        Field::of(Q::Direction),
        Field::named(Q::RouteLength, &[("m", &["route_m", "route_length_m"])]),
        Field::named(Q::Limit, &[("mps", &["limit_mps", "speed_limit_mps"])]),
        Field::named(Q::Acceleration, &[("mps2", &["acceleration_mps2"])]),
        Field::named(Q::GapBefore, &[("m", &["gap_before_m"])]),
        Field::named(Q::GapAfter, &[("m", &["gap_after_m"])]),
        Field::named(Q::SlowestNear, &[("mps", &["slowest_near_mps"])]),
        Field::named(Q::StopNear, &[("m", &["stop_near_m"])]),
    ],
};

/// Accelerations of speed changes, which are needed.
pub const SPEED_CHANGES: Schema = Schema {
    what: "a table of speed changes",
    style: Style::Measurements,
    fields: &[
        Field::named(Q::Acceleration, &[("mps2", &["acceleration_mps2"])]),
        DRIVER,
        Field::of(Q::Category),
    ],
};

/// Hourly weather. A clock and one of the others are needed.
pub const WEATHER: Schema = Schema {
    what: "a table of weather",
    style: Style::Measurements,
    fields: &[
        SINCE_NEW_YEAR,
        Field::of(Q::Date),
        Field::of(Q::Day),
        Field::of(Q::Site),
        Field::named(Q::Temperature, &[("k", &["temperature_k"]), ("c", &["temperature_c"])])
            .within(173.15, 343.15, "a temperature between -100 and 70 °C, or nothing"),
        Field::named(Q::Pressure, &[("pa", &["pressure_pa"]), ("hpa", &["pressure_hpa"])]).within(
            3e4,
            1.2e5,
            "a pressure between 300 and 1200 hPa, or nothing",
        ),
        Field::of(Q::RelativeHumidity).within(
            0.0,
            1.05,
            "a relative humidity between 0 and 1.05 (105 %), or nothing",
        ),
        Field::of(Q::Precipitation).within(0.0, 1.4e-4, "between 0 and 500 mm an hour, or nothing"),
        Field::named(Q::WindSpeed, &[("mps", &["wind_speed_mps"])]).within(
            0.0,
            120.0,
            "a wind speed between 0 and 120 m/s, or nothing",
        ),
        Field::of(Q::WindDirection).within(
            -7.0,
            7.0,
            "a direction of at most one turn, or nothing",
        ),
    ],
};

/// Traffic. A clock, the road type and one of densities and speeds are needed.
pub const TRAFFIC: Schema = Schema {
    what: "a table of traffic",
    style: Style::Measurements,
    fields: &[
        SINCE_NEW_YEAR,
        Field::of(Q::Date),
        Field::of(Q::Day),
        Field::of(Q::RoadType),
        Field::of(Q::Site),
        positive(Q::DensityShare),
        positive(Q::Density),
        positive(Q::SpeedRatio),
    ],
};

/// Records of a fleet, one row a trip. The truck is needed; the response is assigned.
pub const FLEET: Schema = Schema {
    what: "records of a fleet",
    style: Style::Measurements,
    fields: &[
        Field::named(Q::Truck, &[("", &["truck_id", "truck", "vehicle_id", "vehicle"])]),
        Field::named(Q::Driver, &[("", &["driver_id", "driver"])]),
        Field::of(Q::Response),
        Field::of(Q::Weight),
        Field::named(Q::Departure, &[("s", &["departure_s_of_year"])]),
        Field::named(
            Q::Date,
            &[("", &["departure", "date", "start", "start_time", "departure_time"])],
        ),
        Field::of(Q::Outcome),
    ],
};

/// Trips of a fleet, or fills of its tanks, a row each. Distance or odometer, and an amount of fuel
/// or energy are needed.
pub const TRIP_TOTALS: Schema = Schema {
    what: "a table of trips",
    style: Style::Measurements,
    fields: &[
        Field::named(
            Q::Distance,
            &[
                (
                    "km",
                    &[
                        "distance_km",
                        "km",
                        "kilometres",
                        "kilometers",
                        "kilometer",
                        "strecke_km",
                        "sträcka_km",
                        "distancia_km",
                    ],
                ),
                ("m", &["distance_m"]),
            ],
        )
        .within(0.0, 1e8, "a distance from 0 to 100,000 km, or nothing"),
        Field::named(
            Q::FuelAmount,
            &[
                (
                    "l",
                    &[
                        "fuel_l",
                        "litres",
                        "liters",
                        "fuel_used_l",
                        "verbrauch_l",
                        "consommation_l",
                        "förbrukning_l",
                        "consumo_l",
                    ],
                ),
                ("kg", &["fuel_kg"]),
            ],
        )
        .within(0.0, 1e5, "an amount of fuel from 0 on, or nothing"),
        Field::of(Q::EnergyAmount),
        Field::named(Q::GrossWeight, &[("kg", &["gross_weight_kg", "gross_kg", "gcw_kg"])]),
        Field::of(Q::Payload),
        Field::named(Q::DrivingTime, &[("h", &["driving_h", "driving_hours"])]),
        Field::named(Q::Duration, &[("h", &["duration_h", "hours"])]),
        Field::of(Q::Climb),
        Field::named(
            Q::Odometer,
            &[("km", &["odometer_km", "kilometerstand", "kilometerstand_km"])],
        ),
        Field::of(Q::FullTank),
        Field::named(Q::Truck, &[("", &["truck_id", "truck", "vehicle_id", "vehicle"])]),
        Field::named(Q::Driver, &[("", &["driver_id", "driver"])]),
        Field::named(Q::RouteName, &[("", &["route", "route_id", "tour", "relation"])]),
        Field::of(Q::Group),
        Field::named(
            Q::Date,
            &[("", &["departure", "date", "start", "start_time", "departure_time"])],
        ),
    ],
};

/// A route by rows. The position, or latitude and longitude, and the limit are needed.
pub const ROUTE: Schema = Schema {
    what: "a route",
    style: Style::Description,
    fields: &[
        POSITION,
        Field::named(Q::Latitude, &[("", &["lat", "latitude"])]).within(-90.0, 90.0, "-90 to 90"),
        // some count eastwards all around
        Field::named(Q::Longitude, &[("", &["lon", "longitude"])]).within(
            -180.0,
            360.0,
            "-180 to 360",
        ),
        Field::named(Q::Limit, &[("mps", &["speed_limit_mps"]), (KMH, &["speed_limit_kmh"])]),
        Field::named(Q::Altitude, &[("m", &["altitude_m", "elevation_m"])]),
        Field::of(Q::Grade),
        // those of a track
        Field::of(Q::Curvature).within(-0.5, 0.5, "-0.5 to 0.5"),
        Field::of(Q::Stop).within(0.0, 172_800.0, "0 to 172800"),
        Field::of(Q::RoadType),
        Field::of(Q::MapObject),
    ],
};

/// A stop plan. The places need positions, legs, or latitudes and longitudes.
pub const STOP_PLAN: Schema = Schema {
    what: "a stop plan",
    style: Style::Description,
    fields: &[
        Field::named(Q::Order, &[("", &["order", "no", "nr", "stop"])]),
        // the first of these that is there is the name
        Field::named(
            Q::Place,
            &[(
                "",
                &[
                    "place",
                    "ort",
                    "stop_name",
                    "name",
                    "customer",
                    "kunde",
                    "location",
                    "lieu",
                    "plats",
                    "lugar",
                    "haltestelle",
                    "address",
                    "adresse",
                ],
            )],
        ),
        Field::named(
            Q::Position,
            &[("km", &["position_km", "km", "kilometre", "kilometer", "kilometres", "kilometers"])],
        ),
        Field::of(Q::Leg).within(0.0, 5.0e6, "0 to 5000 km"),
        Field::named(Q::Latitude, &[("", &["lat", "latitude"])]).within(-90.0, 90.0, "-90 to 90"),
        Field::named(Q::Longitude, &[("", &["lon", "longitude"])]).within(
            -180.0,
            360.0,
            "-180 to 360",
        ),
        Field::of(Q::Altitude),
        Field::of(Q::Dwell).within(0.0, 172_800.0, "0 to 48 h"),
        Field::of(Q::Loaded).within(0.0, 1.0e5, "0 to 100 t"),
        Field::of(Q::Unloaded).within(0.0, 1.0e5, "0 to 100 t"),
        Field::of(Q::Payload).within(0.0, 1.0e5, "0 to 100 t"),
        Field::of(Q::Arrival),
        Field::named(
            Q::Date,
            &[(
                "",
                &["departure", "departure_time", "start", "etd", "abfahrt", "depart", "salida"],
            )],
        ),
    ],
};

/// VECTO's cycle over distance. Position and speed are needed.
pub const VECTO_CYCLE: Schema = Schema {
    what: "a cycle of VECTO",
    style: Style::Description,
    fields: &[
        Field::named(Q::Position, &[("m", &["s"])]),
        // that of any track; 0 where a truck stops
        Field::named(Q::Speed, &[(KMH, &["v"])]).within(0.0, 70.0, "0 to 252 km/h"),
        Field::named(Q::Gradient, &[("percent", &["grad"])]),
        Field::named(Q::Stop, &[("s", &["stop"])]).within(0.0, 172_800.0, "0 to 172800 s"),
    ],
};

/// The tracks that `ocmc cycle` writes. The rule follows from the track.
pub const TRACKS: Schema = Schema {
    what: "an operating cycle",
    style: Style::Description,
    fields: &[Field::of(Q::Track), Field::of(Q::Rule), POSITION, Field::of(Q::Value)],
};

/// A drive cycle over time. Time and speed are needed; without a slope the road is flat.
pub const DRIVE_CYCLE: Schema = Schema {
    what: "a drive cycle",
    style: Style::Description,
    fields: &[
        Field::named(Q::Time, &[("s", &["time_s", "time", "t", "cycsecs"])]),
        Field::named(
            Q::Speed,
            &[
                ("mps", &["speed_mps", "mps", "cycmps"]),
                (KMH, &["speed_kmh", "v"]),
                ("mph", &["speed_mph", "mph"]),
            ],
        ),
        // whatever the unit, a `grade` of a drive cycle is rise over run
        Field::named(
            Q::Gradient,
            &[("", &["grade", "cycgrade"]), ("percent", &["grad", "grade_percent"])],
        ),
        Field::named(Q::Grade, &[("", &["slope"])]),
        Field::of(Q::Altitude),
        Field::of(Q::Position),
    ],
};

/// The curves of an engine.
pub const ENGINE_CURVES: Schema = Schema {
    what: "the curves of an engine",
    style: Style::Description,
    fields: &[
        SHAFT_SPEED,
        Field::named(
            Q::FullLoadTorque,
            &[(
                "nm",
                &[
                    "mfull",
                    "m_max",
                    "full_load_torque",
                    "max._torque",
                    "torque_nm",
                    "full_load_torque_nm",
                ],
            )],
        ),
        Field::named(
            Q::DragTorque,
            &[("nm", &["mdrag", "m_min", "motoring_torque", "drag_torque", "drag_torque_nm"])],
        ),
    ],
};

/// The map of an engine.
pub const FUEL_MAP: Schema = Schema {
    what: "the fuel map of an engine",
    style: Style::Description,
    fields: &[
        SHAFT_SPEED,
        Field::named(Q::Torque, &[("nm", &["m", "torque", "torque_nm"])]),
        Field::named(Q::FuelRate, &[("gph", &["fc", "fuel_consumption", "fuel_gph", "fuel"])]),
    ],
};

/// The loss map of a gearbox, an axle or a retarder.
pub const LOSS_MAP: Schema = Schema {
    what: "a loss map",
    style: Style::Description,
    fields: &[
        SHAFT_SPEED,
        Field::named(Q::InputTorque, &[("nm", &["input_torque", "torque", "input_torque_nm"])]),
        Field::named(
            Q::LossTorque,
            &[("nm", &["torque_loss", "loss_torque_nm", "torque_loss_nm", "loss_torque"])],
        ),
    ],
};

const DRIVER: Field = Field::named(Q::Driver, &[("", &["driver", "truck"])]);
const SINCE_NEW_YEAR: Field = Field::named(Q::Time, &[("s", &["time_s"])]);
const POSITION: Field = Field::named(Q::Position, &[("m", &["position_m"])]);
const SHAFT_SPEED: Field = Field::named(
    Q::EngineSpeed,
    &[(
        "rpm",
        &[
            "n",
            "engine_speed",
            "speed",
            "rpm",
            "input_speed",
            "retarder_speed",
            "speed_rpm",
            "engine_speed_rpm",
        ],
    )],
);

/// A number that is not negative.
const fn positive(quantity: Q) -> Field {
    Field::of(quantity).within(0.0, f64::MAX, "a number from 0 on, or nothing")
}

//! All formats of tables.

use super::schema::Schema;
use crate::{curve_table, drive_cycle, given_cycle, log, speed_change_table, study};
use crate::{traffic_table, weather_table};

/// The formats.
pub const SCHEMAS: [&Schema; 12] = [
    &log::SCHEMA,
    &curve_table::SCHEMA,
    &speed_change_table::SCHEMA,
    &weather_table::SCHEMA,
    &traffic_table::SCHEMA,
    &given_cycle::ROUTE,
    &given_cycle::VECTO_CYCLE,
    &given_cycle::TRACKS,
    &drive_cycle::SCHEMA,
    &study::ENGINE_CURVES,
    &study::FUEL_MAP,
    &study::LOSS_MAP,
];

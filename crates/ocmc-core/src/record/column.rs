//! The columns of the records: one for each field, for each amount of a carrier, and for each term
//! of the ledger that is recorded so.

use super::{Outcome, Record};
use crate::energy::carrier::{ALL_STORES, CARRIERS, Carrier};
use crate::energy::ledger::{Recorded, TERMS};

/// Columns of a carrier: its amount, its consumption, and that by tonne of payload.
pub(super) const OF_CARRIER: usize = 3;
/// Columns of all carriers, and of what all stores give together.
pub(super) const OF_CARRIERS: usize = OF_CARRIER * Carrier::COUNT + 1;

/// Columns that are declared by carriers and terms of the ledger.
pub(super) const OWN_COLUMNS: usize = {
    let (mut count, mut k) = (OF_CARRIERS, 0);
    while k < TERMS.len() {
        count += matches!(TERMS[k].recorded, Recorded::Column { .. }) as usize;
        k += 1;
    }
    count
};

/// One value of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell {
    /// A count or an index, or none.
    Integer(Option<u64>),
    /// A number, or none.
    Number(Option<f64>),
    /// How the cycle ended.
    Outcome(Outcome),
}

impl Cell {
    /// A count, an index or a number; none of an outcome.
    pub fn number(self) -> Option<f64> {
        match self {
            Self::Integer(count) => count.map(|count| count as f64),
            Self::Number(number) => number,
            Self::Outcome(_) => None,
        }
    }
}

/// One column of the records.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    /// Name, with its unit as a suffix.
    pub name: &'static str,
    source: Source,
}

/// Where a column has its values from.
#[derive(Clone, Copy, Debug)]
enum Source {
    Field(fn(&Record) -> Cell),
    OwnColumn(usize),
}

impl Column {
    /// The value of a record.
    pub fn get(&self, record: &Record) -> Cell {
        match self.source {
            Source::Field(get) => get(record),
            Source::OwnColumn(k) => Cell::Number(record.own_columns[k]),
        }
    }
}

const fn column_of(name: &'static str, get: fn(&Record) -> Cell) -> Column {
    Column { name, source: Source::Field(get) }
}

fn n(value: f64) -> Cell {
    Cell::Number(Some(value))
}

fn i(value: u32) -> Cell {
    Cell::Integer(Some(u64::from(value)))
}

/// The column of that name.
pub fn column(name: &str) -> Option<&'static Column> {
    COLUMNS.iter().find(|column| column.name == name)
}

/// The columns of [`Record::own_columns`].
pub fn own_columns() -> &'static [Column] {
    &OWN
}

const OWN: [Column; OWN_COLUMNS] = {
    let mut all = [FIELDS[0]; OWN_COLUMNS];
    let mut own = 0;
    while own < OF_CARRIERS - 1 {
        let declared = &CARRIERS[own / OF_CARRIER];
        let named = match own % OF_CARRIER {
            0 => declared.amount,
            1 => declared.consumption,
            _ => declared.per_tonne,
        };
        all[own] = Column { name: named.name, source: Source::OwnColumn(own) };
        own += 1;
    }
    all[own] = Column { name: ALL_STORES.name, source: Source::OwnColumn(own) };
    own += 1;
    let mut term = 0;
    while term < TERMS.len() {
        if let Recorded::Column { name, .. } = TERMS[term].recorded {
            all[own] = Column { name, source: Source::OwnColumn(own) };
            own += 1;
        }
        term += 1;
    }
    all
};

/// The columns, in the order in which they are written: the fields, those of the carriers among
/// them, then the terms of the ledger that have a column of their own.
pub const COLUMNS: &[Column] = &ALL_COLUMNS;

const ALL_COLUMNS: [Column; FIELDS.len() + OWN_COLUMNS] = {
    let mut all = [FIELDS[0]; FIELDS.len() + OWN_COLUMNS];
    let (mut field, mut own, mut k) = (0, 0, 0);
    while k < all.len() {
        let carriers = field >= FIELDS_BEFORE_CARRIERS && own < OF_CARRIERS;
        if carriers || field == FIELDS.len() {
            all[k] = OWN[own];
            own += 1;
        } else {
            all[k] = FIELDS[field];
            field += 1;
        }
        k += 1;
    }
    all
};

/// Fields that stand before the columns of the carriers.
const FIELDS_BEFORE_CARRIERS: usize = 12;

/// The columns of the fields.
const FIELDS: &[Column] = &[
    column_of("cycle_id", |r| Cell::Integer(Some(r.cycle_id))),
    column_of("outcome", |r| Cell::Outcome(r.outcome)),
    column_of("distance_m", |r| n(r.distance_m)),
    column_of("duration_s", |r| n(r.duration_s)),
    column_of("standstill_s", |r| n(r.standstill_s)),
    column_of("mean_speed_mps", |r| n(r.mean_speed_mps)),
    column_of("n_stops", |r| i(r.n_stops)),
    column_of("n_gear_shifts", |r| i(r.n_gear_shifts)),
    column_of("wheel_energy_j", |r| n(r.wheel_energy_j)),
    column_of("brake_energy_j", |r| n(r.brake_energy_j)),
    column_of("regenerated_energy_j", |r| Cell::Number(r.regenerated_energy_j)),
    column_of("auxiliary_energy_j", |r| n(r.auxiliary_energy_j)),
    column_of("wheel_kwh_per_km", |r| n(r.wheel_kwh_per_km)),
    column_of("co2_g_per_km", |r| Cell::Number(r.co2_g_per_km)),
    column_of("climb_m", |r| n(r.climb_m)),
    column_of("payload_kg", |r| n(r.payload_kg)),
    column_of("air_temperature_k", |r| n(r.air_temperature_k)),
    column_of("head_wind_mps", |r| n(r.head_wind_mps)),
    column_of("driver_curve_speed_mps", |r| Cell::Number(r.driver_curve_speed_mps)),
    column_of("driver_curve_exponent", |r| Cell::Number(r.driver_curve_exponent)),
    column_of("driver_effect", |r| Cell::Number(r.driver_effect)),
    column_of("driver_deceleration_mps2", |r| Cell::Number(r.driver_deceleration_mps2)),
    column_of("driver_acceleration_mps2", |r| Cell::Number(r.driver_acceleration_mps2)),
    column_of("driver_compliance", |r| Cell::Number(r.driver_compliance)),
    column_of("driver_kp", |r| Cell::Number(r.driver_kp)),
    column_of("driver_ki", |r| Cell::Number(r.driver_ki)),
    column_of("driver_kd", |r| Cell::Number(r.driver_kd)),
    column_of("driver_switch_threshold_mps", |r| Cell::Number(r.driver_switch_threshold_mps)),
    column_of("driver_gain_redraws", |r| Cell::Integer(r.driver_gain_redraws.map(u64::from))),
    column_of("fuel_energy_j", |r| Cell::Number(r.fuel_energy_j)),
    column_of("engine_loss_j", |r| Cell::Number(r.engine_loss_j)),
    column_of("crankshaft_work_j", |r| Cell::Number(r.crankshaft_work_j)),
    column_of("transmission_loss_j", |r| n(r.transmission_loss_j)),
    column_of("shift_loss_j", |r| Cell::Number(r.shift_loss_j)),
    column_of("clutch_loss_j", |r| Cell::Number(r.clutch_loss_j)),
    column_of("drag_energy_j", |r| n(r.drag_energy_j)),
    column_of("rolling_energy_j", |r| n(r.rolling_energy_j)),
    column_of("service_brake_energy_j", |r| n(r.service_brake_energy_j)),
    column_of("engine_brake_energy_j", |r| Cell::Number(r.engine_brake_energy_j)),
    column_of("kinetic_change_j", |r| n(r.kinetic_change_j)),
    column_of("potential_change_j", |r| n(r.potential_change_j)),
    column_of("moving_s", |r| n(r.moving_s)),
    column_of("simulated_s", |r| n(r.simulated_s)),
    column_of("departure_s_of_year", |r| n(r.departure_s_of_year)),
    column_of("urban_share", |r| Cell::Number(r.urban_share)),
    column_of("rural_share", |r| Cell::Number(r.rural_share)),
    column_of("motorway_share", |r| Cell::Number(r.motorway_share)),
    column_of("mean_limit_mps", |r| Cell::Number(r.mean_limit_mps)),
    column_of("n_curves", |r| Cell::Integer(r.n_curves.map(u64::from))),
    column_of("drag_area_m2", |r| n(r.drag_area_m2)),
    column_of("rolling_coefficient", |r| n(r.rolling_coefficient)),
    column_of("battery_loss_j", |r| Cell::Number(r.battery_loss_j)),
    column_of("motor_loss_j", |r| Cell::Number(r.motor_loss_j)),
    column_of("charged_energy_j", |r| Cell::Number(r.charged_energy_j)),
    column_of("charging_loss_j", |r| Cell::Number(r.charging_loss_j)),
    column_of("final_charge", |r| Cell::Number(r.final_charge)),
    column_of("limited_s", |r| Cell::Number(r.limited_s)),
    column_of("missing_energy_j", |r| Cell::Number(r.missing_energy_j)),
    column_of("outside_map_energy_j", |r| Cell::Number(r.outside_map_energy_j)),
    column_of("truck_id", |r| Cell::Integer(Some(r.truck_id))),
    column_of("driver_id", |r| Cell::Integer(r.driver_id)),
    column_of("trip", |r| Cell::Integer(Some(r.trip))),
    column_of("whole_trip_m", |r| Cell::Number(r.whole_trip_m)),
    column_of("whole_trip_kwh_per_km", |r| Cell::Number(r.whole_trip_kwh_per_km)),
    column_of("rest_s", |r| Cell::Number(r.rest_s)),
    column_of("n_rests", |r| Cell::Integer(r.n_rests.map(u64::from))),
    column_of("payload_cut_kg", |r| n(r.payload_cut_kg)),
    column_of("charged_energy_depot_j", |r| Cell::Number(r.charged_energy_depot_j)),
    column_of("charged_energy_public_j", |r| Cell::Number(r.charged_energy_public_j)),
    column_of("charged_energy_stop_j", |r| Cell::Number(r.charged_energy_stop_j)),
    column_of("grid_energy_depot_j", |r| Cell::Number(r.grid_energy_depot_j)),
    column_of("grid_energy_public_j", |r| Cell::Number(r.grid_energy_public_j)),
    column_of("grid_energy_stop_j", |r| Cell::Number(r.grid_energy_stop_j)),
    column_of("n_charging_stops", |r| Cell::Integer(r.n_charging_stops.map(u64::from))),
    column_of("charging_s", |r| Cell::Number(r.charging_s)),
    column_of("charging_wait_s", |r| Cell::Number(r.charging_wait_s)),
    column_of("depot_charging_s", |r| Cell::Number(r.depot_charging_s)),
    column_of("departure_charge", |r| Cell::Number(r.departure_charge)),
    column_of("grid_co2_g_per_km", |r| Cell::Number(r.grid_co2_g_per_km)),
    column_of("well_to_wheel_g_per_km", |r| Cell::Number(r.well_to_wheel_g_per_km)),
    column_of("well_to_wheel_g_per_tkm", |r| Cell::Number(r.well_to_wheel_g_per_tkm)),
    column_of("battery_conditioning_energy_j", |r| Cell::Number(r.battery_conditioning_energy_j)),
    column_of("final_battery_temperature_k", |r| Cell::Number(r.final_battery_temperature_k)),
    column_of("lowest_charge", |r| Cell::Number(r.lowest_charge)),
    column_of("mean_payload_kg", |r| n(r.mean_payload_kg)),
    column_of("power_take_off_energy_j", |r| Cell::Number(r.power_take_off_energy_j)),
    column_of("charger_auxiliary_energy_j", |r| Cell::Number(r.charger_auxiliary_energy_j)),
    column_of("route_id", |r| Cell::Integer(r.route_id.map(u64::from))),
];

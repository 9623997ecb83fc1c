//! Terms that are compared: times, shifts, fuel, and energies by term.

use crate::file::{Series, Sum};
use ocmc_core::energy::Carrier;
use ocmc_core::energy::ledger::Term;
use ocmc_core::prescribed::FollowedCycle;
use ocmc_core::record::Record;
use serde::Serialize;

/// One second of a time series.
const SECOND_S: f64 = 1.0;

/// Terms of a truck on a mission. Energies in J.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Terms {
    /// Duration, in s.
    pub duration_s: f64,
    /// Distance, in m.
    pub distance_m: f64,
    /// Shifts; absent where they are not known.
    pub shifts: Option<u32>,
    /// Against the air.
    pub air_j: f64,
    /// Against the tyres.
    pub rolling_j: f64,
    /// Against gravity; absent where it is not known.
    pub grade_j: Option<f64>,
    /// Positive work at the wheels; absent where it is not known.
    pub wheel_j: Option<f64>,
    /// Energy of the brakes.
    pub brake_j: f64,
    /// Lost in gearbox, axle and retarder.
    pub transmission_j: f64,
    /// Part of the retarder in it; absent where it is not known.
    pub retarder_j: Option<f64>,
    /// Energy of the auxiliaries.
    pub auxiliary_j: f64,
    /// Energy of the engine, where it is positive; absent where it is not known.
    pub engine_j: Option<f64>,
    /// Fuel, in kg.
    pub fuel_kg: f64,
}

/// A term of the table: its name, its value for a person, and its unit.
pub type TermOf = (&'static str, &'static str, fn(&Terms) -> Option<f64>);

/// The terms of the table.
pub const TABLE: [TermOf; 13] = [
    ("time", "s", |t| Some(t.duration_s)),
    ("distance", "km", |t| Some(t.distance_m / 1000.0)),
    ("shifts per km", "", |t| Some(f64::from(t.shifts?) / (t.distance_m / 1000.0))),
    ("air", "kWh", |t| Some(t.air_j / 3.6e6)),
    ("rolling", "kWh", |t| Some(t.rolling_j / 3.6e6)),
    ("grade", "kWh", |t| Some(t.grade_j? / 3.6e6)),
    ("brakes", "kWh", |t| Some(t.brake_j / 3.6e6)),
    ("gearbox and axle", "kWh", |t| Some((t.transmission_j - t.retarder_j?) / 3.6e6)),
    ("retarder", "kWh", |t| Some(t.retarder_j? / 3.6e6).filter(|kwh| *kwh > 0.0)),
    ("auxiliaries", "kWh", |t| Some(t.auxiliary_j / 3.6e6)),
    ("engine, where it drives", "kWh", |t| Some(t.engine_j? / 3.6e6)),
    ("wheel work", "kWh", |t| Some(t.wheel_j? / 3.6e6)),
    ("fuel", "kg", |t| Some(t.fuel_kg)),
];

impl Terms {
    /// Terms of a followed cycle.
    pub(super) fn followed(
        sum: &FollowedCycle,
        n_shifts: u32,
        retarder_j: f64,
        heating_jpkg: f64,
    ) -> Self {
        let ledger = &sum.ledger;
        Self {
            duration_s: sum.duration_s,
            distance_m: ledger[Term::Distance],
            shifts: Some(n_shifts),
            air_j: ledger[Term::Drag],
            rolling_j: ledger[Term::Rolling],
            grade_j: Some(ledger[Term::Grade]),
            wheel_j: Some(ledger[Term::Wheel]),
            brake_j: ledger[Term::ServiceBrake] + ledger[Term::EngineBrake],
            transmission_j: ledger[Term::Transmission],
            auxiliary_j: ledger[Term::Auxiliary],
            retarder_j: Some(retarder_j),
            engine_j: Some(sum.driving_j),
            fuel_kg: ledger[Term::FuelEnergy] / heating_jpkg,
        }
    }

    /// Terms of a time series of VECTO.
    pub(super) fn series(series: &Series) -> Self {
        let integral = |value: fn(&crate::file::Second) -> f64| {
            series.seconds.iter().map(value).map(|x| x * SECOND_S).sum::<f64>()
        };
        let mut engaged = series.seconds.iter().map(|second| second.gear).filter(|gear| *gear > 0);
        let mut last = engaged.next();
        let mut shifts = 0;
        for gear in engaged {
            shifts += u32::from(Some(gear) != last);
            last = Some(gear);
        }
        Self {
            duration_s: series.seconds.len() as f64 * SECOND_S,
            distance_m: series.seconds.last().map_or(0.0, |second| second.end_m),
            shifts: Some(shifts),
            air_j: integral(|s| s.drag_w),
            rolling_j: integral(|s| s.rolling_w),
            grade_j: Some(integral(|s| s.grade_w)),
            wheel_j: Some(integral(|s| s.wheel_w.max(0.0))),
            brake_j: -integral(|s| s.brake_w),
            transmission_j: integral(|s| s.lost_w),
            retarder_j: Some(integral(|s| s.retarder_w)),
            auxiliary_j: integral(|s| s.auxiliary_w),
            engine_j: Some(integral(|s| s.engine_w.max(0.0))),
            fuel_kg: integral(|s| s.fuel_kgps),
        }
    }

    /// Terms of a driven cycle.
    pub(super) fn record(record: &Record) -> Self {
        Self {
            duration_s: record.duration_s,
            distance_m: record.distance_m,
            shifts: Some(record.n_gear_shifts),
            air_j: record.drag_energy_j,
            rolling_j: record.rolling_energy_j,
            grade_j: Some(record.potential_change_j),
            wheel_j: Some(record.wheel_energy_j),
            brake_j: record.brake_energy_j,
            transmission_j: record.transmission_loss_j,
            retarder_j: None,
            auxiliary_j: record.auxiliary_energy_j,
            engine_j: None,
            fuel_kg: record.amount(Carrier::LiquidFuel).unwrap_or(0.0),
        }
    }

    /// Terms of a row of sums of VECTO.
    pub(super) fn sum(sum: &Sum) -> Self {
        Self {
            duration_s: sum.time_s,
            distance_m: sum.distance_m,
            shifts: None,
            air_j: sum.air_j,
            rolling_j: sum.rolling_j,
            grade_j: None,
            wheel_j: None,
            brake_j: sum.brake_j,
            transmission_j: sum.gearbox_axle_j + sum.retarder_j,
            retarder_j: Some(sum.retarder_j),
            auxiliary_j: sum.auxiliary_j,
            engine_j: Some(sum.engine_j),
            fuel_kg: sum.fuel_kg,
        }
    }
}

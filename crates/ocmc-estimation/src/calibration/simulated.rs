//! The table of curves that a study's drivers would leave: driven, taken as logs, detected.

use crate::fit::curve_speed::CurveTable;
use crate::log::TripLog;
use crate::log::curve::{CurveOptions, detect_curves};
use ocmc_core::kernel::drive::trace::{Trace, motions};
use ocmc_core::lanes::WIDTH;
use ocmc_core::study::Study;
use ocmc_fleet::run::pool;
use rayon::prelude::*;

/// Which trips are driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trips {
    /// Master seed.
    pub seed: u64,
    /// Number of drivers.
    pub drivers: u64,
    /// Trips of each of them, on different roads.
    pub per_driver: u64,
}

/// What `ocmc curves` would find in these trips; none of trips that cannot be used. Logs of curves
/// need 5 Hz: the study's step is the caller's to choose.
pub fn simulated_curves(study: &Study, trips: &Trips, options: &CurveOptions) -> CurveTable {
    let count = trips.drivers * trips.per_driver;
    let scenario = |trip: u64| {
        let mut scenario = study.sample(trips.seed, trip);
        let first = trip - trip % trips.per_driver;
        if first != trip {
            scenario.driver = study.sample(trips.seed, first).driver;
        }
        scenario
    };
    let blocks: Vec<u64> = (0..count).step_by(WIDTH).collect();
    let tables = |first: u64| {
        let block = first..(first + WIDTH as u64).min(count);
        let drives = motions(study, block.clone().map(scenario));
        let of_trip = |(trip, drive)| of_trip(&drive, trip / trips.per_driver, options);
        block.zip(drives).map(of_trip).collect::<Vec<_>>()
    };
    let tables: Vec<CurveTable> =
        pool(0).install(|| blocks.into_par_iter().flat_map_iter(tables).collect());
    let mut all = CurveTable { left: Some(Vec::new()), ..CurveTable::default() };
    for table in tables {
        all.driver.extend(table.driver);
        all.radius_m.extend(table.radius_m);
        all.speed_mps.extend(table.speed_mps);
        if let (Some(all), Some(left)) = (&mut all.left, table.left) {
            all.extend(left);
        }
    }
    all
}

/// The curves of one trip.
fn of_trip(trace: &Trace, driver: u64, options: &CurveOptions) -> CurveTable {
    let column = |name: &str| {
        let column = trace.columns.iter().find(|column| column.name == name);
        column.map_or(&[][..], |column| column.values.as_slice()).into()
    };
    let log = TripLog {
        time_s: column("time_s"),
        speed_mps: column("speed_mps"),
        yaw_rate_radps: column("yaw_rate_radps"),
        ..TripLog::default()
    };
    let found = detect_curves(&log, options).map_or_else(|_| Vec::new(), |found| found.curves);
    CurveTable {
        driver: vec![driver.to_string(); found.len()],
        radius_m: found.iter().map(|curve| curve.radius_m).collect(),
        speed_mps: found.iter().map(|curve| curve.speed_mps).collect(),
        left: Some(found.iter().map(|curve| curve.left).collect()),
        ..CurveTable::default()
    }
}

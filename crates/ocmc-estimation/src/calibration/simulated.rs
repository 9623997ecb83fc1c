//! The table of curves that a study's drivers would leave: driven, taken as logs, detected.

use crate::fit::curve_speed::CurveTable;
use crate::log::TripLog;
use crate::log::curve::{CurveOptions, detect_curves};
use ocmc_core::kernel::drive::trace::{Trace, motions};
use ocmc_core::lanes::WIDTH;
use ocmc_core::study::Study;
use ocmc_fleet::run::{RunPlan, each};
use std::convert::Infallible;
use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;

/// Trips that are driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trips {
    /// Master seed.
    pub seed: u64,
    /// Number of drivers.
    pub drivers: u64,
    /// Trips of each of them, on different roads.
    pub per_driver: u64,
    /// Threads; one for each CPU where it is 0.
    pub threads: usize,
}

/// Curves that `ocmc curves` would find in these trips; none of trips that cannot be used. Logs of
/// curves need 5 Hz: the study's step is the caller's to choose.
pub fn simulated_curves(study: &Study, trips: &Trips, options: &CurveOptions) -> CurveTable {
    let curves = watched_curves(study, trips, options, || ControlFlow::<Infallible>::Continue(()));
    match curves {
        ControlFlow::Continue(table) => table,
        ControlFlow::Break(never) => match never {},
    }
}

/// As [`simulated_curves`]; `look` is asked several times a second whether to go on.
pub(super) fn watched_curves<B>(
    study: &Study,
    trips: &Trips,
    options: &CurveOptions,
    mut look: impl FnMut() -> ControlFlow<B>,
) -> ControlFlow<B, CurveTable> {
    let count = trips.drivers * trips.per_driver;
    let scenario = |trip: u64| {
        let mut scenario = study.sample(trips.seed, trip);
        let first = trip - trip % trips.per_driver;
        if first != trip {
            scenario.driver = study.sample(trips.seed, first).driver;
        }
        scenario
    };
    let tables = |block: u64, _: &AtomicBool| {
        let first = block * WIDTH as u64;
        let block = first..(first + WIDTH as u64).min(count);
        let drives = motions(study, block.clone().map(scenario));
        let of_trip = |(trip, drive)| of_trip(&drive, trip / trips.per_driver, options);
        block.zip(drives).map(of_trip).collect::<Vec<_>>()
    };
    let plan = RunPlan::new(trips.seed, 0, count.div_ceil(WIDTH as u64), None, Some(1));
    let tables = each(&RunPlan { threads: trips.threads, ..plan }, &tables, |_| look())?;
    let mut all = CurveTable { left: Some(Vec::new()), ..CurveTable::default() };
    for table in tables.into_iter().flatten() {
        all.driver.extend(table.driver);
        all.radius_m.extend(table.radius_m);
        all.speed_mps.extend(table.speed_mps);
        if let (Some(all), Some(left)) = (&mut all.left, table.left) {
            all.extend(left);
        }
    }
    ControlFlow::Continue(all)
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
    let curves =
        detect_curves(&log, options).map_or_else(|_| Vec::new(), |detection| detection.curves);
    CurveTable {
        driver: vec![driver.to_string(); curves.len()],
        radius_m: curves.iter().map(|curve| curve.radius_m).collect(),
        speed_mps: curves.iter().map(|curve| curve.speed_mps).collect(),
        left: Some(curves.iter().map(|curve| curve.left).collect()),
        ..CurveTable::default()
    }
}

//! One event of a drive: a truck that already rolls, for a given time, from the same step function as a fleet.
//!
//! It is what the identification of a driver's gains simulates again and again.

use super::battery_electric::BatteryElectric;
use super::diesel::Diesel;
use super::lane_task::Cabin;
use super::powertrain::Traction;
use super::state::{Shared, State};
use crate::study::{Scenario, Study};
use crate::vehicle::Drive;
#[cfg(not(target_arch = "x86_64"))]
use fearless_simd::dispatch;
use fearless_simd::{Level, prelude::*};

/// How a truck rolls where an event begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rolling {
    /// Way from the start of the scenario's road, in m; within its first segment.
    pub offset_m: f64,
    /// Speed, in m/s.
    pub speed_mps: f64,
    /// Gear, from 0.
    pub gear: usize,
    /// Accelerator pedal that the engine's torque has followed.
    pub accelerator: f64,
    /// Integral part J of the controller.
    pub integral: f64,
    /// Filtered speed of its derivative part, in m/s.
    pub filtered_mps: f64,
    /// Output that a switched driver holds.
    pub held: f64,
    /// Whether the switched driver is holding it.
    pub holds: bool,
}

/// The time series of an event, at the ends of the steps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EventDrive {
    /// Time since the start, in s.
    pub time_s: Vec<f64>,
    /// Speed, in m/s.
    pub speed_mps: Vec<f64>,
    /// Accelerator pedal.
    pub accelerator: Vec<f64>,
    /// Brake pedal.
    pub brake: Vec<f64>,
}

/// Drives an event for some time, in s, or until the road ends.
pub fn drive_event(
    study: &Study,
    scenario: Scenario,
    rolling: &Rolling,
    duration_s: f64,
) -> EventDrive {
    let cabin = Cabin::new(study, scenario);
    match &study.powertrain().drive {
        Drive::Diesel(drive) => {
            let shared = Shared::new(study, Diesel::new(drive, &study.powertrain().model));
            drive_on(&shared, cabin, rolling, duration_s)
        }
        Drive::BatteryElectric(drive) => {
            let shared = Shared::new(study, BatteryElectric::new(drive));
            drive_on(&shared, cabin, rolling, duration_s)
        }
    }
}

/// With AVX2 where the CPU has it: one truck gains nothing from wider vectors.
fn drive_on<T: Traction>(
    shared: &Shared<T>,
    cabin: Cabin,
    rolling: &Rolling,
    duration_s: f64,
) -> EventDrive {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = Level::new().as_avx2() {
        return simd.vectorize(
            #[inline(always)]
            || drive_cabin(simd, shared, cabin, rolling, duration_s),
        );
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = Level::baseline().as_sse2() {
        return simd.vectorize(
            #[inline(always)]
            || drive_cabin(simd, shared, cabin, rolling, duration_s),
        );
    }
    #[cfg(target_arch = "x86_64")]
    unreachable!("x86-64 has SSE2");
    #[cfg(not(target_arch = "x86_64"))]
    dispatch!(Level::baseline(), simd => drive_cabin(simd, shared, cabin, rolling, duration_s))
}

#[inline(always)]
fn drive_cabin<S: Simd, T: Traction>(
    simd: S,
    shared: &Shared<T>,
    mut cabin: Cabin,
    rolling: &Rolling,
    duration_s: f64,
) -> EventDrive {
    let mut state = State::parked(simd, shared);
    cabin.enter(&mut state, 0, shared);
    cabin.roll(&mut state, 0, rolling, shared);
    let mut drive = EventDrive::default();
    let mut time_s = 0.0;
    while time_s < duration_s {
        let view = state.step(shared);
        if view.dt[0] == 0.0 {
            continue; // it was taken back
        }
        time_s += view.dt[0];
        drive.time_s.push(time_s);
        drive.speed_mps.push(state.speed[0]);
        drive.accelerator.push(view.accelerator[0]);
        drive.brake.push(view.brake[0]);
        let sights = view.sights();
        if sights.alarm & 1 != 0 && cabin.attend(&mut state, 0, sights.of(0), shared).is_some() {
            break;
        }
    }
    drive
}

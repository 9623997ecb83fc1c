//! One event of a drive: a truck that already rolls, for a given time, from the same step function
//! as a fleet.
//!
//! It is what the identification of a driver's gains simulates again and again.

use super::cpu::{CpuLevel, SimdTask};
use super::lane_task::LaneTask;
use super::state::{KernelParameters, Lane, State};
use crate::powertrain::{Powertrain, PowertrainTask};
use crate::study::{Scenario, Study};
use fearless_simd::prelude::*;

/// How a truck rolls where an event begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialMotion {
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
pub struct EventSeries {
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
pub fn simulate_event(
    study: &Study,
    scenario: Scenario,
    rolling: &InitialMotion,
    duration_s: f64,
) -> EventSeries {
    let task = LaneTask::new(study, scenario);
    let powertrain = &study.vehicle().powertrain;
    powertrain.dispatch(EventTask { study, task, rolling, duration_s })
}

struct EventTask<'a> {
    study: &'a Study,
    task: LaneTask,
    rolling: &'a InitialMotion,
    duration_s: f64,
}

impl PowertrainTask for EventTask<'_> {
    type Answer = EventSeries;

    fn run<P: Powertrain>(self, powertrain: &P) -> EventSeries {
        let parameters = KernelParameters::new(self.study, powertrain);
        CpuLevel::best().run_narrow(Rolling { parameters, event: self })
    }
}

struct Rolling<'a, P> {
    parameters: KernelParameters<'a, P>,
    event: EventTask<'a>,
}

impl<P: Powertrain> SimdTask for Rolling<'_, P> {
    type Answer = EventSeries;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> EventSeries {
        let EventTask { mut task, rolling, duration_s, .. } = self.event;
        let parameters = &self.parameters;
        let state = &mut State::parked(simd, parameters);
        let mut lane = Lane { state, number: 0, parameters };
        task.enter(&mut lane);
        task.roll(&mut lane, rolling);
        let mut series = EventSeries::default();
        let mut time_s = 0.0;
        while time_s < duration_s {
            let view = lane.state.step(parameters);
            if view.dt[0] == 0.0 {
                continue; // it was taken back
            }
            time_s += view.dt[0];
            series.time_s.push(time_s);
            series.speed_mps.push(lane.state.motion.speed[0]);
            series.accelerator.push(view.accelerator[0]);
            series.brake.push(view.brake[0]);
            let events = view.events();
            if events.lanes & 1 != 0 && task.handle_event(&mut lane, events.lane(0)).is_some() {
                break;
            }
        }
        series
    }
}

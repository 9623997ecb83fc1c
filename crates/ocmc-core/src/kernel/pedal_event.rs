//! One event of a drive: a truck that already rolls, for a given time, from the same step function
//! as a fleet.
//!
//! It is what the identification of a driver's gains simulates again and again.

use super::cpu::{CpuLevel, SimdTask};
use super::lane_task::LaneTask;
use super::road_row::RoadRow;
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
    /// How late the driver sees the speed, in s: his reaction time.
    pub reaction_delay_s: f64,
    /// Acceleration before the start, in m/s²: what a driver sees late begins before the event.
    pub acceleration_mps2: f64,
}

/// What a driver sees who sees the speed late.
///
/// The controller of the step knows error and change of the speed now. It gets the late ones by a
/// desired speed that is moved by what the speed has gained since, and by a filtered speed that is
/// as far from the speed as the late ones are from each other. Both are held over a step.
struct LateSight {
    delay_s: f64,
    filter_s: f64,
    desired_mps: f64,
    /// Speed and acceleration at the start.
    start: [f64; 2],
    /// Time of the last look, the speed that was seen then, and that speed behind its filter.
    time_s: f64,
    seen_mps: f64,
    filtered_mps: f64,
    /// Row of the series from which the next look goes on.
    row: usize,
}

impl LateSight {
    fn new(rolling: &InitialMotion, filter_s: f64, desired_mps: f64) -> Self {
        let delay_s = rolling.reaction_delay_s;
        let seen_mps = rolling.speed_mps - delay_s * rolling.acceleration_mps2;
        Self {
            delay_s,
            filter_s,
            desired_mps,
            start: [rolling.speed_mps, rolling.acceleration_mps2],
            time_s: 0.0,
            seen_mps,
            filtered_mps: seen_mps - (rolling.speed_mps - rolling.filtered_mps),
            row: 0,
        }
    }

    /// Speed at a time, in m/s: of the series, or before the start.
    fn speed_mps(&mut self, series: &EventSeries, time_s: f64) -> f64 {
        if time_s <= 0.0 {
            return self.start[0] + time_s * self.start[1];
        }
        while series.time_s.get(self.row).is_some_and(|end_s| *end_s < time_s) {
            self.row += 1;
        }
        let at = |row: usize| [series.time_s[row], series.speed_mps[row]];
        let before = self.row.checked_sub(1).map_or([0.0, self.start[0]], at);
        let Some(after_s) = series.time_s.get(self.row) else { return before[1] };
        let part = (time_s - before[0]) / (after_s - before[0]);
        before[1] + part * (series.speed_mps[self.row] - before[1])
    }

    /// Shows the lane what its driver sees at this time.
    fn show<S: Simd, P: Powertrain>(
        &mut self,
        lane: &mut Lane<S, P>,
        series: &EventSeries,
        now_s: f64,
    ) {
        let step_s = now_s - self.time_s;
        let seen_mps = self.speed_mps(series, now_s - self.delay_s);
        if step_s > 0.0 {
            // the exact answer of a first-order lag to a ramp
            let behind_mps = self.filter_s * (seen_mps - self.seen_mps) / step_s;
            let left = libm::exp(-step_s / self.filter_s);
            self.filtered_mps =
                seen_mps - behind_mps + (self.filtered_mps - self.seen_mps + behind_mps) * left;
            (self.time_s, self.seen_mps) = (now_s, seen_mps);
        }
        let motion = &mut lane.state.motion;
        let speed_mps = motion.speed[lane.number];
        let desired_mps = (self.desired_mps + speed_mps - seen_mps).max(0.0);
        motion.filtered[lane.number] = speed_mps - (seen_mps - self.filtered_mps);
        let at = motion.at[lane.number];
        // a step begins with the next row where this one has ended
        for row in motion.roads[lane.number].iter_mut().skip(at).take(2) {
            row.0[RoadRow::LIMIT] = desired_mps * desired_mps;
        }
    }
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
        let filter_s = parameters.pedals.pid.derivative_filter_s;
        let limit = lane.state.motion.roads[0].first().map_or(0.0, |row| row.0[RoadRow::LIMIT]);
        let mut late = (rolling.reaction_delay_s > 0.0)
            .then(|| LateSight::new(rolling, filter_s, limit.sqrt()));
        while time_s < duration_s {
            if let Some(late) = &mut late {
                late.show(&mut lane, &series, time_s);
            }
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

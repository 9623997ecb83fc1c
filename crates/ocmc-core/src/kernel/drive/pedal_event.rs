//! Events of a drive: trucks that already roll, for a given time, from the same step function as a
//! fleet.
//!
//! It is what the identification of a driver's gains simulates again and again, with other gains in
//! each lane.

use super::cpu::{CpuLevel, SimdTask};
use crate::kernel::step::road_row::RoadRow;
use crate::kernel::step::state::{KernelParameters, Lane, State};
use crate::kernel::step::step_view::StepView;
use crate::kernel::trip::InitialMotion;
use crate::kernel::trip::lane_task::LaneTask;
use crate::lanes::WIDTH;
use crate::powertrain::{Powertrain, PowertrainTask};
use crate::study::{Scenario, Study};
use fearless_simd::prelude::*;

/// State of a driver who sees the speed late.
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

/// A truck that rolls into an event: its scenario, and how it rolls.
pub type RollingStart = (Scenario, InitialMotion);

/// Drives events for some time each, in s, or until their roads end, side by side. The
/// series are in the order of the starts, and none depends on the others.
pub fn simulate_events(
    study: &Study,
    starts: &[RollingStart],
    duration_s: f64,
) -> Vec<EventSeries> {
    study.vehicle().powertrain.dispatch(EventsTask { study, starts, duration_s })
}

struct EventsTask<'a> {
    study: &'a Study,
    starts: &'a [RollingStart],
    duration_s: f64,
}

impl PowertrainTask for EventsTask<'_> {
    type Answer = Vec<EventSeries>;

    fn run<P: Powertrain>(self, powertrain: &P) -> Vec<EventSeries> {
        let parameters = KernelParameters::new(self.study, powertrain);
        CpuLevel::best().run_narrow(Rolling { parameters, events: self })
    }
}

/// A truck in a lane, and what was noted of it.
struct Rolled {
    task: LaneTask,
    late: Option<LateSight>,
    series: EventSeries,
    time_s: f64,
    drives: bool,
}

struct Rolling<'a, P> {
    parameters: KernelParameters<'a, P>,
    events: EventsTask<'a>,
}

impl<P: Powertrain> SimdTask for Rolling<'_, P> {
    type Answer = Vec<EventSeries>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Vec<EventSeries> {
        let mut all = Vec::with_capacity(self.events.starts.len());
        for block in self.events.starts.chunks(WIDTH) {
            let mut state = State::parked(simd, &self.parameters);
            let mut trucks = self.enter(&mut state, block);
            while trucks.iter().any(|truck| truck.drives) {
                for (number, truck) in trucks.iter_mut().enumerate() {
                    if let (true, Some(late)) = (truck.drives, &mut truck.late) {
                        let mut lane =
                            Lane { state: &mut state, number, parameters: &self.parameters };
                        late.show(&mut lane, &truck.series, truck.time_s);
                    }
                }
                let view = state.step(&self.parameters);
                self.note(&mut state, &view, &mut trucks);
            }
            all.extend(trucks.into_iter().map(|truck| truck.series));
        }
        all
    }
}

impl<P: Powertrain> Rolling<'_, P> {
    /// Lets the trucks of a block roll into their lanes.
    fn enter<S: Simd>(&self, state: &mut State<S, P>, block: &[RollingStart]) -> Vec<Rolled> {
        let filter_s = self.parameters.pedals.pid.derivative_filter_s;
        let starts = block.iter().enumerate();
        let entered = starts.map(|(number, (scenario, rolling))| {
            let mut task = LaneTask::new(self.events.study, scenario.clone());
            let mut lane = Lane { state, number, parameters: &self.parameters };
            task.enter(&mut lane);
            task.roll(&mut lane, rolling);
            let first = lane.state.motion.roads[number].first();
            let limit = first.map_or(0.0, |row| row.0[RoadRow::LIMIT]);
            let late = (rolling.reaction_delay_s > 0.0)
                .then(|| LateSight::new(rolling, filter_s, limit.sqrt()));
            let drives = self.events.duration_s > 0.0;
            Rolled { task, late, series: EventSeries::default(), time_s: 0.0, drives }
        });
        entered.collect()
    }

    /// Notes a step of the trucks and handles its events; those who have arrived are taken off
    /// the road.
    #[inline(always)]
    fn note<S: Simd>(&self, state: &mut State<S, P>, view: &StepView<S>, trucks: &mut [Rolled]) {
        let events = view.events();
        for (number, truck) in trucks.iter_mut().enumerate() {
            let step_s = view.dt[number];
            if !truck.drives || step_s == 0.0 {
                continue; // a step that was taken back
            }
            truck.time_s += step_s;
            truck.series.time_s.push(truck.time_s);
            truck.series.speed_mps.push(state.motion.speed[number]);
            truck.series.accelerator.push(view.accelerator[number]);
            truck.series.brake.push(view.brake[number]);
            let mut lane = Lane { state, number, parameters: &self.parameters };
            let has_event = events.lanes >> number & 1 != 0;
            let ends =
                has_event && truck.task.handle_event(&mut lane, events.lane(number)).is_some();
            truck.drives = !ends && truck.time_s < self.events.duration_s;
            if !truck.drives {
                truck.task.leave(&mut lane);
                lane.park();
            }
        }
    }
}

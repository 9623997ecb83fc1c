//! Trucks that roll into events: how their drivers see them, and what is noted of them.

use crate::kernel::step::road_row::RoadRow;
use crate::kernel::step::state::{KernelParameters, Lane, State};
use crate::kernel::step::step_view::StepView;
use crate::kernel::trip::InitialMotion;
use crate::kernel::trip::lane_task::LaneTask;
use crate::lanes::WIDTH;
use crate::powertrain::Powertrain;
use fearless_simd::prelude::*;
use std::vec::IntoIter;

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

/// A truck that rolls, and what was noted of it.
struct RollingTruck {
    late: Option<LateSight>,
    series: EventSeries,
    time_s: f64,
}

/// Trucks in the order in which they enter the lanes.
pub(super) struct RollingTrucks {
    /// How those roll that are still to enter.
    ahead: IntoIter<InitialMotion>,
    /// Trucks that have entered.
    trucks: Vec<RollingTruck>,
    /// The truck in each lane of two blocks.
    in_lane: [usize; 2 * WIDTH],
    duration_s: f64,
}

impl RollingTrucks {
    pub(super) fn new(rolling: Vec<InitialMotion>, duration_s: f64) -> Self {
        let trucks = Vec::with_capacity(rolling.len());
        Self { ahead: rolling.into_iter(), trucks, in_lane: [0; 2 * WIDTH], duration_s }
    }

    /// Lets the next truck roll into a lane.
    pub(super) fn entered<S: Simd, P: Powertrain>(
        &mut self,
        first: usize,
        task: &mut LaneTask,
        lane: &mut Lane<S, P>,
    ) {
        let rolling = self.ahead.next().expect("each truck rolls somehow");
        task.roll(lane, &rolling);
        let limit = lane.state.motion.roads[lane.number].first();
        let limit = limit.map_or(0.0, |row| row.0[RoadRow::LIMIT]);
        let filter_s = lane.parameters.pedals.pid.derivative_filter_s;
        let late = (rolling.reaction_delay_s > 0.0)
            .then(|| LateSight::new(&rolling, filter_s, limit.sqrt()));
        self.in_lane[first + lane.number] = self.trucks.len();
        self.trucks.push(RollingTruck { late, series: EventSeries::default(), time_s: 0.0 });
    }

    /// Shows the drivers who see late what they see.
    pub(super) fn before_step<S: Simd, P: Powertrain>(
        &mut self,
        parameters: &KernelParameters<P>,
        state: &mut State<S, P>,
        (first, tasks): (usize, &[Option<LaneTask>]),
    ) {
        for number in (0..WIDTH).filter(|number| tasks[*number].is_some()) {
            let truck = &mut self.trucks[self.in_lane[first + number]];
            if let Some(late) = &mut truck.late {
                late.show(&mut Lane { state, number, parameters }, &truck.series, truck.time_s);
            }
        }
    }

    /// Notes a step of the trucks. Returns the lanes whose time is over, as bits.
    pub(super) fn after_step<S: Simd, P: Powertrain>(
        &mut self,
        state: &State<S, P>,
        view: &StepView<S>,
        (first, tasks): (usize, &[Option<LaneTask>]),
    ) -> u64 {
        let mut over = 0;
        for number in (0..WIDTH).filter(|number| tasks[*number].is_some()) {
            let step_s = view.dt[number];
            if step_s == 0.0 {
                continue; // a step that was taken back
            }
            let RollingTruck { series, time_s, .. } =
                &mut self.trucks[self.in_lane[first + number]];
            *time_s += step_s;
            series.time_s.push(*time_s);
            series.speed_mps.push(state.motion.speed[number]);
            series.accelerator.push(view.accelerator[number]);
            series.brake.push(view.brake[number]);
            over |= u64::from(*time_s >= self.duration_s) << number;
        }
        over
    }

    /// Series of the trucks, in the order of entering.
    pub(super) fn into_series(self) -> Vec<EventSeries> {
        self.trucks.into_iter().map(|truck| truck.series).collect()
    }
}

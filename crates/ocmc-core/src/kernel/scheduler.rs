//! Drives a range of cycles, eight or sixteen side by side: a lane takes the next cycle as soon as
//! its own has ended.

use super::cpu::{CpuLevel, SimdTask, run_baseline};
use super::lane_task::LaneTask;
use super::state::{KernelParameters, Lane, State};
use super::step::steps;
use super::step_view::{LaneEvents, StepView};
use crate::lanes::{WIDTH, interleaves_blocks};
use crate::powertrain::{Powertrain, PowertrainTask};
use crate::record::{Outcome, Record};
use crate::study::{Scenario, Study};
use crate::tactical::SpeedProfile;
use fearless_simd::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Observes every step of every lane: a trace does, a fleet does not.
pub trait Observer {
    /// After a step, before its events are handled.
    fn after_step<S: Simd, P: Powertrain>(
        &mut self,
        _parameters: &KernelParameters<P>,
        _state: &State<S, P>,
        _view: &StepView<S>,
        _tasks: &[Option<LaneTask>],
    ) {
    }
    /// After the event of a lane, that of this task, has been handled.
    fn after_event<S: Simd, P: Powertrain>(
        &mut self,
        _parameters: &KernelParameters<P>,
        _state: &State<S, P>,
        _task: (usize, &LaneTask),
    ) {
    }
    /// Whether the run is to stop: cycles that are on the road are then given up.
    fn is_stopped(&self) -> bool {
        false
    }
}

/// Observes nothing; once the flag is set, the cycles on the road are given up.
#[derive(Clone, Copy, Debug)]
pub struct StopFlag<'a>(pub &'a AtomicBool);

impl Observer for StopFlag<'_> {
    fn is_stopped(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Gives the next task; takes back the used one, whose buffers are reused.
pub type Next<'a> = &'a mut dyn FnMut(Option<LaneTask>) -> Option<LaneTask>;

/// Drives the cycles of a range; the records are in order of the ids.
pub fn drive(study: &Study, seed: u64, cycles: Range<u64>, level: CpuLevel) -> Vec<Record> {
    drive_tasks(study, &mut sampled(study, seed, cycles), level)
}

/// Drives the tasks that `next` gives; the records are in order of the cycle ids.
pub fn drive_tasks(study: &Study, next: Next, level: CpuLevel) -> Vec<Record> {
    drive_until(study, next, level, &AtomicBool::new(false))
}

/// As [`drive_tasks`], until a flag is set; there are no records of cycles that were given up.
pub fn drive_until(study: &Study, next: Next, level: CpuLevel, stop: &AtomicBool) -> Vec<Record> {
    study.vehicle().powertrain.dispatch(FleetTask { study, next, level, stop, whole_trips: true })
}

/// As [`drive_until`]; of trips that a battery cuts short the rest is not driven.
pub fn drive_until_empty(
    study: &Study,
    next: Next,
    level: CpuLevel,
    stop: &AtomicBool,
) -> Vec<Record> {
    study.vehicle().powertrain.dispatch(FleetTask { study, next, level, stop, whole_trips: false })
}

struct FleetTask<'a, 'b> {
    study: &'a Study,
    next: Next<'b>,
    level: CpuLevel,
    stop: &'a AtomicBool,
    whole_trips: bool,
}

impl PowertrainTask for FleetTask<'_, '_> {
    type Answer = Vec<Record>;

    fn run<P: Powertrain>(self, powertrain: &P) -> Vec<Record> {
        let Self { study, level, stop, whole_trips, .. } = self;
        let parameters = KernelParameters::new(study, powertrain);
        let observer = &mut StopFlag(stop);
        let driven = level.run(LaneScheduler::new(study, &parameters, self.next, observer));
        if whole_trips {
            driven.with_whole_trips(study, powertrain, level, stop)
        } else {
            driven.records
        }
    }
}

/// As [`drive_tasks`], with an observer of every step: slower.
pub fn drive_observed<P: Powertrain, O: Observer>(
    study: &Study,
    powertrain: &P,
    next: Next,
    observer: &mut O,
) -> Vec<Record> {
    let parameters = KernelParameters::new(study, powertrain);
    let driven = run_baseline(LaneScheduler::new(study, &parameters, next, observer));
    driven.with_whole_trips(study, powertrain, CpuLevel::Baseline, &AtomicBool::new(false))
}

/// What a scheduler has driven.
struct Driven {
    /// In order of the cycle ids.
    records: Vec<Record>,
    /// What the cycles drove that a battery cut short, in the same order.
    cut_short: Vec<Scenario>,
}

impl Driven {
    /// The records, with the whole trips of the cycles that were cut short: driven again from their
    /// start, with a battery that never empties.
    fn with_whole_trips<P: Powertrain>(
        self,
        study: &Study,
        powertrain: &P,
        level: CpuLevel,
        stop: &AtomicBool,
    ) -> Vec<Record> {
        let Self { mut records, cut_short } = self;
        let (false, Some(deep)) = (cut_short.is_empty(), powertrain.never_emptying()) else {
            return records;
        };
        let parameters = KernelParameters::new(study, &deep);
        let mut scenarios = cut_short.into_iter();
        let mut next = |_| scenarios.next().map(|scenario| LaneTask::new(study, scenario));
        let observer = &mut StopFlag(stop);
        let whole = level.run(LaneScheduler::new(study, &parameters, &mut next, observer)).records;
        let depleted = records.iter_mut().filter(|record| record.outcome == Outcome::Depleted);
        for (record, whole) in depleted.zip(whole) {
            if whole.outcome == Outcome::Completed {
                record.drove_whole_trip(whole.distance_m, whole.consumption_kwh_per_km);
            }
        }
        records
    }
}

/// Gives the cycles of a range one by one; the buffers of a used task are reused.
pub fn sampled(
    study: &Study,
    seed: u64,
    mut cycles: Range<u64>,
) -> impl FnMut(Option<LaneTask>) -> Option<LaneTask> {
    let mut profile = SpeedProfile::default();
    move |used| {
        let cycle_id = cycles.next()?;
        Some(match used {
            Some(mut task) => {
                task.reuse(study, seed, cycle_id, &mut profile);
                task
            }
            None => LaneTask::new(study, study.sample(seed, cycle_id)),
        })
    }
}

/// Drives one given scenario.
pub fn drive_scenario(study: &Study, scenario: Scenario) -> Record {
    let mut task = Some(LaneTask::new(study, scenario));
    let records = drive_tasks(study, &mut |_| task.take(), CpuLevel::Baseline);
    records.into_iter().next().expect("one scenario gives one record")
}

/// The tasks of one block. A lane whose last cycle has ended is empty.
type LaneTasks = [Option<LaneTask>; WIDTH];

/// Gives tasks to lanes and collects their records.
struct LaneScheduler<'a, 'b, P, O> {
    study: &'a Study,
    parameters: &'a KernelParameters<'a, P>,
    next: Next<'b>,
    observer: &'a mut O,
    records: Vec<Record>,
    cut_short: Vec<Scenario>,
    /// Lanes with a cycle.
    driving: usize,
}

impl<P: Powertrain, O: Observer> SimdTask for LaneScheduler<'_, '_, P, O> {
    type Answer = Driven;

    /// The loop over one or two blocks, until `next` gives no more tasks; the records are in order
    /// of the cycle ids.
    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> Driven {
        let parameters = self.parameters;
        let mut front = State::parked(simd, parameters);
        let mut back = State::parked(simd, parameters);
        let mut front_tasks = self.fill(&mut front);
        let mut back_tasks = [const { None }; WIDTH];
        if interleaves_blocks(simd) {
            back_tasks = self.fill(&mut back);
        }
        while self.driving > 0 {
            if interleaves_blocks(simd) {
                let views = steps((&mut front, &mut back), parameters);
                self.after_step(&mut front, &mut front_tasks, &views.0);
                self.after_step(&mut back, &mut back_tasks, &views.1);
            } else {
                let view = front.step(parameters);
                self.after_step(&mut front, &mut front_tasks, &view);
            }
        }
        self.records.sort_by_key(|record| record.cycle_id);
        self.cut_short.sort_by_key(|scenario| scenario.cycle_id);
        Driven { records: self.records, cut_short: self.cut_short }
    }
}

impl<'a, 'b, P: Powertrain, O: Observer> LaneScheduler<'a, 'b, P, O> {
    fn new(
        study: &'a Study,
        parameters: &'a KernelParameters<'a, P>,
        next: Next<'b>,
        observer: &'a mut O,
    ) -> Self {
        let (records, cut_short) = (Vec::new(), Vec::new());
        Self { study, parameters, next, observer, records, cut_short, driving: 0 }
    }

    /// Puts a cycle into each lane of a block.
    fn fill<S: Simd>(&mut self, state: &mut State<S, P>) -> LaneTasks {
        let mut tasks: LaneTasks = [const { None }; WIDTH];
        for (number, place) in tasks.iter_mut().enumerate() {
            *place = (self.next)(None);
            if let Some(task) = place {
                task.enter(&mut Lane { state, number, parameters: self.parameters });
                self.driving += 1;
            }
        }
        tasks
    }

    /// Shows a step to the observer and handles the events of its lanes.
    #[inline(always)]
    fn after_step<S: Simd>(
        &mut self,
        state: &mut State<S, P>,
        tasks: &mut LaneTasks,
        view: &StepView<S>,
    ) {
        self.observer.after_step(self.parameters, state, view, tasks);
        if view.event.any_true() {
            self.handle_events(state, tasks, &view.events());
        }
    }

    /// Handles the events of a block's lanes.
    #[cold]
    #[inline(never)]
    fn handle_events<S: Simd>(
        &mut self,
        state: &mut State<S, P>,
        tasks: &mut LaneTasks,
        events: &LaneEvents,
    ) {
        if self.observer.is_stopped() {
            self.driving = 0;
            return;
        }
        let parameters = self.parameters;
        let mut lanes = events.lanes;
        while lanes != 0 {
            let number = lanes.trailing_zeros() as usize % WIDTH;
            lanes &= lanes - 1;
            let Some(task) = &mut tasks[number] else { continue };
            let mut lane = Lane { state, number, parameters };
            let outcome = task.handle_event(&mut lane, events.lane(number));
            if let Some(outcome) = outcome {
                self.records.push(task.record(self.study, &lane, outcome));
                if outcome == Outcome::Depleted {
                    self.cut_short.push(task.scenario().clone());
                }
            }
            self.observer.after_event(parameters, lane.state, (number, task));
            if outcome.is_some() {
                if let Some(task) = &mut tasks[number] {
                    task.leave(&mut lane);
                }
                tasks[number] = (self.next)(tasks[number].take());
                if let Some(task) = &mut tasks[number] {
                    task.enter(&mut lane);
                } else {
                    lane.park();
                    self.driving -= 1;
                }
            }
        }
    }
}

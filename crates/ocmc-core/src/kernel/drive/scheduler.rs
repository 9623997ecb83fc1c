//! Drives a range of cycles, eight or sixteen side by side: a lane takes the next cycle as soon as
//! its own has ended.

use super::cpu::{CpuLevel, SimdTask};
use super::observer::Observer;
use super::whole_trip::WholeTrips;
use crate::kernel::step::one_step::steps;
use crate::kernel::step::state::{KernelParameters, Lane, State};
use crate::kernel::step::step_view::{LaneEvents, StepView};
use crate::kernel::trip::lane_task::LaneTask;
use crate::lanes::{WIDTH, interleaves_blocks};
use crate::powertrain::{Powertrain, PowertrainTask};
use crate::record::Record;
use crate::study::{Scenario, Study};
use crate::tactical::SpeedProfile;
use crate::threads::deep;
use fearless_simd::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Gives the next task; takes back the used one, whose buffers are reused.
pub type Next<'a> = &'a mut dyn FnMut(Option<LaneTask>) -> Option<LaneTask>;

/// Takes the record of each cycle as soon as it is known, in no order.
pub type Deliver<'a> = &'a mut dyn FnMut(Record);

/// Looks at the record of a cycle that has ended.
pub type Arrived<'a> = &'a mut dyn FnMut(&Record);

/// Drives the cycles of a range; the records are in order of the ids.
pub fn drive(study: &Study, seed: u64, cycles: Range<u64>, level: CpuLevel) -> Vec<Record> {
    deep(|| drive_tasks(study, &mut sampled(study, seed, cycles), level))
}

/// Drives the tasks that `next` gives; the records are in order of the cycle ids.
pub fn drive_tasks(study: &Study, next: Next, level: CpuLevel) -> Vec<Record> {
    drive_until(study, next, level, &AtomicBool::new(false))
}

/// As [`drive_tasks`], until a flag is set; there are no records of cycles that were given up.
pub fn drive_until(study: &Study, next: Next, level: CpuLevel, stop: &AtomicBool) -> Vec<Record> {
    in_order(|deliver| Driving { study, level, stop, whole_trips: true }.each(next, deliver))
}

/// How the lanes of one thread drive.
#[derive(Clone, Copy, Debug)]
pub struct Driving<'a> {
    /// Study that is driven.
    pub study: &'a Study,
    /// Instructions to use.
    pub level: CpuLevel,
    /// Once it is set, the cycles on the road are given up.
    pub stop: &'a AtomicBool,
    /// Whether a trip that a battery cuts short is driven again as a whole.
    pub whole_trips: bool,
}

impl Driving<'_> {
    /// Drives the tasks that `next` gives: no lane waits for another. There are no records of
    /// cycles that were given up.
    pub fn each(self, next: Next, deliver: Deliver) {
        self.each_arriving(next, &mut |_| {}, deliver);
    }

    /// As [`Self::each`]; `arrived` is called when a cycle has ended, before its whole trip is
    /// driven and before there is a next one for its lane.
    pub fn each_arriving(self, next: Next, arrived: Arrived, deliver: Deliver) {
        let task = FleetTask { driving: self, next, arrived, deliver };
        self.study.vehicle().powertrain.dispatch(task);
    }
}

struct FleetTask<'a, 'b> {
    driving: Driving<'a>,
    next: Next<'b>,
    arrived: Arrived<'b>,
    deliver: Deliver<'b>,
}

impl PowertrainTask for FleetTask<'_, '_> {
    type Answer = ();

    fn run<P: Powertrain>(self, powertrain: &P) {
        let Self { driving, next, arrived, deliver } = self;
        let parameters = KernelParameters::new(driving.study, powertrain);
        let mut whole_trips = WholeTrips::new(driving, powertrain);
        let mut ended = |record: Record, scenario: &Scenario| {
            arrived(&record);
            whole_trips.take(record, scenario, deliver);
        };
        drive_lanes(driving, &parameters, next, &mut ended, Observer::Nobody);
        whole_trips.drive(deliver);
    }
}

/// As [`drive_tasks`], with an observer of every step: slower.
pub(super) fn drive_observed<P: Powertrain>(
    study: &Study,
    powertrain: &P,
    next: Next,
    observer: Observer,
) -> Vec<Record> {
    let parameters = KernelParameters::new(study, powertrain);
    let (level, stop) = (CpuLevel::best(), &AtomicBool::new(false));
    let driving = Driving { study, level, stop, whole_trips: true };
    let mut whole_trips = WholeTrips::new(driving, powertrain);
    in_order(|deliver| {
        let mut ended =
            |record: Record, scenario: &Scenario| whole_trips.take(record, scenario, deliver);
        drive_lanes(driving, &parameters, next, &mut ended, observer);
        whole_trips.drive(deliver);
    })
}

/// The records that are delivered, in order of the cycle ids.
fn in_order(drive: impl FnOnce(Deliver)) -> Vec<Record> {
    let mut records = Vec::new();
    drive(&mut |record| records.push(record));
    records.sort_by_key(|record| record.cycle_id);
    records
}

/// Gives cycles one by one; the buffers of a used task are reused.
pub fn sampled(
    study: &Study,
    seed: u64,
    mut cycles: impl Iterator<Item = u64>,
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
    let records = deep(|| drive_tasks(study, &mut |_| task.take(), CpuLevel::Baseline));
    records.into_iter().next().expect("one scenario gives one record")
}

/// The tasks of one block. A lane whose last cycle has ended is empty.
type LaneTasks = [Option<LaneTask>; WIDTH];

/// Action on a cycle that has ended.
pub(super) type Ended<'a> = &'a mut dyn FnMut(Record, &Scenario);

/// Drives the tasks that `next` gives, once each.
pub(super) fn drive_lanes<P: Powertrain>(
    Driving { study, level, stop, .. }: Driving,
    parameters: &KernelParameters<P>,
    next: Next,
    ended: Ended,
    observer: Observer,
) {
    level.run(LaneScheduler { study, parameters, next, ended, observer, stop, driving: 0 });
}

/// Gives tasks to lanes and passes their records on.
struct LaneScheduler<'a, 'b, P> {
    study: &'a Study,
    parameters: &'a KernelParameters<'a, P>,
    next: Next<'b>,
    ended: Ended<'a>,
    observer: Observer<'a>,
    /// Once it is set, the cycles on the road are given up.
    stop: &'a AtomicBool,
    /// Lanes with a cycle.
    driving: usize,
}

/// The first lane of the second block.
const BACK: usize = WIDTH;

impl<P: Powertrain> SimdTask for LaneScheduler<'_, '_, P> {
    type Answer = ();

    /// The loop over one or two blocks, until `next` gives no more tasks.
    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let parameters = self.parameters;
        let mut front = State::parked(simd, parameters);
        let mut back = State::parked(simd, parameters);
        let mut front_tasks = self.fill(0, &mut front);
        let mut back_tasks = [const { None }; WIDTH];
        if interleaves_blocks(simd) {
            back_tasks = self.fill(BACK, &mut back);
        }
        while self.driving > 0 {
            if interleaves_blocks(simd) {
                let views = steps((&mut front, &mut back), parameters);
                self.after_step(&mut front, (0, &mut front_tasks), &views.0);
                self.after_step(&mut back, (BACK, &mut back_tasks), &views.1);
            } else {
                let view = front.step(parameters);
                self.after_step(&mut front, (0, &mut front_tasks), &view);
            }
        }
    }
}

impl<P: Powertrain> LaneScheduler<'_, '_, P> {
    /// Puts a cycle into each lane of a block, whose lanes are counted from the first one.
    fn fill<S: Simd>(&mut self, first: usize, state: &mut State<S, P>) -> LaneTasks {
        let mut tasks: LaneTasks = [const { None }; WIDTH];
        for (number, place) in tasks.iter_mut().enumerate() {
            *place = (self.next)(None);
            if let Some(task) = place {
                self.enter(first, task, &mut Lane { state, number, parameters: self.parameters });
                self.driving += 1;
            }
        }
        self.observer.before_step(self.parameters, state, (first, &tasks));
        tasks
    }

    /// Puts a cycle into a lane.
    fn enter<S: Simd>(&mut self, first: usize, task: &mut LaneTask, lane: &mut Lane<S, P>) {
        task.enter(lane);
        self.observer.entered(first, task, lane);
    }

    /// Shows a step to the observer and handles the events of its lanes.
    #[inline(always)]
    fn after_step<S: Simd>(
        &mut self,
        state: &mut State<S, P>,
        tasks: (usize, &mut LaneTasks),
        view: &StepView<S>,
    ) {
        if !self.observer.is_nobody() {
            // of a copy: what nobody observes stays in registers
            let view = *view;
            self.observe(state, tasks, &view);
        } else if view.event.any_true() {
            self.handle_events(state, tasks, &view.events(), 0);
        }
    }

    /// Shows a step to the observer and handles the events of its lanes.
    #[cold]
    #[inline(never)]
    fn observe<S: Simd>(
        &mut self,
        state: &mut State<S, P>,
        (first, tasks): (usize, &mut LaneTasks),
        view: &StepView<S>,
    ) {
        let over = self.observer.after_step(self.parameters, state, view, (first, tasks));
        self.handle_events(state, (first, tasks), &view.events(), over);
        self.observer.before_step(self.parameters, state, (first, tasks));
    }

    /// Handles the events of a block's lanes. Those whose time is over are given the next cycle.
    #[cold]
    #[inline(never)]
    fn handle_events<S: Simd>(
        &mut self,
        state: &mut State<S, P>,
        (first, tasks): (usize, &mut LaneTasks),
        events: &LaneEvents,
        over: u64,
    ) {
        if self.stop.load(Ordering::Relaxed) {
            self.driving = 0;
            return;
        }
        let parameters = self.parameters;
        let mut lanes = events.lanes | over;
        while lanes != 0 {
            let number = lanes.trailing_zeros() as usize % WIDTH;
            lanes &= lanes - 1;
            let Some(task) = &mut tasks[number] else { continue };
            let mut lane = Lane { state, number, parameters };
            let mut has_ended = over >> number & 1 != 0;
            if !has_ended {
                let outcome = task.handle_event(&mut lane, events.lane(number));
                if let Some(outcome) = outcome {
                    (self.ended)(task.record(self.study, &lane, outcome), task.scenario());
                }
                self.observer.after_event(parameters, lane.state, (number, task));
                has_ended = outcome.is_some();
            }
            if has_ended {
                task.leave(&mut lane);
                tasks[number] = (self.next)(tasks[number].take());
                if let Some(task) = &mut tasks[number] {
                    self.enter(first, task, &mut lane);
                } else {
                    lane.park();
                    self.driving -= 1;
                }
            }
        }
    }
}

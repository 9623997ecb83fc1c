//! Drives a range of cycles, eight or sixteen side by side: a lane takes the next cycle as soon as its own has ended.

use super::battery_electric::BatteryElectric;
use super::cpu::CpuLevel;
use super::diesel::Diesel;
use super::lane_task::Cabin;
use super::powertrain::Traction;
use super::record::Record;
use super::state::{Shared, State};
use super::step::steps;
use super::step_view::{Sights, StepView};
use crate::lanes::{WIDTH, blocks_take_turns};
use crate::study::{Scenario, Study};
use crate::tactical::SpeedProfile;
use crate::vehicle::Drive;
#[cfg(not(target_arch = "x86_64"))]
use fearless_simd::dispatch;
use fearless_simd::{Level, prelude::*};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Sees every step of every lane; the fleet does not look, a trace does.
pub trait Watch {
    /// After a step, before anything is done about it.
    fn stepped<S: Simd>(
        &mut self,
        _state: &State<S>,
        _view: &StepView<S>,
        _cabins: &[Option<Cabin>],
    ) {
    }
    /// After a lane has been attended to.
    fn attended<S: Simd>(&mut self, _state: &State<S>, _lane: usize, _cabins: &[Option<Cabin>]) {}
    /// Whether enough was seen: cycles that are on the road are then given up.
    fn has_enough(&self) -> bool {
        false
    }
}

/// Looks at nothing but a flag: once it is raised, the cycles on the road are given up.
#[derive(Clone, Copy, Debug)]
pub struct Until<'a>(pub &'a AtomicBool);

impl Watch for Until<'_> {
    fn has_enough(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Hands out cabins; takes back the used one, to be furnished anew.
pub type Next<'a> = &'a mut dyn FnMut(Option<Cabin>) -> Option<Cabin>;

/// Drives the cycles of a range; the records are in order of the ids.
pub fn drive(study: &Study, seed: u64, cycles: Range<u64>, level: CpuLevel) -> Vec<Record> {
    drive_cabins(study, &mut sampled(study, seed, cycles), level)
}

/// Drives whatever `next` hands out; the records are in order of the cycle ids.
pub fn drive_cabins(study: &Study, next: Next, level: CpuLevel) -> Vec<Record> {
    drive_until(study, next, level, &AtomicBool::new(false))
}

/// As [`drive_cabins`], until a flag is raised; there are no records of cycles that were given up.
pub fn drive_until(study: &Study, next: Next, level: CpuLevel, stop: &AtomicBool) -> Vec<Record> {
    match &study.powertrain().drive {
        Drive::Diesel(drive) => {
            let traction = Diesel::new(drive, &study.powertrain().model);
            drive_on(level, study, &Shared::new(study, traction), next, stop)
        }
        Drive::BatteryElectric(drive) => {
            let traction = BatteryElectric::new(drive);
            drive_on(level, study, &Shared::new(study, traction), next, stop)
        }
    }
}

/// As [`drive_cabins`], with somebody who looks at every step: slower.
pub fn drive_watched<O: Watch>(study: &Study, next: Next, watch: &mut O) -> Vec<Record> {
    match &study.powertrain().drive {
        Drive::Diesel(drive) => {
            let traction = Diesel::new(drive, &study.powertrain().model);
            drive_baseline(study, &Shared::new(study, traction), next, watch)
        }
        Drive::BatteryElectric(drive) => {
            let traction = BatteryElectric::new(drive);
            drive_baseline(study, &Shared::new(study, traction), next, watch)
        }
    }
}

/// With the instructions of a level.
fn drive_on<T: Traction>(
    level: CpuLevel,
    study: &Study,
    shared: &Shared<T>,
    next: Next,
    stop: &AtomicBool,
) -> Vec<Record> {
    #[cfg(target_arch = "x86_64")]
    match level {
        CpuLevel::Avx512 => {
            if let Some(simd) = Level::new().as_avx512() {
                return simd.vectorize(
                    #[inline(always)]
                    || drive_blocks(simd, study, shared, next, &mut Until(stop)),
                );
            }
        }
        CpuLevel::Avx2 => {
            if let Some(simd) = Level::new().as_avx2() {
                return simd.vectorize(
                    #[inline(always)]
                    || drive_blocks(simd, study, shared, next, &mut Until(stop)),
                );
            }
        }
        CpuLevel::Baseline => {}
    }
    drive_baseline(study, shared, next, &mut Until(stop))
}

/// With the instructions that every CPU of the platform has. `dispatch!` would compile the loop for all the others, too.
fn drive_baseline<T: Traction, O: Watch>(
    study: &Study,
    shared: &Shared<T>,
    next: Next,
    watch: &mut O,
) -> Vec<Record> {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = Level::baseline().as_sse2() {
        return simd.vectorize(
            #[inline(always)]
            || drive_blocks(simd, study, shared, next, watch),
        );
    }
    #[cfg(target_arch = "x86_64")]
    unreachable!("x86-64 has SSE2");
    #[cfg(not(target_arch = "x86_64"))]
    dispatch!(Level::baseline(), simd => drive_blocks(simd, study, shared, next, watch))
}

/// Hands out the cycles of a range one by one; a used cabin is furnished anew.
pub fn sampled(
    study: &Study,
    seed: u64,
    mut cycles: Range<u64>,
) -> impl FnMut(Option<Cabin>) -> Option<Cabin> {
    let mut profile = SpeedProfile::default();
    move |used| {
        let cycle_id = cycles.next()?;
        Some(match used {
            Some(mut cabin) => {
                cabin.renew(study, seed, cycle_id, &mut profile);
                cabin
            }
            None => Cabin::new(study, study.sample(seed, cycle_id)),
        })
    }
}

/// Drives one given scenario.
pub fn drive_scenario(study: &Study, scenario: Scenario) -> Record {
    let mut cabin = Some(Cabin::new(study, scenario));
    let records = drive_cabins(study, &mut |_| cabin.take(), CpuLevel::Baseline);
    records.into_iter().next().expect("one scenario gives one record")
}

/// The loop over one or two blocks, until `next` gives no more cabins; the records are in order of the cycle ids.
///
/// Inlined into each of the functions above, so that it is compiled for their CPUs.
#[inline(always)]
fn drive_blocks<S: Simd, T: Traction, O: Watch>(
    simd: S,
    study: &Study,
    shared: &Shared<T>,
    next: Next,
    watch: &mut O,
) -> Vec<Record> {
    let mut desk = Desk { study, next, watch, records: Vec::new(), driving: 0 };
    let (mut front, mut back) = (State::parked(simd, shared), State::parked(simd, shared));
    let mut front_cabins = desk.fill(&mut front, shared);
    let mut back_cabins = [const { None }; WIDTH];
    if blocks_take_turns(simd) {
        back_cabins = desk.fill(&mut back, shared);
    }
    while desk.driving > 0 {
        if blocks_take_turns(simd) {
            let views = steps((&mut front, &mut back), shared);
            desk.look(&mut front, &mut front_cabins, &views.0, shared);
            desk.look(&mut back, &mut back_cabins, &views.1, shared);
        } else {
            let view = front.step(shared);
            desk.look(&mut front, &mut front_cabins, &view, shared);
        }
    }
    desk.records.sort_by_key(|record| record.cycle_id);
    desk.records
}

/// The cabins of one block. A lane whose last cycle has ended is empty.
type Cabins = [Option<Cabin>; WIDTH];

/// Where cycles are handed out and their records come in.
struct Desk<'a, 'b, O> {
    study: &'a Study,
    next: Next<'b>,
    watch: &'a mut O,
    records: Vec<Record>,
    /// Lanes with a cycle.
    driving: usize,
}

impl<O: Watch> Desk<'_, '_, O> {
    /// Puts a cycle into each lane of a block.
    fn fill<S: Simd, T: Traction>(&mut self, state: &mut State<S>, shared: &Shared<T>) -> Cabins {
        let mut cabins = [const { None }; WIDTH];
        for (lane, place) in cabins.iter_mut().enumerate() {
            *place = (self.next)(None);
            if let Some(cabin) = place {
                cabin.enter(state, lane, shared);
                self.driving += 1;
            }
        }
        cabins
    }

    /// Looks at a block after a step.
    #[inline(always)]
    fn look<S: Simd, T: Traction>(
        &mut self,
        state: &mut State<S>,
        cabins: &mut Cabins,
        view: &StepView<S>,
        shared: &Shared<T>,
    ) {
        self.watch.stepped(state, view, cabins);
        if view.alarm.any_true() {
            self.attend(state, cabins, &view.sights(), shared);
        }
    }

    /// Looks after the lanes that have raised an alarm.
    #[cold]
    #[inline(never)]
    fn attend<S: Simd, T: Traction>(
        &mut self,
        state: &mut State<S>,
        cabins: &mut Cabins,
        sights: &Sights,
        shared: &Shared<T>,
    ) {
        if self.watch.has_enough() {
            self.driving = 0;
            return;
        }
        let mut alarms = sights.alarm;
        while alarms != 0 {
            let lane = alarms.trailing_zeros() as usize % WIDTH;
            alarms &= alarms - 1;
            let Some(cabin) = &mut cabins[lane] else { continue };
            let outcome = cabin.attend(state, lane, sights.of(lane), shared);
            if let Some(outcome) = outcome {
                self.records.push(cabin.record(self.study, state, lane, outcome, shared));
            }
            self.watch.attended(state, lane, cabins);
            if outcome.is_some() {
                if let Some(cabin) = &mut cabins[lane] {
                    cabin.leave(state, lane);
                }
                cabins[lane] = (self.next)(cabins[lane].take());
                if let Some(cabin) = &mut cabins[lane] {
                    cabin.enter(state, lane, shared);
                } else {
                    state.park(lane);
                    self.driving -= 1;
                }
            }
        }
    }
}

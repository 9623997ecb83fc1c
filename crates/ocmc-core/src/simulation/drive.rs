//! Drives a range of cycles, `W` side by side: a lane takes the next cycle as soon as its own has ended.

use super::cabin::{Cabin, Sight};
use super::cpu::CpuLevel;
use super::record::Record;
use super::state::{Shared, State};
use super::step::StepView;
use crate::study::{Scenario, Study};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Sees every step of every lane; the fleet does not look, a trace does.
pub trait Watch<const W: usize> {
    /// After a step, before anything is done about it.
    fn stepped(&mut self, _state: &State<W>, _view: &StepView<W>, _cabins: &[Option<Cabin>]) {}
    /// After a lane has been attended to.
    fn attended(&mut self, _state: &State<W>, _lane: usize, _cabins: &[Option<Cabin>]) {}
    /// Whether enough was seen: cycles that are on the road are then given up.
    fn has_enough(&self) -> bool {
        false
    }
}

/// Looks away.
#[derive(Clone, Copy, Debug)]
pub struct Unwatched;

impl<const W: usize> Watch<W> for Unwatched {}

/// Looks at nothing but a flag: once it is raised, the cycles on the road are given up.
#[derive(Clone, Copy, Debug)]
pub struct Until<'a>(pub &'a AtomicBool);

impl<const W: usize> Watch<W> for Until<'_> {
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
    drive_watched(study, next, level, &mut Unwatched)
}

/// As [`drive_cabins`], with somebody who looks; there are no records of cycles that were given up.
pub fn drive_watched<O: Watch<8> + Watch<16>>(
    study: &Study,
    next: Next,
    level: CpuLevel,
    watch: &mut O,
) -> Vec<Record> {
    match level {
        #[cfg(target_arch = "x86_64")]
        CpuLevel::Avx512 if level.is_available() => {
            // SAFETY: the CPU has these instructions, as the guard has just asked.
            #[allow(unsafe_code, reason = "the one place where CPU features are chosen")]
            unsafe {
                drive_avx512(study, next, watch)
            }
        }
        #[cfg(target_arch = "x86_64")]
        CpuLevel::Avx2 if level.is_available() => {
            // SAFETY: the CPU has these instructions, as the guard has just asked.
            #[allow(unsafe_code, reason = "the one place where CPU features are chosen")]
            unsafe {
                drive_avx2(study, next, watch)
            }
        }
        _ => drive_lanes::<8, _>(study, next, watch),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2,bmi2,popcnt")]
fn drive_avx512(study: &Study, next: Next, watch: &mut impl Watch<16>) -> Vec<Record> {
    drive_lanes::<16, _>(study, next, watch)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi2,popcnt")]
fn drive_avx2(study: &Study, next: Next, watch: &mut impl Watch<8>) -> Vec<Record> {
    drive_lanes::<8, _>(study, next, watch)
}

/// Hands out the cycles of a range one by one; a used cabin is furnished anew.
pub fn sampled(
    study: &Study,
    seed: u64,
    mut cycles: Range<u64>,
) -> impl FnMut(Option<Cabin>) -> Option<Cabin> {
    move |used| {
        let cycle_id = cycles.next()?;
        Some(match used {
            Some(mut cabin) => {
                cabin.renew(study, seed, cycle_id);
                cabin
            }
            None => Cabin::new(study, study.sample(seed, cycle_id)),
        })
    }
}

/// Drives one given scenario.
pub fn drive_scenario(study: &Study, scenario: Scenario) -> Record {
    let mut cabin = Some(Cabin::new(study, scenario));
    let records = drive_lanes::<1, _>(study, &mut |_| cabin.take(), &mut Unwatched);
    records.into_iter().next().expect("one scenario gives one record")
}

/// The loop over `W` lanes, until `next` gives no more cabins; the records are in order of the cycle ids.
///
/// Inlined into each of the functions above, so that it is compiled for their CPUs.
#[inline(always)]
pub fn drive_lanes<const W: usize, O: Watch<W>>(
    study: &Study,
    next: Next,
    watch: &mut O,
) -> Vec<Record> {
    let shared = Shared::new(study);
    let mut state = State::<W>::parked(&shared);
    let mut records = Vec::new();
    // a lane whose last cycle has ended is empty
    let mut cabins: Vec<Option<Cabin>> = Vec::with_capacity(W);
    for lane in 0..W {
        let mut cabin = next(None);
        if let Some(cabin) = &mut cabin {
            cabin.enter(&mut state, lane, &shared);
        }
        cabins.push(cabin);
    }
    let mut driving = cabins.iter().flatten().count();
    while driving > 0 {
        let view = state.step(&shared);
        watch.stepped(&state, &view, &cabins);
        let mut alarms = view.alarm.bits();
        if alarms != 0 && watch.has_enough() {
            break;
        }
        while alarms != 0 {
            let lane = alarms.trailing_zeros() as usize % W;
            alarms &= alarms - 1;
            let Some(cabin) = &mut cabins[lane] else { continue };
            let sight = Sight {
                accelerator: view.accelerator.0[lane],
                wants_shift: view.wants_shift.0[lane] > 0.0,
                slowing: view.slowing.0[lane] > 0.0,
                closed: view.closed.0[lane] > 0.0,
                road_power_w: view.road_power.0[lane],
            };
            let outcome = cabin.attend(&mut state, lane, sight, &shared);
            if let Some(outcome) = outcome {
                records.push(cabin.record(study, &state, lane, outcome, &shared));
            }
            watch.attended(&state, lane, &cabins);
            if outcome.is_some() {
                cabins[lane] = next(cabins[lane].take());
                if let Some(cabin) = &mut cabins[lane] {
                    cabin.enter(&mut state, lane, &shared);
                } else {
                    state.park(lane);
                    driving -= 1;
                }
            }
        }
    }
    records.sort_by_key(|record| record.cycle_id);
    records
}

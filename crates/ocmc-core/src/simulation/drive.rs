//! Drives a range of cycles, `W` side by side: a lane takes the next cycle as soon as its own has ended.

use super::cabin::{Cabin, Sight};
use super::cpu::CpuLevel;
use super::record::Record;
use super::state::{Shared, State};
use super::step::StepView;
use crate::study::Study;
use std::ops::Range;

/// Sees every step of every lane; the fleet does not look, a trace does.
pub trait Watch<const W: usize> {
    /// After a step, before anything is done about it.
    fn stepped(&mut self, _state: &State<W>, _view: &StepView<W>, _cabins: &[Cabin]) {}
    /// After a lane has been attended to.
    fn attended(&mut self, _state: &State<W>, _lane: usize, _cabins: &[Cabin]) {}
}

/// Looks away.
#[derive(Clone, Copy, Debug)]
pub struct Unwatched;

impl<const W: usize> Watch<W> for Unwatched {}

/// Drives the cycles of a range; the records are in order of the ids.
pub fn drive(study: &Study, seed: u64, cycles: Range<u64>, level: CpuLevel) -> Vec<Record> {
    match level {
        #[cfg(target_arch = "x86_64")]
        CpuLevel::Avx512 if level.is_available() => {
            // SAFETY: the CPU has these instructions, as the guard has just asked.
            #[allow(unsafe_code, reason = "the one place where CPU features are chosen")]
            unsafe {
                drive_avx512(study, seed, cycles)
            }
        }
        #[cfg(target_arch = "x86_64")]
        CpuLevel::Avx2 if level.is_available() => {
            // SAFETY: the CPU has these instructions, as the guard has just asked.
            #[allow(unsafe_code, reason = "the one place where CPU features are chosen")]
            unsafe {
                drive_avx2(study, seed, cycles)
            }
        }
        _ => drive_lanes::<8, _>(study, seed, cycles, &mut Unwatched),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2,bmi2,popcnt")]
fn drive_avx512(study: &Study, seed: u64, cycles: Range<u64>) -> Vec<Record> {
    drive_lanes::<16, _>(study, seed, cycles, &mut Unwatched)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi2,popcnt")]
fn drive_avx2(study: &Study, seed: u64, cycles: Range<u64>) -> Vec<Record> {
    drive_lanes::<8, _>(study, seed, cycles, &mut Unwatched)
}

/// The loop over `W` lanes. Inlined into each of the functions above, so that it is compiled for their CPUs.
#[inline(always)]
pub fn drive_lanes<const W: usize, O: Watch<W>>(
    study: &Study,
    seed: u64,
    cycles: Range<u64>,
    watch: &mut O,
) -> Vec<Record> {
    let shared = Shared::new(study);
    let mut state = State::<W>::parked(&shared);
    let first = cycles.start;
    let mut waiting = cycles;
    let mut records: Vec<Option<Record>> = waiting.clone().map(|_| None).collect();
    let mut cabins: Vec<Cabin> = Vec::with_capacity(W);
    for lane in 0..W {
        if let Some(id) = waiting.next() {
            let mut cabin = Cabin::new(study, seed, id);
            cabin.enter(&mut state, lane, &shared);
            cabins.push(cabin);
        }
    }
    let mut driving = cabins.len();
    while driving > 0 {
        let view = state.step(&shared);
        watch.stepped(&state, &view, &cabins);
        if !view.alarm.any() {
            continue;
        }
        for lane in 0..cabins.len() {
            if view.alarm.0[lane] <= 0.0 {
                continue;
            }
            let sight = Sight {
                accelerator: view.accelerator.0[lane],
                wants_shift: view.wants_shift.0[lane] > 0.0,
                slowing: view.slowing.0[lane] > 0.0,
                closed: view.closed.0[lane] > 0.0,
                road_power_w: view.road_power.0[lane],
            };
            let cabin = &mut cabins[lane];
            if let Some(outcome) = cabin.attend(&mut state, lane, sight, &shared) {
                let record = cabin.record(study, &state, lane, outcome, &shared);
                let index = (record.cycle_id - first) as usize;
                records[index] = Some(record);
                if let Some(id) = waiting.next() {
                    cabin.renew(study, seed, id);
                    cabin.enter(&mut state, lane, &shared);
                } else {
                    state.park(lane);
                    driving -= 1;
                }
            }
            watch.attended(&state, lane, &cabins);
        }
    }
    records.into_iter().map(|record| record.expect("every cycle ends")).collect()
}

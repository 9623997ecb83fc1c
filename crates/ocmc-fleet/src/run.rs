//! Runs a range of cycles in parallel and hands the records over in the order of their ids.

use ocmc_core::kernel::drive::chain::{Draw, drive_chained};
use ocmc_core::kernel::drive::cpu::CpuLevel;
use ocmc_core::kernel::drive::scheduler::{Deliver, Driving, drive_tasks, sampled};
use ocmc_core::kernel::trip::lane_task::LaneTask;
use ocmc_core::random::PickFreeze;
use ocmc_core::record::Record;
use ocmc_core::study::Study;
use ocmc_core::tactical::SpeedProfile;
use ocmc_core::threads::{STACK_BYTES, deep};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::collections::BTreeMap;
use std::num::NonZero;
use std::ops::{ControlFlow, Range};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

/// Which cycles to run, and on what. Only `seed`, `first_cycle`, `cycles` and `pick_freeze` decide
/// the records.
#[derive(Clone, Copy, Debug)]
pub struct RunPlan {
    /// Master seed.
    pub seed: u64,
    /// Id of the first cycle.
    pub first_cycle: u64,
    /// Number of cycles.
    pub cycles: u64,
    /// Streams that the cycles take from the second sample.
    pub pick_freeze: PickFreeze,
    /// Threads, at least 1; [`each`] takes 0 as one for each processor.
    pub threads: usize,
    /// Consecutive cycles that one thread takes at a time, and that leave together.
    pub chunk: u64,
    /// Instructions to use.
    pub level: CpuLevel,
}

/// Longest time between two calls of a run's sink.
const LONGEST_SILENCE: Duration = Duration::from_millis(100);

/// Most threads that can be asked for.
pub const MOST_THREADS: usize = 1024;

impl RunPlan {
    /// A plan on the best instructions of this CPU: on all its threads and in chunks of
    /// [`chunk_for`], where nothing else is asked for.
    pub fn new(
        seed: u64,
        first_cycle: u64,
        cycles: u64,
        threads: Option<usize>,
        chunk: Option<u64>,
    ) -> Self {
        let available = || thread::available_parallelism().map_or(1, NonZero::get);
        let threads = threads.unwrap_or_else(available);
        let chunk = chunk.unwrap_or_else(|| chunk_for(cycles, threads)).min(cycles).max(1);
        // a thread without a chunk would only be started
        let with_work = cycles.div_ceil(chunk.max(LEAST_FOR_A_THREAD));
        let threads = threads.min(usize::try_from(with_work).unwrap_or(usize::MAX)).max(1);
        let pick_freeze = PickFreeze::NONE;
        Self { seed, first_cycle, cycles, pick_freeze, threads, chunk, level: CpuLevel::best() }
    }

    /// The plan with chunks of whole trucks: as many as fill the lanes, where there are enough for
    /// all threads.
    fn of_trucks(&self, study: &Study) -> Self {
        let trips = study.nesting().trips_per_truck;
        let trucks = self.cycles.div_ceil(trips).div_ceil(self.threads.max(1) as u64).max(1);
        // as many in each chunk, so that none is left to the end with a truck or two
        let side_by_side = trucks.div_ceil(trucks.div_ceil(TRUCKS_SIDE_BY_SIDE));
        Self { chunk: side_by_side * trips, ..*self }
    }
}

/// Trucks whose trips are driven side by side where they chain: those of two blocks of lanes.
const TRUCKS_SIDE_BY_SIDE: u64 = 32;

/// Cycles that a thread takes at most, where nothing else is asked for: it takes the next ones while
/// its lanes drive the last, so that few are left to one thread when the others have none.
pub const CHUNK: u64 = 128;

/// Cycles with which it is worth starting a thread: they fill its lanes.
const LEAST_FOR_A_THREAD: u64 = 16;

/// The chunk size for a run of that many cycles: a 256th of what each thread drives.
pub fn chunk_for(cycles: u64, threads: usize) -> u64 {
    cycles.div_ceil(256 * threads as u64).clamp(4, CHUNK)
}

/// Runs the plan. `sink` is called on this thread with the records of consecutive chunks, in order
/// of the cycle ids, while the next chunks are computed; and several times a second, with no
/// records where none have come. Breaking ends the run at once: cycles that are on the road are
/// given up.
///
/// The records do not depend on threads, chunks or level. The rayon pool is the run's own.
pub fn run<B>(
    study: &Study,
    plan: &RunPlan,
    sink: impl FnMut(Vec<Record>) -> ControlFlow<B>,
) -> ControlFlow<B> {
    if study.chains() {
        let RunPlan { seed, pick_freeze, level, .. } = *plan;
        let draw = Draw { seed, pick_freeze };
        let drive = |ranges: Ranges, stop: &AtomicBool, deliver: Deliver| {
            let driving = Driving { study, level, stop, whole_trips: true };
            ranges.for_each(|range| drive_chained(driving, draw, &range, deliver));
        };
        return run_with(&plan.of_trucks(study), &drive, sink);
    }
    let drive = |ranges: Ranges, stop: &AtomicBool, deliver: Deliver| {
        let driving = Driving { study, level: plan.level, stop, whole_trips: true };
        driving.each(&mut *tasks(study, plan, ranges.flatten()), deliver);
    };
    run_with(plan, &drive, sink)
}

/// A pool of threads that drive: one for each processor where the number is 0.
pub fn pool(threads: usize) -> ThreadPool {
    let pool = ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK_BYTES);
    pool.build().expect("the system can start threads")
}

/// Ranges of cycle ids that a thread drives, one after the other.
pub type Ranges<'a> = &'a mut dyn Iterator<Item = Range<u64>>;

/// As [`run`], with whatever `drive` makes of ranges of cycle ids: one record for each id, in any order.
/// It may give up, and then give fewer, once its flag is set.
pub fn run_with<B>(
    plan: &RunPlan,
    drive: &(dyn Fn(Ranges, &AtomicBool, Deliver) + Sync),
    mut sink: impl FnMut(Vec<Record>) -> ControlFlow<B>,
) -> ControlFlow<B> {
    let chunk = plan.chunk.max(1);
    let length_of = |k: u64| chunk.min(plan.cycles - k * chunk);
    let range_of = |k: u64| {
        let first = plan.first_cycle + k * chunk;
        first..first + length_of(k)
    };
    let chunks = plan.cycles.div_ceil(chunk);
    let next = AtomicU64::new(0);
    let stop = AtomicBool::new(false);
    let threads = plan.threads.max(1);
    let pool = pool(threads);
    // a slow sink holds the workers back, so that memory stays bounded
    let (sender, receiver) = mpsc::sync_channel::<(u64, Vec<Record>)>(2 * threads);
    pool.in_place_scope(|scope| {
        for _ in 0..threads {
            let sender = sender.clone();
            let (next, stop) = (&next, &stop);
            scope.spawn(move |_| {
                let mut ranges = std::iter::from_fn(|| {
                    let k = next.fetch_add(1, Ordering::Relaxed);
                    (k < chunks && !stop.load(Ordering::Relaxed)).then(|| range_of(k))
                });
                let mut begun = BTreeMap::<u64, Vec<Record>>::new();
                let mut deliver = |record: Record| {
                    let k = (record.cycle_id - plan.first_cycle) / chunk;
                    let records = begun.entry(k).or_default();
                    records.push(record);
                    if records.len() as u64 == length_of(k) {
                        let mut records = begun.remove(&k).expect("it is there");
                        records.sort_by_key(|record| record.cycle_id);
                        // whoever takes no more of them has set the flag
                        let _ = sender.send((k, records));
                    }
                };
                drive(&mut ranges, stop, &mut deliver);
            });
        }
        drop(sender);
        // moved in here: it has to be gone before the scope waits for workers that wait to send
        let receiver = receiver;
        let mut waiting = BTreeMap::new();
        let mut due = 0;
        loop {
            match receiver.recv_timeout(LONGEST_SILENCE) {
                Ok((k, records)) => {
                    waiting.insert(k, records);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return ControlFlow::Continue(()),
            }
            let mut ended = ControlFlow::Continue(());
            if !waiting.contains_key(&due) {
                ended = sink(Vec::new());
            }
            while ended.is_continue()
                && let Some(records) = waiting.remove(&due)
            {
                due += 1;
                ended = sink(records);
            }
            if ended.is_break() {
                stop.store(true, Ordering::Relaxed);
                return ended;
            }
        }
    })
}

/// What `of` makes of each cycle of a plan, by its id and in order of the ids; it does not depend on
/// the threads. `progress` receives the number of cycles done, several times a second; breaking
/// ends the work, and sets the flag on which `of` may give up.
pub fn each<T: Send, B>(
    plan: &RunPlan,
    of: &(dyn Fn(u64, &AtomicBool) -> T + Sync),
    mut progress: impl FnMut(u64) -> ControlFlow<B>,
) -> ControlFlow<B, Vec<T>> {
    let ids = plan.first_cycle..plan.first_cycle + plan.cycles;
    let (done, stop) = (AtomicU64::new(0), AtomicBool::new(false));
    let one = |id: u64| {
        let found = (!stop.load(Ordering::Relaxed)).then(|| of(id, &stop));
        done.fetch_add(1, Ordering::Relaxed);
        found
    };
    let (sender, receiver) = mpsc::channel();
    pool(plan.threads).in_place_scope(|scope| {
        scope.spawn(|_| {
            let all: Option<Vec<T>> = ids.into_par_iter().map(one).collect();
            // whoever waits no longer has set the flag
            let _ = sender.send(all);
        });
        loop {
            let all = receiver.recv_timeout(LONGEST_SILENCE).ok().flatten();
            let ended = progress(done.load(Ordering::Relaxed));
            if ended.is_break() {
                stop.store(true, Ordering::Relaxed);
            }
            match (ended, all) {
                (ControlFlow::Break(end), _) => return ControlFlow::Break(end),
                (_, Some(all)) => return ControlFlow::Continue(all),
                _ => {}
            }
        }
    })
}

/// All records of a plan. `progress` receives the number of cycles driven so far, several times a
/// second; breaking ends the run.
pub fn records<B>(
    study: &Study,
    plan: &RunPlan,
    mut progress: impl FnMut(u64) -> ControlFlow<B>,
) -> ControlFlow<B, Vec<Record>> {
    let mut all = Vec::new();
    run(study, plan, |records| {
        all.extend(records);
        progress(all.len() as u64)
    })?;
    ControlFlow::Continue(all)
}

/// Hands out cycles of the plan.
fn tasks<'a>(
    study: &'a Study,
    plan: &'a RunPlan,
    mut cycles: impl Iterator<Item = u64> + 'a,
) -> Box<dyn FnMut(Option<LaneTask>) -> Option<LaneTask> + 'a> {
    if plan.pick_freeze == PickFreeze::NONE {
        return Box::new(sampled(study, plan.seed, cycles));
    }
    let mut profile = SpeedProfile::default();
    Box::new(move |used| {
        let cycle_id = cycles.next()?;
        let scenario = study.sample_pick_freeze(plan.seed, cycle_id, plan.pick_freeze);
        Some(LaneTask::of(study, scenario, used, &mut profile))
    })
}

/// Drives single cycles again, in the order of their ids.
pub fn replay(study: &Study, seed: u64, cycle_ids: &[u64]) -> Vec<Record> {
    deep(|| again(study, seed, cycle_ids))
}

fn again(study: &Study, seed: u64, cycle_ids: &[u64]) -> Vec<Record> {
    if study.chains() {
        let (draw, level) = (Draw { seed, pick_freeze: PickFreeze::NONE }, CpuLevel::best());
        let stop = &AtomicBool::new(false);
        let driving = Driving { study, level, stop, whole_trips: true };
        let mut records = Vec::new();
        for &id in cycle_ids {
            drive_chained(driving, draw, &(id..id + 1), &mut |record| records.push(record));
        }
        return records;
    }
    let mut ids = cycle_ids.iter();
    let mut next = |_| ids.next().map(|id| LaneTask::new(study, study.sample(seed, *id)));
    drive_tasks(study, &mut next, CpuLevel::best())
}

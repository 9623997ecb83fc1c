//! Runs a range of cycles in parallel and hands the records over in the order of their ids.

use ocmc_core::kernel::drive::chain::{Draw, drive_chained};
use ocmc_core::kernel::drive::cpu::CpuLevel;
use ocmc_core::kernel::drive::scheduler::{Deliver, Driving, drive_tasks, sampled};
use ocmc_core::kernel::trip::lane_task::LaneTask;
use ocmc_core::random::PickFreeze;
use ocmc_core::record::Record;
use ocmc_core::study::Study;
use ocmc_core::tactical::SpeedProfile;
use ocmc_core::threads::{CAN_START, STACK_BYTES, deep};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::collections::BTreeMap;
use std::num::NonZero;
use std::ops::{ControlFlow, Range};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

/// Cycles to run, and the threads and streams. Only `seed`, `first_cycle`, `cycles` and
/// `pick_freeze` decide the records.
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

/// Cycles that a thread takes at most, where nothing else is asked for: it takes the next ones
/// while its lanes drive the last, so that few are left to one thread when the others have none.
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

/// As [`run`], with whatever `drive` makes of ranges of cycle ids: one record for each id, in any
/// order. It may give up, and then give fewer, once its flag is set.
pub fn run_with<B>(
    plan: &RunPlan,
    drive: &(dyn Fn(Ranges, &AtomicBool, Deliver) + Sync),
    sink: impl FnMut(Vec<Record>) -> ControlFlow<B>,
) -> ControlFlow<B> {
    let plan = RunPlan { chunk: plan.chunk.max(1), threads: plan.threads.max(1), ..*plan };
    if CAN_START { on_threads(&plan, drive, sink) } else { on_this_thread(&plan, drive, sink) }
}

fn on_threads<B>(
    plan: &RunPlan,
    drive: &(dyn Fn(Ranges, &AtomicBool, Deliver) + Sync),
    mut sink: impl FnMut(Vec<Record>) -> ControlFlow<B>,
) -> ControlFlow<B> {
    let next = AtomicU64::new(0);
    let stop = AtomicBool::new(false);
    let pool = pool(plan.threads);
    // a slow sink holds the workers back, so that memory stays bounded
    let (sender, receiver) = mpsc::sync_channel::<(u64, Vec<Record>)>(2 * plan.threads);
    pool.in_place_scope(|scope| {
        for _ in 0..plan.threads {
            let sender = sender.clone();
            let (next, stop) = (&next, &stop);
            scope.spawn(move |_| {
                let mut ranges = std::iter::from_fn(|| {
                    let k = next.fetch_add(1, Ordering::Relaxed);
                    plan.range_of(k).filter(|_| !stop.load(Ordering::Relaxed))
                });
                let mut begun = Begun { plan, chunks: BTreeMap::new() };
                let mut deliver = |record: Record| {
                    if let Some(whole) = begun.with(record) {
                        // whoever takes no more of them has set the flag
                        let _ = sender.send(whole);
                    }
                };
                drive(&mut ranges, stop, &mut deliver);
            });
        }
        drop(sender);
        // moved in here: it has to be gone before the scope waits for workers that wait to send
        let receiver = receiver;
        let mut waiting = Waiting::default();
        loop {
            match receiver.recv_timeout(LONGEST_SILENCE) {
                Ok((k, records)) => {
                    waiting.chunks.insert(k, records);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return ControlFlow::Continue(()),
            }
            let ended = waiting.give(&mut sink);
            if ended.is_break() {
                stop.store(true, Ordering::Relaxed);
                return ended;
            }
        }
    })
}

/// As [`run_with`] where no thread can be started: `sink` is called in between.
fn on_this_thread<B>(
    plan: &RunPlan,
    drive: &(dyn Fn(Ranges, &AtomicBool, Deliver) + Sync),
    mut sink: impl FnMut(Vec<Record>) -> ControlFlow<B>,
) -> ControlFlow<B> {
    let stop = AtomicBool::new(false);
    let mut ranges =
        (0..).map_while(|k| plan.range_of(k)).take_while(|_| !stop.load(Ordering::Relaxed));
    let mut begun = Begun { plan, chunks: BTreeMap::new() };
    let mut waiting = Waiting::default();
    let mut ended = ControlFlow::Continue(());
    let mut spoken = Instant::now();
    let mut deliver = |record: Record| {
        let whole = begun.with(record);
        if ended.is_break() || whole.is_none() && spoken.elapsed() < LONGEST_SILENCE {
            return;
        }
        waiting.chunks.extend(whole);
        ended = waiting.give(&mut sink);
        stop.store(ended.is_break(), Ordering::Relaxed);
        spoken = Instant::now();
    };
    drive(&mut ranges, &stop, &mut deliver);
    ended
}

impl RunPlan {
    /// Cycles of the `k`-th chunk, where there is one.
    fn range_of(&self, k: u64) -> Option<Range<u64>> {
        let begin = k.checked_mul(self.chunk).filter(|begin| *begin < self.cycles)?;
        let end = self.cycles.min(begin.saturating_add(self.chunk));
        Some(self.first_cycle + begin..self.first_cycle + end)
    }
}

/// Chunks of which a thread has driven some cycles.
struct Begun<'a> {
    plan: &'a RunPlan,
    chunks: BTreeMap<u64, Vec<Record>>,
}

impl Begun<'_> {
    /// Adds a record; the chunk and its number, where that was the last one of it.
    fn with(&mut self, record: Record) -> Option<(u64, Vec<Record>)> {
        let k = (record.cycle_id - self.plan.first_cycle) / self.plan.chunk;
        let records = self.chunks.entry(k).or_default();
        records.push(record);
        let length = self.plan.range_of(k).map_or(0, |range| range.end - range.start);
        (records.len() as u64 == length).then(|| {
            let mut records = self.chunks.remove(&k).expect("it is there");
            records.sort_by_key(|record| record.cycle_id);
            (k, records)
        })
    }
}

/// Chunks that wait for those before them.
#[derive(Default)]
struct Waiting {
    chunks: BTreeMap<u64, Vec<Record>>,
    due: u64,
}

impl Waiting {
    /// Gives the sink all chunks whose turn it is, or no records where none is there.
    fn give<B>(&mut self, sink: &mut impl FnMut(Vec<Record>) -> ControlFlow<B>) -> ControlFlow<B> {
        if !self.chunks.contains_key(&self.due) {
            return sink(Vec::new());
        }
        while let Some(records) = self.chunks.remove(&self.due) {
            self.due += 1;
            sink(records)?;
        }
        ControlFlow::Continue(())
    }
}

/// Results of `result_of` for each cycle of a plan, by its id and in order of the ids; it does not
/// depend on the threads. `progress` receives the number of cycles done, several times a second;
/// breaking ends the work, and sets the flag on which `result_of` may give up.
pub fn each<T: Send, B>(
    plan: &RunPlan,
    result_of: &(dyn Fn(u64, &AtomicBool) -> T + Sync),
    mut progress: impl FnMut(u64) -> ControlFlow<B>,
) -> ControlFlow<B, Vec<T>> {
    let ids = plan.first_cycle..plan.first_cycle + plan.cycles;
    let (done, stop) = (AtomicU64::new(0), AtomicBool::new(false));
    let one = |id: u64| {
        let answer = (!stop.load(Ordering::Relaxed)).then(|| result_of(id, &stop));
        done.fetch_add(1, Ordering::Relaxed);
        answer
    };
    if !CAN_START {
        let mut all = Vec::new();
        let mut spoken = Instant::now();
        for id in ids {
            all.extend(one(id));
            if spoken.elapsed() >= LONGEST_SILENCE {
                progress(all.len() as u64)?;
                spoken = Instant::now();
            }
        }
        progress(all.len() as u64)?;
        return ControlFlow::Continue(all);
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::swap;

    /// Records that come in pairs, the second one of each first.
    fn swapped(ranges: Ranges, stop: &AtomicBool, deliver: Deliver) {
        let mut ids = ranges.flatten().map(|cycle_id| Record { cycle_id, ..Record::default() });
        while let Some(mut first) = ids.next().filter(|_| !stop.load(Ordering::Relaxed)) {
            if let Some(mut second) = ids.next() {
                swap(&mut first, &mut second);
                deliver(second);
            }
            deliver(first);
        }
    }

    #[test]
    fn one_thread_gives_what_threads_give() {
        for (cycles, chunk) in [(1, 1), (7, 3), (40, 4), (41, 100)] {
            let plan = RunPlan::new(1, 5, cycles, Some(2), Some(chunk));
            let (mut there, mut here) = (Vec::new(), Vec::new());
            let of_threads = on_threads(&plan, &swapped, |records| {
                there.extend(records.iter().map(|record| record.cycle_id));
                ControlFlow::<()>::Continue(())
            });
            let of_one = on_this_thread(&plan, &swapped, |records| {
                here.extend(records.iter().map(|record| record.cycle_id));
                ControlFlow::<()>::Continue(())
            });
            assert!(of_threads.is_continue() && of_one.is_continue());
            assert_eq!(here, (5..5 + cycles).collect::<Vec<_>>());
            assert_eq!(here, there);
        }
    }

    #[test]
    fn one_thread_ends_where_the_sink_breaks() {
        let plan = RunPlan::new(1, 0, 1_000_000, Some(1), Some(10));
        let mut taken = 0;
        let ended = on_this_thread(&plan, &swapped, |records| {
            taken += records.len();
            if taken >= 30 { ControlFlow::Break("enough") } else { ControlFlow::Continue(()) }
        });
        assert_eq!((ended, taken), (ControlFlow::Break("enough"), 30));
    }
}

//! Work that is watched.

use crate::error::Error;
use ocmc_core::threads::CAN_START;
use std::ops::ControlFlow;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

pub use crate::progress::{Progress, Watch, go_on};

/// Longest time between two looks.
const INTERVAL: Duration = Duration::from_millis(100);

impl Progress {
    /// So many logs of all are read.
    pub(crate) fn of_logs(done: usize, total: usize) -> Self {
        Self { what: "logs", done: done as u64, total: total as u64 }
    }

    /// Asks whether to go on.
    pub(crate) fn look(self, watch: &mut Watch) -> Result<(), Error> {
        self.ended(watch(self))
    }

    /// Result of work that may have been ended here.
    pub(crate) fn ended<T>(self, ended: ControlFlow<(), T>) -> Result<T, Error> {
        match ended {
            ControlFlow::Continue(answer) => Ok(answer),
            ControlFlow::Break(()) => Err(Error::Interrupted(self)),
        }
    }
}

/// Does work that counts the cycles that are done, and asks at each count whether to go on.
pub(crate) fn watched<T>(
    total: u64,
    watch: &mut Watch,
    work: impl FnOnce(&mut dyn FnMut(u64) -> ControlFlow<()>) -> ControlFlow<(), T>,
) -> Result<T, Error> {
    let mut progress = Progress { what: "cycles", done: 0, total };
    let mut look = |done| {
        progress.done = done;
        watch(progress)
    };
    let ended = if look(0).is_continue() { work(&mut look) } else { ControlFlow::Break(()) };
    progress.ended(ended)
}

/// Does work on another thread that says what is done and ends soon once its flag is set, and
/// watches it from this one; on this one where no thread can be started.
pub(crate) fn aside<T: Send>(
    start: Progress,
    watch: &mut Watch,
    work: impl FnOnce(&AtomicBool, &mut dyn FnMut(usize)) -> T + Send,
) -> Result<T, Error> {
    let (done, stop) = (&AtomicU64::new(start.done), &AtomicBool::new(false));
    let mut progress = start;
    let mut ended = watch(progress);
    if ended.is_break() {
        return Err(Error::Interrupted(progress));
    }
    if !CAN_START {
        let mut look = |count| {
            progress.done = count as u64;
            if ended.is_continue() {
                ended = watch(progress);
            }
            stop.store(ended.is_break(), Ordering::Relaxed);
        };
        let answer = work(stop, &mut look);
        return progress.ended(ended.map_continue(|()| answer));
    }
    let answer = thread::scope(|scope| {
        let (under_way, over) = mpsc::channel::<()>();
        let worker = scope.spawn(move || {
            let answer = work(stop, &mut |count| done.store(count as u64, Ordering::Relaxed));
            drop(under_way);
            answer
        });
        while over.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
            progress.done = done.load(Ordering::Relaxed);
            if ended.is_continue() {
                ended = watch(progress);
            }
            stop.store(ended.is_break(), Ordering::Relaxed);
        }
        worker.join().unwrap_or_else(|panic| resume_unwind(panic))
    });
    progress.ended(ended.map_continue(|()| answer))
}

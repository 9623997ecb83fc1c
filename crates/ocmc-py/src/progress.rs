//! Looks after what takes its time, from Python's side: Ctrl-C and a progress bar, some times a second.

use pyo3::prelude::*;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

/// Time between two looks.
const INTERVAL: Duration = Duration::from_millis(100);

/// What looks after something.
pub(crate) struct Watch {
    /// What ``ocmc._progress.progress`` made of the user's wish; none for what has no bar.
    progress: Option<Py<PyAny>>,
    looked: Instant,
}

impl Watch {
    /// Begins to watch a run of that many cycles. `progress` is what the user asked for.
    pub(crate) fn new(py: Python, progress: Option<&Bound<PyAny>>, cycles: u64) -> PyResult<Self> {
        Self::of(py, progress, cycles, "cycles")
    }

    /// As [`Watch::new`], of that many of something.
    fn of(py: Python, progress: Option<&Bound<PyAny>>, total: u64, what: &str) -> PyResult<Self> {
        let module = py.import("ocmc._progress")?;
        let progress = module.call_method1("progress", (progress, total, what))?.unbind();
        Ok(Self { progress: Some(progress), looked: Instant::now() })
    }

    /// Watches for Ctrl-C alone.
    pub(crate) fn without_bar() -> Self {
        Self { progress: None, looked: Instant::now() }
    }

    /// Called without the interpreter, as often as one likes.
    ///
    /// # Errors
    /// ``KeyboardInterrupt`` after Ctrl-C, and what a callback of the user raises.
    pub(crate) fn look(&mut self, done: u64) -> PyResult<()> {
        if self.looked.elapsed() < INTERVAL {
            return Ok(());
        }
        self.looked = Instant::now();
        Python::attach(|py| {
            py.check_signals()?;
            match &self.progress {
                Some(progress) => progress.call_method1(py, "reach", (done,)).map(drop),
                None => Ok(()),
            }
        })
    }

    /// Ends the bar: `done` is all cycles where the run was not interrupted.
    pub(crate) fn finish(self, py: Python, done: u64) -> PyResult<()> {
        match self.progress {
            Some(progress) => progress.call_method1(py, "finish", (done,)).map(drop),
            None => Ok(()),
        }
    }
}

/// How far some work is, and whether it is to end.
#[derive(Default)]
pub(crate) struct Work {
    pub(crate) done: AtomicU64,
    pub(crate) stop: AtomicBool,
}

/// Does `work` on another thread and without the interpreter, while this thread looks after it. `what` is what the bar counts.
///
/// # Errors
/// As [`Watch::look`].
pub(crate) fn watched<T: Send>(
    py: Python,
    progress: Option<&Bound<PyAny>>,
    total: u64,
    what: &str,
    work: impl FnOnce(&Work) -> T + Send,
) -> PyResult<T> {
    let mut watch = Watch::of(py, progress, total, what)?;
    let state = &Work::default();
    let (answer, interrupt) = py.detach(|| {
        thread::scope(|scope| {
            let (under_way, ended) = mpsc::channel::<()>();
            let worker = scope.spawn(move || {
                let answer = work(state);
                drop(under_way);
                answer
            });
            let mut interrupt = None;
            while ended.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
                if interrupt.is_none()
                    && let Err(raised) = watch.look(state.done.load(Ordering::Relaxed))
                {
                    state.stop.store(true, Ordering::Relaxed);
                    interrupt = Some(raised);
                }
            }
            (worker.join().unwrap_or_else(|panic| resume_unwind(panic)), interrupt)
        })
    });
    let finished = watch.finish(py, state.done.load(Ordering::Relaxed));
    match interrupt {
        Some(raised) => Err(raised),
        None => finished.map(|()| answer),
    }
}

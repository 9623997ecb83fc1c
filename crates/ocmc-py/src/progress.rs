//! Looks after a run from Python's side: Ctrl-C and a progress bar, some times a second.

use pyo3::prelude::*;
use std::time::{Duration, Instant};

/// Time between two looks.
const INTERVAL: Duration = Duration::from_millis(100);

/// What a run is watched by.
pub(crate) struct Watch {
    /// What ``ocmc._progress.progress`` made of the user's wish.
    progress: Py<PyAny>,
    looked: Instant,
}

impl Watch {
    /// Begins to watch a run of that many cycles. `progress` is what the user asked for.
    pub(crate) fn new(py: Python, progress: Option<&Bound<PyAny>>, cycles: u64) -> PyResult<Self> {
        let module = py.import("ocmc._progress")?;
        let progress = module.call_method1("progress", (progress, cycles))?.unbind();
        Ok(Self { progress, looked: Instant::now() })
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
            self.progress.call_method1(py, "reach", (done,)).map(drop)
        })
    }

    /// Ends the bar: `done` is all cycles where the run was not interrupted.
    pub(crate) fn finish(self, py: Python, done: u64) -> PyResult<()> {
        self.progress.call_method1(py, "finish", (done,)).map(drop)
    }
}

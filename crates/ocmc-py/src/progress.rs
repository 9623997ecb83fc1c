//! Looks after what takes its time, from Python's side: Ctrl-C and a progress bar, some times a
//! second.

use crate::answer::warn;
use crate::error::exception;
use ocmc_api::{Error, Progress};
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Time between two looks.
const INTERVAL: Duration = Duration::from_millis(100);

/// Observer of work.
struct Watch {
    /// Argument of the user.
    asked: Option<Py<PyAny>>,
    /// Bar that ``ocmc._progress.progress`` made of it.
    bar: Option<Py<PyAny>>,
    progress: Progress,
    looked: Instant,
    /// ``KeyboardInterrupt`` after Ctrl-C, or what a callback of the user raised.
    raised: Option<PyErr>,
}

impl Watch {
    /// Called without the interpreter, as often as one likes.
    fn look(&mut self, progress: Progress) -> ControlFlow<()> {
        self.progress = progress;
        let begins = self.bar.is_none() && progress.what != "logs";
        if !begins && self.looked.elapsed() < INTERVAL {
            return ControlFlow::Continue(());
        }
        self.looked = Instant::now();
        let looked = Python::attach(|py| {
            if begins {
                let asked = (&self.asked, progress.total, progress.what);
                let bar = py.import("ocmc._progress")?.call_method1("progress", asked)?;
                self.bar = Some(bar.unbind());
                return Ok(());
            }
            py.check_signals()?;
            match &self.bar {
                Some(bar) => bar.call_method1(py, "reach", (progress.done,)).map(drop),
                None => Ok(()),
            }
        });
        self.raised = looked.err();
        if self.raised.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Asks a question without the interpreter but for a look at its signals and the progress bar.
///
/// # Errors
/// ``KeyboardInterrupt`` after Ctrl-C, what a callback of the user raises, and what the answer
/// says.
pub(crate) fn watched<T: Send>(
    py: Python,
    progress: Option<&Bound<PyAny>>,
    ask: impl FnOnce(&mut ocmc_api::Watch) -> Result<T, Error> + Send,
) -> PyResult<T> {
    let mut watch = Watch {
        asked: progress.map(|asked| asked.clone().unbind()),
        bar: None,
        progress: Progress { what: "logs", done: 0, total: 0 },
        looked: Instant::now(),
        raised: None,
    };
    let answer = py.detach(|| ask(&mut |progress| watch.look(progress)));
    let Watch { bar, progress: Progress { done, total, .. }, raised, .. } = watch;
    let done = if raised.is_none() && answer.is_ok() { total } else { done };
    let finished = bar.map_or(Ok(()), |bar| bar.call_method1(py, "finish", (done,)).map(drop));
    if let Some(raised) = raised {
        return Err(raised);
    }
    let answer = answer.map_err(exception)?;
    finished.map(|()| answer)
}

/// Says something on standard error where a progress bar would be shown.
pub(crate) fn note(py: Python, progress: Option<&Bound<PyAny>>, text: &str) -> PyResult<()> {
    py.import("ocmc._progress")?.call_method1("note", (progress, text)).map(drop)
}

/// As [`watched`], of a question that warns: its warnings are passed on where it has an answer.
pub(crate) fn warned<T: Send>(
    py: Python,
    progress: Option<&Bound<PyAny>>,
    ask: impl FnOnce(&mut dyn FnMut(&str), &mut ocmc_api::Watch) -> Result<T, Error> + Send,
) -> PyResult<T> {
    let mut warnings = Vec::new();
    let answer = watched(py, progress, |watch| {
        ask(&mut |text: &str| warnings.push(text.to_owned()), watch)
    })?;
    warnings.iter().try_for_each(|warning| warn(py, warning))?;
    Ok(answer)
}

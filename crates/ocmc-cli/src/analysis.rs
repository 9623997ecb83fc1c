//! What the analyses of a fleet share: a progress bar over all of their cycles, Ctrl-C, and the time that they took.

use crate::arguments::AnalysisArguments;
use crate::failure::Failure;
use crate::interrupt;
use crate::number_text::{rough, short};
use crate::progress::Progress;
use std::cell::Cell;
use std::ops::ControlFlow;
use std::time::Instant;

/// An analysis that is under way.
pub(crate) struct Analysis {
    cycles: u64,
    driven: Cell<u64>,
    progress: Progress,
    clock: Instant,
}

/// The user has asked to stop.
pub(crate) struct Interrupted;

impl Analysis {
    /// Begins an analysis that drives so many cycles.
    pub(crate) fn begin(cycles: u64, arguments: &AnalysisArguments) -> Self {
        interrupt::listen();
        Self {
            cycles,
            driven: Cell::new(0),
            progress: Progress::new(cycles, 0, arguments.quiet),
            clock: Instant::now(),
        }
    }

    /// So many cycles have been driven: goes on, or stops where the user has asked to.
    pub(crate) fn reach(&self, cycles: u64) -> ControlFlow<Interrupted> {
        self.driven.set(cycles);
        self.progress.reach(cycles);
        if interrupt::asked() && cycles < self.cycles {
            return ControlFlow::Break(Interrupted);
        }
        ControlFlow::Continue(())
    }

    /// The answer, and the seconds that it took.
    pub(crate) fn end<T>(self, answer: ControlFlow<Interrupted, T>) -> Result<(T, f64), Failure> {
        self.progress.finish();
        match answer {
            ControlFlow::Continue(answer) => Ok((answer, self.clock.elapsed().as_secs_f64())),
            ControlFlow::Break(Interrupted) => Err(Failure::Interrupted {
                finished: format!("{} of {} cycles finished", self.driven.get(), self.cycles),
                help: "there is no answer without the rest; fewer --cycles take less time"
                    .to_owned(),
            }),
        }
    }

    /// The line of the answer about its cost.
    pub(crate) fn took(wall_s: f64, threads: usize, cycles: u64) -> String {
        let rate = rough(cycles as f64 / wall_s);
        let threads =
            if threads == 1 { "1 thread".to_owned() } else { format!("{threads} threads") };
        format!("{:<10} {} s on {threads}: {rate} cycles/s\n", "took", short(wall_s))
    }
}

//! The progress bar of a run: on a terminal, with rate and time left; nothing elsewhere.

use crate::number_text::rough;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::fmt::Write;
use std::time::Duration;

/// A progress bar over cycles.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// Begins a bar over `cycles`, of which `done` are there already; `quiet` draws none.
    pub(crate) fn new(cycles: u64, done: u64, quiet: bool) -> Self {
        Self::over("cycles", cycles, done, quiet)
    }

    /// As [`Progress::new`], over something else than cycles.
    pub(crate) fn over(what: &str, all: u64, done: u64, quiet: bool) -> Self {
        let target =
            if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(all), target);
        let style = ProgressStyle::with_template(&format!(
            "{{wide_bar}} {{human_pos}} of {{human_len}} {what}, {{rate}}/s, {{eta}} left"
        ));
        if let Ok(style) = style {
            // without the decimals of indicatif's own rate
            bar.set_style(style.with_key("rate", |state: &ProgressState, out: &mut dyn Write| {
                let _ = write!(out, "{}", rough(state.per_sec()));
            }));
        }
        bar.set_position(done);
        bar.reset_eta();
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(bar)
    }

    /// Goes on to that number of cycles.
    pub(crate) fn reach(&self, cycles: u64) {
        self.0.set_position(cycles);
    }

    /// Removes the bar.
    pub(crate) fn finish(self) {
        self.0.finish_and_clear();
    }
}

//! Watches what takes its time: a progress bar on a terminal, with rate and time left, and Ctrl-C.

use crate::interrupt::{self, Patience};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use ocmc_api::number_text::rough;
use ocmc_api::{Error, Progress, Watch};
use std::fmt::Write;
use std::ops::ControlFlow;
use std::time::Duration;

/// Time between two pictures.
const TICK: Duration = Duration::from_millis(200);

/// Asks a question, draws a bar of the work on it, and ends it on Ctrl-C within a second; `quiet`
/// draws no bar.
pub(crate) fn watched<T>(
    quiet: bool,
    ask: impl FnOnce(&mut Watch) -> Result<T, Error>,
) -> Result<T, Error> {
    interrupt::listen(Patience::Short);
    shown(quiet, ask)
}

/// As [`watched`], of work that keeps what was done before it ends.
pub(crate) fn kept<T>(
    quiet: bool,
    ask: impl FnOnce(&mut Watch) -> Result<T, Error>,
) -> Result<T, Error> {
    interrupt::listen(Patience::UntilKept);
    shown(quiet, ask)
}

/// Does work that does not say how far it is, beside a sign that it goes on and for how long;
/// `quiet` draws none.
pub(crate) fn busy<T>(quiet: bool, what: &'static str, work: impl FnOnce() -> T) -> T {
    let bar = ProgressBar::with_draw_target(None, target(quiet)).with_message(what);
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}, {elapsed}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(TICK);
    let done = work();
    bar.finish_and_clear();
    done
}

fn target(quiet: bool) -> ProgressDrawTarget {
    if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() }
}

fn shown<T>(quiet: bool, ask: impl FnOnce(&mut Watch) -> Result<T, Error>) -> Result<T, Error> {
    let mut shown: Option<ProgressBar> = None;
    let answer = ask(&mut |progress| {
        if progress.what != "logs"
            && shown.as_ref().is_none_or(|bar| bar.length() != Some(progress.total))
        {
            end(shown.take());
            shown = Some(begin(progress, quiet));
        }
        if let Some(bar) = &shown {
            bar.set_position(progress.done);
        }
        if interrupt::asked() && progress.done < progress.total {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    });
    end(shown);
    answer
}

/// A bar from what is done already on.
fn begin(progress: Progress, quiet: bool) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(progress.total), target(quiet));
    let style = ProgressStyle::with_template(&format!(
        "{{wide_bar}} {{human_pos}} of {{human_len}} {}, {{rate}}/s, {{eta}} left",
        progress.what
    ));
    if let Ok(style) = style {
        // without the decimals of indicatif's own rate
        bar.set_style(style.with_key("rate", |state: &ProgressState, out: &mut dyn Write| {
            let _ = write!(out, "{}", rough(state.per_sec()));
        }));
    }
    bar.set_position(progress.done);
    bar.reset_eta();
    bar.enable_steady_tick(TICK);
    bar
}

/// Removes a bar.
fn end(bar: Option<ProgressBar>) {
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
}

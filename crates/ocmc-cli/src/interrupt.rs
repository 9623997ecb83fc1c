//! Ctrl-C: the first one asks the work to stop, a later one ends the program. Work that has nothing
//! to keep and does not stop soon is ended with the program.

use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::sync::{Once, OnceLock};
use std::thread;
use std::time::{Duration, Instant};

/// The signal that asked to stop; 0 before.
static ASKED_BY: AtomicI32 = AtomicI32::new(0);
static ASKED_AT: OnceLock<Instant> = OnceLock::new();
/// Whether there is nothing to keep.
static IS_SHORT: AtomicBool = AtomicBool::new(false);
static INSTALL: Once = Once::new();

/// Ctrl-C.
const SIGINT: i32 = 2;
/// One request to stop may arrive twice: `timeout` and schedulers signal a process and its group.
const SAME_WISH: Duration = Duration::from_millis(500);

/// For how long work may go on that was asked to stop.
const SOON: Duration = Duration::from_millis(700);

/// For how long work is waited for that was asked to stop.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Patience {
    /// Until it has kept what was done.
    UntilKept,
    /// Not for long: there is nothing to keep.
    Short,
}

/// Listens from now on. Where the system refuses, Ctrl-C ends the program at once, as it does by
/// default.
pub(crate) fn listen(patience: Patience) {
    IS_SHORT.store(matches!(patience, Patience::Short), Ordering::Relaxed);
    INSTALL.call_once(install);
}

/// Whether the user has asked to stop.
pub(crate) fn asked() -> bool {
    ASKED_BY.load(Ordering::Relaxed) != 0
}

/// Exit status of a run that a signal has ended: 128 and the signal's number, as of a program that
/// does not catch it.
pub(crate) fn exit_status() -> i32 {
    128 + ASKED_BY.load(Ordering::Relaxed)
}

/// Notes a request to stop, or ends the program where it is another one than the first.
fn ask(signal: i32) {
    let asked_at = ASKED_AT.get_or_init(Instant::now);
    let first = ASKED_BY.compare_exchange(0, signal, Ordering::Relaxed, Ordering::Relaxed);
    if first.is_err() && asked_at.elapsed() > SAME_WISH {
        crate::output::note("ended by a second signal");
        std::process::exit(128 + signal);
    }
    if first.is_ok() && IS_SHORT.load(Ordering::Relaxed) {
        thread::spawn(move || {
            thread::sleep(SOON);
            crate::output::note("interrupted: there is no answer without the rest");
            std::process::exit(128 + signal);
        });
    }
}

#[cfg(not(unix))]
fn install() {
    let _ = ctrlc::set_handler(|| ask(SIGINT));
}

/// Signals that were ignored when the program started stay ignored: `nohup` ignores the hang-up of
/// the terminal, and a script that starts a job in the background ignores Ctrl-C for it.
#[cfg(unix)]
fn install() {
    use signal_hook::consts::{SIGHUP, SIGTERM};
    let ignored = std::fs::read_to_string("/proc/self/status");
    let ignored = ignored.map_or(0, |status| ignored_signals(&status));
    let heard =
        [SIGHUP, SIGINT, SIGTERM].into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0);
    if let Ok(mut signals) = signal_hook::iterator::Signals::new(heard) {
        thread::spawn(move || signals.forever().for_each(ask));
    }
}

/// The signals that a process ignores, one bit each, from Linux's account of it. Other systems have
/// none, and reading what a signal does is unsafe code there: no signal counts as ignored.
#[cfg(unix)]
fn ignored_signals(status: &str) -> u64 {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}

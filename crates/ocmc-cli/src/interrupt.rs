//! Ctrl-C: the first one asks the run to stop, a later one ends the program.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Once, OnceLock};
use std::time::{Duration, Instant};

static ASKED: AtomicBool = AtomicBool::new(false);
static ASKED_AT: OnceLock<Instant> = OnceLock::new();
static INSTALL: Once = Once::new();

/// Exit status after a second Ctrl-C, by convention of the shells.
const ENDED_BY_CTRL_C: i32 = 130;
/// One request to stop may arrive twice: `timeout` and schedulers signal a process and its group.
const SAME_WISH: Duration = Duration::from_millis(500);

/// Listens from now on. Where the system refuses, Ctrl-C ends the program at once, as it does by
/// default.
pub(crate) fn listen() {
    INSTALL.call_once(install);
}

/// Whether the user has asked to stop.
pub(crate) fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

/// Notes a request to stop, or ends the program where it is another one than the first.
fn ask() {
    let asked_at = ASKED_AT.get_or_init(Instant::now);
    if ASKED.swap(true, Ordering::Relaxed) && asked_at.elapsed() > SAME_WISH {
        crate::output::note("ended by a second signal");
        std::process::exit(ENDED_BY_CTRL_C);
    }
}

#[cfg(not(unix))]
fn install() {
    let _ = ctrlc::set_handler(ask);
}

/// Signals that were ignored when the program started stay ignored: `nohup` ignores the hang-up of
/// the terminal, and a script that starts a job in the background ignores Ctrl-C for it.
#[cfg(unix)]
fn install() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let ignored = std::fs::read_to_string("/proc/self/status");
    let ignored = ignored.map_or(0, |status| ignored_signals(&status));
    let heard =
        [SIGHUP, SIGINT, SIGTERM].into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0);
    if let Ok(mut signals) = signal_hook::iterator::Signals::new(heard) {
        std::thread::spawn(move || signals.forever().for_each(|_| ask()));
    }
}

/// The signals that a process ignores, one bit each, from Linux's account of it. Other systems have
/// none, and reading what a signal does is unsafe code there: no signal counts as ignored.
#[cfg(unix)]
fn ignored_signals(status: &str) -> u64 {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}

//! Ctrl-C: the first one asks the run to stop, a later one ends the program.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Once, OnceLock};
use std::time::{Duration, Instant};

static ASKED: AtomicBool = AtomicBool::new(false);
static ASKED_AT: OnceLock<Instant> = OnceLock::new();
static INSTALL: Once = Once::new();

/// Exit status after a second Ctrl-C, by convention of the shells.
const ENDED_BY_CTRL_C: i32 = 130;
/// One wish to stop may arrive twice: `timeout` and schedulers signal a process and its group.
const SAME_WISH: Duration = Duration::from_millis(500);

/// Listens from now on. Where the system refuses, Ctrl-C ends the program at once, as it does by default.
pub(crate) fn listen() {
    INSTALL.call_once(|| {
        let _ = ctrlc::set_handler(|| {
            let asked_at = ASKED_AT.get_or_init(Instant::now);
            if ASKED.swap(true, Ordering::Relaxed) && asked_at.elapsed() > SAME_WISH {
                crate::output::note("ended by a second signal");
                std::process::exit(ENDED_BY_CTRL_C);
            }
        });
    });
}

/// Whether the user has asked to stop.
pub(crate) fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

//! Ctrl-C: the first one asks the run to stop, the second one ends the program.

use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);
static INSTALL: Once = Once::new();

/// Exit status after a second Ctrl-C, by convention of the shells.
const ENDED_BY_CTRL_C: i32 = 130;

/// Listens from now on. Where the system refuses, Ctrl-C ends the program at once, as it does by default.
pub(crate) fn listen() {
    INSTALL.call_once(|| {
        let _ = ctrlc::set_handler(|| {
            if ASKED.swap(true, Ordering::Relaxed) {
                std::process::exit(ENDED_BY_CTRL_C);
            }
        });
    });
}

/// Whether the user has asked to stop.
pub(crate) fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

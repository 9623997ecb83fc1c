//! Threads that drive, with stacks that are deep enough for a program that is not optimised.

use std::panic::resume_unwind;
use std::thread::{Builder, scope};

/// Whether threads can be started: not in WebAssembly, where the caller's thread does all work.
pub const CAN_START: bool = !cfg!(target_family = "wasm");

/// Stack of a thread that drives, in bytes. Without optimisation the step, which is inlined into
/// one function, has a place of its own there for each value in between: more than the 2 MB that
/// threads have of themselves. What is not used is never given.
pub const STACK_BYTES: usize = 32 << 20;

/// Does work that drives on the caller's thread, where that is optimised; else on one that has the
/// stack for it.
pub fn deep<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    if !cfg!(debug_assertions) || !CAN_START {
        return work();
    }
    scope(|scope| {
        let worker = Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, work);
        let worker = worker.expect("the system can start threads");
        worker.join().unwrap_or_else(|panic| resume_unwind(panic))
    })
}

//! The engine for a tab of a browser, compiled to WebAssembly: a WASI command that reads a question
//! from standard input and answers it on standard output, as `ocmc ask` does.
//!
//! Whoever calls it gives it files, a clock and the two streams; it needs nothing else, no thread
//! either. `scripts/build-tab` builds it.

#[cfg(target_family = "wasm")]
mod answering;

#[cfg(target_family = "wasm")]
fn main() -> std::process::ExitCode {
    answering::answer()
}

#[cfg(not(target_family = "wasm"))]
fn main() {}

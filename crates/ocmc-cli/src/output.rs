//! The two ways out: the answer to standard output, everything else to standard error. Neither can panic.

use crate::failure::Failure;
use std::io::{self, ErrorKind, IsTerminal, Write};

/// Width of what is printed where there is no terminal.
const DEFAULT_WIDTH: usize = 80;

/// Writes a part of the answer. A reader who has seen enough and closed the pipe is no failure.
pub(crate) fn answer(text: &str) -> Result<(), Failure> {
    answer_bytes(text.as_bytes())
}

/// As [`answer`], for what is not text.
pub(crate) fn answer_bytes(bytes: &[u8]) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        Err(source) => Err(Failure::StandardOutput { source }),
        Ok(()) => Ok(()),
    }
}

/// Writes a hint or an error. There is nobody to tell where this fails.
pub(crate) fn note(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// Columns that the answer may use.
pub(crate) fn width() -> usize {
    let terminal = io::stdout().is_terminal().then(terminal_size::terminal_size).flatten();
    terminal.map_or(DEFAULT_WIDTH, |(width, _)| usize::from(width.0).clamp(40, 160))
}

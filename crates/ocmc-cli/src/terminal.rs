//! How wide terminals are.

use std::io::{self, IsTerminal};

/// Width of what is printed where there is no terminal.
const DEFAULT_WIDTH: usize = 80;

/// Widths between which text is fitted to a terminal.
const NARROWEST: usize = 40;
const WIDEST: usize = 160;

/// Columns that the answer may use.
pub(crate) fn width() -> usize {
    let width = terminal_size::terminal_size_of(io::stdout()).map(|(width, _)| width.0);
    width.map_or(DEFAULT_WIDTH, clamped)
}

/// Columns of the terminal that shows standard error; none where it is no terminal.
pub(crate) fn error_terminal_width() -> Option<usize> {
    let stderr = io::stderr();
    let size = terminal_size::terminal_size_of(&stderr).map(|(width, _)| clamped(width.0));
    stderr.is_terminal().then(|| size.unwrap_or(DEFAULT_WIDTH))
}

fn clamped(width: u16) -> usize {
    usize::from(width).clamp(NARROWEST, WIDEST)
}

//! The ways out: the answer to standard output or a file, everything else to standard error. None
//! can panic.

use crate::failure::Failure;
use ocmc_api::printable::printable;
use ocmc_api::{Answer, RunAnswer};
use serde::Serialize;
use std::fs::{self, OpenOptions, Permissions};
use std::io::{self, ErrorKind, Write};
use std::path::Path;
use terminal_size::{Height, Width, terminal_size_of};

/// Longest line of a hint or an error, in characters: a file without line ends is no message.
const LONGEST_LINE: usize = 2000;

/// Width of what is printed where there is no terminal.
const DEFAULT_WIDTH: usize = 80;

/// Widths between which text is fitted to a terminal.
const NARROWEST: usize = 40;
const WIDEST: usize = 160;

/// Writes a part of the answer, in letters that a terminal shows. A reader who has seen enough and
/// closed the pipe is no failure.
pub(crate) fn answer(text: &str) -> Result<(), Failure> {
    answer_bytes(printable(text).as_bytes())
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

/// Writes an answer, as JSON where that was asked for, and before it what was read and its
/// warnings.
pub(crate) fn print(result: &impl Answer, json: bool) -> Result<(), Failure> {
    result.notes().iter().for_each(|told| note(told));
    print_quietly(result, json)
}

/// As [`print`], without what was read.
pub(crate) fn print_quietly(result: &impl Answer, json: bool) -> Result<(), Failure> {
    result.warnings().iter().for_each(|warning| warn(warning));
    answer(&if json { result.to_indented_json() } else { result.text() })
}

/// As [`print`], of a run, as wide as the terminal is.
pub(crate) fn print_run(run: &RunAnswer, json: bool) -> Result<(), Failure> {
    let width = width(terminal_size_of(io::stdout()));
    answer(&if json { run.to_indented_json() } else { run.text_of_width(width) })
}

/// Where a table goes: a file, in the format of its extension, or standard output as CSV.
pub(crate) struct Target<'a> {
    path: Option<&'a Path>,
    json: bool,
}

impl<'a> Target<'a> {
    /// Works out the format from the name of the file.
    pub(crate) fn of(path: Option<&'a Path>) -> Result<Self, Failure> {
        let extension = path.map(|path| path.extension().and_then(|extension| extension.to_str()));
        match extension {
            None | Some(Some("csv")) => Ok(Self { path, json: false }),
            Some(Some("json")) => Ok(Self { path, json: true }),
            Some(_) => {
                let text = "the name after --out has to end in `.csv` or `.json`";
                Err(Failure::Usage(text.to_owned()))
            }
        }
    }

    /// JSON to standard output.
    pub(crate) fn json() -> Self {
        Self { path: None, json: true }
    }

    /// Writes what has a form for each format.
    pub(crate) fn write(
        &self,
        answer: &impl Serialize,
        csv: impl FnOnce(&mut Vec<u8>) -> io::Result<()>,
    ) -> Result<(), Failure> {
        let mut bytes = Vec::new();
        if self.json {
            serde_json::to_writer(&mut bytes, answer).expect("numbers, and keys that are words");
            bytes.push(b'\n');
        } else {
            csv(&mut bytes).expect("memory takes what is written to it");
        }
        match self.path {
            None => answer_bytes(&bytes),
            Some(path) => write(path, &bytes),
        }
    }
}

/// Writes a file; an existing one is replaced, in one go: on a full disk it stays as it was.
pub(crate) fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), Failure> {
    let content = content.as_ref();
    let written = match fs::metadata(path) {
        Ok(entry) if !entry.is_file() => fs::write(path, content),
        entry => replace(path, content, entry.ok().map(|entry| entry.permissions())),
    };
    written.map_err(|source| Failure::File { path: path.to_owned(), source })
}

/// Writes a file beside another one, and puts it in its place.
fn replace(path: &Path, content: &[u8], permissions: Option<Permissions>) -> io::Result<()> {
    // what a link leads to is replaced, not the link
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let mut beside = path.clone().into_os_string();
    beside.push(format!(".{}.tmp", std::process::id()));
    let written = match OpenOptions::new().write(true).create_new(true).open(&beside) {
        // a file may be ours in a directory that is not
        Err(error) if error.kind() == ErrorKind::PermissionDenied => fs::write(&path, content),
        Err(error) => return Err(error),
        Ok(mut file) => file
            .write_all(content)
            .and_then(|()| permissions.map_or(Ok(()), |given| file.set_permissions(given)))
            .and_then(|()| fs::rename(&beside, &path)),
    };
    if written.is_err() {
        let _ = fs::remove_file(&beside);
    }
    written
}

/// Writes a hint or an error. Where this fails, there is nowhere to report it.
pub(crate) fn note(text: &str) {
    drawn(&printable(text));
}

/// As [`note`], of what is drawn with colours.
pub(crate) fn drawn(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", fitted(text));
}

/// Writes what has to be known.
pub(crate) fn warn(text: &str) {
    note(&format!("warning: {text}"));
}

/// A text that may hold what a file holds: control characters are spelled out, but for line ends
/// and colours, and lines end somewhere.
fn fitted(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    let mut in_line = 0;
    for (place, letter) in text.char_indices() {
        in_line = if letter == '\n' { 0 } else { in_line + 1 };
        if in_line == LONGEST_LINE {
            shown.push('…');
        } else if in_line < LONGEST_LINE {
            if letter.is_control() && !matches!(letter, '\n' | '\t') && !is_colour(&text[place..]) {
                shown.extend(letter.escape_default());
            } else {
                shown.push(letter);
            }
        }
    }
    shown
}

/// Whether a text begins with what changes a terminal's colour.
fn is_colour(text: &str) -> bool {
    text.strip_prefix("\u{1b}[").is_some_and(|rest| {
        rest.trim_start_matches(|c: char| c.is_ascii_digit() || c == ';').starts_with('m')
    })
}

/// Columns that text may have on a terminal of that size, where there is one.
pub(crate) fn width(size: Option<(Width, Height)>) -> usize {
    size.map_or(DEFAULT_WIDTH, |(width, _)| usize::from(width.0).clamp(NARROWEST, WIDEST))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_would_obey_is_spelled_out_and_lines_end() {
        let text = "a\tb\u{1b}[1;31mred\u{1b}[0m\u{1b}]0;title\u{7}\u{1b}[2J\nnext";
        let wanted = "a\tb\u{1b}[1;31mred\u{1b}[0m\\u{1b}]0;title\\u{7}\\u{1b}[2J\nnext";
        assert_eq!(fitted(text), wanted);
        let long = fitted(&format!("{}\nnext", "x".repeat(5_000_000)));
        assert_eq!(long, format!("{}…\nnext", "x".repeat(LONGEST_LINE - 1)));
    }
}

//! Words in tables that a spreadsheet would take for a formula.
//!
//! A spreadsheet that opens a CSV file evaluates a cell that begins with `=`, `+`, `-` or `@`, and
//! with a tabulator or a carriage return before one. Words come from files of others: names of
//! drivers, drives and road types. Such a word is written behind an apostrophe, which is how a
//! spreadsheet itself marks a text, and read back without it. Numbers stay as they are.

use std::borrow::Cow;

/// Whether a word, behind any apostrophes, begins like a formula.
fn is_formula(word: &str) -> bool {
    word.trim_start_matches('\'').starts_with(['=', '+', '-', '@', '\t', '\r'])
}

/// A word as it is written.
pub fn written(word: &str) -> Cow<'_, str> {
    if is_formula(word) { Cow::Owned(format!("'{word}")) } else { Cow::Borrowed(word) }
}

/// A word that was written so.
pub fn read(word: &str) -> &str {
    word.strip_prefix('\'').filter(|rest| is_formula(rest)).unwrap_or(word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_word_is_written_as_a_formula_and_each_is_read_back() {
        for word in ["=1+1", "+1", "-5", "@a", "\t=1", "\r", "'=1", "''-1"] {
            let there = written(word);
            assert!(there.starts_with('\''), "{there}");
            assert_eq!(read(&there), word);
        }
        for word in ["", "a", "'a", "''", "1-2", "rock'n'roll"] {
            assert_eq!((&*written(word), read(word)), (word, word));
        }
    }
}

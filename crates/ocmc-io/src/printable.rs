//! Letters that a terminal obeys instead of showing them.

use std::borrow::Cow;
use std::fmt::Write;

/// Whether a letter is none that is shown: a control character, or a mark that turns the direction
/// of writing around, so that a text reads otherwise than it is.
pub fn is_hidden(letter: char) -> bool {
    letter.is_control() || matches!(letter, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// A text in which hidden letters are spelled out as `\u001b`, but for line ends and tabulators. In
/// JSON it means the same as before.
pub fn printable(text: &str) -> Cow<'_, str> {
    let is_kept = |letter| !is_hidden(letter) || matches!(letter, '\n' | '\t');
    let plain = text.replace("\r\n", "\n");
    if plain.chars().all(is_kept) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    for letter in plain.chars() {
        if is_kept(letter) {
            shown.push(letter);
        } else {
            write!(shown, "\\u{:04x}", u32::from(letter)).expect("a string takes any text");
        }
    }
    Cow::Owned(shown)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_letters_are_spelled_out_and_others_stay() {
        assert_eq!(printable("a\tb\r\nå €\n"), "a\tb\r\nå €\n");
        assert_eq!(printable("\u{1b}[2J\u{9b}2J\r\u{202e}"), "\\u001b[2J\\u009b2J\\u000d\\u202e");
    }
}

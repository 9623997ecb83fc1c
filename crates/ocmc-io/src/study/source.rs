//! Where a key of a study was written: a text, and a place in it.

use crate::printable::is_hidden;
use std::ops::Range;
use std::sync::Arc;

/// Longest piece of a source line that is shown, in characters.
const SHOWN_CHARACTERS: usize = 120;

/// A text that keys come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Kind of the text.
    pub kind: SourceKind,
    /// Its name: a path, the name of a built-in, or the argument itself.
    pub name: String,
    /// The text.
    pub text: String,
}

/// The kind of a [`Source`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceKind {
    /// A file of the user.
    File,
    /// A study or vehicle that is part of the program.
    BuiltIn,
    /// The argument of a `--set`.
    Setting,
}

/// A place in a source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The text.
    pub source: Arc<Source>,
    /// Bytes of the text.
    pub span: Range<usize>,
}

impl Source {
    /// The source as it is called in messages.
    pub fn label(&self) -> String {
        match self.kind {
            SourceKind::File => cut(&self.name, usize::MAX),
            SourceKind::BuiltIn => format!("built-in {}", self.name),
            SourceKind::Setting => format!("--set {}", cut(&self.name, SHOWN_CHARACTERS)),
        }
    }
}

impl Place {
    /// A place, moved to the nearest character boundaries of the text.
    pub fn new(source: &Arc<Source>, span: Range<usize>) -> Self {
        let text = &source.text;
        let start = floor_boundary(text, span.start);
        let end = floor_boundary(text, span.end.max(span.start)).max(start);
        Self { source: Arc::clone(source), span: start..end }
    }

    /// Line, from 1.
    pub fn line(&self) -> usize {
        self.source.text[..self.span.start].matches('\n').count() + 1
    }

    /// Column in characters, from 1.
    pub fn column(&self) -> usize {
        self.source.text[self.line_start()..self.span.start].chars().count() + 1
    }

    /// The text of the place, on one line, cut to `most` characters.
    pub fn text(&self, most: usize) -> String {
        cut(&self.source.text[self.span.clone()], most)
    }

    /// The place as it is called in messages.
    pub fn label(&self) -> String {
        match self.source.kind {
            SourceKind::Setting => self.source.label(),
            _ => format!("{}:{}:{}", self.source.label(), self.line(), self.column()),
        }
    }

    /// The source line, cut to 120 characters around the place, and where in it the place begins
    /// and how many characters it has.
    pub fn excerpt(&self) -> (String, usize, usize) {
        let text = &self.source.text;
        let rest = &text[self.line_start()..];
        let line = rest.split('\n').next().unwrap_or_default().trim_end_matches('\r');
        let characters: Vec<char> = line.chars().map(shown).collect();
        let at = (self.column() - 1).min(characters.len());
        let marked = text[self.span.clone()].split('\n').next().unwrap_or_default();
        let marked = marked.trim_end().chars().count().max(1);
        let first = if characters.len() <= SHOWN_CHARACTERS || at < SHOWN_CHARACTERS - 30 {
            0
        } else {
            at - SHOWN_CHARACTERS / 2
        };
        let last = characters.len().min(first + SHOWN_CHARACTERS);
        let shown: String = characters[first..last].iter().collect();
        (shown, at - first, marked.min((last - at).max(1)))
    }

    fn line_start(&self) -> usize {
        self.source.text[..self.span.start].rfind('\n').map_or(0, |k| k + 1)
    }
}

/// A text on one line, cut to `most` characters.
pub(super) fn cut(text: &str, most: usize) -> String {
    let mut shown_text: String = text.chars().take(most).map(shown).collect();
    if text.chars().nth(most).is_some() {
        shown_text.push('…');
    }
    shown_text
}

/// Control characters are not sent to a terminal.
fn shown(character: char) -> char {
    match character {
        '\t' | '\n' | '\r' => ' ',
        c if is_hidden(c) => '\u{fffd}',
        c => c,
    }
}

fn floor_boundary(text: &str, index: usize) -> usize {
    let mut index = index.min(text.len());
    while !text.is_char_boundary(index) {
        index -= 1;
    }
    index
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(text: &str, span: Range<usize>) -> Place {
        let source = Source { kind: SourceKind::File, name: "a.toml".into(), text: text.into() };
        Place::new(&Arc::new(source), span)
    }

    #[test]
    fn line_and_column_count_characters_from_one() {
        let place = place("a = 1\nå = -3\n", 11..13);
        assert_eq!((place.line(), place.column()), (2, 5));
        assert_eq!(place.excerpt(), ("å = -3".to_owned(), 4, 2));
        assert_eq!(place.label(), "a.toml:2:5");
    }

    #[test]
    fn long_lines_are_cut_around_the_place() {
        let text = format!("{}!{}", "x".repeat(1000), "y".repeat(1000));
        let (line, at, marked) = place(&text, 1000..1001).excerpt();
        assert_eq!((line.chars().count(), line.chars().nth(at), marked), (120, Some('!'), 1));
    }

    #[test]
    fn a_span_outside_the_text_is_moved_into_it() {
        let place = place("å", 1..99);
        assert_eq!(place.span, 0..2);
    }
}

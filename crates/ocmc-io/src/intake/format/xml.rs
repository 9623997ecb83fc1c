//! Documents in XML: elements, their attributes and their texts, in the order in which they stand.
//!
//! A document type is refused: it may define entities that expand to any length, and no track has
//! one.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// Most elements within each other.
const DEEPEST: usize = 64;

/// A piece of a document.
pub(super) enum Piece<'a> {
    /// An element begins; its name has no prefix.
    Begin(&'a str, Attributes<'a>),
    /// An element ends, with its name and the text right inside it.
    End(&'a str, &'a str),
}

/// Attributes of an element.
pub(super) struct Attributes<'a>(&'a BytesStart<'a>);

impl Attributes<'_> {
    /// The value of an attribute, as a number; NaN where it is missing or no number.
    pub(super) fn number(&self, name: &str) -> f64 {
        let value = self.0.try_get_attribute(name).ok().flatten();
        value.map_or(f64::NAN, |value| number(&value.value))
    }
}

/// The number that a text is; NaN where it is none.
pub(super) fn number(text: &str) -> f64 {
    text.trim().parse().ok().filter(|number: &f64| number.is_finite()).unwrap_or(f64::NAN)
}

/// Calls `take` with each piece of a document.
///
/// # Errors
/// Where it is not well formed, or what `take` says.
pub(super) fn walk(
    text: &str,
    mut take: impl FnMut(Piece) -> Result<(), String>,
) -> Result<(), String> {
    let mut reader = Reader::from_str(text);
    // names of open elements in one text, where each begins, and the same of their texts
    let (mut names, mut name_starts) = (String::new(), Vec::<usize>::new());
    let (mut texts, mut text_starts) = (String::new(), Vec::<usize>::new());
    loop {
        let place = reader.buffer_position();
        let broken = |reason: String| format!("is not well formed at byte {place}: {reason}");
        match reader.read_event().map_err(|error| broken(error.to_string()))? {
            Event::Start(element) => {
                if name_starts.len() >= DEEPEST {
                    return Err(format!("has more than {DEEPEST} elements within each other"));
                }
                let name = element.local_name();
                let name: &str = name.as_ref();
                take(Piece::Begin(name, Attributes(&element)))?;
                name_starts.push(names.len());
                names.push_str(name);
                text_starts.push(texts.len());
            }
            Event::Empty(element) => {
                let name = element.local_name();
                let name: &str = name.as_ref();
                take(Piece::Begin(name, Attributes(&element)))?;
                take(Piece::End(name, ""))?;
            }
            Event::Text(text) if !text_starts.is_empty() => {
                texts.push_str(&text);
            }
            Event::CData(text) if !text_starts.is_empty() => {
                texts.push_str(&text);
            }
            Event::GeneralRef(entity) if !text_starts.is_empty() => {
                let known = [("amp", '&'), ("lt", '<'), ("gt", '>'), ("quot", '"'), ("apos", '\'')];
                let named =
                    known.iter().find(|(known, _)| *known == &*entity).map(|(_, letter)| *letter);
                let letter = named.or_else(|| entity.resolve_char_ref().ok().flatten());
                texts.push(letter.unwrap_or('\u{fffd}'));
            }
            Event::End(_) => {
                let (Some(name), Some(text)) = (name_starts.pop(), text_starts.pop()) else {
                    return Err(broken("an end without a beginning".to_owned()));
                };
                take(Piece::End(&names[name..], &texts[text..]))?;
                names.truncate(name);
                texts.truncate(text);
            }
            Event::DocType(_) => {
                return Err(
                    "has a document type (<!DOCTYPE ...>), which may hide entities that expand \
                            to any length: leave that line out"
                        .to_owned(),
                );
            }
            Event::Eof if name_starts.is_empty() => return Ok(()),
            Event::Eof => return Err(format!("ends within `{}`", &names[name_starts[0]..])),
            _ => {}
        }
    }
}

//! The study of a run as a sheet: a key, its value and its meaning in each row.

use super::STUDY;
use super::package::Package;
use super::sheet::{Cell, MOST_CHARACTERS};
use crate::run_directory::Manifest;
use crate::study::{KeyValue, keys_of};
use std::io::{self, Seek, Write};

/// Writes the sheet. A value that is longer than a cell goes on in the next rows, with the same
/// key.
pub(super) fn add<W: Write + Seek>(
    package: Package<W>,
    manifest: &Manifest,
) -> io::Result<Package<W>> {
    let keys = keys_of(&manifest.resolved_study);
    let names = ["key", "value", "meaning | allowed"];
    let mut sheet = package.sheet(STUDY, names, &[44, 32, 60], 0)?;
    for KeyValue { key, value, note } in &keys {
        match value {
            toml::Value::Float(number) if number.is_finite() => {
                sheet.row([key.as_str().into(), (*number).into(), note.as_str().into()])?;
            }
            toml::Value::Integer(number) if u64::try_from(*number).is_ok() => {
                let number = number.unsigned_abs();
                sheet.row([key.as_str().into(), number.into(), note.as_str().into()])?;
            }
            toml::Value::String(text) => {
                for (k, part) in parts(text).into_iter().enumerate() {
                    let note = if k == 0 { note.as_str().into() } else { Cell::Empty };
                    sheet.row([key.as_str().into(), part.into(), note])?;
                }
            }
            other => {
                let text = other.to_string();
                sheet.row([key.as_str().into(), text.into(), note.as_str().into()])?;
            }
        }
    }
    sheet.end()
}

/// A text in parts that fit into cells.
fn parts(text: &str) -> Vec<String> {
    let (mut parts, mut length) = (vec![String::new()], 0);
    for letter in text.chars() {
        if length + letter.len_utf16() > MOST_CHARACTERS {
            parts.push(String::new());
            length = 0;
        }
        length += letter.len_utf16();
        let last = parts.len() - 1;
        parts[last].push(letter);
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_are_parted_and_nothing_is_lost() {
        let text = "a😀".repeat(30_000);
        let texts = parts(&text);
        assert_eq!(texts.len(), 3);
        assert!(texts.iter().all(|part| part.encode_utf16().count() <= MOST_CHARACTERS));
        assert_eq!(texts.concat(), text);
        assert_eq!(parts(""), [""]);
    }
}

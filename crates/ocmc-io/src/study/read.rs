//! Reading the text of a study or vehicle: a built-in one by its name, otherwise a file.

use super::builtin::{BuiltIn, STUDIES, VEHICLES};
use super::error::{Cause, Fault};
use super::source::{Source, SourceKind};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Largest study file, in bytes: a hundred times the default one.
pub(super) const MOST_BYTES: u64 = 4 << 20;

/// What a name stands for: its word, and what is built in of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kind(&'static str, &'static [BuiltIn]);

pub(super) const STUDY: Kind = Kind("study", STUDIES);
pub(super) const VEHICLE: Kind = Kind("vehicle", VEHICLES);

/// A text and the file that it is from; a built-in one has none.
pub(super) struct Text {
    pub(super) source: Arc<Source>,
    pub(super) file: Option<PathBuf>,
}

/// Reads a built-in study or vehicle, or a file, relative to `folder`.
pub(super) fn read(name: &str, kind: Kind, folder: Option<&Path>) -> Result<Text, Box<Fault>> {
    if let Some(built_in) = kind.1.iter().find(|built_in| built_in.name == name) {
        let (name, text) = (built_in.name.to_owned(), built_in.text.to_owned());
        let source = Arc::new(Source { kind: SourceKind::BuiltIn, name, text });
        return Ok(Text { source, file: None });
    }
    let path = folder.map_or_else(|| PathBuf::from(name), |folder| folder.join(name));
    let text = read_file(&path, name, kind)?;
    let name = path.display().to_string();
    let source = Arc::new(Source { kind: SourceKind::File, name, text });
    Ok(Text { source, file: Some(path) })
}

fn read_file(path: &Path, name: &str, kind: Kind) -> Result<String, Box<Fault>> {
    let shown = path.display().to_string();
    let unreadable = |error: std::io::Error| {
        Fault::new(Cause::Unreadable { path: shown.clone(), reason: error.to_string() })
    };
    let metadata = match std::fs::metadata(path) {
        Ok(metadata) => metadata,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            let names: Vec<&str> = kind.1.iter().map(|built_in| built_in.name).collect();
            let cause = Cause::UnknownName { what: kind.0, name: shown };
            return Err(Fault::new(cause).suggest(name, &names));
        }
        Err(error) => return Err(unreadable(error)),
    };
    if metadata.is_dir() {
        return Err(Fault::new(Cause::Directory(shown)));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(unreadable)?;
    file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(Fault::new(Cause::TooLarge { path: shown, limit: MOST_BYTES }));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let byte = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..=byte].split(|b| *b == b'\n').count();
        Fault::new(Cause::NotText { path: shown.clone(), line, byte })
    })?;
    if text.trim().is_empty() {
        let fault = Fault::new(Cause::Empty(shown));
        return Err(fault.help("`ocmc study init FILE` writes a complete study"));
    }
    Ok(text)
}

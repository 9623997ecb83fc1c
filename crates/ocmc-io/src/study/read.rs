//! Reading the text of a study or vehicle: a built-in one by its name, otherwise a file.

use super::builtin::{self, BuiltIn};
use super::error::{Cause, Fault};
use super::source::{Source, SourceKind};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Largest study file, in bytes: a hundred times the default one.
pub(super) const MOST_BYTES: u64 = 4 << 20;

/// What a name stands for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    Study,
    Vehicle,
}

impl Kind {
    fn built_in(self) -> &'static [BuiltIn] {
        match self {
            Self::Study => builtin::STUDIES,
            Self::Vehicle => builtin::VEHICLES,
        }
    }

    fn word(self) -> &'static str {
        match self {
            Self::Study => "study",
            Self::Vehicle => "vehicle",
        }
    }
}

/// A text and the file that it is from; a built-in one has none.
pub(super) struct Text {
    pub(super) source: Arc<Source>,
    pub(super) file: Option<PathBuf>,
}

/// Reads a built-in study or vehicle, or a file, relative to `folder`.
pub(super) fn read(name: &str, kind: Kind, folder: Option<&Path>) -> Result<Text, Box<Fault>> {
    if let Some(built_in) = kind.built_in().iter().find(|built_in| built_in.name == name) {
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
        let reason = error.to_string();
        Box::new(Fault::new(Cause::Unreadable { path: shown.clone(), reason }))
    };
    let metadata = match std::fs::metadata(path) {
        Ok(metadata) => metadata,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            let names: Vec<&str> = kind.built_in().iter().map(|built_in| built_in.name).collect();
            let cause = Cause::UnknownName { what: kind.word(), name: shown };
            return Err(Box::new(Fault::new(cause).suggest(name, &names)));
        }
        Err(error) => return Err(unreadable(error)),
    };
    if metadata.is_dir() {
        return Err(Box::new(Fault::new(Cause::Directory { path: shown })));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(unreadable)?;
    file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > MOST_BYTES {
        let cause = Cause::TooLarge { path: shown, limit: MOST_BYTES };
        return Err(Box::new(Fault::new(cause)));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let byte = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..=byte].split(|b| *b == b'\n').count();
        Box::new(Fault::new(Cause::NotText { path: shown.clone(), line, byte }))
    })?;
    if text.trim().is_empty() {
        let fault = Fault::new(Cause::Empty { path: shown });
        return Err(Box::new(fault.help("`ocmc study init FILE` writes a complete study")));
    }
    Ok(text)
}

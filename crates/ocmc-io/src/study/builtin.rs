//! The studies and vehicles that are part of the program, and the text of one: of a built-in one by
//! its name, otherwise of a file.

use super::error::{Cause, Fault, StudyFileError};
use super::files::Files;
use super::source::{Source, SourceKind};
use crate::input_file;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A study or vehicle that is part of the program.
#[derive(Clone, Copy, Debug)]
pub struct BuiltIn {
    /// Its name.
    pub name: &'static str,
    /// Its text.
    pub text: &'static str,
}

const fn built_in(name: &'static str, text: &'static str) -> BuiltIn {
    BuiltIn { name, text }
}

impl BuiltIn {
    /// Description of a study in one line, as it says itself; of a vehicle, how its file begins.
    pub fn description(&self) -> String {
        let said = |line: &'static str| line.strip_prefix("description = \"")?.strip_suffix('"');
        if let Some(said) = self.text.lines().find_map(said) {
            return said.to_owned();
        }
        let comment = self.text.lines().map_while(|line| line.strip_prefix("# "));
        let comment = comment.collect::<Vec<_>>().join(" ");
        let first = comment.split_once(". ").map_or(comment.as_str(), |(first, _)| first);
        first.trim_end_matches('.').to_owned()
    }
}

/// The name of the default study.
pub const DEFAULT: &str = "field-truck";

/// The built-in studies, the default one first.
pub const STUDIES: &[BuiltIn] = &[
    built_in(DEFAULT, include_str!("../../../../configs/field-truck.toml")),
    built_in("field-truck-loaded", include_str!("../../../../configs/field-truck-loaded.toml")),
    built_in("field-truck-printed", include_str!("../../../../configs/field-truck-printed.toml")),
    built_in("field-truck-table", include_str!("../../../../configs/field-truck-table.toml")),
    built_in("simulator-truck", include_str!("../../../../configs/simulator-truck.toml")),
    built_in("simulator-slopes", include_str!("../../../../configs/simulator-slopes.toml")),
    built_in("simulator-study", include_str!("../../../../configs/simulator-study.toml")),
    built_in("long-haul", include_str!("../../../../configs/long-haul.toml")),
    built_in("regional", include_str!("../../../../configs/regional.toml")),
    built_in("urban-delivery", include_str!("../../../../configs/urban-delivery.toml")),
    built_in("battery-truck", include_str!("../../../../configs/battery-truck.toml")),
    built_in("electric-regional", include_str!("../../../../configs/electric-regional.toml")),
    built_in("electric-long-haul", include_str!("../../../../configs/electric-long-haul.toml")),
    built_in("fuel-cell-truck", include_str!("../../../../configs/fuel-cell-truck.toml")),
    built_in("passenger-car", include_str!("../../../../configs/passenger-car.toml")),
];

/// The built-in vehicles.
pub const VEHICLES: &[BuiltIn] = &[
    built_in("tractor-40t", include_str!("../../../../configs/vehicles/tractor-40t.toml")),
    built_in(
        "tractor-40t-vecto",
        include_str!("../../../../configs/vehicles/tractor-40t-vecto.toml"),
    ),
    built_in("rigid-12t", include_str!("../../../../configs/vehicles/rigid-12t.toml")),
    built_in("city-bus-12m", include_str!("../../../../configs/vehicles/city-bus-12m.toml")),
    built_in(
        "tractor-electric-40t",
        include_str!("../../../../configs/vehicles/tractor-electric-40t.toml"),
    ),
    built_in(
        "tractor-fuel-cell-40t",
        include_str!("../../../../configs/vehicles/tractor-fuel-cell-40t.toml"),
    ),
    built_in(
        "city-bus-electric-12m",
        include_str!("../../../../configs/vehicles/city-bus-electric-12m.toml"),
    ),
    built_in("coach-12m", include_str!("../../../../configs/vehicles/coach-12m.toml")),
    built_in("van-3500kg", include_str!("../../../../configs/vehicles/van-3500kg.toml")),
    built_in("car-electric", include_str!("../../../../configs/vehicles/car-electric.toml")),
    built_in("car-petrol", include_str!("../../../../configs/vehicles/car-petrol.toml")),
];

/// The built-in studies, the default one first.
pub fn list() -> &'static [BuiltIn] {
    STUDIES
}

/// The built-in vehicles.
pub fn vehicles() -> &'static [BuiltIn] {
    VEHICLES
}

/// The text of a built-in study or vehicle.
///
/// # Errors
/// [`StudyFileError`] names the nearest built-in name.
pub fn show(name: &str) -> Result<&'static str, StudyFileError> {
    find(name).ok_or_else(|| unknown(name, Cause::NotBuiltIn(name.to_owned())))
}

/// The text of a built-in study or vehicle, or of a file, as it is written. A built-in name wins
/// over a file.
///
/// # Errors
/// [`StudyFileError`] names the nearest built-in name, or says why the file cannot be read.
pub fn text(name_or_path: &Path, files: &Files) -> Result<String, StudyFileError> {
    if let Some(text) = name_or_path.to_str().and_then(find) {
        return Ok(text.to_owned());
    }
    if name_or_path == Path::new(STANDARD_INPUT) {
        return Ok(standard_input()?.text);
    }
    if *files != Files::Refused && !name_or_path.exists() {
        let name = name_or_path.display().to_string();
        let (what, shown) = ("study or vehicle", name.clone());
        return Err(unknown(&shown, Cause::UnknownName { what, name }));
    }
    Ok(read(name_or_path, "study", STUDY, files)?.source.text.clone())
}

fn all() -> impl Iterator<Item = &'static BuiltIn> {
    STUDIES.iter().chain(VEHICLES)
}

pub(super) fn find(name: &str) -> Option<&'static str> {
    all().find(|built_in| built_in.name == name).map(|built_in| built_in.text)
}

/// The fault of a name that is not built in, with the nearest one that is.
fn unknown(name: &str, cause: Cause) -> StudyFileError {
    let names: Vec<&str> = all().map(|built_in| built_in.name).collect();
    Fault::new(cause).suggest(name, &names).into()
}

/// Largest study file, in bytes: a hundred times the default one.
pub(super) const MOST_BYTES: u64 = 4 << 20;

/// Kind of a name: its word, and its built-in files.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kind(&'static str, &'static [BuiltIn]);

impl Kind {
    pub(super) fn is_vehicle(self) -> bool {
        self.0 == VEHICLE.0
    }

    fn names(self) -> Vec<&'static str> {
        self.1.iter().map(|built_in| built_in.name).collect()
    }
}

pub(super) const STUDY: Kind = Kind("study", STUDIES);
pub(super) const VEHICLE: Kind = Kind("vehicle", VEHICLES);

/// A text and the file that it is from; a built-in one has none.
pub(super) struct Text {
    pub(super) source: Arc<Source>,
    pub(super) file: Option<PathBuf>,
}

/// Reads the built-in study or vehicle, or the file, that a key names.
pub(super) fn read(name: &Path, key: &str, kind: Kind, files: &Files) -> Result<Text, Box<Fault>> {
    if let Some(built_in) = kind.1.iter().find(|built_in| name.to_str() == Some(built_in.name)) {
        let (name, text) = (built_in.name.to_owned(), built_in.text.to_owned());
        let source = Arc::new(Source { kind: SourceKind::BuiltIn, name, text });
        return Ok(Text { source, file: None });
    }
    let shown = name.to_string_lossy();
    let refused = |fault: Box<Fault>| fault.suggest(&shown, &kind.names());
    let path = files.path(key, name).map_err(refused)?;
    let text = read_file(&path, &shown, kind)?;
    let name = path.display().to_string();
    let source = Arc::new(Source { kind: SourceKind::File, name, text });
    Ok(Text { source, file: Some(path) })
}

fn read_file(path: &Path, name: &str, kind: Kind) -> Result<String, Box<Fault>> {
    let shown = path.display().to_string();
    let metadata = match std::fs::metadata(path) {
        Ok(metadata) => metadata,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            let cause = Cause::UnknownName { what: kind.0, name: shown };
            return Err(Fault::new(cause).suggest(name, &kind.names()));
        }
        Err(error) => return Err(unreadable(&shown)(error)),
    };
    if metadata.is_dir() {
        return Err(Fault::new(Cause::Directory(shown)));
    }
    text_of(&shown, input_file::open(path).map_err(unreadable(&shown))?)
}

/// The name of standard input in place of a study's.
pub(super) const STANDARD_INPUT: &str = "-";

/// A study on standard input.
pub(super) fn standard_input() -> Result<Source, Box<Fault>> {
    let name = "standard input".to_owned();
    let text = text_of(&name, std::io::stdin())?;
    Ok(Source { kind: SourceKind::File, name, text })
}

fn unreadable(path: &str) -> impl Fn(std::io::Error) -> Box<Fault> {
    move |error| Fault::new(Cause::Unreadable { path: path.to_owned(), reason: error.to_string() })
}

/// The text of a study that is called so.
fn text_of(name: &str, file: impl Read) -> Result<String, Box<Fault>> {
    let shown = name.to_owned();
    let mut bytes = Vec::new();
    file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable(name))?;
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

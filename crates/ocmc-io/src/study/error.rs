//! Faults of a study, for people: where it is written, what is allowed, and what was probably
//! meant.

use super::source::{Place, cut};
use std::fmt;

/// Most faults that are printed at once.
const SHOWN_FAULTS: usize = 20;
/// Longest message that is printed, in characters.
const SHOWN_MESSAGE: usize = 1500;
/// Most names that are printed in a list of allowed ones.
const SHOWN_NAMES: usize = 24;

/// Everything that is wrong with a study file.
///
/// Its text is complete and readable; a program that draws its own messages takes them from
/// `faults`.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyFileError {
    /// The faults, at least one.
    pub faults: Vec<Fault>,
}

/// One thing that is wrong with a study file.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Cause of the fault.
    pub cause: Cause,
    /// Where it is written; none for what is wrong with a whole file, or a study without a text.
    pub place: Option<Place>,
    /// How to correct it.
    pub help: Option<String>,
    /// Where a value that the user did not write comes from.
    pub note: Option<String>,
}

/// A fault's cause.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Cause {
    /// A name that is neither built in nor a file.
    #[error("`{name}` is neither a built-in {what} nor a file")]
    UnknownName {
        /// A study or a vehicle.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A name that is not built in.
    #[error("no study or vehicle called `{0}` is built in")]
    NotBuiltIn(String),
    /// A file that cannot be read.
    #[error("cannot read `{path}`: {reason}")]
    Unreadable {
        /// The file.
        path: String,
        /// The system's answer.
        reason: String,
    },
    /// A name of a file where none may be read: its key.
    #[error(
        "`{0}` names a file or nothing that is built in, and no file may be read here: allowed is \
         what is built in"
    )]
    FileRefused(String),
    /// A file that lies outside the folder of those that may be read.
    #[error(
        "`{0}` names a file outside of the files that were given: allowed are their plain names"
    )]
    FileOutside(String),
    /// A directory.
    #[error("`{0}` is a directory, not a study file")]
    Directory(String),
    /// A file that is too large.
    #[error("`{path}` has more than {limit} bytes: not a study file")]
    TooLarge {
        /// The file.
        path: String,
        /// The largest size.
        limit: u64,
    },
    /// A file that is not text.
    #[error(
        "`{path}` is not UTF-8 text: line {line}, byte {byte} of the file; save it in UTF-8, not \
         in UTF-16 or Latin-1"
    )]
    NotText {
        /// The file.
        path: String,
        /// Line of the first wrong byte, from 1.
        line: usize,
        /// Position of the first wrong byte, from 0.
        byte: usize,
    },
    /// A file without a key.
    #[error("`{0}` is empty")]
    Empty(String),
    /// A text that is not TOML, and what the parser says.
    #[error("not valid TOML: {0}")]
    Syntax(String),
    /// A `--set` that is not one.
    #[error("`--set {setting}` has no {part}")]
    Setting {
        /// The argument.
        setting: String,
        /// Setting that it lacks.
        part: &'static str,
    },
    /// An unknown key.
    #[error("`{0}` is not a key of a study")]
    UnknownKey(String),
    /// A word that is not one of a key's words.
    #[error("`{key}` is {value}, which is not one of its values")]
    UnknownWord {
        /// Full path.
        key: String,
        /// The word.
        value: String,
    },
    /// A key without which there is no study.
    #[error("`{key}` is missing{allowed}")]
    Missing {
        /// Full path.
        key: String,
        /// Its range, where it is a number.
        allowed: String,
    },
    /// An entry that a list does not have.
    #[error("`{key}` has {}, not `{index}`", entries_of(*entries))]
    NoEntry {
        /// Full path of the list.
        key: String,
        /// Index as it was written.
        index: String,
        /// Entries of the list.
        entries: usize,
    },
    /// A value of another type, a number out of its bounds, or one that does not fit the others.
    #[error("`{key}` is {value}, allowed is {allowed}")]
    NotAllowed {
        /// Full path.
        key: String,
        /// The value.
        value: String,
        /// Allowed values.
        allowed: String,
    },
    /// Fault of a file that a study names, its name included, or with a text of its own kind.
    #[error("{0}")]
    File(String),
    /// A path of `study.drop` that is not there.
    #[error("`study.drop` names `{0}`, which is not inherited")]
    NothingToDrop(String),
    /// Studies that derive from one another.
    #[error(
        "`{key}` = \"{name}\" makes a study derive from itself, or a chain of more than {limit}"
    )]
    BaseChain {
        /// `study.base`.
        key: &'static str,
        /// The base.
        name: String,
        /// Longest chain.
        limit: usize,
    },
    /// A fleet of several groups, where one study is asked for: their names.
    #[error("the study is a fleet of groups ({0}), and the question is of one study")]
    SeveralGroups(String),
    /// Tables within tables without end.
    #[error("tables are nested more than {0} deep")]
    TooDeep(usize),
}

impl Fault {
    pub(super) fn new(cause: Cause) -> Box<Self> {
        Box::new(Self { cause, place: None, help: None, note: None })
    }

    /// Fault of a value that may not be there.
    pub(super) fn not_allowed(
        key: impl Into<String>,
        value: impl Into<String>,
        allowed: impl Into<String>,
    ) -> Box<Self> {
        let (key, value, allowed) = (key.into(), value.into(), allowed.into());
        Self::new(Cause::NotAllowed { key, value, allowed })
    }

    pub(super) fn at(mut self: Box<Self>, place: Option<&Place>) -> Box<Self> {
        self.place = place.cloned();
        self
    }

    pub(super) fn help(mut self: Box<Self>, help: impl Into<String>) -> Box<Self> {
        self.help = Some(help.into());
        self
    }

    /// Adds the nearest of `names` as a help, or all of them.
    pub(super) fn suggest<S: AsRef<str>>(self: Box<Self>, wrong: &str, names: &[S]) -> Box<Self> {
        let listed = listed(names);
        match nearest(wrong, names) {
            Some(name) => self.help(format!("did you mean `{name}`? There are: {listed}")),
            None if names.is_empty() => self,
            None => self.help(format!("there are: {listed}")),
        }
    }

    /// Message of the fault, on one line that is safe to print.
    pub fn message(&self) -> String {
        cut(&self.cause.to_string(), SHOWN_MESSAGE)
    }

    /// The full path of the key that is wrong.
    pub fn key(&self) -> Option<&str> {
        match &self.cause {
            Cause::UnknownKey(key)
            | Cause::UnknownWord { key, .. }
            | Cause::Missing { key, .. }
            | Cause::NoEntry { key, .. }
            | Cause::NotAllowed { key, .. }
            | Cause::FileRefused(key)
            | Cause::FileOutside(key) => Some(key),
            Cause::BaseChain { key, .. } => Some(key),
            Cause::NothingToDrop(_) => Some("study.drop"),
            _ => None,
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if let Some(place) = &self.place {
            let (line, at, marked) = place.excerpt();
            let number = place.line().to_string();
            let gutter = " ".repeat(number.len());
            writeln!(f, "{}: {}", place.label(), self.message())?;
            writeln!(f, "  {number} | {line}")?;
            write!(f, "  {gutter} | {}{}", " ".repeat(at), "^".repeat(marked))?;
        } else {
            f.write_str(&self.message())?;
        }
        for (title, text) in [("help", &self.help), ("note", &self.note)] {
            if let Some(text) = text {
                write!(f, "\n  {title}: {}", cut(text, SHOWN_MESSAGE))?;
            }
        }
        Ok(())
    }
}

impl fmt::Display for StudyFileError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        for (k, fault) in self.faults.iter().take(SHOWN_FAULTS).enumerate() {
            if k > 0 {
                write!(f, "\n\n")?;
            }
            write!(f, "{fault}")?;
        }
        match self.faults.len().saturating_sub(SHOWN_FAULTS) {
            0 => Ok(()),
            more => write!(f, "\n\nand {more} more"),
        }
    }
}

impl std::error::Error for StudyFileError {}
impl std::error::Error for Fault {}

impl From<Box<Fault>> for StudyFileError {
    fn from(fault: Box<Fault>) -> Self {
        Self { faults: vec![*fault] }
    }
}

/// How many entries a list has, and which indices lead to them.
fn entries_of(entries: usize) -> String {
    match entries {
        0 => "no entries, allowed is a whole list".to_owned(),
        1 => "1 entry, allowed is the index 0".to_owned(),
        n => format!("{n} entries, allowed is an index of 0 to {}", n - 1),
    }
}

/// Remedy for a decimal comma.
pub(super) const DECIMAL_POINT: &str = "numbers take a decimal point: 2.5, not 2,5";

/// Remedy for a number with its unit behind it.
pub(super) const NO_UNIT: &str =
    "numbers stand without their unit, in which the key ends: 250, not 250m";

/// Likeness from which on a name is one with a typing error.
const TYPING_ERROR: f64 = 0.75;

/// Names that other people have for keys.
const OTHER_NAMES: [(&str, &str); 12] = [
    ("cd", "drag_area_m2"),
    ("cda", "drag_area_m2"),
    ("cdxa", "drag_area_m2"),
    ("crr", "rolling_factor"),
    ("rrc", "rolling_factor"),
    ("weight", "curb_mass_kg"),
    ("tare", "curb_mass_kg"),
    ("load", "payload_kg"),
    ("cargo", "payload_kg"),
    ("distance", "length_m"),
    ("range", "length_m"),
    ("diesel", "fuel_per_l"),
];

/// The name that was probably meant.
pub fn nearest<'a, S: AsRef<str>>(wrong: &str, names: &'a [S]) -> Option<&'a str> {
    // a comparison is quadratic in the length, and no name is long
    let wrong: String = wrong.chars().take(64).collect();
    let likeness = |name: &str| strsim::normalized_damerau_levenshtein(&wrong, name);
    let likely = names.iter().map(|name| (likeness(name.as_ref()), name.as_ref()));
    let (likeness, likeliest) = likely.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let units = ["_kg", "_t", "_m", "_km", "_m2", "_kw", "_kmh"];
    let stem = units.iter().find_map(|unit| wrong.strip_suffix(unit)).unwrap_or(&wrong);
    let other = OTHER_NAMES.iter().find(|(other, _)| *other == stem);
    let other = other.and_then(|(_, name)| names.iter().find(|known| known.as_ref() == *name));
    // `mass` is part of `curb_mass_kg`, and more like `class`
    let is_part = |name: &&S| name.as_ref().split('_').any(|word| word == stem);
    let part = other.or_else(|| names.iter().find(is_part)).map(AsRef::as_ref);
    let part = part.filter(|_| likeness < TYPING_ERROR);
    part.or_else(|| (likeness >= 0.5).then_some(likeliest))
}

fn listed<S: AsRef<str>>(names: &[S]) -> String {
    let shown: Vec<String> = names
        .iter()
        .take(SHOWN_NAMES)
        .map(|name| format!("`{}`", cut(name.as_ref(), 60)))
        .collect();
    let more = if names.len() > SHOWN_NAMES { ", …" } else { "" };
    format!("{}{more}", shown.join(", "))
}

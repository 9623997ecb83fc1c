//! Between which values the judged numbers of a study plausibly lie: the tables `[judged.NAME]` of
//! a study file, and of a vehicle's file.
//!
//! An entry has a `reason`, and for each of its keys `[low, judged, high]`: numbers, lists or laws
//! as the key takes them. The keys of an entry move together. Where the value of the study is
//! another one than what was judged, it has been typed or written by a fit: it is no longer judged,
//! and its key is left out. `judged.effects_of` names the built-in study whose stored effects hold.
//! The tables say nothing of a trip: they are no part of the study's hash.

use super::LoadedStudy;
use super::error::{Fault, StudyFileError};
use super::node::{Content, Node};
use super::source::SourceKind;
use ocmc_core::study::tree::Step;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value, json};

/// Judged numbers that move together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JudgedNumbers {
    /// Name of the entry.
    pub name: String,
    /// Why they lie within their ranges.
    pub reason: String,
    /// The numbers.
    pub keys: Vec<JudgedKey>,
}

/// One judged number, list of numbers or law.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JudgedKey {
    /// Path of the key.
    pub path: String,
    /// At one end of the plausible range.
    pub low: Value,
    /// The value that was judged: that of the study.
    pub judged: Value,
    /// At the other end.
    pub high: Value,
}

/// Commands that fit keys to data, by the beginning of their paths; the first that fits.
const FITS: [(&str, Option<&str>); 16] = [
    ("mission.length_m", Some(ROADS)),
    ("mission.payload_kg", Some(ROADS)),
    ("mission.departure", Some(ROADS)),
    ("mission.stops", Some(ROADS)),
    ("road.types.urban.wind_exposure", None),
    ("road.types.rural.wind_exposure", None),
    ("road.types.motorway.wind_exposure", None),
    ("road.event", None),
    ("road.", Some(ROADS)),
    ("traffic.", Some("ocmc fit traffic")),
    ("weather.", Some("ocmc fit weather")),
    ("driver.curve_speed.", Some("ocmc fit curve-speed")),
    ("driver.speed_change.launch", None),
    ("driver.speed_change.peak", None),
    ("driver.speed_change.", Some("ocmc fit speed-change")),
    ("driver.pedals.pid", Some("ocmc identify")),
];
const ROADS: &str = "ocmc fit operating-cycle";

impl JudgedNumbers {
    /// The command whose data would replace them; none where they have to be typed.
    pub fn replaced_by(&self) -> Option<&'static str> {
        let path = &self.keys.first()?.path;
        FITS.iter().find(|(start, _)| path.starts_with(start))?.1
    }
}

/// An end of a plausible range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The first value of an entry, which is the lower one where the key takes a number.
    Low,
    /// The last one.
    High,
}

impl LoadedStudy {
    /// The study with numbers of one of its entries at an end of their ranges.
    ///
    /// # Errors
    /// Where the rest of the study does not go with them.
    pub fn at_end(&self, numbers: &JudgedNumbers, end: End) -> Result<Self, StudyFileError> {
        let ends = numbers.keys.iter().map(|key| match end {
            End::Low => (key.path.clone(), key.low.clone()),
            End::High => (key.path.clone(), key.high.clone()),
        });
        self.with_values(ends)
    }

    /// The resolved study with its ranges of judged numbers, as a dictionary that loads to both.
    pub fn with_ranges(&self) -> Value {
        let mut study = self.model.to_tree();
        let of_vehicle =
            |numbers: &&JudgedNumbers| numbers.keys.iter().all(|key| key.path.starts_with(VEHICLE));
        let (vehicle, own): (Vec<_>, Vec<_>) = self.judged().iter().partition(of_vehicle);
        study[TABLE] = tables(&own, "", self.judged.study.as_deref());
        study["vehicle"][TABLE] = tables(&vehicle, VEHICLE, self.judged.vehicle.as_deref());
        study
    }
}

/// The tables of entries, their paths without what stands before them.
fn tables(entries: &[&JudgedNumbers], before: &str, effects_of: Option<&str>) -> Value {
    let entry = |numbers: &&JudgedNumbers| {
        let range = |key: &JudgedKey| {
            let path = key.path.strip_prefix(before).unwrap_or(&key.path);
            (path.to_owned(), json!([key.low, key.judged, key.high]))
        };
        let reason = ("reason".to_owned(), Value::from(numbers.reason.as_str()));
        let table = numbers.keys.iter().map(range).chain([reason]);
        (numbers.name.clone(), Value::Object(table.collect()))
    };
    let effects_of = effects_of.map(|name| (EFFECTS_OF.to_owned(), Value::from(name)));
    Value::Object(entries.iter().map(entry).chain(effects_of).collect())
}

/// Before the paths of a vehicle's keys.
const VEHICLE: &str = "vehicle.";

/// A number that was judged, and that another one has replaced.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ReplacedNumber {
    /// Path of the key.
    pub key: String,
    /// Entry that it was of.
    pub name: String,
    /// Where the other one is from: `typed in --set`, or `fitted from 203 rows of a file`.
    pub standing: String,
}

pub(super) const TABLE: &str = "judged";
/// The built-in study, or vehicle, whose stored effects hold ([`super::judged_effect`]).
const EFFECTS_OF: &str = "effects_of";
/// Table of the fits that have written into a study file.
pub(super) const FITTED: &str = "fitted";
/// In the table of a fit that is not all of its file: what it was made from, and the keys.
pub(super) const FITTED_FROM: &str = "from";
pub(super) const FITTED_KEYS: &str = "keys";
/// The command whose numbers are calibrated: many together, and none of them alone.
const CALIBRATED: &str = "calibrate totals";
const ALLOWED: &str = "a `reason`, and for each key `[low, judged, high]`";

/// Judged numbers of a study and its vehicle.
#[derive(Clone, Debug)]
pub(super) struct Judged {
    pub(super) numbers: Vec<JudgedNumbers>,
    pub(super) replaced: Vec<ReplacedNumber>,
    /// The built-in study whose stored effects hold.
    pub(super) study: Option<String>,
    /// The built-in vehicle with which they hold.
    pub(super) vehicle: Option<String>,
}

/// Takes the tables out of a tree whose bases are resolved; those of the vehicle last.
pub(super) fn take(tree: &mut Node) -> Result<Judged, Box<Fault>> {
    let of_study = taken(tree);
    let of_vehicle = tree.get_mut("vehicle").and_then(taken);
    let (numbers, replaced) = (Vec::new(), Vec::new());
    let mut judged = Judged { numbers, replaced, study: None, vehicle: None };
    let fits = of_study.as_ref().and_then(|tables| tables.get(FITTED)).cloned();
    for (tables, before) in [(of_study, ""), (of_vehicle, VEHICLE)] {
        let Some(tables) = tables else { continue };
        let Content::Table(tables) = &tables.content else { return Err(wrong(&tables, TABLE)) };
        for (name, entry) in tables {
            match entry.as_str().filter(|_| name == EFFECTS_OF) {
                Some(study) if before.is_empty() => judged.study = Some(study.to_owned()),
                Some(vehicle) => judged.vehicle = Some(vehicle.to_owned()),
                None if name == FITTED => {}
                None => {
                    let (judged_still, replaced) = numbers_of(tree, name, entry, before)?;
                    judged.numbers.extend(judged_still);
                    let standing = |(key, value): (String, &Node)| ReplacedNumber {
                        name: name.clone(),
                        standing: standing(&key, value, fits.as_ref()),
                        key,
                    };
                    judged.replaced.extend(replaced.into_iter().map(standing));
                }
            }
        }
    }
    Ok(judged)
}

fn taken(node: &mut Node) -> Option<Node> {
    node.entries_mut()?.remove(TABLE)
}

fn wrong(node: &Node, key: &str) -> Box<Fault> {
    Fault::not_allowed(key, node.shown(), ALLOWED).at(node.any_place())
}

/// Where a number is from that has replaced a judged one. A fit that names its keys has written
/// those and what is below them; another one all of its file.
fn standing(key: &str, value: &Node, fits: Option<&Node>) -> String {
    let Some(place) = value.any_place() else { return "typed".to_owned() };
    let source = &place.source;
    let is_of_it = |from: &Node| from.any_place().is_some_and(|place| place.source == *source);
    let fits = fits.into_iter().flat_map(Node::children);
    let fits: Vec<_> = fits.into_iter().filter(|(_, from)| is_of_it(from)).collect();
    let is_below =
        |path: &str| key == path || key.strip_prefix(path).is_some_and(|k| k.starts_with('.'));
    let names = |from: &Node| {
        let keys = from.get(FITTED_KEYS).map(Node::to_json);
        let keys = keys.as_ref().and_then(Value::as_array).into_iter().flatten();
        keys.filter_map(Value::as_str).any(is_below)
    };
    let by_name = fits.iter().find(|(_, from)| names(from));
    let by_fit = by_name.or_else(|| fits.iter().find(|(_, from)| from.as_str().is_some()));
    let words = by_fit.and_then(|(command, from)| {
        let is_calibrated = matches!(command, Step::Key(name) if name == CALIBRATED);
        let how = if is_calibrated { "calibrated on" } else { "fitted from" };
        let from = from.as_str().or_else(|| from.get(FITTED_FROM)?.as_str())?;
        Some(format!("{how} {from}"))
    });
    match (source.kind, words) {
        (SourceKind::Setting, _) => "typed in --set".to_owned(),
        (_, Some(words)) => words,
        (SourceKind::File, None) => format!("typed in {}", source.name),
        (SourceKind::BuiltIn, None) => format!("of the built-in {}", source.name),
    }
}

/// A key whose value is another one than was judged, and that value.
type Replaced<'a> = (String, &'a Node);

/// An entry, without the keys whose value is another one; none where that leaves nothing. And these
/// keys.
fn numbers_of<'a>(
    tree: &'a Node,
    name: &str,
    entry: &Node,
    before: &str,
) -> Result<(Option<JudgedNumbers>, Vec<Replaced<'a>>), Box<Fault>> {
    let place = format!("{before}{TABLE}.{name}");
    let Content::Table(keys) = &entry.content else { return Err(wrong(entry, &place)) };
    let mut numbers =
        JudgedNumbers { name: name.to_owned(), reason: String::new(), keys: Vec::new() };
    let mut replaced = Vec::new();
    for (key, value) in keys {
        if let (true, Some(reason)) = (key == "reason", value.as_str()) {
            reason.clone_into(&mut numbers.reason);
            continue;
        }
        let Value::Array(values) = value.to_json() else { return Err(wrong(value, &place)) };
        let Ok([low, judged, high]) = <[Value; 3]>::try_from(values) else {
            return Err(wrong(value, &place));
        };
        let path = format!("{before}{key}");
        match tree_value(tree, &path) {
            Some(value) if same(&value.to_json(), &judged) => {
                numbers.keys.push(JudgedKey { path, low, judged, high });
            }
            Some(value) => replaced.push((path, value)),
            None => {}
        }
    }
    if numbers.reason.is_empty() {
        return Err(wrong(entry, &place));
    }
    Ok(((!numbers.keys.is_empty()).then_some(numbers), replaced))
}

fn tree_value<'a>(tree: &'a Node, path: &str) -> Option<&'a Node> {
    let step = |name: &str| match name.parse() {
        Ok(index) => Step::Index(index),
        Err(_) => Step::Key(name.to_owned()),
    };
    let (node, is_there) = tree.follow(&path.split('.').map(step).collect::<Vec<_>>());
    is_there.then_some(node)
}

/// Whether two values are the same, however their numbers are written.
fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => a.as_f64() == b.as_f64(),
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b))
        }
        (Value::Object(a), Value::Object(b)) => {
            let in_b = |(name, a): (&String, &Value)| b.get(name).is_some_and(|b| same(a, b));
            a.len() == b.len() && a.iter().all(in_b)
        }
        _ => a == b,
    }
}

#[cfg(test)]
mod tests {
    use super::End;
    use crate::study::builtin::STUDIES;
    use crate::study::{LoadedStudy, load, load_json, load_text};

    const NO_SETS: &[&str] = &[];

    #[test]
    fn both_ends_of_every_entry_make_a_study() {
        let both_ends = |study: &str| {
            let own = load(study, NO_SETS).unwrap_or_else(|e| panic!("{study}: {e}"));
            for numbers in own.judged() {
                for end in [End::Low, End::High] {
                    let (name, moved) = (&numbers.name, own.at_end(numbers, end));
                    assert!(moved.is_ok(), "{study} {name} {end:?}: {}", moved.unwrap_err());
                }
            }
        };
        std::thread::scope(|scope| {
            for study in STUDIES {
                scope.spawn(|| both_ends(study.name));
            }
        });
    }

    #[test]
    fn a_study_travels_with_its_ranges() {
        for study in STUDIES {
            let own = load(study.name, &["mission.length_m=4000"]).unwrap();
            let again = load_json(&own.with_ranges(), NO_SETS).unwrap();
            assert_eq!(again.model, own.model, "{}", study.name);
            let sorted = |study: &LoadedStudy| {
                let mut entries = study.judged().to_vec();
                entries.sort_by(|a, b| (&a.name, &a.keys[0].path).cmp(&(&b.name, &b.keys[0].path)));
                entries
            };
            assert_eq!(sorted(&again), sorted(&own), "{}", study.name);
            assert_eq!(again.judged_doubt(), own.judged_doubt(), "{}", study.name);
        }
    }

    #[test]
    fn what_is_typed_is_no_longer_judged() {
        let keys = |sets: &[&str]| {
            let own = load("field-truck", sets).unwrap();
            own.judged().iter().map(|numbers| numbers.keys.len()).sum::<usize>()
        };
        let all = keys(NO_SETS);
        assert!(all > 150, "{all}");
        assert_eq!(keys(&["mission.length_m=80000"]), all - 1);
        let own = load("field-truck", &["mission.length_m=80000"]).unwrap();
        let replaced = own.replaced();
        assert_eq!((replaced.len(), &*replaced[0].standing), (1, "typed in --set"));
        assert_eq!((&*replaced[0].key, &*replaced[0].name), ("mission.length_m", "trip_length"));
        // the same number, written otherwise
        assert_eq!(keys(&["mission.length_m=100000"]), all);
        let other = "study.name = \"a\"\nstudy.description = \"b\"\nstudy.base = \"field-truck\"\n\
                     judged.trip_length.\"mission.length_m\" = 3\n";
        let error = load_text("a.toml", other, NO_SETS).unwrap_err().to_string();
        assert!(error.contains("[low, judged, high]"), "{error}");
    }
}
